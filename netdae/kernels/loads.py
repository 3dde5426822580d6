"""Loads for the kernel of `explicit.verlet`, and the books of what is outside: one row (6,) of force and torque."""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.kernels.cables import FAST


class Pushes(NamedTuple):
    """Loads: the force weight · signal at each of q nodes, in g groups of one signal each."""

    node: IntArray  # (q,), 3i
    weight: FloatArray  # (q,)
    signal: IntArray  # (q,), which signal
    begin: IntArray  # (g + 1,), where each group begins
    total: FloatArray  # (g,), sum of the weights
    in_space: BoolArray  # (g,)


@njit(cache=True, fastmath=FAST)
def push(pushes: Pushes, signal: FloatArray, p: FloatArray) -> None:
    """The loads' forces p (3n,)."""
    for i in range(len(p)):
        p[i] = 0.0
    for q in range(len(pushes.node)):
        for c in range(3):
            p[pushes.node[q] + c] += pushes.weight[q] * signal[pushes.signal[q], c]


@njit(cache=True, fastmath=FAST)
def find_moments(x: FloatArray, pushes: Pushes, moments: FloatArray) -> None:
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
def add_loads(pushes: Pushes, moments: FloatArray, signal: FloatArray, row: FloatArray) -> None:
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
def add_force(x: FloatArray, node: int, c: int, F: float, in_space: BoolArray, row: FloatArray) -> None:
    """Row (6,) gains a force F along the axis c on a node, and its torque."""
    if in_space[node]:
        row[c] += F
        row[3 + (c + 1) % 3] += x[3 * node + (c + 2) % 3] * F
        row[3 + (c + 2) % 3] -= x[3 * node + (c + 1) % 3] * F
