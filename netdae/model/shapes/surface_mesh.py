"""A closed triangle mesh with its signed distance on a grid; `mesh.surface` reads and prepares one."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product

import numpy as np

from netdae.core.arrays import FloatArray, IntArray, frozen_floats, frozen_ints
from netdae.core.errors import InputError
from netdae.model.shapes.kinds import GRID, Core
from netdae.model.shapes.sizes import check_sizes, vector
from netdae.model.shapes.solid import Solid, of_surface
from netdae.model.shapes.surfaces import Surface


@dataclass(frozen=True, eq=False)
class SurfaceMesh:
    """A closed triangle mesh, met through a grid of signed distances that is interpolated trilinearly.

    points : (n, 3), m; triangles : (m, 3), counter-clockwise seen from outside
    origin : (3,), m, place of the grid's first node; spacing : m
    values : (n_x, n_y, n_z), signed distance at the grid's nodes, m, already with the rounding
    error : m, largest difference between grid and exact distance that was found, see `mesh.surface_grid`
    rounding : m, of its edges, as far as the grid resolves it
    notes : what was repaired when the file was read, in words
    """

    points: FloatArray
    triangles: IntArray
    origin: FloatArray
    spacing: float
    values: FloatArray
    error: float
    rounding: float = 0.0
    notes: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", frozen_floats(self.points))
        object.__setattr__(self, "triangles", frozen_ints(self.triangles))
        object.__setattr__(self, "origin", vector("surface mesh", "origin", self.origin))
        object.__setattr__(self, "values", frozen_floats(self.values))
        check_sizes("surface mesh", spacing=self.spacing)
        check_sizes("surface mesh", at_least_zero=True, rounding=self.rounding, error=self.error)
        values = self.values
        if values.ndim != 3 or min(values.shape) < 2 or not np.isfinite(values).all():
            raise InputError(
                f"surface mesh: the grid has the shape {values.shape}: give finite distances at two or more nodes "
                "along each of three axes"
            )

    @property
    def lipschitz(self) -> float:
        """Largest |∇φ| of the interpolation outside the surface, so that this is at least φ/lipschitz away.

        In a cell ∇φ is a mean of the values at its corners, each from the three edges that meet there; the largest is
        that of a corner, of those cells that reach outside.
        """
        values = self.values
        x, y, z = (np.diff(values, axis=axis) ** 2 for axis in range(3))
        square, reach = np.zeros(x[:, 1:, 1:].shape), np.full(x[:, 1:, 1:].shape, -np.inf)
        ends = (slice(None, -1), slice(1, None))
        for i, j, k in product(ends, repeat=3):
            square = np.maximum(square, x[:, j, k] + y[i, :, k] + z[i, j, :])
            reach = np.maximum(reach, values[i, j, k])
        return max(1.0, float(np.sqrt(square[reach > 0.0].max(initial=0.0))) / self.spacing)

    def core(self) -> Core:
        """The grid."""
        values = self.values
        points = self.points
        numbers = np.concatenate([self.origin, [self.spacing], values.shape, values.reshape(-1)])
        centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
        radius = float(np.linalg.norm(points - centre, axis=1).max()) + self.error
        return Core(GRID, 0.0, numbers, tuple(centre.tolist()), radius, self.lipschitz, False)

    def solid(self) -> Solid:
        """Of unit density, in the mesh itself."""
        return of_surface(self.surface())

    def surface(self) -> Surface:
        """The mesh itself."""
        return Surface(self.points, self.triangles)
