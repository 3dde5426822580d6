"""The net made from a raw mesh.

Symbols as in `mesh.raw`.
"""

from __future__ import annotations

import numpy as np

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.core.errors import MeshError
from netdae.mesh.findings import many, report_coincident, report_doubles, report_unused
from netdae.mesh.raw import NUMBERS, RawMesh, integer_groups, no_indices
from netdae.model.net import ZERO_OR_MORE, CableNet

LARGEST_PLACE = 1e6
"""Largest coordinate of a mesh, m: nets are metres wide, and beyond this, positions lose micrometres."""

SHORTEST_CABLE = 1e-9
"""Shortest distance of a cable's nodes, m, unless its rest length is given: about the width of an atom."""

SMALLEST, LARGEST = 1e-20, 1e20
"""Range of numbers of the cables, SI units: anything beyond is a wrong unit."""

Groups = dict[str, BoolArray]


def net_of(raw: RawMesh, *, surface_edges: bool = False) -> tuple[CableNet, tuple[str, ...]]:
    """Net of the lines of a mesh, and what its author should know, a sentence each.

    Lines given twice become one cable, in the groups of both; nodes without a cable are dropped, also from
    their groups. A cable group gives the node group of its ends as well, unless there is one of that name. With
    `surface_edges` the edges of the surface cells are cables too, in the groups border (edges of one cell
    only) and inner.

    Raises MeshError, without the file's name, for a mesh that is not a net.
    """
    findings = [*raw.findings]
    _check_points(raw)
    _check_lines(raw, surface_edges)
    if raw.split:
        findings.append(f"{many(raw.split, 'line')} of more than two points split into straight cables")
    if raw.left_out:
        findings.append(f"elements that are no cables are left out: {raw.left_out}")
    if len(raw.face_edges) and not surface_edges:
        findings.append(
            "the surface cells are left out, only the lines are cables: for the edges of the cells as well, give "
            "surface_edges = true in [net], --surface-edges on the command line"
        )
    ends, groups, numbers = raw.ends, _line_groups(raw), _numbers(raw)
    kept, same = _distinct(ends)
    report_doubles(ends, kept, same, groups, findings, raw.node_name)
    if surface_edges:
        ends, groups, numbers = _with_edges(raw, ends, groups, numbers)
        kept, same = _distinct(ends)
    cables = ends[kept]
    groups = {name: _any_of(member, same, len(kept)) for name, member in groups.items()}
    numbers = {name: _first_of(values, same, len(kept)) for name, values in numbers.items()}
    node_groups = _node_groups(raw)
    for name, member in groups.items():
        ends_of = np.zeros(len(raw.points), dtype=bool)
        ends_of[cables[member]] = True
        node_groups.setdefault(name, ends_of)
    used = np.zeros(len(raw.points), dtype=bool)
    used[cables] = True
    report_unused(used, node_groups, findings)
    nodes = raw.points[used]
    cables = (np.cumsum(used) - 1)[cables]
    node_groups = {name: member[used] for name, member in node_groups.items()}
    place = np.flatnonzero(used)
    report_coincident(nodes, findings, lambda node: raw.node_name(int(place[node])))
    for kind, found in (("node", node_groups), ("cable", groups)):
        if "all" in found and not found["all"].all():
            findings.append(
                f"the {kind} group 'all' of the file is left out: 'all' always means every {kind}"
            )
    rest_length = numbers.pop("rest_length", None)
    if rest_length is not None:
        span = np.linalg.norm(nodes[cables[:, 1]] - nodes[cables[:, 0]], axis=1)
        rest_length = np.where(np.isnan(rest_length), span, rest_length)
    net = CableNet(
        nodes,
        cables,
        {name: np.flatnonzero(member) for name, member in node_groups.items() if member.any()},
        {name: np.flatnonzero(member) for name, member in groups.items() if member.any()},
        rest_length,  # type: ignore[arg-type]  # None is the distance in x̄
        numbers,
    )
    return net, tuple(findings)


def _check_points(raw: RawMesh) -> None:
    wrong = np.flatnonzero(~(np.abs(raw.points) <= LARGEST_PLACE).all(axis=1))
    if len(wrong):
        where = ", ".join(f"{x:g}" for x in raw.points[wrong[0]])
        raise MeshError(
            f"{raw.node_name(int(wrong[0]))} has the coordinates ({where}): give finite numbers in m, "
            f"{LARGEST_PLACE:g} at most"
        )


def _check_lines(raw: RawMesh, surface_edges: bool) -> None:
    if surface_edges and not len(raw.face_edges):
        raise MeshError(
            "the mesh has no surface cells whose edges could be cables: leave surface_edges (--surface-edges) out"
        )
    if not len(raw.ends) and not surface_edges:
        if len(raw.face_edges):
            raise MeshError(
                "a surface mesh without lines is no net, its cells are membranes: "
                "ask for its edges as cables (surface_edges = true in [net], --surface-edges on the command line), "
                "or save the lines"
            )
        if raw.volumes:
            raise MeshError(
                f"the mesh has {many(raw.volumes, 'volume cell')} and no lines: save the cables as lines"
            )
        elements = f", its elements are {raw.left_out}" if raw.left_out else ""
        raise MeshError(f"the mesh has no lines{elements}: each cable is a line between two nodes")
    for kind, pairs in (("cable", raw.ends), ("surface edge", raw.face_edges)):

        def name(k: int, kind: str = kind) -> str:
            return raw.cable_name(k) if kind == "cable" else f"{kind} {k}"

        outside = np.flatnonzero(((pairs < 0) | (pairs >= len(raw.points))).any(axis=1))
        if len(outside):
            if raw.numbers:
                raw.numbers().check()
            i, j = pairs[outside[0]]
            wrong = j if 0 <= i < len(raw.points) else i
            count = len(raw.points)
            raise MeshError(f"{name(outside[0])} joins node {wrong}, but the file has {many(count, 'node')}")
        loops = np.flatnonzero(pairs[:, 0] == pairs[:, 1])
        if len(loops):
            node = raw.node_name(int(pairs[loops[0], 0]))
            raise MeshError(f"{name(loops[0])} joins {node} to itself: a cable needs two different nodes")
    if "rest_length" not in raw.cell_data:
        span = np.linalg.norm(raw.points[raw.ends[:, 1]] - raw.points[raw.ends[:, 0]], axis=1)
        if (span < SHORTEST_CABLE).any():
            k = int(np.argmin(span))
            i, j = (raw.node_name(node) for node in raw.ends[k].tolist())
            raise MeshError(
                f"{raw.cable_name(k)} between {i} and {j} has the rest length {span[k]:g} m: move the nodes apart "
                f"or give a rest_length, {SHORTEST_CABLE:g} m at least"
            )


def _cell_groups(raw: RawMesh) -> Groups:
    groups = integer_groups(raw.cell_data)
    for name, cells in raw.cell_sets.items():
        member = groups.setdefault(name, np.zeros(raw.cell_count, dtype=bool))
        member[cells] = True
    return groups


def _line_groups(raw: RawMesh) -> Groups:
    groups = {name: member[raw.line_cell] for name, member in _cell_groups(raw).items()}
    return {name: member for name, member in groups.items() if member.any()}


def _node_groups(raw: RawMesh) -> Groups:
    groups = integer_groups(raw.point_data)
    of_vertices = {name: raw.vertices[member[raw.vertex_cell]] for name, member in _cell_groups(raw).items()}
    for sets in (raw.point_sets, of_vertices):
        for name, points in sets.items():
            if len(points):
                groups.setdefault(name, np.zeros(len(raw.points), dtype=bool))[points] = True
    return {name: member for name, member in groups.items() if member.any()}


def _numbers(raw: RawMesh) -> dict[str, FloatArray]:
    """Numbers of the line pieces; a split line's rest length is divided in proportion to the distances."""
    numbers: dict[str, FloatArray] = {}
    for name in NUMBERS:
        if name not in raw.cell_data:
            continue
        values = raw.cell_data[name]
        if values.dtype.kind not in "iuf" or values.size != raw.cell_count:
            raise MeshError(
                f"cell data {name!r} are {values.shape} of {values.dtype}: give one number per cable"
            )
        numbers[name] = values.reshape(-1)[raw.line_cell].astype(np.float64)
        inside = (numbers[name] >= SMALLEST) & (numbers[name] <= LARGEST)
        bound = "above zero"
        if name in ZERO_OR_MORE:
            inside, bound = inside | (numbers[name] == 0), "zero or more"
        wrong = np.flatnonzero(~(np.isnan(numbers[name]) | inside))
        if len(wrong):
            found = numbers[name][wrong[0]]
            raise MeshError(
                f"{raw.cable_name(int(wrong[0]))} has {name} {found:g}: give a number {bound}, "
                f"{SMALLEST:g} to {LARGEST:g} in SI units"
            )
    if raw.split and "rest_length" in numbers:
        span = np.linalg.norm(raw.points[raw.ends[:, 1]] - raw.points[raw.ends[:, 0]], axis=1)
        whole = np.bincount(raw.line_cell, span, raw.cell_count)[raw.line_cell]
        pieces = np.bincount(raw.line_cell, minlength=raw.cell_count)[raw.line_cell]
        numbers["rest_length"] *= np.divide(span, whole, out=1 / pieces, where=whole > 0)
    return numbers


def _distinct(ends: IntArray) -> tuple[IntArray, IntArray]:
    """The first line of each pair of nodes, in file order, and for each line its place among them."""
    if not len(ends):
        return no_indices(), no_indices()
    key = ends.min(axis=1) * (int(ends.max()) + 1) + ends.max(axis=1)
    _, first, same = np.unique(key, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order], rank[same.reshape(-1)]


def _with_edges(
    raw: RawMesh, ends: IntArray, groups: Groups, numbers: dict[str, FloatArray]
) -> tuple[IntArray, Groups, dict[str, FloatArray]]:
    """The lines followed by the distinct edges of the surface cells, which are in the groups of their cells."""
    face_edges = raw.face_edges
    first, same = _distinct(face_edges)
    outer = np.bincount(same) == 1
    none = np.zeros(len(first), dtype=bool)
    grown = {name: np.concatenate([member, none]) for name, member in groups.items()}
    for name, member in (("border", outer), ("inner", ~outer)):
        grown.setdefault(name, np.zeros(len(ends) + len(first), dtype=bool))[len(ends) :] = member
    for name, cells in _cell_groups(raw).items():
        member = _any_of(cells[raw.face_cell], same, len(first))
        if member.any():
            grown.setdefault(name, np.zeros(len(ends) + len(first), dtype=bool))[len(ends) :] |= member
    blank = np.full(len(first), np.nan)
    return (
        np.concatenate([ends, face_edges[first]]),
        grown,
        {name: np.concatenate([values, blank]) for name, values in numbers.items()},
    )


def _any_of(member: BoolArray, same: IntArray, count: int) -> BoolArray:
    return np.asarray(np.bincount(same[member], minlength=count) > 0)


def _first_of(values: FloatArray, same: IntArray, count: int) -> FloatArray:
    result = np.full(count, np.nan)
    given = np.flatnonzero(~np.isnan(values))[::-1]  # of several values for one place numpy keeps the last
    result[same[given]] = values[given]
    return result
