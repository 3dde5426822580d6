"""A trial of the compiled driver before its first flight: two nodes on a cable, flown by both drivers of IDA.

The compiled driver writes into the objects of a C library. Where that library is laid out otherwise than expected, what
comes out is wrong rather than refused: it is trusted when it agrees with scikit-sundae's own way through the library.
What has agreed once is noted beside the compiled kernels, for just this library and this source.
"""

from __future__ import annotations

import contextlib
import hashlib
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from netdae._arrays import FloatArray
from netdae.damping import Dashpot
from netdae.errors import RunError
from netdae.forces.law import version_of
from netdae.ida.sundials import Unavailable, library_path
from netdae.material import Material
from netdae.net import CableNet
from netdae.options import SolverOptions
from netdae.restraints import Drive
from netdae.stepper import Stepper
from netdae.system import System

END = 0.02  # s: a fifth of a period of the two nodes on their cable
AGREES = 1e-6  # of both drivers, m and m/s; each keeps 1e-9 of its error test over some hundred steps


Driver = Callable[[System, Drive, SolverOptions], Stepper]


def check_agreement(compiled: Driver, python: Driver) -> None:
    """Raise Unavailable where the compiled driver does not do as the one from Python does."""
    note = _note()
    if note.exists():
        return
    found = difference(compiled, python)
    if not found <= AGREES:
        raise Unavailable(f"both drivers of IDA differ by {found:.3g} on two nodes, more than {AGREES:g}")
    with contextlib.suppress(OSError):  # a folder that is not ours is tried again next time
        note.parent.mkdir(exist_ok=True)
        note.touch()


def difference(compiled: Driver, python: Driver) -> float:
    """Largest difference of both drivers in position and velocity, m and m/s; infinite where one fails."""
    system = _two_nodes()
    options = SolverOptions(rtol=1e-9, atol_position=1e-10, atol_velocity=1e-9)
    drive = system.drive_from(system.net.nodes)
    try:
        one, other = (_flown(made(system, drive, options), system) for made in (compiled, python))
    except RunError:
        return math.inf
    return float(np.abs(one - other).max())


def _two_nodes() -> System:
    nodes, groups = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), {"ends": np.arange(2)}
    net = CableNet(nodes, np.array([[0, 1]]), groups, rest_length=np.array([0.99]))
    cord = Material(youngs_modulus=1e6, density=1000.0, diameter=1e-2)
    return System(net, cord, masses={"ends": 0.2}, damping=Dashpot(viscosity_time=1e-3))


def _flown(solver: Stepper, system: System) -> FloatArray:
    x = system.net.nodes
    v = np.array([[0.0, 0.0, 0.0], [0.5, 0.3, 0.0]])
    part = system.during(0.0, END)
    solver.enter(part, 0.0, np.stack((x, v)), np.stack((v, part.acceleration(0.0, x, v))))
    solver.go_on(part)
    t = 0.0
    while t < END:
        *_, last = solver.step(END)
        t = last.t
    return last.y


def _note() -> Path:
    """The file that says that they agree."""
    path = library_path()
    library = path.stat()
    told = f"{path} {library.st_size} {library.st_mtime_ns} {version_of('netdae.ida.native')}"
    name = hashlib.sha256(told.encode()).hexdigest()[:16]
    return Path(__file__).parent / "__pycache__" / f"ida-agrees-{name}"
