"""External force and torque about the origin, in a row (6,), of forces on nodes; those of reels have no part in it."""

from __future__ import annotations

from numba import njit

from netdae.core.arrays import BoolArray, FloatArray
from netdae.core.compilation import FAST


@njit(cache=True, fastmath=FAST, forceinline=True)
def add_force(x: FloatArray, i: int, F: float, in_space: BoolArray, row: FloatArray) -> None:
    """Add a force F, N, along the entry i of x (3n,)."""
    node, c = i // 3, i % 3
    if in_space[node]:
        row[c] += F
        row[3 + (c + 1) % 3] += x[3 * node + (c + 2) % 3] * F
        row[3 + (c + 2) % 3] -= x[3 * node + (c + 1) % 3] * F


@njit(cache=True, fastmath=FAST, forceinline=True)
def add_brakes(x: FloatArray, v: FloatArray, alpha: FloatArray, in_space: BoolArray, row: FloatArray) -> None:
    """Add the forces of α M (3n,) on all nodes, which are external; none where alpha is empty."""
    for i in range(len(alpha)):
        add_force(x, i, -alpha[i] * v[i], in_space, row)


@njit(cache=True, fastmath=FAST, forceinline=True)
def add_slow_wrench(
    x: FloatArray, slow: FloatArray, in_space: BoolArray, first: int, last: int, row: FloatArray
) -> None:
    """Add the slow forces on the entries from `first` to `last`; none where slow is empty."""
    fx = fy = fz = tx = ty = tz = 0.0
    for i in range(first, last if len(slow) > 0 else first, 3):
        if in_space[i // 3]:
            a, b, c = slow[i], slow[i + 1], slow[i + 2]
            px, py, pz = x[i], x[i + 1], x[i + 2]
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
