"""The section [[pulleys]] of a scenario, and the cords of constant length through rings that it makes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from netdae.forces.rings import Rings
from netdae.model.net import CableNet
from netdae.scenario.closing import FrictionCoefficient, GroupOrList
from netdae.scenario.groups import check_group
from netdae.scenario.material import CordMaterial, material_of
from netdae.scenario.problems import InSection
from netdae.scenario.section import Length, Section, Text
from netdae.system.pulleys import PulleyCord, check_pulleys

CreepSpeed = Annotated[float, Field(gt=0, le=1e6)]  # m/s


class _Rings(Section):
    friction: FrictionCoefficient = Field(
        0.0, description="Coefficient of friction at the rings, by the capstan rule."
    )
    creep_speed: CreepSpeed = Field(
        1e-2, description="Sliding speed at which the friction has seven tenths of its full value, m/s."
    )
    ring_size: Length = Field(1e-3, description="Least length of cord from one ring to the next, m.")


class OwnCord(_Rings):
    """Cables of the net that are one cord, which slides through its inner nodes."""

    cables: Text = Field(description="Cable group: one chain of cables, or one loop.")


class PulleyEntry(CordMaterial, _Rings):
    """One cord of constant length through rings at several nodes: held nodes are fixed pulleys, free ones moving."""

    rings: GroupOrList = Field(
        description="Node numbers in the order of the cord, its ends among them; or a node group, in the order in "
        "which a closed loop of cables passes it."
    )
    loop: Text | None = Field(
        None, description="Group of the loop that passes the rings; by default the group of the rings itself."
    )
    closed: bool = Field(False, description="Whether the cord is endless and comes back to its first ring.")
    length: Length | None = Field(None, description="Rest length, m; its way through the mesh by default.")


def _kind_of_cord(value: Any) -> str:
    return "<cables>" if isinstance(value, dict) and "cables" in value else "<rings>"


PulleyCordEntry = Annotated[
    Annotated[OwnCord, Tag("<cables>")] | Annotated[PulleyEntry, Tag("<rings>")], Discriminator(_kind_of_cord)
]


def pulleys_of(
    entries: Sequence[OwnCord | PulleyEntry], net: CableNet, section: InSection
) -> list[PulleyCord]:
    """The cords of the entries; raises InputError, through `section`, for rings that are not in the net."""
    cords = []
    for number, entry in enumerate(entries):
        with section("pulleys", number):
            cords.append(_cord_of(entry, net))
            check_pulleys(net, cords[-1])
    return cords


def _cord_of(entry: OwnCord | PulleyEntry, net: CableNet) -> PulleyCord:
    rings = Rings(entry.ring_size, entry.friction, entry.creep_speed)
    if isinstance(entry, OwnCord):
        check_group(net.cable_groups, entry.cables, "cable")
        return PulleyCord(cables=entry.cables, rings=rings)
    group = entry.rings if isinstance(entry.rings, str) else None
    if group is not None:
        check_group(net.node_groups, group, "node")
    return PulleyCord(
        material_of(entry),
        group=group,
        nodes=None if isinstance(entry.rings, str) else tuple(entry.rings),
        loop=entry.loop,
        closed=entry.closed,
        length=entry.length,
        rings=rings,
    )
