"""The closest point of a closed triangle mesh, and on which side of it a point is.

A tree of boxes, with at most four triangles in a leaf, is searched from the nearer box on; each point begins with the
triangle of the point before it. Inside is where (p − c) · n < 0, with c the closest point and n the normal of the face,
at an edge the sum of the unit normals of its two faces, at a vertex their sum weighted by the angles there (Bærentzen
and Aanæs, IEEE Trans. Vis. Comput. Graph. 11 (2005) 243): right for every closed mesh that is consistently wound and
does not cross itself.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from netdae.core.arrays import FloatArray, IntArray

_LEAF = 4
DEPTH = 96  # of the stack; halving 2⁴⁸ triangles needs less


class Tree(NamedTuple):
    """Boxes around triangles.

    low, high : (K, 3), corners of the boxes
    child : (K,), the first of two children, which follow one another; 0 for a leaf
    first, size : (K,), the triangles of a leaf in `triangles`
    triangles : (m,), their order; corners : (m, 3, 3), m, of the triangles in the mesh's own order
    """

    low: FloatArray
    high: FloatArray
    child: IntArray
    first: IntArray
    size: IntArray
    triangles: IntArray
    corners: FloatArray


class Closest(NamedTuple):
    """Closest points of k points.

    distance : (k,), m; triangle : (k,)
    feature : (k,), 0 on the face, 1 to 3 at its corners, 4 to 6 on its edges from each corner to the next
    place : (k, 3), m
    """

    distance: FloatArray
    triangle: IntArray
    feature: IntArray
    place: FloatArray


def tree_of(points: FloatArray, triangles: IntArray) -> Tree:
    """A tree of boxes, halved at the median along their longest axis."""
    corners = np.ascontiguousarray(points[triangles])
    low, high, middle = corners.min(axis=1), corners.max(axis=1), corners.mean(axis=1)
    order = np.arange(len(triangles), dtype=np.int64)
    first, count, child = [0], [len(triangles)], [0]
    boxes: list[tuple[FloatArray, FloatArray]] = []
    k = 0
    while k < len(first):
        here = order[first[k] : first[k] + count[k]]
        boxes.append((low[here].min(axis=0), high[here].max(axis=0)))
        if count[k] > _LEAF:
            along = middle[here, int(np.argmax(np.ptp(middle[here], axis=0)))]
            half = count[k] // 2
            order[first[k] : first[k] + count[k]] = here[np.argpartition(along, half)]
            child[k] = len(first)
            first += [first[k], first[k] + half]
            count += [half, count[k] - half]
            child += [0, 0]
        k += 1
    return Tree(
        np.array([each[0] for each in boxes]),
        np.array([each[1] for each in boxes]),
        np.array(child),
        np.array(first),
        np.array(count),
        order,
        corners,
    )


def closest(tree: Tree, points: FloatArray) -> Closest:
    """Closest points of the mesh to points (k, 3)."""
    count = len(points)
    found = Closest(
        np.empty(count), np.empty(count, np.int64), np.empty(count, np.int64), np.empty((count, 3))
    )
    _closest(tree, np.ascontiguousarray(points), found)
    return found


def signed_distances(tree: Tree, triangles: IntArray, points: FloatArray) -> FloatArray:
    """Distance of points (k, 3) to the closed mesh, (k,), m, negative inside."""
    found = closest(tree, points)
    normals = _pseudonormals(tree.corners, triangles)[found.triangle, found.feature]
    outward = np.einsum("ki,ki->k", points - found.place, normals)
    return np.where(outward < 0.0, -found.distance, found.distance)


def face_normals(corners: FloatArray) -> FloatArray:
    """Unit normals of triangles (m, 3, 3), (m, 3); zero for a triangle without area."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.where(length > 0.0, length, 1.0)


def corner_angles(corners: FloatArray) -> FloatArray:
    """Angles of triangles (m, 3, 3) at their corners, (m, 3), rad."""
    ahead = np.roll(corners, -1, axis=1) - corners
    back = np.roll(corners, 1, axis=1) - corners
    cross = np.linalg.norm(np.cross(ahead, back), axis=2)
    return np.arctan2(cross, np.einsum("mki,mki->mk", ahead, back))


def _pseudonormals(corners: FloatArray, triangles: IntArray) -> FloatArray:
    """Normals of each triangle by feature, (m, 7, 3), see `Closest`."""
    faces = face_normals(corners)
    normals = np.empty((len(corners), 7, 3))
    normals[:, 0] = faces
    of_points = np.zeros((int(triangles.max()) + 1, 3))
    angle = corner_angles(corners)
    for k in range(3):
        np.add.at(of_points, triangles[:, k], angle[:, k, None] * faces)
    normals[:, 1:4] = of_points[triangles]
    ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    _, edge = np.unique(ends, axis=0, return_inverse=True)
    edge = edge.reshape(-1)
    of_edges = np.zeros((int(edge.max()) + 1, 3))
    np.add.at(of_edges, edge, np.repeat(faces, 3, axis=0))
    normals[:, 4:7] = of_edges[edge].reshape(-1, 3, 3)
    return normals


@njit(cache=True, error_model="numpy")
def _closest(tree: Tree, points: FloatArray, found: Closest) -> None:
    stack = np.empty(DEPTH, np.int64)
    near = np.empty(DEPTH)
    triangle = 0
    for i in range(len(points)):
        p = (points[i, 0], points[i, 1], points[i, 2])
        qx, qy, qz, feature = _on_triangle(tree.corners, triangle, p)
        best = (qx - p[0]) ** 2 + (qy - p[1]) ** 2 + (qz - p[2]) ** 2
        stack[0], near[0] = 0, 0.0
        height = 1
        while height > 0:
            height -= 1
            box = stack[height]
            if near[height] >= best:
                continue
            child = tree.child[box]
            if child == 0:
                for j in range(tree.first[box], tree.first[box] + tree.size[box]):
                    t = tree.triangles[j]
                    x, y, z, kind = _on_triangle(tree.corners, t, p)
                    square = (x - p[0]) ** 2 + (y - p[1]) ** 2 + (z - p[2]) ** 2
                    if square < best:
                        best, triangle, feature, qx, qy, qz = square, t, kind, x, y, z
                continue
            one, other = _to_box(tree, child, p), _to_box(tree, child + 1, p)
            swap = other < one  # the nearer one is taken first, so it is put on top
            stack[height], near[height] = (child, one) if swap else (child + 1, other)
            stack[height + 1], near[height + 1] = (child + 1, other) if swap else (child, one)
            height += 2
        found.distance[i], found.triangle[i], found.feature[i] = np.sqrt(best), triangle, feature
        found.place[i, 0], found.place[i, 1], found.place[i, 2] = qx, qy, qz


@njit(cache=True, forceinline=True)
def _to_box(tree: Tree, box: int, p: tuple[float, float, float]) -> float:
    """Square of the distance to a box."""
    square = 0.0
    for axis in range(3):
        off = max(tree.low[box, axis] - p[axis], p[axis] - tree.high[box, axis], 0.0)
        square += off * off
    return square


@njit(cache=True, forceinline=True, error_model="numpy")
def _on_triangle(
    corners: FloatArray, t: int, p: tuple[float, float, float]
) -> tuple[float, float, float, int]:
    """Closest point of a triangle, and its feature: by the regions around corners, edges and face."""
    ax, ay, az = corners[t, 0, 0], corners[t, 0, 1], corners[t, 0, 2]
    ux, uy, uz = corners[t, 1, 0] - ax, corners[t, 1, 1] - ay, corners[t, 1, 2] - az
    wx, wy, wz = corners[t, 2, 0] - ax, corners[t, 2, 1] - ay, corners[t, 2, 2] - az
    px, py, pz = p[0] - ax, p[1] - ay, p[2] - az
    uu, uw, ww = ux * ux + uy * uy + uz * uz, ux * wx + uy * wy + uz * wz, wx * wx + wy * wy + wz * wz
    # scalar products of the edges from a with p from a, from b and from c
    pu, pw = ux * px + uy * py + uz * pz, wx * px + wy * py + wz * pz
    bu, bw = pu - uu, pw - uw
    cu, cw = pu - uw, pw - ww
    if pu <= 0.0 and pw <= 0.0:
        return ax, ay, az, 1
    if bu >= 0.0 and bw <= bu:
        return ax + ux, ay + uy, az + uz, 2
    if cw >= 0.0 and cu <= cw:
        return ax + wx, ay + wy, az + wz, 3
    # areas against the edges, all times the same
    c = pu * bw - bu * pw
    if c <= 0.0 and pu >= 0.0 and bu <= 0.0:
        s = pu / (pu - bu) if pu > bu else 0.0
        return ax + s * ux, ay + s * uy, az + s * uz, 4
    b = cu * pw - pu * cw
    if b <= 0.0 and pw >= 0.0 and cw <= 0.0:
        s = pw / (pw - cw) if pw > cw else 0.0
        return ax + s * wx, ay + s * wy, az + s * wz, 6
    a = bu * cw - cu * bw
    if a <= 0.0 and bw - bu >= 0.0 and cu - cw >= 0.0:
        length = (bw - bu) + (cu - cw)
        s = (bw - bu) / length if length > 0.0 else 0.0
        return ax + ux + s * (wx - ux), ay + uy + s * (wy - uy), az + uz + s * (wz - uz), 5
    whole = a + b + c
    v, w = b / whole, c / whole
    return ax + v * ux + w * wx, ay + v * uy + w * wy, az + v * uz + w * wz, 0
