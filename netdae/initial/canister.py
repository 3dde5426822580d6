"""What all stowed shapes share: the canister, the plane of the net, and the checks of a pack.

Symbols: x positions (n, 3), m; x̄ those of the open net; L̄ rest lengths (m,), l distances of the cables' ends.

A pack is a map of the open net's plane into the canister. Each shape has its map in its own module:
`initial.scaled.scaled`, `accordion.accordion`, `star.star`. None may bring the ends of a cable farther apart than
(1 − slack) L̄, so that what the cable has to spare hangs slack between them, and no two knots may share a place.
Contact of the net with itself is not modelled: what would pass through itself is reported by `initial.opening`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from netdae.core.arrays import BoolArray, FloatArray
from netdae.core.errors import InputError
from netdae.model.net import CableNet

SLACK = 0.01
"""Least slack of each cable of a folded pack, as a share of its rest length."""

FLAT = 1e-6
"""A net is flat if its nodes deviate from its plane by at most this share of its width."""

TOGETHER = 1e-9
"""Knots nearer to each other than this share of the open net's width share a place."""


@dataclass(frozen=True)
class Canister:
    """The room that a pack is folded into; its floor lies in the plane of the net, its mouth `depth` above.

    depth : m, along the normal of the net's plane
    diameter : m, of a round canister; or
    side : m, of a square one, its sides along the first two axes of the net's plane
    """

    depth: float
    diameter: float | None = None
    side: float | None = None

    def __post_init__(self) -> None:
        if (self.diameter is None) == (self.side is None):
            raise InputError(
                "canister: give a diameter for a round one or a side for a square one, one of the two"
            )
        for name in ("depth", "diameter", "side"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0):
                raise InputError(f"canister: {name} is {value:g} m: give a length above zero")

    @property
    def width(self) -> float:
        """Diameter or side, m."""
        return self.diameter if self.diameter is not None else self.side or 0.0

    @property
    def words(self) -> str:
        """Its size in words."""
        kind = "round" if self.diameter is not None else "square"
        return f"{kind} canister {self.width:.6g} m wide and {self.depth:.6g} m deep"

    def width_for(self, pack: FloatArray) -> float:
        """Smallest diameter or side, m, that holds points (n, 2) when they are centred in it."""
        middle = (pack.min(axis=0) + pack.max(axis=0)) / 2
        if self.diameter is None:
            return float(np.ptp(pack, axis=0).max())
        return 2 * float(np.linalg.norm(pack - middle, axis=1).max())


@dataclass(frozen=True, eq=False)
class Plane:
    """The plane of a flat net.

    origin : (3,), m
    axes : (3, 3), unit rows: two in the plane, the third its normal; those of the mesh where it lies in xy
    """

    origin: FloatArray
    axes: FloatArray

    @classmethod
    def of(cls, net: CableNet) -> Plane:
        """Plane through the middle of a net's width; raises InputError for a net that is not flat."""
        x = np.array(net.nodes)
        origin = (x.min(axis=0) + x.max(axis=0)) / 2
        normal = np.linalg.svd(x - x.mean(axis=0), full_matrices=True)[2][2]
        normal *= np.sign(normal[np.argmax(np.abs(normal))])
        if abs(normal[2]) > 1 - 1e-12:
            normal = np.array([0.0, 0.0, 1.0])
        off = (x - x.mean(axis=0)) @ normal
        worst = int(np.argmax(np.abs(off)))
        if abs(off[worst]) > FLAT * np.ptp(x, axis=0).max():
            raise InputError(
                f"node {worst} stands {abs(off[worst]):.3g} m off the plane of the net, "
                'but only a flat net can be folded: give a flat mesh, or shape = "scaled"'
            )
        first = np.eye(3)[int(np.argmin(np.abs(normal)))]
        if abs(normal[0]) < 0.9:  # the x axis where it is not the normal
            first = np.array([1.0, 0.0, 0.0])
        first = first - (first @ normal) * normal
        first /= np.linalg.norm(first)
        return cls(origin, np.stack([first, np.cross(normal, first), normal]))

    def flat(self, x: FloatArray) -> FloatArray:
        """Coordinates (n, 2) in the plane of positions (n, 3), m."""
        return (x - self.origin) @ self.axes[:2].T

    def solid(self, local: FloatArray) -> FloatArray:
        """Positions (n, 3) of local coordinates (n, 3), m."""
        return self.origin + local @ self.axes


def stretch_of(net: CableNet, x: FloatArray) -> FloatArray:
    """l/L̄ of each cable at positions x (n, 3), (m,)."""
    return np.linalg.norm(x[net.cables[:, 1]] - x[net.cables[:, 0]], axis=1) / net.rest_length


def fitting(net: CableNet) -> float:
    """Factor, at most 1, that draws x̄ together until no cable is longer than at rest."""
    return min(1.0, 1.0 / float(stretch_of(net, net.nodes).max()))


def taut_finding(net: CableNet, x: FloatArray, *, tight: BoolArray | None = None) -> str:
    """The worst of the taut cables at positions x (n, 3) in words; empty when all are slack or just straight.

    tight : (m,), True at cables with a prestress, which count as taut only where they are longer than in x̄
    """
    stretch = stretch_of(net, x)
    meant = 1.0 if tight is None else np.where(tight, stretch_of(net, net.nodes), 1.0)
    over = stretch > (1 + 1e-9) * meant  # round-off of a net that is as long as drawn
    taut, stretch = np.flatnonzero(over), np.where(over, stretch, 0.0)
    if not len(taut):
        return ""
    e = int(np.argmax(stretch))
    strain = (stretch[e] ** 2 - 1) / 2  # E11, Eq. (3)
    i, j = net.cables[e]
    return (
        f"{len(taut)} of {net.cable_count} cables are taut at the start, worst cable {e} between nodes {i} and {j}: "
        f"strain {strain:.3g} over its rest length {net.rest_length[e]:.6g} m"
    )


def together_finding(net: CableNet, x: FloatArray) -> str:
    """The first two knots that share a place at positions x (n, 3), but not in x̄, in words; empty without any."""
    near = TOGETHER * float(np.ptp(net.nodes, axis=0).max())
    pairs = cKDTree(x).query_pairs(near, output_type="ndarray")
    pairs = pairs[np.linalg.norm(net.nodes[pairs[:, 1]] - net.nodes[pairs[:, 0]], axis=1) > near]
    if not len(pairs):
        return ""
    i, j = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))[0]]
    return f"{len(np.unique(pairs))} knots share a place with another, first nodes {i} and {j}"


def check_pack(net: CableNet, x: FloatArray, *, shape: str, coincide: bool = False) -> None:
    """Raise InputError where a cable of a pack is taut, or two knots share a place that should not."""
    taut = taut_finding(net, x)
    if taut:
        raise InputError(f"{shape}: {taut}: give fewer folds or a smaller gap")
    together = "" if coincide else together_finding(net, x)
    if together:
        raise InputError(f"{shape}: {together}: give a larger gap or depth, or coincide = true")


def check_slack_share(slack: float) -> float:
    """`slack`, or InputError where it is not a share of a length."""
    if not 0 < slack < 0.5:
        raise InputError(f"slack is {slack:g}: give a share above 0 and below 0.5, for instance {SLACK:g}")
    return slack


def rounded_up(value: float) -> str:
    """Four digits, rounded up, so that a size of this value suffices."""
    digits = 3 - math.floor(math.log10(value))
    return f"{math.ceil(round(value * 10.0**digits, 6)) / 10.0**digits:.{max(digits, 0)}f}"
