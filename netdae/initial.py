"""Starts of a flight: where the nodes are and how fast, before anything pulls.

Positions x and velocities v are (n, 3), m and m/s.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from netdae.errors import InputError
from netdae.net import CableNet
from netdae.state import State


def scaled(
    net: CableNet,
    scale: ArrayLike = (1.0, 1.0, 1.0),
    *,
    rotation_deg: ArrayLike = (0.0, 0.0, 0.0),
    velocity: ArrayLike = (0.0, 0.0, 0.0),
) -> tuple[CableNet, State]:
    """The net drawn together by `scale` about the origin and turned, moving as a whole; turned net and start.

    scale : (3,), factors along x, y, z of the mesh
    rotation_deg : (3,), turns about the fixed x, then y, then z axis, in degrees
    velocity : (3,), m/s

    x̄ is turned with the start, since Eq. (9) takes its directions from x̄.
    """
    turn = Rotation.from_euler("xyz", np.asarray(rotation_deg, dtype=np.float64), degrees=True)
    turned = net.with_nodes(turn.apply(np.array(net.nodes)))  # scipy takes no read-only arrays
    x = turn.apply(net.nodes * np.asarray(scale, dtype=np.float64))
    return turned, State.at(x, np.broadcast_to(np.asarray(velocity, dtype=np.float64), x.shape))


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

    speed : m/s, beside the velocity that the nodes have already
    half_angle_deg : degrees, from the axis towards where the node stands off the group's own middle

    Raises InputError where the axis is zero, or a node stands on it and so has no outward direction.
    """
    n = np.asarray(axis, dtype=np.float64)
    if not np.linalg.norm(n) > 0:
        raise InputError(f"ejection of {group!r}: axis is {n.tolist()}: give a direction")
    n = n / np.linalg.norm(n)
    nodes = net.nodes_of(group)
    offset = start.x[nodes] - start.x[nodes].mean(axis=0)
    outward = offset - np.outer(offset @ n, n)
    reach = np.linalg.norm(outward, axis=1)
    angle = np.deg2rad(half_angle_deg)
    scale = max(float(np.abs(net.nodes).max()), 1e-300)
    if angle != 0 and (reach <= 1e-9 * scale).any():
        node = nodes[int(np.argmin(reach))]
        raise InputError(
            f"ejection of {group!r}: node {node} stands on the axis and has no outward direction: "
            "set half_angle_deg to 0, or choose nodes around the axis"
        )
    direction = np.divide(outward, reach[:, None], out=np.zeros_like(outward), where=reach[:, None] > 0)
    v = start.v.copy()
    v[nodes] += speed * (np.cos(angle) * n + np.sin(angle) * direction)
    return State.at(start.x, v, t=start.t)
