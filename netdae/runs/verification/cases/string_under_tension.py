"""VM53 of the ANSYS verification manual: a string of 100 in drawn to 500 lb; its first three frequencies.

The manual's elements have the mass ρAl of the drawn string, ours ρ̄ĀL̄: so ρ̄ = ρ l/L̄ for the same string. The error of
lumps is x²/6 with x = nπ/2N; two meshes take it out and leave x⁴/120.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from netdae.core.arrays import FloatArray
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.runs.verification.case import Case, Check, Curve, Picture, Refinement, Setting, Source, Study
from netdae.runs.verification.nets import line
from netdae.solvers.modes import frequencies
from netdae.solvers.statics import equilibrium
from netdae.system.damping import NoDamping
from netdae.system.system import System

INCH, POUND = 0.0254, 4.4482216152605  # m, N
PSI = POUND / INCH**2
SLUG_INCH = POUND / INCH  # lb s²/in in kg
DENSITY = 0.00073 * SLUG_INCH / INCH**3
PUBLISHED = np.array([74.708, 149.42, 224.12])  # Hz


def frequencies_of(cables: int, density: float = DENSITY) -> tuple[FloatArray, float, float]:
    """First three frequencies, Hz, the stretch l/L̄, and the tension, N."""
    length, modulus, area, tension = 100 * INCH, 30e6 * PSI, 0.00306796 * INCH**2, 500 * POUND

    def excess(L: float) -> float:  # N = S11 A l/L with S11 = E E11
        return modulus * 0.5 * ((length / L) ** 2 - 1) * area * length / L - tension

    rest = brentq(excess, 0.99 * length, length, xtol=1e-15, rtol=1e-15)
    net = line(cables, length=length)
    net = CableNet(net.nodes, net.cables, net.node_groups, rest_length=np.full(cables, rest / cables))
    cord = Material(youngs_modulus=modulus, density=density * length / rest, area=area)
    ends = [Restraint("first"), Restraint("last"), Restraint("inner", "z")]
    system = System(net, cord, damping=NoDamping(), restraints=ends)
    found, _ = frequencies(system, equilibrium(system, net.nodes), count=3)
    return found, length / rest, float(system.tension(net.nodes)[0])


def fly(setting: Setting) -> Study:
    """Frequencies on a mesh and on one twice as coarse, and their extrapolation."""
    fine, _, tension = frequencies_of(setting.mesh)
    coarse, _, _ = frequencies_of(setting.mesh // 2)
    x = np.pi / (2 * setting.mesh)
    number = np.arange(1, 4)
    limit = (4 * fine - coarse) / 3
    return Study(
        (
            Check.of(
                "frequencies, extrapolated",
                "Hz",
                limit,
                PUBLISHED,
                relative=1e-4,
                reason="the manual has five digits, and the extrapolation leaves 2e-6 at 40 pieces",
            ),
            Check.of(
                "third frequency of the mesh",
                "Hz",
                fine[2],
                limit[2],
                relative=1.1 * (3 * x) ** 2 / 6,
                reason="lumps lower it by x²/6, x = nπ/2N",
            ),
            Check.of(
                "tension", "N", tension, 500 * POUND, relative=1e-10, reason="round-off of the rest length"
            ),
        ),
        Picture(
            "number of the mode",
            "frequency, Hz",
            (Curve("published", number, PUBLISHED),),
            (Curve("netdae, extrapolated", number, limit), Curve(f"{setting.mesh} pieces", number, fine)),
        ),
    )


MESHES = (10, 20, 40, 80)
CASE = Case(
    name="string-under-tension",
    title="Vibration of a string under tension (ANSYS VM53)",
    statement="A steel string drawn to 500 lb has the three frequencies of the ANSYS verification manual.",
    sources=(Source("Ansys Mechanical APDL Verification Manual, VM53, Vibration of a String Under Tension"),),
    fly=fly,
    settings=(Setting("modes", 40),),
    quick=(Setting("modes", 40),),
    refinements=(
        Refinement(
            "pieces",
            MESHES,
            tuple(Setting("modes", N) for N in MESHES),
            "third frequency of the mesh",
            -2.0,
            0.05,
            "the next term, x²/20 with x = 3π/20, bends it by 0.03",
        ),
    ),
)
