"""Triangulated surfaces of shapes, for pictures and for integrals over polyhedra.

Triangles are counter-clockwise seen from outside.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from netdae.core.arrays import FloatArray, IntArray

AROUND = 48  # segments of a circle: a chord is 0.2 % of the radius off


class Surface(NamedTuple):
    """A triangulated surface.

    points : (n, 3), m, in the part's frame, or the body's; triangles : (m, 3), indices of points
    """

    points: FloatArray
    triangles: IntArray

    def placed(self, position: FloatArray, axes: FloatArray) -> Surface:
        """The surface with its points b = position + axes q."""
        return Surface(position + self.points @ axes.T, self.triangles)


def joined(surfaces: list[Surface]) -> Surface:
    """Several surfaces as one."""
    starts = np.cumsum([0, *(len(each.points) for each in surfaces)])
    return Surface(
        np.concatenate([each.points for each in surfaces]),
        np.concatenate([each.triangles + start for each, start in zip(surfaces, starts, strict=False)]),
    )


def revolved(profile: FloatArray, around: int = AROUND) -> Surface:
    """Surface that a profile (k, 2) of r and z draws around the z axis; it begins at the bottom and ends at the top.

    Its first and last points are moved to the axis.
    """
    angle = 2.0 * np.pi * np.arange(around) / around
    rings = profile[1:-1]
    r, z = rings[:, :1], np.repeat(rings[:, 1:], around, axis=1)
    sides = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=2).reshape(-1, 3)
    ends = np.array([[0.0, 0.0, profile[0, 1]], [0.0, 0.0, profile[-1, 1]]])
    here = np.arange(around)
    there = (here + 1) % around
    bottom, top = len(sides), len(sides) + 1
    last = around * (len(rings) - 1)
    triangles = [
        np.column_stack([np.full(around, bottom), there, here]),
        np.column_stack([np.full(around, top), last + here, last + there]),
    ]
    for low in range(0, last, around):
        a, b, c, d = low + here, low + there, low + around + here, low + around + there
        triangles += [np.column_stack([a, b, d]), np.column_stack([a, d, c])]
    return Surface(np.concatenate([sides, ends]), np.concatenate(triangles).astype(np.int64))


def block(half: FloatArray) -> Surface:
    """Surface of a box of half edges (3,)."""
    corner = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)], dtype=np.float64)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return polyhedron(corner * half, faces)


def distinct(points: FloatArray, near: float) -> tuple[IntArray, IntArray]:
    """Indices of points (n, 3) of which none is within `near` m of another, and for each point which it is, (n,).

    Chains of near points are one.
    """
    _, first, exact = np.unique(points, axis=0, return_index=True, return_inverse=True)
    pairs = cKDTree(points[first]).query_pairs(near, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(first), len(first)))
    _, cluster = connected_components(graph, directed=False)
    _, chosen, cluster = np.unique(cluster, return_index=True, return_inverse=True)
    return first[chosen], cluster[exact.reshape(-1)]


def polyhedron(points: FloatArray, faces: Sequence[tuple[int, ...]]) -> Surface:
    """Surface of convex faces, each given by its corners."""
    fans = [(face[0], face[i], face[i + 1]) for face in faces for i in range(1, len(face) - 1)]
    return Surface(points, np.array(fans, dtype=np.int64))
