"""The convex hull of points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.optimize import linprog
from scipy.spatial import ConvexHull as Qhull
from scipy.spatial import HalfspaceIntersection, QhullError

from netdae.core.arrays import FloatArray, frozen_floats
from netdae.core.errors import InputError
from netdae.model.shapes.kinds import CORE, FACE, HULL, VERTEX, Core
from netdae.model.shapes.sizes import check_rounding
from netdae.model.shapes.solid import Solid, of_surface
from netdae.model.shapes.solids import ROUNDING
from netdae.model.shapes.surfaces import Surface, distinct, polyhedron

_NEAR = 1e-9  # of the size: points and planes closer than this are one; far above round-off


class Polytope(NamedTuple):
    """A convex polytope {q : normals q ≤ offsets}.

    points : (n, 3), its vertices; faces : the vertices of each, counter-clockwise seen from outside
    normals : (F, 3), of unit length; offsets : (F,)
    """

    points: FloatArray
    faces: list[tuple[int, ...]]
    normals: FloatArray
    offsets: FloatArray


@dataclass(frozen=True, eq=False)
class ConvexHull:
    """The convex hull of points; for bodies of some hundred faces at most, since each look at it walks all of them.

    points : (n, 3), m; rounding : radius of its edges, m
    """

    points: FloatArray
    rounding: float = ROUNDING

    def __post_init__(self) -> None:
        try:
            points = frozen_floats(self.points)
        except (TypeError, ValueError):
            points = frozen_floats(np.nan)
        if points.ndim != 2 or points.shape[1] != 3 or len(points) < 4 or not np.isfinite(points).all():
            raise InputError(
                f"convex hull: points have the shape {points.shape}: give four or more rows of three finite numbers"
            )
        object.__setattr__(self, "points", points)
        try:
            faces = self.polytope
        except QhullError:
            raise InputError("convex hull: its points are all in one plane: give one off it") from None
        check_rounding("convex hull", self.rounding, _inscribed(faces)[1] * (1.0 - 1e-6))

    @cached_property
    def polytope(self) -> Polytope:
        """The hull with sharp edges."""
        return _polytope(self.points)

    def core(self) -> Core:
        """The polytope between the planes of the faces moved inwards by the rounding; small faces may vanish."""
        core = _receded(self.polytope, self.rounding) if self.rounding else self.polytope
        faces, loops = [], []
        start = CORE + 1 + FACE * len(core.faces)
        for face, n, offset in zip(core.faces, core.normals, core.offsets, strict=True):
            v = core.points[list(face)]
            t = np.roll(v, -1, axis=0) - v
            length = np.linalg.norm(t, axis=1, keepdims=True)
            t /= length
            faces.append([*n, offset, start, len(v)])
            loops.append(np.concatenate([v, t, length, np.cross(t, n)], axis=1))
            start += VERTEX * len(v)
        numbers = np.concatenate([[len(faces)], np.ravel(faces), *(each.reshape(-1) for each in loops)])
        centre = 0.5 * (core.points.min(axis=0) + core.points.max(axis=0))
        radius = float(np.linalg.norm(core.points - centre, axis=1).max()) + self.rounding
        return Core(HULL, self.rounding, numbers, tuple(centre.tolist()), radius)

    def solid(self) -> Solid:
        """Of unit density, with sharp edges."""
        return of_surface(self.surface())

    def surface(self) -> Surface:
        """Triangles of its faces, with sharp edges."""
        return polyhedron(self.polytope.points, self.polytope.faces)


def _polytope(points: FloatArray) -> Polytope:
    size = float(np.ptp(points, axis=0).max())
    points = points[np.sort(distinct(points, _NEAR * size)[0])]
    hull = Qhull(points)
    # triangles of one plane are one face
    plane = hull.equations / [1.0, 1.0, 1.0, size]
    faces: list[tuple[int, ...]] = []
    equations = []
    left = np.ones(len(plane), dtype=bool)
    for k in range(len(plane)):
        if not left[k]:
            continue
        same = left & (np.abs(plane - plane[k]).max(axis=1) < _NEAR)
        left &= ~same
        corners = np.unique(hull.simplices[same])
        faces.append(_loop(points, corners, hull.equations[k, :3]))
        equations.append(hull.equations[k])
    used, where = np.unique(np.concatenate([list(face) for face in faces]), return_inverse=True)
    ends = np.cumsum([0, *(len(face) for face in faces)])
    renamed = [tuple(where[a:b].tolist()) for a, b in pairwise(ends)]
    found = np.array(equations)
    return Polytope(points[used], renamed, found[:, :3], -found[:, 3])


def _loop(points: FloatArray, corners: FloatArray, normal: FloatArray) -> tuple[int, ...]:
    """Corners of a convex face, counter-clockwise about its normal."""
    v = points[corners] - points[corners].mean(axis=0)
    u = v[np.argmax(np.linalg.norm(v, axis=1))]
    w = np.cross(normal, u)
    return tuple(corners[np.argsort(np.arctan2(v @ w, v @ u))].tolist())


def _inscribed(faces: Polytope) -> tuple[FloatArray, float]:
    """Centre and radius of the largest sphere inside: the linear programme max r with n · q + r ≤ offset."""
    rows = np.column_stack([faces.normals, np.ones(len(faces.normals))])
    found = linprog([0.0, 0.0, 0.0, -1.0], rows, faces.offsets, bounds=[(None, None)] * 3 + [(0.0, None)])
    return found.x[:3], float(found.x[3])


def _receded(faces: Polytope, by: float) -> Polytope:
    centre, _ = _inscribed(faces)
    planes = np.column_stack([faces.normals, by - faces.offsets])
    return _polytope(HalfspaceIntersection(planes, centre).intersections)
