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

Only nodes on which a force may act are moved in each step, see `active`. All forces act in each step, through the table
of forces. External ones that depend on positions and velocities alone, such as gravity, orbit and still air, change
little in a few steps: they are evaluated once for `hold` steps, at the position and velocity that each node has in
their middle by its velocity and acceleration, and act with that value in each of them.

The power of a dissipative or external share is taken with the mean velocity of the steps before and after the instant,
v½ + h a/2: with it the kinetic energy of leapfrog balances exactly. So half of it is summed at the instant, and half
one step later. What acts at an instant does so half a step before it and half a step after it.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from netdae.core.addresses import floats
from netdae.core.arrays import FloatArray
from netdae.core.compilation import FAST
from netdae.core.records import load
from netdae.forces.loops import DISSIPATED, EXTERNAL, FORCE, FORMER, GIVEN, STRAIN, TAKEN, TENSION
from netdae.forces.table import (
    Rows,
    add_forces,
    add_powers,
    forget_shares,
    friction_rate,
    rests,
    set_time,
    settle,
    sift,
)
from netdae.solvers.explicit.active import (
    INLINED,
    LEAST_MARGIN,
    WAY,
    activate_all,
    catch_up,
    clear,
    is_due,
    look,
    make_up_turn,
    move,
    turn_target,
)
from netdae.solvers.explicit.drums import Drums, hold_drums
from netdae.solvers.explicit.held import add_reactions, drive
from netdae.solvers.explicit.parts import IMPULSE, LOST, WORK, Acting, Bodies, Held, Room, Tally
from netdae.solvers.explicit.rayleigh import Solver, damp, drag_all
from netdae.solvers.explicit.rubbing import Contacts, put_way, rub
from netdae.solvers.explicit.turning import attitude_now
from netdae.solvers.explicit.wrench import add_brakes, add_slow_wrench

RUBBED = 8  # steps after which the rate of friction is compared with its limit, which is well above it


@njit(cache=True, fastmath=FAST)
def fly(
    start: int,
    addresses: tuple[int, int, int, int],
    solver: Solver,
    motions: FloatArray,
    t: float,
    h: float,
    steps: int,
    hold: int,
    limits: tuple[float, float],
    fresh: bool,
    powers: FloatArray,
    history: tuple[FloatArray, FloatArray, FloatArray],
) -> Tally:
    """Take `steps` steps of length h from t on, or fewer if strain or friction pass their limits.

    start : address of x, v, a, (3, 3n), which are advanced to the end
    addresses : of the Bodies, the Acting, the Held and the Room
    solver : of Rayleigh damping for this h
    hold : steps for which slow forces are held
    fresh : whether the flight begins here; else a holds the damping of the steps before
    powers : (8,), of the previous instant: power taken and given, W, and external force and torque of all but
        restraints; those of the last step at the end
    limits : of strain, and of the rate of friction in 1/s, see `forces.drawcord`; infinite where nothing ends the steps
    motions : (steps + 1, 3, k), u in m, u̇ and ü of each of k driven components at the ends of the steps
    history : (r, 3, 3n), (r, 10) and (r, 4), filled with x, v, a after each of the last r steps; with dissipated
        energy, work and impulse up to then, the largest tension at that step and the largest up to then; and with the
        attitude of a target
    """
    bodies, acting = load(addresses[0], Bodies), load(addresses[1], Acting)
    held, room = load(addresses[2], Held), load(addresses[3], Room)
    size = len(bodies.mass)
    x, v, a = floats(start, size), floats(start + 8 * size, size), floats(start + 16 * size, size)
    rows, slowly, quiet = load(acting.rows, Rows), len(acting.slow) > 0, steps - len(history[0])
    peak, peak_step, strain, rate, step, short = 0.0, 0, -np.inf, 0.0, 0, False
    _begin(x, v, a, bodies, acting, held, room, rows, solver, motions[0], t, h, fresh, powers)
    while step < steps and strain <= limits[0] and rate <= limits[1] and not short:
        step += 1
        slow_ends = slowly and (step - 1) % hold == 0
        _look_ahead(v, a, h, step, slow_ends, bodies, acting, room)
        way = move(x, v, h, acting, room) + drive(x, v, acting.ahead, held, motions, step, h, room)
        way += turn_target(t + step * h, x, v, h, not room.moves[bodies.spin // 3], bodies, room)
        due = is_due(way, room)
        if due or slow_ends or step > quiet:
            catch_up(x, v, h, bodies, acting, room)
            make_up_turn(t + step * h, x, v, h, bodies, room)
            if slow_ends:
                _find_slow(t + step * h, x, v, h, hold, acting, room)
            if due:
                look(x, v, h, rows, bodies, acting, room)
            if step > quiet:
                activate_all(room)
        if acting.contacts != 0:
            put_way(load(acting.contacts, Contacts), room.reach[WAY])
        _evaluate(t + step * h, x, v, rows, acting, room)
        lost, brought = _hold_drums(x, v, h, bodies, acting, room, powers)
        if acting.contacts != 0:
            lost += rub(v, room.f, room.kick, load(acting.contacts, Contacts), powers[IMPULSE:])
        if solver.damps:
            lost += _damp(x, v, h, bodies, held, room, solver, motions[step], powers)
        _sum_up(x, h, lost, brought, bodies, held, room, motions, step, powers)
        tension, strain = np.sqrt(room.sums[TENSION]), max(strain, room.sums[STRAIN])
        if tension > peak:
            peak, peak_step = tension, step
        if limits[0] < np.inf:
            short = rests(rows, x) > 0 or rows.curved[1] != 0
            if acting.rubs and step % RUBBED == 1:
                rate = max(rate, friction_rate(rows, x, v, bodies.share))
        if step > quiet:
            state, totals = history[0][step - quiet - 1], history[1][step - quiet - 1]
            for i in range(len(x)):
                state[0, i] = x[i]
            _end_step(state[1], state[2], v, room.f, bodies.share, h, held, motions[step])
            _close(state[1], h, lost, brought, rows, acting, room, powers, totals)
            totals[8], totals[9] = tension, peak
            if bodies.pose != 0:
                attitude_now(bodies.pose, history[2][step - quiet - 1])
    catch_up(x, v, h, bodies, acting, room)
    make_up_turn(t + step * h, x, v, h, bodies, room)
    if slowly:
        _add_rest_of_wrench(x, h, bodies, acting, room, powers)
    _end_step(v, a, v, room.f, bodies.share, h, held, motions[step])
    totals = np.empty(8)
    _close(v, h, lost, brought, rows, acting, room, powers, totals)
    return Tally(step, totals[LOST], totals[WORK], totals[IMPULSE:], peak, peak_step, strain, rate, 0.0, 0.0)


@njit(**INLINED)
def _begin(
    x: FloatArray,
    v: FloatArray,
    a: FloatArray,
    bodies: Bodies,
    acting: Acting,
    held: Held,
    room: Room,
    rows: Rows,
    solver: Solver,
    motion: FloatArray,
    t: float,
    h: float,
    fresh: bool,
    powers: FloatArray,
) -> None:
    """The instant before the first step, whose forces are evaluated where they are needed, and its half kick."""
    f, sums, slow, size, drums = room.f, room.sums, acting.slow, len(x), load(acting.drums, Drums)
    clear(h, bodies, room)
    if acting.contacts != 0:
        put_way(load(acting.contacts, Contacts), 0.0)
    activate_all(room)
    room.outside[:] = 0.0
    f[:] = 0.0
    if len(slow) > 0:
        acting.slow_v[:] = 0.0
        _find_slow(t, x, v, 0.0, 1, acting, room)
    if len(held.entry) > 0 or fresh:
        sift(rows, x, 0.0, LEAST_MARGIN * bodies.shortest, np.int64(0))
        for i in range(len(acting.ahead)):
            acting.ahead[i] = v[i]
        _evaluate(t, x, v, rows, acting, room)
        lost, brought = hold_drums(x, v, bodies.share, f, 0.5 * h if fresh else 0.0, drums)
        if fresh:
            powers[LOST], powers[WORK] = lost + sums[DISSIPATED], brought + sums[EXTERNAL]
            for k in range(6):
                powers[IMPULSE + k] = sums[FORCE + k]
            sums[TAKEN] = sums[GIVEN] = 0.0
            settle(rows, v, sums)
            powers[LOST] += sums[TAKEN]
            powers[WORK] += sums[GIVEN] + _power_of(slow, v)
            add_slow_wrench(x, slow, bodies.in_space, 0, size, powers[IMPULSE:])
        if solver.damps:
            if fresh:
                for c in range(len(held.entry)):
                    held.speed[c] = motion[1, held.motion[c]]
                damp(v, bodies.mass, f, h, solver, held.entry, held.speed, room.now, room.viscous)
                add_brakes(x, room.now, solver.rest.alpha, bodies.in_space, powers[IMPULSE:])
            else:
                drag_all(v, solver, room.viscous)
            for i in range(size):
                f[i] += room.viscous[i]
                if fresh:
                    powers[LOST] -= 0.5 * room.viscous[i] * (v[i] + room.now[i])
        if fresh and (
            solver.damps or len(drums.entry) > 0
        ):  # stiff forces take the velocity after this half step
            for i in range(size):
                a[i] = bodies.share[i] * f[i] if bodies.share[i] > 0.0 else a[i]
        for c in range(len(held.entry)):
            i = held.entry[c]
            held.R[c] = bodies.mass[i] * a[i] - f[i]
            held.x[c] = x[i]
        add_reactions(x, bodies.in_space, held, room.outside)
    room.gained[LOST], room.gained[WORK] = 0.5 * h * powers[LOST], 0.5 * h * powers[WORK]
    for k in range(6):
        room.gained[IMPULSE + k] = 0.5 * h * (powers[IMPULSE + k] + room.outside[k])
    for i in range(size):
        v[i] += 0.5 * h * a[i]
        f[i] = 0.0
    for i in range(len(acting.ahead)):
        acting.ahead[i] = v[i] + 0.5 * h * a[i]
    forget_shares(rows)


@njit(**INLINED)
def _look_ahead(
    v: FloatArray,
    a: FloatArray,
    h: float,
    step: int,
    slow_ends: bool,
    bodies: Bodies,
    acting: Acting,
    room: Room,
) -> None:
    """What forces need of the acceleration at the last instant: velocities at the end of this step, and in the middle
    of those for which slow forces are held; and the work of slow forces at that instant."""
    ahead, slow, f = acting.ahead, acting.slow, room.f
    if slow_ends:
        for i in range(len(v)):
            acting.slow_v[i] = a[i] if step == 1 else bodies.share[i] * f[i]
    if step == 1 or (len(ahead) == 0 and len(slow) == 0):
        return
    work = 0.0
    for r in range(room.counts[0]):
        first, last = 3 * room.begin[r], 3 * room.end[r]
        if len(ahead) > 0:
            for i in range(first, last):
                ahead[i] = v[i] + 1.5 * room.kick[i] * f[i]
        if len(slow) > 0:
            for i in range(first, last):
                work += slow[i] * (v[i] + 0.5 * room.kick[i] * f[i])
    room.gained[WORK] += h * work


@njit(**INLINED)
def _find_slow(
    t: float, x: FloatArray, v: FloatArray, h: float, hold: int, acting: Acting, room: Room
) -> None:
    """Write the forces that are held for `hold` steps from this one on to `slow`, and to f.

    v is the mid-step velocity, and `slow_v` holds the acceleration before it.
    """
    middle, slow = 0.5 * (hold - 1) * h, acting.slow
    for i in range(len(x)):
        acting.slow_x[i] = x[i] + middle * v[i]
        acting.slow_v[i] = v[i] + (middle + 0.5 * h) * acting.slow_v[i]
        slow[i] = 0.0
    rows = load(acting.slow_rows, Rows)
    set_time(rows, t + middle)
    add_forces(rows, acting.slow_x, acting.slow_v, acting.slow_v, slow, np.int64(0), room.sums)
    for i in range(len(x)):
        room.f[i] = slow[i]


@njit(**INLINED)
def _evaluate(t: float, x: FloatArray, v: FloatArray, rows: Rows, acting: Acting, room: Room) -> None:
    """Add the forces of the table at t to f, and all else to sums."""
    sums, ahead = room.sums, acting.ahead if len(acting.ahead) > 0 else v
    sums[:] = 0.0
    sums[STRAIN] = -np.inf
    set_time(rows, t)
    add_forces(rows, x, v, ahead, room.f, np.int64(v.ctypes.data), sums)
    if acting.in_python:
        add_powers(rows, x, ahead, sums)


@njit(**INLINED)
def _hold_drums(
    x: FloatArray, v: FloatArray, h: float, bodies: Bodies, acting: Acting, room: Room, powers: FloatArray
) -> tuple[float, float]:
    """Add the forces on drums to f; return the powers in W that these and forces in Python take and give.

    External force and torque go to powers.
    """
    sums, drums = room.sums, load(acting.drums, Drums)
    lost, brought = sums[DISSIPATED], sums[EXTERNAL]
    if len(drums.entry) > 0:
        taken, given = hold_drums(x, v, bodies.share, room.f, h, drums)
        lost, brought = lost + taken, brought + given
    for k in range(6):
        powers[IMPULSE + k] = sums[FORCE + k]
    for r in range(room.counts[0] if len(acting.slow) > 0 else 0):
        add_slow_wrench(x, acting.slow, bodies.in_space, 3 * room.begin[r], 3 * room.end[r], powers[IMPULSE:])
    return lost, brought


@njit(**INLINED)
def _damp(
    x: FloatArray,
    v: FloatArray,
    h: float,
    bodies: Bodies,
    held: Held,
    room: Room,
    solver: Solver,
    motion: FloatArray,
    powers: FloatArray,
) -> float:
    """Add Rayleigh damping to f, and its external part to powers; return the power in W that it takes."""
    lost = 0.0
    for c in range(len(held.entry)):
        held.speed[c] = motion[1, held.motion[c]]
    damp(v, bodies.mass, room.f, h, solver, held.entry, held.speed, room.now, room.viscous)
    for i in range(len(room.f)):
        room.f[i] += room.viscous[i]
        lost -= room.viscous[i] * room.now[i]
    add_brakes(x, room.now, solver.rest.alpha, bodies.in_space, powers[IMPULSE:])
    return lost


@njit(**INLINED)
def _sum_up(
    x: FloatArray,
    h: float,
    lost: float,
    brought: float,
    bodies: Bodies,
    held: Held,
    room: Room,
    motions: FloatArray,
    step: int,
    powers: FloatArray,
) -> None:
    """Add to the balance what this instant brings, and the second half of the powers of the last one."""
    sums, gained, outside = room.sums, room.gained, room.outside
    for k in range(6):
        outside[k] = powers[IMPULSE + k]
    gained[LOST] += h * lost + 0.5 * h * (sums[TAKEN] + sums[TAKEN + FORMER])
    gained[WORK] += h * brought + 0.5 * h * (sums[GIVEN] + sums[GIVEN + FORMER])
    if len(held.entry) > 0:
        for c in range(len(held.entry)):
            i, former = held.entry[c], held.R[c]
            held.R[c] = bodies.mass[i] * motions[step, 2, held.motion[c]] - room.f[i]
            gained[WORK] += 0.5 * (former + held.R[c]) * (x[i] - held.x[c])
            held.x[c] = x[i]
        add_reactions(x, bodies.in_space, held, outside)
    for k in range(6):
        gained[IMPULSE + k] += h * outside[k]


@njit(**INLINED)
def _close(
    v: FloatArray,
    h: float,
    lost: float,
    brought: float,
    rows: Rows,
    acting: Acting,
    room: Room,
    powers: FloatArray,
    totals: FloatArray,
) -> None:
    """Write what the balance has gained up to an instant with velocities v to totals, and its powers to powers."""
    sums = room.sums
    taken, given = sums[TAKEN], sums[GIVEN]
    sums[TAKEN] = sums[GIVEN] = 0.0
    settle(rows, v, sums)
    slow = _power_of(acting.slow, v)
    powers[LOST], powers[WORK] = lost + sums[TAKEN], brought + sums[GIVEN] + slow
    totals[LOST] = room.gained[LOST] + 0.5 * h * (sums[TAKEN] - taken - lost)
    totals[WORK] = room.gained[WORK] + 0.5 * h * (sums[GIVEN] - given - brought + slow)
    sums[TAKEN], sums[GIVEN] = taken, given
    for k in range(IMPULSE, IMPULSE + 6):
        totals[k] = room.gained[k] - 0.5 * h * room.outside[k - IMPULSE]


@njit(**INLINED)
def _power_of(slow: FloatArray, v: FloatArray) -> float:
    total = 0.0
    for i in range(len(slow)):
        total += slow[i] * v[i]
    return total


@njit(**INLINED)
def _add_rest_of_wrench(
    x: FloatArray, h: float, bodies: Bodies, acting: Acting, room: Room, powers: FloatArray
) -> None:
    """Add the slow forces on nodes that are not active to the powers of the last instant and to the balance."""
    rest, first = np.zeros(6), 0
    for r in range(room.counts[0] + 1):
        last = 3 * room.begin[r] if r < room.counts[0] else len(x)
        add_slow_wrench(x, acting.slow, bodies.in_space, first, last, rest)
        first = 3 * room.end[r] if r < room.counts[0] else last
    for k in range(6):
        powers[IMPULSE + k] += rest[k]
        room.outside[k] += rest[k]
        room.gained[IMPULSE + k] += h * rest[k]


@njit(**INLINED)
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
