"""Where a net may touch a target or obstacles: every knot and every cable with every part, see `forces.contact`.

A stiffness that is not given is chosen for each cord and bullet. ½ EĀ/L̄, half of the cord's own, costs an explicit step
nothing. A point of the mass m that comes at the speed v is stopped in the depth δ by k = m v²/δ² (n = 1), or
k = 1.25 m v²/δ^2.5 (n = 1.5): where this is more, for a depth of `DEEP`, k is raised to it. A cable meets with its own
mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.core.records import Record
from netdae.forces.contact import DEEP, MEETING, REGULAR, RESTING, Meeting, Resting
from netdae.forces.elements import ElementForce
from netdae.model.material import Cords
from netdae.model.net import CableNet
from netdae.model.shapes.part import Part, parts_of
from netdae.model.signals import CLOCK
from netdae.model.target import Contact, Obstacle
from netdae.system.target_nodes import TargetNodes


def contacts_of(
    net: CableNet,
    cords: Cords,
    mass: FloatArray,
    touches: BoolArray,
    body: TargetNodes | None,
    obstacles: Sequence[Obstacle],
) -> tuple[list[ElementForce], list[Record]]:
    """Forces of a target and of obstacles on the nodes that can touch, (n,), and on their cables.

    mass : (n,), kg
    The records hold the parts, to be kept as long as the forces are.
    """
    forces, kept = [], []
    own = np.flatnonzero(touches)
    cables = net.cables[touches[net.cables].all(axis=1)]
    which = np.flatnonzero(touches[net.cables].all(axis=1))
    ends = np.concatenate((np.stack((own, own), axis=1), cables))
    thick = np.sqrt(cords.area / np.pi)
    half = 0.5 * cords.axial_stiffness / net.rest_length
    at_knot, of_knot = np.zeros((2, net.node_count))
    np.maximum.at(at_knot, net.cables, thick[:, None])
    np.maximum.at(of_knot, net.cables, half[:, None])
    radius = np.concatenate((at_knot[own], thick[which]))
    stiffness = np.concatenate((of_knot[own], half[which]))
    hangs = 0.5 * cords.linear_density * net.rest_length
    moving = np.concatenate((mass[own], 2.0 * hangs[which]))
    regular = np.concatenate((np.zeros(len(own)), np.full(len(which), REGULAR)))
    if body is not None:
        parts = body.target.principal_parts
        contacts = [body.target.contact_of(k) for k in range(len(parts))]
        record, values = _values(parts, contacts, ends, radius, stiffness, moving, regular)
        nodes = np.tile(ends, (len(parts), 1))
        there = np.tile([body.place, body.spin], (len(nodes), 1))
        meeting = Meeting(record.address, body.pose.address, **values)
        forces.append(ElementForce(MEETING, np.hstack((nodes, there)), meeting, CLOCK))
        kept.append(record)
    if obstacles:
        parts = tuple(obstacle.part for obstacle in obstacles)
        contacts = [obstacle.contact for obstacle in obstacles]
        record, values = _values(parts, contacts, ends, radius, stiffness, moving, regular)
        forces.append(
            ElementForce(RESTING, np.tile(ends, (len(parts), 1)), Resting(record.address, **values))
        )
        kept.append(record)
    return forces, kept


def _values(
    parts: Sequence[Part],
    contacts: Sequence[Contact],
    ends: IntArray,
    radius: FloatArray,
    stiffness: FloatArray,
    moving: FloatArray,
    regular: FloatArray,
) -> tuple[Record, dict[str, Any]]:
    """The record of the parts, and parameters of the elements of all of them, part after part."""
    record, count, m = Record(parts_of(parts)), len(parts), len(ends)
    part = np.repeat(np.arange(count), m)
    k = np.concatenate([_chosen(contact, stiffness, moving) for contact in contacts])
    of_part = {
        name: np.array([getattr(contact, name) for contact in contacts])[part]
        for name in ("exponent", "dissipation", "friction", "slip_speed")
    }
    return record, {
        "part": part,
        "radius": np.tile(radius, count),
        "regular": np.tile(regular, count),
        "stiffness": k,
        **of_part,
        "convex": record.values.convex[part],
        "lipschitz": record.values.lipschitz[part],
        "place": np.full(count * m, 0.5),
        "met": np.zeros((count * m, 11)),
        "elastic": False,
        "exact": True,
        "middle": record.values.centre[part],
        "sphere": record.values.radius[part],
        "asleep": np.zeros(count * m),
        "way": 0,
    }


def _chosen(contact: Contact, stiffness: FloatArray, moving: FloatArray) -> FloatArray:
    """k of each element, (m,), N/mⁿ."""
    if contact.stiffness is not None:
        return np.full(len(stiffness), contact.stiffness)
    n, v = contact.exponent, contact.closing_speed
    needed = 0.5 * (n + 1.0) * moving * v * v / DEEP ** (n + 1.0)
    return np.maximum(stiffness / DEEP ** (n - 1.0), needed)
