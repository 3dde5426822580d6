"""Drums in an explicit step: forces that hold or turn them are taken at its end, whatever their stiffness.

A brake is far too stiff for an explicit step: F_b/(v₀ J/R²) is 5e4 1/s for 5 N, 1 mm/s and 0.1 kg; so are a motor's
controller and pawl. Hence the force g on a drum, of all laws that are `implicit`, is taken at the velocity after the
kick,

    v⁺ = v + h (f + g(s, v⁺))/m,

one equation for each drum. Its left side minus its right side has a slope of at least 1 in v⁺, so it has one solution,
found by Newton's method between bounds. A brake then holds at any step length, and keeps the order while it slides.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from netdae.core.addresses import call
from netdae.core.arrays import FloatArray, Reals, Wholes
from netdae.core.compilation import INLINED
from netdae.core.records import Record
from netdae.forces.elements import ElementForce
from netdae.forces.loops import loop_of

ITERATIONS = 60  # bisection alone is at round-off by then


class Drums(NamedTuple):
    """Drums that something holds or turns; q elements act on d drums, those of each drum stored together."""

    entry: Wholes  # (d,), of the drum in x
    begin: Wholes  # (d + 1,), where its elements begin
    function: Wholes  # (q,), address of the law's function, see `forces.loops`
    elements: Wholes  # (q,), address of the force's Elements
    element: Wholes  # (q,), which of them
    out: Reals  # (4,), room for what one element gives


def drums_of(forces: Sequence[ElementForce], records: Sequence[Record]) -> Drums:
    """Drums of forces with implicit laws, with the records of their elements."""
    rows = [
        (3 * int(node), loop_of(force.law, "at_drum").address, record.address, e)
        for force, record in zip(forces, records, strict=True)
        for e, node in enumerate(force.nodes[:, 0])
    ]
    table = np.array(sorted(rows, key=lambda row: row[0]), dtype=np.int64).reshape(len(rows), 4)
    entry, begin = np.unique(table[:, 0], return_index=True)
    function, elements, element = (np.ascontiguousarray(table[:, k]) for k in (1, 2, 3))
    return Drums(entry, np.append(begin, len(rows)), function, elements, element, np.zeros(4))


@njit(cache=True, **INLINED)
def _held_by(drums: Drums, d: int, s: float, v: float, out: FloatArray) -> float:
    """Return g in N on one drum; write its conservative, dissipative and external share, and ∂g/∂v, to out."""
    out[:] = 0.0
    for q in range(drums.begin[d], drums.begin[d + 1]):
        call(drums.function[q], (drums.elements[q], drums.element[q], s, v, out.ctypes.data))
    return out[0] + out[1] + out[2]


@njit(cache=True, **INLINED)
def _kicked(drums: Drums, d: int, s: float, b: float, c: float, near: float, out: FloatArray) -> float:
    """The solution of v⁺ = b + c g(s, v⁺), searched from `near` on."""
    g = _held_by(drums, d, s, b, out)
    low, high = b - abs(c * g), b + abs(c * g)
    v = b
    if low < near < high:
        v = near
        g = _held_by(drums, d, s, v, out)
    for _ in range(ITERATIONS):
        miss = v - b - c * g
        if miss == 0.0:
            break
        if miss > 0.0:
            high = v
        else:
            low = v
        slope = out[3]
        new = v - miss / (1.0 - c * slope)
        parts = abs(out[0]) + abs(out[1]) + abs(out[2])
        if abs(new - v) <= 2e-15 * (abs(new) + (abs(b) + c * parts) / (1.0 - c * slope)):  # round-off
            break
        if not low < new < high:
            new = 0.5 * (low + high)
        v = new
        g = _held_by(drums, d, s, v, out)
    return v


@njit(cache=True, **INLINED)
def hold_drums(
    x: FloatArray, v: FloatArray, share: FloatArray, f: FloatArray, h: float, drums: Drums
) -> tuple[float, float]:
    """Add the forces on drums to f, which holds all others; return the powers in W that they take and give."""
    lost, given, out = 0.0, 0.0, drums.out
    for d in range(len(drums.entry)):
        i = drums.entry[d]
        c = h * share[i]  # zero where the drum is driven
        after = _kicked(drums, d, x[i], v[i] + c * f[i], c, v[i], out)
        f[i] += _held_by(drums, d, x[i], after, out)
        mean = v[i] + 0.5 * c * f[i]
        lost -= out[1] * mean
        given += out[2] * mean
    return lost, given
