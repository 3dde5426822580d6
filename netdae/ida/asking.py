"""How compiled code of IDA's driver asks Python, see `ida.asked`: one function of C, and arrays that both see."""

from __future__ import annotations

import numpy as np
from numba import njit

from netdae._arrays import FloatArray
from netdae.ida.addresses import call, floats, ints
from netdae.ida.further import further_at

FORCES, TANGENTS, POWERS, HELD = 0, 1, 2, 3
"""What is asked for."""


@njit(cache=True)
def asks_held(address: int) -> bool:
    """Whether restrained axes are asked for."""
    return further_at(address).asks_held != 0


@njit(cache=True)
def asking_failed(address: int) -> bool:
    """Whether a call has failed."""
    return further_at(address).asked_failed != 0


@njit(cache=True)
def ask_held(address: int, t: float) -> None:
    """Put restrained axes where they belong at t."""
    u = further_at(address)
    if u.asks_held != 0:
        call(u.ask, (t, np.int32(HELD)))


@njit(cache=True)
def _tell(address: int, x: FloatArray, v: FloatArray) -> None:
    u = further_at(address)
    n3 = 3 * u.n
    y = floats(u.asked_y, 2 * n3)
    for k in range(n3):
        y[k], y[n3 + k] = x[k], v[k]


@njit(cache=True)
def add_asked_forces(address: int, t: float, x: FloatArray, v: FloatArray, f: FloatArray) -> None:
    """Add the forces that are asked for to f (3n,)."""
    u = further_at(address)
    if u.asks_forces == 0:
        return
    _tell(address, x, v)
    call(u.ask, (t, np.int32(FORCES)))
    asked = floats(u.asked_f, 3 * u.n)
    for k in range(len(asked)):
        f[k] += asked[k]


@njit(cache=True)
def add_asked_rates(address: int, t: float, x: FloatArray, v: FloatArray, out: FloatArray) -> None:
    """Add their powers, force and torque to out (8,), see `ida.books`."""
    u = further_at(address)
    if u.asks_forces == 0:
        return
    _tell(address, x, v)
    call(u.ask, (t, np.int32(POWERS)))
    asked = floats(u.asked_rates, 8)
    for q in range(8):
        out[q] += asked[q]


@njit(cache=True)
def add_asked_blocks(
    address: int, t: float, x: FloatArray, v: FloatArray, cj: float, free: FloatArray, K: FloatArray
) -> None:
    """Add the symmetric parts of their T + c_j D to K, and keep D for the products."""
    u = further_at(address)
    if u.asked_blocks == 0:
        return
    _tell(address, x, v)
    call(u.ask, (t, np.int32(TANGENTS)))
    m = u.asked_blocks
    block, low, high = ints(u.asked_block, m), ints(u.asked_low, m), ints(u.asked_high, m)
    T, D = floats(u.asked_T, (m, 3, 3)), floats(u.asked_D, (m, 3, 3))
    for b in range(m):
        for r in range(3):
            for c in range(3):
                value = T[b, r, c] + cj * D[b, r, c]
                if len(free):
                    value *= free[3 * low[b] + r] * free[3 * high[b] + c]
                K[block[b], r, c] += value


@njit(cache=True)
def add_asked_products(address: int, r1: FloatArray, right: FloatArray) -> None:
    """right (3n,) gains D r₁."""
    u = further_at(address)
    m = u.asked_blocks
    low, high, D = ints(u.asked_low, m), ints(u.asked_high, m), floats(u.asked_D, (m, 3, 3))
    for b in range(m):
        i, j = 3 * low[b], 3 * high[b]
        for r in range(3):
            for c in range(3):
                right[i + r] += D[b, r, c] * r1[j + c]
                if i != j:
                    right[j + c] += D[b, r, c] * r1[i + r]
