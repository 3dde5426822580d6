"""A mass m on one cable L, EA is dropped 0.3 m below the anchor: slack fall, stretch, rebound, and again.

With Eqs. (3), (4) the cable stores ½ EA L E11², E11 = (l²/L² − 1)/2. The lowest length solves
½ EA L E11² = m g (l − drop); the fall to it takes √(2 (L − drop)/g) + ∫ dl/v, v² = 2 g (l − drop) − EA L E11²/m.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from netdae.forces.loads import Gravity
from netdae.model.material import Material
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.runs.verification.case import Case, Check, Curve, Picture, Setting, Source, Study
from netdae.runs.verification.nets import G, line
from netdae.solvers.flight import simulate
from netdae.system.damping import NoDamping
from netdae.system.system import System

EA, L, DROP = 60.0, 1.5, 0.3  # N, m, m


class Bungee:
    """System and reference: lowest length, m, and the times to it and to the first taut instant, s."""

    def __init__(self) -> None:
        cord = Material(youngs_modulus=1e6 * EA, area=1e-6, linear_density=1e-6)
        gravity, anchor = Gravity([0.0, 0.0, -G]), Restraint("first")
        self.system = System(
            line(1, length=L),
            cord,
            damping=NoDamping(),
            masses={"last": 1.0},
            loads=[gravity],
            restraints=[anchor],
        )
        self.start = State.at([[0.0, 0.0, 0.0], [0.0, 0.0, -DROP]])
        self.m = float(self.system.mass[1])  # with the half of the cable
        self.lowest = brentq(self.excess, L, 10 * L, xtol=1e-14)
        self.to_taut = math.sqrt(2 * (L - DROP) / G)
        stretch, _ = quad(self.pace, 0.0, math.sqrt(self.lowest - L), epsabs=1e-13)
        self.to_lowest = self.to_taut + stretch

    def pace(self, s: float) -> float:
        """dt/ds with l = lowest − s², which takes the root out of dt = dl/v at the lowest point."""
        left = -2 * self.excess(self.lowest - s * s) / self.m
        if s < 1e-4:  # where the difference of energies is round-off: its slope
            E11 = 0.5 * ((self.lowest / L) ** 2 - 1)
            left = 2 * s * s * (EA * E11 * self.lowest / L / self.m - G)
            return 2 / math.sqrt(left / s / s) if s > 0 else self.pace(1e-5)
        return 2 * s / math.sqrt(left)

    def excess(self, length: float) -> float:
        """Stored energy less the energy of the fall, J."""
        E11 = 0.5 * ((length / L) ** 2 - 1)
        return 0.5 * EA * L * E11**2 - self.m * G * (length - DROP)

    def length_at(self, t: float) -> float:
        """Length below the anchor at a time before the lowest point, m, by the same quadrature."""
        if t <= self.to_taut:
            return DROP + 0.5 * G * t * t

        def late(s: float) -> float:
            rest, _ = quad(self.pace, 0.0, s, epsabs=1e-12)
            return rest - (self.to_lowest - t)

        return self.lowest - brentq(late, 0.0, math.sqrt(self.lowest - L), xtol=1e-12) ** 2


def fly(setting: Setting) -> Study:
    """Two rebounds: places and times of the turns, and the accelerations there."""
    b = Bungee()
    turns = b.to_lowest * np.arange(1, 5)  # lowest, back at the start, lowest, back at the start
    way = b.to_lowest * np.linspace(0.0, 0.98, 15)
    flight = simulate(b.system, b.start, [*way, *turns], options=setting.options())
    z, v, a = (
        values[len(way) :, 1, 2] for values in (flight.positions, flight.velocities, flight.accelerations)
    )
    late = -v / a  # v is all but zero there: one step of Newton's finds where it is
    E11 = 0.5 * ((b.lowest / L) ** 2 - 1)
    pull = EA * E11 * b.lowest / L
    share = 1e-6 if setting.rtol else 2e-4
    reason = (
        "some thousand steps at a relative tolerance of 1e-10"
        if setting.rtol
        else "the preset promises 1 mm on such a way"
    )
    fallen = -flight.positions[: len(way), 1, 2]
    reference = [b.length_at(t) for t in way]
    return Study(
        (
            Check.of("times of the turns", "s", turns + late, turns, relative=share, reason=reason),
            Check.of(
                "heights of the turns",
                "m",
                z + 0.5 * v * late,
                [-b.lowest, -DROP] * 2,
                relative=share,
                reason=reason,
            ),
            Check.of(
                "accelerations of the first turns",
                "m/s²",
                a[:2],
                [pull / b.m - G, -G],
                relative=5 * share,
                reason="the pull rises with five times the share of the length",
            ),
        ),
        Picture(
            "time, s",
            "length below the anchor, m",
            (Curve("quadrature of the energy", way, reference),),
            (Curve("netdae", way, fallen),),
        ),
    )


CASE = Case(
    name="bungee",
    title="Bungee with the law of St. Venant and Kirchhoff",
    statement="A mass dropped on a slack cable turns where energy says and when a quadrature says, twice.",
    sources=(Source("Energy and quadrature with Eqs. (3), (4) of netdae's model, derived in the case"),),
    fly=fly,
    settings=(Setting("ida", rtol=1e-10), Setting("ida"), Setting("explicit", max_step=1e-3)),
    quick=(Setting("ida", rtol=1e-10), Setting("explicit", max_step=1e-3)),
)
