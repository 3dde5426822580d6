"""The section [metrics] of a scenario, and the measures of a net that it chooses."""

from __future__ import annotations

from pydantic import Field

from netdae.model.net import CableNet
from netdae.output.metrics import DeploymentMetrics
from netdae.scenario.groups import check_group
from netdae.scenario.section import Section, Text
from netdae.system.system import System

NONE = "none"
"""What the keys say where a net has no such group."""


class Metrics(Section):
    """What is measured."""

    mouth: Text | None = Field(
        None,
        description='Group of the closed loop of the mouth; "border" if the net has it; "none" for none.',
    )
    corners: Text | None = Field(
        None, description='Node group of the corners; "corners" if the net has it; "none" for none.'
    )


def metrics_of(chosen: Metrics, system: System, *, contact_sums: bool = True) -> DeploymentMetrics:
    """Mouth and corners as chosen, or border and corners where the net has them; begun with the system.

    contact_sums : see `DeploymentMetrics`

    Raises InputError for an unknown group, and for a mouth that is no closed loop.
    """
    net = system.net
    mouth = chosen.mouth or ("border" if "border" in {*net.node_groups, *net.cable_groups} else NONE)
    corners = chosen.corners or ("corners" if "corners" in net.node_groups else NONE)
    metrics = DeploymentMetrics(
        mouth=None if mouth == NONE else mouth,
        corners=None if corners == NONE else corners,
        contact_sums=contact_sums,
    )
    if mouth != NONE:
        check_group({**net.node_groups, **net.cable_groups}, mouth, "node")
    if corners != NONE:
        check_group(net.node_groups, corners, "node")
    metrics.begin(system)  # finds the loop, or says what is wrong with it
    return metrics


def mouth_note(chosen: Metrics, net: CableNet) -> list[str]:
    """A note where a net without a group border is flown without a mouth that nobody has left out."""
    if chosen.mouth is not None or "border" in {*net.node_groups, *net.cable_groups}:
        return []
    groups = sorted({*net.node_groups, *net.cable_groups} - {"all"})
    named = f"one of {', '.join(groups[:8])}{', ...' if len(groups) > 8 else ''}" if groups else "it has none"
    return [
        "the net has no group border, so that no mouth is measured: give the group of its closed loop by mouth in "
        f'[metrics] ({named}), or mouth = "none" where no mouth is meant'
    ]
