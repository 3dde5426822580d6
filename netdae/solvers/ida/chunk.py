"""A chunk of IDA's steps without Python: the loop around IDASolve, which keeps states, powers and work of each step."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from netdae.core.addresses import call, ints
from netdae.core.records import load
from netdae.forces.pose import Pose, attitude_at, move_base, put_base, rates_of
from netdae.forces.table import ENDED, Rows, rests
from netdae.solvers.ida.failures import STANDS_STILL, STUCK, WOUND_IN
from netdae.solvers.ida.kernel import OPTIONS, RATES, Net, between, middle, rates
from netdae.solvers.ida.layout import RECORD, Chunk, record_at
from netdae.solvers.ida.taut import LOW_ORDER, SETTLING, TIGHT, Damped, is_undamped

_ONE_STEP = 2  # IDA_ONE_STEP
SAME = 1e-6  # of step lengths, which are differences of times
_ORDER = RECORD.fields["order"][1]  # type: ignore[index]
_ERRORS_FAILED = RECORD.fields["errors_failed"][1]  # type: ignore[index]


@njit(nogil=True, **OPTIONS)
def begin_rates(address: int, row: int) -> float:
    """Compute the rates with which the sums continue from a row of the chunk; return the largest tension there, N."""
    u = record_at(address)
    chunk = load(u.chunk, Chunk)
    return rates(chunk.times[row], chunk.states[row], load(u.net, Net), chunk.rates)


@njit(**OPTIONS)
def put_attitude(chunk: Chunk, net: Net, row: int) -> None:
    """Let forces see the target's attitude as it follows from a row of the chunk."""
    if net.pose != 0:
        pose, y, at, q = load(net.pose, Pose), chunk.states[row], net.spin, chunk.attitudes[row]
        if pose.free:
            angle, spin = rates_of(pose, y, at), rates_of(pose, y, len(y) // 2 + at)
            put_base(pose, (q[0], q[1], q[2], q[3]), angle, spin, chunk.times[row])


@njit(**OPTIONS)
def turn_on(chunk: Chunk, net: Net, row: int) -> None:
    """Find the target's attitude in a row from that in the row before, from which later ones then follow."""
    if net.pose != 0:
        pose, y, at = load(net.pose, Pose), chunk.states[row], net.spin
        angle, spin = rates_of(pose, y, at), rates_of(pose, y, len(y) // 2 + at)
        move_base(pose, angle, spin, chunk.times[row])
        q = attitude_at(pose, angle, spin, chunk.times[row])
        for c in range(4):
            chunk.attitudes[row, c] = q[c]


@njit(nogil=True, **OPTIONS)
def begin_attitude(address: int) -> None:
    """Let forces see the target as it is in the chunk's first row."""
    u = record_at(address)
    put_attitude(load(u.chunk, Chunk), load(u.net, Net), 0)


@njit(nogil=True, **OPTIONS)
def fly(address: int, row: int, count: int, stop: float, span: float) -> int:
    """Up to `count` steps from the state in `row`, not beyond `stop`, for at most `span` seconds; IDA's last code.

    A step in which a cord is completely wound in does not count; it is kept in the row after `made`.
    The chunk's rows 0 to `made` then hold times, states (x, v), slopes (ẋ, v̇), sums since its start, and tensions.
    """
    u = record_at(address)
    size, net, chunk = 6 * u.n, load(u.net, Net), load(u.chunk, Chunk)
    rows, damped = load(net.rows, Rows), load(u.damped, Damped)
    times, states, slopes, sums, now = chunk.times, chunk.states, chunk.slopes, chunk.sums, chunk.rates
    if row > 0:
        for q in range(size):
            states[0, q], slopes[0, q] = states[row, q], slopes[row, q]
        times[0] = times[row]
        for q in range(4):
            chunk.attitudes[0, q] = chunk.attitudes[row, q]
    put_attitude(chunk, net, 0)
    for q in range(RATES):
        sums[0, q] = 0.0
    then = np.empty(RATES)
    code, made = 0, 0
    while made < count and times[made] < stop and times[made] - times[0] < span:
        k, t = made, times[made]
        y = states[k + 1]
        ints(ints(u.y, 1)[0], 2)[1] = y.ctypes.data
        ints(ints(u.yp, 1)[0], 2)[1] = slopes[k + 1].ctypes.data
        code = call(u.ida_solve, (u.memory, stop, chunk.clock.ctypes.data, u.y, u.yp, np.int32(_ONE_STEP)))
        if code < 0:
            break
        at = chunk.clock[0]
        times[made + 1] = at
        if rests(rows, y[: size // 2]) == ENDED:
            code = WOUND_IN
            break
        made += 1
        h = at - t
        for q in range(RATES):
            then[q] = now[q]
        chunk.tensions[made] = rates(at, y, net, now)
        if h > 0.0:
            middle(h, states[k], y, chunk.middle)
            rates(t + 0.5 * h, chunk.middle, net, chunk.middle_rates)
        turn_on(chunk, net, made)
        for q in range(RATES):
            sums[made, q] = sums[k, q] + h / 6.0 * (then[q] + 4.0 * chunk.middle_rates[q] + now[q])
        if rows.curved[1] != 0:  # Python has failed
            made -= 1
            break
        u.undamped = is_undamped(u.undamped, h, damped.kappa, damped.tau)
        u.low = 1 if u.undamped != 0 and (u.low != 0 or chunk.tensions[made] > 0.0) else 0
        u.free += 1 if u.low != 0 and u.undamped > 1 else 0
        u.strict = TIGHT if u.low != 0 and u.undamped > 1 else 1.0
        _limit_order(address, at, h)
        u.stuck = u.stuck + 1 if h <= 8.9e-16 * abs(at) else 0
        if u.stuck > STUCK:
            code = STANDS_STILL
            break
    u.made = made
    call(u.error_test_fails, (u.memory, address + _ERRORS_FAILED))
    return code


@njit(**OPTIONS)
def _limit_order(address: int, at: float, h: float) -> None:
    """Let IDA's order fall to a low one, or rise again.

    A limit below its present order would let IDA go beyond the vectors that it has, so the limit follows it down. An
    order that stays high where it grows what nothing damps is ended by a new start. The limit rises only with a new
    step length: IDA then waits with a higher order until it has kept what this requires.
    """
    u = record_at(address)
    u.since += 1
    allowed = u.highest if u.since > SETTLING else u.allowed
    if u.low != 0:
        call(u.get_order, (u.memory, address + _ORDER))
        order = u.order & 0xFFFFFFFF
        u.above = u.above + 1 if u.undamped > 1 and order > LOW_ORDER else 0
        if u.above > SETTLING:
            call(u.error_test_fails, (u.memory, address + _ERRORS_FAILED))
            u.failed_earlier += u.errors_failed
            call(u.start_anew, (u.memory, at, u.y, u.yp))
            order, u.above, u.spoilt = 1, 0, 0
        allowed = min(u.highest, max(LOW_ORDER, order))
    same = abs(h - u.h_before) <= SAME * h
    u.h_before = h
    if allowed < u.allowed or (allowed > u.allowed and not same):
        u.allowed = allowed
        call(u.set_highest_order, (u.memory, np.int32(allowed)))


@njit(nogil=True, **OPTIONS)
def inside(address: int, row: int, t: float, out: Any, share: Any, attitude: Any) -> None:
    """Write x, v, a at t in the step from `row` on to out (9n,), the sums since the chunk began to share (8,).

    attitude : (4,), gets that of the target
    """
    u = record_at(address)
    size, net, chunk = 6 * u.n, load(u.net, Net), load(u.chunk, Chunk)
    times, states, slopes, mid = chunk.times, chunk.states, chunk.slopes, np.empty(size)
    put_attitude(chunk, net, row)
    h = times[row + 1] - times[row]
    for q in range(RATES):
        share[q] = chunk.sums[row, q]
    s = (t - times[row]) / h if h > 0.0 else 0.0
    between(h if h > 0.0 else 1.0, s, states[row], slopes[row], states[row + 1], slopes[row + 1], out)
    part = t - times[row]
    if part > 0.0:
        first, half, last = np.empty(RATES), np.empty(RATES), np.empty(RATES)
        rates(times[row], states[row], net, first)
        middle(part, states[row], out[:size], mid)
        rates(times[row] + 0.5 * part, mid, net, half)
        rates(t, out[:size], net, last)
        for q in range(RATES):
            share[q] += part / 6.0 * (first[q] + 4.0 * half[q] + last[q])
    if net.pose != 0:
        pose, at = load(net.pose, Pose), net.spin
        q = attitude_at(pose, rates_of(pose, out, at), rates_of(pose, out, size // 2 + at), t)
        for c in range(4):
            attitude[c] = q[c]
        put_attitude(chunk, net, u.made)
