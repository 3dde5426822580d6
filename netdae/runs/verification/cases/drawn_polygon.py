"""k free masses m on a ring cord that a drum winds in: all move radially, as one equation says.

With the length of the cord l = k √(4 R² sin²(π/k) + η²), η the size of a ring, wound in by s(t):
m R̈ = −(N/k) ∂l/∂R, N = EA E11 λ, λ = l/(L − s). The reference is SciPy's DOP853 on that equation.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from netdae.core.arrays import FloatArray
from netdae.forces.rings import Rings
from netdae.model.material import Material
from netdae.model.motions import FunctionMotion
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.runs.verification.case import Case, Check, Curve, Picture, Setting, Source, Study
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import NoDamping
from netdae.system.reels import Reel
from netdae.system.system import System

MASS, RADIUS, SPEED, START, SIZE, EA = 0.3, 2.0, 1.0, 0.5, 1e-2, 100.0  # kg, m, m/s, s, m, N


def winding(speed: float, t0: float = START) -> FunctionMotion:
    """s = v t²/(2 t0) up to t0, then at the speed v: no jump of the velocity."""
    return FunctionMotion(
        lambda t: [speed * (t * t / (2 * t0) if t < t0 else t - t0 / 2), 0, 0],
        lambda t: [speed * min(t / t0, 1.0), 0, 0],
        lambda t: [speed / t0 if t < t0 else 0.0, 0, 0],
    )


def polygon(k: int, radius: float) -> FloatArray:
    """Corners of a regular polygon, (k, 3), m."""
    angle = 2 * np.pi * np.arange(k) / k
    return radius * np.stack((np.cos(angle), np.sin(angle), np.zeros(k)), axis=1)


def fly(setting: Setting) -> Study:
    """Two seconds: the cord snaps taut, and the masses swing."""
    k = setting.mesh
    places = polygon(k, RADIUS)
    cables = np.stack((np.arange(k), np.roll(np.arange(k), -1)), axis=1)
    h = np.linalg.norm(places[cables[:, 1]] - places[cables[:, 0]], axis=1)
    nodes = np.concatenate((places, np.zeros((1, 3))))
    net = CableNet(nodes, cables, {"rings": np.arange(k), "drum": np.array([k])}, rest_length=h)
    motion = winding(SPEED)
    system = System(
        net,
        Material(youngs_modulus=1e6 * EA, linear_density=1e-9, area=1e-6),
        damping=NoDamping(),
        masses={"rings": MASS},
        reels=[Reel(k, np.arange(k), inertia=0.0, share=-1.0, rings=Rings(size=SIZE))],
        restraints=[Restraint("drum", axes="x", motion=motion)],
    )
    times = np.linspace(0.0, 2.0, 33)
    flight = simulate(system, State.at(nodes), times, options=_options(setting))
    side, L0 = 2 * np.sin(np.pi / k), h.sum()

    def rates(t: float, y: FloatArray) -> list[float]:
        R, v = y
        piece = np.hypot(side * R, SIZE)
        stretch = k * piece / (L0 - motion.at(t)[0][0])
        N = EA * max(0.5 * (stretch**2 - 1), 0.0) * stretch
        return [v, -N * side**2 * R / piece / MASS]

    truth = solve_ivp(
        rates, (0, 2), [RADIUS, 0.0], t_eval=times, method="DOP853", rtol=1e-12, atol=1e-13, max_step=1e-2
    )
    x, v = flight.positions[:, :k], flight.velocities[:, :k]
    out = x / np.linalg.norm(x, axis=2)[:, :, None]
    kept = np.array(
        [system.kinetic_energy(s.v) + system.elastic_energy(s.x) - s.balance.external_work for s in flight]
    )
    assert flight[-1].balance.external_work > 0.02  # that the drum has put in
    within = 3e-6 if setting.rtol else 2e-3
    reason = (
        "a relative tolerance of 1e-8 in each of some hundred steps of swings of a metre"
        if setting.rtol
        else "the explicit preset promises 1 mm, and the cord swings twice"
    )
    return Study(
        (
            Check.of(
                "radius of every mass",
                "m",
                np.linalg.norm(x, axis=2),
                np.broadcast_to(truth.y[0][:, None], (len(times), k)),
                within=within,
                reason=reason,
            ),
            Check.of(
                "radial speed of every mass",
                "m/s",
                np.sum(v * out, axis=2),
                np.broadcast_to(truth.y[1][:, None], (len(times), k)),
                within=5 * within,
                reason="five swings' rad/s of the same",
            ),
            Check.of(
                "way sideways, by speed",
                "m/s",
                np.cross(out, v),
                0.0,
                within=1e-9 if setting.rtol else 1e-6,
                reason="round-off, that the solver's corrections let grow",
            ),
            Check.of(
                "energy, less the drum's work",
                "J",
                kept,
                kept[0],
                within=1e-5 if setting.rtol else 5e-3,
                reason="the same tolerance, of a swing of a joule",
            ),
            Check.of(
                "momentum",
                "kg m/s",
                system.momentum(flight[-1].v),
                0.0,
                within=1e-10,
                reason="round-off: the forces of the cord have no resultant",
            ),
        ),
        Picture(
            "time, s",
            "radius, m",
            (Curve("one equation, DOP853", times, truth.y[0]),),
            (Curve(f"netdae, {k} rings", times, np.linalg.norm(x, axis=2)[:, 0]),),
        ),
    )


def _options(setting: Setting) -> SolverOptions:
    if setting.method == "explicit":
        return setting.options()
    return SolverOptions(rtol=setting.rtol, atol_position=1e-2 * setting.rtol, atol_velocity=setting.rtol)


CASE = Case(
    name="drawn-polygon",
    title="A closing cord drawn through rings",
    statement="Free masses on a ring cord that is wound in move as one equation of motion says, through its snap.",
    sources=(Source("Lagrange's equation of the radius, derived in the case"),),
    fly=fly,
    settings=(Setting("ida", 3, rtol=1e-8), Setting("ida", 8, rtol=1e-8), Setting("ida", 40, rtol=1e-8)),
    quick=(Setting("ida", 8, rtol=1e-8),),
)
