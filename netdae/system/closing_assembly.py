"""A net with its closings: cords and drums are additional cables and nodes of the same net."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import InputError
from netdae.forces.cables import law_of
from netdae.forces.force import Force
from netdae.model.material import Material
from netdae.model.mouth import mouth_of
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.system.closing import Closing, Drawcord, Haul, Winch, motors_of
from netdae.system.reels import LEAST, LEAST_OF_CORD, Reel

CABLES, DRUMS = "closing", "drums"
"""Groups of all cables that close the net, and of the nodes of their drums."""


class Strand(Protocol):
    """What `rings_through` asks of a cord, see `closing.Drawcord`; `what` begins its messages."""

    @property
    def what(self) -> str: ...  # noqa: D102
    @property
    def group(self) -> str | None: ...  # noqa: D102
    @property
    def nodes(self) -> tuple[int, ...] | None: ...  # noqa: D102
    @property
    def loop(self) -> str | None: ...  # noqa: D102


@dataclass(frozen=True, eq=False)
class Closed:
    """A net with its closings, and what a System takes besides it.

    net, start : with the drums' nodes after the net's own. Cable group "closing", and "closing_1", "closing_2", ...
        for each of the closings; node group "drums"
    reels, restraints, forces : of the System; numbers : for each restraint, from 0, the closing whose drum it holds;
        materials : cable group to Material, to be added to the net's own
    """

    net: CableNet
    start: State
    reels: tuple[Reel, ...]
    restraints: tuple[Restraint, ...]
    numbers: tuple[int, ...]
    forces: tuple[Force, ...]
    materials: dict[str, Material]


@dataclass(frozen=True, eq=False)
class _Cord:
    """Cables (c, 2) with their rest lengths L̄₀ (c,) that one drum winds in."""

    cables: IntArray
    L: FloatArray
    closing: Closing

    @property
    def haul(self) -> Haul:
        return self.closing.haul


def with_closings(net: CableNet, start: State, closings: Sequence[Closing]) -> Closed:
    """The net with winches and drawcords, and their joint initial state.

    Raises InputError as `check_closing` does, where the net has groups of these names, and where a cord is so short
    that it pulls harder at the start than its motor.
    """
    for kind, names, groups in (
        ("node", (DRUMS,), net.node_groups),
        ("cable", (CABLES, *(f"{CABLES}_{k + 1}" for k in range(len(closings)))), net.cable_groups),
    ):
        for name in names:
            if name in groups:
                raise InputError(
                    f"closing: the net has a {kind} group {name!r} already: give that group another name"
                )
    for closing in closings:
        _check_times(closing.haul, start.t)
    by_closing = [_cords_of(net, closing) for closing in closings]
    cords = [cord for each in by_closing for cord in each]
    for cord in cords:
        _check_start(cord, start.x)
    if not cords:
        return Closed(net, start, (), (), (), (), {})
    n, m = net.node_count, net.cable_count
    drums = np.arange(n, n + len(cords))
    counts = [len(cord.cables) for cord in cords]
    firsts = m + np.concatenate(([0], np.cumsum(counts)[:-1]))
    numbers = [np.arange(first, first + count) for first, count in zip(firsts, counts, strict=True)]
    groups, materials, k = {CABLES: np.concatenate(numbers)}, {}, 0
    for number, (closing, own) in enumerate(zip(closings, by_closing, strict=True), 1):
        groups[f"{CABLES}_{number}"] = np.concatenate(numbers[k : k + len(own)])
        materials[f"{CABLES}_{number}"] = closing.material
        k += len(own)
    added = np.zeros((len(cords), 3))
    grown = CableNet(
        np.concatenate((net.nodes, added)),
        np.concatenate((net.cables, *(cord.cables for cord in cords))),
        {**net.node_groups, DRUMS: drums},
        {**net.cable_groups, **groups},
        np.concatenate((net.rest_length, *(cord.L for cord in cords))),
        {name: np.concatenate((data, np.full(sum(counts), np.nan))) for name, data in net.cable_data.items()},
    )
    x, v = np.concatenate((start.x, added)), np.concatenate((start.v, added))
    reels = tuple(
        _reel_of(cord, int(drum), cables) for cord, drum, cables in zip(cords, drums, numbers, strict=True)
    )
    of_cords = [number for number, own in enumerate(by_closing) for _ in own]
    held = [
        (restraint, number)
        for cord, drum, number in zip(cords, drums, of_cords, strict=True)
        for restraint in _restraints_of(cord.haul, int(drum), start.t)
    ]
    return Closed(
        grown,
        replace(start, x=x, v=v, a=np.zeros_like(x)),
        reels,
        tuple(restraint for restraint, _ in held),
        tuple(number for _, number in held),
        (motors_of([cord.haul for cord in cords], drums.tolist()),),
        materials,
    )


def check_closing(net: CableNet, closing: Closing, begin: float) -> None:
    """Raise InputError where a closing does not fit a net, or begins before the flight does at `begin` in s."""
    _check_times(closing.haul, begin)
    _cords_of(net, closing)


def _cords_of(net: CableNet, closing: Closing) -> list[_Cord]:
    """The cords of a winch, one for each pair, or of a drawcord; raises InputError where there is none."""
    return _pairs_of(net, closing) if isinstance(closing, Winch) else [_drawn_through(net, closing)]


def _pairs_of(net: CableNet, winch: Winch) -> list[_Cord]:
    first, second = _ends_of(net, winch.first), _ends_of(net, winch.second)
    if len(first) != len(second) or not len(first):
        raise InputError(
            f"closing: {_named(winch.first)} has {len(first)} nodes and {_named(winch.second)} has {len(second)}: "
            "a winch joins them by pairs, so let both have as many, and one at least"
        )
    cords: list[_Cord] = []
    joined: set[frozenset[int]] = set()
    for i, j in zip(first.tolist(), second.tolist(), strict=True):
        if frozenset((i, j)) in joined:
            raise InputError(
                f"closing: nodes {i} and {j} are joined twice, by {_named(winch.first)} and {_named(winch.second)}: "
                "name each pair once"
            )
        joined.add(frozenset((i, j)))
        if i == j:
            raise InputError(
                f"closing: node {i} of {_named(winch.first)} is its own partner in {_named(winch.second)}: "
                "a winch needs two nodes"
            )
        length = winch.length or float(np.linalg.norm(net.nodes[j] - net.nodes[i]))
        _check_final(winch.haul, length, LEAST)
        cords.append(_Cord(np.array([[i, j]]), np.array([length]), winch))
    return cords


def _ends_of(net: CableNet, ends: str | tuple[int, ...]) -> IntArray:
    """Nodes at one end of a winch, in the order in which they are paired."""
    return net.nodes_of(ends) if isinstance(ends, str) else _listed(net, ends)


def _named(ends: str | tuple[int, ...]) -> str:
    return repr(ends) if isinstance(ends, str) else f"the list {list(ends)}"


def _listed(net: CableNet, numbers: tuple[int, ...], what: str = "closing") -> IntArray:
    """The nodes of these numbers; raises InputError where the net has no such node."""
    missing = [number for number in numbers if not 0 <= number < net.node_count]  # before they are 64 bits
    if missing:
        raise InputError(
            f"{what}: the cord runs through node {missing[0]}, but the net has {net.node_count} nodes"
        )
    return np.array(numbers, dtype=np.int64)


def rings_through(net: CableNet, cord: Strand) -> IntArray:
    """Nodes of the rings of a drawcord or pulley cord in its order, (k,); raises InputError where none fits."""
    if cord.nodes is None:
        assert cord.group is not None
        members = net.nodes_of(cord.group)
        if len(members) < 2:
            raise InputError(
                f"{cord.what}: the cord runs through {_counted(members)} of {cord.group!r}: give two or more rings"
            )
        loop = mouth_of(net, cord.loop or cord.group)
        outside = np.setdiff1d(members, loop)
        if len(outside):
            raise InputError(
                f"{cord.what}: node {outside[0]} of {cord.group!r} is not on the loop {cord.loop!r}: "
                "name the group of a loop that passes all rings, or list the nodes in their order"
            )
        return loop[np.isin(loop, members)]
    nodes = _listed(net, cord.nodes, cord.what)
    if len(nodes) < 2:
        raise InputError(f"{cord.what}: the cord runs through {_counted(nodes)}: give two or more rings")
    values, count = np.unique(nodes, return_counts=True)
    if (count > 1).any():
        raise InputError(
            f"{cord.what}: the cord runs through node {values[count > 1][0]} twice: let it pass each ring once"
        )
    return nodes


def _counted(nodes: IntArray) -> str:
    return "1 node" if len(nodes) == 1 else f"{len(nodes)} nodes"


def _drawn_through(net: CableNet, cord: Drawcord) -> _Cord:
    nodes = rings_through(net, cord)
    if cord.closed and len(nodes) < 3:
        raise InputError(
            "closing: a closed cord runs through 2 nodes: give three or more rings, or closed = false"
        )
    cables = np.stack((nodes, np.roll(nodes, -1)), axis=1)[: len(nodes) if cord.closed else -1]
    h = np.hypot(np.linalg.norm(net.nodes[cables[:, 1]] - net.nodes[cables[:, 0]], axis=1), cord.rings.size)
    length = float(cord.length or h.sum())
    _check_final(cord.haul, length, LEAST_OF_CORD)
    least = len(cables) * cord.rings.size
    if cord.haul.final_length <= least:
        raise InputError(
            f"closing: final_length is {cord.haul.final_length:g} m, but {len(cables)} rings of {cord.rings.size:g} m "
            f"side by side take {least:g} m of the cord: give more, or smaller rings"
        )
    return _Cord(cables, h * length / h.sum(), cord)


def _check_final(haul: Haul, length: float, least: float) -> None:
    if not haul.final_length < length:
        raise InputError(
            f"closing: final_length is {haul.final_length:g} m, but the cord is {length:g} m long before: give less"
        )
    if haul.final_length < least * length * (1 - 1e-12):
        raise InputError(
            f"closing: final_length is {haul.final_length:g} m, under {least:.0%} of the cord's {length:g} m: give more"
        )


def _check_start(cord: _Cord, x: FloatArray) -> None:
    """Raise InputError where a cord pulls harder at the start, x (n, 3), than its motor."""
    d = np.linalg.norm(x[cord.cables[:, 1]] - x[cord.cables[:, 0]], axis=1)
    size = cord.closing.rings.size if isinstance(cord.closing, Drawcord) else 0.0
    way, length, material = float(np.hypot(d, size).sum()), float(cord.L.sum()), cord.closing.material
    E11 = 0.5 * ((way / length) ** 2 - 1)
    g, _, _, _ = law_of(E11, material.toe_strain, material.law == "engineering")
    pull = material.youngs_modulus * material.cross_section * g * way / length
    if pull > cord.haul.force:
        i, j = cord.cables[0].tolist()
        which = f"from node {i} to {j}" if len(cord.cables) == 1 else f"through node {i}"
        raise InputError(
            f"closing: the cord {which} is {length:g} m long, but its way at the start is {way:g} m, on which it pulls "
            f"with {pull:.3g} N, more than its motor with {cord.haul.force:g} N: give it {way:g} m or more"
        )


def _check_times(haul: Haul, begin: float) -> None:
    for name in ("begin", "hold"):
        value = getattr(haul, name)
        if isinstance(value, float | int) and value < begin:
            raise InputError(
                f"closing: {name} is {value:g} s, before the start of the flight at {begin:g} s: give a later time"
            )


def _reel_of(cord: _Cord, drum: int, cables: IntArray) -> Reel:
    return Reel(
        drum,
        cables,
        inertia=cord.haul.inertia,
        share=-1.0,
        longest=float(cord.L.sum()) - cord.haul.final_length,
        rings=cord.closing.rings if isinstance(cord.closing, Drawcord) else None,
    )


def _restraints_of(haul: Haul, drum: int, start: float) -> list[Restraint]:
    restraints = []
    if isinstance(haul.begin, str) or (haul.begin is not None and haul.begin > start):
        restraints.append(Restraint((drum,), axes="x", until=haul.begin))
    if haul.hold is not None:
        restraints.append(Restraint((drum,), axes="x", begin=haul.hold))
    return restraints
