"""The compiled velocity Verlet: several steps of the whole net at once, with the balance kept at each of them.

Rounding may differ from machine to machine (sums are reordered for speed), but not from run to run.

One step of length h, with the force at the new position and the mid-step velocity:

    v½ = v + h a/2,     x′ = x + h v½,     a′ = f(t′, x′, v½)/M,     v′ = v½ + h a′/2.

Without damping it is symplectic; dashpots enter by v½, half a step late. With C and K of a mode per unit mass it is
stable for h² K + 2 h C ≤ 4, which is h ≤ (2/ω)(√(1 + ζ²) − ζ) with K = ω² and C = 2ζω (T. Belytschko, W. K. Liu,
B. Moran, Nonlinear Finite Elements for Continua and Structures, 2000, ch. 6). Rayleigh damping is taken at v′ and does
not bound the step, see `explicit.rayleigh`.

Arrays are flat: x, v, a (3n,), node i at 3i. External force and torque about the origin stand together in one row
(6,); nodes of reels, which are not places in space, have no part in it.

All forces act in each step, through the table of forces. External ones that depend on positions and velocities alone,
such as gravity, orbit and still air, change little in a few steps: they are evaluated once for `hold` steps, at the
position and velocity that each node has in their middle by its velocity and acceleration, and act with that value in
each of them. The power of a dissipative or external share is taken with the mean velocity of the steps before and after
the instant, v½ + h a/2: with it the kinetic energy of leapfrog balances exactly.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from netdae.core.arrays import BoolArray, Flags, FloatArray, Reals, Wholes
from netdae.core.records import load
from netdae.forces.law import FAST
from netdae.forces.loops import DISSIPATED, EXTERNAL, FORCE, STRAIN, SUMS, TENSION
from netdae.forces.table import Rows, add_forces, add_powers, friction_rate, rests, set_time, sift
from netdae.solvers.explicit.drums import Drums, hold_drums
from netdae.solvers.explicit.rayleigh import Solver, damp, drag_all

INLINED: dict[str, Any] = {
    "cache": True,
    "fastmath": FAST,
    "forceinline": True,  # otherwise each array counts its references at each call
}
LOOK = 32  # steps for which the near elements are found; 12 to 96 differ by less than 5 %
LEAST_MARGIN = 1e-4  # of the shortest cable: for a net that begins to move
OUTSIDE = 2  # where external force and torque begin in `powers`
POWERS = OUTSIDE + 6


class Bodies(NamedTuple):
    """What moves."""

    mass: Reals  # (3n,), kg
    share: Reals  # (3n,), 1/mass, zero on restrained axes
    in_space: Flags  # (n,), False for nodes of reels
    shortest: float  # m, of the cables


class Acting(NamedTuple):
    """What acts: the table's forces, and those that are taken at the end of the step."""

    rows: int  # address of the table's
    drums: int  # address of the Drums
    taken: Reals  # (3n,), room for dissipative shares, or (0,) where there are none
    given: Reals  # (3n,), room for external shares, or (0,)
    slow_rows: int  # address of those of the forces that are held for some steps
    slow: Reals  # (3n,), room for their sum, or (0,) where there are none
    slow_x: Reals  # (3n,) or (0,), room for places and velocities in their middle
    slow_v: Reals
    ahead: Reals  # (3n,), room for velocities at the end of the step where a force needs them, or (0,)
    in_python: bool  # whether any force is written in Python
    rubs: bool  # whether friction bounds the step


class Held(NamedTuple):
    """Restrained axes: entries of x, their anchors, and which component of which motion drives them."""

    entry: Wholes  # (c,)
    anchor: Reals  # (c,), m
    motion: Wholes  # (c,)


class Tally(NamedTuple):
    """The result of a run of steps."""

    steps: int  # fewer than requested where a limit was passed, a reel wound in too far, or a force in Python failed
    dissipated: float  # J
    work: float  # J
    impulse: FloatArray  # (6,), N s and N m s
    peak: float  # tension, N
    peak_step: int
    strain: float  # the largest E11
    rate: float  # the largest rate of friction, 1/s


@njit(**INLINED)
def speed_of(v: FloatArray) -> float:
    """Largest |v| of all entries: without sign, floats order as their bits do, which processors compare at once."""
    bits = v.view(np.int64)
    top = np.int64(0)
    for i in range(len(bits)):
        top = max(top, bits[i] & 0x7FFFFFFFFFFFFFFF)
    return np.int64(top).view(np.float64)


@njit(**INLINED)
def _evaluate(
    t: float,
    x: FloatArray,
    v: FloatArray,
    ahead: FloatArray,
    acting: Acting,
    f: FloatArray,
    sums: FloatArray,
) -> None:
    """Add the forces of the table at t to f, their shares to `taken` and `given`, and all else to sums."""
    sums[:] = 0.0
    sums[STRAIN] = -np.inf
    taken, given = acting.taken, acting.given
    rows = load(acting.rows, Rows)
    set_time(rows, t)
    of_taken, of_given = np.int64(0), np.int64(0)
    if len(taken):
        of_taken = np.int64(taken.ctypes.data)
    if len(given):
        of_given = np.int64(given.ctypes.data)
    add_forces(rows, x, v, ahead, f, of_taken, of_given, sums)
    if acting.in_python:
        add_powers(rows, x, ahead, sums)


@njit(cache=True, fastmath=FAST)
def _look_at_slow(
    t: float,
    x: FloatArray,
    v: FloatArray,
    h: float,
    hold: int,
    acting: Acting,
    sums: FloatArray,
) -> None:
    """Write to `slow` the forces that are held for `hold` steps from this one on.

    v is the mid-step velocity, and `slow_v` holds the acceleration before it.
    """
    middle, slow = 0.5 * (hold - 1) * h, acting.slow
    for i in range(len(x)):
        acting.slow_x[i] = x[i] + middle * v[i]
        acting.slow_v[i] = v[i] + (middle + 0.5 * h) * acting.slow_v[i]
        slow[i] = 0.0
    rows = load(acting.slow_rows, Rows)
    set_time(rows, t + middle)
    add_forces(rows, acting.slow_x, acting.slow_v, acting.slow_v, slow, np.int64(0), np.int64(0), sums)


@njit(cache=True, fastmath=FAST)
def _add_slow_wrench(x: FloatArray, slow: FloatArray, in_space: BoolArray, row: FloatArray) -> None:
    """Add the slow forces and their torques to row (6,)."""
    fx = fy = fz = tx = ty = tz = 0.0
    for i in range(len(slow) // 3):
        if in_space[i]:
            a, b, c = slow[3 * i], slow[3 * i + 1], slow[3 * i + 2]
            px, py, pz = x[3 * i], x[3 * i + 1], x[3 * i + 2]
            fx += a
            fy += b
            fz += c
            tx += py * c - pz * b
            ty += pz * a - px * c
            tz += px * b - py * a
    row[0] += fx
    row[1] += fy
    row[2] += fz
    row[3] += tx
    row[4] += ty
    row[5] += tz


@njit(**INLINED)
def _kick(
    x: FloatArray, v: FloatArray, share: FloatArray, f: FloatArray, h: float, acting: Acting, first: bool
) -> tuple[float, float]:
    """The half kick of a step, that of the next, and the drift, in one pass; returns powers as `_powers` does.

    f, `taken` and `given` are zero afterwards; `ahead` is v at the end of the step, with the acceleration at its start,
    except in the first step of a run, which has it already.
    """
    lost = brought = 0.0
    taken, given, ahead = acting.taken, acting.given, acting.ahead
    if not first:
        for i in range(len(ahead)):
            ahead[i] = v[i] + 1.5 * h * share[i] * f[i]
    for i in range(len(given)):
        brought += given[i] * (v[i] + 0.5 * h * share[i] * f[i])
        given[i] = 0.0
    for i in range(len(acting.slow) if not first else 0):
        brought += acting.slow[i] * (v[i] + 0.5 * h * share[i] * f[i])
    if len(taken):
        for i in range(len(x)):
            kick = h * share[i] * f[i]
            lost -= taken[i] * (v[i] + 0.5 * kick)
            taken[i] = 0.0
            v[i] += kick
            x[i] += h * v[i]
            f[i] = 0.0
    else:
        for i in range(len(x)):
            v[i] += h * share[i] * f[i]
            x[i] += h * v[i]
            f[i] = 0.0
    return lost, brought


@njit(cache=True, fastmath=FAST)
def _powers(v: FloatArray, share: FloatArray, f: FloatArray, h: float, acting: Acting) -> tuple[float, float]:
    """Powers in W taken by dissipative shares and brought by external ones, at v + h a/2."""
    lost = brought = 0.0
    for i in range(len(acting.taken)):
        lost -= acting.taken[i] * (v[i] + 0.5 * h * share[i] * f[i])
    for i in range(len(acting.given)):
        brought += acting.given[i] * (v[i] + 0.5 * h * share[i] * f[i])
    for i in range(len(acting.slow)):
        brought += acting.slow[i] * (v[i] + 0.5 * h * share[i] * f[i])
    return lost, brought


@njit(cache=True, fastmath=FAST)
def fly(
    x: FloatArray,
    v: FloatArray,
    a: FloatArray,
    addresses: tuple[int, int, int],
    solver: Solver,
    motions: FloatArray,
    t: float,
    h: float,
    steps: int,
    hold: int,
    limits: tuple[float, float],
    fresh: bool,
    powers: FloatArray,
    history: tuple[FloatArray, FloatArray],
) -> Tally:
    """Take `steps` steps of length h from t on, or fewer if strain or friction pass their limits; x, v, a are changed.

    addresses : of the Bodies, the Acting and the Held
    solver : of Rayleigh damping for this h
    hold : steps for which slow forces are held
    fresh : whether the flight begins here; else a holds the damping of the steps before
    powers : (8,), of the previous instant: power taken and given, W, and external force and torque of all but
        restraints; those of the last step at the end
    limits : of strain, and of the rate of friction in 1/s, see `forces.drawcord`; infinite where nothing ends the steps
    motions : (steps + 1, 3, k), u in m, u̇ and ü of each of k driven components at the ends of the steps
    history : (r, 3, 3n) and (r, 10), filled with x, v, a after each of the last r steps, and with dissipated energy,
        work and impulse up to then, the largest tension at that step and the largest up to then
    """
    bodies, acting, held = load(addresses[0], Bodies), load(addresses[1], Acting), load(addresses[2], Held)
    rows, drums = load(acting.rows, Rows), load(acting.drums, Drums)
    ahead, rubs = acting.ahead, acting.rubs
    share, size, (states, totals) = bodies.share, len(x), history
    f, viscous, sums = np.zeros(size), np.zeros(size), np.zeros(SUMS)
    dragged, braked = solver.damps, len(solver.rest.alpha) > 0
    driven, limited, rate = len(held.entry) > 0, limits[0] < np.inf, 0.0
    impulse, outside, outside_old = np.zeros(6), np.zeros(6), np.zeros(6)
    peak, peak_step, strain, step, short = 0.0, 0, -np.inf, 0, False
    R_old, x_old, speed = np.zeros(len(held.entry)), np.zeros(len(held.entry)), np.zeros(len(held.entry))
    now = np.zeros(size) if dragged else v  # the velocity at which Rayleigh damping is taken
    way, margin, least_margin = np.inf, 0.0, LEAST_MARGIN * bodies.shortest
    acting.taken[:] = 0.0
    acting.given[:] = 0.0
    slowly = len(acting.slow) > 0
    if slowly:
        acting.slow_v[:] = 0.0
        _look_at_slow(t, x, v, 0.0, 1, acting, sums)
    if driven or fresh:
        sift(rows, x, 0.0)
        for i in range(len(acting.slow)):
            f[i] = acting.slow[i]
        _evaluate(t, x, v, v, acting, f, sums)
        lost, brought = hold_drums(x, v, share, f, 0.5 * h if fresh else 0.0, drums)
        if fresh:
            own_lost, own_brought = _powers(v, share, f, 0.0, acting)
            powers[0] = lost + own_lost + sums[DISSIPATED]
            powers[1] = brought + own_brought + sums[EXTERNAL]
            for k in range(6):
                powers[OUTSIDE + k] = sums[FORCE + k]
            if slowly:
                _add_slow_wrench(x, acting.slow, bodies.in_space, powers[OUTSIDE:])
        if dragged:
            if fresh:
                for c in range(len(held.entry)):
                    speed[c] = motions[0, 1, held.motion[c]]
                damp(v, bodies.mass, f, h, solver, held.entry, speed, now, viscous)
                if braked:
                    _add_brakes(x, now, solver.rest.alpha, bodies.in_space, powers[OUTSIDE:])
            else:
                drag_all(v, solver, viscous)
            for i in range(size):
                f[i] += viscous[i]
                if fresh:
                    powers[0] -= 0.5 * viscous[i] * (v[i] + now[i])
        if fresh and (dragged or len(drums.entry) > 0):  # stiff forces take the velocity after this half step
            for i in range(size):
                a[i] = share[i] * f[i] if share[i] > 0.0 else a[i]
        for c in range(len(held.entry)):
            i = held.entry[c]
            R_old[c] = bodies.mass[i] * a[i] - f[i]
            _add_force(x, i // 3, i % 3, R_old[c], bodies.in_space, outside_old)
    for k in range(6):
        outside_old[k] += powers[OUTSIDE + k]
    # what acts at an instant does so half a step before it and half a step after it
    dissipated, work = 0.5 * h * powers[0], 0.5 * h * powers[1]
    for i in range(size):
        v[i] += 0.5 * h * a[i]
        f[i] = 0.0
    for i in range(len(ahead)):
        ahead[i] = v[i] + 0.5 * h * a[i]
    acting.taken[:] = 0.0
    acting.given[:] = 0.0
    lost, brought = 0.0, 0.0
    while step < steps and strain <= limits[0] and rate <= limits[1] and not short:
        step += 1
        for c in range(len(held.entry)):
            x_old[c] = x[held.entry[c]]
        if slowly and (step - 1) % hold == 0:
            for i in range(size):
                acting.slow_v[i] = a[i] if step == 1 else share[i] * f[i]
        # v is the middle velocity
        own_lost, own_brought = _kick(x, v, share, f, h, acting, step == 1)
        dissipated += h * own_lost
        work += h * own_brought
        moved = h * speed_of(v)
        for c in range(len(held.entry)):
            i, k = held.entry[c], held.motion[c]
            x[i] = held.anchor[c] + motions[step, 0, k]
            v[i] = 0.5 * (motions[step - 1, 1, k] + motions[step, 1, k])
            if len(ahead):
                ahead[i] = motions[step, 1, k]
            moved = max(moved, abs(x[i] - x_old[c]))
        parted = 2.0 * np.sqrt(3.0) * moved
        way += parted
        if not way <= margin:
            margin, way = max(LOOK * parted, least_margin), 0.0
            sift(rows, x, 1.01 * margin)  # 1 % for round-off
        if slowly:
            if (step - 1) % hold == 0:
                _look_at_slow(t + step * h, x, v, h, hold, acting, sums)
            for i in range(size):
                f[i] = acting.slow[i]
        _evaluate(t + step * h, x, v, ahead if len(ahead) else v, acting, f, sums)
        tension = np.sqrt(sums[TENSION])
        strain = max(strain, sums[STRAIN])
        if tension > peak:
            peak, peak_step = tension, step
        if limited:
            short = rests(rows, x) > 0 or rows.curved[1] != 0
            if rubs:
                rate = max(rate, friction_rate(rows, x, v, share))
        lost, brought = hold_drums(x, v, share, f, h, drums) if len(drums.entry) else (0.0, 0.0)
        for k in range(6):
            powers[OUTSIDE + k] = sums[FORCE + k]
        if slowly:
            _add_slow_wrench(x, acting.slow, bodies.in_space, powers[OUTSIDE:])
        if dragged:
            for c in range(len(held.entry)):
                speed[c] = motions[step, 1, held.motion[c]]
            damp(v, bodies.mass, f, h, solver, held.entry, speed, now, viscous)
            for i in range(size):
                f[i] += viscous[i]
                lost -= viscous[i] * now[i]
            if braked:
                _add_brakes(x, now, solver.rest.alpha, bodies.in_space, powers[OUTSIDE:])
        lost, brought = lost + sums[DISSIPATED], brought + sums[EXTERNAL]  # those of forces in Python
        dissipated += h * lost
        work += h * brought
        for c in range(len(held.entry)):
            i = held.entry[c]
            R = bodies.mass[i] * motions[step, 2, held.motion[c]] - f[i]
            work += 0.5 * (R_old[c] + R) * (x[i] - x_old[c])
            _add_force(x, i // 3, i % 3, R, bodies.in_space, outside)
            R_old[c] = R
        for k in range(6):
            outside[k] += powers[OUTSIDE + k]
            impulse[k] += 0.5 * h * (outside_old[k] + outside[k])
            outside_old[k], outside[k] = outside[k], 0.0
        row = step - 1 - steps + len(states)
        if row >= 0:
            state, total = states[row], totals[row]
            for i in range(size):
                state[0, i] = x[i]
            _end_step(state[1], state[2], v, f, share, h, held, motions[step])
            own_lost, own_brought = _powers(v, share, f, h, acting)
            total[0] = dissipated + 0.5 * h * (own_lost - lost)
            total[1] = work + 0.5 * h * (own_brought - brought)
            total[8], total[9] = tension, peak
            for k in range(6):
                total[2 + k] = impulse[k]
    own_lost, own_brought = _powers(v, share, f, h, acting)
    powers[0], powers[1] = lost + own_lost, brought + own_brought
    dissipated += 0.5 * h * (own_lost - lost)
    work += 0.5 * h * (own_brought - brought)
    _end_step(v, a, v, f, share, h, held, motions[step])
    return Tally(step, dissipated, work, impulse, peak, peak_step, strain, rate)


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
    """Add the forces of α M on all nodes, which are external, and their torques to row (6,)."""
    for i in range(len(v)):
        _add_force(x, i // 3, i % 3, -alpha[i] * v[i], in_space, row)


@njit(cache=True, fastmath=FAST)
def _add_force(x: FloatArray, node: int, c: int, F: float, in_space: BoolArray, row: FloatArray) -> None:
    """Add a force F along the axis c on a node, and its torque, to row (6,)."""
    if in_space[node]:
        row[c] += F
        row[3 + (c + 1) % 3] += x[3 * node + (c + 2) % 3] * F
        row[3 + (c + 2) % 3] -= x[3 * node + (c + 1) % 3] * F
