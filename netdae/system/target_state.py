"""Where a target is, and how it moves, in a State of the flight."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.model.shapes.part import axes_of
from netdae.model.state import State

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
