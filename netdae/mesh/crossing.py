"""Edges of a triangle mesh that pass through its triangles."""

from __future__ import annotations

import numpy as np
from numba import njit

from netdae.core.arrays import FloatArray, IntArray
from netdae.mesh.closest import DEPTH, Tree

_NEAR = 1e-9  # of the size: an edge that ends this close to a triangle only touches it


def crossing_of(tree: Tree, triangles: IntArray, points: FloatArray) -> tuple[int, IntArray, int]:
    """How many edges pass through a triangle, and the first: its ends (2,) and the triangle.

    An edge that shares a corner with a triangle cannot pass through it.
    """
    ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    edges = np.unique(ends, axis=0)
    size = float(np.ptp(points, axis=0).max())
    count, edge, triangle = _crossings(tree, triangles, points, edges, _NEAR * size)
    return count, edges[edge], triangle


@njit(cache=True, error_model="numpy")
def _crossings(
    tree: Tree, triangles: IntArray, points: FloatArray, edges: IntArray, near: float
) -> tuple[int, int, int]:
    stack = np.empty(DEPTH, np.int64)
    count, edge, triangle = 0, 0, -1
    for k in range(len(edges)):
        i, j = edges[k, 0], edges[k, 1]
        stack[0] = 0
        height = 1
        while height > 0:
            height -= 1
            box = stack[height]
            apart = False
            for axis in range(3):
                low, high = points[i, axis], points[j, axis]
                apart |= max(low, high) < tree.low[box, axis] or min(low, high) > tree.high[box, axis]
            if apart:
                continue
            child = tree.child[box]
            if child != 0:
                stack[height], stack[height + 1] = child, child + 1
                height += 2
                continue
            for m in range(tree.first[box], tree.first[box] + tree.size[box]):
                t = tree.triangles[m]
                shared = False
                for corner in range(3):
                    shared |= triangles[t, corner] == i or triangles[t, corner] == j
                if not shared and _passes(points[i], points[j], tree.corners[t], near):
                    if count == 0:
                        edge, triangle = k, t
                    count += 1
    return count, edge, triangle


@njit(cache=True, forceinline=True, error_model="numpy")
def _passes(p: FloatArray, q: FloatArray, corners: FloatArray, near: float) -> bool:
    """Whether a segment passes through the inner of a triangle, farther than `near` from all of its edges and ends."""
    ux, uy, uz = corners[1, 0] - corners[0, 0], corners[1, 1] - corners[0, 1], corners[1, 2] - corners[0, 2]
    wx, wy, wz = corners[2, 0] - corners[0, 0], corners[2, 1] - corners[0, 1], corners[2, 2] - corners[0, 2]
    nx, ny, nz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
    double = np.sqrt(nx * nx + ny * ny + nz * nz)
    if double <= near * near:
        return False
    nx, ny, nz = nx / double, ny / double, nz / double
    height = nx * corners[0, 0] + ny * corners[0, 1] + nz * corners[0, 2]
    above = nx * p[0] + ny * p[1] + nz * p[2] - height
    below = nx * q[0] + ny * q[1] + nz * q[2] - height
    if above * below >= 0.0 or abs(above) <= near or abs(below) <= near:
        return False
    s = above / (above - below)
    x, y, z = p[0] + s * (q[0] - p[0]), p[1] + s * (q[1] - p[1]), p[2] + s * (q[2] - p[2])
    for k in range(3):
        end = (k + 1) % 3
        ux, uy, uz = x - corners[k, 0], y - corners[k, 1], z - corners[k, 2]
        wx, wy, wz = (
            corners[end, 0] - corners[k, 0],
            corners[end, 1] - corners[k, 1],
            corners[end, 2] - corners[k, 2],
        )
        # n × w points inwards, and is as long as w
        inward = ux * (ny * wz - nz * wy) + uy * (nz * wx - nx * wz) + uz * (nx * wy - ny * wx)
        if inward <= near * np.sqrt(wx * wx + wy * wy + wz * wz):
            return False
    return True
