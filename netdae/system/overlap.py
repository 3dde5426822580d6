"""Where a net is closest to a rigid body, and how much of it touches it.

Distances are those of the cords' surfaces: φ less their radius r, and at a knot that of its thickest cord.

A cable is straight from knot to knot, x(s) = xᵢ + s d. Of a convex part φ is convex along it: its least value is at i
where d·n ≥ 0 there, at j where d·n ≤ 0 there, and otherwise between, not below the point where the two tangents meet;
it is found by bisection of the slope. Of any other part φ changes by the way times its Lipschitz constant C at most, so
that φ ≥ ½ (φᵢ + φⱼ − C l) for a length l; it is searched at points of a fixed spacing, and once more about the least of
them. Cables whose bound is neither below the least so far nor below r are left out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.model.material import Cords
from netdae.model.net import CableNet
from netdae.model.shapes.distance import signed_distance
from netdae.model.shapes.kinds import Parts
from netdae.model.shapes.part import Part, axes_of, parts_of
from netdae.model.target import Obstacle, Target

_HALVINGS = 20  # of a cable: to a millionth of its length
_POINTS = 33  # along a cable at a part that is not convex, in each of two rounds: to a 512th of its length


class Nearest(NamedTuple):
    """The point of a net with the least signed distance to a body.

    distance : φ − r, m, negative where it touches; point : (3,), m, in the frame of the net; part : of the body
    cable : that it is on, or −1 at a knot; node : the knot, or −1 where it is between two
    inside : how many knots and cables touch the body
    """

    distance: float
    point: FloatArray
    part: int
    cable: int
    node: int
    inside: int


class Placed(NamedTuple):
    """A body at its place: x = position + axes b."""

    parts: Parts
    position: FloatArray
    axes: FloatArray


def placed(body: Target | Obstacle) -> Placed:
    """A target where it starts, or an obstacle."""
    if isinstance(body, Obstacle):
        return Placed(parts_of((body.part,)), np.zeros(3), np.eye(3))
    return Placed(parts_of(body.parts), body.position, axes_of(body.attitude))


def parts_in(body: Target | Obstacle) -> tuple[Part, ...]:
    """The parts of a body."""
    return (body.part,) if isinstance(body, Obstacle) else body.parts


class Knots(NamedTuple):
    """What of a net may touch.

    shown : (n,), True at knots and bullets, False at drums and at the target
    cables : (m, 2); node_radius, cable_radius : (n,) and (m,), m
    """

    shown: BoolArray
    cables: IntArray
    node_radius: FloatArray
    cable_radius: FloatArray

    @classmethod
    def of(cls, net: CableNet, cords: Cords, shown: BoolArray) -> Knots:
        """Those of a net."""
        thick, at_knot = np.sqrt(cords.area / np.pi), np.zeros(net.node_count)
        np.maximum.at(at_knot, net.cables, thick[:, None])
        return cls(np.ascontiguousarray(shown), net.cables, at_knot, thick)


def nearest(body: Placed, x: FloatArray, knots: Knots) -> Nearest:
    """The point of a net with its nodes at x (n, 3) that is nearest to a body."""
    parts = body.parts
    b = np.ascontiguousarray((x - body.position) @ body.axes)
    steepest = float(parts.lipschitz.max())
    distance, s, part, cable, node, inside = _nearest(
        parts.kind, parts.first, parts.numbers, parts.convex, steepest, b, *knots
    )
    if cable >= 0:
        i, j = knots.cables[cable]
        return Nearest(distance, (1.0 - s) * x[i] + s * x[j], part, cable, -1, inside)
    return Nearest(distance, np.array(x[node]), part, -1, node, inside)


def gaps(body: Placed, x: FloatArray) -> FloatArray:
    """φ at points x (n, 3), (n,), m."""
    parts = body.parts
    return _gaps(
        parts.kind, parts.first, parts.numbers, np.ascontiguousarray((x - body.position) @ body.axes)
    )


@njit(cache=True, forceinline=True)
def _least(
    kind: IntArray, first: IntArray, numbers: FloatArray, x: float, y: float, z: float
) -> tuple[float, int]:
    least, part = np.inf, 0
    for p in range(len(kind)):
        phi = signed_distance(kind[p], first[p], numbers, x, y, z)[0]
        if phi < least:
            least, part = phi, p
    return least, part


@njit(cache=True)
def _gaps(kind: IntArray, first: IntArray, numbers: FloatArray, b: FloatArray) -> FloatArray:
    phi = np.empty(len(b))
    for i in range(len(b)):
        phi[i] = _least(kind, first, numbers, b[i, 0], b[i, 1], b[i, 2])[0]
    return phi


@njit(cache=True, forceinline=True)
def _along(
    kind: int,
    first: int,
    numbers: FloatArray,
    convex: bool,
    steepest: float,
    a: tuple[float, float, float],
    d: tuple[float, float, float],
    enough: float,
) -> tuple[float, float]:
    """The least φ of a part along a cable from a to a + d, and its s; infinite where it is not below `enough`."""
    start = signed_distance(kind, first, numbers, a[0], a[1], a[2])
    end = signed_distance(kind, first, numbers, a[0] + d[0], a[1] + d[1], a[2] + d[2])
    if not convex:
        length = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        if not 0.5 * (start[0] + end[0] - steepest * length) < enough:
            return np.inf, 0.0
        low, high, least, where = 0.0, 1.0, np.inf, 0.0
        for _ in range(2):
            width, begin = (high - low) / (_POINTS - 1), low
            for k in range(_POINTS):
                s = begin + k * width
                phi = signed_distance(
                    kind, first, numbers, a[0] + s * d[0], a[1] + s * d[1], a[2] + s * d[2]
                )[0]
                if phi < least:
                    least, where = phi, s
            low, high = max(where - width, 0.0), min(where + width, 1.0)
        return least, where
    falls = start[1] * d[0] + start[2] * d[1] + start[3] * d[2]
    rises = end[1] * d[0] + end[2] * d[1] + end[3] * d[2]
    if not falls < 0.0:
        return start[0], 0.0
    if not rises > 0.0:
        return end[0], 1.0
    meet = (end[0] - rises - start[0]) / (falls - rises)
    if not start[0] + meet * falls < enough:
        return np.inf, 0.0
    low, high, least, where = 0.0, 1.0, min(start[0], end[0]), 0.0 if start[0] < end[0] else 1.0
    for _ in range(_HALVINGS):
        s = 0.5 * (low + high)
        now = signed_distance(kind, first, numbers, a[0] + s * d[0], a[1] + s * d[1], a[2] + s * d[2])
        if now[0] < least:
            least, where = now[0], s
        if now[1] * d[0] + now[2] * d[1] + now[3] * d[2] < 0.0:
            low = s
        else:
            high = s
    return least, where


@njit(cache=True)
def _nearest(
    kind: IntArray,
    first: IntArray,
    numbers: FloatArray,
    convex: BoolArray,
    steepest: float,
    b: FloatArray,
    shown: BoolArray,
    cables: IntArray,
    node_radius: FloatArray,
    cable_radius: FloatArray,
) -> tuple[float, float, int, int, int, int]:
    """φ − r, s along the cable, part, cable, node, and the number inside."""
    best, at, part, cable, node, inside = np.inf, 0.0, 0, -1, -1, 0
    for i in range(len(b)):
        if shown[i]:
            phi, which = _least(kind, first, numbers, b[i, 0], b[i, 1], b[i, 2])
            inside += phi < node_radius[i]
            if phi - node_radius[i] < best:
                best, part, node = phi - node_radius[i], which, i
    for e in range(len(cables)):
        i, j, r = cables[e, 0], cables[e, 1], cable_radius[e]
        a = b[i, 0], b[i, 1], b[i, 2]
        d = b[j, 0] - b[i, 0], b[j, 1] - b[i, 1], b[j, 2] - b[i, 2]
        touches = False
        for p in range(len(kind)):
            enough = max(best, 0.0) + r
            phi, s = _along(kind[p], first[p], numbers, convex[p], steepest, a, d, enough)
            touches = touches or phi < r
            if phi - r < best:
                best, at, part, cable, node = phi - r, s, p, e, -1
        inside += touches
    return best, at, part, cable, node, inside
