"""The step of undamped nets: it keeps energy and both momenta, whatever its length.

Symbols: x, v, M as in `verlet`; U the energy stored in cables and springs, s = ½ d·d of one of them with d = xⱼ − xᵢ;
h step length; a bar over what is between two instants.

Verlet's step is stable for linear nets only. Each time that a cable goes taut or slack within a step it gives or takes
up to (h ω)²/4 of the energy of the encounter, see `guard`; without a damper nothing takes what is given, and no step
length makes the sum bounded. This step replaces −∇U by a discrete gradient (O. Gonzalez, Time integration and discrete
Hamiltonian systems, J. Nonlinear Sci. 6, 1996; J. C. Simo and N. Tarnow, The discrete energy-momentum method, ZAMP 43,
1992):

    x₁ = x₀ + h (v₀ + v₁)/2,     M (v₁ − v₀) = h f̄,     f̄ = Σ q̄ (d₀ + d₁)/2 on i, −q̄ (d₀ + d₁)/2 on j,
    q̄ = (U₁ − U₀)/(s₁ − s₀).

The work of f̄ is f̄·(x₁ − x₀) = −Σ q̄ (d₀ + d₁)/2·(d₁ − d₀) = −Σ q̄ (s₁ − s₀) = U₀ − U₁, and it is the change of the
kinetic energy, h f̄·(v₀ + v₁)/2: their sum is kept, exactly, at kinks too. f̄ is a pair of opposite forces along the mean
cable, at the mean places, (x₀ + x₁)/2; since x₁ − x₀ is along the mean velocity both momenta are kept. It is of second
order: q̄ is the stress at the middle but for h², see `forces.cables` for it without cancellation.

x₁ is found by fixed point, x₁ ← x₀ + h v₀ + ½ h² f̄(x₀, x₁)/M, to `NEAR` m or the last digit of x. f̄ depends on x₁ with
half the stiffness, so the error falls by (h ω)²/4 ≤ r² each time, with r the share of the longest stable step: four
times at r = `LONGEST`. Where it does not, as at a strain beyond its limit, the step is taken in 2, 4, 8, ... equal
parts.

All other forces act as in `verlet`, by kicks of h/2 before and after: at the instants, with the velocity expected
there. Their work is that of the mean velocity of each kick, which is exact. Restrained axes are moved evenly from one
place to the next, and what holds them is booked by what f̄ and the kicks do to them.

Where a cable shortens again within a step, its largest tension is inside of it, where `stepper` looks by a step of part
length.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from netdae.core.addresses import floats, index
from netdae.core.arrays import BoolArray, FloatArray, Reals, Wholes, wholes
from netdae.core.compilation import FAST
from netdae.core.records import load
from netdae.forces.loops import DISSIPATED, EXTERNAL, FORCE, GIVEN, SUMS, TAKEN
from netdae.forces.table import (
    Rows,
    add_between,
    add_forces,
    add_powers,
    find_crests,
    forget_shares,
    set_time,
    settle,
    sift,
)
from netdae.solvers.explicit.active import (
    INLINED,
    MARGIN,
    PARTING,
    WAY,
    WIDE_MARGIN,
    WIDE_WAY,
    clear,
    look,
)
from netdae.solvers.explicit.parts import IMPULSE, LOST, POWERS, WORK, Acting, Bodies, Held, Room, Tally
from netdae.solvers.explicit.wrench import add_force, add_slow_wrench

LONGEST = 0.5
"""Largest share of the stable step: the work of a flight, (number of steps) × (passes over the forces), hardly depends
on it from 0.25 to 0.5, and grows beyond."""
NEAR = 1e-13  # m, to which places are found
PASSES = 60  # after which a step is divided; at 0.25 an error falls to round-off in 26
PARTS = 1024  # the most
LOOKS = 3  # in one step


class Between(NamedTuple):
    """Forces with a mean force between two places, and room for a step; arrays (3n,)."""

    rows: int  # address of the table's
    x: Reals  # m, at its start
    v: Reals  # m/s, at its start, after the kick
    whole: Reals  # m/s, at the instant before
    f: Reals  # N, the mean forces of the last pass
    guess: Reals  # N, of the step before
    former: Reals  # N, of that before it
    now: Reals  # m/s, expected velocity at the instant
    old: Reals  # m, at the start of a part of a step, or where axes are restrained
    speed: Reals  # m/s, there, and even ones of restrained axes
    active: Wholes  # (n,), 3i of the nodes on which mean forces may act
    many: Wholes  # (1,), how many these are
    found: Reals  # (5,), see `find_crests`
    gained: Reals  # (8,), by the balance in this step
    sums: Reals  # of forces, see `forces.loops`
    passes: Reals  # (2,), passes over the forces, and steps that were divided


def room_for(rows: int, size: int) -> Between:
    """A Between for nets of `size` unknowns."""
    x, v, whole, f, guess, former, now, old, speed = np.zeros((9, size))
    return Between(
        rows=rows,
        x=x,
        v=v,
        whole=whole,
        f=f,
        guess=guess,
        former=former,
        now=now,
        old=old,
        speed=speed,
        active=wholes(size // 3),
        many=wholes(1),
        found=np.zeros(5),
        gained=np.zeros(POWERS),
        sums=np.zeros(SUMS),
        passes=np.zeros(2),
    )


@njit(cache=True, fastmath=FAST)
def fly_lossless(
    start: int,
    addresses: tuple[int, int, int, int],
    between: int,
    motions: FloatArray,
    t: float,
    h: float,
    steps: int,
    hold: int,
    strain_limit: float,
    history: tuple[FloatArray, FloatArray, FloatArray],
) -> Tally:
    """Take `steps` steps of length h from t on, or fewer if the strain passes its limit; as `verlet.fly`.

    between : address of the Between
    """
    bodies, acting = load(addresses[0], Bodies), load(addresses[1], Acting)
    held, room, b = load(addresses[2], Held), load(addresses[3], Room), load(between, Between)
    size = len(bodies.mass)
    x, v, a = floats(start, size), floats(start + 8 * size, size), floats(start + 16 * size, size)
    rows, own, quiet = load(acting.rows, Rows), load(b.rows, Rows), steps - len(history[0])
    peak, peak_step, strain, step, short = 0.0, 0, -np.inf, 0, False
    crest, crest_at, slowly = 0.0, 0.0, len(acting.slow) > 0
    kicks = slowly or len(rows.elements) > 0
    before = b.whole if kicks else b.v
    near = _begin(x, v, a, bodies, acting, held, room, rows, b, t, h)
    while step < steps and strain <= strain_limit and not short:
        step += 1
        if kicks:
            for i in range(size):
                b.whole[i] = v[i]
            _kick_again(x, v, 0.5 * h, bodies, acting, held, room, rows)
        _advance(x, v, h, near, motions, step, bodies, acting, held, room, rows, own, b)
        if kicks:
            for i in range(size):  # as if other forces were as before
                b.now[i] = v[i] + 0.5 * room.kick[i] * room.f[i]
            if slowly and (step - 1) % hold == 0:
                _find_slow(t + step * h, x, h, hold, bodies, acting, room, b)
            _kick(t + step * h, x, v, b.now, 0.5 * h, bodies, acting, held, room, rows)
        find_crests(own, b.x, before, x, v, h, b.found)
        tension = np.sqrt(b.found[0])
        strain = max(strain, max(b.found[1], b.found[4]))
        if tension > peak:
            peak, peak_step = tension, step
        if np.sqrt(b.found[2]) > crest:
            crest, crest_at = np.sqrt(b.found[2]), step - 1 + b.found[3]
        if strain_limit < np.inf:
            short = rows.curved[1] != 0
        if step > quiet:
            state, totals = history[0][step - quiet - 1], history[1][step - quiet - 1]
            _accelerate(x, v, state[2], bodies, held, room, own, motions[step], b)
            for i in range(size):
                state[0, i], state[1, i] = x[i], v[i]
            for k in range(8):
                totals[k] = room.gained[k]
            totals[8], totals[9] = tension, peak
    _accelerate(x, v, a, bodies, held, room, own, motions[step], b)
    gained = room.gained
    return Tally(
        step,
        gained[LOST],
        gained[WORK],
        gained[IMPULSE:].copy(),
        peak,
        peak_step,
        strain,
        0.0,
        crest,
        crest_at,
    )


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
    b: Between,
    t: float,
    h: float,
) -> float:
    """Kicks' forces at the instant before the first step, and what mean forces may be; return how near is near, m."""
    farthest = 0.0
    clear(h, bodies, room)
    b.passes[:] = 0.0
    for i in range(len(x)):
        b.f[i], b.now[i], room.drift[i] = 0.0, v[i], 0.0
        farthest = max(farthest, abs(x[i]))
    sift(rows, x, 0.0, 1e-3 * bodies.shortest, np.int64(0))
    if len(acting.slow) > 0:
        room.f[:] = 0.0
        _find_slow(t, x, h, 1, bodies, acting, room, b)
    forget_shares(rows)
    _kick(t, x, v, b.now, 0.0, bodies, acting, held, room, rows)
    for i in range(len(x)):
        b.guess[i] = b.former[i] = bodies.mass[i] * a[i] - room.f[i]
    return max(NEAR * min(1.0, bodies.shortest), 4.5e-16 * farthest)


@njit(**INLINED)
def _find_slow(
    t: float, x: FloatArray, h: float, hold: int, bodies: Bodies, acting: Acting, room: Room, b: Between
) -> None:
    """Write the forces that are held for `hold` instants from this one on to `slow`, taken in their middle."""
    middle, slow = 0.5 * (hold - 1) * h, acting.slow
    for i in range(len(x)):
        gain = middle * bodies.share[i] * (room.f[i] + b.f[i])
        acting.slow_x[i] = x[i] + middle * (b.now[i] + 0.5 * gain)
        acting.slow_v[i] = b.now[i] + gain
        slow[i] = 0.0
    rows = load(acting.slow_rows, Rows)
    set_time(rows, t + middle)
    add_forces(rows, acting.slow_x, acting.slow_v, acting.slow_v, slow, np.int64(0), room.sums)


@njit(**INLINED)
def _kick(
    t: float,
    x: FloatArray,
    v: FloatArray,
    now: FloatArray,
    h: float,
    bodies: Bodies,
    acting: Acting,
    held: Held,
    room: Room,
    rows: Rows,
) -> None:
    """Leave the forces that kick at t in f and their shares in the rows, and kick for h; v is before the kick."""
    sums, f, slow = room.sums, room.f, acting.slow
    sums[:] = 0.0
    for i in range(len(f)):
        f[i] = slow[i] if len(slow) > 0 else 0.0
    set_time(rows, t)
    add_forces(rows, x, now, now, f, np.int64(v.ctypes.data), sums)
    if acting.in_python:
        add_powers(rows, x, now, sums)
    room.outside[:] = 0.0
    for k in range(6):
        room.outside[k] = sums[FORCE + k]
    add_slow_wrench(x, slow, bodies.in_space, 0, len(x), room.outside)
    for c in range(len(held.entry)):
        add_force(x, held.entry[c], -f[held.entry[c]], bodies.in_space, room.outside)
    _push(v, h, bodies, acting, held, room, rows)


@njit(**INLINED)
def _kick_again(
    x: FloatArray,
    v: FloatArray,
    h: float,
    bodies: Bodies,
    acting: Acting,
    held: Held,
    room: Room,
    rows: Rows,
) -> None:
    """Kick for h by the same forces."""
    room.sums[TAKEN] = room.sums[GIVEN] = 0.0
    settle(rows, v, room.sums)
    _push(v, h, bodies, acting, held, room, rows)


@njit(**INLINED)
def _push(
    v: FloatArray, h: float, bodies: Bodies, acting: Acting, held: Held, room: Room, rows: Rows
) -> None:
    """Kick, and book its work and impulse: powers at v are in sums, external force and torque in `outside`."""
    sums, slow, gained, f = room.sums, acting.slow, room.gained, room.f
    lost, brought = sums[TAKEN], sums[GIVEN]
    sums[TAKEN] = sums[GIVEN] = 0.0
    for c in range(len(held.entry)):
        brought -= 2.0 * f[held.entry[c]] * v[held.entry[c]]
    for i in range(len(slow)):
        brought += slow[i] * v[i]
    for i in range(len(v)):
        v[i] += h * bodies.share[i] * f[i]
    for i in range(len(slow)):
        brought += slow[i] * v[i]
    settle(rows, v, sums)
    lost, brought = lost + sums[TAKEN], brought + sums[GIVEN]
    gained[LOST] += 0.5 * h * lost + h * sums[DISSIPATED]
    gained[WORK] += 0.5 * h * brought + h * sums[EXTERNAL]
    for k in range(6):
        gained[IMPULSE + k] += h * room.outside[k]


@njit(**INLINED)
def _advance(
    x: FloatArray,
    v: FloatArray,
    h: float,
    near: float,
    motions: FloatArray,
    step: int,
    bodies: Bodies,
    acting: Acting,
    held: Held,
    room: Room,
    rows: Rows,
    own: Rows,
    b: Between,
) -> None:
    """Move x and v by one step of the mean forces, and book what restraints and forces to the ground give."""
    reach, gained = room.reach, room.gained
    way = 0.0
    for i in range(len(x)):
        b.x[i], b.v[i] = x[i], v[i]
        way = max(way, abs(v[i] + 0.5 * room.kick[i] * b.guess[i] - room.drift[i]))
    way *= PARTING * h
    for look_number in range(LOOKS):
        if look_number > 0 or not reach[WAY] + way <= reach[MARGIN]:
            for i in range(len(x)):
                b.now[i] = (x[i] - b.x[i]) / h if look_number > 0 else v[i] + 0.5 * room.kick[i] * b.guess[i]
                x[i] = b.x[i]
            for c in range(len(held.entry)):
                b.now[held.entry[c]] = _speed_of(held, motions, c, step, h)
            _look_at_all(x, h, bodies, acting, room, rows, own, b)
        parts = 1
        while parts <= PARTS:
            b.gained[:] = 0.0
            if _solve(x, v, h / parts, parts, near, motions, step, h, bodies, held, room, own, b):
                break
            parts *= 2
            b.passes[1] += 1.0
            for i in range(len(x)):
                x[i], v[i] = b.x[i], b.v[i]
        if parts > PARTS:
            x[0] = np.nan
        way = 0.0
        for i in range(len(x)):
            way = max(way, abs(x[i] - b.x[i] - h * room.drift[i]))
        way *= PARTING
        if reach[WAY] + way <= reach[MARGIN]:
            break
        if look_number + 1 < LOOKS:
            for i in range(len(x)):
                v[i] = b.v[i]
    reach[WAY] += way
    reach[WIDE_WAY] += way
    for k in range(8):
        gained[k] += b.gained[k]
    for c in range(len(held.entry)):  # its share of the kinetic energy and of the momenta
        i, k = held.entry[c], held.motion[c]
        before, after = motions[step - 1, 1, k], motions[step, 1, k]
        v[i] = after
        gained[WORK] += 0.5 * bodies.mass[i] * (after * after - before * before)
        _add_halfway(b.x, x, i, bodies.mass[i] * (after - before), bodies.in_space, gained)
    for q in range(b.many[0]):
        for i in range(index(b.active[q]), index(b.active[q]) + 3):
            b.former[i], b.guess[i] = b.guess[i], b.f[i]


@njit(**INLINED)
def _speed_of(held: Held, motions: FloatArray, c: int, step: int, h: float) -> float:
    k = held.motion[c]
    return (motions[step, 0, k] - motions[step - 1, 0, k]) / h


@njit(**INLINED)
def _look_at_all(
    x: FloatArray,
    h: float,
    bodies: Bodies,
    acting: Acting,
    room: Room,
    rows: Rows,
    own: Rows,
    b: Between,
) -> None:
    """Find the elements that may act until the next look, see `active`; the expected velocities are in `now`."""
    look(x, b.now, h, own, bodies, acting, room)
    b.many[0] = 0
    for i in range(len(bodies.in_space)):
        if room.moves[i]:
            b.active[b.many[0]] = 3 * i
            b.many[0] += 1
        else:
            for k in range(3 * i, 3 * i + 3):
                b.f[k] = b.guess[k] = b.former[k] = 0.0
    reach = room.reach
    wide = reach[WIDE_MARGIN] if reach[WIDE_WAY] == 0.0 else 0.0
    sift(rows, x, 1.01 * reach[MARGIN], 1.01 * wide, np.int64(0))


@njit(**INLINED)
def _solve(
    x: FloatArray,
    v: FloatArray,
    dt: float,
    parts: int,
    near: float,
    motions: FloatArray,
    step: int,
    h: float,
    bodies: Bodies,
    held: Held,
    room: Room,
    own: Rows,
    b: Between,
) -> bool:
    """Advance by `parts` steps of length dt; False where a fixed point is not found.

    What restraints and forces to the ground give is added to `b.gained`.
    """
    share, f, kick = bodies.share, b.f, 0.5 * dt
    whole = parts == 1 and len(held.entry) == 0
    old, speed = (b.x, b.v) if whole else (b.old, b.speed)
    for part in range(parts):
        for i in range(len(x) if not whole else 0):
            old[i], speed[i] = x[i], v[i]
        for c in range(len(held.entry)):
            i, k = held.entry[c], held.motion[c]
            end = motions[step, 0, k]
            if part + 1 < parts:
                end = motions[step - 1, 0, k] + (part + 1) / parts * (end - motions[step - 1, 0, k])
            held.x[c] = held.anchor[c] + end
            speed[i] = (held.x[c] - x[i]) / dt
        for i in range(len(x)):
            x[i] = old[i] + dt * speed[i]
        ahead = 1.0 if parts == 1 else 0.0
        for q in range(b.many[0]):
            for i in range(index(b.active[q]), index(b.active[q]) + 3):
                expected = b.guess[i] + ahead * (b.guess[i] - b.former[i])
                x[i] = old[i] + dt * (speed[i] + kick * share[i] * expected)
        if not _find_place(x, old, speed, dt, near, share, room, own, b):
            return False
        for q in range(b.many[0]):
            for i in range(index(b.active[q]), index(b.active[q]) + 3):
                v[i] = speed[i] + dt * share[i] * f[i]
        for c in range(len(held.entry)):
            x[held.entry[c]] = held.x[c]
        for c in range(len(held.entry)):
            i = held.entry[c]
            b.gained[WORK] -= f[i] * (x[i] - old[i])
            _add_halfway(old, x, i, -dt * f[i], bodies.in_space, b.gained)
        for k in range(6):
            b.gained[IMPULSE + k] += dt * b.sums[FORCE + k]
    return True


@njit(**INLINED)
def _add_halfway(
    old: FloatArray, x: FloatArray, i: int, impulse: float, in_space: BoolArray, gained: FloatArray
) -> None:
    """Add an impulse along the entry i, and its moment at the mean place of the node."""
    node, c = i // 3, i % 3
    if in_space[node]:
        j, k = (c + 1) % 3, (c + 2) % 3
        gained[IMPULSE + c] += impulse
        gained[IMPULSE + 3 + j] += 0.5 * (old[3 * node + k] + x[3 * node + k]) * impulse
        gained[IMPULSE + 3 + k] -= 0.5 * (old[3 * node + j] + x[3 * node + j]) * impulse


@njit(**INLINED)
def _find_place(
    x: FloatArray,
    old: FloatArray,
    speed: FloatArray,
    dt: float,
    near: float,
    share: FloatArray,
    room: Room,
    own: Rows,
    b: Between,
) -> bool:
    """Find x after a step of length dt from `old` at `speed`, and the mean forces; False where passes do not."""
    f, kick = b.f, 0.5 * dt
    for _ in range(PASSES):
        b.passes[0] += 1.0
        b.sums[:] = 0.0
        for q in range(b.many[0]):
            for i in range(index(b.active[q]), index(b.active[q]) + 3):
                f[i] = 0.0
        add_between(own, old, x, f, b.sums)
        top = np.int64(
            0
        )  # the bits of a number that is not negative have its order, and not-a-number is last
        for q in range(b.many[0]):
            for i in range(index(b.active[q]), index(b.active[q]) + 3):
                place = old[i] + dt * (speed[i] + kick * share[i] * f[i])
                top = max(top, np.float64(abs(place - x[i])).view(np.int64))
                x[i] = place
        if np.int64(top).view(np.float64) <= near:
            return True
    return False


@njit(**INLINED)
def _accelerate(
    x: FloatArray,
    v: FloatArray,
    a: FloatArray,
    bodies: Bodies,
    held: Held,
    room: Room,
    own: Rows,
    motion: FloatArray,
    b: Between,
) -> None:
    """Write the accelerations of an instant to a (3n,)."""
    f = room.viscous
    for i in range(len(x)):
        f[i] = room.f[i]
    add_forces(own, x, v, v, f, np.int64(0), b.sums)
    for i in range(len(x)):
        a[i] = bodies.share[i] * f[i]
    for c in range(len(held.entry)):
        a[held.entry[c]] = motion[2, held.motion[c]]
