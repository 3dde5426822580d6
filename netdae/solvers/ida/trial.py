"""A trial of the compiled driver before its first flight: two nodes on a cable, flown by IDA and by SciPy's DOP853.

The compiled driver writes into the objects of a C library. If that library's layout is not as expected, results are
wrong without an error. So the driver is trusted only once it agrees with a solver that shares no memory with it. An
agreement is recorded beside the compiled kernels, for exactly this library and this source.
"""

from __future__ import annotations

import contextlib
import hashlib
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from netdae.core.arrays import FloatArray
from netdae.core.errors import RunError
from netdae.forces.law import version_of
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.restraints import Drive
from netdae.solvers.ida.sundials import Unavailable, library_path
from netdae.solvers.options import SolverOptions
from netdae.solvers.stepper import Stepper
from netdae.system.damping import Dashpot
from netdae.system.system import System

END = 0.02  # s: a fifth of a period of the two nodes on their cable
AGREES = 1e-6  # m and m/s; IDA keeps 1e-9 in each of some hundred steps, DOP853 1e-12 in all

Driver = Callable[[System, Drive, SolverOptions], Stepper]


def check_agreement(driver: Driver) -> None:
    """Raise Unavailable where a driver of IDA does not reproduce SciPy's flight."""
    note = _note()
    if note.exists():
        return
    found = difference(driver)
    if not found <= AGREES:
        raise Unavailable(f"IDA differs from SciPy by {found:.3g} on two nodes, more than {AGREES:g}")
    with contextlib.suppress(OSError):  # a folder that cannot be written: the trial is repeated next time
        note.parent.mkdir(exist_ok=True)
        note.touch()


def difference(driver: Driver) -> float:
    """Largest difference from SciPy's flight in position and velocity, m and m/s; infinite where the driver fails."""
    system, y = _two_nodes()
    options = SolverOptions(rtol=1e-9, atol_position=1e-10, atol_velocity=1e-9)
    try:
        flown = _flown(driver(system, system.drive_from(y[0]), options), system, y)
    except RunError:
        return math.inf
    return float(np.abs(flown - _by_scipy(system, y)).max())


def _two_nodes() -> tuple[System, FloatArray]:
    """The system, and its start (x, v), (2, 2, 3)."""
    nodes, groups = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), {"ends": np.arange(2)}
    net = CableNet(nodes, np.array([[0, 1]]), groups, rest_length=np.array([0.99]))
    cord = Material(youngs_modulus=1e6, density=1000.0, diameter=1e-2)
    system = System(net, cord, masses={"ends": 0.2}, damping=Dashpot(viscosity_time=1e-3))
    return system, np.stack((nodes, [[0.0, 0.0, 0.0], [0.5, 0.3, 0.0]]))


def _flown(solver: Stepper, system: System, y: FloatArray) -> FloatArray:
    part = system.during(0.0, END)
    solver.enter(part, 0.0, y, _slope(system, y))
    solver.go_on(part)
    t = 0.0
    while t < END:
        *_, last = solver.step(END)
        t = last.t
    return last.y


def _by_scipy(system: System, y: FloatArray) -> FloatArray:
    """By DOP853: the cable stays taut, so a formula of eighth order meets no kink."""
    fun = lambda t, flat: _slope(system, flat.reshape(y.shape)).ravel()  # noqa: E731
    flight = solve_ivp(fun, (0.0, END), y.ravel(), method="DOP853", rtol=1e-12, atol=1e-14)
    return np.asarray(flight.y[:, -1]).reshape(y.shape)


def _slope(system: System, y: FloatArray) -> FloatArray:
    return np.stack((y[1], system.acceleration(0.0, y[0], y[1])))


def _note() -> Path:
    """The file that records the agreement."""
    path = library_path()
    library = path.stat()
    reported = f"{path} {library.st_size} {library.st_mtime_ns} {version_of('netdae.solvers.ida.native')}"
    name = hashlib.sha256(reported.encode()).hexdigest()[:16]
    return Path(__file__).parent / "__pycache__" / f"ida-agrees-{name}"
