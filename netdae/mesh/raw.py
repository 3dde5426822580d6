"""What a mesh file holds, independent of its format.

Symbols: p points, s straight line pieces, c cells of the file (of every type, in file order).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.mesh.findings import FileNumbers
from netdae.model.net import CABLE_DATA

NUMBERS = (*CABLE_DATA, "rest_length")
"""Names of cell data that are numbers of the cables and not groups."""

MOST_KINDS = 16
"""Integer data with more values than this enumerate something: they make one group, not one per value."""

Data = Mapping[str, NDArray[Any]]


def no_indices() -> IntArray:
    """No points, pieces or cells."""
    return np.zeros(0, dtype=np.int64)


def _no_pairs() -> IntArray:
    return np.zeros((0, 2), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class RawMesh:
    """Arrays of a mesh file.

    points : (p, 3), m
    cell_count : c
    ends : (s, 2), the points that each line piece joins; a poly line or a quadratic line gives several
    line_cell : (s,), the cell that each piece belongs to
    vertices, vertex_cell : (k,), points that are cells, and their cells
    face_edges, face_cell : (f, 2), edges of all surface cells, an edge between two of them twice, and their cells
    point_data, cell_data : name to (p, ...) or (c, ...)
    point_sets, cell_sets : name to points or cells
    split : number of quadratic and poly lines cut into pieces
    volumes : number of cells with a volume
    numbers : gives the numbers by which the file calls nodes and elements, for messages; None where it has none
    findings : what the author of the file should know, a sentence each
    left_out : elements that are neither lines nor surfaces, by their type in the file
    """

    points: FloatArray
    cell_count: int
    ends: IntArray = field(default_factory=_no_pairs)
    line_cell: IntArray = field(default_factory=no_indices)
    vertices: IntArray = field(default_factory=no_indices)
    vertex_cell: IntArray = field(default_factory=no_indices)
    face_edges: IntArray = field(default_factory=_no_pairs)
    face_cell: IntArray = field(default_factory=no_indices)
    point_data: Data = field(default_factory=dict)
    cell_data: Data = field(default_factory=dict)
    point_sets: Mapping[str, IntArray] = field(default_factory=dict)
    cell_sets: Mapping[str, IntArray] = field(default_factory=dict)
    split: int = 0
    volumes: int = 0
    numbers: Callable[[], FileNumbers] | None = None
    findings: tuple[str, ...] = ()
    left_out: str = ""

    def node_name(self, node: int) -> str:
        """What the file calls a point."""
        nodes = self.numbers().nodes if self.numbers else ()
        return (
            f"node {nodes[node]} of the file" if len(nodes) == len(self.points) else f"node {node} (from 0)"
        )

    def cable_name(self, piece: int) -> str:
        """What the file calls the cell of a line piece."""
        cell = int(self.line_cell[piece])
        elements = self.numbers().elements if self.numbers else ()
        if len(elements) == self.cell_count:
            return f"cable {elements[cell][0]} of the file"
        return f"cable {cell} (from 0)"

    @property
    def unused_data(self) -> tuple[str, ...]:
        """Names of the data that a net does not use."""
        known = [*integer_groups(self.point_data), *integer_groups(self.cell_data)]
        names = {*self.point_data, *(name for name in self.cell_data if name not in NUMBERS)}
        return tuple(sorted(name for name in names - set(known) if not _is_internal(name)))


def chain_of(connectivity: IntArray, sizes: IntArray) -> tuple[IntArray, IntArray]:
    """Pieces (s, 2) of the chains of points that make up `connectivity`, and the chain of each (s,)."""
    chain = np.repeat(np.arange(len(sizes)), sizes)
    within = chain[1:] == chain[:-1]
    return np.column_stack([connectivity[:-1], connectivity[1:]])[within], chain[1:][within]


def corner_edges(nodes: IntArray, corners: int) -> IntArray:
    """Edges (f, 2) of surface cells, nodes (cells, k): corners first, then, if any, the nodes inside their edges.

    The edges of one cell follow one another, from corner to corner by way of the nodes inside.
    """
    around = nodes[:, :corners]
    if nodes.shape[1] > corners:
        around = np.stack([around, nodes[:, corners : 2 * corners]], axis=-1).reshape(len(nodes), -1)
    return np.stack([around, np.roll(around, -1, axis=1)], axis=-1).reshape(-1, 2).astype(np.int64)


def _is_internal(name: str) -> bool:
    """Whether data are a mesh program's own bookkeeping."""
    return name.startswith(("gmsh:", "vtk", "cell_tags"))


def integer_groups(data: Data) -> dict[str, BoolArray]:
    """Groups by integer data: everything that is not 0; with several values, also `name:value` for each."""
    groups: dict[str, BoolArray] = {}
    for name, values in data.items():
        if values.dtype.kind not in "iub" or name in NUMBERS or _is_internal(name):
            continue
        column = values.reshape(len(values), -1)
        if column.shape[1] != 1:
            continue
        groups[name] = column[:, 0] != 0
        kinds = np.unique(column[groups[name], 0])
        if 1 < len(kinds) <= MOST_KINDS:
            groups.update({f"{name}:{kind}": column[:, 0] == kind for kind in kinds.tolist()})
    return groups
