"""Which nodes a step moves one by one: those that a force may act on before the next look.

Most cables of a net in flight are slack, and a node whose cables all are flies straight, or under forces that are held
for some steps with a constant acceleration. A look finds the cables that may go taut before the next one, see `sift`
of the table. Their nodes are active, and so are the nodes of all forces that are not sifted. All other nodes stay where
they are, and catch up before the next look, step by step with the same numbers as active ones: which nodes are active
changes no digit of a flight.

No two nodes part faster than 2 √3 times the largest entry of |v − u|, with u the mean velocity at the look. The way
that this makes in the steps since, `WAY`, says when the next look is due: as soon as it exceeds the `MARGIN` within
which cables were taken in. Active nodes count with their speed in each step, others with the largest of the look. Most
looks only search among the cables that an earlier one found within a margin several times as large.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from netdae.core.addresses import index
from netdae.core.arrays import BoolArray, FloatArray
from netdae.core.compilation import FAST
from netdae.forces.table import Rows, sift
from netdae.solvers.explicit.parts import IMPULSE, WORK, Acting, Bodies, Room
from netdae.solvers.explicit.turning import pace_of, turn

INLINED: dict[str, Any] = {"cache": True, "fastmath": FAST, "forceinline": True}
EXACT: dict[str, Any] = {**INLINED, "fastmath": False}  # said, or the caller's would hold: no fused products
BLOCK = 32  # nodes that are active together: their entries fill whole registers of all processors
PARTING = 2.0 * math.sqrt(3.0)
LOOK, WIDE = 16, 4  # steps for which active nodes are found, and looks among the cables of one
LEAST_MARGIN = 1e-4  # of the shortest cable: for a net that begins to move
WAY, MARGIN, WIDE_WAY, WIDE_MARGIN, OTHERS = 0, 1, 2, 3, 4
"""Places in `Room.reach`: m, m, m, m, and the largest entry of |v − u| of nodes that are not active, m/s."""


@njit(**EXACT)
def move(x: FloatArray, v: FloatArray, h: float, acting: Acting, room: Room) -> float:
    """Kick and drift of the active nodes; leave the held forces in f, and return the way of a step, see the module.

    v is the velocity in the middle of the step before, and then in that of this one.
    """
    f, kick, slow, drift = room.f, room.kick, acting.slow, room.drift
    top = np.float64(room.reach[OTHERS]).view(np.int64)
    for r in range(room.counts[0]):
        first, last = index(3 * room.begin[r]), index(3 * room.end[r])
        for i in range(first, last):
            speed = v[i] + kick[i] * f[i]
            v[i] = speed
            x[i] += h * speed
            f[i] = 0.0
            top = max(top, np.float64(abs(speed - drift[i])).view(np.int64))
        if len(slow) > 0:
            for i in range(first, last):
                f[i] = slow[i]
    room.counts[1] += 1
    return PARTING * h * np.int64(top).view(np.float64)


@njit(**INLINED)
def is_due(way: float, room: Room) -> bool:
    """Whether a look is due after a step of this way, m; true for not-a-number too."""
    room.reach[WAY] += way
    room.reach[WIDE_WAY] += way
    return not room.reach[WAY] <= room.reach[MARGIN]


@njit(**INLINED)
def turn_target(
    t: float, x: FloatArray, v: FloatArray, h: float, waits: bool, bodies: Bodies, room: Room
) -> float:
    """Turn a free target in this step to t, or count it among those to be made up; return how far its points move, m.

    waits : whether nothing can act on it before the next look
    """
    if bodies.pose == 0:
        return 0.0
    if bodies.free:
        room.counts[2] += 1
        if not waits:
            make_up_turn(t, x, v, h, bodies, room)
    return h * pace_of(v, bodies.pose, bodies.spin, bodies.radius)


@njit(**INLINED)
def make_up_turn(t: float, x: FloatArray, v: FloatArray, h: float, bodies: Bodies, room: Room) -> None:
    """Turn a free target through the steps since it was turned."""
    if room.counts[2] > 0:
        turn(x, v, room.counts[2] * h, t, bodies.pose, bodies.spin)
        room.counts[2] = 0


@njit(**INLINED)
def catch_up(x: FloatArray, v: FloatArray, h: float, bodies: Bodies, acting: Acting, room: Room) -> None:
    """Move the nodes that are not active through the steps since they were, and sum what held forces did to them."""
    steps, first = room.counts[1], 0
    room.counts[1] = 0
    for r in range(room.counts[0] + 1 if steps > 0 else 0):
        last = 3 * room.begin[r] if r < room.counts[0] else len(x)
        if last > first:
            if len(acting.slow) > 0:
                _sum_held(first, last, x, v, h, steps, acting.slow, room.kick, bodies.in_space, room.gained)
            _go(first, last, x, v, h, steps, acting.slow, room.kick)
        first = 3 * room.end[r] if r < room.counts[0] else last


@njit(**EXACT)
def _go(
    first: int,
    last: int,
    x: FloatArray,
    v: FloatArray,
    h: float,
    steps: int,
    slow: FloatArray,
    kick: FloatArray,
) -> None:
    """So many steps of the entries from `first` to `last`, three or four at a time in registers."""
    first = index(first)
    if len(slow) > 0:
        for i in range(first, last, 3):
            gain0, gain1, gain2 = kick[i] * slow[i], kick[i + 1] * slow[i + 1], kick[i + 2] * slow[i + 2]
            v0, v1, v2, x0, x1, x2 = v[i], v[i + 1], v[i + 2], x[i], x[i + 1], x[i + 2]
            for _ in range(steps):
                v0, v1, v2 = v0 + gain0, v1 + gain1, v2 + gain2
                x0, x1, x2 = x0 + h * v0, x1 + h * v1, x2 + h * v2
            v[i], v[i + 1], v[i + 2], x[i], x[i + 1], x[i + 2] = v0, v1, v2, x0, x1, x2
        return
    odd = first + (last - first) % 4
    for i in range(first, odd):
        way = h * v[i]
        for _ in range(steps):
            x[i] += way
    for i in range(odd, last, 4):
        w0, w1, w2, w3 = h * v[i], h * v[i + 1], h * v[i + 2], h * v[i + 3]
        x0, x1, x2, x3 = x[i], x[i + 1], x[i + 2], x[i + 3]
        for _ in range(steps):
            x0, x1, x2, x3 = x0 + w0, x1 + w1, x2 + w2, x3 + w3
        x[i], x[i + 1], x[i + 2], x[i + 3] = x0, x1, x2, x3


@njit(**INLINED)
def _sum_held(
    first: int,
    last: int,
    x: FloatArray,
    v: FloatArray,
    h: float,
    steps: int,
    slow: FloatArray,
    kick: FloatArray,
    in_space: BoolArray,
    gained: FloatArray,
) -> None:
    """Add work and impulse of held forces f on these entries, over the instants of these steps but for the last.

    With the acceleration a = f/M, instant k is at x + k h v + ½ k (k + 1) h² a; v is that of the middle of the step
    before the first.
    """
    once, twice = 0.5 * steps * (steps - 1), (steps - 1) * steps * (steps + 1) / 6.0
    half = 0.5 * steps
    for i in range(first, last, 3):
        fx, fy, fz = slow[i], slow[i + 1], slow[i + 2]
        ax, ay, az = kick[i] * fx, kick[i + 1] * fy, kick[i + 2] * fz  # h a
        power = fx * (v[i] + half * ax) + fy * (v[i + 1] + half * ay) + fz * (v[i + 2] + half * az)
        gained[WORK] += h * steps * power
        if in_space[i // 3]:
            px = steps * x[i] + h * (once * v[i] + twice * ax)
            py = steps * x[i + 1] + h * (once * v[i + 1] + twice * ay)
            pz = steps * x[i + 2] + h * (once * v[i + 2] + twice * az)
            gained[IMPULSE] += h * steps * fx
            gained[IMPULSE + 1] += h * steps * fy
            gained[IMPULSE + 2] += h * steps * fz
            gained[IMPULSE + 3] += h * (py * fz - pz * fy)
            gained[IMPULSE + 4] += h * (pz * fx - px * fz)
            gained[IMPULSE + 5] += h * (px * fy - py * fx)


@njit(**INLINED)
def look(
    x: FloatArray, v: FloatArray, h: float, rows: Rows, bodies: Bodies, acting: Acting, room: Room
) -> None:
    """Find the elements that may act until the next look, and the active nodes. All nodes are where they should be."""
    n, reach, slow, moves = len(bodies.in_space), room.reach, acting.slow, room.moves
    a = b = c = 0.0
    for i in range(0, 3 * n, 3):
        a, b, c = a + v[i], b + v[i + 1], c + v[i + 2]
    for i in range(0, 3 * n, 3):
        room.drift[i], room.drift[i + 1], room.drift[i + 2] = a / n, b / n, c / n
    pace = 0.0
    if bodies.pose != 0:  # its spin node is no place: how fast its points move counts apart
        pace = pace_of(v, bodies.pose, bodies.spin, bodies.radius)
        for i in range(bodies.spin, bodies.spin + 3):
            room.drift[i] = v[i]
    fastest = 0.0
    for i in range(3 * n):
        gain = LOOK * abs(room.kick[i] * slow[i]) if len(slow) > 0 else 0.0
        fastest = max(fastest, abs(v[i] - room.drift[i]) + gain)
    if acting.contacts != 0:  # what is fixed in space moves with −u
        for i in range(3):
            fastest = max(fastest, abs(room.drift[i]))
    reach[OTHERS] = fastest
    margin = max(LOOK * h * (PARTING * fastest + pace), LEAST_MARGIN * bodies.shortest)
    wide = 0.0
    if not reach[WIDE_WAY] + margin <= reach[WIDE_MARGIN]:
        wide = WIDE * margin
        reach[WIDE_WAY], reach[WIDE_MARGIN] = 0.0, wide
    reach[WAY], reach[MARGIN] = 0.0, margin
    for i in range(n):
        moves[i] = bodies.always[i]
    sift(rows, x, 1.01 * margin, 1.01 * wide, np.int64(moves.ctypes.data))  # 1 % for round-off
    if bodies.whole:
        activate_all(room)
    else:
        _find_spans(room)


@njit(**INLINED)
def clear(h: float, bodies: Bodies, room: Room) -> None:
    """Begin a run of steps of length h: nothing is gained yet, and a look is due."""
    room.counts[1] = room.counts[2] = 0
    room.moves[:] = False
    room.reach[:] = 0.0
    room.reach[MARGIN] = room.reach[WIDE_MARGIN] = -1.0
    room.gained[:] = 0.0
    for i in range(len(room.kick)):
        room.kick[i] = h * bodies.share[i]


@njit(**INLINED)
def activate_all(room: Room) -> None:
    """Let all nodes be active until the next look."""
    room.begin[0], room.end[0], room.counts[0] = 0, len(room.moves), 1


@njit(**INLINED)
def _find_spans(room: Room) -> None:
    """Spans of blocks in which a node is active."""
    n, count, moves, joins = len(room.moves), 0, room.moves, False
    for begin in range(0, n, BLOCK):
        end, any_moves = min(begin + BLOCK, n), False
        for i in range(begin, end):
            any_moves = any_moves or moves[i]
        if any_moves and not joins:
            room.begin[count] = begin
            count += 1
        if any_moves:
            room.end[count - 1] = end
        joins = any_moves
    room.counts[0] = count
