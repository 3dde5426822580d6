"""Surface meshes of targets from files: STL, OBJ and PLY, read by trimesh."""

from __future__ import annotations

import logging
import os
from pathlib import Path

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import InputError, MeshError
from netdae.core.files import reason_of
from netdae.mesh.closed import closed_surface
from netdae.mesh.io import SUFFIXES as NET_SUFFIXES
from netdae.mesh.receded import receded
from netdae.mesh.surface_grid import CELLS, LARGEST, grid_of
from netdae.model.shapes.sizes import check_sizes
from netdae.model.shapes.solids import ROUNDING
from netdae.model.shapes.surface_mesh import SurfaceMesh
from netdae.model.shapes.surfaces import Surface

log = logging.getLogger(__name__)

SUFFIXES = (".stl", ".obj", ".ply")
"""Suffixes of the files that are read."""

MILLIMETRES = 100.0
"""A target this many times longer than the net is taken for one in millimetres, 1000 times too long."""


def read_surface(
    path: str | os.PathLike[str], *, scale: float = 1.0, rounding: float | None = None, cells: int = CELLS
) -> SurfaceMesh:
    """Read a closed triangle mesh and take its signed distance on a grid.

    What was repaired goes to the log as warnings, and to `notes`.

    scale : factor to metres, 1e-3 for a file in millimetres
    rounding : radius of its edges, m; None for 5 mm, or none where the mesh is too thin or too fine for it
    cells : of the grid, along the longest side

    Raises MeshError, one line with the file's name, for a file without a closed surface.
    """
    if not 8 <= cells <= LARGEST:
        raise InputError(f"surface mesh: cells is {cells}: give 8 to {LARGEST}")
    check_sizes("surface mesh", scale=scale)
    file = Path(path)
    try:
        points, triangles = _triangles_in(file)
        mesh = surface_mesh(scale * points, triangles, rounding=rounding, cells=cells)
    except InputError as error:
        raise MeshError(f"{path}: {error}") from error
    for note in mesh.notes:
        log.warning("%s: %s", path, note)
    return mesh


def surface_mesh(
    points: FloatArray, triangles: IntArray, *, rounding: float | None = None, cells: int = CELLS
) -> SurfaceMesh:
    """The same for points (n, 3) in m and triangles (m, 3) at hand; raises InputError."""
    surface, notes = closed_surface(points, triangles)
    radius = ROUNDING if rounding is None else rounding
    check_sizes("surface mesh", at_least_zero=True, rounding=radius)
    core = surface
    try:
        if radius:
            core = receded(surface, radius)
    except InputError:
        if rounding is not None:
            raise
        notes.append(
            f"edges left sharp, since parts are too thin or too finely resolved for {1e3 * radius:g} mm"
        )
        radius = 0.0
    grid = grid_of(surface, core, radius, cells=cells)
    return SurfaceMesh(
        *surface, grid.origin, grid.spacing, grid.values, grid.error, rounding=radius, notes=tuple(notes)
    )


def check_size(surface: Surface, net_size: float, name: str) -> None:
    """Raise MeshError for a surface so much larger than a net of `net_size` m that its file is in other units."""
    size = float(np.ptp(surface.points, axis=0).max())
    if size > MILLIMETRES * net_size:
        raise MeshError(
            f"{name}: the surface is {size:g} m long, {size / net_size:.0f} times the net of {net_size:g} m: "
            "if the file is in millimetres give scale = 0.001"
        )


def _triangles_in(file: Path) -> tuple[FloatArray, IntArray]:
    suffix = file.suffix.lower()
    if suffix in NET_SUFFIXES and suffix not in SUFFIXES:
        raise MeshError(
            f"this is the format of a net, and a target needs a closed surface: give one of {', '.join(SUFFIXES)}"
        )
    if suffix not in SUFFIXES:
        raise MeshError(
            f"the format {suffix or 'without a suffix'} is not known: give one of {', '.join(SUFFIXES)}"
        )
    try:
        import trimesh
    except ImportError:
        raise MeshError(
            "surface meshes are read by trimesh, which is missing: pip install 'netdae[capture]'"
        ) from None
    try:
        with open(file, "rb") as stream:
            if not stream.read(1):
                raise MeshError("the file is empty")
            stream.seek(0)
            mesh = trimesh.load_mesh(stream, file_type=suffix[1:], process=False, maintain_order=True)
            points = np.asarray(mesh.vertices, dtype=np.float64)
            triangles = np.asarray(getattr(mesh, "faces", ()), dtype=np.int64).reshape(-1, 3)
    except OSError as error:
        raise MeshError(f"cannot be read: {reason_of(error)}") from error
    except InputError:
        raise
    except Exception as error:  # whatever a broken file makes of trimesh
        raise MeshError(
            f"cannot be read as {suffix[1:].upper()}: {error!s:.200}".replace("\n", " ")
        ) from error
    return points, triangles
