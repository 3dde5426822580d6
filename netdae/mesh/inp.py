"""Input files of Abaqus and CalculiX: read as a RawMesh, and nets written.

Read is each keyword that places or groups something (`inp_part`, `inp_deck`). Keywords that do and are not read are
refused by name; elements that are no lines are left out with a note.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import MeshError
from netdae.mesh.findings import FileNumbers
from netdae.mesh.inp_blocks import blocks_of
from netdae.mesh.inp_deck import Assembled, Deck, assembled
from netdae.mesh.inp_types import LINE, SURFACE, VOLUME
from netdae.mesh.raw import RawMesh, corner_edges
from netdae.model.net import CableNet

CORNERS = {3: 3, 4: 4, 6: 3, 8: 4, 9: 4}
"""Corners of a surface element by the number of its nodes."""

# no number in an .inp states how long it is; lines with two stars are comments
_END = "** end of the net"
_HEAD = f"** whole if the last line is: {_END}"
_LINES = re.compile(rb"^\*\* data lines: (\d+)\r?$", re.MULTILINE)


def read_inp(file: Path) -> RawMesh:
    """Read an input file; raises MeshError, without the file's name."""
    data = file.read_bytes()
    text = data.decode("utf-8", errors="replace")
    findings = _check_whole(data, text)
    deck = Deck()
    deck.add(blocks_of(text, file.parent))
    found = assembled(deck)
    if not len(found.points):
        raise MeshError("the file has no nodes: check that it is an input file with *NODE")
    point_sets, about_nodes = found.sets("node")
    cell_sets, about_cells = found.sets("element")
    findings += [*about_nodes, *about_cells]
    used = {instance.part for instance in deck.instances.values()}
    findings += [
        f"the part {name} is placed nowhere and left out"
        for name, part in deck.parts.items()
        if name not in used and part.elements
    ]
    findings += [
        f"*{word} holds nodes together, which is not read: join what it joins by common nodes"
        for word in deck.joined_by
    ]
    return _raw_of(found, point_sets, cell_sets, findings)


def _check_whole(data: bytes, text: str) -> list[str]:
    """Raise MeshError for a file of netdae that is not whole; a note where another one may not be."""
    if text.startswith(_HEAD):
        promised = _LINES.search(data)
        count = _data_lines(data)
        if not text.rstrip().endswith(_END):
            raise MeshError(f"the file is cut off, its last line is not {_END!r}: save the mesh again")
        if promised and count != int(promised[1]):
            raise MeshError(
                f"the file promises {promised[1].decode()} lines of data and has {count}: save the mesh again"
            )
    last = text.splitlines()[-1].strip() if text.strip() else ""
    if last and not text.endswith(("\n", "\r")) and not last.upper().startswith(("*END", "**")):
        return [f"the file ends within the line {last[:40]!r}: check that it is whole"]
    return []


def _data_lines(data: bytes) -> int:
    return sum(1 for line in data.splitlines() if line.strip() and not line.lstrip().startswith(b"*"))


def _raw_of(
    found: Assembled,
    point_sets: Mapping[str, IntArray],
    cell_sets: Mapping[str, IntArray],
    findings: list[str],
) -> RawMesh:
    pairs: list[tuple[int, int]] = []
    line_cell: list[int] = []
    faces: dict[tuple[int, int], list[list[int]]] = {}
    face_cells: dict[tuple[int, int], list[int]] = {}
    others: Counter[str] = Counter()
    split = volumes = 0
    for cell, (scope, element) in enumerate(found.elements):
        kind = element.type.kind
        if kind == VOLUME:
            volumes += 1
        if kind not in (LINE, SURFACE):
            others[element.name.upper()] += 1
            continue
        nodes = []
        for label in element.nodes:
            node = found.node_of(scope, label)
            if node is None:
                raise MeshError(
                    f"element {found.element_labels[cell]} of the file joins node {label}, but the file has no node "
                    "of this number: edit the element or add the node"
                )
            nodes.append(node)
        if kind == LINE:
            pairs += pairwise(nodes)
            line_cell += [cell] * (len(nodes) - 1)
            split += len(nodes) > 2
        else:
            shape = len(nodes), CORNERS[len(nodes)]
            faces.setdefault(shape, []).append(nodes)
            face_cells.setdefault(shape, []).append(cell)
    edges = [corner_edges(np.array(nodes), shape[1]) for shape, nodes in faces.items()]
    counts = [len(each) // len(faces[shape]) for shape, each in zip(faces, edges, strict=True)]
    cells = [np.repeat(face_cells[shape], count) for shape, count in zip(faces, counts, strict=True)]
    none = np.zeros((0, 2), np.int64)
    return RawMesh(
        points=found.points,
        cell_count=len(found.elements),
        ends=np.array(pairs, dtype=np.int64).reshape(-1, 2),
        line_cell=np.array(line_cell, dtype=np.int64),
        face_edges=np.concatenate([none, *edges]),
        face_cell=np.concatenate([none[:, 0], *cells]),
        point_sets=point_sets,
        cell_sets=cell_sets,
        split=split,
        volumes=volumes,
        numbers=lambda: FileNumbers(
            found.node_labels,
            [
                (label, element.nodes)
                for label, (_, element) in zip(found.element_labels, found.elements, strict=True)
            ],
        ),
        findings=tuple(findings),
        left_out=", ".join(f"{count} {name}" for name, count in sorted(others.items())),
    )


def write_inp(path: Path, net: CableNet, numbers: Mapping[str, FloatArray]) -> None:
    """Write a net with its groups; raises MeshError for data of cables, for which there is no place."""
    if numbers:
        raise MeshError(f"it has no place for {', '.join(numbers)}: write .vtu, .vtk, .msh or .xdmf")
    lines = ["*NODE", *(f"{k}, {x!r}, {y!r}, {z!r}" for k, (x, y, z) in enumerate(net.nodes.tolist(), 1))]
    lines += ["*ELEMENT, TYPE=T3D2"]
    lines += [f"{k}, {i + 1}, {j + 1}" for k, (i, j) in enumerate(net.cables.tolist(), 1)]
    for key, groups in (("NSET", net.node_groups), ("ELSET", net.cable_groups)):
        for name, member in groups.items():
            if name != "all" and len(member):
                lines += [f"*{key}, {key}={_quoted(name)}", *_rows(member + 1)]
    text = "\n".join(lines) + "\n"
    head = f"{_HEAD}\n** data lines: {_data_lines(text.encode())}\n"
    path.write_text(f"{head}{text}{_END}\n", encoding="utf-8", newline="\n")


def _quoted(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z_][\w.+-]*", name) else f'"{name}"'


def _rows(numbers: IntArray) -> list[str]:
    """Sixteen numbers a line, as many as Abaqus takes."""
    return [", ".join(map(str, numbers[k : k + 16].tolist())) for k in range(0, len(numbers), 16)]
