"""SSNL114 of code_aster, V6.02.114: a cable as long as its span of 325 m, cold or hot; its lowest point.

The published values solve the catenary with N = EA (l/L̄ − 1), reported good to 1e-3 m. Eq. (4) is stiffer by 1.5 times
the strain of 1e-3; the sag of a flat cable goes as the cube root of its softness, so 5e-4.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.forces.loads import Gravity
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.runs.verification.case import Case, Check, Curve, Picture, Setting, Source, Study
from netdae.runs.verification.nets import G, line
from netdae.solvers.statics import equilibrium
from netdae.system.damping import NoDamping
from netdae.system.system import System

PUBLISHED = {1.0: -6.352, 1 + 2.3e-5 * 39.26: -8.195}  # stretch of the rest length: lowest point, m


def shape_of(cables: int, law: Literal["engineering", "st_venant_kirchhoff"], stretch: float) -> FloatArray:
    """Where the cable hangs, (cables + 1, 3), m."""
    net = line(cables, length=325.0)
    net = CableNet(net.nodes, net.cables, net.node_groups, rest_length=stretch * net.rest_length)
    cord = Material(youngs_modulus=5.70e10, density=2844.23, area=2.2783e-4, law=law)
    ends = [Restraint("first"), Restraint("last")]
    gravity = Gravity([0.0, 0.0, -G])
    system = System(net, cord, damping=NoDamping(), loads=[gravity], restraints=ends)
    return equilibrium(system, net.nodes).x


def fly(setting: Setting) -> Study:
    """Sags of both laws, cold and hot, extrapolated from two meshes."""
    N = setting.mesh
    sags: dict[str, list[float]] = {}
    for law in ("engineering", "st_venant_kirchhoff"):
        for stretch in PUBLISHED:
            coarse, fine = (shape_of(n, law, stretch)[n // 2, 2] for n in (N // 2, N))
            sags.setdefault(law, []).append((4 * fine - coarse) / 3)
    expected = [*PUBLISHED.values()]
    strain = 2844.23 * G * 325.0**2 / (8 * 6.352 * 5.70e10)
    shape = shape_of(N, "engineering", max(PUBLISHED))
    middle = np.array([162.5])
    return Study(
        (
            Check.of(
                "lowest point, engineering law",
                "m",
                sags["engineering"],
                expected,
                within=1e-3,
                reason="the reference is reported good to 1e-3 m",
            ),
            Check.of(
                "lowest point, St. Venant-Kirchhoff",
                "m",
                sags["st_venant_kirchhoff"],
                expected,
                within=1e-3 * 6.352,
                reason="its law is stiffer by 1.5 times the strain of 1e-3: a third of that in the sag",
            ),
            Check.of(
                "sag less by the stiffer law, cold",
                "m",
                sags["st_venant_kirchhoff"][0] - sags["engineering"][0],
                0.5 * strain * 6.352,
                relative=0.1,
                reason="a third of 1.5 times the strain w l²/(8 d EA); the parabola of it is good to some hundredths",
            ),
        ),
        Picture(
            "along the span, m",
            "height, m",
            (Curve("lowest point, published", middle, [min(PUBLISHED.values())]),),
            (Curve("netdae, hot", shape[:, 0], shape[:, 2]),),
        ),
    )


CASE = Case(
    name="heavy-cable",
    title="Cable under its own weight (code_aster SSNL114)",
    statement="A cable as long as its span sags as deep as code_aster's validation manual says, cold and hot.",
    sources=(
        Source(
            "code_aster validation manual, document V6.02.114: SSNL114, heavy cable with thermal expansion"
        ),
    ),
    fly=fly,
    settings=(Setting("statics", 80),),
    quick=(Setting("statics", 80),),
)
