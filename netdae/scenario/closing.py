"""What may stand in the sections [[closing]] of a scenario file: winches and drawcords that close the net."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from netdae.scenario.section import (
    Area,
    BreakingForce,
    Density,
    Length,
    LinearDensity,
    Modulus,
    Section,
    Text,
    Thickness,
    TimeOrEvent,
    kind_of,
)

ReelSpeed = Annotated[float, Field(gt=0, le=1e6)]  # m/s
MotorForce = Annotated[float, Field(gt=0, le=1e12)]  # N
Inertia = Annotated[float, Field(gt=0, le=1e9)]  # kg
FrictionCoefficient = Annotated[float, Field(ge=0, le=100)]
NodeNumber = Annotated[int, Field(ge=0)]


def _kind_of_rings(value: Any) -> str:
    return "<list>" if isinstance(value, list) else "<group>"


GroupOrList = Annotated[
    Annotated[Text, Tag("<group>")] | Annotated[list[NodeNumber], Tag("<list>")],
    Discriminator(_kind_of_rings),
]


class HauledCord(Section):
    """What winches and drawcords have in common: a cord that a motor winds in."""

    speed: ReelSpeed = Field(description="Speed at which the motor winds in, m/s.")
    force: MotorForce = Field(description="The most that the motor pulls with, N.")
    final_length: Length = Field(description="Rest length at which it ends, m.")
    begin: TimeOrEvent | None = Field(
        None, description="Time in s, or name of an event, at which it begins; the start by default."
    )
    hold: TimeOrEvent | None = Field(
        None, description="Time in s, or name of an event, at which the drum is locked for good."
    )
    length: Length | None = Field(
        None, description="Rest length before, m; its way through the mesh by default."
    )
    drum_inertia: Inertia | None = Field(
        None, description="Moment of inertia of the drum over its radius squared, kg; force · 0.01 s / speed."
    )
    youngs_modulus: Modulus = Field(description="Young's modulus, Pa.")
    density: Density | None = Field(None, description="Density, kg/m³; or give linear_density.")
    linear_density: LinearDensity | None = Field(None, description="Mass per length, kg/m.")
    diameter: Thickness | None = Field(None, description="Diameter, m; or give area.")
    area: Area | None = Field(None, description="Cross-section, m².")
    toe_strain: Annotated[float, Field(ge=0, le=10)] = Field(
        0.0, description="Strain up to which the stress rises quadratically."
    )
    law: Literal["st_venant_kirchhoff", "engineering"] = Field(
        "st_venant_kirchhoff", description="Stress over Green-Lagrange strain, or force over elongation."
    )
    strength: BreakingForce | None = Field(None, description="Breaking force, N.")


class WinchEntry(HauledCord):
    """Winches that draw each node of a group to its partner in another."""

    kind: Literal["winch"] = Field(description="Kind of closing.")
    first: GroupOrList = Field(description="Node group at the one end, or node numbers in order.")
    second: GroupOrList = Field(
        description="As many nodes at the other end; groups are paired in the order of their node numbers."
    )


class DrawcordEntry(HauledCord):
    """One cord through rings at several nodes."""

    kind: Literal["drawcord"] = Field(description="Kind of closing.")
    rings: GroupOrList = Field(
        description="Node group, in the order in which a closed loop of cables passes it; or node numbers in order."
    )
    loop: Text | None = Field(
        None, description="Group of the loop that passes the rings; by default the group of the rings itself."
    )
    closed: bool = Field(True, description="Whether the cord comes back to its first ring.")
    fastened: bool | None = Field(
        None,
        description="Whether the cord's end is tied; by default an open one is, a closed one has both wound in.",
    )
    friction: FrictionCoefficient = Field(
        0.0, description="Coefficient of friction at the rings, by the capstan rule."
    )
    ring_size: Length = Field(1e-3, description="Least length of cord from one ring to the next, m.")


ClosingEntry = Annotated[
    Annotated[WinchEntry, Tag("winch")] | Annotated[DrawcordEntry, Tag("drawcord")], Discriminator(kind_of)
]
