"""Where a target is, and how it moves, in a State of the flight."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.model.shapes.part import axes_of, parts_of
from netdae.model.state import State
from netdae.system.overlap import Knots, Nearest, Placed, nearest

if TYPE_CHECKING:
    from netdae.system.system import System


class TargetState(NamedTuple):
    """A target at an instant.

    centre, velocity : (3,), m and m/s, of its centre of mass; origin : (3,), m, of the body's frame
    attitude : (4,), quaternion (w, x, y, z) of the body's frame
    spin : (3,), rad/s, about the axes of the body's frame
    """

    centre: FloatArray
    velocity: FloatArray
    origin: FloatArray
    attitude: FloatArray
    spin: FloatArray


class TargetColumns(NamedTuple):
    """A target in the columns of metrics.csv, SI units; nan where there is none.

    target_x, ... : of its centre of mass; target_spin_x, ... : rad/s, about the axes of its frame
    target_gap : least distance of knots and cables, with their thickness, from its surface, m, negative in contact
    """

    target_x: float
    target_y: float
    target_z: float
    target_velocity_x: float
    target_velocity_y: float
    target_velocity_z: float
    target_spin_x: float
    target_spin_y: float
    target_spin_z: float
    target_gap: float


NO_TARGET = TargetColumns(*[np.nan] * len(TargetColumns._fields))


class Meeting:
    """How near a net, with its tether and closing cords, comes to the target of a system that has one."""

    def __init__(self, system: System) -> None:
        body = system.body
        assert body is not None
        self.system = system
        self.parts = parts_of(body.target.parts)
        shown = system.in_space.copy()
        shown[body.place] = False
        self.knots = Knots.of(system.net, system.cords, shown)

    def nearest(self, state: State) -> Nearest:
        """The point of the net that is nearest to the target, or deepest in it."""
        target = target_at(self.system, state)
        body = Placed(self.parts, target.origin, axes_of(target.attitude))
        return nearest(body, state.x, self.knots)

    def columns(self, state: State) -> TargetColumns:
        """The target at a State, as metrics.csv has it."""
        target = target_at(self.system, state)
        gap = self.nearest(state).distance
        return TargetColumns(*map(float, (*target.centre, *target.velocity, *target.spin, gap)))


def target_at(system: System, state: State) -> TargetState:
    """The target of a system that has one."""
    body = system.body
    assert body is not None
    target, rigid = body.target, body.target.body
    centre, velocity = state.x[body.place], state.v[body.place]
    principal = state.attitude if len(state.attitude) else target.principal_attitude
    W = state.v[body.spin] / body.pose.values.rho
    spin = W if rigid is None else axes_of(rigid.axes) @ W
    return TargetState(
        np.array(centre),
        np.array(velocity),
        target.origin_of(centre, principal),
        target.frame_of(principal),
        np.asarray(spin),
    )
