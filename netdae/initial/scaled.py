"""Initial states of a flight: positions and velocities of the nodes, before anything pulls.

Positions x and velocities v are (n, 3), m and m/s.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from netdae.initial.ejection import Ejection, launch_of
from netdae.model.net import CableNet
from netdae.model.state import State


def scaled(
    net: CableNet,
    scale: ArrayLike = (1.0, 1.0, 1.0),
    *,
    rotation_deg: ArrayLike = (0.0, 0.0, 0.0),
    velocity: ArrayLike = (0.0, 0.0, 0.0),
) -> tuple[CableNet, State]:
    """The net drawn together by `scale` about the origin and rotated, moving as a whole; rotated net and initial state.

    scale : (3,), factors along x, y, z of the mesh
    rotation_deg : (3,), turns about the fixed x, then y, then z axis, in degrees
    velocity : (3,), m/s

    x̄ is rotated as well, since Eq. (9) takes its directions from x̄.
    """
    x = net.nodes * np.asarray(scale, dtype=np.float64)
    return placed(net, x, rotation_deg=rotation_deg, velocity=velocity)


def placed(
    net: CableNet, x: ArrayLike, *, rotation_deg: ArrayLike, velocity: ArrayLike
) -> tuple[CableNet, State]:
    """The net with positions x (n, 3), m, both rotated, moving as a whole; rotated net and start, see `scaled`."""
    turn = Rotation.from_euler("xyz", np.asarray(rotation_deg, dtype=np.float64), degrees=True)
    turned = net.with_nodes(turn.apply(np.array(net.nodes)))  # scipy takes no read-only arrays
    start = turn.apply(np.array(x, dtype=np.float64))
    return turned, State.at(start, np.broadcast_to(np.asarray(velocity, dtype=np.float64), start.shape))


def ejected(
    net: CableNet,
    start: State,
    group: str,
    *,
    speed: float,
    half_angle_deg: float,
    axis: ArrayLike = (0.0, 0.0, 1.0),
) -> State:
    """`start` with the nodes of a group shot along `axis`, each turned outward by the half-angle.

    speed : m/s, added to the velocity that the nodes have already
    half_angle_deg : degrees, from the axis, away from the group's own middle

    Raises InputError where the axis is zero, or a node lies on it and so has no outward direction.
    Bullets with errors of their own, or released later, are made by `ejection.fired`.
    """
    launch = launch_of(net, start, Ejection(group, speed, half_angle_deg, axis))
    v = start.v.copy()
    v[launch.nodes] = launch.velocities
    return State.at(start.x, v, t=start.t)
