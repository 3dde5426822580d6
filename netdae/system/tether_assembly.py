"""A net tied to its chaser: the tether's knots and cables are additional ones of the same net.

A chain of cables runs from a node of the net, or from the junction of a bridle with a leg from each of several
nodes, to the node of the chaser. It starts laid out straight and nowhere taut, with the chaser's velocity.

Pay-out lengthens the last cable, at the chaser, by s, see `reels`. The cord's mass does not move with it: what is paid
out, ρ̄Ā s, stays with the chaser, and the last cable hangs straight between its ends whatever its length. Both the
chaser's mass and that of the net with its tether are wrong by this amount: `Tether.mass_left` reports it, 0.13 kg for
30 m of a 2 mm cord of 1390 kg/m³. Where this matters next to the net's mass, start with more of the tether laid out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial import cKDTree

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import InputError
from netdae.model.material import Material
from netdae.model.motions import Motion, TableMotion
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.model.tether import CABLE_GROUPS, NODE_GROUPS, Tether
from netdae.system.reels import LEAST, Reel


@dataclass(frozen=True, eq=False)
class Tethered:
    """A net with its tether, and what a System takes besides it.

    net, start : with the tether's knots, the chaser and, if there is a reel, its node after the net's own.
        Node groups "tether" (knots), "chaser", "reel"; cable groups "tether" (in order) and "bridle"
    length : m, rest length of the chain at the start
    reels : of the System; restraints : those of chaser and reel; masses : group to kg; materials : cable
        group to Material, each to be added to the net's own
    """

    net: CableNet
    start: State
    length: float
    reels: tuple[Reel, ...]
    restraints: tuple[Restraint, ...]
    masses: dict[str, float]
    materials: dict[str, Material]

    @classmethod
    def without(cls, net: CableNet, start: State) -> Tethered:
        """A net without a tether."""
        return cls(net, start, 0.0, (), (), {}, {})


@dataclass
class _Growth:
    """Knots and cables that are added to a net of n nodes and m cables."""

    n: int
    m: int
    reference: list[FloatArray] = field(default_factory=list)
    places: list[FloatArray] = field(default_factory=list)
    cables: list[tuple[int, int]] = field(default_factory=list)
    rest_length: list[float] = field(default_factory=list)

    def knot(self, reference: FloatArray, place: FloatArray) -> int:
        """Add a node at x̄ and x, (3,); returns its number."""
        self.reference.append(reference)
        self.places.append(place)
        return self.n + len(self.places) - 1

    def chain(self, first: int, last: int, ends: FloatArray, length: float, count: int) -> None:
        """Add `count` cables of the total rest length `length`, in a straight line between two nodes.

        ends : (2, 2, 3), x̄ and x of both
        """
        here = first
        for k in range(1, count + 1):
            share = k / count
            there = last if k == count else self.knot(*((1 - share) * ends[:, 0] + share * ends[:, 1]))
            self.cables.append((here, there))
            self.rest_length.append(length / count)
            here = there


def with_tether(net: CableNet, start: State, tether: Tether) -> Tethered:
    """The net tied to its chaser by a tether, and their joint initial state.

    Raises InputError where there is nothing to tie to, where the tether is too short for its path, or where a
    knot of it would lie on another node.
    """
    tied = _tied_nodes(net, tether)
    chaser_at = np.asarray(tether.chaser.position, dtype=np.float64)
    growth = _Growth(net.node_count, net.cable_count)
    chaser = growth.knot(chaser_at, chaser_at)
    if len(tied) == 1:
        root, root_at = int(tied[0]), start.x[tied[0]]
        way = float(np.linalg.norm(chaser_at - root_at))
        length = _length_of(tether, way)
        reference = net.nodes[root]
    else:
        root_at, length = _junction(tether, start.x[tied], chaser_at)
        reference, root = root_at, growth.knot(root_at, root_at)
        way = float(np.linalg.norm(chaser_at - root_at))
    if way == 0:
        raise InputError("tether: the chaser stands where the tether begins: move it away")
    if length < way * (1 - 1e-12):
        raise InputError(
            f"tether: it is {length:g} m long, but the chaser stands {way:g} m away: give a greater length, "
            "or move the chaser nearer"
        )
    if tether.bridle is not None:
        pieces = max(1, round(tether.bridle / (length / tether.elements)))
        for node in tied.tolist():
            ends = np.array([[net.nodes[node], root_at], [start.x[node], root_at]])
            growth.chain(node, root, ends, tether.bridle, pieces)
    legs = len(growth.cables)
    ends = np.array([[reference, chaser_at], [root_at, chaser_at]])
    growth.chain(root, chaser, ends, length, tether.elements)
    _check_apart(start.x, np.array(growth.places), length / tether.elements)
    return _grown(net, start, tether, growth, chaser, legs, length)


def _tied_nodes(net: CableNet, tether: Tether) -> IntArray:
    tied = net.nodes_of(tether.group)
    if len(tied) == 0:
        raise InputError(
            f"tether: the node group {tether.group!r} is empty: name the node, or the nodes, that the tether is tied to"
        )
    if (len(tied) > 1) != (tether.bridle is not None):
        if len(tied) == 1:
            raise InputError(
                f"tether: the group {tether.group!r} has one node, which needs no bridle: leave it out"
            )
        raise InputError(
            f"tether: the group {tether.group!r} has {len(tied)} nodes: give bridle, the length of the leg to each in m"
        )
    for kind, names, groups in (
        ("node", NODE_GROUPS, net.node_groups),
        ("cable", CABLE_GROUPS, net.cable_groups),
    ):
        for name in names:
            if name in groups:
                raise InputError(
                    f"tether: the net has a {kind} group {name!r} already: give that group another name"
                )
    return tied


def _length_of(tether: Tether, way: float) -> float:
    if tether.length is not None:
        return tether.length
    assert tether.slack is not None
    return way * (1 + tether.slack)


def _junction(tether: Tether, x: FloatArray, chaser: FloatArray) -> tuple[FloatArray, float]:
    """Place (3,) where the legs from x (k, 3) meet, on the line from their middle to the chaser, and the length.

    With `length` the junction shares the line in proportion to legs and tether, as far as no leg goes taut; with
    `slack` the longest leg has this slack too.
    """
    bridle = tether.bridle
    assert bridle is not None
    middle = x.mean(axis=0)
    line = chaser - middle
    way = float(np.linalg.norm(line))
    if way == 0:
        raise InputError("tether: the chaser stands in the middle of the bridle's nodes: move it away")
    axis = line / way
    along = (x - middle) @ axis
    aside = np.linalg.norm(x - middle - np.outer(along, axis), axis=1)
    leg = bridle / (1 + (tether.slack or 0.0))
    reach = np.sqrt(np.maximum(leg**2 - aside**2, 0.0))
    nearest, farthest = float(np.max(along - reach)), float(np.min(along + reach))
    if aside.max() > leg or nearest > farthest or farthest <= 0:
        worst = int(np.argmax(aside))
        raise InputError(
            f"tether: bridle is {bridle:g} m, too short for its legs to meet: a node of {tether.group!r} lies "
            f"{aside[worst]:g} m off the line to the chaser: give longer legs"
        )
    if tether.length is None:
        h = min(farthest, way)
    else:
        h = float(np.clip(way * bridle / (bridle + tether.length), nearest, farthest))
    return middle + h * axis, _length_of(tether, way - h)


def _check_apart(x: FloatArray, places: FloatArray, piece: float) -> None:
    """Raise InputError where a knot of the tether, places (k, 3), lies on another node."""
    everything = np.concatenate((x, places))
    distance, other = cKDTree(everything).query(places, k=2)
    # the knot itself is one of the two
    k = int(np.argmin(distance[:, 1]))
    if distance[k, 1] <= 1e-6 * piece:
        own = len(x) + k
        node = next(int(i) for i in other[k] if i != own)
        raise InputError(
            f"tether: a knot of it at {places[k].tolist()} m lies on node {node}: move the chaser a little"
        )


def _grown(
    net: CableNet, start: State, tether: Tether, growth: _Growth, chaser: int, legs: int, length: float
) -> Tethered:
    n, m, motion = net.node_count, net.cable_count, tether.chaser.motion
    velocity = tether.chaser.velocity if motion is None else motion.at(start.t)[1]
    knots = np.arange(n, n + len(growth.places))
    added_v = np.broadcast_to(np.asarray(velocity, dtype=np.float64), (len(knots), 3))
    added = np.arange(m, m + len(growth.cables))
    node_groups = {"tether": knots[knots != chaser], "chaser": [chaser]}
    x, v = np.concatenate((start.x, growth.places)), np.concatenate((start.v, added_v))
    nodes = np.concatenate((net.nodes, growth.reference))
    reels: tuple[Reel, ...] = ()
    if tether.payout != "locked":
        drum = len(x)
        reels = (_reel_of(tether, drum, int(added[-1]), length),)
        node_groups["reel"] = [drum]
        rate = np.zeros((1, 3))
        if not isinstance(tether.payout, str):
            rate[0, 0] = tether.payout.at(start.t)[1][0]
        x, v = np.concatenate((x, np.zeros((1, 3)))), np.concatenate((v, rate))
        nodes = np.concatenate((nodes, np.zeros((1, 3))))
    cable_groups = {"tether": added[legs:], **({"bridle": added[:legs]} if legs else {})}
    grown = CableNet(
        nodes,
        np.concatenate((net.cables, np.array(growth.cables))),
        {**net.node_groups, **node_groups},
        {**net.cable_groups, **cable_groups},
        np.concatenate((net.rest_length, growth.rest_length)),
        {name: np.concatenate((data, np.full(len(added), np.nan))) for name, data in net.cable_data.items()},
    )
    chaser_mass = {"chaser": tether.chaser.mass} if tether.chaser.mass > 0 else {}
    return Tethered(
        grown,
        replace(start, x=x, v=v, a=np.zeros_like(x)),
        length,
        reels,
        _restraints_of(tether),
        chaser_mass,
        dict.fromkeys(cable_groups, tether.material),
    )


def _reel_of(tether: Tether, node: int, cable: int, length: float) -> Reel:
    longest = math.inf
    if tether.longest is not None:
        if tether.longest < length:
            raise InputError(
                f"tether: longest is {tether.longest:g} m, less than its length at the start, {length:g} m: give more"
            )
        longest = tether.longest - length
    if not isinstance(tether.payout, str):
        _check_driven(tether.payout, length / tether.elements)
    return Reel(
        node,
        np.array([cable]),
        inertia=tether.drum_inertia,
        brake_force=tether.brake_force,
        ratchet=tether.ratchet,
        longest=longest,
    )


def _check_driven(payout: Motion, piece: float) -> None:
    """Raise InputError where a table winds in more than the last cable, of the initial length `piece`."""
    if not isinstance(payout, TableMotion):
        return  # a flight reports it where a rest length comes to zero
    times = np.union1d(payout.times, np.linspace(payout.times[0], payout.times[-1], 1001))
    least, t = min((float(payout.at(t)[0][0]), t) for t in times.tolist())
    if least < -(1 - LEAST) * piece:
        raise InputError(
            f"tether: the reel is driven to {least:g} m at t = {t:g} s, and the last cable has {piece:g} m: "
            f"wind in {1 - LEAST:.0%} of it at most, or take fewer elements"
        )


def _restraints_of(tether: Tether) -> tuple[Restraint, ...]:
    restraints = []
    if tether.chaser.motion is not None:
        restraints.append(Restraint("chaser", motion=tether.chaser.motion))
    until = math.inf if tether.lock is None else tether.lock
    if tether.begin is not None:
        restraints.append(Restraint("reel", axes="x", until=tether.begin))
    if not isinstance(tether.payout, str):
        restraints.append(Restraint("reel", axes="x", motion=tether.payout, until=until))
    if tether.lock is not None:
        restraints.append(Restraint("reel", axes="x", begin=tether.lock))
    return tuple(restraints)
