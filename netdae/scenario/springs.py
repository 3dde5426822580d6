"""The kind "spring" of [[loads]] of a scenario, and the springs that it makes."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from netdae.core.arrays import FloatArray
from netdae.forces.spring import Spring
from netdae.scenario.section import Section, Text, Vector

Stiffness = Annotated[float, Field(ge=1e-9, le=1e12)]  # N/m
Viscosity = Annotated[float, Field(ge=0, le=1e12)]  # N s/m
RestLength = Annotated[float, Field(ge=0, le=1e6)]  # m


class SpringEntry(Section):
    """Linear springs from each node of a group to one other node, or to the ground."""

    kind: Literal["spring"] = Field(description="Kind of load.")
    group: Text = Field(description="Node group.")
    to: Text | None = Field(
        None, description="Node group of the one node at the other end; the ground by default."
    )
    anchor: Vector | None = Field(
        None, description="Place on the ground, m; by default that of each node at the start."
    )
    stiffness: Stiffness = Field(description="Stiffness of each spring, which also pushes, N/m.")
    viscosity: Viscosity = Field(0.0, description="Of the damper beside each spring, N s/m.")
    rest_length: RestLength | None = Field(
        None, description="Length at which it neither pulls nor pushes, m; by default that at the start."
    )


def spring_of(entry: SpringEntry, x: FloatArray) -> Spring:
    """The springs of a net whose nodes start at x (n, 3); raises InputError for what cannot be."""
    return Spring(
        entry.group,
        entry.stiffness,
        to=entry.to,
        anchor=entry.anchor,
        viscosity=entry.viscosity,
        rest_length=entry.rest_length,
        x=x,
    )
