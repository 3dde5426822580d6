"""Where a net is closest to a rigid body, and whether it begins inside.

A cable is straight from knot to knot. φ changes along it by its length at most, times the Lipschitz constant C of φ, so
φ ≥ ½ (φᵢ + φⱼ − C l) on a cable of length l between knots with φᵢ and φⱼ. Cables for which this bound is not below what
the knots have are left out; others are searched at points of a fixed spacing, and once more about the least of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.model.shapes.distance import closest_parts
from netdae.model.shapes.kinds import Parts
from netdae.model.shapes.part import Part, axes_of, parts_of
from netdae.model.target import Obstacle, Target

_POINTS = 33  # along a cable, in each of two rounds: to a 512th of its length


class Nearest(NamedTuple):
    """The point of a net with the least signed distance to a body.

    distance : φ, m, negative inside; point : (3,), m, in space; part : of the body
    cable : that it is on, or −1 at a knot without cable; node : the knot, or −1 where it is between two
    """

    distance: float
    point: FloatArray
    part: int
    cable: int
    node: int


class Placed(NamedTuple):
    """A body at its place: x = position + axes b."""

    parts: tuple[Part, ...]
    position: FloatArray
    axes: FloatArray


def placed(body: Target | Obstacle) -> Placed:
    """A target where it starts, or an obstacle."""
    if isinstance(body, Obstacle):
        return Placed((body.part,), np.zeros(3), np.eye(3))
    return Placed(body.parts, body.position, axes_of(body.attitude))


def nearest(body: Placed, x: FloatArray, cables: IntArray, nodes: Sequence[int] | IntArray) -> Nearest:
    """The point of knots `nodes` at x (n, 3), and of cables (m, 2), that is nearest to a body, or deepest in it."""
    parts = parts_of(body.parts)
    b = (x - body.position) @ body.axes
    of_nodes = np.full(len(x), np.inf)
    at = np.asarray(nodes, dtype=np.int64)
    of_nodes[at], which = distances(parts, b[at])
    k = int(np.argmin(of_nodes[at]))
    best = Nearest(float(of_nodes[at][k]), x[at[k]], int(which[k]), -1, int(at[k]))
    i, j = cables.T
    length = np.linalg.norm(x[j] - x[i], axis=1)
    bound = 0.5 * (of_nodes[i] + of_nodes[j] - float(parts.lipschitz.max()) * length)
    for cable in np.flatnonzero(bound < best.distance)[np.argsort(bound[bound < best.distance])]:
        if bound[cable] >= best.distance:
            break  # the others have larger bounds
        low, high = 0.0, 1.0
        for _ in range(2):
            s = np.linspace(low, high, _POINTS)
            points = (1.0 - s)[:, None] * b[i[cable]] + s[:, None] * b[j[cable]]
            found, which = distances(parts, points)
            k = int(np.argmin(found))
            low, high = s[max(k - 1, 0)], s[min(k + 1, _POINTS - 1)]
        if found[k] < best.distance:
            point = body.position + body.axes @ points[k]
            best = Nearest(float(found[k]), point, int(which[k]), int(cable), -1)
    return best


def distances(parts: Parts, points: FloatArray) -> tuple[FloatArray, IntArray]:
    """The least φ over all parts at points (n, 3) of the body's frame, (n,), and the part, (n,)."""
    return closest_parts(parts.kind, parts.first, parts.numbers, np.ascontiguousarray(points))
