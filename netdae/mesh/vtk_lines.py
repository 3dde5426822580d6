"""Lines of the VTK files that meshio reads only in part.

These are all legacy .vtk files, whose poly lines, bytes and integers meshio drops or misreads, and .vtu files with
poly lines, several pieces or a new version.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from netdae.core.arrays import IntArray
from netdae.core.errors import MeshError
from netdae.mesh.raw import RawMesh, chain_of, corner_edges
from netdae.mesh.vtk_counts import check_legacy

# numbers of vtkCellType.h
VERTEX, LINE, POLY_LINE, QUADRATIC_EDGE = 1, 3, 4, 21
SURFACES = (5, 7, 9)  # triangle, polygon, quad: their points go round
PIXEL = 8
QUADRATIC = {22: 3, 34: 3, 23: 4, 28: 4}  # surfaces with points inside their edges, and their corners
VOLUMES = (*range(10, 17), *range(24, 28), *range(29, 34), 37, 41, 42)
CURVES = (35, 51, 60, 68, 75)


def read_polylines(path: Path) -> RawMesh:
    """Read a .vtu or .vtk by pyvista; a poly line of k points gives k − 1 line pieces."""
    import pyvista

    if path.suffix.lower() == ".vtk":
        check_legacy(path.read_bytes())
    reported = pyvista.VtkErrorCatcher(send_to_logging=False)
    with pyvista.vtk_verbosity("off"), reported:
        mesh: Any = pyvista.read(path)
    # where binary data end early VTK only warns, and returns what was in memory
    wrong = [
        *reported.error_events,
        *(event for event in reported.warning_events if "Error reading" in str(event)),
    ]
    if wrong:
        raise ValueError(str(wrong[0]))
    if isinstance(mesh, pyvista.PolyData):
        mesh = mesh.cast_to_unstructured_grid()
    if not isinstance(mesh, pyvista.UnstructuredGrid):
        raise MeshError(f"the file holds {type(mesh).__name__}: save the cables as an unstructured grid")
    kinds = np.asarray(mesh.celltypes)
    offset = np.asarray(mesh.offset, dtype=np.int64)
    connectivity = np.array(mesh.cell_connectivity, dtype=np.int64)
    if np.isin(kinds, CURVES).any():
        kind = kinds[np.isin(kinds, CURVES)][0]
        raise MeshError(
            f"the file holds curved cells of VTK type {kind}: save the cables as lines or poly lines"
        )
    for cell in np.flatnonzero(kinds == QUADRATIC_EDGE):
        start = offset[cell]
        connectivity[start : start + 3] = connectivity[[start, start + 2, start + 1]]
    for cell in np.flatnonzero(kinds == PIXEL):
        start = offset[cell]
        connectivity[start : start + 4] = connectivity[[start, start + 1, start + 3, start + 2]]
    size = np.diff(offset)
    lines = np.flatnonzero(np.isin(kinds, (LINE, POLY_LINE, QUADRATIC_EDGE)))
    ends, chain = chain_of(_members(connectivity, offset, lines), size[lines])
    faces = np.flatnonzero(np.isin(kinds, (*SURFACES, PIXEL)))
    straight, face = chain_of(*_closed(connectivity, offset, faces))
    edges, edge_cell = [straight], [faces[face]]
    for kind, corners in QUADRATIC.items():
        cells = np.flatnonzero(kinds == kind)
        if len(cells):
            edges.append(corner_edges(_members(connectivity, offset, cells).reshape(len(cells), -1), corners))
            edge_cell.append(np.repeat(cells, 2 * corners))
    known = (VERTEX, LINE, POLY_LINE, QUADRATIC_EDGE, *SURFACES, PIXEL, *QUADRATIC, *VOLUMES)
    others = Counter(kinds[~np.isin(kinds, known)].tolist())
    vertices = np.flatnonzero(kinds == VERTEX)
    return RawMesh(
        points=np.asarray(mesh.points, dtype=np.float64),
        cell_count=len(kinds),
        ends=ends,
        line_cell=lines[chain],
        vertices=_members(connectivity, offset, vertices),
        vertex_cell=vertices,
        face_edges=np.concatenate(edges),
        face_cell=np.concatenate(edge_cell),
        point_data={name: np.asarray(mesh.point_data[name]) for name in mesh.point_data},
        cell_data={name: np.asarray(mesh.cell_data[name]) for name in mesh.cell_data},
        split=int(np.count_nonzero(size[lines] > 2)),
        left_out=", ".join(f"{count} of VTK type {kind}" for kind, count in sorted(others.items())),
        volumes=int(np.count_nonzero(np.isin(kinds, VOLUMES))),
    )


def _members(connectivity: IntArray, offset: IntArray, cells: IntArray) -> IntArray:
    """Points of the cells, one cell after the other."""
    chosen = np.zeros(len(offset) - 1, dtype=bool)
    chosen[cells] = True
    return connectivity[np.repeat(chosen, np.diff(offset))]


def _closed(connectivity: IntArray, offset: IntArray, cells: IntArray) -> tuple[IntArray, IntArray]:
    """Points of the cells, each with its first point again at its end, and the number of them."""
    size = np.diff(offset)[cells]
    after = np.cumsum(size)
    points = _members(connectivity, offset, cells)
    return np.insert(points, after, points[after - size]), size + 1
