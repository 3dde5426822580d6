"""Cables whose rest length a reel pays out or winds in.

A reel is a generalised node r: its x-coordinate is s, the length paid out in m, its velocity along x is ṡ, its
mass the drum's inertia J/R² in kg. Symbols, for a cable from node i to node j that reels on r:
L̄(s) = L̄₀ + σ s with the share σ, usually 1; else as in `cables`, with Λ = 1 + 2 E11 = d·d/L̄².

The rest length varies, so that with ∂E11/∂L̄ = −Λ/L̄ the strain and its rate are

    E11 = ½ (d·d/L̄² − 1),       Ė11 = d·w/L̄² − σ Λ ṡ/L̄.

The stored energy is U = EĀ L̄ e(E11) with the law's energy e, e′ = g. Minus its derivatives are the pull of
`cables` on i and j and, on s, −∂U/∂s = σ EĀ (g Λ − e). The dashpot is taken as dissipation of the power
EĀ L̄ (S − g) Ė11 with S = g + τ g′ Ė11, not below zero; its forces are −EĀ L̄ (S − g) times the derivatives of
Ė11 by w and ṡ. Together

    f on i = q d = −f on j,  q = EĀ S/L̄,        f on s = σ EĀ (S Λ − e),

so that kinetic energy, U and the dissipated energy add up to a constant. For σ = 1 the force on s is N l/L̄ − EĀ e
with the axial force N = EĀ S l/L̄: the power of N at the outlet, where stretched cord leaves at l/L̄ ṡ, less
the energy that unstretched cord takes up in leaving. All is zero where the cable is slack. With

    E11,d = d/L̄²,  E11,s = −σ Λ/L̄,    Ė11,d = w/L̄² − 2σ ṡ d/L̄³,  Ė11,s = −2σ d·w/L̄³ + 3σ² ṡ Λ/L̄²,
    S,• = (g′ + τ g″ Ė11) E11,• + τ g′ Ė11,•,     S,w = τ g′ d/L̄²,   S,ṡ = −τ g′ σ Λ/L̄

the derivatives are

    ∂(q d)/∂d = q I + EĀ/L̄ d ⊗ S,d              ∂(q d)/∂s = EĀ/L̄ (S,s − σ S/L̄) d
    ∂f_s/∂d = σ EĀ (Λ S,d + (2S − g) d/L̄²)       ∂f_s/∂s = σ EĀ (Λ S,s − σ (2S − g) Λ/L̄)

and the same with only S,w and S,ṡ by velocity. Where S is held at zero, S,• is zero too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from netdae.core.arrays import Flags, FloatArray, IntArray, Reals
from netdae.forces.cables import along_of, law_of, strain_of
from netdae.forces.law import Family, Law, Shares, compiled

SHORTEST = 1e-3
"""Share of L̄₀ below which no rest length enters a force: Newton's iteration may try states far beyond a stop."""

WOUND_IN = 0.8
"""Share of its rest length to which a reel may wind in a cable before an explicit step is checked again."""


class Reeled(NamedTuple):
    """Parameters of cables whose rest length moves with a reel: cable end i, cable end j, reel node r; (m,)."""

    L: Reals  # L̄₀, m, where s = 0
    share: Reals  # σ, of L̄(s) = L̄₀ + σ s
    EA: Reals  # EĀ, N
    eps: Reals  # ε
    engineering: Flags
    tau: Reals  # τ, s


@compiled
def _rest(p: Reeled, e: int, x: FloatArray) -> tuple[float, float]:
    return p.L[e] + p.share[e] * x[2, 0], 0.0


@compiled
def _strain_and_rate(x: FloatArray, v: FloatArray, L: float, share: float) -> tuple[float, float]:
    """E11 and Ė11 of one cable from x, v (3, 3) of i, j and r."""
    dx, dy, dz = x[1, 0] - x[0, 0], x[1, 1] - x[0, 1], x[1, 2] - x[0, 2]
    wx, wy, wz = v[1, 0] - v[0, 0], v[1, 1] - v[0, 1], v[1, 2] - v[0, 2]
    E11 = strain_of(dx, dy, dz, L)
    return E11, (dx * wx + dy * wy + dz * wz) / (L * L) - share * (1.0 + 2.0 * E11) * v[2, 0] / L


@compiled
def _length(p: Reeled, e: int, x: FloatArray) -> float:
    """L̄(s), above zero."""
    return max(p.L[e] + p.share[e] * x[2, 0], SHORTEST * p.L[e])


@compiled
def _force(p: Reeled, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    L = _length(p, e, x)
    E11, rate = _strain_and_rate(x, v, L, p.share[e])
    if E11 < 0.0:
        return False
    g, dg, _, energy = law_of(E11, p.eps[e], p.engineering[e])
    damper = max(g + p.tau[e] * dg * rate, 0.0) - g
    for c in range(3):
        along = p.EA[e] / L * (x[1, c] - x[0, c])
        f.conservative[0, c], f.conservative[1, c] = along * g, -along * g
        f.dissipative[0, c], f.dissipative[1, c] = along * damper, -along * damper
    pull = p.share[e] * p.EA[e]
    f.conservative[2, 0] = pull * (g * (1.0 + 2.0 * E11) - energy)
    f.dissipative[2, 0] = pull * damper * (1.0 + 2.0 * E11)
    return True


@compiled
def _tangent(
    p: Reeled, e: int, s: FloatArray, x: FloatArray, v: FloatArray, K: FloatArray, C: FloatArray
) -> bool:
    L, sigma, s_dot = _length(p, e, x), p.share[e], v[2, 0]
    E11, rate = _strain_and_rate(x, v, L, sigma)
    if E11 < 0.0:
        return False
    g, dg, ddg, _ = law_of(E11, p.eps[e], p.engineering[e])
    stretch2, LL = 1.0 + 2.0 * E11, L * L
    S, by_E11, by_rate = g + p.tau[e] * dg * rate, dg + p.tau[e] * ddg * rate, p.tau[e] * dg
    if S < 0.0:
        S = by_E11 = by_rate = 0.0
    dw = 0.0
    for c in range(3):
        dw += (x[1, c] - x[0, c]) * (v[1, c] - v[0, c])
    rate_s = (-2.0 * sigma * dw / L + 3.0 * sigma * sigma * s_dot * stretch2) / LL
    S_s = -by_E11 * sigma * stretch2 / L + by_rate * rate_s
    S_sdot = -by_rate * sigma * stretch2 / L
    q, c = p.EA[e] * S / L, p.EA[e] / L
    for b in range(3):
        db, wb = x[1, b] - x[0, b], v[1, b] - v[0, b]
        S_d = by_E11 * db / LL + by_rate * (wb - 2.0 * sigma * s_dot * db / L) / LL
        S_w = by_rate * db / LL
        for a in range(3):
            da = x[1, a] - x[0, a]
            stiffness = c * da * S_d + (q if a == b else 0.0)
            viscosity = c * da * S_w
            K[0, a, 1, b] = K[1, a, 0, b] = stiffness
            K[0, a, 0, b] = K[1, a, 1, b] = -stiffness
            C[0, a, 1, b] = C[1, a, 0, b] = viscosity
            C[0, a, 0, b] = C[1, a, 1, b] = -viscosity
        reel_d = sigma * p.EA[e] * (stretch2 * S_d + (2.0 * S - g) * db / LL)
        reel_w = sigma * p.EA[e] * stretch2 * S_w
        K[2, 0, 1, b], K[2, 0, 0, b] = reel_d, -reel_d
        C[2, 0, 1, b], C[2, 0, 0, b] = reel_w, -reel_w
        pull_s, pull_sdot = c * (S_s - sigma * S / L) * db, c * S_sdot * db
        K[0, b, 2, 0], K[1, b, 2, 0] = pull_s, -pull_s
        C[0, b, 2, 0], C[1, b, 2, 0] = pull_sdot, -pull_sdot
    K[2, 0, 2, 0] = sigma * p.EA[e] * stretch2 * (S_s - sigma * (2.0 * S - g) / L)
    C[2, 0, 2, 0] = sigma * p.EA[e] * stretch2 * S_sdot
    return True


@compiled
def _energy(p: Reeled, e: int, x: FloatArray) -> float:
    L = _length(p, e, x)
    E11 = strain_of(x[1, 0] - x[0, 0], x[1, 1] - x[0, 1], x[1, 2] - x[0, 2], L)
    return p.EA[e] * L * law_of(E11, p.eps[e], p.engineering[e])[3]


@compiled
def _measured(p: Reeled, e: int, x: FloatArray) -> tuple[float, float]:
    E11 = strain_of(x[1, 0] - x[0, 0], x[1, 1] - x[0, 1], x[1, 2] - x[0, 2], _length(p, e, x))
    elastic = p.EA[e] * law_of(E11, p.eps[e], p.engineering[e])[0]
    return elastic * elastic * (1.0 + 2.0 * E11), E11


def _named(nodes: IntArray) -> str:
    return f"the cable between nodes {nodes[0]} and {nodes[1]}"


def _bound(p: Reeled, nodes: IntArray, strain: float, x: FloatArray) -> list[Family]:
    L = WOUND_IN * (p.L + p.share * x[nodes[:, 2], 0])
    of_cable = along_of(L, p.EA, p.eps, p.engineering, p.tau, strain)
    on_drum = p.share**2 * (1 + 2 * strain) * of_cable
    return [Family(nodes, np.stack((of_cable, of_cable, on_drum), axis=-1))]


REELED = Law(
    Reeled,
    force=_force,
    tangent=_tangent,
    energy=_energy,
    nodes=3,
    shares=("conservative", "dissipative"),
    measured=_measured,
    rest=_rest,
    named=_named,
    bound=_bound,
)
