"""Masses m at the corners of a polygon that turns: each is held by 2 T sin(π/n) = m ω² r, so T = m ω² r/(2 sin(π/n)).

Twelve masses at a strain of 1e-3, without damping: the ring turns on, and neither tension nor energy changes.
"""

from __future__ import annotations

import numpy as np

from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.runs.verification.case import Case, Check, Curve, Picture, Setting, Source, Study
from netdae.solvers.driver import integrate
from netdae.system.damping import NoDamping
from netdae.system.system import System

N, EA, MASS, STRAIN = 12, 1e4, 0.1, 1e-3
BOUNDS = {"standard": (0.02, 0.01), "accurate": (0.01, 0.005)}


def fly(setting: Setting) -> Study:
    """Two seconds, some turns."""
    angle = 2 * np.pi * np.arange(N) / N
    nodes = np.stack((np.cos(angle), np.sin(angle), 0 * angle), axis=1)
    sides = np.stack((np.arange(N), np.roll(np.arange(N), -1)), axis=1)
    net = CableNet(nodes, sides, {"all": np.arange(N)})
    cord = Material(youngs_modulus=1e6 * EA, linear_density=1e-9, area=1e-6)
    system = System(net, cord, masses={"all": MASS}, damping=NoDamping())
    stretch = np.sqrt(1 + 2 * STRAIN)
    T = EA * STRAIN * stretch
    omega = np.sqrt(2 * T * np.sin(np.pi / N) / (MASS * stretch))
    x = stretch * nodes
    start = State.at(x, omega * np.stack((-x[:, 1], x[:, 0], 0 * angle), axis=1))
    times = np.linspace(0.0, 2.0, 41)
    peaks: list[float] = []
    states = list(
        integrate(
            system,
            start,
            times,
            options=setting.options(),
            watch=[lambda state: peaks.append(state.balance.peak_tension)],
        )
    )
    in_tension, in_energy = BOUNDS[setting.accuracy]
    tensions = np.array([system.tension(state.x) for state in states])
    energies = np.array([system.kinetic_energy(each.v) + system.elastic_energy(each.x) for each in states])
    turned = np.unwrap([np.arctan2(*state.x[0, [1, 0]]) for state in states])
    promised = "the share that the preset promises for taut undamped cables"
    return Study(
        (
            Check.of("tension in every side", "N", tensions, T, relative=in_tension, reason=promised),
            Check.of("peak tension of all steps", "N", max(peaks), T, relative=in_tension, reason=promised),
            Check.of("energy", "J", energies, energies[0], relative=in_energy, reason=promised),
            Check.of(
                "angle turned",
                "rad",
                turned[-1],
                omega * times[-1],
                relative=0.5 * in_energy,
                reason="the speed goes with the root of the energy",
            ),
        ),
        Picture(
            "time, s",
            "tension, N",
            (Curve("m ω² r/(2 sin(π/n))", times[[0, -1]], [T, T]),),
            (Curve("netdae, largest side", times, tensions.max(axis=1)),),
        ),
    )


CASE = Case(
    name="whirling-ring",
    title="Whirling ring",
    statement="A turning ring of masses keeps the tension that the centrifugal force asks for, without damping.",
    sources=(Source("Balance of each mass, derived in the case"),),
    fly=fly,
    settings=(
        Setting("ida", accuracy="standard"),
        Setting("ida", accuracy="accurate"),
        Setting("explicit", accuracy="standard"),
        Setting("explicit", accuracy="accurate"),
    ),
    quick=(Setting("ida", accuracy="standard"), Setting("explicit", accuracy="standard")),
)
