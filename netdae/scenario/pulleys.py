"""The section [[pulleys]] of a scenario, and the cords of constant length through rings that it makes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

from pydantic import Field

from netdae.forces.rings import Rings
from netdae.model.net import CableNet
from netdae.scenario.closing import FrictionCoefficient, GroupOrList
from netdae.scenario.groups import check_group
from netdae.scenario.material import CordMaterial, material_of
from netdae.scenario.problems import InSection
from netdae.scenario.section import Length, Text
from netdae.system.pulleys import PulleyCord, check_pulleys

CreepSpeed = Annotated[float, Field(gt=0, le=1e6)]  # m/s


class PulleyEntry(CordMaterial):
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
    friction: FrictionCoefficient = Field(
        0.0, description="Coefficient of friction at the rings, by the capstan rule."
    )
    creep_speed: CreepSpeed = Field(
        1e-2, description="Sliding speed at which the friction has seven tenths of its full value, m/s."
    )
    ring_size: Length = Field(1e-3, description="Least length of cord from one ring to the next, m.")


def pulleys_of(entries: Sequence[PulleyEntry], net: CableNet, section: InSection) -> list[PulleyCord]:
    """The cords of the entries; raises InputError, through `section`, for rings that are not in the net."""
    cords = []
    for number, entry in enumerate(entries):
        with section("pulleys", number):
            cords.append(_cord_of(entry, net))
            check_pulleys(net, cords[-1])
    return cords


def _cord_of(entry: PulleyEntry, net: CableNet) -> PulleyCord:
    by_group = isinstance(entry.rings, str)
    if by_group:
        check_group(net.node_groups, str(entry.rings), "node")
    return PulleyCord(
        material_of(entry),
        group=str(entry.rings) if by_group else None,
        nodes=None if by_group else tuple(int(node) for node in entry.rings),
        loop=entry.loop,
        closed=entry.closed,
        length=entry.length,
        rings=Rings(entry.ring_size, entry.friction, entry.creep_speed),
    )
