"""Restraints: nodes whose axes are fixed or driven, and what they prescribe.

Symbols: c restrained axes of all nodes, mask (n, 3); x_d, v_d, a_d what they prescribe.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.errors import InputError
from netdae.motions import Fixed, Motion, TableMotion, check_derivatives
from netdae.net import CableNet


@dataclass(frozen=True)
class Restraint:
    """Axes of a node group that are held at their starting place or move from it.

    group : node group
    axes : any of "x", "y", "z" together, for instance "xyz"
    motion : how they move from where they start; fixed by default
    """

    group: str
    axes: str = "xyz"
    motion: Motion = Fixed()  # noqa: RUF009  # frozen

    def __post_init__(self) -> None:
        if not self.axes or set(self.axes) - set("xyz") or len(set(self.axes)) != len(self.axes):
            raise InputError(
                f"restraint on {self.group!r}: axes is {self.axes!r}: give some of x, y, z, each once"
            )

    @property
    def axis_indices(self) -> IntArray:
        """0 for x, 1 for y, 2 for z."""
        return np.array(sorted("xyz".index(axis) for axis in self.axes))


def mask_of(restraints: tuple[Restraint, ...], net: CableNet) -> BoolArray:
    """Which axes of which nodes are restrained, (n, 3); raises InputError where two meet or one holds nothing."""
    mask = np.zeros((net.node_count, 3), dtype=np.bool_)
    for restraint in restraints:
        if len(net.nodes_of(restraint.group)) == 0:
            raise InputError(f"restraint on {restraint.group!r}: the group has no nodes: name another one")
        place = np.ix_(net.nodes_of(restraint.group), restraint.axis_indices)
        if mask[place].any():
            node = net.nodes_of(restraint.group)[int(np.argmax(mask[place].any(axis=1)))]
            raise InputError(
                f"restraint on {restraint.group!r}: node {node} is restrained in one of the axes "
                f"{restraint.axes} by an earlier restraint: let each axis of a node have one restraint"
            )
        mask[place] = True
    return mask


@dataclass(frozen=True, eq=False)
class Drive:
    """All restraints of a net bound to where its nodes started.

    mask : (n, 3), True where restrained
    anchor : (n, 3), m, positions at the start
    """

    restraints: tuple[Restraint, ...]
    mask: BoolArray
    anchor: FloatArray
    places: tuple[tuple[IntArray, ...], ...]

    @classmethod
    def of(cls, restraints: tuple[Restraint, ...], net: CableNet, anchor: FloatArray) -> Drive:
        """Restraints of `net` whose nodes start at `anchor` (n, 3)."""
        places = tuple(np.ix_(net.nodes_of(r.group), r.axis_indices) for r in restraints)
        return cls(restraints, mask_of(restraints, net), np.array(anchor), places)

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
        """Raise InputError where the motion at the start contradicts where or how fast the nodes start.

        end : s, of the flight: up to there its derivatives are checked as well, see `motions.check_derivatives`
        """
        size, speed = float(np.abs(self.anchor).max()), float(np.abs(v).max())
        for restraint, place in zip(self.restraints, self.places, strict=True):
            u, du, ddu = restraint.motion.at(t)
            axes = restraint.axis_indices
            late_by = 8 * math.ulp(t)  # round-off of the clock in a motion that begins at t
            pace, gain = float(np.abs(du[axes]).max()), float(np.abs(ddu[axes]).max())
            name = f"restraint on {restraint.group!r}"
            # round-off of a motion that is a difference of places in the net
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
            if end is not None and not isinstance(restraint.motion, Fixed | TableMotion):  # those cannot err
                try:
                    check_derivatives(restraint.motion, axes, t, end)
                except InputError as error:
                    raise InputError(f"{name}: {error}") from error
