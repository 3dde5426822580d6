"""The compiled velocity Verlet: several steps of the whole net at once, with the books kept at each of them.

Rounding may differ from machine to machine (sums are reordered for speed), but not from run to run.

One step of length h, with the force at the new place and the velocity of its middle:

    v½ = v + h a/2,     x′ = x + h v½,     a′ = f(t′, x′, v½)/M,     v′ = v½ + h a′/2.

Without damping it is symplectic; dashpots enter by v½, half a step late. With C and K of a mode per unit of mass it is
stable for h² K + 2 h C ≤ 4, which is h ≤ (2/ω)(√(1 + ζ²) − ζ) with K = ω² and C = 2ζω (T. Belytschko, W. K. Liu,
B. Moran, Nonlinear Finite Elements for Continua and Structures, 2000, ch. 6). Rayleigh damping is taken at v′ and is no
bound, see `kernels.rayleigh`.

Arrays are flat: x, v, a (3n,), node i at 3i. Force and torque about the origin of all that acts from outside stand
together in one row (6,); nodes of reels, which are no places in space, have no part in it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.kernels.cables import (
    FAST,
    Cords,
    Dashpots,
    Drags,
    add_pulls,
    dashpot_power,
    find_near,
    speed_of,
)
from netdae.kernels.cordage import Cordage, add_cord_pulls, cord_power, friction_rate
from netdae.kernels.loads import Pushes, add_force, add_loads, find_moments, push
from netdae.kernels.rayleigh import Solver, damp, drag_all
from netdae.kernels.reels import Drums, Reels, add_reeled_pulls, hold_drums, local_of, reeled_power
from netdae.kernels.strings import string_room_of

LOOK = 32  # steps for which the near cables are found; 12 to 96 differ by less than 5 %
LEAST_MARGIN = 1e-4  # of the shortest cable: for a net that begins to move


class Bodies(NamedTuple):
    """What moves."""

    mass: FloatArray  # (3n,), kg
    share: FloatArray  # (3n,), 1/mass, zero on restrained axes
    in_space: BoolArray  # (n,), False for nodes of reels


class Forces(NamedTuple):
    """All that acts."""

    cords: Cords
    drags: Drags
    pushes: Pushes
    reels: Reels
    drums: Drums
    cordage: Cordage


class Held(NamedTuple):
    """Restrained axes: entries of x, their anchors, and which component of which motion drives them."""

    entry: IntArray  # (c,)
    anchor: FloatArray  # (c,), m
    motion: IntArray  # (c,)


class Tally(NamedTuple):
    """What a run of steps gave."""

    steps: int  # fewer than asked where a limit was passed, or a reel wound in too far
    dissipated: float  # J
    work: float  # J
    impulse: FloatArray  # (6,), N s and N m s
    peak: float  # tension, N
    peak_step: int
    strain: float  # the largest E11
    rate: float  # the largest of friction, 1/s


@njit(cache=True, fastmath=FAST)
def fly(
    x: FloatArray,
    v: FloatArray,
    a: FloatArray,
    bodies: Bodies,
    forces: Forces,
    held: Held,
    solver: Solver,
    signals: FloatArray,
    motions: FloatArray,
    h: float,
    steps: int,
    limits: tuple[float, float],
    fresh: bool,
    powers: FloatArray,
    told: tuple[FloatArray, FloatArray],
) -> Tally:
    """Take `steps` steps of length h, or fewer if strain or friction pass their limits; x, v, a are changed.

    solver : of Rayleigh damping for this h
    fresh : whether the flight begins here; else a holds the damping of the steps before
    powers : (2,), W, what dampers and brakes took and motors gave in the step before; those of the last step at the end
    limits : of strain, and of the rate of friction in 1/s, see `kernels.cordage`
    signals : (steps + 1, s, 3), the signals at the ends of the steps, or (1, s, 3) where all are constant
    motions : (steps + 1, 3, k), u in m, u̇ and ü of each of k driven components at the ends of the steps
    told : (r, 3, 3n) and (r, 10), to be filled with x, v, a after each of the last r of the steps asked for, and with
        dissipated energy, work and impulse up to then, the largest tension at it and that up to then
    """
    cords, drags, pushes, reels, drums, cordage = forces
    share, size, (states, sums) = bodies.share, len(x), told
    f, viscous, reeled = np.zeros(size), np.zeros(size), local_of(reels)
    stringed, elastic = string_room_of(cordage.strings), string_room_of(cordage.elastic)
    dashpots = Dashpots(np.empty(len(cords.L2), dtype=np.int64), np.empty(len(cords.L2)))
    near = np.empty(len(cords.L2), dtype=np.int64)
    nearby, way, margin = -1, 0.0, 0.0
    least_margin = LEAST_MARGIN * np.sqrt(cords.L2.min()) if len(cords.L2) else 0.0
    dragged, braked = len(drags.ends) > 0 or len(drags.alpha) > 0, len(drags.alpha) > 0
    driven, loaded, on_reels = len(held.entry) > 0, len(pushes.node) > 0, len(reels.L) > 0
    strung, rubs, rate = len(cordage.least) > 0, (cordage.strings.friction > 0.0).any(), 0.0
    peak = 0.0
    impulse, outside, outside_old = np.zeros(6), np.zeros(6), np.zeros(6)
    peak_step, strain, step, short = 0, -np.inf, 0, False
    p, signal = np.zeros(size), signals[0]
    moments_old, moments = np.zeros((len(pushes.total), 3)), np.zeros((len(pushes.total), 3))
    R_old, x_old, speed = np.zeros(len(held.entry)), np.zeros(len(held.entry)), np.zeros(len(held.entry))
    now = np.zeros(size) if dragged else v  # the velocity at which Rayleigh damping is taken
    if loaded:
        push(pushes, signal, p)
        find_moments(x, pushes, moments_old)
        add_loads(pushes, moments_old, signal, outside_old)
    now_old = v
    if fresh:
        powers[:] = 0.0
    if driven or fresh:
        add_pulls(x, v, cords, near, find_near(x, cords, 0.0, near), f, dashpots)
        if on_reels:
            add_reeled_pulls(x, v, reels, f, reeled)
        if strung:
            add_cord_pulls(x, v, cordage, f, stringed)
        for i in range(size):
            f[i] += p[i]
        lost, given = hold_drums(x, v, share, f, 0.5 * h if fresh else 0.0, drums)
        if fresh:
            powers[0], powers[1] = lost, given
        if dragged:
            if fresh:
                for c in range(len(held.entry)):
                    speed[c] = motions[0, 1, held.motion[c]]
                damp(v, bodies.mass, f, h, solver, held.entry, speed, now, viscous)
                now_old = now
            else:
                drag_all(v, solver, viscous)
            for i in range(size):
                f[i] += viscous[i]
                if fresh:
                    powers[0] -= 0.5 * viscous[i] * (v[i] + now[i])
        if fresh and (
            dragged or len(drums.entry) > 0
        ):  # what is stiff takes the velocity after this half step
            for i in range(size):
                a[i] = share[i] * f[i] if share[i] > 0.0 else a[i]
        for c in range(len(held.entry)):
            i = held.entry[c]
            R_old[c] = bodies.mass[i] * a[i] - f[i]
            add_force(x, i // 3, i % 3, R_old[c], bodies.in_space, outside_old)
    if braked:
        _add_brakes(x, now_old, drags.alpha, bodies.in_space, outside_old)
    # what acts at an instant does so half a step before it and half a step after it
    dissipated, work = 0.5 * h * powers[0], 0.5 * h * powers[1]
    for i in range(size):
        v[i] += 0.5 * h * a[i]
        f[i] = 0.0
    while step < steps and strain <= limits[0] and rate <= limits[1] and not short:
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
        if on_reels:
            pull, longest, short = add_reeled_pulls(x, v, reels, f, reeled)
            tension, stretched = max(tension, pull), max(stretched, longest)
        if strung:
            pull, longest, too_short = add_cord_pulls(x, v, cordage, f, stringed)
            tension, stretched, short = max(tension, pull), max(stretched, longest), short or too_short
            if rubs:
                rate = max(rate, friction_rate(cordage, share, stringed))
        strain = max(strain, stretched)
        if tension > peak:
            peak, peak_step = tension, step
        if loaded:
            signal_old = signal
            if len(signals) > 1:
                signal = signals[step]
                push(pushes, signal, p)
            for i in range(size):
                f[i] += p[i]
            find_moments(x, pushes, moments)
            add_loads(pushes, moments, signal, outside)
            for g in range(len(pushes.total)):
                s = pushes.signal[pushes.begin[g]]
                for c in range(3):
                    mean = 0.5 * (signal_old[s, c] + signal[s, c])
                    work += mean * (moments[g, c] - moments_old[g, c])
                    moments_old[g, c] = moments[g, c]
        powers[0], powers[1] = hold_drums(x, v, share, f, h, drums)
        if dragged:
            for c in range(len(held.entry)):
                speed[c] = motions[step, 1, held.motion[c]]
            damp(v, bodies.mass, f, h, solver, held.entry, speed, now, viscous)
            power = 0.0
            for i in range(size):
                f[i] += viscous[i]
                power -= viscous[i] * now[i]
            powers[0] += power
            if braked:
                _add_brakes(x, now, drags.alpha, bodies.in_space, outside)
        # on the mean velocity of the steps before and after it, v½ + h a/2
        powers[0] += dashpot_power(x, v, share, f, h, cords, count, dashpots)
        if on_reels:
            powers[0] += reeled_power(v, share, f, h, reels, reeled)
        if strung:
            powers[0] += cord_power(x, v, share, f, h, cordage, stringed, elastic)
        dissipated += h * powers[0]
        work += h * powers[1]
        for c in range(len(held.entry)):
            i = held.entry[c]
            R = bodies.mass[i] * motions[step, 2, held.motion[c]] - f[i]
            work += 0.5 * (R_old[c] + R) * (x[i] - x_old[c])
            add_force(x, i // 3, i % 3, R, bodies.in_space, outside)
            R_old[c] = R
        if loaded or driven or braked:
            for k in range(6):
                impulse[k] += 0.5 * h * (outside_old[k] + outside[k])
                outside_old[k], outside[k] = outside[k], 0.0
        row = step - 1 - steps + len(states)
        if row >= 0:
            state, total = states[row], sums[row]
            for i in range(size):
                state[0, i] = x[i]
            _end_step(state[1], state[2], v, f, share, h, held, motions[step])
            total[0], total[1] = dissipated - 0.5 * h * powers[0], work - 0.5 * h * powers[1]
            total[8], total[9] = tension, peak
            for k in range(6):
                total[2 + k] = impulse[k]
    _end_step(v, a, v, f, share, h, held, motions[step])
    dissipated -= 0.5 * h * powers[0]
    return Tally(step, dissipated, work - 0.5 * h * powers[1], impulse, peak, peak_step, strain, rate)


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
def _add_brakes(
    x: FloatArray, v: FloatArray, alpha: FloatArray, in_space: BoolArray, row: FloatArray
) -> None:
    """Row (6,) gains the forces of α M on all nodes, which come from outside, and their torques."""
    for i in range(len(v)):
        add_force(x, i // 3, i % 3, -alpha[i] * v[i], in_space, row)
