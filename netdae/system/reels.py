"""Reels: drums that pay out or wind in cables, each a generalised node of the net.

Symbols: s length paid out in m, J drum's moment of inertia, R its radius; L̄(s) = L̄₀ + σ s, see `forces.reel`.
The node's x-coordinate is s, its mass J/R² in kg; y and z are held. No cable ends at it. Driving its x axis by a
table reels at a given rate, and the work of the reaction is the motor's; fixing the axis locks the reel.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from netdae.core.arrays import BoolArray, FloatArray, IntArray, frozen_ints
from netdae.core.errors import InputError
from netdae.forces.brake import BRAKE, END_STOP, Brake, EndStop
from netdae.forces.drawcord import drawcord
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.forces.reel import REELED, Reeled
from netdae.forces.rings import Cord, Rings
from netdae.model.material import Cords
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint

CREEP = 1e-3
"""Creep speed v₀ of a brake, m/s: at half of the brake force a drum creeps 0.6 mm/s, 3.5 cm in a minute. Slower
would be finer than the 3e-4 m/s error of velocities at the standard accuracy, and stiffer for no gain."""

LEAST = 0.1
"""Share of its length L̄₀ down to which a reel may wind in a cable; a stop there keeps rest lengths above zero."""

LEAST_OF_CORD = 0.01
"""The same for a whole cord through rings, which no single cable limits."""


@dataclass(frozen=True, eq=False)
class Reel:
    """A drum with the cables that it reels.

    node : the reel's node
    cables : (c,), indices of the cables whose rest length is L̄₀ + `share` · s
    inertia : J/R², kg
    share : σ, 1 for a cable that s lengthens, −1 for one that it shortens
    brake_force : N, dry friction at the drum's rim; viscosity : N s/m, in proportion to ṡ
    ratchet : True where it does not wind back by itself; needs a brake force
    creep_speed : v₀, m/s, see `forces.brake`
    shortest, longest : m, stops of s; the drum is fully wound at one and empty at the other
    rings : given where the cables, in their order, are one cord that slides through the nodes between them
    laid : True where rest lengths are those of straight pieces, and the cord is longer by what its rings take in x̄

    Raises InputError for values out of range.
    """

    node: int
    cables: IntArray
    inertia: float = 0.0
    share: float = 1.0
    brake_force: float = 0.0
    viscosity: float = 0.0
    ratchet: bool = False
    creep_speed: float = CREEP
    shortest: float = -math.inf
    longest: float = math.inf
    rings: Rings | None = None
    laid: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "cables", frozen_ints(np.atleast_1d(self.cables)))
        if not len(self.cables):
            raise InputError("reel: it has no cables: give one at least")
        for name in ("inertia", "brake_force", "viscosity"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise InputError(f"reel: {name} is {value:g}: give a finite number, zero or more")
        if not (math.isfinite(self.creep_speed) and self.creep_speed > 0):
            raise InputError(f"reel: creep_speed is {self.creep_speed:g}: give a finite number above zero")
        if not (math.isfinite(self.share) and self.share != 0):
            raise InputError(f"reel: share is {self.share:g}: give 1, -1, or another finite number but zero")
        if not self.shortest < self.longest:
            raise InputError(
                f"reel: it runs from {self.shortest:g} to {self.longest:g} m: let longest be above shortest"
            )
        if self.ratchet and self.brake_force == 0:
            raise InputError("reel: a ratchet without brake_force holds nothing: give a force above zero")


def check_reels(reels: Sequence[Reel], net: CableNet) -> None:
    """Raise InputError where reels and net do not match."""
    taken: set[int] = set()
    for reel in reels:
        if not 0 <= reel.node < net.node_count:
            raise InputError(f"reel: its node is {reel.node}, but the net has {net.node_count} nodes")
        ends = np.flatnonzero((net.cables == reel.node).any(axis=1))
        if len(ends):
            raise InputError(
                f"reel: cable {ends[0]} ends at its node {reel.node}: let the node stand alone, it is no place in space"
            )
        outside = reel.cables[(reel.cables < 0) | (reel.cables >= net.cable_count)]
        if len(outside):
            raise InputError(f"reel: it has the cable {outside[0]}, but the net has {net.cable_count} cables")
        twice = [e for e in reel.cables.tolist() if e in taken]
        if twice or len(np.unique(reel.cables)) < len(reel.cables):
            raise InputError(f"reel at node {reel.node}: a cable is on a reel twice: let each have one reel")
        taken.update(reel.cables.tolist())
        if reel.rings is not None:
            rings_of(reel, net)
    if len({reel.node for reel in reels}) < len(reels):
        raise InputError("reel: two reels share a node: give each its own")


def rings_of(reel: Reel, net: CableNet) -> tuple[IntArray, bool]:
    """Nodes in the order of a cord through rings, (k,), and whether it is closed; raises InputError for no cord."""
    ends = net.cables[reel.cables]
    broken = np.flatnonzero(ends[1:, 0] != ends[:-1, 1])
    if len(broken):
        raise InputError(
            f"reel at node {reel.node}: its cables {reel.cables[broken[0]]} and {reel.cables[broken[0] + 1]} are "
            "no cord through rings: let each begin where the one before ends"
        )
    closed = len(ends) > 1 and bool(ends[0, 0] == ends[-1, 1])
    nodes = ends[:, 0] if closed else np.append(ends[:, 0], ends[-1, 1])
    if len(np.unique(nodes)) < len(nodes):
        raise InputError(
            f"reel at node {reel.node}: its cord comes through a node twice: let it pass each once"
        )
    return nodes, closed


def nodes_of_reels(reels: Sequence[Reel], node_count: int) -> BoolArray:
    """True at the nodes that are reels, (n,): they have no place, momentum or weight."""
    mask = np.zeros(node_count, dtype=np.bool_)
    mask[[reel.node for reel in reels]] = True
    return mask


def reeled_cables(reels: Sequence[Reel], cable_count: int) -> BoolArray:
    """True at the cables that are on a reel, (m,): `forces.reel` pulls them, not `forces.cables`."""
    mask = np.zeros(cable_count, dtype=np.bool_)
    for reel in reels:
        mask[reel.cables] = True
    return mask


def rest_lengths(L: FloatArray, reels: Sequence[Reel], x: FloatArray) -> FloatArray:
    """Current rest lengths (m,), m, from those at s = 0, L (m,), and the positions of all nodes x (n, 3)."""
    now = L.copy()
    for reel in reels:
        if reel.rings is None:
            now[reel.cables] += reel.share * x[reel.node, 0]
    return now


def slid_lengths(L: FloatArray, reels: Sequence[Reel], net: CableNet, x: FloatArray) -> FloatArray:
    """Rest lengths (m,) like `rest_lengths`, but of drawcords the part between each two rings, m.

    The whole cord has one strain, that of its total length l = Σ √(d·d + η²): a piece of the length |d| has the
    rest length |d| L̄/l.
    """
    now = rest_lengths(L, reels, x)
    for reel in reels:
        if reel.rings is not None:
            ends = net.cables[reel.cables]
            d = np.linalg.norm(x[ends[:, 1]] - x[ends[:, 0]], axis=1)
            whole = length_of_cord(reel, net, L) + reel.share * x[reel.node, 0]
            # where two rings coincide there is none: a millionth of a ring keeps it above zero
            least = 1e-6 * reel.rings.size
            now[reel.cables] = np.maximum(d, least) * whole / np.hypot(d, reel.rings.size).sum()
    return now


def length_of_cord(reel: Reel, net: CableNet, L: FloatArray) -> float:
    """Rest length of a whole cord through rings, m, where s = 0, from those of all cables, L (m,).

    Where it is laid, each piece of the length d in x̄ is longer by the share h/d, h = √(d² + η²): then the cord has in
    x̄ the strain that its cables would have.
    """
    own, rings = L[reel.cables], reel.rings
    if not reel.laid or rings is None:
        return float(own.sum())
    d = np.linalg.norm(net.spans[reel.cables], axis=1)
    return float((own * np.divide(np.hypot(d, rings.size), d, out=np.ones_like(d), where=d > 0)).sum())


def restraints_of(reels: Sequence[Reel]) -> tuple[Restraint, ...]:
    """Restraints of the unused axes y and z of drums without inertia; no force moves those of the others."""
    return tuple(Restraint((reel.node,), axes="yz") for reel in reels if reel.inertia == 0)


def forces_of(reels: Sequence[Reel], net: CableNet, cords: Cords, tau: FloatArray) -> tuple[Force, ...]:
    """Forces of the reels on a net whose cables are made of `cords` and have the viscosity times tau (m,), s.

    A stop is as stiff as the reeled cables are at their shortest between s = 0 and it, Σ σ² EĀ/min(L̄₀, L̄(s_e)). No
    drum moves faster on it than on its cables, and it yields less than what it holds: where a reel winds in, a motor
    of the force F presses it by F/k = L̄ F/EĀ, the part F/EĀ of the length that is left. (As stiff as at s = 0 it
    would yield by F/EĀ of the whole length, much for a short remainder.) It is damped critically against the drum,
    c = 2 √(k J/R²): with the rate 1/θ = √(k/(J/R²)) a drum that lands at ṡ under F is

        δ(t) = F/k (1 − (1 + t/θ) e^(−t/θ)) + ṡ t e^(−t/θ)

    beyond it, never by more than F/k + ṡ θ/e; one that nothing pulls goes ṡ θ/e and, since the stop lets go where it
    would have to pull, comes back at ṡ/e².
    Raises InputError as `check_reels` does.
    """
    check_reels(reels, net)
    if not reels:
        return ()
    single = [reel for reel in reels if reel.rings is None]
    return (
        *([_reeled_of(single, net, cords, tau)] if single else []),
        *(_cord_of(reel, reel.rings, net, cords, tau) for reel in reels if reel.rings is not None),
        *_brakes_of(reels),
        *_stops_of(reels, net, cords),
    )


def _reeled_of(reels: Sequence[Reel], net: CableNet, cords: Cords, tau: FloatArray) -> ElementForce:
    cables = np.concatenate([reel.cables for reel in reels])
    drum = np.concatenate([np.full(len(reel.cables), reel.node) for reel in reels])
    share = np.concatenate([np.full(len(reel.cables), reel.share) for reel in reels])
    parameters = Reeled(
        net.rest_length[cables],
        share,
        cords.axial_stiffness[cables],
        cords.toe_strain[cables],
        cords.engineering[cables],
        tau[cables],
    )
    return ElementForce(REELED, np.column_stack((net.cables[cables], drum)), parameters)


def _cord_of(reel: Reel, rings: Rings, net: CableNet, cords: Cords, tau: FloatArray) -> ElementForce:
    """The cord has the material of its first cable; its τ is the mean of those of its cables."""
    nodes, closed = rings_of(reel, net)
    first = reel.cables[0]
    cord = Cord(
        length_of_cord(reel, net, net.rest_length),
        float(reel.share),
        float(cords.axial_stiffness[first]),
        float(cords.toe_strain[first]),
        bool(cords.engineering[first]),
        float(tau[reel.cables].mean()),
        rings.size,
        rings.friction,
        rings.creep_speed,
        1.0 if rings.fastened else 0.5,
    )
    return drawcord(np.append(nodes, reel.node)[None], cord, closed=closed)


def _brakes_of(reels: Sequence[Reel]) -> list[Force]:
    braked = [reel for reel in reels if reel.brake_force > 0 or reel.viscosity > 0]
    if not braked:
        return []
    numbers = np.array([(reel.brake_force, reel.creep_speed, reel.viscosity) for reel in braked]).T.copy()
    nodes = np.array([[reel.node] for reel in braked])
    ratchets = np.array([reel.ratchet for reel in braked])
    return [ElementForce(BRAKE, nodes, Brake(numbers[0], numbers[1], numbers[2], ratchets))]


def way_of(reel: Reel, L: FloatArray) -> tuple[float, float]:
    """Least and largest s of a reel whose cables have the lengths L (c,) where s = 0: its stops, m."""
    most = (1 - LEAST) * L.min() if reel.rings is None else (1 - LEAST_OF_CORD) * L.sum()
    wound_in = float(most) / abs(reel.share)
    if reel.share > 0:
        return max(reel.shortest, -wound_in), reel.longest
    return reel.shortest, min(reel.longest, wound_in)


def _stops_of(reels: Sequence[Reel], net: CableNet, cords: Cords) -> list[Force]:
    rows = []
    for reel in reels:
        L = net.rest_length[reel.cables]
        EA = cords.axial_stiffness[reel.cables]
        if reel.rings is not None:
            L, EA = L.sum(keepdims=True), EA[:1]
        for place, side in zip(way_of(reel, net.rest_length[reel.cables]), (-1.0, 1.0), strict=True):
            if math.isfinite(place):
                k = reel.share**2 * float(np.sum(EA / np.minimum(L, L + reel.share * place)))
                rows.append((reel.node, place, side, k, 2 * math.sqrt(k * reel.inertia)))
    table = np.array(rows).T.copy()
    return [ElementForce(END_STOP, table[0].astype(np.int64)[:, None], EndStop(*table[1:]))]
