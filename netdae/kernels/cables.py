"""Cables and Rayleigh damping for the kernels of `explicit.verlet` and `ida.kernel`: flat arrays, node i at 3i.

Most cables of a net in flight are slack and far from taut. No two nodes part faster than 2√3 times the largest
component of all velocities, so that a cable which lacks a margin to be taut stays slack until they have parted by so
much: the forces run over the near cables only, and to the last bit give what they would give over all.

Symbols as in `forces.cables`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.forces.cables import law_of

FAST = {"reassoc", "contract", "arcp", "nsz"}  # but not-a-number and infinity keep their meaning


class Cords(NamedTuple):
    """Cables for the kernel, (m,) but for `ends`."""

    ends: IntArray  # (m, 2), 3i and 3j
    L2: FloatArray  # L̄², m²
    half: FloatArray  # EĀ/(2 L̄³), N/m³: q of the sharp law over l² − L̄²
    viscous: FloatArray  # τ EĀ/L̄³, N s/m³: q of its dashpot over d·w
    EA: FloatArray  # N
    eps: FloatArray
    engineering: BoolArray
    tau: FloatArray  # s
    plain: bool  # all cables follow Eq. (4) without a toe


class Drags(NamedTuple):
    """Rayleigh damping: none where `ends` and `alpha` are empty."""

    ends: IntArray  # (p, 2)
    viscosity: FloatArray  # (p, 6), upper triangle of β (EĀ/L̄) nnᵀ by rows, N s/m
    alpha: FloatArray  # (3n,) α M, kg/s, or (0,)


class Dashpots(NamedTuple):
    """Those dashpots that act in a step, up to a number that is told beside: cables, and their share of q."""

    cables: IntArray  # (m,)
    q: FloatArray  # (m,), N/m


@njit(cache=True, fastmath=FAST)
def speed_of(v: FloatArray) -> float:
    """Largest |v| of all entries: without sign, floats order as their bits do, which processors compare at once."""
    bits = v.view(np.int64)
    top = np.int64(0)
    for i in range(len(bits)):
        top = max(top, bits[i] & 0x7FFFFFFFFFFFFFFF)
    return np.int64(top).view(np.float64)


@njit(cache=True, fastmath=FAST)
def find_near(x: FloatArray, cords: Cords, margin: float, near: IntArray) -> int:
    """Put the cables that lack `margin` in m or less to be taut into near (m,); how many they are.

    Those without stiffness, which are on reels, are none of them.
    """
    count = 0
    for e in range(len(cords.L2)):
        i, j = cords.ends[e, 0], cords.ends[e, 1]
        dx, dy, dz = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
        reach = np.sqrt(dx * dx + dy * dy + dz * dz) + margin
        near[count] = e
        count += cords.EA[e] > 0.0 and not reach * reach < cords.L2[e]  # counts not-a-number
    return count


@njit(cache=True, fastmath=FAST)
def add_pulls(
    x: FloatArray, v: FloatArray, cords: Cords, near: IntArray, nearby: int, f: FloatArray, dashpots: Dashpots
) -> tuple[int, float, float]:
    """Add the pulls of the first `nearby` cables in near to f; how many dashpots act, largest tension and strain."""
    count = 0
    peak2 = 0.0
    strain = -np.inf
    ends, L2, half, plain = cords.ends, cords.L2, cords.half, cords.plain
    for k in range(nearby):
        e = near[k]
        i, j = ends[e, 0], ends[e, 1]
        dx, dy, dz = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
        l2 = dx * dx + dy * dy + dz * dz
        excess = l2 - L2[e]
        if excess < 0.0:
            continue
        rate = dx * (v[j] - v[i]) + dy * (v[j + 1] - v[i + 1]) + dz * (v[j + 2] - v[i + 2])
        E11 = 0.5 * excess / L2[e]
        if plain:
            elastic = half[e] * excess
            damper = cords.viscous[e] * rate
        else:
            g, dg, _, _ = law_of(E11, cords.eps[e], cords.engineering[e])
            elastic = g * cords.EA[e] / np.sqrt(L2[e])
            damper = cords.viscous[e] * dg * rate
        q = max(elastic + damper, 0.0)
        if damper != 0.0:
            dashpots.cables[count], dashpots.q[count] = e, q - elastic
            count += 1
        strain = max(strain, E11)
        peak2 = max(peak2, elastic * elastic * l2)
        f[i] += q * dx
        f[i + 1] += q * dy
        f[i + 2] += q * dz
        f[j] -= q * dx
        f[j + 1] -= q * dy
        f[j + 2] -= q * dz
    return count, np.sqrt(peak2), strain


@njit(cache=True, fastmath=FAST)
def dashpot_power(
    x: FloatArray,
    v: FloatArray,
    share: FloatArray,
    f: FloatArray,
    h: float,
    cords: Cords,
    count: int,
    dashpots: Dashpots,
) -> float:
    """Power in W that the first `count` dashpots take in a step."""
    lost = 0.0
    for k in range(count):
        i, j = cords.ends[dashpots.cables[k], 0], cords.ends[dashpots.cables[k], 1]
        rate = 0.0
        for c in range(3):
            w = v[j + c] - v[i + c] + 0.5 * h * (share[j + c] * f[j + c] - share[i + c] * f[i + c])
            rate += (x[j + c] - x[i + c]) * w
        lost += dashpots.q[k] * rate
    return lost


@njit(cache=True, fastmath=FAST)
def drag(v: FloatArray, drags: Drags, viscous: FloatArray) -> None:
    """Forces of Rayleigh damping, Eq. (9), into viscous (3n,)."""
    for i in range(len(viscous)):
        viscous[i] = 0.0
    for e in range(len(drags.ends)):
        i, j = drags.ends[e, 0], drags.ends[e, 1]
        wx, wy, wz = v[j] - v[i], v[j + 1] - v[i + 1], v[j + 2] - v[i + 2]
        V = drags.viscosity[e]
        fx = V[0] * wx + V[1] * wy + V[2] * wz
        fy = V[1] * wx + V[3] * wy + V[4] * wz
        fz = V[2] * wx + V[4] * wy + V[5] * wz
        viscous[i] += fx
        viscous[i + 1] += fy
        viscous[i + 2] += fz
        viscous[j] -= fx
        viscous[j + 1] -= fy
        viscous[j + 2] -= fz
    if len(drags.alpha):
        for i in range(len(v)):
            viscous[i] -= drags.alpha[i] * v[i]
