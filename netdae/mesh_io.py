"""Nets from mesh files and back: Gmsh .msh, VTK .vtu and .vtk, .xdmf, Abaqus .inp.

Physical groups, node and element sets, and integer data (everything that is not 0) are groups by their name:
of nodes where they hold points, of cables where they hold lines. Cell data `diameter`, `area`,
`youngs_modulus`, `density` and `rest_length` are numbers of the cables, in SI units.
"""

from __future__ import annotations

import contextlib
import functools
import io
import logging
import os
import re
import tempfile
import warnings
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from netdae._arrays import FloatArray, IntArray
from netdae._files import reason_of
from netdae.errors import InputError, MeshError
from netdae.inp import element_sets_of, keywords_of
from netdae.inp import numbers_of as numbers_of_inp
from netdae.mesh_findings import FileNumbers, difference_of
from netdae.msh import numbers_of as numbers_of_msh
from netdae.msh import physical_groups_of, write_msh
from netdae.net import CableNet
from netdae.raw_mesh import RawMesh, chain_of, net_of
from netdae.vtk_lines import read_polylines

log = logging.getLogger(__name__)

SUFFIXES = (".vtu", ".vtk", ".msh", ".xdmf", ".inp")
"""Endings of the files that are read and written."""

# what meshio says of .vtu files that it reads in part or not at all, though they are whole
_LEFT_TO_VTK = re.compile("meshio cannot handle|Unknown VTU file version")


# no number in an .inp tells how long it is; lines with two stars are comments
_INP_END = "** end of the net"
_INP_HEAD = f"** whole if the last line is: {_INP_END}"


@dataclass(frozen=True, eq=False)
class Description:
    """What is in a mesh file.

    net : the net that is made of it
    findings : what its author should know, a sentence each
    unused_data : names of data that netdae has no use for
    """

    net: CableNet
    findings: tuple[str, ...]
    unused_data: tuple[str, ...]


def read_net(path: str | os.PathLike[str], *, surface_edges: bool = False) -> CableNet:
    """Read a net from a mesh file; what its author should know goes to the log as warnings.

    Lines are cables; poly lines and quadratic lines are split at their nodes. With `surface_edges` the edges
    of surface cells are cables as well, in the groups border and inner.
    Raises MeshError, one line with the file's name, for a file that is no net.
    """
    found = describe(path, surface_edges=surface_edges)
    for finding in found.findings:
        log.warning("%s: %s", path, finding)
    return found.net


def describe(path: str | os.PathLike[str], *, surface_edges: bool = False) -> Description:
    """Net, findings and unused data of a mesh file, see `read_net`."""
    file = Path(path)
    _check_file(file)
    try:
        raw = _raw_of(file)
        net, findings = net_of(raw, surface_edges=surface_edges)
    except InputError as error:
        raise MeshError(f"{path}: {error}") from error
    return Description(net, findings, raw.unused_data)


def write_net(net: CableNet, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
    """Write a net with its groups and data; the format goes by the ending.

    Its folder is made. The file gets its name only when reading it back has given the same net.
    Raises MeshError for a file that exists, unless `overwrite`, and for a net that the format cannot hold.
    """
    file = Path(path)
    suffix = _suffix_of(file)
    if file.is_dir():
        raise MeshError(f"{path}: this is a folder: give the name of a file")
    if file.exists() and not overwrite:
        raise MeshError(
            f"{path}: the file exists: choose another name, or replace it by overwrite (--overwrite)"
        )
    numbers = dict(net.cable_data)
    if not np.array_equal(np.linalg.norm(net.spans, axis=1), net.rest_length):
        numbers["rest_length"] = net.rest_length
    temporary = file.with_name(f".{file.stem}.{os.getpid()}.part{suffix}")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with _quiet():
            _WRITERS[suffix](temporary, net, numbers)
        difference = difference_of(net, describe(temporary).net)
        if difference:
            raise MeshError(f"reading it back gives {difference}: choose another ending or change the net")
        temporary.replace(file)
    except OSError as error:
        raise MeshError(
            f"{path}: the file cannot be written: {reason_of(error)}: choose another place"
        ) from error
    except Exception as error:
        reason = _first_line(error).removeprefix(f"{temporary}: ")
        raise MeshError(f"{path}: a {suffix} file cannot hold this net: {reason}") from error
    finally:
        with contextlib.suppress(OSError):  # it is not there, or nothing may be changed in this folder
            temporary.unlink()


def _suffix_of(file: Path) -> str:
    suffix = file.suffix.lower()
    if suffix not in SUFFIXES:
        found = f"the ending {file.suffix!r} is unknown" if suffix else "the name has no ending"
        raise MeshError(f"{file}: {found}: netdae reads and writes {', '.join(SUFFIXES)}")
    return suffix


def _check_file(file: Path) -> None:
    if file.is_dir():
        raise MeshError(f"{file}: this is a folder: give the name of a mesh file")
    if not file.exists():
        raise MeshError(f"{file}: there is no such file: check the name and the folder")
    _suffix_of(file)
    if file.stat().st_size == 0:
        raise MeshError(f"{file}: the file is empty: write the mesh again")


def _first_line(error: BaseException) -> str:
    lines = str(error).strip().splitlines()
    return lines[0].strip() if lines else type(error).__name__


@contextlib.contextmanager
def _quiet() -> Iterator[io.StringIO]:
    """Catch what meshio prints and warns of."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield said


def _raw_of(file: Path) -> RawMesh:
    suffix = file.suffix.lower()
    try:
        with _quiet() as said:
            if suffix == ".vtu":
                return _raw_of_vtu(file, said)
            raw = _READERS[suffix](file)
            if "not closed by" in said.getvalue():  # meshio of a section of .msh
                raise MeshError("the file is cut off, a section of it does not end: save the mesh again")
            return raw
    except InputError:
        raise
    except (Exception, SystemExit) as error:  # meshio raises anything on a file that is not whole
        if isinstance(error, PermissionError):
            raise MeshError("the file cannot be read: permission denied") from error
        if isinstance(error, FileNotFoundError):
            raise MeshError(
                "a file that it names, with the data, is missing: put it beside this one"
            ) from error
        # what other libraries say of their own arrays helps nobody; a ReadError is of the file
        reason = (
            _first_line(error) if isinstance(error, meshio.ReadError | ET.ParseError) and str(error) else ""
        )
        raise MeshError(
            f"the file cannot be read as {suffix}, it is cut off, damaged or of another kind"
            f"{reason and f' ({reason})'}: save the mesh again"
        ) from error


def _raw_of_vtu(file: Path, said: io.StringIO) -> RawMesh:
    """Read by meshio, or by pyvista where meshio would lose lines."""
    if file.read_bytes().count(b"<Piece") > 1:  # meshio keeps the cells of the last only
        return read_polylines(file)
    try:
        mesh = meshio.vtu.read(file)
    except meshio.ReadError as error:
        if _LEFT_TO_VTK.search(str(error)):
            return read_polylines(file)
        raise
    if _LEFT_TO_VTK.search(" ".join(said.getvalue().split())):
        return read_polylines(file)
    if "corrupt" in said.getvalue():
        raise MeshError("the file is damaged, its lines are not as long as it says: save the mesh again")
    return _raw_of_mesh(mesh)


def _raw_of_msh(file: Path) -> RawMesh:
    data = file.read_bytes()
    groups = physical_groups_of(data)
    numbers = _lazily(lambda: numbers_of_msh(data))
    with tempfile.TemporaryDirectory() as folder:  # meshio reads MSH from a true file only
        rest = Path(folder) / "rest.msh"
        rest.write_bytes(groups.rest)
        with _checking(numbers):
            mesh = meshio.gmsh.read(rest)
    tags = mesh.cell_data.get("gmsh:physical" if groups.version == "2.2" else "gmsh:geometrical", [])
    blocks = [(block.dim, np.asarray(tag)) for block, tag in zip(mesh.cells, tags, strict=False)]
    return _raw_of_mesh(mesh, cell_sets=groups.cell_sets(blocks), numbers=numbers)


def _raw_of_xdmf(file: Path) -> RawMesh:
    return _raw_of_mesh(meshio.xdmf.read(file))


def _raw_of_inp(file: Path) -> RawMesh:
    text = file.read_text(errors="replace")
    if text.startswith(_INP_HEAD) and not text.rstrip().endswith(_INP_END):
        raise MeshError(f"the file is cut off, its last line is not {_INP_END!r}: save the mesh again")
    keywords = keywords_of(text)
    numbers = _lazily(lambda: numbers_of_inp(text))
    with _checking(numbers):
        mesh = meshio.abaqus.read(file)
    sets = element_sets_of(keywords, [len(block) for block in mesh.cells], mesh.cell_sets)
    return _raw_of_mesh(mesh, point_sets=mesh.point_sets, cell_sets=sets, middle_last=False, numbers=numbers)


def _lazily(numbers: Callable[[], FileNumbers]) -> Callable[[], FileNumbers]:
    """`numbers`, read for the first message that wants them; none where they cannot be read."""

    @functools.cache
    def found() -> FileNumbers:
        try:
            return numbers()
        except (ValueError, IndexError, InputError):  # the reader of the mesh says what is wrong
            return FileNumbers([], [])

    return found


@contextlib.contextmanager
def _checking(numbers: Callable[[], FileNumbers]) -> Iterator[None]:
    """Tell of an element whose node is not there where a reader stumbles over it."""
    try:
        yield
    except Exception:
        numbers().check()
        raise


_READERS: dict[str, Callable[[Path], RawMesh]] = {
    ".vtk": read_polylines,
    ".msh": _raw_of_msh,
    ".xdmf": _raw_of_xdmf,
    ".inp": _raw_of_inp,
}


def _raw_of_mesh(
    mesh: Any,
    *,
    point_sets: Mapping[str, Any] | None = None,
    cell_sets: Mapping[str, IntArray] | None = None,
    middle_last: bool = True,
    numbers: Callable[[], FileNumbers] | None = None,
) -> RawMesh:
    """Arrays of a meshio mesh; `middle_last`: quadratic lines end with their middle node, unlike Abaqus's."""
    points = np.asarray(mesh.points, dtype=np.float64)
    if not points.size:
        raise MeshError("the mesh has no nodes: check what was saved")
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise MeshError(f"the nodes have the shape {points.shape}: give two or three coordinates each")
    points = np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])
    ends, line_cell, vertices, vertex_cell, edges = [], [], [], [], []
    start = split = volumes = 0
    for block in mesh.cells:
        nodes = np.asarray(block.data)
        count = len(nodes)
        if block.dim == 0:
            vertices.append(nodes[:, 0].astype(np.int64))
            vertex_cell.append(np.arange(start, start + count))
        elif block.type in ("line", "line3"):  # XDMF's poly lines of equal length come as "line"
            order = [0, 2, 1] if block.type == "line3" and middle_last else slice(None)
            chain = nodes.astype(np.int64)[:, order]
            pieces, cell = chain_of(chain.reshape(-1), np.full(count, chain.shape[1]))
            ends.append(pieces)
            line_cell.append(start + cell)
            split += count if chain.shape[1] > 2 else 0
        elif block.dim == 1:
            raise MeshError(
                f"the mesh has curved lines of type {block.type}: save it with straight or quadratic lines"
            )
        elif block.type in ("triangle", "quad", "polygon"):
            around = np.stack([nodes, np.roll(nodes, -1, axis=1)], axis=-1)
            edges.append(around.reshape(-1, 2).astype(np.int64))
        elif block.dim == 2:
            edges.append(_corner_edges(block.type, nodes))
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
        point_data={name: np.asarray(values) for name, values in mesh.point_data.items()},
        cell_data={name: np.concatenate(values) for name, values in mesh.cell_data.items() if values},
        point_sets={name: np.asarray(nodes, np.int64) for name, nodes in (point_sets or {}).items()},
        cell_sets=cell_sets or {},
        split=split,
        volumes=volumes,
        numbers=numbers,
    )


def _corner_edges(kind: str, nodes: Any) -> IntArray:
    """Edges of surface cells with nodes on their edges, from corner to corner by way of those nodes."""
    corners = {"triangle6": 3, "triangle7": 3, "quad8": 4, "quad9": 4}.get(kind)
    if corners is None:
        raise MeshError(f"the mesh has surface cells of type {kind}: save them with straight edges")
    around = np.stack([nodes[:, :corners], nodes[:, corners : 2 * corners]], axis=-1).reshape(len(nodes), -1)
    return np.stack([around, np.roll(around, -1, axis=1)], axis=-1).reshape(-1, 2).astype(np.int64)


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
    # the one integer whose name meshio writes as VTK reads it
    meshio.vtk.write(path, _as_data(net, numbers, np.int64))


def _write_xdmf(path: Path, net: CableNet, numbers: Mapping[str, FloatArray]) -> None:
    # all in one file: an .h5 beside it would go by the temporary name
    meshio.xdmf.write(path, _as_data(net, numbers, np.int32), data_format="XML")


def _write_inp(path: Path, net: CableNet, numbers: Mapping[str, FloatArray]) -> None:
    if numbers:
        raise MeshError(f"it has no place for {', '.join(numbers)}: write .vtu, .vtk, .msh or .xdmf")
    mesh = meshio.Mesh(
        net.nodes,
        [("line", net.cables)],
        point_sets={name: member for name, member in net.node_groups.items() if name != "all"},
        cell_sets={name: [member] for name, member in net.cable_groups.items() if name != "all"},
    )
    meshio.abaqus.write(path, mesh)
    path.write_text(f"{_INP_HEAD}\n{path.read_text()}{_INP_END}\n")


_WRITERS: dict[str, Callable[[Path, CableNet, Mapping[str, FloatArray]], None]] = {
    ".vtu": _write_vtu,
    ".vtk": _write_vtk,
    ".msh": write_msh,
    ".xdmf": _write_xdmf,
    ".inp": _write_inp,
}
