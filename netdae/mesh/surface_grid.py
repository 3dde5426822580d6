"""Signed distances of a closed mesh on a grid, kept on disk by the mesh's content.

The grid has cubic cells of side h. φ is interpolated trilinearly between its nodes, which is off by up to h²/(4 R) on a
surface with the radius of curvature R, and by up to half a cell at sharp edges. The error is measured: `error_of`.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import MeshError
from netdae.core.files import write_whole
from netdae.mesh.closest import Tree, signed_distances, tree_of
from netdae.model.shapes.distance import curvatures
from netdae.model.shapes.part import Part, parts_of
from netdae.model.shapes.surface_mesh import SurfaceMesh
from netdae.model.shapes.surfaces import Surface

CELLS = 64
"""Cells along the longest side where nothing else is given."""

MARGIN = 3  # nodes of the grid beyond the surface on each side
LARGEST = 256  # cells along a side: 17 million nodes, 136 MB
_VERSION = 1  # of what is kept on disk
_SAMPLES = 4000


class Grid(NamedTuple):
    """origin : (3,), m; spacing : m; values : (n_x, n_y, n_z), m; error : m, see `error_of`."""

    origin: FloatArray
    spacing: float
    values: FloatArray
    error: float


def grid_of(surface: Surface, core: Surface, rounding: float, *, cells: int = CELLS) -> Grid:
    """Signed distance to what is within `rounding` m of the core, on a grid with room for the surface.

    surface : the mesh; core : the mesh receded by the rounding, or the mesh itself
    """
    low, high = surface.points.min(axis=0), surface.points.max(axis=0)
    spacing = float((high - low).max()) / cells
    file = _file_of(surface, core, rounding, cells)
    kept = _kept(file)
    if kept is not None:
        return kept
    # the ends of the longest side are half-way between nodes: on nodes flat faces would look better than they are
    counts = np.ceil((high - low) / spacing - 1e-9).astype(np.int64) + 2 * MARGIN
    origin = 0.5 * (low + high) - 0.5 * spacing * (counts - 1)
    tree = tree_of(*core)
    index = np.indices(counts).reshape(3, -1).T
    values = signed_distances(tree, core.triangles, origin + spacing * index).reshape(counts) - rounding
    _check(values, spacing)
    error = error_of(surface, core, rounding, tree, origin, spacing, values)
    made = Grid(origin, spacing, values, error)
    _keep(file, made)
    return made


def error_of(
    surface: Surface,
    core: Surface,
    rounding: float,
    tree: Tree,
    origin: FloatArray,
    spacing: float,
    values: FloatArray,
) -> float:
    """Largest |grid − exact distance|, m, over points within half a cell of the surface's corners, edges and faces."""
    rng = np.random.default_rng(0)
    corners = surface.points[surface.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    on_faces = rng.choice(len(corners), _SAMPLES, p=area / area.sum())
    weights = rng.dirichlet((1.0, 1.0, 1.0), 2 * _SAMPLES)
    weights[_SAMPLES:, 2] = 0.0  # on edges, long ones more often
    length = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)
    on_edges = rng.choice(len(corners), _SAMPLES, p=length / length.sum())
    weights /= weights.sum(axis=1, keepdims=True)
    samples = np.einsum("ki,kij->kj", weights, corners[np.concatenate([on_faces, on_edges])])
    points = np.concatenate([samples, rng.permutation(surface.points)[:_SAMPLES]])
    points = points + rng.uniform(-0.5, 0.5, points.shape) * spacing / np.sqrt(3.0)
    exact = signed_distances(tree, core.triangles, points) - rounding
    grid = SurfaceMesh(surface.points, surface.triangles, origin, spacing, values, error=0.0)
    parts = parts_of([Part(grid)])
    found = curvatures(parts.kind[0], parts.first[0], parts.numbers, np.ascontiguousarray(points))[:, 0]
    return float(np.abs(found - exact).max())


def _check(values: FloatArray, spacing: float) -> None:
    """A signed distance changes by no more than the way; a wrong side anywhere breaks this."""
    steps = [float(np.abs(np.diff(values, axis=axis)).max()) for axis in range(3)]
    if max(steps) > spacing * (1.0 + 1e-9):
        raise MeshError(
            "the inside of the surface cannot be told from its outside everywhere: look for triangles that cross, "
            "touch or lie on each other"
        )


def cache_folder() -> Path | None:
    """Where grids are kept: the user's cache folder of this system; None if it has none."""
    with contextlib.suppress(RuntimeError):  # no home
        if sys.platform == "win32":
            return (
                Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "netdae" / "grids"
            )
        if sys.platform == "darwin":
            return Path.home() / "Library" / "Caches" / "netdae" / "grids"
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "netdae" / "grids"
    return None


def _file_of(surface: Surface, core: Surface, rounding: float, cells: int) -> Path | None:
    folder = cache_folder()
    if folder is None:
        return None
    digest = hashlib.sha256(repr((_VERSION, rounding, cells, MARGIN)).encode())
    for each in (*surface, *core):
        digest.update(repr(each.shape).encode())
        digest.update(np.ascontiguousarray(each).tobytes())
    return folder / f"{digest.hexdigest()[:32]}.npz"


def _kept(file: Path | None) -> Grid | None:
    if file is None:
        return None
    try:
        with np.load(file, allow_pickle=False) as found:
            return Grid(found["origin"], float(found["spacing"]), found["values"], float(found["error"]))
    except Exception:  # not there, not readable, or cut short: it is made anew
        return None


def _keep(file: Path | None, grid: Grid) -> None:
    if file is None:
        return
    written = io.BytesIO()
    np.savez(written, origin=grid.origin, spacing=grid.spacing, values=grid.values, error=grid.error)
    with contextlib.suppress(OSError):  # no place to keep it: it is made again next time
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, written.getvalue())
