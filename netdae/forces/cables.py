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
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.forces.protocol import Account, NewtonPart, Tangent


@njit(cache=True)
def strain_of(dx: float, dy: float, dz: float, L: float) -> float:
    """E11 by Eq. (3)."""
    return 0.5 * ((dx * dx + dy * dy + dz * dz) / (L * L) - 1.0)


@njit(cache=True)
def own_strain_of(E11: float, engineering: bool) -> float:
    """The strain e in which a law and its toe are told: E11, or λ − 1 of the engineering law."""
    return 2.0 * E11 / (1.0 + np.sqrt(1.0 + 2.0 * E11)) if engineering else E11


@njit(cache=True)
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


@njit(cache=True)
def _forces(
    x: FloatArray,
    v: FloatArray,
    L: FloatArray,
    EA: FloatArray,
    eps: FloatArray,
    engineering: BoolArray,
    tau: FloatArray,
    f: FloatArray,
) -> None:
    for e in range(len(L)):
        dx, dy, dz = x[e, 1, 0] - x[e, 0, 0], x[e, 1, 1] - x[e, 0, 1], x[e, 1, 2] - x[e, 0, 2]
        E11 = strain_of(dx, dy, dz, L[e])
        if E11 < 0.0:
            f[e] = 0.0
            continue
        g, dg, _, _ = law_of(E11, eps[e], engineering[e])
        wx, wy, wz = v[e, 1, 0] - v[e, 0, 0], v[e, 1, 1] - v[e, 0, 1], v[e, 1, 2] - v[e, 0, 2]
        rate = (dx * wx + dy * wy + dz * wz) / (L[e] * L[e])
        q = max(g + tau[e] * dg * rate, 0.0) * EA[e] / L[e]
        f[e, 0, 0], f[e, 0, 1], f[e, 0, 2] = q * dx, q * dy, q * dz
        f[e, 1, 0], f[e, 1, 1], f[e, 1, 2] = -q * dx, -q * dy, -q * dz


@njit(cache=True)
def _tangents(
    x: FloatArray,
    v: FloatArray,
    taut: IntArray,
    L: FloatArray,
    EA: FloatArray,
    eps: FloatArray,
    engineering: BoolArray,
    tau: FloatArray,
    K: FloatArray,
    C: FloatArray,
) -> None:
    for k in range(len(taut)):
        e = taut[k]
        d, w = x[e, 1] - x[e, 0], v[e, 1] - v[e, 0]
        g, dg, ddg, _ = law_of(strain_of(d[0], d[1], d[2], L[e]), eps[e], engineering[e])
        rate = (d[0] * w[0] + d[1] * w[1] + d[2] * w[2]) / (L[e] * L[e])
        q, c = (g + tau[e] * dg * rate) * EA[e] / L[e], EA[e] / L[e] ** 3
        for a in range(3):
            for b in range(3):
                along = c * d[a] * ((dg + tau[e] * ddg * rate) * d[b] + tau[e] * dg * w[b])
                stiffness = along + q if a == b else along
                viscosity = c * tau[e] * dg * d[a] * d[b]
                K[k, 0, a, 1, b] = K[k, 1, a, 0, b] = stiffness
                K[k, 0, a, 0, b] = K[k, 1, a, 1, b] = -stiffness
                C[k, 0, a, 1, b] = C[k, 1, a, 0, b] = viscosity
                C[k, 0, a, 0, b] = C[k, 1, a, 1, b] = -viscosity


@njit(cache=True)
def _taut(
    x: FloatArray,
    v: FloatArray,
    L: FloatArray,
    eps: FloatArray,
    engineering: BoolArray,
    tau: FloatArray,
) -> IntArray:
    """Cables that are taut and whose stress is not held at zero."""
    taut, count = np.empty(len(L), dtype=np.int64), 0
    for e in range(len(L)):
        dx, dy, dz = x[e, 1, 0] - x[e, 0, 0], x[e, 1, 1] - x[e, 0, 1], x[e, 1, 2] - x[e, 0, 2]
        E11 = strain_of(dx, dy, dz, L[e])
        if E11 < 0.0:
            continue
        g, dg, _, _ = law_of(E11, eps[e], engineering[e])
        wx, wy, wz = v[e, 1, 0] - v[e, 0, 0], v[e, 1, 1] - v[e, 0, 1], v[e, 1, 2] - v[e, 0, 2]
        if g + tau[e] * dg * (dx * wx + dy * wy + dz * wz) / (L[e] * L[e]) >= 0.0:
            taut[count] = e
            count += 1
    return taut[:count].copy()


@njit(cache=True)
def _account(
    x: FloatArray,
    v: FloatArray,
    L: FloatArray,
    EA: FloatArray,
    eps: FloatArray,
    engineering: BoolArray,
    tau: FloatArray,
) -> tuple[float, float]:
    stored = dissipated = 0.0
    for e in range(len(L)):
        dx, dy, dz = x[e, 1, 0] - x[e, 0, 0], x[e, 1, 1] - x[e, 0, 1], x[e, 1, 2] - x[e, 0, 2]
        E11 = strain_of(dx, dy, dz, L[e])
        if E11 < 0.0:
            continue
        g, dg, _, energy = law_of(E11, eps[e], engineering[e])
        stored += EA[e] * L[e] * energy
        if tau[e] > 0.0:
            wx, wy, wz = v[e, 1, 0] - v[e, 0, 0], v[e, 1, 1] - v[e, 0, 1], v[e, 1, 2] - v[e, 0, 2]
            rate = (dx * wx + dy * wy + dz * wz) / (L[e] * L[e])
            dissipated += EA[e] * L[e] * (max(g + tau[e] * dg * rate, 0.0) - g) * rate
    return stored, dissipated


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
    """All cables of a net as one force with k = 2.

    nodes : (m, 2); L : L̄ (m,), m; EA : EĀ (m,), N; eps : ε (m,); engineering : (m,); tau : τ (m,), s
    """

    nodes: IntArray
    L: FloatArray
    EA: FloatArray
    eps: FloatArray
    engineering: BoolArray
    tau: FloatArray

    newton: NewtonPart = "symmetric"
    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()
    external: bool = False

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Pull of each cable on its two nodes, (m, 2, 3), N; Eq. (5) with the dashpot's share."""
        f = np.empty_like(x)
        _forces(x, v, self.L, self.EA, self.eps, self.engineering, self.tau, f)
        return f

    def tangent(self, t: float, x: FloatArray, v: FloatArray) -> Tangent:
        """∂f/∂x, minus Eq. (6) without dashpot, and ∂f/∂v, of the taut cables."""
        taut = _taut(x, v, self.L, self.eps, self.engineering, self.tau)
        K, C = np.empty((2, len(taut), 2, 3, 2, 3))
        _tangents(x, v, taut, self.L, self.EA, self.eps, self.engineering, self.tau, K, C)
        return Tangent(taut, K, C)

    def account(self, t: float, x: FloatArray, v: FloatArray) -> Account:
        """Elastic energy and the dashpot's power, (S11 − g) Ė11 Ā L̄ with the S11 that is not below zero."""
        return Account(*_account(x, v, self.L, self.EA, self.eps, self.engineering, self.tau))

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
