"""The measures of a net that the section [metrics] of a scenario chooses."""

from __future__ import annotations

from netdae.metrics import DeploymentMetrics
from netdae.scenario import schema
from netdae.scenario.groups import check_group
from netdae.system import System


def metrics_of(chosen: schema.Metrics, system: System) -> DeploymentMetrics:
    """Mouth and corners as chosen, or border and corners where the net has them; begun with the system.

    Raises InputError for an unknown group, and for a mouth that is no closed loop.
    """
    net = system.net
    mouth = chosen.mouth or ("border" if "border" in {*net.node_groups, *net.cable_groups} else schema.NONE)
    corners = chosen.corners or ("corners" if "corners" in net.node_groups else schema.NONE)
    metrics = DeploymentMetrics(
        mouth=None if mouth == schema.NONE else mouth, corners=None if corners == schema.NONE else corners
    )
    if mouth != schema.NONE:
        check_group({**net.node_groups, **net.cable_groups}, mouth, "node")
    if corners != schema.NONE:
        check_group(net.node_groups, corners, "node")
    metrics.begin(system)  # finds the loop, or says what is wrong with it
    return metrics
