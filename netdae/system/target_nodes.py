"""The two nodes of a target in a net: its place, which is its centre of mass, and its spin, see `forces.pose`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numba import njit

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.core.records import Record, load
from netdae.forces.contact import MEETING
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.forces.gyroscope import GYROSCOPE, Gyroscope
from netdae.forces.pose import TURN, Pose, attitude_at, matrix_of, move_base, pose_of, put_base, rates_of
from netdae.model.motions import Fixed, Motion, Steady
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.model.target import Target
from netdae.model.tether import PLACE, SPIN


@dataclass(frozen=True, eq=False)
class TargetNodes:
    """A target as the last two nodes of a net.

    place, spin : their numbers
    pose : its attitude as the System's own forces see it; compiled methods have one of their own
    """

    target: Target
    place: int
    spin: int
    pose: Record

    @classmethod
    def of(cls, target: Target, net: CableNet) -> TargetNodes:
        """Nodes after those of a net."""
        body, free = target.body, target.motion == "free"
        rho = np.ones(3) if body is None else np.sqrt(body.inertia / body.mass)
        mass = 0.0 if body is None else body.mass
        pose = Record(pose_of(target.principal_attitude, rho, mass, free=free))
        return cls(target, net.node_count, net.node_count + 1, pose)

    @property
    def mass(self) -> FloatArray:
        """Of both nodes, (2,), kg."""
        return np.full(2, self.pose.values.mass)

    @property
    def radius(self) -> float:
        """Distance of its farthest point from the centre of mass, m."""
        cores = [(part, part.shape.core()) for part in self.target.principal_parts]
        reach = [
            np.linalg.norm(part.position + part.axes @ core.centre) + core.radius for part, core in cores
        ]
        return float(max(reach))

    def gyroscopic(self, v: FloatArray) -> FloatArray:
        """Acceleration of the spin node by the gyroscopic torque, (3,), m/s²; v (n, 3)."""
        pose = self.pose.values
        if not pose.free:
            return np.zeros(3)
        W = v[self.spin] / pose.rho
        return -np.cross(W, pose.rho**2 * W) / pose.rho

    def longest_step(self, v: FloatArray) -> float:
        """Longest step in s of a method that follows the attitude by `pose`'s series, at velocities v (n, 3)."""
        spin = float(np.linalg.norm(v[self.spin] / self.pose.values.rho))
        return TURN / spin if spin > 0 and self.pose.values.free else np.inf

    def grown(self, net: CableNet) -> CableNet:
        """The net with both nodes, which are the groups "target" and "spin of target"."""
        for name in (PLACE, SPIN):
            if name in net.node_groups:
                raise InputError(f"target: the net has a node group {name!r} already: rename it")
        own = (PLACE, self.place), (SPIN, self.spin)
        return replace(
            net,
            nodes=np.concatenate((net.nodes, self._start()[0])),
            node_groups={**net.node_groups, **{name: np.array([at]) for name, at in own}},
        )

    def whole(self, start: State) -> State:
        """A start of the net alone, with that of the target where it lacks it."""
        x, v, a = start.x, start.v, start.a
        if len(x) == self.place:
            own_x, own_v = self._start()
            x, v = np.concatenate((x, own_x)), np.concatenate((v, own_v))
            a = np.concatenate((a, np.zeros((2, 3))))
        attitude = start.attitude if len(start.attitude) else self.target.principal_attitude
        return replace(start, x=x, v=v, a=a, attitude=attitude)

    def _start(self) -> tuple[FloatArray, FloatArray]:
        """Positions and velocities of both nodes at the start, (2, 3)."""
        target, rho = self.target, self.pose.values.rho
        x = np.stack((target.centre, np.zeros(3)))
        return x, np.stack((target.velocity, rho * target.principal_spin))

    def restraints(self) -> tuple[Restraint, ...]:
        """What holds or drives a target that is not free."""
        if self.target.motion == "free":
            return ()
        _, speeds = self._start()
        motions: list[Motion] = [Steady(tuple(each)) if each.any() else Fixed() for each in speeds]
        return (
            Restraint((self.place,), motion=motions[0]),
            Restraint((self.spin,), motion=motions[1]),
        )

    def forces(self) -> tuple[Force, ...]:
        """What acts on the target alone."""
        if self.target.motion != "free":
            return ()
        rho, mass = self.pose.values.rho, self.pose.values.mass
        parameters = Gyroscope(rho[None], np.array([mass]))
        return (ElementForce(GYROSCOPE, np.array([[self.spin]]), parameters),)

    # Attitude

    def take(self, state: State) -> None:
        """Let the System's forces see the target as it is at a state."""
        if len(state.attitude):
            x, v = (np.ascontiguousarray(each[self.spin]) for each in (state.x, state.v))
            set_attitude(self.pose.address, state.attitude, x, v, state.t)

    def attitude_at(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Quaternion (w, x, y, z) of the principal axes, (4,), near the state that was last taken; x, v (n, 3)."""
        return np.array(
            attitude_of(self.pose.address, *(np.ascontiguousarray(each[self.spin]) for each in (x, v)), t)
        )

    def advance(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """The attitude as `attitude_at`, from which later ones then follow."""
        advance(self.pose.address, *(np.ascontiguousarray(each[self.spin]) for each in (x, v)), t)
        return np.array(self.pose.values.base[:4])

    def spin_momentum(self, x: FloatArray, v: FloatArray) -> FloatArray:
        """R I W, (3,), N m s, near the state that was last taken."""
        pose = self.pose.values
        R = np.array(
            axes_of(self.pose.address, *(np.ascontiguousarray(each[self.spin]) for each in (x, v)))
        ).reshape(3, 3)
        return R @ (pose.mass * pose.rho * v[self.spin])


def seen_by(forces: tuple[Force, ...], pose: Record | None, way: int) -> tuple[Force, ...]:
    """The same forces, but contact with a memory of its own, a tangent for Newton's matrix and another pose.

    way : address of that of explicit steps, see `forces.contact`, for which it leaves out damping and friction; or 0
    """
    return tuple(_own(force, pose, way) for force in forces)


def _own(force: Force, pose: Record | None, way: int) -> Force:
    if not isinstance(force, ElementForce) or not force.law.across:
        return force
    settings: dict[str, Any] = {"elastic": way != 0, "exact": False, "way": way}
    if force.law is MEETING and pose is not None:
        settings["pose"] = pose.address
    return replace(force, parameters=force.parameters._replace(**settings))


@njit(cache=True)
def set_attitude(address: int, q: FloatArray, x: FloatArray, v: FloatArray, t: float) -> None:
    """Put the base of the pose at an address at q (4,), with x, v (3,) of its spin node."""
    pose = load(address, Pose)
    if pose.free:
        put_base(pose, (q[0], q[1], q[2], q[3]), rates_of(pose, x, 0), rates_of(pose, v, 0), t)


@njit(cache=True)
def attitude_of(address: int, x: FloatArray, v: FloatArray, t: float) -> Any:
    """Quaternion where the spin node has x, v (3,) at t."""
    pose = load(address, Pose)
    return attitude_at(pose, rates_of(pose, x, 0), rates_of(pose, v, 0), t)


@njit(cache=True)
def axes_of(address: int, x: FloatArray, v: FloatArray) -> Any:
    """R where the spin node has x, v (3,) at the time of the base."""
    pose = load(address, Pose)
    return matrix_of(attitude_at(pose, rates_of(pose, x, 0), rates_of(pose, v, 0), pose.base[10]))


@njit(cache=True)
def advance(address: int, x: FloatArray, v: FloatArray, t: float) -> None:
    """Move the base to t."""
    pose = load(address, Pose)
    move_base(pose, rates_of(pose, x, 0), rates_of(pose, v, 0), t)
