"""Opening of a pack: whether the net would have to pass through itself.

Symbols: s from 0, packed, to 1, open; ends of the two cables of a pair a, b and c, d, each (3,) and linear in s.

Contact of the net with itself is not modelled, so cables pass through each other unhindered. Whether they have to
depends on the whole flight; what is tested here is the simplest way from the pack to the open net, on which every
knot goes straight to its place and all arrive together:

    x(s) = (1 − s) x_pack + s x̄.

Two cables that are straight between their knots meet where

    V(s) = (b − a) · ((c − a) × (d − a)) = 0,

a cubic. Every change of sign between `SAMPLES` times is found by bisection, and counted where the two lines cross
inside both cables. A pack without such a crossing can be opened without one. A pack with crossings may still open
another way (layers peeled off one after another), so they are a warning, not an error; and cables that only touch, or
stay in one plane, as in a net that is drawn together flat, do not count. In a net of more than `MOST_CABLES` cables,
only that many, evenly chosen, are tested.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from netdae.core.arrays import FloatArray, IntArray
from netdae.model.net import CableNet
from netdae.model.state import State

SAMPLES = 33
"""Times at which V is evaluated; the last of them is `LAST`."""

LAST = 0.97
"""Part of the way that is searched for crossings: at the end all cables of a flat net lie in one plane."""

MOST_CABLES = 1500
"""Most cables that are tested, each against each."""


class Crossings(NamedTuple):
    """Pairs of cables that cross while a pack opens on straight lines.

    pairs : found; tested : cables that were tested, each against each
    first : two cables that cross earliest, −1 without any; way : share of the way at which they do
    """

    pairs: int
    tested: int
    first: tuple[int, int]
    way: float


def crossings_of(net: CableNet, start: State) -> Crossings:
    """Crossings on the way from `start` to x̄, both about their own middle."""
    chosen = np.unique(np.linspace(0, net.cable_count - 1, MOST_CABLES).round().astype(np.int64))
    pack, flat = start.x - start.x.mean(axis=0), net.nodes - net.nodes.mean(axis=0)
    ends = np.stack([pack[net.cables[chosen]], flat[net.cables[chosen]] - pack[net.cables[chosen]]])
    count, e, f, way = _crossings(ends, np.ascontiguousarray(net.cables[chosen]))
    first = (int(chosen[e]), int(chosen[f])) if count else (-1, -1)
    return Crossings(int(count), len(chosen), first, float(way))


def opening_finding(net: CableNet, start: State) -> str:
    """Message that a pack would pass through itself while it opens; empty where it need not."""
    found = crossings_of(net, start)
    if not found.pairs:
        return ""
    pairs = "1 pair" if found.pairs == 1 else f"{found.pairs} pairs"
    part = "" if found.tested == net.cable_count else f" of {found.tested} tested"
    return (
        f"the pack would pass through itself while opening: on straight lines to the open net {pairs} of "
        f"cables{part} cross, first cables {found.first[0]} and {found.first[1]} at {100 * found.way:.0f} % "
        "of the way; contact of the net with itself is not modelled"
    )


Triple = tuple[float, float, float]


@njit(cache=True, forceinline=True)
def _triple(u: Triple, v: Triple, w: Triple) -> float:
    """u · (v × w)."""
    return (
        u[0] * (v[1] * w[2] - v[2] * w[1])
        + u[1] * (v[2] * w[0] - v[0] * w[2])
        + u[2] * (v[0] * w[1] - v[1] * w[0])
    )


@njit(cache=True, forceinline=True)
def _span(a: FloatArray, b: FloatArray) -> Triple:
    """b − a; a tuple, which costs no memory."""
    return b[0] - a[0], b[1] - a[1], b[2] - a[2]


@njit(cache=True, forceinline=True)
def _squares(u: Triple, v: Triple) -> float:
    """u² + v²."""
    return u[0] * u[0] + u[1] * u[1] + u[2] * u[2] + v[0] * v[0] + v[1] * v[1] + v[2] * v[2]


@njit(cache=True, forceinline=True)
def _inside(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> bool:
    """Whether the lines a b and c d, which lie in one plane, cross inside of both."""
    p, q, r = b - a, d - c, c - a
    pp, qq, pq = np.dot(p, p), np.dot(q, q), np.dot(p, q)
    det = pp * qq - pq * pq
    if det <= 1e-12 * pp * qq:  # parallel
        return False
    rp, rq = np.dot(r, p), np.dot(r, q)
    along = (rp * qq - rq * pq) / det
    other = (rp * pq - rq * pp) / det
    edge = 1e-6  # cables that meet at their ends touch
    return edge < along < 1 - edge and edge < other < 1 - edge


@njit(cache=True, forceinline=True)
def _way_of_crossing(x: FloatArray, y: FloatArray, dx: FloatArray, dy: FloatArray) -> float:
    """Share of the way at which cables x and y (2, 3) that move by dx, dy cross first; 2 where they do not."""
    u, du = _span(x[0], x[1]), _span(dx[0], dx[1])
    v, dv = _span(x[0], y[0]), _span(dx[0], dy[0])
    w, dw = _span(x[0], y[1]), _span(dx[0], dy[1])
    c0 = _triple(u, v, w)
    c1 = _triple(du, v, w) + _triple(u, dv, w) + _triple(u, v, dw)
    c2 = _triple(u, dv, dw) + _triple(du, v, dw) + _triple(du, dv, w)
    c3 = _triple(du, dv, dw)
    # round-off of coplanar cables
    size = np.sqrt(_squares(u, du) * _squares(v, dv) * _squares(w, dw))
    if max(abs(c0), abs(c1), abs(c2), abs(c3)) <= 1e-12 * size:
        return 2.0
    # a cubic lies between the least and the largest of its Bézier points
    b1, b2 = c0 + LAST * c1 / 3, c0 + LAST * (2 * c1 + LAST * c2) / 3
    b3 = c0 + LAST * (c1 + LAST * (c2 + LAST * c3))
    if min(c0, b1, b2, b3) > 0.0 or max(c0, b1, b2, b3) < 0.0:
        return 2.0
    before = c0
    for k in range(1, SAMPLES):
        s = LAST * k / (SAMPLES - 1)
        value = c0 + s * (c1 + s * (c2 + s * c3))
        if before * value < 0.0:
            low, high = s - LAST / (SAMPLES - 1), s
            for _ in range(50):
                middle = 0.5 * (low + high)
                at = c0 + middle * (c1 + middle * (c2 + middle * c3))
                if at * before > 0.0:
                    low = middle
                else:
                    high = middle
            if _inside(x[0] + high * dx[0], x[1] + high * dx[1], y[0] + high * dy[0], y[1] + high * dy[1]):
                return high
        if value != 0.0:
            before = value
    return 2.0


@njit(cache=True)
def _crossings(ends: FloatArray, cables: IntArray) -> tuple[int, int, int, float]:
    """Number of crossing pairs, the earliest of them and its share of the way, of ends and their moves (2, m, 2, 3)."""
    count, first, second, earliest = 0, -1, -1, 2.0
    for e in range(len(cables)):
        i, j = cables[e, 0], cables[e, 1]
        for f in range(e):
            others = (cables[f, 0], cables[f, 1])
            if i in others or j in others:
                continue
            way = _way_of_crossing(ends[0, e], ends[0, f], ends[1, e], ends[1, f])
            if way <= 1.0:
                count += 1
                if way < earliest:
                    first, second, earliest = f, e, way
    return count, first, second, earliest
