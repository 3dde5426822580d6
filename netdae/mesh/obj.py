"""Wavefront .obj files, as Blender writes them: vertices, lines `l`, points `p`, faces `f`, groups by `g` and `o`."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import MeshError
from netdae.mesh.raw import RawMesh
from netdae.model.net import CableNet

_DEFAULT = ("default", "off")
_END = "# end of the net"
_HEAD = f"# whole if the last line is: {_END}"


def read_obj(file: Path) -> RawMesh:
    """Read a .obj file; raises MeshError, without its name, for a line that cannot be read."""
    points: list[list[float]] = []
    pairs: list[tuple[int, int]] = []
    edges: list[tuple[int, int]] = []
    vertices: list[int] = []
    of_pair: list[int] = []
    of_edge: list[int] = []
    of_vertex: list[int] = []
    sets: dict[str, list[int]] = {}
    groups: list[str] = []
    cell = split = 0
    text = file.read_text(encoding="utf-8", errors="replace").replace("\\\n", " ")
    if text.startswith(_HEAD) and not text.rstrip().endswith(_END):
        raise MeshError(f"the file is cut off, its last line is not {_END!r}: save the mesh again")
    for number, line in enumerate(text.splitlines(), 1):
        word, *fields = line.split("#", 1)[0].split() or [""]
        if word == "v":
            points.append([_real(field, number) for field in fields[:3]])
            if len(fields) < 3:
                raise MeshError(
                    f"line {number} has {len(fields)} coordinates, expected 3: the file is cut off"
                )
        elif word in ("g", "o"):
            groups = [name for name in fields if name not in _DEFAULT]
        elif word in ("l", "p", "f"):
            nodes = [_index(field, len(points), number) for field in fields]
            if len(nodes) < {"l": 2, "p": 1, "f": 3}[word]:
                raise MeshError(f"line {number}: {word} names {len(nodes)} vertices: the file is cut off")
            for name in groups:
                sets.setdefault(name, []).append(cell)
            if word == "l":
                pairs += pairwise(nodes)
                of_pair += [cell] * (len(nodes) - 1)
                split += len(nodes) > 2
            elif word == "p":
                vertices += nodes
                of_vertex += [cell] * len(nodes)
            else:
                edges += zip(nodes, [*nodes[1:], nodes[0]], strict=True)
                of_edge += [cell] * len(nodes)
            cell += 1
    if not points:
        raise MeshError("the file has no nodes: vertices are lines that begin with v")
    return RawMesh(
        points=np.array(points),
        cell_count=cell,
        ends=_array(pairs).reshape(-1, 2),
        line_cell=_array(of_pair),
        vertices=_array(vertices),
        vertex_cell=_array(of_vertex),
        face_edges=_array(edges).reshape(-1, 2),
        face_cell=_array(of_edge),
        cell_sets={name: _array(cells) for name, cells in sets.items()},
        split=split,
    )


def write_obj(path: Path, net: CableNet, numbers: Mapping[str, FloatArray]) -> None:
    """Write a net; node groups are points. Raises MeshError for data of cables, for which there is no place."""
    if numbers:
        raise MeshError(f"it has no place for {', '.join(numbers)}: write .vtu, .vtp, .vtk, .msh or .xdmf")
    lines = [_HEAD, *(f"v {x!r} {y!r} {z!r}" for x, y, z in net.nodes.tolist())]
    named: list[list[str]] = [[] for _ in range(net.cable_count)]
    for name, member in net.cable_groups.items():
        for cable in member.tolist() if name != "all" else ():
            named[cable].append(name)
    before: list[str] = []
    for (i, j), names in zip(net.cables.tolist(), named, strict=True):
        if names != before:
            lines.append(f"g {' '.join(names) or 'default'}")
            before = names
        lines.append(f"l {i + 1} {j + 1}")
    for name, member in net.node_groups.items():
        if name != "all" and len(member):
            lines += [f"g {name}", f"p {' '.join(map(str, (member + 1).tolist()))}"]
    path.write_text("\n".join([*lines, _END]) + "\n", encoding="utf-8", newline="\n")


def _array(values: list[int] | list[tuple[int, int]]) -> IntArray:
    return np.array(values, dtype=np.int64)


def _real(field: str, number: int) -> float:
    try:
        return float(field)
    except ValueError:
        raise MeshError(
            f"line {number}: {field[:40]!r} is no number: the file is damaged, or edit the line"
        ) from None


def _index(field: str, count: int, number: int) -> int:
    """Place of a vertex: numbers begin with 1, and negative ones count back from the last."""
    text = field.partition("/")[0]
    value = int(text) if text.lstrip("-").isdecimal() and len(text) < 16 else 0
    place = value - 1 if value > 0 else count + value
    if value == 0 or not 0 <= place < count:
        raise MeshError(
            f"line {number} names vertex {text[:40]}, but there are {count} before it: edit the line"
        )
    return place
