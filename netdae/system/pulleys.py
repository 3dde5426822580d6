"""Cords of constant length through rings: pulleys, tackles, and lines that run through eyes.

A cord slides through rings at nodes of the net and is fastened at its ends, or is endless. A ring at a node that is
held is a fixed pulley, one at a free node a moving one. The cord is that of `forces.drawcord` on a drum that never
turns: with ṡ = 0 the speed at which it slides through ring j,

    c_j = a_j l̇ − Σ_{i<j} ḣ_i,

does not depend on where the cord is fastened; an endless cord with friction does not slide at its first ring. At a ring
with the turn φ, N_j/N_{j−1} = e^{±μφ} while the cord slides, and the node feels the pull of both segments.

So two masses at the ends of a cord over one fixed pulley move with a = g (m₁ − m₂ e^{μπ})/(m₁ + m₂ e^{μπ}).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import ClassVar

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import InputError
from netdae.forces.rings import Rings
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.model.tether import PULLEY_DRUMS
from netdae.system.closing_assembly import rings_through
from netdae.system.reels import Reel

CABLES = "pulleys"
"""Group of all cables of such cords; those of the first alone are in the group pulleys_1."""


@dataclass(frozen=True)
class PulleyCord:
    """One cord of constant length through rings at several nodes.

    material : of the cord; None with `cables`, which have theirs
    nodes : numbers of the nodes with rings, in the order of the cord; or
    group : node group through whose nodes it runs; or
    cables : group of the net's own cables that are this cord, one chain or loop: they slide, and no cable is added
    loop : group of the closed loop of cables that orders the nodes of `group`; by default `group` itself
    closed : True where the cord of `nodes` or `group` is endless and comes back to its first ring
    length : L̄, m; None for its path length in x̄; that of its cables with `cables`
    rings : size and friction

    Raises InputError for values that do not go together.
    """

    material: Material | None = None
    group: str | None = None
    nodes: tuple[int, ...] | None = None
    cables: str | None = None
    loop: str | None = None
    closed: bool = False
    length: float | None = None
    rings: Rings = field(default_factory=Rings)
    what: ClassVar[str] = "pulleys"

    def __post_init__(self) -> None:
        if self.length is not None and not (math.isfinite(self.length) and self.length > 0):
            raise InputError(f"pulleys: length is {self.length:g} m: give a finite number above zero")
        if sum(each is not None for each in (self.group, self.nodes, self.cables)) != 1:
            raise InputError(
                "pulleys: give just one of a group, a list of nodes and a group of cables for the rings of a cord"
            )
        if self.loop is not None and self.group is None:
            raise InputError("pulleys: the rings have an order of their own: leave the loop out")
        if self.cables is not None and (self.closed or self.material is not None or self.length is not None):
            raise InputError(
                "pulleys: the cables of the net have a material, a length and ends: leave them out here"
            )
        if self.cables is None and self.material is None:
            raise InputError("pulleys: the cord has no material: give one")


@dataclass(frozen=True, eq=False)
class Strung:
    """A net with its pulley cords, and what a System takes besides it.

    net, start : with one node for each cord after the net's own, in the node group "pulley_drums": a drum that never
        turns. Cable group "pulleys", and "pulleys_1", "pulleys_2", ... for each cord
    reels, restraints : of the System; materials : cable group to Material, to be added to the net's own
    """

    net: CableNet
    start: State
    reels: tuple[Reel, ...]
    restraints: tuple[Restraint, ...]
    materials: dict[str, Material]


def with_pulleys(net: CableNet, start: State, cords: Sequence[PulleyCord]) -> Strung:
    """The net with its pulley cords, and their joint initial state.

    Raises InputError where a cord cannot be drawn through its rings, or the net has groups of these names.
    """
    if not cords:
        return Strung(net, start, (), (), {})
    names = [f"{CABLES}_{k}" for k in range(1, len(cords) + 1)]
    for kind, groups, taken in (
        ("cable", net.cable_groups, (CABLES, *names)),
        ("node", net.node_groups, (PULLEY_DRUMS,)),
    ):
        for name in taken:
            if name in groups:
                raise InputError(
                    f"pulleys: the net has a {kind} group {name!r} already: give that group another name"
                )
    n, m = net.node_count, net.cable_count
    ends, numbers = np.array(net.cables), []
    pieces: list[IntArray] = []
    lengths: list[FloatArray] = []
    for cord in cords:
        cables, L = _pieces_of(net, cord)
        if cord.cables is None:
            first = m + sum(len(each) for each in pieces)
            numbers.append(np.arange(first, first + len(cables)))
            pieces.append(cables)
            lengths.append(L)
        else:
            numbers.append(own := _numbers_of(net, cables))
            ends[own] = cables  # in the direction of the cord
    drums, added = np.arange(n, n + len(cords)), np.zeros((len(cords), 3))
    count = sum(len(each) for each in pieces)
    grown = CableNet(
        np.concatenate((net.nodes, added)),
        np.concatenate((ends, *pieces)),
        {**net.node_groups, PULLEY_DRUMS: drums},
        {**net.cable_groups, CABLES: np.concatenate(numbers), **dict(zip(names, numbers, strict=True))},
        np.concatenate((net.rest_length, *lengths)),
        {name: np.concatenate((data, np.full(count, np.nan))) for name, data in net.cable_data.items()},
    )
    x, v = np.concatenate((start.x, added)), np.concatenate((start.v, added))
    return Strung(
        grown,
        replace(start, x=x, v=v, a=np.zeros_like(x)),
        tuple(
            Reel(
                int(drum),
                own,
                share=-1.0,
                rings=replace(cord.rings, fastened=True),
                laid=cord.cables is not None,
            )
            for drum, own, cord in zip(drums, numbers, cords, strict=True)
        ),
        tuple(Restraint((int(drum),), axes="x") for drum in drums),
        {name: cord.material for name, cord in zip(names, cords, strict=True) if cord.material is not None},
    )


def check_pulleys(net: CableNet, cord: PulleyCord) -> None:
    """Raise InputError where a cord cannot be drawn through its rings."""
    _pieces_of(net, cord)


def _pieces_of(net: CableNet, cord: PulleyCord) -> tuple[IntArray, FloatArray]:
    """Cables (c, 2) from ring to ring and their rest lengths (c,), m."""
    if cord.cables is not None:
        cables = _chain_of(net, cord.cables)
        return cables, net.rest_length[_numbers_of(net, cables)]
    nodes = rings_through(net, cord)
    if cord.closed and len(nodes) < 3:
        raise InputError(
            "pulleys: an endless cord runs through 2 nodes: give three or more rings, or closed = false"
        )
    cables = np.stack((nodes, np.roll(nodes, -1)), axis=1)[: len(nodes) if cord.closed else -1]
    d = net.nodes[cables[:, 1]] - net.nodes[cables[:, 0]]
    h = np.hypot(np.linalg.norm(d, axis=1), cord.rings.size)
    least, length = len(cables) * cord.rings.size, float(cord.length or h.sum())
    if length <= least:
        raise InputError(
            f"pulleys: the cord is {length:g} m long, but {len(cables)} rings of {cord.rings.size:g} m side by side "
            f"take {least:g} m of it: give more, or smaller rings"
        )
    return cables, h * length / h.sum()


def _chain_of(net: CableNet, group: str) -> IntArray:
    """The cables (c, 2) of a group, one after the other from the end with the smaller node, or around the loop."""
    cables = net.cables[net.cables_of(group)]
    neighbours: dict[int, list[int]] = {}
    for i, j in cables.tolist():
        neighbours.setdefault(i, []).append(j)
        neighbours.setdefault(j, []).append(i)
    forked = next((node for node, others in neighbours.items() if len(others) > 2), None)
    if forked is not None:
        raise InputError(
            f"pulleys: {len(neighbours[forked])} cables of {group!r} meet at node {forked}: one cord is a "
            "chain of cables"
        )
    open_ends = sorted(node for node, others in neighbours.items() if len(others) == 1)
    here = open_ends[0] if open_ends else min(neighbours)
    way, before = [here], -1
    while True:
        onward = [node for node in sorted(neighbours[here]) if node != before]
        if not onward:
            break
        before, here = here, onward[0]
        way.append(here)
        if here == way[0]:
            break
    if len(way) - 1 < len(cables):
        outside = next(node for node in neighbours if node not in way)
        raise InputError(
            f"pulleys: the cables of {group!r} are several cords: node {outside} is not on the one through node "
            f"{way[0]}: make a group of each"
        )
    if len(way) < 3:
        raise InputError(
            f"pulleys: the cord {group!r} is one cable: it slides through nothing; give two cables or more"
        )
    return np.array(list(pairwise(way)), dtype=np.int64)


def _numbers_of(net: CableNet, cables: IntArray) -> IntArray:
    """Numbers of the net's cables between the nodes of each of `cables` (c, 2)."""
    places = {frozenset(pair): number for number, pair in enumerate(net.cables.tolist())}
    return np.array([places[frozenset(pair)] for pair in cables.tolist()], dtype=np.int64)
