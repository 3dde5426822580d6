"""Friction of a cord at its rings, by the capstan rule.

Symbols as in `rings`; N mean tension, N_i that of segment i, ν_i = N_i/N; L̄ = L̄₀ + σ s rest length and λ = l/L̄ stretch
of the whole cord; ring j lies between the segments j − 1 and j.

At ring j the cord turns by the angle φ_j and slides with the speed c_j; by the capstan rule (Euler, Eytelwein) the
tension behind the ring over that before it is e^{μφ}, the greater on the side the cord moves to. How much cord lies in
each segment follows from one strain in all of it: with a_j = (h_0 + … + h_{j−1})/l, ring j lies at the rest length a_j
L̄ from the cord's start. The cord is measured from the point that does not move along it, at the share θ from the start:
θ = 1 where its end is fastened at the last ring, θ = ½ where both ends go into the drum. So

    c_j = λ d/dt[(θ − a_j) L̄] = λ σ ṡ (θ − a_j) − Σ_{i<j} ḣ_i + a_j l̇,       positive from small to large j,
    N_j/N_{j−1} = exp(μ φ_j γ(c_j/v₀)),     γ(u) = u/√(1 + u²),     v₀ creep speed.

With ρ_i = N_i/N_0 the N_i are fixed by their mean, Σ ν_i h_i = l: ν_i = ρ_i l/Σ h_m ρ_m. The drum feels the tensions
that enter it, ν_d = θ ν_0 + (1 − θ) ν_{p−1}. The power of the N_i beyond that of one tension N is, summed by parts,

    Σ (N_i − N) ḣ_i − σ λ (ν_d − 1) N ṡ = Σ_j (N_j − N_{j−1}) c_j ≥ 0,

so that friction only dissipates; equal pulls along each segment keep both momenta. Segments of different tension
stretch differently, by (N_i − N)/EĀ of their length: this is neglected. The angle is smoothed at zero by φ₀ = √2δ:
φ = arccos((1 − δ) cos) − arccos(1 − δ). The derivatives are, with ∇ with respect to all coordinates,

    ∇ ln ν_i = ∇ ln ρ_i + ∇l/l − Σ_m (ρ_m ∇h_m + h_m ρ_m ∇ ln ρ_m)/Σ h_m ρ_m
    ∇ ln ρ_i = Σ_{0<j≤i} μ (γ ∇φ_j + φ_j γ′ ∇c_j/v₀),       ∇a_j = (Σ_{i<j} ∇h_i − a_j ∇l)/l.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from netdae.core.arrays import FloatArray
from netdae.forces.rings import Cord, Way, add_along

DELTA = 5e-7
"""δ: angles are smoothed at φ₀ = 1e-3 rad, a hundredth of the turn of the cord at each of 60 rings on a loop."""

NO_ANGLE = math.acos(1.0 - DELTA)
"""arccos(1 − δ), of a cord that goes straight on."""

RATIO = 1e-3
"""Share of η below which the direction of a segment is no longer used for an angle."""


@njit(cache=True, forceinline=True)
def turn_at(way: Way, j: int, size: float) -> tuple[float, float, float, float]:
    """cos φ, φ_j and the lengths of d_{j−1} and d_j, not below a share of η, at the ring j."""
    least = RATIO * size
    cosine = square0 = square1 = 0.0
    for a in range(3):
        d0, d1 = way.u[j - 1, a] * way.h[j - 1], way.u[j, a] * way.h[j]
        cosine += d0 * d1
        square0 += d0 * d0
        square1 += d1 * d1
    r0, r1 = np.sqrt(square0 + least * least), np.sqrt(square1 + least * least)
    cosine /= r0 * r1
    return cosine, np.arccos((1.0 - DELTA) * cosine) - NO_ANGLE, r0, r1


@njit(cache=True, forceinline=True)
def sliding_speeds(way: Way, L: float, s_rate: float, cord: Cord) -> FloatArray:
    """c_j (p,) at the rings 1 to p − 1; zero at ring 0."""
    c = np.zeros(len(way.h))
    before = before_rate = 0.0
    for j in range(1, len(c)):
        before += way.h[j - 1]
        before_rate += way.h_rate[j - 1]
        a = before / way.length
        c[j] = way.length / L * cord.share * s_rate * (cord.theta - a) - before_rate + a * way.rate
    return c


@njit(cache=True, forceinline=True)
def tension_shares(way: Way, c: FloatArray, cord: Cord) -> FloatArray:
    """ν_i (p,); 1 without friction."""
    nu = np.ones(len(c))
    if cord.friction == 0.0:
        return nu
    logarithm, total = 0.0, way.h[0]
    for j in range(1, len(c)):
        slip = c[j] / cord.creep_speed
        logarithm += cord.friction * turn_at(way, j, cord.size)[1] * slip / np.sqrt(1.0 + slip * slip)
        nu[j] = np.exp(logarithm)
        total += way.h[j] * nu[j]
    return nu * (way.length / total)


@njit(cache=True, forceinline=True)
def share_gradients(
    way: Way,
    v: FloatArray,
    L: float,
    cord: Cord,
    c: FloatArray,
    nu: FloatArray,
    by_x: FloatArray,
    by_v: FloatArray,
) -> None:
    """∇ ln ν_i by x and by v, each (p, k + 1, 3)."""
    k, p = len(v) - 1, len(nu)
    reeling, stretch = cord.share * v[k, 0], way.length / L
    length_x, rate_x = np.zeros((k + 1, 3)), np.zeros((k + 1, 3))  # ∇l and ∇l̇
    for i in range(p):
        add_along(way, v, i, 1.0, 0.0, length_x)
        add_along(way, v, i, 0.0, 1.0, rate_x)
    before_x, before_rate_x = np.zeros((k + 1, 3)), np.zeros((k + 1, 3))
    mean_x, mean_v = np.zeros((k + 1, 3)), np.zeros((k + 1, 3))  # Σ (ρ ∇h + h ρ ∇ ln ρ) over Σ h ρ
    by_x[:], by_v[:] = 0.0, 0.0
    before = 0.0
    for i in range(p):
        if i > 0:
            a = before / way.length
            cosine, angle, r0, r1 = turn_at(way, i, cord.size)
            slip = c[i] / cord.creep_speed
            root = np.sqrt(1.0 + slip * slip)
            by_cosine = -cord.friction * slip / root * (1.0 - DELTA)
            by_cosine /= np.sqrt(1.0 - ((1.0 - DELTA) * cosine) ** 2)
            by_slide = cord.friction * angle / (cord.creep_speed * root**3)
            by_x[i], by_v[i] = by_x[i - 1], by_v[i - 1]
            for n in range(k):
                for b in range(3):
                    a_x = (before_x[n, b] - a * length_x[n, b]) / way.length
                    slide_x = reeling * ((cord.theta - a) * length_x[n, b] / L - stretch * a_x)
                    slide_x += way.rate * a_x + a * rate_x[n, b] - before_rate_x[n, b]
                    by_x[i, n, b] += by_slide * slide_x
                    by_v[i, n, b] += by_slide * (a * length_x[n, b] - before_x[n, b])
            by_x[i, k, 0] -= by_slide * reeling * (cord.theta - a) * cord.share * stretch / L
            by_v[i, k, 0] += by_slide * stretch * cord.share * (cord.theta - a)
            for b in range(3):
                n0, n1 = way.u[i - 1, b] * way.h[i - 1] / r0, way.u[i, b] * way.h[i] / r1
                turn0, turn1 = by_cosine * (n1 - cosine * n0) / r0, by_cosine * (n0 - cosine * n1) / r1
                by_x[i, i - 1, b] -= turn0
                by_x[i, i, b] += turn0 - turn1
                by_x[i, (i + 1) % k, b] += turn1
        weight = nu[i] / way.length
        for n in range(k + 1):
            for b in range(3):
                mean_x[n, b] += way.h[i] * weight * by_x[i, n, b]
                mean_v[n, b] += way.h[i] * weight * by_v[i, n, b]
        add_along(way, v, i, weight, 0.0, mean_x)
        add_along(way, v, i, 1.0, 0.0, before_x)
        add_along(way, v, i, 0.0, 1.0, before_rate_x)
        before += way.h[i]
    for i in range(p):
        for n in range(k + 1):
            for b in range(3):
                by_x[i, n, b] += length_x[n, b] / way.length - mean_x[n, b]
                by_v[i, n, b] -= mean_v[n, b]
