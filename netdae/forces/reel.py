"""Cables whose rest length a reel pays out or winds in.

A reel is a generalised node r: its x-coordinate is s, the length paid out in m, its velocity along x is ṡ, its
mass the drum's inertia J/R² in kg. Symbols, for a cable from node i to node j that reels on r:
L̄(s) = L̄₀ + σ s with the share σ, usually 1; else as in `cables`, with Λ = 1 + 2 E11 = d·d/L̄².

The rest length moves, so that with ∂E11/∂L̄ = −Λ/L̄ the strain and its rate are

    E11 = ½ (d·d/L̄² − 1),       Ė11 = d·w/L̄² − σ Λ ṡ/L̄.

The stored energy is U = EĀ L̄ e(E11) with the law's energy e, e′ = g. Minus its derivatives are the pull of
`cables` on i and j and, on s, −∂U/∂s = σ EĀ (g Λ − e). The dashpot is taken as dissipation of the power
EĀ L̄ (S − g) Ė11 with S = g + τ g′ Ė11, not below zero; its forces are −EĀ L̄ (S − g) times the derivatives of
Ė11 by w and ṡ. Together

    f on i = q d = −f on j,  q = EĀ S/L̄,        f on s = σ EĀ (S Λ − e),

so that kinetic energy, U and what is dissipated add up to a constant. For σ = 1 the force on s is N l/L̄ − EĀ e
with the axial force N = EĀ S l/L̄: the power of N at the outlet, where stretched cord leaves at l/L̄ ṡ, less
the energy that unstretched cord takes up in leaving. All is zero where the cable is slack. With

    E11,d = d/L̄²,  E11,s = −σ Λ/L̄,    Ė11,d = w/L̄² − 2σ ṡ d/L̄³,  Ė11,s = −2σ d·w/L̄³ + 3σ² ṡ Λ/L̄²,
    S,• = (g′ + τ g″ Ė11) E11,• + τ g′ Ė11,•,     S,w = τ g′ d/L̄²,   S,ṡ = −τ g′ σ Λ/L̄

the derivatives are

    ∂(q d)/∂d = q I + EĀ/L̄ d ⊗ S,d              ∂(q d)/∂s = EĀ/L̄ (S,s − σ S/L̄) d
    ∂f_s/∂d = σ EĀ (Λ S,d + (2S − g) d/L̄²)       ∂f_s/∂s = σ EĀ (Λ S,s − σ (2S − g) Λ/L̄)

and the same with S,w and S,ṡ alone by velocity. Where S is held at zero, S,• is zero too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.errors import RunError
from netdae.forces.cables import law_of, strain_of
from netdae.forces.protocol import Account, NewtonPart, Tangent


@njit(cache=True)
def _rest_lengths(x: FloatArray, L0: FloatArray, share: FloatArray, L: FloatArray) -> float:
    """L̄(s) into L (m,); the least of them."""
    least = np.inf
    for e in range(len(L)):
        L[e] = L0[e] + share[e] * x[e, 2, 0]
        least = min(least, L[e])
    return least


@njit(cache=True)
def _strain_and_rate(x: FloatArray, v: FloatArray, L: float, share: float) -> tuple[float, float]:
    """E11 and Ė11 of one cable from x, v (3, 3) of i, j and r."""
    dx, dy, dz = x[1, 0] - x[0, 0], x[1, 1] - x[0, 1], x[1, 2] - x[0, 2]
    wx, wy, wz = v[1, 0] - v[0, 0], v[1, 1] - v[0, 1], v[1, 2] - v[0, 2]
    E11 = strain_of(dx, dy, dz, L)
    return E11, (dx * wx + dy * wy + dz * wz) / (L * L) - share * (1.0 + 2.0 * E11) * v[2, 0] / L


@njit(cache=True)
def reeled_forces(
    x: FloatArray,
    v: FloatArray,
    L: FloatArray,
    share: FloatArray,
    EA: FloatArray,
    eps: FloatArray,
    engineering: BoolArray,
    tau: FloatArray,
    f: FloatArray,
) -> None:
    """Forces f (m, 3, 3) on i, j and r of each cable, N; L is L̄(s)."""
    for e in range(len(L)):
        f[e] = 0.0
        E11, rate = _strain_and_rate(x[e], v[e], L[e], share[e])
        if E11 < 0.0:
            continue
        g, dg, _, energy = law_of(E11, eps[e], engineering[e])
        S = max(g + tau[e] * dg * rate, 0.0)
        for a in range(3):
            pull = EA[e] * S / L[e] * (x[e, 1, a] - x[e, 0, a])
            f[e, 0, a], f[e, 1, a] = pull, -pull
        f[e, 2, 0] = share[e] * EA[e] * (S * (1.0 + 2.0 * E11) - energy)


@njit(cache=True)
def reeled_tangents(
    x: FloatArray,
    v: FloatArray,
    taut: IntArray,
    L: FloatArray,
    share: FloatArray,
    EA: FloatArray,
    eps: FloatArray,
    engineering: BoolArray,
    tau: FloatArray,
    K: FloatArray,
    C: FloatArray,
) -> None:
    """∂f/∂x and ∂f/∂v of the cables `taut` (a,) into K and C, (a, 3, 3, 3, 3)."""
    K[:], C[:] = 0.0, 0.0
    for k in range(len(taut)):
        e = taut[k]
        d, w, s_dot = x[e, 1] - x[e, 0], v[e, 1] - v[e, 0], v[e, 2, 0]
        E11, rate = _strain_and_rate(x[e], v[e], L[e], share[e])
        g, dg, ddg, _ = law_of(E11, eps[e], engineering[e])
        stretch2, sigma, LL = 1.0 + 2.0 * E11, share[e], L[e] * L[e]
        S, by_E11, by_rate = g + tau[e] * dg * rate, dg + tau[e] * ddg * rate, tau[e] * dg
        if S < 0.0:
            S = by_E11 = by_rate = 0.0
        dw = d[0] * w[0] + d[1] * w[1] + d[2] * w[2]
        rate_s = (-2.0 * sigma * dw / L[e] + 3.0 * sigma * sigma * s_dot * stretch2) / LL
        S_s = -by_E11 * sigma * stretch2 / L[e] + by_rate * rate_s
        S_sdot = -by_rate * sigma * stretch2 / L[e]
        q, c = EA[e] * S / L[e], EA[e] / L[e]
        for b in range(3):
            S_d = by_E11 * d[b] / LL + by_rate * (w[b] - 2.0 * sigma * s_dot * d[b] / L[e]) / LL
            S_w = by_rate * d[b] / LL
            for a in range(3):
                stiffness = c * d[a] * S_d + (q if a == b else 0.0)
                viscosity = c * d[a] * S_w
                K[k, 0, a, 1, b], K[k, 0, a, 0, b] = stiffness, -stiffness
                K[k, 1, a, 1, b], K[k, 1, a, 0, b] = -stiffness, stiffness
                C[k, 0, a, 1, b], C[k, 0, a, 0, b] = viscosity, -viscosity
                C[k, 1, a, 1, b], C[k, 1, a, 0, b] = -viscosity, viscosity
            reel_d = sigma * EA[e] * (stretch2 * S_d + (2.0 * S - g) * d[b] / LL)
            reel_w = sigma * EA[e] * stretch2 * S_w
            K[k, 2, 0, 1, b], K[k, 2, 0, 0, b] = reel_d, -reel_d
            C[k, 2, 0, 1, b], C[k, 2, 0, 0, b] = reel_w, -reel_w
            pull_s, pull_sdot = c * (S_s - sigma * S / L[e]) * d[b], c * S_sdot * d[b]
            K[k, 0, b, 2, 0], K[k, 1, b, 2, 0] = pull_s, -pull_s
            C[k, 0, b, 2, 0], C[k, 1, b, 2, 0] = pull_sdot, -pull_sdot
        K[k, 2, 0, 2, 0] = sigma * EA[e] * stretch2 * (S_s - sigma * (2.0 * S - g) / L[e])
        C[k, 2, 0, 2, 0] = sigma * EA[e] * stretch2 * S_sdot


@njit(cache=True)
def reeled_powers(
    x: FloatArray,
    v: FloatArray,
    L: FloatArray,
    share: FloatArray,
    EA: FloatArray,
    eps: FloatArray,
    engineering: BoolArray,
    tau: FloatArray,
) -> tuple[float, float]:
    """U of all cables and the power that their dashpots take, EĀ L̄ (S − g) Ė11."""
    stored = dissipated = 0.0
    for e in range(len(L)):
        E11, rate = _strain_and_rate(x[e], v[e], L[e], share[e])
        if E11 < 0.0:
            continue
        g, dg, _, energy = law_of(E11, eps[e], engineering[e])
        stored += EA[e] * L[e] * energy
        dissipated += (max(g + tau[e] * dg * rate, 0.0) - g) * rate * EA[e] * L[e]
    return stored, dissipated


SHORTEST = 1e-3
"""Share of L̄₀ below which forces take no rest length; `account`, asked of steps that count, refuses one below zero."""


@dataclass(frozen=True, eq=False)
class Reeled:
    """Cables whose rest length moves with a reel, k = 3: cable end i, cable end j, reel node r.

    nodes : (m, 3); L : L̄₀ (m,), m, where s = 0; share : σ (m,), of L̄(s) = L̄₀ + σ s
    EA : EĀ (m,), N; eps : ε (m,); engineering : (m,); tau : τ (m,), s

    Raises RunError where a rest length has come to zero.
    """

    nodes: IntArray
    L: FloatArray
    share: FloatArray
    EA: FloatArray
    eps: FloatArray
    engineering: BoolArray
    tau: FloatArray

    newton: NewtonPart = "symmetric"
    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()
    external: bool = False

    def rest_length(self, t: float, x: FloatArray) -> FloatArray:
        """L̄(s) (m,), m, from x (m, 3, 3); raises RunError where it is not above zero."""
        L = np.empty(len(x))
        if not _rest_lengths(x, self.L, self.share, L) > 0.0:
            e = int(np.argmin(L))
            i, j, r = self.nodes[e]
            raise RunError(
                f"at t = {t:g} s the cable between nodes {i} and {j} has the rest length {L[e]:g} m, wound in by the "
                f"reel at node {r}: stop the reel before, at a length above zero"
            )
        return L

    def _tried(self, x: FloatArray) -> FloatArray:
        """L̄(s) (m,), m; above zero also where a trial of Newton's iteration lies far beyond a stop."""
        L = np.empty(len(x))
        _rest_lengths(x, self.L, self.share, L)
        return np.maximum(L, SHORTEST * self.L)

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Pull on both ends and, along x of the reel node, the force on s, (m, 3, 3), N."""
        f = np.empty_like(x)
        reeled_forces(x, v, self._tried(x), *self._cords, f)
        return f

    def tangent(self, t: float, x: FloatArray, v: FloatArray) -> Tangent:
        """∂f/∂x and ∂f/∂v of the taut cables."""
        L = self._tried(x)
        taut = np.flatnonzero(np.sum((x[:, 1] - x[:, 0]) ** 2, axis=1) >= L * L)
        K, C = np.empty((2, len(taut), 3, 3, 3, 3))
        reeled_tangents(x, v, taut, L, *self._cords, K, C)
        return Tangent(taut, K, C)

    def account(self, t: float, x: FloatArray, v: FloatArray) -> Account:
        """U, and the dashpot's power EĀ L̄ (S − g) Ė11."""
        return Account(*reeled_powers(x, v, self.rest_length(t, x), *self._cords))

    @property
    def _cords(self) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray, FloatArray]:
        return self.share, self.EA, self.eps, self.engineering, self.tau
