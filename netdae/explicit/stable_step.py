"""The step length below which the explicit method is stable, whatever the net does.

Symbols: h step length; k, c stiffness in N/m and viscosity in N s/m of a cable along itself; m mass of a node.

The net is stable if no share of it is unstable alone (B. M. Irons, Applications of a theorem on eigenvalues to finite
element problems, 1970): give each cable e of node i the share of m_i that its (h² k + 2 h c)ₑ has in the sum Σ over
the cables of i. Then each cable with its two shares is stable if, with sums over the cables of i and of j,

    Σᵢ (h² k + 2 h c)/mᵢ + Σⱼ (h² k + 2 h c)/mⱼ ≤ 4,

a quadratic in h for every cable, whatever its direction. In straight nets it is √2 below the true limit.
k = EĀ/L̄ (g′λ² + g)/E is taken at a strain that no cable passes. With a toe k falls with it, and h grows.

A reeled cable also pulls its drum, by σλ times what it pulls its ends, and has a share of the drum's mass too: with
the sums over the cables on the drum r there stands one more term, Σᵣ σ²λ² (h² k + 2 h c)/m_r. k and c are taken at
`WOUND_IN` times the rest length that there is. Stops of drums are as stiff as its cables together, and count with them;
their dampers, and brakes, are taken at the velocity after the kick (see `kernels.reels`) and are no bound; nor is
Rayleigh damping, whatever its strength (see `kernels.rayleigh`).

A cord through rings (see `forces.drawcord`) has one k along the whole of it, EĀ/L̄ as above, and pulls each of its
nodes with |b_i| N: 2 N at most, N at its ends, σλ N at its drum. Let B = Σ |b_i|. With shares by k|b_i|B in place of k
it is stable if Σ (|b_i|/B) Σᵢ (h² k + 2 h c)/mᵢ ≤ 4. That is for rings that lie zigzag; those that do not are far
softer. Across, each segment is no stiffer than N/η, N at the largest strain. The rate of friction at rings (see
`kernels.cordage`) stands beside C in all sums.

Forces that the kernel does not know have bounds of their own, see `explicit.kicks`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from netdae._arrays import FloatArray, IntArray
from netdae.forces.brake import EndStop
from netdae.forces.cables import Cables, law_of
from netdae.forces.drawcord import SlidingCord
from netdae.forces.reel import Reeled
from netdae.system import System

WOUND_IN = 0.8
"""Share of its rest length to which a reel may wind in a cable before the step is looked at again."""


def stable_step(
    system: System, strain: float, *, rate: float = 0.0, damped: bool = True, x: FloatArray | None = None
) -> float:
    """Largest stable h in s while no E11 passes `strain`; infinite where nothing moves.

    rate : of the friction at rings, 1/s, see `kernels.cordage`
    damped : False for the step that the net would have without its dashpots
    x : (n, 3), m, where the drums of reels are; at s = 0 by default
    """
    families = list(_families(system, strain, np.zeros_like(system.net.nodes) if x is None else x))
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


class _Family(NamedTuple):
    """Elements: their nodes (m, k), and k and c with which each counts at each node, (2, m, k).

    weight : (m, k) or a number, with which the sums of its nodes count for each
    """

    nodes: IntArray
    of_nodes: FloatArray
    weight: FloatArray | float = 1.0


def _families(system: System, strain: float, x: FloatArray) -> Iterator[_Family]:
    for force in system.forces:
        match force:
            case Cables():
                of_cable = _along(force, force.L, strain)
                yield _Family(force.nodes, np.stack((of_cable, of_cable), axis=-1))
            case Reeled():
                of_cable = _along(force, WOUND_IN * _lengths_of(force, x), strain)
                on_drum = force.share**2 * (1 + 2 * strain) * of_cable
                yield _Family(force.nodes, np.stack((of_cable, of_cable, on_drum), axis=-1))
            case SlidingCord():
                yield from _of_cord(force, strain, x)
            case EndStop():
                yield _Family(force.nodes, np.stack((force.stiffness, 0 * force.stiffness))[..., None])


def _of_cord(force: SlidingCord, strain: float, x: FloatArray) -> Iterator[_Family]:
    """A cord along itself, and its segments across."""
    cord, L = force.cord, WOUND_IN * force.rest_length(x[force.nodes])
    g, dg, _, _ = law_of(strain, cord.eps, cord.engineering)
    stretch2 = 1 + 2 * strain
    k = cord.EA / L * np.array([dg * stretch2 + g, cord.tau * dg * stretch2])
    pull = np.full(force.nodes.shape, 2.0)
    if not force.closed:
        pull[0, [0, -2]] = 1.0
    pull[0, -1] = abs(cord.share) * math.sqrt(stretch2)
    yield _Family(force.nodes, k[:, None, None] * pull * pull.sum(), pull / pull.sum())
    across = np.array([cord.EA * g * math.sqrt(stretch2) / cord.size, 0.0])
    yield _Family(force.links, np.tile(across[:, None, None], (1, *force.links.shape)))


def _along(cables: Cables | Reeled, L: FloatArray, strain: float) -> FloatArray:
    """k in N/m and c in N s/m of cables of the rest lengths L (m,) along themselves, (2, m)."""
    stiffening, softening = np.empty((2, len(L)))
    for eps, engineering in {
        (float(e), bool(g)) for e, g in zip(cables.eps, cables.engineering, strict=True)
    }:
        g, dg, _, _ = law_of(strain, eps, engineering)
        of_law = (cables.eps == eps) & (cables.engineering == engineering)
        softening[of_law] = dg * (1 + 2 * strain)
        stiffening[of_law] = dg * (1 + 2 * strain) + g
    return cables.EA / L * np.stack((stiffening, cables.tau * softening))


def reeled_lengths(system: System, x: FloatArray, *, t: float = 0.0) -> FloatArray:
    """Rest lengths (m,) in m on reels where x (n, 3) are the positions, of cables and then of cords without friction.

    Raises RunError where one is wound in whole.
    """
    cables = [_lengths_of(force, x, t) for force in system.forces if isinstance(force, Reeled)]
    cords = []
    for force in system.forces:
        if isinstance(force, SlidingCord):
            force.account(t, x[force.nodes], np.zeros((1, force.nodes.size, 3)))
            cords.append([force.rest_length(x[force.nodes])])
    return np.concatenate((np.zeros(0), *cables, *cords))


def _lengths_of(reeled: Reeled, x: FloatArray, t: float = 0.0) -> FloatArray:
    return reeled.rest_length(t, x[reeled.nodes])


SHORTENED = 20.0
"""IDA is the cheaper one where dashpots shorten the explicit step more than so many times.

Measured on the reference flight of 21 × 21 knots: with a viscosity time of 3e-4 s, 17 times shorter, the explicit
flight at "fast" took as long as IDA at rtol 1e-3 and 1e-3 m/s, with 3e-3 s, 170 times shorter, four times as long.
"""


def cheaper_method(system: System) -> dict[str, str]:
    """Which method flies this system for less, and why: "method" and "reason"."""
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
