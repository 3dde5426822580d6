"""The step length below which the explicit method is stable, whatever the net does.

Symbols: h step length; k, c stiffness in N/m and viscosity in N s/m of a cable along itself; m mass of a node.

The net is stable if no share of it is unstable alone (B. M. Irons, Applications of a theorem on eigenvalues to finite
element problems, 1970): give each cable e of node i the share of m_i that its (h² k + 2 h c)ₑ has in the sum Σ over
the cables of i. Then each cable with its two shares is stable if, with sums over the cables of i and of j,

    Σᵢ (h² k + 2 h c)/mᵢ + Σⱼ (h² k + 2 h c)/mⱼ + 2 h α ≤ 4,

a quadratic in h for every cable, whatever its direction. In straight nets it is √2 below the true limit.
k = EĀ/L̄ (g′λ² + g)/E is taken at a strain that no cable passes. With a toe k falls with it, and h grows.
"""

from __future__ import annotations

import math

import numpy as np

from netdae._arrays import FloatArray
from netdae.forces.cables import law_of
from netdae.forces.rayleigh import MassDamping, StiffnessDamping
from netdae.system import System


def stable_step(system: System, strain: float, *, damped: bool = True) -> float:
    """Largest stable h in s while no E11 passes `strain`; infinite where nothing moves.

    damped : False for the step that the net would have without its damping
    """
    cables = system.cables
    stiffening, softening = np.empty((2, len(cables.L)))
    for eps, engineering in {
        (float(e), bool(g)) for e, g in zip(cables.eps, cables.engineering, strict=True)
    }:
        g, dg, _, _ = law_of(strain, eps, engineering)
        of_law = (cables.eps == eps) & (cables.engineering == engineering)
        softening[of_law] = dg * (1 + 2 * strain)
        stiffening[of_law] = dg * (1 + 2 * strain) + g
    k = cables.EA / cables.L * stiffening
    c, alpha = np.zeros_like(k), 0.0
    if damped:
        c += cables.tau * cables.EA / cables.L * softening
        for force in system.forces:
            if isinstance(force, StiffnessDamping):
                c += np.trace(force.viscosity, axis1=1, axis2=2)
            elif isinstance(force, MassDamping):
                alpha = float((force.viscosity[system.mass > 0] / system.mass[system.mass > 0]).max())
    K, C = (_over_mass(system, of_cable) for of_cable in (k, c))
    i, j = cables.nodes.T
    A, B = K[i] + K[j], C[i] + C[j] + alpha
    moving = A > 0
    if not moving.any():
        return math.inf
    return float((4 / (B + np.sqrt(B**2 + 4 * A)))[moving].min())  # the root of A h² + 2 B h = 4


def _over_mass(system: System, of_cable: FloatArray) -> FloatArray:
    """Sums over the cables of each node, over its mass; zero for nodes that cannot move, (n,)."""
    total = np.zeros(system.net.node_count)
    np.add.at(total, system.cables.nodes, of_cable[:, None])
    moving = ~system.restrained.all(axis=1) & (system.mass > 0)
    return np.divide(total, system.mass, out=np.zeros_like(total), where=moving)


SHORTENED = 20.0
"""IDA is the cheaper one where damping shortens the explicit step more than so many times.

Measured on the reference flight of 21 × 21 knots at accuracy = "fast": with Rayleigh damping of β = 1e-4 s, 5 times
shorter, the explicit flight took a quarter of IDA's time, with 1e-3 s, 50 times shorter, four times as much.
"""


def cheaper_method(system: System) -> dict[str, str]:
    """Which method flies this system for less, and why: "method" and "reason"."""
    strain = max(float(system.toe_strain.max()), 1e-3)
    free, damped = (stable_step(system, strain, damped=damped) for damped in (False, True))
    if not math.isfinite(damped):
        return {"method": "ida", "reason": "no cable can move, so that no step is too long for IDA"}
    shorter = free / damped
    if shorter > SHORTENED:
        reason = (
            f"damping shortens the stable explicit step {shorter:.3g} times, to {damped:.3g} s; IDA's goes on"
        )
        return {"method": "ida", "reason": reason}
    reason = f"explicit steps cost little, and damping shortens the stable one only {shorter:.3g} times"
    return {"method": "explicit", "reason": f"{reason}, to {damped:.3g} s"}
