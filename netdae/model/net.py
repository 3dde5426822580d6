"""The cable net: knots in their reference positions, joined by cables.

Symbols: n nodes, m cables, x̄ reference position (n, 3), L̄ rest length (m,).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from netdae.core.arrays import FloatArray, IntArray, frozen_floats, frozen_ints
from netdae.core.errors import InputError
from netdae.model import patterns

CABLE_DATA = ("diameter", "area", "youngs_modulus", "density", "prestress")
"""Names of per-cable data that override the material, in SI units."""

ZERO_OR_MORE = ("density", "prestress")
"""Those of them that may be zero."""


@dataclass(frozen=True, eq=False)
class CableNet:
    """Topology and reference geometry of a net.

    nodes : (n, 3), m, the reference positions x̄
    cables : (m, 2), the nodes that each cable joins
    node_groups, cable_groups : name to indices, or to one bool per node or cable; kept as sorted indices;
        the group "all" always exists
    rest_length : (m,), m, L̄; by default the distance in x̄
    cable_data : any of `CABLE_DATA` to (m,) values, SI units, NaN where the material's value applies

    Raises InputError for a net that cannot be built, with the node or cable.
    """

    nodes: FloatArray
    cables: IntArray
    node_groups: Mapping[str, IntArray] = field(default_factory=dict)
    cable_groups: Mapping[str, IntArray] = field(default_factory=dict)
    rest_length: FloatArray = None  # type: ignore[assignment]  # set below from x̄
    cable_data: Mapping[str, FloatArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        nodes, cables = frozen_floats(self.nodes), _cables_of(self.cables)
        _check_nodes(nodes)
        _check_cables(cables, len(nodes))
        if self.rest_length is None:
            rest_length = frozen_floats(np.linalg.norm(_spans_of(nodes, cables), axis=1))
        else:
            rest_length = frozen_floats(self.rest_length)
        _check_rest_length(rest_length, cables)
        put = object.__setattr__
        put(self, "nodes", nodes)
        put(self, "cables", cables)
        put(self, "rest_length", rest_length)
        put(self, "node_groups", _groups_of(self.node_groups, len(nodes), "node"))
        put(self, "cable_groups", _groups_of(self.cable_groups, len(cables), "cable"))
        put(self, "cable_data", _cable_data_of(self.cable_data, len(cables)))

    @property
    def node_count(self) -> int:
        """Number of nodes n."""
        return len(self.nodes)

    @property
    def cable_count(self) -> int:
        """Number of cables m."""
        return len(self.cables)

    @property
    def spans(self) -> FloatArray:
        """x̄ⱼ − x̄ᵢ of each cable from node i to node j, (m, 3), m."""
        return _spans_of(self.nodes, self.cables)

    def nodes_of(self, group: str) -> IntArray:
        """Node indices of a group; raises InputError that lists the groups."""
        return _member(self.node_groups, group, "node")

    def cables_of(self, group: str) -> IntArray:
        """Cable indices of a group; raises InputError that lists the groups."""
        return _member(self.cable_groups, group, "cable")

    def with_nodes(self, nodes: ArrayLike) -> CableNet:
        """Copy with other reference positions x̄ and the same rest lengths, for instance a rotated net."""
        return replace(self, nodes=np.asarray(nodes, dtype=np.float64))

    @classmethod
    def square(cls, *, side: float, cells: int, subdivide: int = 1) -> CableNet:
        """Square net in the xy plane, centred at the origin: `cells` × `cells` meshes, side in m."""
        return cls._from(patterns.square(side=side, cells=cells, subdivide=subdivide))

    @classmethod
    def rectangle(
        cls, *, width: float, height: float, columns: int, rows: int, subdivide: int = 1
    ) -> CableNet:
        """Rectangular net in the xy plane: `columns` × `rows` meshes over width (x) × height (y), m."""
        return cls._from(
            patterns.rectangle(width=width, height=height, columns=columns, rows=rows, subdivide=subdivide)
        )

    @classmethod
    def hexagon(cls, *, radius: float, rings: int, subdivide: int = 1) -> CableNet:
        """Hexagonal net of triangular meshes, `rings` rings about the centre, corners at `radius` m."""
        return cls._from(patterns.hexagon(radius=radius, rings=rings, subdivide=subdivide))

    @classmethod
    def radial(cls, *, radius: float, rings: int, spokes: int, subdivide: int = 1) -> CableNet:
        """Spider-web net: `spokes` radial cables and `rings` closed rings out to `radius` m."""
        return cls._from(patterns.radial(radius=radius, rings=rings, spokes=spokes, subdivide=subdivide))

    @classmethod
    def diamond(cls, *, side: float, cells: int, subdivide: int = 1) -> CableNet:
        """Square net whose inner meshes stand on their corners, in a straight border of `side` m."""
        return cls._from(patterns.diamond(side=side, cells=cells, subdivide=subdivide))

    @classmethod
    def _from(cls, pattern: patterns.Pattern) -> CableNet:
        return cls(pattern.nodes, pattern.cables, pattern.node_groups, pattern.cable_groups)


def _spans_of(nodes: FloatArray, cables: IntArray) -> FloatArray:
    return nodes[cables[:, 1]] - nodes[cables[:, 0]]


def _cables_of(cables: Any) -> IntArray:
    array = np.asarray(cables)
    if array.size == 0:
        raise InputError("the net has no cables: give at least one pair of nodes")
    if array.ndim != 2 or array.shape[1] != 2 or array.dtype.kind not in "iu":
        raise InputError(f"cables are (m, 2) whole numbers, not {array.shape} of {array.dtype}")
    return frozen_ints(array)


def _check_nodes(nodes: FloatArray) -> None:
    if nodes.ndim != 2 or nodes.shape[1] != 3:
        raise InputError(f"nodes are (n, 3) coordinates in m, not {nodes.shape}")
    wrong = np.flatnonzero(~np.isfinite(nodes).all(axis=1))
    if len(wrong):
        raise InputError(
            f"node {wrong[0]} has the coordinates {nodes[wrong[0]].tolist()}: give finite numbers"
        )


def _check_cables(cables: IntArray, node_count: int) -> None:
    outside = np.flatnonzero((cables < 0).any(axis=1) | (cables >= node_count).any(axis=1))
    if len(outside):
        i, j = cables[outside[0]]
        wrong = j if 0 <= i < node_count else i
        raise InputError(f"cable {outside[0]} joins node {wrong}, but the net has {node_count} nodes")
    loops = np.flatnonzero(cables[:, 0] == cables[:, 1])
    if len(loops):
        raise InputError(
            f"cable {loops[0]} joins node {cables[loops[0], 0]} to itself: a cable needs two different nodes"
        )


def _check_rest_length(rest_length: FloatArray, cables: IntArray) -> None:
    if rest_length.shape != (len(cables),):
        raise InputError(
            f"rest_length holds {rest_length.shape} values for {len(cables)} cables: give one per cable"
        )
    wrong = np.flatnonzero(~(np.isfinite(rest_length) & (rest_length > 0)))
    if len(wrong):
        e = wrong[0]
        raise InputError(
            f"cable {e} between nodes {cables[e, 0]} and {cables[e, 1]} has the rest length {rest_length[e]:g} m: "
            "move the nodes apart or give a rest_length above zero"
        )


def _groups_of(groups: Mapping[str, Any], count: int, kind: str) -> Mapping[str, IntArray]:
    result = {"all": frozen_ints(np.arange(count))}
    for name, members in groups.items():
        indices = np.unique(_indices_of(members, count, f"{kind} group {name!r}"))
        if len(indices) and (indices[0] < 0 or indices[-1] >= count):
            wrong = indices[0] if indices[0] < 0 else indices[-1]
            raise InputError(f"{kind} group {name!r} holds {kind} {wrong}, but the net has {count} {kind}s")
        if name != "all":
            result[name] = frozen_ints(indices)
    return MappingProxyType(result)


def _indices_of(members: Any, count: int, what: str) -> IntArray:
    array = np.asarray(members)
    if array.dtype == np.bool_ and array.shape == (count,):
        return np.flatnonzero(array)
    if array.size and array.dtype.kind not in "iu":
        raise InputError(
            f"{what} holds {array.shape} of {array.dtype}: give whole numbers, or a mask of {count} booleans"
        )
    return array.astype(np.int64)


def _cable_data_of(data: Mapping[str, Any], count: int) -> Mapping[str, FloatArray]:
    result = {}
    for name, values in data.items():
        if name not in CABLE_DATA:
            raise InputError(f"cable data {name!r} is unknown: netdae reads {', '.join(CABLE_DATA)}")
        array = frozen_floats(values)
        if array.shape != (count,):
            raise InputError(
                f"cable data {name!r} holds {array.shape} values for {count} cables: give one per cable"
            )
        high_enough, bound = (
            (array >= 0, "zero or more") if name in ZERO_OR_MORE else (array > 0, "above zero")
        )
        wrong = np.flatnonzero(~(np.isnan(array) | (np.isfinite(array) & high_enough)))
        if len(wrong):
            raise InputError(f"cable {wrong[0]} has {name} {array[wrong[0]]:g}: give a finite number {bound}")
        result[name] = array
    return MappingProxyType(result)


def _member(groups: Mapping[str, IntArray], name: str, kind: str) -> IntArray:
    if name not in groups:
        raise InputError(f"there is no {kind} group {name!r}: the net has {', '.join(sorted(groups))}")
    return groups[name]
