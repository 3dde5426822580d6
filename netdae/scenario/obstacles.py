"""The section [[obstacles]] of a scenario, fixed bodies such as a floor, and what it makes of them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pydantic import Field

from netdae.model.target import Obstacle
from netdae.scenario.problems import InSection
from netdae.scenario.section import Vector
from netdae.scenario.shapes import ContactKeys, ShapeKeys, contact_of, part_of, shape_of


class ObstacleEntry(ContactKeys, ShapeKeys):
    """A body that is fixed in space, such as a floor: the plane z = 0 with its free side above."""

    position: Vector = Field((0.0, 0.0, 0.0), description="Place of its origin, m.")
    attitude_deg: Vector = Field(
        (0.0, 0.0, 0.0), description="Turns about the fixed x, then y, then z axis, degrees."
    )


def obstacles_of(
    entries: Sequence[ObstacleEntry], folder: Path, net_size: float, section: InSection
) -> tuple[Obstacle, ...]:
    """The obstacles of the entries; raises InputError, through `section`, for shapes that cannot be."""
    obstacles = []
    for number, entry in enumerate(entries):
        with section("obstacles", number):
            part = part_of(shape_of(entry, folder, net_size), entry.position, entry.attitude_deg)
            obstacles.append(Obstacle(part, contact_of(entry)))
    return tuple(obstacles)
