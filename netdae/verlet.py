"""The compiled velocity Verlet: several steps of the whole net at once, with the books kept at each of them.

Rounding may differ from machine to machine (sums are reordered for speed), but not from run to run.

One step of length h, with the force at the new place and the velocity of its middle:

    v½ = v + h a/2,     x′ = x + h v½,     a′ = f(t′, x′, v½)/M,     v′ = v½ + h a′/2.

Without damping it is symplectic; viscous forces enter by v½, half a step late. With C and K of a mode per unit of
mass it is stable for h² K + 2 h C ≤ 4, which is h ≤ (2/ω)(√(1 + ζ²) − ζ) with K = ω² and C = 2ζω
(T. Belytschko, W. K. Liu, B. Moran, Nonlinear Finite Elements for Continua and Structures, 2000, ch. 6).

Arrays are flat: x, v, a (3n,), node i at 3i. Force and torque about the origin of all that acts from outside stand
together in one row (6,); nodes of reels, which are no places in space, have no part in it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.kernel_cables import (
    FAST,
    Cords,
    Dashpots,
    Drags,
    add_pulls,
    dashpot_loss,
    drag,
    find_near,
    speed_of,
)
from netdae.kernel_reels import Drums, Reels, add_reeled_pulls, hold_drums, local_of, reeled_loss

LOOK = 32  # steps for which the near cables are found; 12 to 96 differ by less than 5 %
LEAST_MARGIN = 1e-4  # of the shortest cable: for a net that begins to move


class Bodies(NamedTuple):
    """What moves."""

    mass: FloatArray  # (3n,), kg
    share: FloatArray  # (3n,), 1/mass, zero on restrained axes
    in_space: BoolArray  # (n,), False for nodes of reels


class Pushes(NamedTuple):
    """Loads: the force weight · signal at each of q nodes, in g groups of one signal each."""

    node: IntArray  # (q,), 3i
    weight: FloatArray  # (q,)
    signal: IntArray  # (q,), which signal
    begin: IntArray  # (g + 1,), where each group begins
    total: FloatArray  # (g,), sum of the weights
    in_space: BoolArray  # (g,)


class Forces(NamedTuple):
    """All that acts."""

    cords: Cords
    drags: Drags
    pushes: Pushes
    reels: Reels
    drums: Drums


class Held(NamedTuple):
    """Restrained axes: entries of x, their anchors, and which component of which motion drives them."""

    entry: IntArray  # (c,)
    anchor: FloatArray  # (c,), m
    motion: IntArray  # (c,)


class Tally(NamedTuple):
    """What a run of steps gave."""

    steps: int  # fewer than asked where a strain passed the limit, or a reel wound in too far
    dissipated: float  # J
    work: float  # J
    impulse: FloatArray  # (6,), N s and N m s
    peak: float  # tension, N
    peak_step: int
    strain: float  # the largest E11


@njit(cache=True, fastmath=FAST)
def fly(
    x: FloatArray,
    v: FloatArray,
    a: FloatArray,
    bodies: Bodies,
    forces: Forces,
    held: Held,
    signals: FloatArray,
    motions: FloatArray,
    h: float,
    steps: int,
    strain_limit: float,
    told: tuple[FloatArray, FloatArray],
) -> Tally:
    """Take `steps` steps of length h, or fewer if a strain passes the limit; x, v, a are changed.

    signals : (steps + 1, s, 3), the signals at the ends of the steps, or (1, s, 3) where all are constant
    motions : (steps + 1, 3, k), u in m, u̇ and ü of each of k driven components at the ends of the steps
    told : (r, 3, 3n) and (r, 10), to be filled with x, v, a after each of the last r of the steps asked for, and with
        dissipated energy, work and impulse up to then, the largest tension at it and that up to then
    """
    cords, drags, pushes, reels, drums = forces
    share, size, (states, sums) = bodies.share, len(x), told
    f, viscous, reeled = np.zeros(size), np.zeros(size), local_of(reels)
    dashpots = Dashpots(np.empty(len(cords.L2), dtype=np.int64), np.empty(len(cords.L2)))
    near = np.empty(len(cords.L2), dtype=np.int64)
    nearby, way, margin = -1, 0.0, 0.0
    least_margin = LEAST_MARGIN * np.sqrt(cords.L2.min()) if len(cords.L2) else 0.0
    dragged = len(drags.ends) > 0 or len(drags.alpha) > 0
    driven, loaded, on_reels = len(held.entry) > 0, len(pushes.node) > 0, len(reels.L) > 0
    dissipated = work = peak = 0.0
    impulse, outside, outside_old = np.zeros(6), np.zeros(6), np.zeros(6)
    peak_step, strain, step, short = 0, -np.inf, 0, False
    p, signal = np.zeros(size), signals[0]
    moments_old, moments = np.zeros((len(pushes.total), 3)), np.zeros((len(pushes.total), 3))
    R_old, x_old = np.zeros(len(held.entry)), np.zeros(len(held.entry))
    if loaded:
        _push(pushes, signal, p)
        _find_moments(x, pushes, moments_old)
        _add_loads(pushes, moments_old, signal, outside_old)
    if driven:
        add_pulls(x, v, cords, near, find_near(x, cords, 0.0, near), f, dashpots)
        if dragged:
            drag(v, drags, viscous)
        if on_reels:
            add_reeled_pulls(x, v, reels, f, reeled)
        for i in range(size):
            f[i] += viscous[i] + p[i]
        hold_drums(x, v, share, f, 0.0, drums)
        for c in range(len(held.entry)):
            i = held.entry[c]
            R_old[c] = bodies.mass[i] * a[i] - f[i]
            _add_force(x, i // 3, i % 3, R_old[c], bodies.in_space, outside_old)
    for i in range(size):
        v[i] += 0.5 * h * a[i]
        f[i] = 0.0
    while step < steps and strain <= strain_limit and not short:
        step += 1
        for c in range(len(held.entry)):
            x_old[c] = x[held.entry[c]]
        # v is the middle velocity: the half kick of the former step and that of this one, and the drift, in one pass
        for i in range(size):
            v[i] += h * share[i] * f[i]
            x[i] += h * v[i]
            f[i] = 0.0
        moved = h * speed_of(v)
        for c in range(len(held.entry)):
            i, k = held.entry[c], held.motion[c]
            x[i] = held.anchor[c] + motions[step, 0, k]
            v[i] = 0.5 * (motions[step - 1, 1, k] + motions[step, 1, k])
            moved = max(moved, abs(x[i] - x_old[c]))
        parted = 2.0 * np.sqrt(3.0) * moved
        way += parted
        if nearby < 0 or not way <= margin:
            margin, way = max(LOOK * parted, least_margin), 0.0
            nearby = find_near(x, cords, 1.01 * margin, near)  # 1 % for round-off
        count, tension, stretched = add_pulls(x, v, cords, near, nearby, f, dashpots)
        if dragged:
            drag(v, drags, viscous)
            for i in range(size):
                f[i] += viscous[i]
        if on_reels:
            pull, longest, short = add_reeled_pulls(x, v, reels, f, reeled)
            tension, stretched = max(tension, pull), max(stretched, longest)
        strain = max(strain, stretched)
        if tension > peak:
            peak, peak_step = tension, step
        if loaded:
            signal_old = signal
            if len(signals) > 1:
                signal = signals[step]
                _push(pushes, signal, p)
            for i in range(size):
                f[i] += p[i]
            _find_moments(x, pushes, moments)
            _add_loads(pushes, moments, signal, outside)
            for g in range(len(pushes.total)):
                s = pushes.signal[pushes.begin[g]]
                for c in range(3):
                    mean = 0.5 * (signal_old[s, c] + signal[s, c])
                    work += mean * (moments[g, c] - moments_old[g, c])
                    moments_old[g, c] = moments[g, c]
        dissipated += hold_drums(x, v, share, f, h, drums)
        # a viscous force of this instant acts over half a step before and after it: on the mean, v½ + h a/2
        dissipated += dashpot_loss(x, v, share, f, h, cords, count, dashpots)
        if on_reels:
            dissipated += reeled_loss(v, share, f, h, reels, reeled)
        if dragged:
            for i in range(size):
                dissipated -= h * viscous[i] * (v[i] + 0.5 * h * share[i] * f[i])
            for n in range(len(drags.alpha) // 3):
                for c in range(3):
                    _add_force(x, n, c, -h * drags.alpha[3 * n + c] * v[3 * n + c], bodies.in_space, impulse)
        for c in range(len(held.entry)):
            i = held.entry[c]
            R = bodies.mass[i] * motions[step, 2, held.motion[c]] - f[i]
            work += 0.5 * (R_old[c] + R) * (x[i] - x_old[c])
            _add_force(x, i // 3, i % 3, R, bodies.in_space, outside)
            R_old[c] = R
        if loaded or driven:
            for k in range(6):
                impulse[k] += 0.5 * h * (outside_old[k] + outside[k])
                outside_old[k], outside[k] = outside[k], 0.0
        row = step - 1 - steps + len(states)
        if row >= 0:
            now, total = states[row], sums[row]
            for i in range(size):
                now[0, i] = x[i]
            _end_step(now[1], now[2], v, f, share, h, held, motions[step])
            total[0], total[1], total[8], total[9] = dissipated, work, tension, peak
            for k in range(6):
                total[2 + k] = impulse[k]
    _end_step(v, a, v, f, share, h, held, motions[step])
    return Tally(step, dissipated, work, impulse, peak, peak_step, strain)


@njit(cache=True, fastmath=FAST)
def _end_step(
    v: FloatArray,
    a: FloatArray,
    middle: FloatArray,
    f: FloatArray,
    share: FloatArray,
    h: float,
    held: Held,
    motion: FloatArray,
) -> None:
    """Velocities and accelerations at the end of a step, from its middle velocity and its forces."""
    for i in range(len(f)):
        a[i] = share[i] * f[i]
        v[i] = middle[i] + 0.5 * h * a[i]
    for c in range(len(held.entry)):
        i, k = held.entry[c], held.motion[c]
        v[i], a[i] = motion[1, k], motion[2, k]


@njit(cache=True, fastmath=FAST)
def _push(pushes: Pushes, signal: FloatArray, p: FloatArray) -> None:
    """The loads' forces p (3n,)."""
    for i in range(len(p)):
        p[i] = 0.0
    for q in range(len(pushes.node)):
        for c in range(3):
            p[pushes.node[q] + c] += pushes.weight[q] * signal[pushes.signal[q], c]


@njit(cache=True, fastmath=FAST)
def _find_moments(x: FloatArray, pushes: Pushes, moments: FloatArray) -> None:
    """Moments (g, 3), Σ weight · x of each group: what work and torque of its loads depend on."""
    for g in range(len(pushes.total)):
        mx = my = mz = 0.0
        for q in range(pushes.begin[g], pushes.begin[g + 1]):
            i, w = pushes.node[q], pushes.weight[q]
            mx += w * x[i]
            my += w * x[i + 1]
            mz += w * x[i + 2]
        moments[g, 0], moments[g, 1], moments[g, 2] = mx, my, mz


@njit(cache=True, fastmath=FAST)
def _add_loads(pushes: Pushes, moments: FloatArray, signal: FloatArray, row: FloatArray) -> None:
    """Row (6,) gains the forces of all loads and their torques about the origin."""
    for g in range(len(pushes.total)):
        if pushes.in_space[g]:
            s = signal[pushes.signal[pushes.begin[g]]]
            for c in range(3):
                row[c] += pushes.total[g] * s[c]
                row[3 + c] += (
                    moments[g, (c + 1) % 3] * s[(c + 2) % 3] - moments[g, (c + 2) % 3] * s[(c + 1) % 3]
                )


@njit(cache=True, fastmath=FAST)
def _add_force(x: FloatArray, node: int, c: int, F: float, in_space: BoolArray, row: FloatArray) -> None:
    """Row (6,) gains a force F along the axis c on a node, and its torque."""
    if in_space[node]:
        row[c] += F
        row[3 + (c + 1) % 3] += x[3 * node + (c + 2) % 3] * F
        row[3 + (c + 2) % 3] -= x[3 * node + (c + 1) % 3] * F
