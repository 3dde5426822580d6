"""Free masses about a circular orbit: ẍ = 3n²x + 2nẏ, ÿ = −2nẋ, z̈ = −n²z, x outward, y along the track.

The solution is x = (4 − 3c) x₀ + s/n u + 2/n (1 − c) v and so on, with s, c = sin, cos nt: one revolution, on a way of
0.6 km. The error of IDA falls with its tolerance.
"""

from __future__ import annotations

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.forces.orbit import Orbit
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.runs.verification.case import Case, Check, Curve, Picture, Refinement, Setting, Study
from netdae.runs.verification.cases.long_tether import CLOHESSY, n
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import NoDamping
from netdae.system.system import System

X0 = np.array([[10.0, -20.0, 5.0], [-30.0, 0.0, 8.0]])
V0 = np.array([[0.01, -0.02, 0.005], [-0.02, 0.03, 0.01]])
REVOLUTION = 2 * np.pi / n


def closed_form(n: float, t: float, x0: FloatArray, v0: FloatArray) -> FloatArray:
    """Positions (k, 3) at t of free masses from x0, v0 (k, 3)."""
    s, c = np.sin(n * t), np.cos(n * t)
    (x, y, z), (u, v, w) = x0.T, v0.T
    return np.stack(
        (
            (4 - 3 * c) * x + s / n * u + 2 / n * (1 - c) * v,
            6 * (s - n * t) * x + y - 2 / n * (1 - c) * u + (4 * s - 3 * n * t) / n * v,
            c * z + s / n * w,
        ),
        axis=1,
    )


def fly(setting: Setting) -> Study:
    """Two masses whose cable is far longer than their way, for one revolution."""
    net = CableNet(X0, np.array([[0, 1]]), rest_length=np.array([1e5]))
    cord = Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)
    system = System(net, cord, damping=NoDamping(), loads=[Orbit(n)])
    times = np.linspace(0.0, REVOLUTION, 25)
    flight = simulate(system, State.at(X0, V0), times, options=_options(setting))
    expected = np.array([closed_form(n, t, X0, V0) for t in times])
    # some hundred steps of rtol of the way each; the preset keeps the tolerances of a 1 s flight
    within = max(1e3 * setting.rtol * 600.0, 1e-3) if setting.rtol else 0.6
    return Study(
        (
            Check.of(
                "positions of free masses",
                "m",
                flight.positions,
                expected,
                within=within,
                reason="1000 tolerances of the 0.6 km way, for some hundred steps; explicit a thousandth of the way",
            ),
        ),
        Picture(
            "along the track, m",
            "outward, m",
            tuple(Curve(f"closed form, mass {k + 1}", *expected[:, k, [1, 0]].T) for k in (0, 1)),
            tuple(Curve(f"netdae, mass {k + 1}", *flight.positions[:, k, [1, 0]].T) for k in (0, 1)),
        ),
    )


def _options(setting: Setting) -> SolverOptions:
    if setting.method == "explicit":
        return setting.options()
    r = setting.rtol
    return SolverOptions(rtol=r, atol_position=10 * r, atol_velocity=0.1 * r)


TOLERANCES = (1e-4, 1e-6, 1e-8)
CASE = Case(
    name="clohessy-wiltshire",
    title="Free masses in the frame of an orbit",
    statement="Free masses fly the closed form of Clohessy and Wiltshire, and IDA's error follows its tolerance.",
    sources=(CLOHESSY,),
    fly=fly,
    settings=(Setting("ida", rtol=1e-6), Setting("ida", rtol=1e-8), Setting("explicit", max_step=1.0)),
    quick=(Setting("ida", rtol=1e-8), Setting("explicit", max_step=1.0)),
    refinements=(
        Refinement(
            "rtol",
            TOLERANCES,
            tuple(Setting("ida", rtol=each) for each in TOLERANCES),
            "positions of free masses",
            0.95,
            0.35,
            "order and step vary, so that the error follows the tolerance but roughly",
        ),
        Refinement(
            "step",
            (2.0, 1.0, 0.5),
            tuple(Setting("explicit", max_step=each) for each in (2.0, 1.0, 0.5)),
            "positions of free masses",
            2.0,
            0.15,
            "the velocity Verlet is of second order",
        ),
    ),
)
