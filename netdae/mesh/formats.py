"""Formats of mesh files: what each holds as a RawMesh, and a net written in each.

The suffix of a file determines its format, see `netdae.mesh.io.SUFFIXES`.
"""

from __future__ import annotations

import contextlib
import io
import re
import warnings
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import InputError, MeshError
from netdae.mesh.csv_pair import read_csv_pair
from netdae.mesh.findings import FileNumbers
from netdae.mesh.inp import read_inp, write_inp
from netdae.mesh.msh import physical_groups_of, write_msh
from netdae.mesh.msh_tables import data_of, elements_of, nodes_of
from netdae.mesh.obj import read_obj, write_obj
from netdae.mesh.raw import RawMesh, chain_of, corner_edges
from netdae.mesh.vtk_lines import read_polylines
from netdae.mesh.vtp import write_vtp
from netdae.mesh.vtu_counts import check_xml
from netdae.mesh.xdmf import read_xdmf
from netdae.model.net import CableNet

# messages of meshio about intact .vtu files that it reads in part or not at all
_LEFT_TO_VTK = re.compile("meshio cannot handle|Unknown VTU file version|Skipping")


def first_line(error: BaseException) -> str:
    """The first line of the message, or the kind of error where there is none."""
    lines = str(error).strip().splitlines()
    return lines[0].strip() if lines else type(error).__name__


@contextlib.contextmanager
def _quiet() -> Iterator[io.StringIO]:
    """Capture the output and warnings of meshio."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield said


def raw_mesh_of(file: Path) -> RawMesh:
    """Read a mesh file; raises MeshError, without the file's name, for one that cannot be read."""
    suffix = file.suffix.lower()
    try:
        with _quiet() as said:
            if suffix == ".vtu":
                return _raw_of_vtu(file, said)
            return _READERS[suffix](file)
    except InputError:
        raise
    except (Exception, SystemExit) as error:  # meshio raises anything on a damaged file
        if isinstance(error, PermissionError):
            raise MeshError("the file cannot be read: permission denied") from error
        if isinstance(error, FileNotFoundError):
            raise MeshError(
                "a file that it names, with the data, is missing: put it beside this one"
            ) from error
        # messages of other libraries about their own arrays do not help; a ReadError is about the file
        reason = (
            first_line(error) if isinstance(error, meshio.ReadError | ET.ParseError) and str(error) else ""
        )
        raise MeshError(
            f"the file cannot be read as {suffix}, it is cut off, damaged or of another kind"
            f"{reason and f' ({reason})'}: save the mesh again"
        ) from error


def _raw_of_vtu(file: Path, said: io.StringIO) -> RawMesh:
    """Read by meshio, or by VTK where meshio would lose something or fails."""
    data = file.read_bytes()
    check_xml(data)
    if data.count(b"<Piece") > 1:  # meshio keeps the cells of the last only
        return read_polylines(file)
    try:
        mesh = meshio.vtu.read(file)
        if not _LEFT_TO_VTK.search(" ".join(said.getvalue().split())) and "corrupt" not in said.getvalue():
            return _raw_of_mesh(mesh)
    except InputError:
        raise
    except (Exception, SystemExit):  # meshio raises anything on what it does not know
        pass
    return read_polylines(file)


def _raw_of_vtp(file: Path) -> RawMesh:
    check_xml(file.read_bytes())
    return read_polylines(file)


def _raw_of_msh(file: Path) -> RawMesh:
    groups = physical_groups_of(file.read_bytes())
    numbers, points = nodes_of(groups.sections)
    blocks = elements_of(groups.sections)
    named = FileNumbers(
        numbers.tolist(),
        [pair for block in blocks for pair in zip(block.numbers.tolist(), block.nodes.tolist(), strict=True)],
    )
    named.check()
    order = np.argsort(numbers, kind="stable")
    cells = [
        (_GMSH_TYPES.get(block.kind, "vertex"), order[np.searchsorted(numbers[order], block.nodes)])
        for block in blocks
    ]
    mesh = meshio.Mesh(points, cells)
    tags = [(each.dim, block.tags) for each, block in zip(mesh.cells, blocks, strict=True)]
    raw = _raw_of_mesh(mesh, cell_sets=groups.cell_sets(tags), numbers=lambda: named)
    elements = np.concatenate([np.zeros(0, np.int64), *(block.numbers for block in blocks)])
    return replace(
        raw,
        point_data=data_of(groups.sections, "NodeData", numbers),
        cell_data=data_of(groups.sections, "ElementData", elements),
    )


def _raw_of_xdmf(file: Path) -> RawMesh:
    mesh, findings = read_xdmf(file)
    return replace(_raw_of_mesh(mesh), findings=findings)


_GMSH_TYPES: dict[int, str] = dict(meshio.gmsh.common._gmsh_to_meshio_type)

_CORNERS = {"triangle": 3, "triangle6": 3, "triangle7": 3, "quad": 4, "quad8": 4, "quad9": 4}

_READERS: dict[str, Callable[[Path], RawMesh]] = {
    ".vtk": read_polylines,
    ".msh": _raw_of_msh,
    ".xdmf": _raw_of_xdmf,
    ".inp": read_inp,
    ".vtp": _raw_of_vtp,
    ".obj": read_obj,
    ".csv": read_csv_pair,
}


def _raw_of_mesh(
    mesh: Any,
    *,
    cell_sets: Mapping[str, IntArray] | None = None,
    numbers: Callable[[], FileNumbers] | None = None,
) -> RawMesh:
    """Arrays of a meshio mesh, whose quadratic lines end with their middle node."""
    points = np.asarray(mesh.points, dtype=np.float64)
    if not points.size:
        raise MeshError("the mesh has no nodes: check what was saved")
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise MeshError(f"the nodes have the shape {points.shape}: give two or three coordinates each")
    points = np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])
    ends, line_cell, vertices, vertex_cell, edges, edge_cell = [], [], [], [], [], []
    start = split = volumes = 0
    for block in mesh.cells:
        nodes = np.asarray(block.data)
        count = len(nodes)
        if block.dim == 0:
            vertices.append(nodes[:, 0].astype(np.int64))
            vertex_cell.append(np.arange(start, start + count))
        elif block.type in ("line", "line3"):  # XDMF's poly lines of equal length come as "line"
            order = [0, 2, 1] if block.type == "line3" else slice(None)
            chain = nodes.astype(np.int64)[:, order]
            pieces, cell = chain_of(chain.reshape(-1), np.full(count, chain.shape[1]))
            ends.append(pieces)
            line_cell.append(start + cell)
            split += count if chain.shape[1] > 2 else 0
        elif block.dim == 1:
            raise MeshError(
                f"the mesh has curved lines of type {block.type}: save it with straight or quadratic lines"
            )
        elif block.dim == 2:
            corners = nodes.shape[1] if block.type == "polygon" else _CORNERS.get(block.type)
            if corners is None:
                raise MeshError(
                    f"the mesh has surface cells of type {block.type}: save them with straight edges"
                )
            around = corner_edges(nodes, corners)
            edges.append(around)
            edge_cell.append(start + np.repeat(np.arange(count), len(around) // count))
        else:
            volumes += count
        start += count
    return RawMesh(
        points=points,
        cell_count=start,
        ends=np.concatenate([np.zeros((0, 2), np.int64), *ends]),
        line_cell=np.concatenate([np.zeros(0, np.int64), *line_cell]),
        vertices=np.concatenate([np.zeros(0, np.int64), *vertices]),
        vertex_cell=np.concatenate([np.zeros(0, np.int64), *vertex_cell]),
        face_edges=np.concatenate([np.zeros((0, 2), np.int64), *edges]),
        face_cell=np.concatenate([np.zeros(0, np.int64), *edge_cell]),
        point_data={name: np.asarray(values) for name, values in mesh.point_data.items()},
        cell_data={name: np.concatenate(values) for name, values in mesh.cell_data.items() if values},
        cell_sets=cell_sets or {},
        split=split,
        volumes=volumes,
        numbers=numbers,
    )


def _as_data(net: CableNet, numbers: Mapping[str, FloatArray], integer: type[np.integer]) -> Any:
    """The net as a meshio mesh whose groups are 0 and 1."""

    def flags(groups: Mapping[str, IntArray], count: int) -> dict[str, Any]:
        named = {name: member for name, member in groups.items() if name != "all"}
        return {name: np.isin(np.arange(count), member).astype(integer) for name, member in named.items()}

    cells = {**flags(net.cable_groups, net.cable_count), **numbers}
    return meshio.Mesh(
        net.nodes.copy(),
        [("line", net.cables.copy())],
        point_data=flags(net.node_groups, net.node_count),
        cell_data={name: [np.array(values)] for name, values in cells.items()},
    )


def _write_vtu(path: Path, net: CableNet, numbers: Mapping[str, FloatArray]) -> None:
    meshio.vtu.write(path, _as_data(net, numbers, np.uint8))


def _write_vtk(path: Path, net: CableNet, numbers: Mapping[str, FloatArray]) -> None:
    # the only integer type whose name meshio writes as VTK reads it
    meshio.vtk.write(path, _as_data(net, numbers, np.int64))


def _write_xdmf(path: Path, net: CableNet, numbers: Mapping[str, FloatArray]) -> None:
    # all in one file: an .h5 beside it would keep the temporary name
    meshio.xdmf.write(path, _as_data(net, numbers, np.int32), data_format="XML")


_WRITERS: dict[str, Callable[[Path, CableNet, Mapping[str, FloatArray]], None]] = {
    ".vtu": _write_vtu,
    ".vtk": _write_vtk,
    ".msh": write_msh,
    ".xdmf": _write_xdmf,
    ".inp": write_inp,
    ".vtp": write_vtp,
    ".obj": write_obj,
}


def write_mesh(path: Path, net: CableNet, numbers: Mapping[str, FloatArray]) -> None:
    """Write a net with its groups and the given numbers of its cables; raises any exception where it does not fit."""
    with _quiet():
        _WRITERS[path.suffix.lower()](path, net, numbers)
