"""What a net and the bodies that it meets do to each other in a State: distances, forces, energy and powers.

Friction's share of the dissipated power is what the law dissipates less what it dissipates with μ = 0. The force with
μ = 0 is along the normals; what its parts at knots add up to is the normal force, since those of one knot hardly
differ in direction.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.forces.contact import MEETING, RESTING
from netdae.forces.elements import ElementForce
from netdae.model.shapes.part import axes_of, parts_of
from netdae.model.state import State
from netdae.system.net_forces import NetForces
from netdae.system.overlap import Knots, Nearest, Placed, gaps, nearest, placed
from netdae.system.target_state import target_at

if TYPE_CHECKING:
    from netdae.system.system import System


class Contacts(NamedTuple):
    """Contact at an instant.

    gap : m, least distance of knots and cables, with their thickness, from all bodies; negative in contact
    touching : how many knots and cables touch
    normal : N, sum of the normal forces
    stored : J; dissipated : W, of which friction : W
    """

    gap: float
    touching: int
    normal: float = 0.0
    stored: float = 0.0
    dissipated: float = 0.0
    friction: float = 0.0


class TargetColumns(NamedTuple):
    """A target in the columns of metrics.csv, SI units; nan where there is none.

    target_x, ... : of its centre of mass; target_spin_x, ... : rad/s, about the axes of its frame
    target_force_x, ... : N, of the net on it
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
    target_force_x: float
    target_force_y: float
    target_force_z: float


NO_TARGET = TargetColumns(*[np.nan] * len(TargetColumns._fields))


class Meeting:
    """A net, with its tether and closing cords, and the target and obstacles of a system.

    There is nothing to meet where `bodies` is False.
    """

    def __init__(self, system: System) -> None:
        self.system = system
        shown = system.in_space.copy()
        if system.body is not None:
            shown[system.body.place] = False
        self.shown = shown
        self.knots = Knots.of(system.net, system.cords, shown)
        self.bodies = system.body is not None or bool(system.obstacles)
        self._parts = None if system.body is None else parts_of(system.body.target.parts)
        self._fixed = [placed(each) for each in system.obstacles]
        laws = [
            each
            for each in system.forces
            if isinstance(each, ElementForce) and each.law in (MEETING, RESTING)
        ]
        self._forces = NetForces.of(laws, system.in_space)
        self._of_parts = [
            NetForces.of([_of_part(each, part)], system.in_space)
            for each in laws
            if each.law is MEETING
            for part in range(int(each.parameters.part.max()) + 1)
        ]
        smooth = [_smooth(each) for each in laws]
        self._smooth = NetForces.of(smooth, system.in_space)

    def nearest(self, state: State) -> Nearest:
        """The point of the net that is nearest to a body, or deepest in one; `inside` counts those of all bodies."""
        found = [nearest(body, state.x, self.knots) for body in self._placed(state)]
        least = min(found, key=lambda each: each.distance)
        return least._replace(inside=sum(each.inside for each in found))

    def at(self, state: State) -> Contacts:
        """Contact at a State."""
        point = self.nearest(state)
        if not point.distance < 0.0:
            return Contacts(point.distance, point.inside)
        self.system.take(state)
        t, x, v = state.t, state.x, state.v
        whole, smooth = self._forces.powers(t, x, v), self._smooth.powers(t, x, v)
        normal = np.linalg.norm(self._smooth.force(t, x, v)[self.shown], axis=1).sum()
        friction = whole.dissipated - smooth.dissipated
        return Contacts(point.distance, point.inside, float(normal), whole.stored, whole.dissipated, friction)

    def forces(self, state: State) -> FloatArray:
        """Force on each node, (n, 3), N: of all bodies on those of the net, of the net on the target's place."""
        self.system.take(state)
        return self._forces.force(state.t, state.x, state.v)

    def part_forces(self, state: State) -> FloatArray:
        """Force of the net on each part of the target, (P, 3), N."""
        self.system.take(state)
        assert self.system.body is not None
        place = self.system.body.place
        return np.array([each.force(state.t, state.x, state.v)[place] for each in self._of_parts])

    def gaps(self, state: State) -> FloatArray:
        """Distance of each node, with the thickness of its cords, from the nearest body, (n,), m; nan at others."""
        found = np.full(len(state.x), np.inf)
        for body in self._placed(state):
            found = np.minimum(found, gaps(body, state.x))
        return np.where(self.shown, found - self.knots.node_radius, np.nan)

    def columns(self, state: State) -> TargetColumns:
        """The target at a State, as metrics.csv has it."""
        body = self.system.body
        if body is None:
            return NO_TARGET
        target, force = target_at(self.system, state), self.forces(state)[body.place]
        return TargetColumns(*map(float, (*target.centre, *target.velocity, *target.spin, *force)))

    def _placed(self, state: State) -> list[Placed]:
        if self._parts is None:
            return self._fixed
        target = target_at(self.system, state)
        return [Placed(self._parts, target.origin, axes_of(target.attitude)), *self._fixed]


def _of_part(force: ElementForce, part: int) -> ElementForce:
    """The same contact with one part alone."""
    own = np.flatnonzero(force.parameters.part == part)
    fields = force.parameters._asdict()
    chosen = {name: value[own] for name, value in fields.items() if isinstance(value, np.ndarray)}
    return replace(force, nodes=force.nodes[own], parameters=force.parameters._replace(**chosen))


def _smooth(force: ElementForce) -> ElementForce:
    """The same contact without friction."""
    parameters = force.parameters._replace(friction=np.zeros_like(force.parameters.friction))
    return replace(force, parameters=parameters)
