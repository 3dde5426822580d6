"""A chunk of IDA's steps without Python: the loop around IDASolve, which keeps states and books of each step."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from netdae.ida.addresses import call, floats, ints
from netdae.ida.asking import asking_failed
from netdae.ida.books import RATES, between, middle, rates
from netdae.ida.failures import STANDS_STILL, STUCK, WOUND_IN
from netdae.ida.further_calls import wound_in_whole
from netdae.ida.kernel import OPTIONS
from netdae.ida.layout import RECORD, net_of, record_at

_ONE_STEP = 2  # IDA_ONE_STEP
_ERRORS_FAILED = RECORD.fields["errors_failed"][1]  # type: ignore[index]


@njit(nogil=True, **OPTIONS)
def begin_books(address: int, row: int) -> float:
    """The rates with which the books go on from a row of the chunk; the largest tension there, N."""
    u = record_at(address)
    t, y = floats(u.times, row + 1)[row], floats(u.states, (row + 1, 6 * u.n))[row]
    return rates(t, y, net_of(u), floats(u.rates, RATES))


@njit(nogil=True, **OPTIONS)
def fly(address: int, row: int, count: int, stop: float, span: float) -> int:
    """Up to `count` steps from the state in `row`, not beyond `stop` and no more than `span` seconds; IDA's last code.

    A step in which a cord is wound in whole does not count; it stands in the row after `made`.
    The chunk's rows 0 to `made` are then times, states (x, v), slopes (ẋ, v̇), books from its begin on, and tensions.
    """
    u = record_at(address)
    size, net = 6 * u.n, net_of(u)
    times, states, slopes = (
        floats(u.times, count + 1),
        floats(u.states, (count + 1, size)),
        floats(u.slopes, (count + 1, size)),
    )
    books, tensions, now = (
        floats(u.books, (count + 1, RATES)),
        floats(u.tensions, count + 1),
        floats(u.rates, RATES),
    )
    half, mid, clock = floats(u.middle_rates, RATES), floats(u.middle, size), floats(u.clock, 1)
    if row > 0:
        last, slope = floats(u.states, (row + 1, size))[row], floats(u.slopes, (row + 1, size))[row]
        for q in range(size):
            states[0, q], slopes[0, q] = last[q], slope[q]
        times[0] = floats(u.times, row + 1)[row]
    for q in range(RATES):
        books[0, q] = 0.0
    then = np.empty(RATES)
    code, made = 0, 0
    while made < count and times[made] < stop and times[made] - times[0] < span:
        k, t = made, times[made]
        y = states[k + 1]
        ints(ints(u.y, 1)[0], 2)[1] = u.states + 8 * size * (k + 1)
        ints(ints(u.yp, 1)[0], 2)[1] = u.slopes + 8 * size * (k + 1)
        code = call(u.ida_solve, (u.memory, stop, u.clock, u.y, u.yp, np.int32(_ONE_STEP)))
        if code < 0:
            break
        times[made + 1] = clock[0]
        if net.further != 0 and wound_in_whole(net.further, y):
            code = WOUND_IN
            break
        made += 1
        h = clock[0] - t
        for q in range(RATES):
            then[q] = now[q]
        tensions[made] = rates(clock[0], y, net, now)
        if h > 0.0:
            middle(h, states[k], y, mid)
            rates(t + 0.5 * h, mid, net, half)
        for q in range(RATES):
            books[made, q] = books[k, q] + h / 6.0 * (then[q] + 4.0 * half[q] + now[q])
        if net.further != 0 and asking_failed(net.further):
            made -= 1
            break
        u.stuck = u.stuck + 1 if h <= 8.9e-16 * abs(clock[0]) else 0
        if u.stuck > STUCK:
            code = STANDS_STILL
            break
    u.made = made
    call(u.error_test_fails, (u.memory, address + _ERRORS_FAILED))
    return code


@njit(nogil=True, **OPTIONS)
def inside(address: int, row: int, t: float, out: Any, share: Any) -> None:
    """x, v, a at t in the step that begins at `row` into out (9n,), the books since the chunk began into share (8,)."""
    u = record_at(address)
    size, net = 6 * u.n, net_of(u)
    times, states, slopes = (
        floats(u.times, row + 2),
        floats(u.states, (row + 2, size)),
        floats(u.slopes, (row + 2, size)),
    )
    books, mid = floats(u.books, (row + 2, RATES)), np.empty(size)
    h = times[row + 1] - times[row]
    for q in range(RATES):
        share[q] = books[row, q]
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
