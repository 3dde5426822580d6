"""The compiled velocity Verlet: several steps of the whole net at once, with the books kept at each of them.

Rounding may differ from machine to machine (sums are reordered for speed), but not from run to run.

One step of length h, with the force at the new place and the velocity of its middle:

    v½ = v + h a/2,     x′ = x + h v½,     a′ = f(t′, x′, v½)/M,     v′ = v½ + h a′/2.

Without damping it is symplectic; viscous forces enter by v½, half a step late. With C and K of a mode per unit of
mass it is stable for h² K + 2 h C ≤ 4, which is h ≤ (2/ω)(√(1 + ζ²) − ζ) with K = ω² and C = 2ζω
(T. Belytschko, W. K. Liu, B. Moran, Nonlinear Finite Elements for Continua and Structures, 2000, ch. 6).

Arrays are flat: x, v, a (3n,), node i at 3i. Cables: ends (m, 2) as 3i and 3j; see `forces.cables` for the law.
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

    ends: IntArray  # (m, 2)
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


class Pushes(NamedTuple):
    """Loads: force weight · signal at a node, for each of q entries."""

    node: IntArray  # (q,), 3i
    weight: FloatArray  # (q,)
    signal: IntArray  # (q,), which signal


class Held(NamedTuple):
    """Restrained axes: entries of x, their anchors, and which component of which motion drives them."""

    entry: IntArray  # (c,)
    anchor: FloatArray  # (c,), m
    motion: IntArray  # (c,)


class Tally(NamedTuple):
    """What a run of steps gave."""

    steps: int  # fewer than asked where a strain passed the limit
    dissipated: float  # J
    work: float  # J
    px: float  # impulse, N s
    py: float
    pz: float
    peak: float  # tension, N
    peak_step: int
    strain: float  # the largest E11


@njit(cache=True, fastmath=FAST)
def fly(
    x: FloatArray,
    v: FloatArray,
    a: FloatArray,
    mass: FloatArray,
    share: FloatArray,
    cords: Cords,
    drags: Drags,
    pushes: Pushes,
    held: Held,
    signals: FloatArray,
    motions: FloatArray,
    h: float,
    steps: int,
    strain_limit: float,
) -> Tally:
    """Take `steps` steps of length h, or fewer if a strain passes the limit; x, v, a are changed.

    mass : (3n,), kg; share : (3n,), 1/mass, zero on restrained axes
    signals : (steps + 1, s, 3), the signals at the ends of the steps, or (1, s, 3) where all are constant
    motions : (steps + 1, 3, k), u in m, u̇ and ü of each of k driven components at the ends of the steps
    """
    size = len(x)
    f, viscous = np.zeros(size), np.zeros(size)
    damped, damping = np.empty(len(cords.L2), dtype=np.int64), np.empty(len(cords.L2))
    dragged = len(drags.ends) > 0 or len(drags.alpha) > 0
    driven = len(held.entry) > 0
    loaded = len(pushes.node) > 0
    p_old, R_old = np.zeros(size), np.zeros(len(held.entry))
    dissipated = work = peak = 0.0
    impulse = np.zeros(3)
    peak_step, strain, step = 0, -np.inf, 0
    _push(pushes, signals[0], p_old)
    p = p_old.copy()
    x_old = x.copy()
    if driven:
        _forces(x, v, cords, drags, f, viscous, damped, damping)
        for c in range(len(held.entry)):
            i = held.entry[c]
            R_old[c] = mass[i] * a[i] - f[i] - p_old[i]
    for i in range(size):
        v[i] += 0.5 * h * a[i]
        f[i] = 0.0
    while step < steps and strain <= strain_limit:
        step += 1
        if loaded or driven:
            x_old[:] = x
        # v is the middle velocity: the half kick of the former step and that of this one, and the drift, in one pass
        for i in range(size):
            v[i] += h * share[i] * f[i]
            x[i] += h * v[i]
            f[i] = 0.0
        for c in range(len(held.entry)):
            i, k = held.entry[c], held.motion[c]
            x[i] = held.anchor[c] + motions[step, 0, k]
            v[i] = 0.5 * (motions[step - 1, 1, k] + motions[step, 1, k])
        count, tension, stretched = _forces(x, v, cords, drags, f, viscous, damped, damping)
        strain = max(strain, stretched)
        if tension > peak:
            peak, peak_step = tension, step
        if loaded:
            if len(signals) > 1:
                _push(pushes, signals[step], p)
            for i in range(size):
                f[i] += p[i]
                work += 0.5 * (p_old[i] + p[i]) * (x[i] - x_old[i])
                impulse[i % 3] += 0.5 * h * (p_old[i] + p[i])
            if len(signals) > 1:
                p_old[:] = p
        # the viscous force of this instant acts over half a step before and after it: on the mean, v½ + h a/2
        for k in range(count):
            i, j = cords.ends[damped[k], 0], cords.ends[damped[k], 1]
            rate = 0.0
            for c in range(3):
                w = v[j + c] - v[i + c] + 0.5 * h * (share[j + c] * f[j + c] - share[i + c] * f[i + c])
                rate += (x[j + c] - x[i + c]) * w
            dissipated += h * damping[k] * rate
        if dragged:
            for i in range(size):
                dissipated -= h * viscous[i] * (v[i] + 0.5 * h * share[i] * f[i])
            for i in range(len(drags.alpha)):
                impulse[i % 3] -= h * drags.alpha[i] * v[i]
        for c in range(len(held.entry)):
            i = held.entry[c]
            R = mass[i] * motions[step, 2, held.motion[c]] - f[i]
            work += 0.5 * (R_old[c] + R) * (x[i] - x_old[i])
            impulse[i % 3] += 0.5 * h * (R_old[c] + R)
            R_old[c] = R
    for i in range(size):
        a[i] = share[i] * f[i]
        v[i] += 0.5 * h * a[i]
    for c in range(len(held.entry)):
        i, k = held.entry[c], held.motion[c]
        v[i], a[i] = motions[step, 1, k], motions[step, 2, k]
    return Tally(step, dissipated, work, impulse[0], impulse[1], impulse[2], peak, peak_step, strain)


@njit(cache=True, fastmath=FAST)
def _push(pushes: Pushes, signal: FloatArray, p: FloatArray) -> None:
    p[:] = 0.0
    for q in range(len(pushes.node)):
        for c in range(3):
            p[pushes.node[q] + c] += pushes.weight[q] * signal[pushes.signal[q], c]


@njit(cache=True, fastmath=FAST)
def _forces(
    x: FloatArray,
    v: FloatArray,
    cords: Cords,
    drags: Drags,
    f: FloatArray,
    viscous: FloatArray,
    damped: IntArray,
    damping: FloatArray,
) -> tuple[int, float, float]:
    """Forces of cables and Rayleigh damping added to f, the latter alone into viscous; largest tension and strain.

    The first number counts the cables whose dashpot acts: they stand in damped, their share of q in damping.
    """
    count = 0
    peak2 = 0.0
    strain = -np.inf
    ends, L2, half, plain = cords.ends, cords.L2, cords.half, cords.plain
    for e in range(len(L2)):
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
            L = np.sqrt(L2[e])
            elastic = g * cords.EA[e] / L
            damper = cords.viscous[e] * dg * rate
        q = max(elastic + damper, 0.0)
        if damper != 0.0:
            damped[count], damping[count] = e, q - elastic
            count += 1
        strain = max(strain, E11)
        peak2 = max(peak2, elastic * elastic * l2)
        f[i] += q * dx
        f[i + 1] += q * dy
        f[i + 2] += q * dz
        f[j] -= q * dx
        f[j + 1] -= q * dy
        f[j + 2] -= q * dz
    if len(drags.ends) > 0 or len(drags.alpha) > 0:
        _drag(v, drags, viscous)
        for i in range(len(f)):
            f[i] += viscous[i]
    return count, np.sqrt(peak2), strain


@njit(cache=True, fastmath=FAST)
def _drag(v: FloatArray, drags: Drags, viscous: FloatArray) -> None:
    """Forces of Rayleigh damping, Eq. (9)."""
    viscous[:] = 0.0
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
