"""Ejection: bullets shot from the canister, each with its errors, and the speed that they give to the net.

Symbols: m masses of all nodes (n,), kg; n unit vector of the axis; for each bullet b its speed v_b, m/s, its angle
θ_b from the axis, and its time of release, s.

**The speed of the whole net.** No force from outside acts on a free net once its bullets have left: its momentum
is what they took with them, Σ m_b v_b. Along the axis that is Σ m_b v_b cos θ_b, and the centre of mass, of all the
mass Σ m that hangs on them, moves with

    v_com = Σ m_b v_b cos θ_b / Σ m,

however the net opens. m_b is all that is lumped at the bullet's node, its half cables too. With a velocity V of the
whole net n·V is added. A bullet that is held until its time takes its velocity when it is let go; the formula then
assumes that no cable pulled on the canister through it before: the reaction would be an external impulse.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from netdae.core.arrays import FloatArray, IntArray, frozen_floats, frozen_ints
from netdae.core.errors import InputError
from netdae.model.net import CableNet
from netdae.model.state import State


@dataclass(frozen=True)
class Spread:
    """Standard deviations of errors that are drawn from normal distributions, one draw per bullet.

    speed : m/s; angle_deg, azimuth_deg : degrees
    time : s, of the release; a release is never early: absolute values of the draws are taken
    seed : of the draws; each of the four has its own stream, so that one does not shift the others
    member : index in an ensemble; each draws from seed and member alone, and 0 draws what the seed alone gives
    """

    speed: float = 0.0
    angle_deg: float = 0.0
    azimuth_deg: float = 0.0
    time: float = 0.0
    seed: int = 0
    member: int = 0

    def __post_init__(self) -> None:
        for name in ("speed", "angle_deg", "azimuth_deg", "time"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise InputError(f"spread: {name} is {value:g}: give a standard deviation, zero or more")
        for name in ("seed", "member"):
            value = getattr(self, name)
            if isinstance(value, bool) or value != int(value) or value < 0:
                raise InputError(f"spread: {name} is {value}: give a whole number, zero or more")

    @property
    def draws(self) -> bool:
        """Whether any error is drawn."""
        return max(self.speed, self.angle_deg, self.azimuth_deg, self.time) > 0

    def drawn(self, count: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Errors of `count` bullets, each (count,): speed, angle, azimuth, release time."""
        # numpy fills a seed up with zeros, so that (seed, 0) and seed draw the same
        streams = np.random.default_rng((int(self.seed), int(self.member))).spawn(4)
        normal = [stream.standard_normal(count) for stream in streams]
        return (
            self.speed * normal[0],
            self.angle_deg * normal[1],
            self.azimuth_deg * normal[2],
            self.time * np.abs(normal[3]),
        )


@dataclass(frozen=True, eq=False)
class Ejection:
    """Nodes of a group that are shot along an axis, each turned outward by the half-angle.

    group : node group of the bullets
    speed : m/s, added to the velocity that the nodes have already
    half_angle_deg : degrees, from the axis, away from the group's own middle
    axis : (3,), direction in space
    speed_errors : m/s, added to the speed, one per bullet in the order of the group's nodes
    angle_errors_deg : degrees, added to the half-angle; azimuth_errors_deg : turn about the axis, right-handed
    release_times : s after the start of the flight, at which a bullet leaves; until then it is held
    spread : random errors in addition to the listed ones
    outward : whether outward is measured at the initial positions, or in the open net x̄: a folded pack may have
        all its corners on one side
    """

    group: str
    speed: float
    half_angle_deg: float
    axis: ArrayLike = (0.0, 0.0, 1.0)
    speed_errors: Sequence[float] | None = None
    angle_errors_deg: Sequence[float] | None = None
    azimuth_errors_deg: Sequence[float] | None = None
    release_times: Sequence[float] | None = None
    spread: Spread | None = None
    outward: Literal["start", "net"] = "start"


@dataclass(frozen=True, eq=False)
class Launch:
    """Bullets that leave the canister.

    nodes : (k,), rising
    velocities : (k, 3), m/s, of each at its release, including what it has already
    times : (k,), s after the start of the flight
    """

    nodes: IntArray
    velocities: FloatArray
    times: FloatArray

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "nodes", frozen_ints(self.nodes))
        put(self, "velocities", frozen_floats(self.velocities))
        put(self, "times", frozen_floats(self.times))

    @classmethod
    def none(cls) -> Launch:
        """A launch without bullets."""
        return cls(np.zeros(0, dtype=np.int64), np.zeros((0, 3)), np.zeros(0))

    @property
    def held(self) -> Launch:
        """The bullets that are held at first."""
        late = self.times > 0
        return Launch(self.nodes[late], self.velocities[late], self.times[late])


def launch_of(net: CableNet, start: State, ejection: Ejection) -> Launch:
    """Bullets of one ejection from `start`.

    Raises InputError where the axis is zero, a node lies on it and so has no outward direction, an angle is
    outside 0 to 180°, a speed is negative, or a list does not have one number per bullet.
    """
    group = ejection.group
    n = _axis_of(ejection)
    nodes = net.nodes_of(group)
    if not len(nodes):
        raise InputError(f"ejection of {group!r}: the group has no nodes: name another one")
    drawn = (ejection.spread or Spread()).drawn(len(nodes))
    speed = ejection.speed + _listed(ejection, "speed_errors", len(nodes)) + drawn[0]
    angle = ejection.half_angle_deg + _listed(ejection, "angle_errors_deg", len(nodes)) + drawn[1]
    azimuth = np.deg2rad(_listed(ejection, "azimuth_errors_deg", len(nodes)) + drawn[2])
    times = _listed(ejection, "release_times", len(nodes)) + drawn[3]
    for values, what, wrong in (
        (speed, "a speed of {:g} m/s, below zero", (speed < 0) & (ejection.speed >= 0)),
        (times, "a release time of {:g} s, before the begin", times < 0),
    ):
        if wrong.any():
            b = int(np.argmax(wrong))
            raise InputError(
                f"ejection of {group!r}: node {nodes[b]} gets {what.format(values[b])}: give smaller errors"
            )
    theta = np.deg2rad(angle)
    places = start.x[nodes] if ejection.outward == "start" else net.nodes[nodes]
    outward = _outward(net, places, nodes, n, theta, group)
    outward = np.cos(azimuth)[:, None] * outward + np.sin(azimuth)[:, None] * np.cross(n, outward)
    shot = speed[:, None] * (np.cos(theta)[:, None] * n + np.sin(theta)[:, None] * outward)
    return Launch(nodes, start.v[nodes] + shot, times)


def _axis_of(ejection: Ejection) -> FloatArray:
    n = np.asarray(ejection.axis, dtype=np.float64)
    if not np.linalg.norm(n) > 0:
        raise InputError(f"ejection of {ejection.group!r}: axis is {n.tolist()}: give a direction")
    return n / np.linalg.norm(n)


def _listed(ejection: Ejection, name: str, count: int) -> FloatArray:
    """Listed errors of all bullets, (count,); zero where there are none."""
    values = getattr(ejection, name)
    if values is None:
        return np.zeros(count)
    array = np.asarray(values, dtype=np.float64)
    if array.shape != (count,):
        raise InputError(
            f"ejection of {ejection.group!r}: {name}: {array.size} given for {count} bullets: give one number for "
            "each, in the order of the group's nodes"
        )
    if not np.isfinite(array).all():
        b = int(np.argmin(np.isfinite(array)))
        raise InputError(
            f"ejection of {ejection.group!r}: {name}: {array[b]:g} given for bullet {b + 1}: give a finite number"
        )
    return array


def _outward(
    net: CableNet, places: FloatArray, nodes: IntArray, n: FloatArray, theta: FloatArray, group: str
) -> FloatArray:
    """Unit vectors (k, 3) across the axis, from the middle of `places` (k, 3) to each; zero on the axis."""
    offset = places - places.mean(axis=0)
    across = offset - np.outer(offset @ n, n)
    reach = np.linalg.norm(across, axis=1)
    size = max(float(np.abs(net.nodes).max()), 1e-300)
    lost = (reach <= 1e-9 * size) & (theta != 0)
    if lost.any():
        raise InputError(
            f"ejection of {group!r}: node {nodes[int(np.argmax(lost))]} stands on the axis and has no outward "
            "direction: set half_angle_deg to 0, or choose nodes around the axis"
        )
    return np.divide(across, reach[:, None], out=np.zeros_like(across), where=reach[:, None] > 0)


def fired(net: CableNet, start: State, ejections: Sequence[Ejection]) -> tuple[State, Launch]:
    """`start` with the bullets that leave at once in motion, and the launch of all of them.

    A bullet of several ejections gets the sum of their velocities, and must have one release time. Those with a later
    time keep the velocity of `start`, with the canister that holds them.
    """
    v, times = start.v.copy(), np.full(net.node_count, -1.0)
    for ejection in ejections:
        launch = launch_of(net, State.at(start.x, v, t=start.t), ejection)
        before = times[launch.nodes]
        clash = (before >= 0) & (before != launch.times)
        if clash.any():
            b = int(np.argmax(clash))
            raise InputError(
                f"ejection of {ejection.group!r}: node {launch.nodes[b]} is released at {launch.times[b]:g} s, but at "
                f"{before[b]:g} s by an ejection before: let a node have one release time"
            )
        v[launch.nodes] = launch.velocities
        times[launch.nodes] = launch.times
    nodes = np.flatnonzero(times >= 0)
    whole = Launch(nodes, v[nodes], times[nodes])
    held = whole.held.nodes
    v[held] = start.v[held]
    return State.at(start.x, v, t=start.t), whole


def check_bullets(net: CableNet, ejection: Ejection, added_mass: ArrayLike) -> None:
    """Raise InputError where a bullet has no mass of its own in `added_mass` (n,), kg besides its cables."""
    nodes = net.nodes_of(ejection.group)
    bare = np.flatnonzero(np.asarray(added_mass)[nodes] <= 0)
    if len(bare):
        all_of_many = len(bare) == len(nodes) > 1
        who = f"its {len(nodes)} nodes have" if all_of_many else f"node {nodes[bare[0]]} has"
        raise InputError(
            f"ejection of {ejection.group!r}: {who} no mass beside the cables, but bullets need one: "
            f"add [[masses]] with group = {ejection.group!r} and a mass above zero"
        )


def velocity_after(mass: ArrayLike, start: State, launch: Launch) -> FloatArray:
    """Velocity (3,) of the centre of mass of a free net when all bullets have left, m/s; see the module.

    mass : (n,), kg, of all nodes, for instance `System.mass`
    """
    m = np.asarray(mass, dtype=np.float64)
    v = start.v.copy()
    v[launch.nodes] = launch.velocities
    return np.asarray(m @ v / m.sum())
