"""When a net first touches a target or an obstacle, if it keeps its shape and flies on along a straight line.

The gap g between the net and a body changes at C (w + Ω r) at most, with w the speed of the net against the body's
centre of mass, Ω the body's spin, r the distance of its farthest part from there and C the Lipschitz constant of φ. So
nothing touches within g/(C (w + Ω r)), after which the gap is looked at anew, until it is `TOUCHES` or time is over.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from netdae.core.arrays import FloatArray
from netdae.model.shapes.part import axes_of, parts_of
from netdae.model.state import State
from netdae.system.meeting import Meeting
from netdae.system.overlap import Nearest, Placed, nearest, placed
from netdae.system.system import System

TOUCHES = 1e-6  # m
_LOOKS = 1000


class Approach(NamedTuple):
    """The first contact at `time` in s, or none up to there, and the nearest point then."""

    touches: bool
    time: float
    nearest: Nearest


def approach_of(system: System, start: State, velocity: FloatArray, end: float) -> Approach:
    """How a net that starts at `start` and flies at `velocity` (3,), m/s, meets the bodies of a system until `end`, s.

    A free target spins on about the axis of its start.
    """
    meeting, target = Meeting(system), None if system.body is None else system.body.target
    obstacles = [placed(each) for each in system.obstacles]
    own = None if target is None else parts_of(target.parts)
    spin = np.zeros(3) if target is None else axes_of(target.attitude) @ target.spin
    moves = np.zeros(3) if target is None else np.asarray(target.velocity)
    steepest = max(
        float(each.lipschitz.max()) for each in [*(p.parts for p in obstacles), own] if each is not None
    )
    reach = 0.0 if system.body is None else system.body.radius
    turning = float(np.linalg.norm(spin)) * (reach if np.isfinite(reach) else 0.0)
    pace = steepest * max(float(np.linalg.norm(velocity)), float(np.linalg.norm(velocity - moves)) + turning)
    t, least = start.t, None
    for _ in range(_LOOKS):
        after = t - start.t
        bodies = list(obstacles)
        if target is not None and own is not None:
            turn = Rotation.from_rotvec(after * spin).as_matrix()
            axes = turn @ axes_of(target.attitude)
            offset = target.position - target.centre
            bodies.append(Placed(own, target.centre + after * moves + turn @ offset, axes))
        x = np.where(meeting.shown[:, None], start.x + after * velocity, start.x)
        found = min((nearest(body, x, meeting.knots) for body in bodies), key=lambda each: each.distance)
        if found.distance <= TOUCHES:
            return Approach(True, t, found)
        if least is None or found.distance < least.nearest.distance:
            least = Approach(False, t, found)
        if t >= end or pace == 0.0:
            break
        t = min(end, t + max(found.distance, TOUCHES) / pace)
    assert least is not None
    return least
