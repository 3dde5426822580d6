"""Cables that pull and never push, with the objective dashpot.

Symbols, for a cable from node i to node j:
d = xⱼ − xᵢ (3,), w = vⱼ − vᵢ (3,), L̄ rest length, EĀ axial stiffness, ε toe strain, τ viscosity time,
E11 Green-Lagrange strain, S11 second Piola-Kirchhoff stress, q = S11 Ā/L̄ force density in N/m.

Eq. (3) reads E11 = ½ (d·d − L̄²)/L̄², so ∂E11/∂d = d/L̄² and Ė11 = d·w/L̄². With the law g of Eq. (4),

    S11 = g(E11) + τ g′(E11) Ė11, not below zero,       f on i = q d = −f on j,

of which the first term is −S(x) x of Eq. (5). Its derivatives, with g″ where the law is curved, are

    ∂f/∂d = q I + Ā/L̄³ d ⊗ [(g′ + τ g″ Ė11) d + τ g′ w],      ∂f/∂w = τ g′ Ā/L̄³ d ⊗ d:

for τ = 0 the tangent of Eq. (6), and zero wherever the cable is slack or S11 is held at zero.
d ⊗ w is the one unsymmetric part.

Between two places, of strain E₀ with d₀ and E₁ with d₁, the mean force q̄ ½ (d₀ + d₁) does the work of the stored
energy U if q̄ = (U₁ − U₀)/(½ (d₁·d₁ − d₀·d₀)), which is EĀ/L̄ times the mean of n over the law's own strain from one to
the other: ½ (E₀ + E₁) of Eq. (4) where both are taut, and E₁²/(2 (E₁ − E₀)) where the first is slack. The engineering
law has the factor 2/(λ₀ + λ₁), the change of λ − 1 over that of E11.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numba import njit

from netdae.core.arrays import BoolArray, Flags, FloatArray, IntArray, Reals
from netdae.forces.elements import ElementForce
from netdae.forces.law import Family, Law, Shares, Vector, compiled


@njit(cache=True, forceinline=True)
def strain_of(dx: float, dy: float, dz: float, L: float) -> float:
    """E11 by Eq. (3)."""
    return 0.5 * ((dx * dx + dy * dy + dz * dz) / (L * L) - 1.0)


@njit(cache=True, forceinline=True)
def own_strain_of(E11: float, engineering: bool) -> float:
    """The strain e in which a law and its toe are defined: E11, or λ − 1 of the engineering law."""
    return 2.0 * E11 / (1.0 + np.sqrt(1.0 + 2.0 * E11)) if engineering else E11


@njit(cache=True, forceinline=True)
def law_of(E11: float, eps: float, engineering: bool) -> tuple[float, float, float, float]:
    """g/E, g′/E, g″/E and the stored energy per EĀL̄ of the law with toe; zero for a slack cable.

    Taut, the toe law in a strain e is n(e) = e²/(2ε) below ε and e − ε/2 above: C¹, and Eq. (4) for ε = 0.
    St Venant-Kirchhoff: g = E n(E11). Engineering, N = EĀ n(λ − 1) with the stretch λ = √(1 + 2 E11):
    g = E n/λ, and since dλ/dE11 = 1/λ, g′ = E (n′/λ² − n/λ³), g″ = E (n″/λ³ − 3n′/λ⁴ + 3n/λ⁵).
    """
    if E11 < 0.0:
        return 0.0, 0.0, 0.0, 0.0
    e = own_strain_of(E11, engineering)
    if e < eps:
        n, dn, ddn, energy = 0.5 * e * e / eps, e / eps, 1.0 / eps, e * e * e / (6.0 * eps)
    else:
        n, dn, ddn, energy = e - 0.5 * eps, 1.0, 0.0, 0.5 * e * (e - eps) + eps * eps / 6.0
    if not engineering:
        return n, dn, ddn, energy
    s = 1.0 / np.sqrt(1.0 + 2.0 * E11)
    return n * s, (dn - n * s) * s * s, (ddn - 3.0 * (dn - n * s) * s) * s * s * s, energy


class Cable(NamedTuple):
    """Parameters of cables, (m,) but for `plain`."""

    L: Reals  # L̄, m
    L2: Reals  # L̄², m²
    half: Reals  # EĀ/(2 L̄³), N/m³: q of the sharp law over l² − L̄²
    viscous: Reals  # τ EĀ/L̄³, N s/m³: q of its dashpot over d·w
    EA: Reals  # EĀ, N
    eps: Reals  # ε
    engineering: Flags
    plain: bool  # all cables follow Eq. (4) without a toe


@compiled
def densities_of(p: Cable, e: int, excess: float, rate: float) -> tuple[float, float]:
    """Elastic and viscous part of q, N/m, of a cable with d·d − L̄² = excess ≥ 0 and d·w = rate."""
    if p.plain:
        return p.half[e] * excess, p.viscous[e] * rate
    g, dg, _, _ = law_of(0.5 * excess / p.L2[e], p.eps[e], p.engineering[e])
    return g * p.EA[e] / p.L[e], p.viscous[e] * dg * rate


@compiled
def _pull(p: Cable, e: int, s: FloatArray, d: Vector, w: Vector, f: Shares) -> bool:
    excess = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - p.L2[e]
    if excess < 0.0:
        return False
    elastic, viscous = densities_of(p, e, excess, d[0] * w[0] + d[1] * w[1] + d[2] * w[2])
    damper = max(elastic + viscous, 0.0) - elastic
    for c in range(3):
        f.conservative[c] = elastic * d[c]
        f.dissipative[c] = damper * d[c]
    return True


@compiled
def _tangent(p: Cable, e: int, s: FloatArray, d: Vector, w: Vector, K: FloatArray, C: FloatArray) -> bool:
    excess = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - p.L2[e]
    if excess < 0.0:
        return False
    rate = d[0] * w[0] + d[1] * w[1] + d[2] * w[2]
    elastic, viscous = densities_of(p, e, excess, rate)
    q = elastic + viscous
    if q < 0.0:
        return False
    dg, ddg = 1.0, 0.0
    if not p.plain:
        _, dg, ddg, _ = law_of(0.5 * excess / p.L2[e], p.eps[e], p.engineering[e])
    c = p.viscous[e] * dg
    along = 2.0 * p.half[e] * dg + p.viscous[e] * ddg * rate / p.L2[e]
    for a in range(3):
        for b in range(3):
            K[a, b] = d[a] * (along * d[b] + c * w[b])
            C[a, b] = c * d[a] * d[b]
        K[a, a] += q
    return True


@compiled
def _energy(p: Cable, e: int, d: Vector) -> float:
    E11 = 0.5 * ((d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / p.L2[e] - 1.0)
    return p.EA[e] * p.L[e] * law_of(E11, p.eps[e], p.engineering[e])[3]


@compiled
def mean_of_law(e0: float, e1: float, eps: float) -> float:
    """Mean of n(e) of `law_of` over the strains from e0 to e1: the stored energy's difference over theirs.

    Summed piece by piece, slack, toe and straight, so that nothing cancels where they are close.
    """
    low, high = min(e0, e1), max(e0, e1)
    if high <= 0.0:
        return 0.0
    width, mean = high - low, 0.0
    a, b = max(low, 0.0), min(high, eps)
    if a < b or (width == 0.0 and high < eps):
        mean += (a * a + a * b + b * b) / (6.0 * eps) * ((b - a) / width if width > 0.0 else 1.0)
    a = max(low, eps)
    if a < high or (width == 0.0 and high >= eps):
        mean += 0.5 * (a + high - eps) * ((high - a) / width if width > 0.0 else 1.0)
    return mean


@compiled
def _between(p: Cable, e: int, d: Vector, g: Vector, f: FloatArray) -> bool:
    before = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - p.L2[e]
    after = g[0] * g[0] + g[1] * g[1] + g[2] * g[2] - p.L2[e]
    if before < 0.0 and after < 0.0:
        return False
    if p.plain:
        if before >= 0.0 and after >= 0.0:
            q = p.half[e] * 0.5 * (before + after)
        else:
            taut = max(before, after)
            q = p.half[e] * 0.5 * taut * (taut / abs(after - before))
    elif p.engineering[e]:
        s0, s1 = np.sqrt(1.0 + before / p.L2[e]), np.sqrt(1.0 + after / p.L2[e])
        e0, e1 = before / p.L2[e] / (1.0 + s0), after / p.L2[e] / (1.0 + s1)
        q = p.EA[e] / p.L[e] * mean_of_law(e0, e1, p.eps[e]) * 2.0 / (s0 + s1)
    else:
        q = p.EA[e] / p.L[e] * mean_of_law(0.5 * before / p.L2[e], 0.5 * after / p.L2[e], p.eps[e])
    for c in range(3):
        f[c] = 0.5 * q * (d[c] + g[c])
    return True


def _is_lossless(p: Cable) -> bool:
    return not p.viscous.any()


@compiled
def _measured(p: Cable, e: int, d: Vector) -> tuple[float, float]:
    l2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    elastic, _ = densities_of(p, e, l2 - p.L2[e], 0.0)
    return elastic * elastic * l2, 0.5 * (l2 / p.L2[e] - 1.0)


@compiled
def _near(p: Cable, e: int, d: Vector, margin: float) -> bool:
    short = p.L[e] - margin
    far = short > 0.0 and d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < short * short  # false for not-a-number
    return p.EA[e] > 0.0 and not far


def along_of(
    L: FloatArray, EA: FloatArray, eps: FloatArray, engineering: BoolArray, tau: FloatArray, strain: float
) -> FloatArray:
    """k in N/m and c in N s/m of cables (m,) along themselves at a strain, (2, m).

    EĀ/L̄ (g′Λ + g)/E and EĀ/L̄ τ g′Λ/E.
    """
    stiffening, softening = np.empty((2, len(L)))
    for law in {(float(e), bool(g)) for e, g in zip(eps, engineering, strict=True)}:
        g, dg, _, _ = law_of(strain, *law)
        of_law = (eps == law[0]) & (engineering == law[1])
        softening[of_law] = dg * (1 + 2 * strain)
        stiffening[of_law] = dg * (1 + 2 * strain) + g
    return EA / L * np.stack((stiffening, tau * softening))


def _bound(p: Cable, nodes: IntArray, strain: float, x: FloatArray) -> list[Family]:
    tau = np.divide(p.viscous, 2.0 * p.half, out=np.zeros_like(p.L), where=p.half > 0)
    of_cable = along_of(p.L, p.EA, p.eps, p.engineering, tau, strain)
    return [Family(nodes, np.stack((of_cable, of_cable), axis=-1))]


CABLE = Law(
    Cable,
    force=_pull,
    tangent=_tangent,
    energy=_energy,
    pair=True,
    shares=("conservative", "dissipative"),
    measured=_measured,
    near=_near,
    bound=_bound,
    between=_between,
    lossless=_is_lossless,
)


@njit(cache=True)
def _strains(x: FloatArray, nodes: IntArray, L: FloatArray, E11: FloatArray) -> None:
    for e in range(len(L)):
        i, j = nodes[e]
        E11[e] = strain_of(x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2], L[e])


@njit(cache=True)
def _stress_ratios(E11: FloatArray, eps: FloatArray, engineering: BoolArray, ratio: FloatArray) -> None:
    for e in range(len(E11)):
        ratio[e] = law_of(E11[e], eps[e], engineering[e])[0]


@njit(cache=True)
def _energy_and_peak(
    x: FloatArray, nodes: IntArray, L: FloatArray, EA: FloatArray, eps: FloatArray, engineering: BoolArray
) -> tuple[float, float]:
    stored = peak = 0.0
    for e in range(len(L)):
        i, j = nodes[e]
        E11 = strain_of(x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2], L[e])
        if E11 >= 0.0:
            g, _, _, energy = law_of(E11, eps[e], engineering[e])
            stored += EA[e] * L[e] * energy
            peak = max(peak, EA[e] * g * np.sqrt(1.0 + 2.0 * E11))
    return stored, peak


@dataclass(frozen=True, eq=False)
class Cables:
    """All cables of a net, as data; `force` is the force that they exert.

    nodes : (m, 2); L : L̄ (m,), m; EA : EĀ (m,), N; eps : ε (m,); engineering : (m,); tau : τ (m,), s
    """

    nodes: IntArray
    L: FloatArray
    EA: FloatArray
    eps: FloatArray
    engineering: BoolArray
    tau: FloatArray

    @cached_property
    def force(self) -> ElementForce:
        """Pull of each cable on its two nodes, Eq. (5) with the dashpot's share."""
        plain = not ((self.eps > 0).any() or self.engineering.any())
        c = self.EA / self.L**3
        parameters = Cable(
            self.L, self.L**2, 0.5 * c, self.tau * c, self.EA, self.eps, self.engineering, plain
        )
        return ElementForce(CABLE, self.nodes, parameters)

    def energy_and_peak(self, x: FloatArray) -> tuple[float, float]:
        """Stored energy in J and largest tension in N from the positions of all nodes (n, 3)."""
        return _energy_and_peak(x, self.nodes, self.L, self.EA, self.eps, self.engineering)

    def strain(self, x: FloatArray) -> FloatArray:
        """E11 (m,) from the positions of all nodes (n, 3)."""
        E11 = np.empty(len(self.L))
        _strains(x, self.nodes, self.L, E11)
        return E11

    def stress_ratio(self, E11: FloatArray) -> FloatArray:
        """g(E11)/E (m,): Eq. (4) over Young's modulus, without the dashpot's share."""
        ratio = np.empty(len(self.L))
        _stress_ratios(E11, self.eps, self.engineering, ratio)
        return ratio
