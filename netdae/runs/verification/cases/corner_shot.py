"""A free net shot by the bullets at its corners: the flight that netdae is made for, by what holds of it exactly.

Until the cord of a bullet is taut it flies straight, x + u t. Nothing acts from outside: momentum stays what the shot
gave; kinetic and elastic energy and what the dashpots took keep their sum.
"""

from __future__ import annotations

import math

import numpy as np

from netdae.initial.scaled import ejected, scaled
from netdae.model.material import Material
from netdae.model.mouth import vector_area
from netdae.model.net import CableNet
from netdae.runs.verification.case import Case, Check, Curve, Picture, Setting, Source, Study
from netdae.solvers.flight import simulate
from netdae.system.damping import Dashpot
from netdae.system.system import System

SIDE, SHARE, SPEED, BULLET = 5.0, 0.4, 2.5, 0.5  # m, 1, m/s, kg
ENERGY = {"fast": 0.1, "standard": 0.01, "accurate": 1e-3}


def fly(setting: Setting) -> Study:
    """0.8 s: the net opens."""
    N = setting.mesh
    net, start = scaled(CableNet.square(side=SIDE, cells=N), (SHARE, SHARE, 1.0))
    start = ejected(net, start, "corners", speed=SPEED, half_angle_deg=45.0)
    cord = Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)
    system = System(net, cord, masses={"corners": BULLET}, damping=Dashpot(viscosity_time=1e-5))
    corners = net.nodes_of("corners")
    # a bullet at (s a, s a) from the next knots but one runs off with w along each side and h forward: its
    # cords are taut when (s a + w t)² + (w t)² + (h t)² = a²
    a, w, h = SIDE / N, SPEED * math.sin(math.pi / 4) / math.sqrt(2), SPEED * math.cos(math.pi / 4)
    square, line = 2 * w * w + h * h, SHARE * a * w
    taut = (math.sqrt(line**2 + square * (1 - SHARE**2) * a * a) - line) / square
    straight = np.linspace(0.0, 0.98, 8) * taut
    times = np.concatenate((straight, np.linspace(1.05 * taut, 0.8, 24)))
    flight = simulate(system, start, times, options=setting.options())
    kept = np.array([system.momentum(state.v) for state in flight])
    energies = np.array(
        [
            system.kinetic_energy(s.v) + system.elastic_energy(s.x) + s.balance.dissipated_energy
            for s in flight
        ]
    )
    share = ENERGY[setting.accuracy]
    forward = float(system.mass[corners].sum()) * h
    first = start.x[corners][:, None] + start.v[corners][:, None] * straight[:, None]
    expected = np.swapaxes(first, 0, 1)
    opened = np.array([np.linalg.norm(vector_area(x[[0, 1, 3, 2]])) for x in expected])
    corner_areas = np.array([np.linalg.norm(vector_area(x[corners][[0, 1, 3, 2]])) for x in flight.positions])
    return Study(
        (
            Check.of(
                "straight way of the bullets",
                "m",
                flight.positions[: len(straight), corners],
                expected,
                within=1e-9,
                reason="round-off and Newton's tolerance: no force acts",
            ),
            Check.of(
                "momentum",
                "kg m/s",
                kept,
                np.broadcast_to([0.0, 0.0, forward], kept.shape),
                relative=1e-11,
                reason="round-off: the forces of a cable are a pair",
            ),
            Check.of(
                "energy",
                "J",
                energies,
                energies[0],
                relative=share,
                reason="the share of the energy that the preset promises to account for",
            ),
        ),
        Picture(
            "time, s",
            "area between the bullets, m²",
            (Curve("straight flight", straight, opened),),
            (Curve("netdae", times, corner_areas),),
        ),
    )


CASE = Case(
    name="corner-shot",
    title="A net shot by its corners",
    statement="Bullets fly straight until their cords are taut; momentum stays, and the energy is accounted for.",
    sources=(Source("Newton's first law and the balances of momentum and energy, derived in the case"),),
    fly=fly,
    settings=(
        Setting("ida", 10, "standard"),
        Setting("ida", 10, "accurate"),
        Setting("explicit", 10, "standard"),
        Setting("explicit", 10, "accurate"),
    ),
    quick=(Setting("ida", 6, "standard"), Setting("explicit", 6, "standard")),
)
