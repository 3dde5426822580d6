"""What the author of a mesh should know about it, and how two nets differ, in words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.core.errors import MeshError
from netdae.model.net import CableNet


class FileNumbers(NamedTuple):
    """Numbers by which a mesh file calls its nodes and elements, in file order.

    nodes : number of each node
    elements : number of each element, and the numbers of its nodes
    """

    nodes: Sequence[int | str]
    elements: Sequence[tuple[int | str, Sequence[int | str]]]

    def check(self) -> None:
        """Raise MeshError for an element with a node that the file does not have."""
        known = {*self.nodes}
        for number, nodes in self.elements:
            lost = next((node for node in nodes if node not in known), None)
            if lost is not None:
                raise MeshError(
                    f"element {number} of the file joins node {lost}, but the file has no node of this number: "
                    "edit the element or add the node"
                )


def many(count: int, noun: str) -> str:
    """Count and noun, in the plural where needed."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def report_doubles(
    ends: IntArray,
    kept: IntArray,
    same: IntArray,
    groups: Mapping[str, BoolArray],
    findings: list[str],
    node_name: Callable[[int], str],
) -> None:
    """Report lines given twice, but not those that a format repeats once per group."""
    if len(kept) == len(ends):
        return
    member = np.column_stack([np.zeros(len(ends), dtype=bool), *groups.values()])
    _, first = np.unique(np.column_stack([same, member]), axis=0, return_index=True)
    new = np.zeros(len(ends), dtype=bool)
    new[first] = True
    grouped = member.any(axis=1)
    also_grouped = np.bincount(same, grouped) > 0
    doubles = np.flatnonzero(~new | (~grouped & also_grouped[same]))
    if len(doubles):
        i, j = ends[doubles[0]]
        findings.append(
            f"{many(len(doubles), 'cable')} given twice, kept once (first: between {node_name(i)} and {node_name(j)})"
        )


def report_unused(used: BoolArray, node_groups: Mapping[str, BoolArray], findings: list[str]) -> None:
    """Report nodes that no cable joins."""
    unused = int(np.count_nonzero(~used))
    if unused:
        text = f"{many(unused, 'node')} without a cable dropped"
        losers = {name: int(np.count_nonzero(member & ~used)) for name, member in node_groups.items()}
        lost = ", ".join(f"{name!r} loses {count}" for name, count in losers.items() if count)
        findings.append(f"{text}; of the groups {lost}" if lost else text)


def report_coincident(nodes: FloatArray, findings: list[str], node_name: Callable[[int], str]) -> None:
    """Report nodes that coincide with another; `node_name` returns the file's name of the k-th of them."""
    low = nodes.min(axis=0)
    # far below the spacing of any net, far above the digits that files keep
    near = max(1e-9 * float(np.linalg.norm(nodes.max(axis=0) - low)), np.finfo(np.float64).tiny)
    _, first, place = np.unique(
        np.round((nodes - low) / near), axis=0, return_index=True, return_inverse=True
    )
    extra = len(nodes) - len(first)
    if extra:
        origin = first[place.reshape(-1)]
        node = int(np.flatnonzero(origin != np.arange(len(nodes)))[0])
        findings.append(
            f"{many(extra, 'node')} at the place of another (first: {node_name(int(origin[node]))} and "
            f"{node_name(node)}), not joined: where they are one knot, give "
            "merge = 1e-6 in [net], --merge 1e-6 on the command line"
        )


def difference_of(net: CableNet, other: CableNet) -> str:
    """How `other` differs from `net`, in words; empty when it does not."""
    loose = np.setdiff1d(np.arange(net.node_count), net.cables)
    if len(loose):
        return f"no node {loose[0]}, which has no cable"
    if not np.array_equal(net.nodes, other.nodes):
        return (
            "other nodes"
            if net.node_count == other.node_count
            else f"{other.node_count} of {net.node_count} nodes"
        )
    if not np.array_equal(net.cables, other.cables):
        return f"{other.cable_count} cables, not the same {net.cable_count}"
    # a cable group gives a node group of its name when it is read
    implied = {name: np.unique(net.cables[member]) for name, member in net.cable_groups.items()}
    for kind, want, have in (
        ("cable", net.cable_groups, other.cable_groups),
        ("node", {**implied, **net.node_groups}, other.node_groups),
    ):
        wanted = {name: member for name, member in want.items() if len(member)}
        for name in sorted({*wanted, *have}):
            if name not in wanted or name not in have or not np.array_equal(wanted[name], have[name]):
                return f"another {kind} group {name!r}"
    if not np.array_equal(net.rest_length, other.rest_length):
        return "other rest lengths"
    for name in sorted({*net.cable_data, *other.cable_data}):
        if not np.array_equal(net.cable_data.get(name), other.cable_data.get(name), equal_nan=True):  # type: ignore[arg-type]
            return f"other cable data {name!r}"
    return ""
