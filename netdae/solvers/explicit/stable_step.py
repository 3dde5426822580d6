"""The step length below which the explicit method is stable, whatever the net does.

Symbols: h step length; k, c stiffness in N/m and viscosity in N s/m of a cable along itself; m mass of a node.

The net is stable if each part of it alone is stable (B. M. Irons, Applications of a theorem on eigenvalues to finite
element problems, 1970): give each cable e of node i the share of m_i that its (h² k + 2 h c)ₑ has in the sum Σ over
the cables of i. Then each cable with its two shares is stable if, with sums over the cables of i and of j,

    Σᵢ (h² k + 2 h c)/mᵢ + Σⱼ (h² k + 2 h c)/mⱼ ≤ 4,

a quadratic in h for every cable, whatever its direction. In straight nets it is √2 below the true limit.
k = EĀ/L̄ (g′λ² + g)/E is taken at a strain that no cable passes. With a toe, k falls with this strain, and h grows.

A reeled cable also pulls its drum, by σλ times its pull on its ends, and gets a share of the drum's mass too: this adds
one term, Σᵣ σ²λ² (h² k + 2 h c)/m_r, with the sum over the cables on the drum r. k and c are taken at `WOUND_IN` times
the present rest length. Stops of drums are as stiff as the drum's cables together, and count with them. Their dampers,
and brakes, are taken at the velocity after the kick (see `explicit.drums`) and do not bound the step; nor does Rayleigh
damping, whatever its strength (see `explicit.rayleigh`).

A drawcord (see `forces.drawcord`) has one k along its whole length, EĀ/L̄ as above, and pulls each of its nodes with
|b_i| N: 2 N at most, N at its ends, σλ N at its drum. Let B = Σ |b_i|. With shares by k|b_i|B in place of k it is
stable if Σ (|b_i|/B) Σᵢ (h² k + 2 h c)/mᵢ ≤ 4. That is for rings that lie zigzag; otherwise the cord is far softer.
Across, each segment is no stiffer than N/η, N at the largest strain. The rate of friction at rings stands beside C in
all sums.

Contact with a body acts across the cords, which lie on its surface and pull along it: its bound stands apart from
theirs.

Forces whose law has no bound, such as external ones, enter by their current tangent: no step is longer than `STIFF`
over their rate.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.forces.law import Family
from netdae.system.system import System

STIFF = 0.2
"""Step length times the rate of forces without a bound. Of the 4 up to which the step is stable, h² K + 2 h C of
cables takes 3.6 at most, and of these forces 0.4."""


def stable_step(
    system: System, strain: float, *, rate: float = 0.0, damped: bool = True, x: FloatArray | None = None
) -> float:
    """Largest stable h in s while no E11 passes `strain`; infinite where nothing moves.

    rate : of the friction at rings, 1/s, see `forces.drawcord`
    damped : False for the step that the net would have without its dashpots
    x : (n, 3), m, where the drums of reels are; at s = 0 by default
    """
    at = np.zeros_like(system.net.nodes) if x is None else x
    found = [list(_families(system, strain, at, across=across)) for across in (False, True)]
    return min(_stable(system, families, rate, damped=damped) for families in found)


def steps_of_cords_and_contact(system: System) -> tuple[float, float]:
    """Stable h in s of the cords, and that of contact with target and obstacles; infinite where there is none."""
    strain, at = max(float(system.toe_strain.max()), 1e-3), np.zeros_like(system.net.nodes)
    cords, contact = (
        _stable(system, list(_families(system, strain, at, across=across)), 0.0, damped=True)
        for across in (False, True)
    )
    return cords, contact


def _stable(system: System, families: list[Family], rate: float, *, damped: bool) -> float:
    """The same for some families."""
    total = np.zeros((2, system.net.node_count))
    for family in families:
        for sums, of_node in zip(total, family.of_nodes, strict=True):
            np.add.at(sums, family.nodes, of_node)
    moving = ~system.restrained.all(axis=1) & (system.mass > 0)
    K, C = np.divide(total, system.mass, out=np.zeros_like(total), where=moving)
    least = math.inf
    for family in families:
        A, B = ((family.weight * sums[family.nodes]).sum(axis=1) for sums in (K, C))
        B = B + rate if damped else np.zeros_like(B)
        A, B = A[A > 0], B[A > 0]
        h = 4 / (B + np.sqrt(B**2 + 4 * A))  # the root of A h² + 2 B h = 4
        least = min(least, float(h.min(initial=math.inf)))
    return least


def _families(system: System, strain: float, x: FloatArray, *, across: bool) -> Iterator[Family]:
    for force in system.forces:
        if not isinstance(force, ElementForce) or force.law.across != across:
            continue
        if force.law.bound is not None:
            yield from force.law.bound(force.parameters, force.nodes, strain, x)


def without_bound(system: System) -> list[Force]:
    """Forces of a system that have no bound of their own."""
    return [
        force for force in system.forces if not isinstance(force, ElementForce) or force.law.bound is None
    ]


def rate_of(forces: list[Force], system: System, t: float, x: FloatArray, v: FloatArray) -> float:
    """max(√K, C) of some forces at one state, 1/s, with Gershgorin's bounds K of M⁻¹ ∂f/∂x and C of M⁻¹ ∂f/∂v."""
    sums, mass = np.zeros((2, *x.shape)), system.mass[:, None]
    for force in forces:
        elements, *slopes = force.tangent(t, x[force.nodes], v[force.nodes])
        for total, slope in zip(sums, slopes, strict=True):
            np.add.at(total, force.nodes[elements], np.abs(slope).sum(axis=(3, 4)))
    moving = ~system.restrained & (mass > 0)
    K, C = np.divide(sums, mass, out=np.zeros_like(sums), where=moving).max(axis=(1, 2))
    return max(math.sqrt(K), float(C))


SHORTENED = 20.0
"""IDA is cheaper where dashpots shorten the explicit step by more than this factor.

Measured on the reference flight of 21 × 21 knots: with a viscosity time of 3e-4 s, 17 times shorter, the explicit
flight at "fast" took as long as IDA at rtol 1e-3 and 1e-3 m/s, with 3e-3 s, 170 times shorter, four times as long.
"""


def cheaper_method(system: System) -> dict[str, str]:
    """The cheaper method for this system, and why: "method" and "reason"."""
    strain = max(float(system.toe_strain.max()), 1e-3)
    free, damped = (stable_step(system, strain, damped=damped) for damped in (False, True))
    if not math.isfinite(damped):
        return {"method": "ida", "reason": "no cable can move, so that no step is too long for IDA"}
    shorter = free / damped
    if shorter > SHORTENED:
        reason = f"the dashpot shortens the stable explicit step {shorter:.3g} times, to {damped:.3g} s; IDA's goes on"
        return {"method": "ida", "reason": reason}
    how = (
        f"shortens the stable one only {shorter:.3g} times"
        if shorter > 1.01
        else "hardly shortens the stable one"
    )
    return {
        "method": "explicit",
        "reason": f"explicit steps cost little, and damping {how}, to {damped:.3g} s",
    }
