"""What may stand in the section [tether] of a scenario file: the cord from the net to its chaser, and its reel."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from netdae.scenario.section import (
    Area,
    BreakingForce,
    Count,
    Density,
    Length,
    LinearDensity,
    Modulus,
    NodeMass,
    Section,
    Text,
    Thickness,
    TimeOrEvent,
    Vector,
)
from netdae.scenario.tables import MotionFile

Slack = Annotated[float, Field(ge=0, le=1e3)]
BrakeForce = Annotated[float, Field(ge=0, le=1e12)]  # N


class PayoutFile(Section):
    """A CSV table with the header t,paid_out or t,paid_out,rate: the length paid out in m, zero at the start."""

    file: Text = Field(description="CSV file with the header t,paid_out or t,paid_out,rate.")
    interpolation: Literal["linear", "cubic"] = Field("cubic", description="Curve through the rows.")


def _kind_of_table(value: Any) -> str:
    return "<table>" if isinstance(value, dict) else "<value>"


FreeFixedOrTable = Annotated[
    Annotated[Literal["free", "fixed"], Tag("<value>")] | Annotated[MotionFile, Tag("<table>")],
    Discriminator(_kind_of_table),
]
PayoutOrTable = Annotated[
    Annotated[Literal["locked", "free", "braked"], Tag("<value>")] | Annotated[PayoutFile, Tag("<table>")],
    Discriminator(_kind_of_table),
]


class ChaserEntry(Section):
    """The spacecraft, or the stand, at the other end of the tether."""

    position: Vector = Field(description="Place at the start, m; rotation_deg does not turn it.")
    velocity: Vector = Field((0.0, 0.0, 0.0), description="Velocity at the start of a free chaser, m/s.")
    mass: NodeMass = Field(0.0, description="Mass, kg; a free chaser needs one.")
    motion: FreeFixedOrTable = Field(
        "free", description='"free", "fixed", or a table of displacements from the start, m.'
    )


class TetherEntry(Section):
    """A cord from a node, or by a bridle from several nodes, of the net to its chaser."""

    group: Text = Field(description="Node group of the net that it is tied to.")
    chaser: ChaserEntry = Field(description="What it ends at.")
    elements: Count = Field(description="Cables that it is cut into.")
    length: Length | None = Field(None, description="Rest length at the start, m; or give slack.")
    slack: Slack | None = Field(
        None, description="Share by which the rest length exceeds the way at the start."
    )
    bridle: Length | None = Field(
        None, description="Rest length of the leg to each node of a group of several, m."
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
    payout: PayoutOrTable = Field(
        "locked", description='"locked", "free", "braked", or a table of the length paid out, m.'
    )
    brake_force: BrakeForce = Field(0.0, description="Dry friction of the reel, N, where it is braked.")
    ratchet: bool = Field(False, description="Whether a braked reel lets nothing wind back.")
    drum_inertia: NodeMass = Field(
        0.0, description="Moment of inertia of the drum over its radius squared, kg."
    )
    longest: Length | None = Field(None, description="Rest length at which the drum is empty, m.")
    begin: TimeOrEvent | None = Field(
        None, description="Time in s, or name of an event, at which the reel is let go; the start by default."
    )
    lock: TimeOrEvent | None = Field(
        None, description="Time in s, or name of an event, at which the reel is locked."
    )
