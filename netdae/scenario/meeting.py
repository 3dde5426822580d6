"""What a scenario's net and the bodies that it meets have to do with each other at the start."""

from __future__ import annotations

from collections.abc import Sequence

from netdae.core.errors import InputError
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.model.target import Obstacle, Target
from netdae.scenario.problems import InSection
from netdae.system.overlap import Knots, Nearest, nearest, parts_in, placed
from netdae.system.system import System

_TOUCHES = 1e-9
"""m, below which a net that lies on a body is not in it: round-off."""


def check_apart(
    target: Target | None, obstacles: Sequence[Obstacle], system: System, start: State, section: InSection
) -> None:
    """Raise InputError, through `section`, where net, tether or chaser begin inside a body.

    start : of the net, with its tether and closing cords, without the target
    """
    net = system.net
    shown = system.in_space.copy()
    shown[len(start.x) :] = False
    knots = Knots.of(net, system.cords, shown)
    whole = system.whole(start)
    bodies: list[tuple[Target | Obstacle, str, int | None]] = (
        [] if target is None else [(target, "target", None)]
    )
    bodies += [(each, "obstacles", number) for number, each in enumerate(obstacles)]
    for body, name, number in bodies:
        found = nearest(placed(body), whole.x, knots)
        if found.distance < -_TOUCHES:
            with section(name, number):
                place = ", ".join(f"{value:.4g}" for value in found.point)
                part = f" with part {found.part + 1}" if len(parts_in(body)) > 1 else ""
                raise InputError(
                    f"it overlaps {whose(found, net)} at the start{part}: {-found.distance:.3g} m deep at ({place}) m: "
                    "move the one or the other apart"
                )


def whose(found: Nearest, net: CableNet) -> str:
    """What of a net a point belongs to, in words."""
    if found.node >= 0:
        for name in ("chaser", "tether"):
            if found.node in net.node_groups.get(name, ()):
                return f"the {name}"
        return f"the net's node {found.node}"
    if found.cable in net.cable_groups.get("tether", ()):
        return "the tether"
    return f"the net's cable {found.cable}"
