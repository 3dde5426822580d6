"""Irvine's elastic catenary: rest length S, weight w per rest length, hung over a span and a rise, N = EA (l/L̄ − 1).

With the pull H, V on the upper end and P = V − w (S − s): x(s) = H s/EA + H/w [asinh(P/H)], z(s) = P²/(2 EA w) +
√(H² + P²)/w, each less its value at s = 0. H and V follow from the place of the upper end.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.optimize import root

from netdae.core.arrays import FloatArray
from netdae.forces.loads import Gravity
from netdae.model.material import Material
from netdae.model.restraints import Restraint
from netdae.runs.verification.case import Case, Check, Curve, Picture, Refinement, Setting, Source, Study
from netdae.runs.verification.nets import G, line
from netdae.solvers.statics import equilibrium
from netdae.system.damping import NoDamping
from netdae.system.system import System

SPAN, RISE, S, EA, MU = 8.0, 1.5, 9.0, 400.0, 0.5  # m, m, m, N, kg/m
w = MU * G


def at(s: FloatArray | float, H: float, V: float) -> FloatArray:
    """x and z of the point s of rest length from the lower end, m; H, V the pull on the other end, N."""
    W = V - w * S  # vertical pull at s = 0, along the cable
    P = W + w * np.asarray(s)
    x = H * np.asarray(s) / EA + H / w * (np.arcsinh(P / H) - np.arcsinh(W / H))
    z = (P * P - W * W) / (2 * EA * w) + (np.hypot(H, P) - np.hypot(H, W)) / w
    return np.array([x, z])


@cache
def pull() -> tuple[float, float]:
    """H and V, N."""
    H, V = root(lambda p: at(S, *p) - [SPAN, RISE], [w * S] * 2, tol=1e-13).x
    np.testing.assert_allclose(at(S, H, V), [SPAN, RISE], rtol=1e-12)
    return float(H), float(V)


def fly(setting: Setting) -> Study:
    """Nodes and the pull on the upper end."""
    H, V = pull()
    net = line(setting.mesh, length=S)
    cord = Material(youngs_modulus=1e6 * EA, area=1e-6, linear_density=MU, law="engineering")
    ends = [Restraint("first"), Restraint("last")]
    gravity = Gravity([0.0, 0.0, -G])
    system = System(net, cord, damping=NoDamping(), loads=[gravity], restraints=ends)
    start = np.linspace(0, 1, setting.mesh + 1)[:, None] * [SPAN, 0.0, RISE]
    rest = equilibrium(system, start)
    x, z = at(net.nodes[:, 0], H, V)
    share = (80 / setting.mesh) ** 2
    reason = "straight pieces cut the corner by their square; at 80 of them by 1e-4 of the span"
    s = np.linspace(0.0, S, 200)
    return Study(
        (
            Check.of(
                "places of the nodes",
                "m",
                rest.x[:, [0, 2]],
                np.stack((x, z), axis=1),
                within=1e-4 * SPAN * share,
                reason=reason,
            ),
            Check.of(
                "pull on the upper end",
                "N",
                rest.reactions[-1],
                [H, 0.0, V],
                relative=1e-3 * share,
                reason=reason,
            ),
        ),
        Picture(
            "x, m",
            "z, m",
            (Curve("Irvine", *at(s, H, V)),),
            (Curve(f"netdae, {setting.mesh} pieces", rest.x[:, 0], rest.x[:, 2]),),
        ),
    )


MESHES = (10, 20, 40, 80)
CASE = Case(
    name="elastic-catenary",
    title="Elastic catenary",
    statement="A soft cable hung over a span and a rise lies on Irvine's catenary, to second order in its pieces.",
    sources=(Source("H. M. Irvine, Cable Structures, MIT Press 1981, section 2.4"),),
    fly=fly,
    settings=(Setting("statics", 40), Setting("statics", 80)),
    quick=(Setting("statics", 40),),
    refinements=tuple(
        Refinement(
            "pieces",
            MESHES,
            tuple(Setting("statics", N) for N in MESHES),
            check,
            -2.0,
            0.05,
            "second order, bent a little by the next one",
        )
        for check in ("places of the nodes", "pull on the upper end")
    ),
)
