"""Restraints: nodes whose axes are fixed or driven for the whole flight or a part of it, and what they prescribe.

Symbols: c restrained axes of all nodes, mask (n, 3); x_d, v_d, a_d what they prescribe.
A restraint that begins during the flight holds its axes where they are at that time; the jump of their velocities to
those of the motion, or to the release velocity when it ends, is an external impulse.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.core.errors import InputError
from netdae.model.motions import Fixed, Motion, TableMotion, check_derivatives
from netdae.model.net import CableNet


@dataclass(frozen=True, eq=False)
class Restraint:
    """Axes of a node group that are held at their starting position or moved from it.

    group : node group, or the numbers of nodes
    axes : any of "x", "y", "z" together, for instance "xyz"
    motion : how they move from where they start; fixed by default
    begin, until : s, or the name of an event of the flight at which the restraint begins or ends
    release_velocity : (3,), m/s, that its axes take when it ends; None leaves their velocities unchanged
    """

    group: str | tuple[int, ...]
    axes: str = "xyz"
    motion: Motion = Fixed()  # noqa: RUF009  # frozen
    begin: float | str = -math.inf
    until: float | str = math.inf
    release_velocity: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        if not self.axes or set(self.axes) - set("xyz") or len(set(self.axes)) != len(self.axes):
            raise InputError(f"{self.name}: axes is {self.axes!r}: give some of x, y, z, each once")
        for name in ("begin", "until"):
            if isinstance(value := getattr(self, name), float) and math.isnan(value):
                raise InputError(f"{self.name}: {name} is not a number: give a time in s, or an event's name")
        if (
            not isinstance(self.begin, str)
            and not isinstance(self.until, str)
            and not self.begin < self.until
        ):
            raise InputError(
                f"{self.name}: it begins at {self.begin:g} s and ends at {self.until:g} s: let it end later"
            )

    @property
    def name(self) -> str:
        """Its name in messages."""
        if isinstance(self.group, str):
            return f"restraint on {self.group!r}"
        return f"restraint on node{'s' * (len(self.group) > 1)} {', '.join(map(str, self.group))}"

    @property
    def axis_indices(self) -> IntArray:
        """0 for x, 1 for y, 2 for z."""
        return np.array(sorted("xyz".index(axis) for axis in self.axes))

    def nodes_of(self, net: CableNet) -> IntArray:
        """Its nodes, (k,); raises InputError for an unknown group or for nodes that are not in the net."""
        if isinstance(self.group, str):
            return net.nodes_of(self.group)
        nodes = np.array(self.group, dtype=np.int64)
        outside = nodes[(nodes < 0) | (nodes >= net.node_count)]
        if len(outside):
            raise InputError(
                f"restraint on node {outside[0]}: the net has {net.node_count} nodes: name one of them"
            )
        return nodes

    @property
    def permanent(self) -> bool:
        """Whether it holds during the whole flight, regardless of events."""
        return self.begin == -math.inf and self.until == math.inf

    @property
    def changes(self) -> tuple[float, ...]:
        """Times at which it begins and ends, as far as they are known before the flight."""
        return tuple(t for t in (self.begin, self.until) if not isinstance(t, str) and math.isfinite(t))

    @property
    def events(self) -> tuple[str, ...]:
        """Names of the events at which it begins or ends."""
        return tuple(t for t in (self.begin, self.until) if isinstance(t, str))

    def holds(self, t: float, fired: Mapping[str, float]) -> bool:
        """Whether it holds from t on, given the times of the events that have occurred."""
        begin, until = (
            fired.get(each, math.inf) if isinstance(each, str) else each for each in (self.begin, self.until)
        )
        return begin <= t < until


def mask_of(restraints: tuple[Restraint, ...], net: CableNet) -> BoolArray:
    """Which axes of which nodes are restrained, (n, 3); raises InputError where two overlap or one holds nothing."""
    mask = np.zeros((net.node_count, 3), dtype=np.bool_)
    for restraint in restraints:
        nodes = restraint.nodes_of(net)
        if len(nodes) == 0:
            raise InputError(f"{restraint.name}: the group has no nodes: name another one")
        place = np.ix_(nodes, restraint.axis_indices)
        if mask[place].any():
            node = nodes[int(np.argmax(mask[place].any(axis=1)))]
            raise InputError(
                f"{restraint.name}: node {node} is restrained in one of the axes "
                f"{restraint.axes} by an earlier restraint: let each axis of a node have one restraint"
            )
        mask[place] = True
    return mask


@dataclass(frozen=True, eq=False)
class Drive:
    """The active restraints of a net, bound to the positions of its nodes when each began.

    mask : (n, 3), True where restrained
    anchor : (n, 3), m, positions from which the motions count
    """

    restraints: tuple[Restraint, ...]
    mask: BoolArray
    anchor: FloatArray
    places: tuple[tuple[IntArray, ...], ...]

    @classmethod
    def of(cls, restraints: tuple[Restraint, ...], net: CableNet, anchor: FloatArray) -> Drive:
        """Restraints of `net` whose nodes start at `anchor` (n, 3)."""
        places = tuple(np.ix_(r.nodes_of(net), r.axis_indices) for r in restraints)
        return cls(restraints, mask_of(restraints, net), np.array(anchor), places)

    def followed_by(self, restraints: tuple[Restraint, ...], net: CableNet, t: float, x: FloatArray) -> Drive:
        """The restraints active from t on; the motions of those that begin start from the positions x (n, 3)."""
        new = Drive.of(restraints, net, x)
        for restraint, place in zip(new.restraints, new.places, strict=True):
            if restraint in self.restraints:
                new.anchor[place] = self.anchor[place]
            else:
                new.anchor[place] -= restraint.motion.at(t)[0][restraint.axis_indices]
        return new

    def at(self, t: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """x_d in m, v_d in m/s, a_d in m/s², each (n, 3), zero on free axes."""
        prescribed = np.zeros((3, *self.mask.shape))
        for restraint, place in zip(self.restraints, self.places, strict=True):
            u, du, ddu = restraint.motion.at(t)
            axes = restraint.axis_indices
            prescribed[0][place] = self.anchor[place] + u[axes]
            prescribed[1][place] = du[axes]
            prescribed[2][place] = ddu[axes]
        return prescribed[0], prescribed[1], prescribed[2]

    def check_start(self, t: float, v: FloatArray, end: float | None = None) -> None:
        """Raise InputError where the motion at the start contradicts the nodes' initial positions or velocities.

        end : s, end of the flight, up to which the derivatives are checked as well, see `motions.check_derivatives`
        """
        size, speed = float(np.abs(self.anchor).max()), float(np.abs(v).max())
        for restraint, place in zip(self.restraints, self.places, strict=True):
            u, du, ddu = restraint.motion.at(t)
            axes = restraint.axis_indices
            late_by = 8 * math.ulp(t)  # round-off of the clock in a motion that begins at t
            pace, gain = float(np.abs(du[axes]).max()), float(np.abs(ddu[axes]).max())
            name = restraint.name
            # round-off of a motion that is a difference of positions in the net
            if np.abs(u[axes]).max() > 1e-12 * size + late_by * pace:
                raise InputError(
                    f"{name}: its motion begins at {u.tolist()} m from the starting place: "
                    f"let the displacement be zero at t = {t:g} s"
                )
            difference = np.abs(v[place] - du[axes])
            # the last speed is what the acceleration gives over the size of the net
            allowed = 1e-9 * max(speed, pace, math.sqrt(size * gain)) + late_by * gain
            if difference.max() > allowed:
                node = place[0][int(np.argmax(difference.max(axis=1))), 0]
                raise InputError(
                    f"{name}: node {node} starts at {v[node].tolist()} m/s, but its motion begins at {du.tolist()} m/s "
                    f"along {restraint.axes}: start it at that velocity, or change the motion"
                )
            if end is not None and not isinstance(restraint.motion, Fixed | TableMotion):  # these are exact
                try:
                    check_derivatives(restraint.motion, axes, t, end)
                except InputError as error:
                    raise InputError(f"{name}: {error}") from error
