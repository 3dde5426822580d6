"""A square net of N × N meshes a, prestressed to T and held by its border, vibrates as a lumped membrane.

A knot of mass m is pulled back by T/a of each of its four cables: m ω² = (4T/a)(sin²(pπ/2N) + sin²(qπ/2N)),
p, q = 1 … N − 1. In the limit ω = (π/l) √(T a/m) √(p² + q²), the membrane's.
"""

from __future__ import annotations

import numpy as np

from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.runs.verification.case import Case, Check, Curve, Picture, Refinement, Setting, Source, Study
from netdae.solvers.modes import frequencies
from netdae.system.damping import NoDamping
from netdae.system.system import System

SIDE, T, AREAL = 2.0, 5.0, 10.0  # m; T at 10 meshes a side, N; tension and mass a metre are kept in the limit
CORD = {"youngs_modulus": 2e9, "area": 1e-6}


def fly(setting: Setting) -> Study:
    """The lowest frequencies, and that the net is at rest."""
    N = setting.mesh
    a = SIDE / N
    pull = T * AREAL / N  # so that the membrane's tension a metre stays
    cord = Material(linear_density=1e-3 * AREAL / N, prestress=pull, **CORD)  # type: ignore[arg-type]
    net = CableNet.square(side=SIDE, cells=N)
    system = System(net, cord, damping=NoDamping(), restraints=[Restraint("border")])
    m = float(2 * system.cords.linear_density[0] * system.net.rest_length[0])  # two halves of two families
    k = np.sin(np.arange(1, N) * np.pi / (2 * N)) ** 2
    lumped = np.sort(np.sqrt(4 * pull / (m * a) * (k[:, None] + k)).ravel())[:6] / (2 * np.pi)
    pairs = np.arange(1, N)[:, None] ** 2 + np.arange(1, N) ** 2
    membrane = np.sqrt(pull * a / m) * np.sqrt(np.sort(pairs.ravel())[:6]) / (2 * SIDE)
    found, modes = frequencies(system, State.at(net.nodes), count=6)
    number = np.arange(1, 7)
    x = np.pi / (2 * N)
    force = np.where(system.restrained, 0.0, system.force(0.0, net.nodes, np.zeros_like(net.nodes)))
    return Study(
        (
            Check.of(
                "frequencies of the lumps",
                "Hz",
                found,
                lumped,
                relative=1e-8,
                reason="the eigenvalue solver's tolerance",
            ),
            Check.of(
                "first frequency against the membrane",
                "Hz",
                found[0],
                membrane[0],
                relative=1.01 * x * x / 6,
                reason="lumps lower it by x²/6, x = π/2N",
            ),
            Check.of(
                "tension", "N", system.tension(net.nodes), pull, relative=1e-9, reason="round-off over strain"
            ),
            Check.of(
                "force on free knots", "N", force, 0.0, within=1e-9 * pull, reason="round-off over strain"
            ),
            Check.of(
                "moves in its plane", "1", np.abs(modes[0][:, :2]).max(), 0.0, within=1e-6, reason="round-off"
            ),
        ),
        Picture(
            "number of the mode",
            "frequency, Hz",
            (Curve("lumps", number, lumped), Curve("membrane", number, membrane)),
            (Curve("netdae", number, found),),
        ),
    )


MESHES = (5, 10, 20)
CASE = Case(
    name="prestressed-net",
    title="Vibration of a prestressed square net",
    statement="A prestressed net held by its border rings as a lumped membrane, and finer as the membrane.",
    sources=(Source("Lord Rayleigh, The Theory of Sound, vol. 1, §§ 195-199, the rectangular membrane"),),
    fly=fly,
    settings=(Setting("modes", 5), Setting("modes", 10), Setting("modes", 20)),
    quick=(Setting("modes", 10),),
    refinements=(
        Refinement(
            "meshes a side",
            MESHES,
            tuple(Setting("modes", N) for N in MESHES),
            "first frequency against the membrane",
            -2.0,
            0.03,
            "second order of the lumps",
        ),
    ),
)
