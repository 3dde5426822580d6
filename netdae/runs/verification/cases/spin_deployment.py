"""A net drawn together to the share s of its size and spun with ω about its normal opens itself.

While its cords are slack every knot flies straight from r with ω × r: the net grows evenly, its size as
s √(1 + ω²t²), turned by atan ωt, until the cords are taut at √(1/s² − 1)/ω. Nothing acts from outside: angular
momentum is kept to the end, through spreading and rebound.
"""

from __future__ import annotations

import math

import numpy as np

from netdae.initial.scaled import scaled
from netdae.initial.spin import spun
from netdae.model.material import Material
from netdae.model.mouth import mouth_of, vector_area
from netdae.model.net import CableNet
from netdae.runs.verification.case import Case, Check, Curve, Picture, Setting, Source, Study
from netdae.solvers.flight import simulate
from netdae.system.damping import Dashpot
from netdae.system.system import System

SHARE, SPIN, SIDE, CELLS = 0.5, math.radians(240.0), 2.0, 4


def fly(setting: Setting) -> Study:
    """To twice the time in which the net spreads."""
    net, start = scaled(CableNet.square(side=SIDE, cells=CELLS), (SHARE, SHARE, 1.0))
    cord = Material(youngs_modulus=1e9, density=1140.0, diameter=1e-3)
    system = System(net, cord, masses={"corners": 0.1}, damping=Dashpot(viscosity_time=5e-4))
    start = spun(start, system.mass, [0.0, 0.0, math.degrees(SPIN)])
    spread = math.sqrt(1 / SHARE**2 - 1) / SPIN
    free = np.linspace(0.0, 0.99, 12) * spread
    times = np.concatenate((free, spread * np.linspace(1.05, 2.0, 20)))
    flight = simulate(system, start, times, options=setting.options())
    loop = mouth_of(net, "border")
    areas = np.array([np.linalg.norm(vector_area(x[loop])) for x in flight.positions])
    grown = (SIDE * SHARE) ** 2 * (1 + (SPIN * free) ** 2)
    corner = int(net.nodes_of("corners")[0])
    middle = system.mass @ start.x / system.mass.sum()
    arm = flight.positions[: len(free), corner] - middle
    turned = np.unwrap(np.arctan2(arm[:, 1], arm[:, 0]))
    momentum = np.array([system.angular_momentum(s.x, s.v)[2] for s in flight])
    size = 1e-3 if setting.method == "ida" else 1e-9
    why = "angular momentum is a quadratic invariant, which BDF keeps within its tolerance and the Verlet to round-off"
    return Study(
        (
            Check.of(
                "mouth while it opens",
                "m²",
                areas[: len(free)],
                grown,
                relative=1e-4,
                reason="straight flight: the preset's tolerance of position, of metres",
            ),
            Check.of(
                "angle while it opens",
                "rad",
                turned - turned[0],
                np.arctan(SPIN * free),
                within=1e-4,
                reason="straight flight: the preset's tolerance of position, of metres",
            ),
            Check.of("angular momentum", "kg m²/s", momentum, momentum[0], relative=size, reason=why),
            Check.of(
                "momentum",
                "kg m/s",
                system.momentum(flight[-1].v),
                0.0,
                within=1e-10,
                reason="round-off: the forces of a cable are a pair",
            ),
        ),
        Picture(
            "time, s",
            "mouth, m²",
            (Curve("straight flight", free, grown),),
            (Curve("netdae", times, areas),),
        ),
    )


CASE = Case(
    name="spin-deployment",
    title="Deployment by spinning",
    statement="A spun net opens as its knots fly straight, and keeps its angular momentum to the end.",
    sources=(Source("Free flight and Noether's theorem, derived in the case"),),
    fly=fly,
    settings=(Setting("ida", accuracy="accurate"), Setting("explicit", accuracy="accurate")),
    quick=(Setting("ida", accuracy="standard"), Setting("explicit", accuracy="standard")),
)
