"""A tether in orbit swings about the radius as a pendulum: with √3 n in the orbit's plane and 2 n across it.

Two masses on a cord: in the plane θ̈ = −3 n² sin θ cos θ, and out of it φ̈ = −4 n² φ for small φ: the gravity gradient
gives 3 n², the orbit's rotation the one more.
"""

from __future__ import annotations

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.forces.orbit import Orbit
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.runs.verification.case import Case, Check, Curve, Picture, Setting, Source, Study
from netdae.solvers.flight import simulate
from netdae.system.damping import NoDamping
from netdae.system.system import System

n, SMALL, LENGTH = 0.05, 0.01, 100.0  # rad/s, rad, m
CORD = Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)


def vertical_tether(
    length: float, top: float, bottom: float, mean_motion: float
) -> tuple[System, State, float]:
    """Masses on a cord along x in equilibrium about the orbit, and the tension 3 n² m L by theory, N."""
    net = CableNet(
        np.array([[0.0, 0.0, 0.0], [length, 0.0, 0.0]]),
        np.array([[0, 1]]),
        {"bottom": np.array([0]), "top": np.array([1])},
    )
    masses = {"top": top, "bottom": bottom}
    system = System(net, CORD, damping=NoDamping(), masses=masses, loads=[Orbit(mean_motion)])
    m = float(system.mass.prod() / system.mass.sum())
    EA = float(system.cords.axial_stiffness[0])
    # EA E11 l/L̄ = 3 n² m l, so E11 = 3 n² m L̄/EA
    stretch = float(np.sqrt(1 + 2 * 3 * mean_motion**2 * m * length / EA))
    place = np.array([-system.mass[1], system.mass[0]]) / system.mass.sum()
    x = np.zeros((2, 3))
    x[:, 0] = place * stretch * length
    return system, State.at(x), 3 * mean_motion**2 * m * stretch * length


def swing(setting: Setting, axis: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times, angle and the cosine of theory over half a period; axis 1 is in the orbit's plane, 2 across it."""
    factor = np.sqrt(3) if axis == 1 else 2.0
    system, start, _ = vertical_tether(LENGTH, 1.0, 2.0, n)
    x = start.x.copy()
    x[:, axis], x[:, 0] = np.sin(SMALL) * start.x[:, 0], np.cos(SMALL) * start.x[:, 0]
    times = np.linspace(0.0, np.pi / (factor * n), 13)
    flight = simulate(system, State.at(x), times, options=setting.options())
    angle = np.array([np.arctan2(*(s.x[1] - s.x[0])[[axis, 0]]) for s in flight])
    return times, angle, SMALL * np.cos(factor * n * times)


def fly(setting: Setting) -> Study:
    """Half a period in each plane."""
    checks, curves = [], []
    for axis, name in ((1, "in the orbit's plane"), (2, "across it")):
        times, angle, expected = swing(setting, axis)
        checks.append(
            Check.of(
                f"libration {name}",
                "rad",
                angle,
                expected,
                within=1e-4 * SMALL,
                reason="of the swing: the pendulum's next order, θ²/16, moves the period by 1e-5",
            )
        )
        curves.append((Curve(f"theory, {name}", times, expected), Curve(f"netdae, {name}", times, angle)))
    return Study(
        tuple(checks),
        Picture("time, s", "angle, rad", *(tuple(pair) for pair in zip(*curves, strict=True))),
    )


CASE = Case(
    name="libration",
    title="Libration of a tether",
    statement="A tether in orbit librates with √3 n in the plane and 2 n across it.",
    sources=(
        Source(
            "V. V. Beletsky, E. M. Levin, Dynamics of Space Tether Systems, "
            "Advances in the Astronautical Sciences 83, Univelt 1993"
        ),
    ),
    fly=fly,
    settings=(Setting("ida", rtol=1e-8), Setting("explicit")),
    quick=(Setting("ida", rtol=1e-8), Setting("explicit")),
)
