"""Atwood's machine over a pulley that rubs: a = g (m₁ − m₂ e^{μπ})/(m₁ + m₂ e^{μπ}), tensions m₁ (g − a), m₂ (g + a).

The cord turns by π at the ring, so their ratio is the capstan's e^{μπ}, as Euler and Eytelwein found.
"""

from __future__ import annotations

import math

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.forces.drawcord import DRAWCORD, tensions_of
from netdae.forces.elements import ElementForce
from netdae.forces.loads import Gravity
from netdae.forces.rings import Rings
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.runs.verification.case import Case, Check, Curve, Picture, Setting, Source, Study
from netdae.runs.verification.nets import G
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping
from netdae.system.pulleys import PulleyCord, with_pulleys
from netdae.system.system import System

EA, SIZE = 1e4, 1e-4  # N, m
M1, M2, V0, END = 2.0, 0.7, 0.5, 0.4  # kg, kg, m/s, s
ROPE = Material(youngs_modulus=1e10, density=0.0, area=1e-6, law="engineering")
SLACK = Material(youngs_modulus=1e6, density=0.0, area=1e-6)


def machine(
    places: list[list[float]],
    masses: dict[int, float],
    held: list[int],
    tension: float,
    *,
    friction: float = 0.0,
    creep: float = 1e-3,
    damping: Dashpot | NoDamping | None = None,
) -> tuple[System, State]:
    """A cord through nodes at `places` (k, 3), so long that it bears `tension`; a slack cable makes it a net."""
    x = np.array(places, dtype=float)
    groups = {f"n{k}": np.array([k]) for k in range(len(x))}
    net = CableNet(x, np.array([[0, 1]]), groups, rest_length=np.array([1e3]))
    h = np.hypot(np.linalg.norm(np.diff(x, axis=0), axis=1), SIZE)
    cord = PulleyCord(
        ROPE,
        nodes=tuple(range(len(x))),
        length=float(h.sum() / (1 + tension / EA)),
        rings=Rings(SIZE, friction, creep),
    )
    strung = with_pulleys(net, State.at(x), [cord])
    system = System(
        strung.net,
        {"all": SLACK, **strung.materials},
        damping=damping or NoDamping(),
        masses={f"n{k}": m for k, m in masses.items()},
        loads=[Gravity([0, 0, -G])],
        restraints=[*strung.restraints, Restraint(tuple(held))],
        reels=strung.reels,
    )
    return system, strung.start


def segments(system: System, state: State) -> FloatArray:
    """N_i of the one cord, N."""
    (force,) = (each for each in system.forces if getattr(each, "law", None) is DRAWCORD)
    assert isinstance(force, ElementForce)
    return np.asarray(tensions_of(force, state.x[force.nodes], state.v[force.nodes]))


def options(setting: Setting) -> SolverOptions:
    """Tolerances below the yield of the stiff cord."""
    if setting.method == "explicit":
        return setting.options()
    return SolverOptions(rtol=setting.rtol, atol_position=1e-9, atol_velocity=1e-8)


def fall(setting: Setting, friction: float) -> tuple[tuple[Check, ...], Curve, Curve]:
    """The machine with that friction: checks, and the way of theory and of netdae."""
    ratio = math.exp(friction * math.pi)
    a = G * (M1 - M2 * ratio) / (M1 + M2 * ratio)
    # one strain in all of the cord: its mean tension is that of its length
    mean = (M1 * (G - a) * 1.0 + M2 * (G + a) * 1.5) / 2.5
    # both sides hang beside each other, the ring between them turns the cord by π
    places = [[0.0, 0.0, -1.0], [0.0, 0.0, 0.0], [0.0, 0.0, -1.5]]
    system, start = machine(places, {0: M1, 2: M2}, [1], mean, friction=friction)
    v = np.zeros_like(start.x)
    v[0, 2], v[2, 2] = -V0, V0  # it slides from the start, much faster than it creeps
    times = np.linspace(0.0, END, 9)
    flight = simulate(system, State.at(start.x, v), times, options=options(setting))
    way = V0 * times + 0.5 * a * times**2
    pulls = segments(system, flight[-1])
    with_it = f"friction {friction:g}"
    checks = (
        Check.of(
            f"way of both masses, {with_it}",
            "m",
            flight.positions[-1][[0, 2], 2],
            [-1.0 - way[-1], -1.5 + way[-1]],
            within=5e-4 + 0.5e-3 * way[-1] if friction else 2e-5,
            reason="the ratio lacks 2e-3 μ of smoothing, a some 1e-3; the cord yields by 2.5 m · 2 N/EA, 5e-4 m",
        ),
        Check.of(
            f"ratio of the tensions, {with_it}",
            "1",
            pulls[0] / pulls[1],
            ratio,
            relative=5e-4 if friction else 1e-12,
            reason="the angle lacks 2e-3 of smoothing; without friction it is one tension",
        ),
        Check.of(
            f"tensions, {with_it}",
            "N",
            pulls,
            [M1 * (G - a), M2 * (G + a)],
            relative=5e-3 if friction else 2e-3,
            reason="the cord rings a little as its segments change",
        ),
    )
    fallen = -1.0 - flight.positions[:, 0, 2]
    return checks, Curve(f"theory, {with_it}", times, way), Curve(f"netdae, {with_it}", times, fallen)


def fly(setting: Setting) -> Study:
    """Without friction and with it."""
    without, theory, found = fall(setting, 0.0)
    rubbed, rubbed_theory, rubbed_found = fall(setting, 0.2)
    picture = Picture("time, s", "way of the heavy mass, m", (theory, rubbed_theory), (found, rubbed_found))
    return Study((*without, *rubbed), picture)


CASE = Case(
    name="atwood",
    title="Atwood's machine with the capstan's friction",
    statement="Two masses over a pulley fall as theory says; the ratio of the tensions is the capstan's, e to the μπ.",
    sources=(
        Source("G. Atwood, A Treatise on the Rectilinear Motion and Rotation of Bodies, Cambridge 1784"),
        Source("J. A. Eytelwein, Handbuch der Statik fester Körper, vol. 2, Berlin 1808: the capstan"),
    ),
    fly=fly,
    settings=(Setting("ida", rtol=1e-7), Setting("explicit")),
    quick=(Setting("ida", rtol=1e-7), Setting("explicit")),
)
