"""The section [[masses]] of a scenario, and the masses at nodes that it makes."""

from __future__ import annotations

from collections.abc import Sequence

from pydantic import Field

from netdae.model.net import CableNet
from netdae.scenario.groups import check_nodes
from netdae.scenario.problems import InSection
from netdae.scenario.section import NodeMass, Section, Text


class Mass(Section):
    """Bullets, or other masses at nodes; those of several entries add up."""

    group: Text = Field(description="Node group.")
    mass: NodeMass = Field(description="Mass at each node of the group, kg.")


def masses_of(entries: Sequence[Mass], net: CableNet, section: InSection, *, alone: bool) -> dict[str, float]:
    """Node group to kg; raises InputError, through `section`, as `check_nodes` does."""
    masses: dict[str, float] = {}
    for number, entry in enumerate(entries):
        with section("masses", number):
            check_nodes(net, entry.group, alone=alone)
        masses[entry.group] = masses.get(entry.group, 0.0) + entry.mass
    return masses
