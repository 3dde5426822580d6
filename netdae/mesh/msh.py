"""Physical groups of Gmsh's MSH files, versions 2.2 and 4.1, and the writing of 4.1.

Curves may be in several groups, which meshio does not write, hence the writer.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.core.errors import MeshError
from netdae.mesh.msh_tables import LINE, VERTEX, Numbers, Sections, sections_of
from netdae.model.net import CableNet

VERSIONS = {"2": "2.2", "2.2": "2.2", "4.1": "4.1"}


@dataclass(frozen=True)
class PhysicalGroups:
    """Physical groups of an MSH file.

    version : "2.2" or "4.1"
    names : (dimension, number) to the name of the group
    entities : (dimension, entity) to the numbers of its groups, 4.1 only
    sections : the tables of the file
    """

    version: str
    names: Mapping[tuple[int, int], str]
    entities: Mapping[tuple[int, int], tuple[int, ...]]
    sections: Sections

    def cell_sets(self, blocks: Sequence[tuple[int, IntArray]]) -> dict[str, IntArray]:
        """Name to cells, from the dimension and the tag of each cell of each block.

        The tags are numbers of groups in 2.2, of entities in 4.1. A group without a name is named by its number.
        """
        members: dict[str, list[IntArray]] = {}
        start = 0
        for dimension, tags in blocks:
            for tag in np.unique(tags).tolist():
                cells = start + np.flatnonzero(tags == tag)
                numbers = (tag,) if self.version == "2.2" else self.entities.get((dimension, tag), ())
                for number in numbers:
                    if number:
                        name = self.names.get((dimension, abs(number)), str(abs(number)))
                        members.setdefault(name, []).append(cells)
            start += len(tags)
        return {name: np.unique(np.concatenate(cells)) for name, cells in members.items()}


def physical_groups_of(data: bytes) -> PhysicalGroups:
    """Tables of the physical groups of an MSH file; raises MeshError for versions that are not supported."""
    if data.lstrip().startswith((b"$NOD", b"$ELM")):
        raise MeshError("MSH version 1 is not read: save it again as version 4.1 or 2.2 (gmsh -format msh41)")
    head = re.search(rb"^\$MeshFormat\s+(\S+)\s+([01])\s+(\d+)", data, re.MULTILINE)
    if head is None:
        raise MeshError("no $MeshFormat with version, type and size found: this is no MSH file")
    version = head[1].decode(errors="replace")
    if version not in VERSIONS:
        shown = "4.0" if version == "4" else version
        raise MeshError(
            f"MSH version {shown} is not read: save it again as version 4.1 or 2.2 (gmsh -format msh41)"
        )
    if b"$PartitionedEntities" in data:
        raise MeshError("the mesh is partitioned: save it again unpartitioned")
    sections = sections_of(data, VERSIONS[version], head[2] == b"0", int(head[3]))
    names = _names_of(b"\n".join(sections.tables.get("PhysicalNames", [])).decode("utf-8"))
    table = b"".join(sections.tables.get("Entities", []))
    entities = _entities_of(sections.reader(table)) if table and sections.version == "4.1" else {}
    return PhysicalGroups(sections.version, names, entities, sections)


def write_msh(path: Path, net: CableNet, numbers: Mapping[str, FloatArray]) -> None:
    """Write a net as MSH 4.1 in text, with its groups, and `numbers` (m,) as element data.

    Cables of the same groups are a curve, each node that is in a group is a point.
    """
    node_names, node_member = _members(net.node_groups, net.node_count)
    cable_names, cable_member = _members(net.cable_groups, net.cable_count)
    points = np.flatnonzero(node_member.any(axis=1))
    curves, curve = np.unique(cable_member, axis=0, return_inverse=True)
    curve = curve.reshape(-1)
    low, high = (" ".join(f"{x:.17g}" for x in f(axis=0)) for f in (net.nodes.min, net.nodes.max))
    text = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat"]
    named = [(0, node_names), (1, cable_names)]
    rows = [f'{dimension} {k + 1} "{name}"' for dimension, names in named for k, name in enumerate(names)]
    text += ["$PhysicalNames", str(len(rows)), *rows, "$EndPhysicalNames"]
    text += ["$Entities", f"{len(points)} {len(curves)} 0 0"]
    text += [f"{node + 1} {_place(net.nodes[node])} {_list(node_member[node])}" for node in points.tolist()]
    text += [f"{k + 1} {low} {high} {_list(member)} 0" for k, member in enumerate(curves)]
    text += ["$EndEntities"]

    # runs keep the order of nodes and cables
    at_point = np.isin(np.arange(net.node_count), points)
    runs = _runs(np.where(at_point, np.arange(net.node_count), -1))
    text += ["$Nodes", f"{len(runs)} {net.node_count} 1 {net.node_count}"]
    for start, stop in runs:
        text.append(f"0 {start + 1} 0 1" if at_point[start] else f"1 1 0 {stop - start}")
        text += [str(node + 1) for node in range(start, stop)]
        text += [_place(x) for x in net.nodes[start:stop]]
    text += ["$EndNodes"]

    runs = _runs(curve)
    count = net.cable_count + len(points)
    text += ["$Elements", f"{len(runs) + len(points)} {count} 1 {count}"]
    for start, stop in runs:
        text.append(f"1 {curve[start] + 1} {LINE} {stop - start}")
        text += [
            f"{e + 1} {i + 1} {j + 1}" for e, (i, j) in enumerate(net.cables[start:stop].tolist(), start)
        ]
    for k, node in enumerate(points.tolist()):
        text += [f"0 {node + 1} {VERTEX} 1", f"{net.cable_count + k + 1} {node + 1}"]
    text += ["$EndElements"]
    for name, values in numbers.items():
        # readers expect a value for every element: the points get 0
        data = [*values.tolist(), *np.zeros(len(points)).tolist()]
        text += ["$ElementData", "1", f'"{name}"', "1", "0", "3", "0", "1", str(count)]
        text += [f"{e + 1} {value:.17g}" for e, value in enumerate(data)]
        text += ["$EndElementData"]
    path.write_text("\n".join(text) + "\n", encoding="utf-8", newline="\n")


def _names_of(table: str) -> dict[tuple[int, int], str]:
    names = {}
    for line in table.splitlines()[1:]:
        if line.strip():
            dimension, number, name = shlex.split(line)[:3]
            names[int(dimension), int(number)] = name
    return names


def _entities_of(read: Numbers) -> dict[tuple[int, int], tuple[int, ...]]:
    entities = {}
    for dimension, count in enumerate(read.sizes(4)):
        for _ in range(count):
            (tag,) = read.ints(1)
            read.floats(3 if dimension == 0 else 6)
            entities[dimension, tag] = tuple(read.ints(read.sizes(1)[0]))
            if dimension > 0:
                read.ints(read.sizes(1)[0])
    return entities


def _members(groups: Mapping[str, IntArray], count: int) -> tuple[list[str], BoolArray]:
    names = [name for name, member in groups.items() if name != "all" and len(member)]
    table = np.zeros((count, len(names)), dtype=bool)
    for k, name in enumerate(names):
        table[groups[name], k] = True
    return names, table


def _list(member: BoolArray) -> str:
    numbers = np.flatnonzero(member) + 1
    return " ".join(str(n) for n in [len(numbers), *numbers.tolist()])


def _place(x: FloatArray) -> str:
    return " ".join(f"{value:.17g}" for value in x.tolist())


def _runs(kinds: IntArray) -> list[tuple[int, int]]:
    """Start and stop of each run of equal values."""
    breaks = np.flatnonzero(np.diff(kinds)) + 1
    return list(zip([0, *breaks.tolist()], [*breaks.tolist(), len(kinds)], strict=True))
