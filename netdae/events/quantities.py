"""The figures that events watch, as functions of a State.

Symbols: x, v positions and velocities (n, 3), m and m/s; r, w those of the nodes of a loop, (k, 3).
The vector area of the mouth's loop is A = ½ Σ r_k × r_{k+1}, so that

    dA/dt = ½ Σ (w_k × r_{k+1} + r_k × w_{k+1}),      d|A|/dt = A·(dA/dt)/|A|.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numba import njit

from netdae.core.arrays import FloatArray, IntArray, frozen_ints
from netdae.core.errors import InputError
from netdae.events.event import Event, Need, QuantityName, check_needs
from netdae.events.scan import Scan
from netdae.model.mouth import corners_of, mouth_of, vector_area
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.system.measurements import Measurements
from netdae.system.meeting import Meeting
from netdae.system.overlap import Nearest
from netdae.system.system import System


class Scene:
    """A net with its mouth, corners and tether, and the start and direction of its centre of mass.

    Tether, chaser and reel do not count in the centre of mass.

    Raises InputError where an event needs something that the net does not have.
    """

    def __init__(
        self,
        system: System,
        events: Sequence[Event],
        *,
        mouth: str | None,
        corners: str | None,
    ) -> None:
        net = system.net
        needed = {need for event in events for need in event.needs}
        self.system = system
        self.loop = _found(_mouth_of, net, mouth, must="mouth" in needed or "corners" in needed)
        self.corners: IntArray | None = None
        if corners is not None and self.loop is not None and len(net.node_groups.get(corners, ())) >= 3:
            self.corners = corners_of(net, self.loop, corners) if "corners" in needed else None
        self.tether = net.cable_groups.get("tether", frozen_ints([]))
        self.chaser = net.node_groups.get("chaser", frozen_ints([]))
        self._measurements = Measurements.of(system)
        self._meeting = Meeting(system) if "contact" in needed else None
        self._nearest: tuple[State, Nearest] | None = None
        self.reference_area = 0.0 if self.loop is None else vector_area(net.nodes[self.loop])
        self.origin, self.direction = np.zeros(3), np.full(3, np.nan)
        self._state: State | None = None
        self._values: dict[str, float] = {}
        self._scans: dict[str, Scan | None] = {}
        has: dict[Need, bool] = {
            "mouth": self.loop is not None,
            "corners": self.corners is not None,
            "tether": len(self.tether) > 0,
            "chaser": len(self.chaser) > 0,
            "strength": bool(np.isfinite(system.strength).any()),
            "closing": "drums" in net.node_groups,
            "target": system.body is not None,
            "contact": self._meeting is not None and self._meeting.bodies,
        }
        for event in events:
            check_needs(event, [need for need, there in has.items() if there])

    def begin(self, start: State) -> None:
        """Measure distances from this state on, along its momentum; straight ones where it has none."""
        direction = self._measurements.direction_of(start.v)
        self.origin = self.centre(start)
        self.direction = np.full(3, np.nan) if direction is None else direction

    def centre(self, state: State) -> FloatArray:
        """Centre of mass of the net, (3,), m."""
        return self._measurements.centre_of(state.x)

    def value(self, figure: QuantityName, state: State) -> float:
        """A figure of `MEASURES`, in its unit; it is computed once for the same state."""
        if state is not self._state:
            self._state, self._values = state, {}
        if figure not in self._values:
            self._values[figure] = MEASURES[figure](self, state)
        return self._values[figure]

    def nearest(self, state: State) -> Nearest:
        """The point of the net that is nearest to a body; it is found once for the same state."""
        if self._nearest is None or self._nearest[0] is not state:
            assert self._meeting is not None
            self._nearest = state, self._meeting.nearest(state)
        return self._nearest[1]

    def target_place(self) -> int:
        """The node at the target's centre of mass."""
        assert self.system.body is not None
        return self.system.body.place

    def scan(self, figure: QuantityName) -> Scan | None:
        """Scan of a figure over many steps at once; None where there is none."""
        if figure not in self._scans:
            self._scans[figure] = Scan.of(self.system, figure, self.tether)
        return self._scans[figure]

    def centre_velocity(self, state: State) -> FloatArray:
        """Velocity of the net's centre of mass, (3,), m/s."""
        return self._measurements.centre_of(state.v)

    def area_and_rate(self, state: State) -> tuple[float, float]:
        """Area of the mouth, m², and its rate, m²/s."""
        assert self.loop is not None
        return _area_and_rate(state.x, state.v, self.loop)

    def corner_area_and_rate(self, state: State) -> tuple[float, float]:
        """Area of the loop through the corners, m², and its rate, m²/s."""
        assert self.corners is not None
        return _area_and_rate(state.x, state.v, self.corners)


def _mouth_area(scene: Scene, state: State) -> float:
    return math.nan if scene.loop is None else scene.area_and_rate(state)[0]


def _corner_area(scene: Scene, state: State) -> float:
    return scene.corner_area_and_rate(state)[0]


def _distance(scene: Scene, state: State) -> float:
    way = scene.centre(state) - scene.origin
    along = float(way @ scene.direction)
    return along if along == along else float(np.sqrt(way @ way))  # NaN has no direction


def _chaser_distance(scene: Scene, state: State) -> float:
    way = scene.centre(state) - state.x[scene.chaser].mean(axis=0)
    return float(np.sqrt(way @ way))


def _tether_strain(scene: Scene, state: State) -> float:
    return float(scene.system.strain(state.x)[scene.tether].max())


def _tether_tension(scene: Scene, state: State) -> float:
    return float(scene.system.tension(state.x)[scene.tether].max())


def _largest_strain(scene: Scene, state: State) -> float:
    return float(scene.system.strain(state.x).max())


def _load(scene: Scene, state: State) -> float:
    return float((scene.system.tension(state.x) / scene.system.strength).max())


def _target_distance(scene: Scene, state: State) -> float:
    way = scene.centre(state) - state.x[scene.target_place()]
    return float(np.sqrt(way @ way))


def _depth(scene: Scene, state: State) -> float:
    return -scene.nearest(state).distance


def _contacts(scene: Scene, state: State) -> float:
    """Less a half, so that the number passes a whole one where it becomes more."""
    return scene.nearest(state).inside - 0.5


MEASURES: Mapping[QuantityName, Callable[[Scene, State], float]] = {
    "largest_mouth_area": _mouth_area,
    "mouth_area": _mouth_area,
    "corner_area": _corner_area,
    "distance": _distance,
    "chaser_distance": _chaser_distance,
    "tether_taut": _tether_strain,
    "tether_tension": _tether_tension,
    "all_slack": _largest_strain,
    "tension_over_strength": _load,
    "target_distance": _target_distance,
    "first_contact": _depth,
    "contacts": _contacts,
}
"""Function of each figure."""


def _mouth_of(net: CableNet, mouth: str | None) -> IntArray | None:
    if mouth is None or (mouth == "border" and mouth not in {*net.node_groups, *net.cable_groups}):
        return None
    return mouth_of(net, mouth)


def _found(
    find: Callable[[CableNet, str | None], IntArray | None], net: CableNet, name: str | None, *, must: bool
) -> IntArray | None:
    """What is found in the net; None after an error unless an event needs it."""
    try:
        return find(net, name)
    except InputError:
        if must:
            raise
        return None


@njit(cache=True)
def _area_and_rate(x: FloatArray, v: FloatArray, loop: IntArray) -> tuple[float, float]:
    """|A| and d|A|/dt of the loop through nodes; positions are relative to its first node, which drops out."""
    Ax = Ay = Az = dAx = dAy = dAz = 0.0
    o = loop[0]
    for k in range(1, len(loop) - 1):
        i, j = loop[k], loop[k + 1]
        rx, ry, rz = x[i, 0] - x[o, 0], x[i, 1] - x[o, 1], x[i, 2] - x[o, 2]
        sx, sy, sz = x[j, 0] - x[o, 0], x[j, 1] - x[o, 1], x[j, 2] - x[o, 2]
        wx, wy, wz = v[i, 0] - v[o, 0], v[i, 1] - v[o, 1], v[i, 2] - v[o, 2]
        ux, uy, uz = v[j, 0] - v[o, 0], v[j, 1] - v[o, 1], v[j, 2] - v[o, 2]
        Ax += ry * sz - rz * sy
        Ay += rz * sx - rx * sz
        Az += rx * sy - ry * sx
        dAx += wy * sz - wz * sy + ry * uz - rz * uy
        dAy += wz * sx - wx * sz + rz * ux - rx * uz
        dAz += wx * sy - wy * sx + rx * uy - ry * ux
    size = math.sqrt(Ax * Ax + Ay * Ay + Az * Az)
    if size == 0.0:
        return 0.0, 0.0
    return 0.5 * size, 0.5 * (Ax * dAx + Ay * dAy + Az * dAz) / size
