"""Values of a scenario that are told by numbers or by a table."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from netdae.scenario.section import AirDensity, ForceVector, Section, Text, Vector


class TableFile(Section):
    """A CSV table with the header t,x,y,z; times in s, rising."""

    file: Text = Field(description="CSV file with the header t,x,y,z.")
    interpolation: Literal["linear", "cubic"] = Field("linear", description="Curve through the rows.")


class MotionFile(Section):
    """A CSV table with the header t,x,y,z or t,x,y,z,vx,vy,vz: displacements in m from where the nodes start."""

    file: Text = Field(description="CSV file with the header t,x,y,z or t,x,y,z,vx,vy,vz.")
    interpolation: Literal["linear", "cubic"] = Field("cubic", description="Curve through the rows.")


class DensityFile(Section):
    """A CSV table with the header altitude,density; altitudes in m, rising, densities in kg/m³."""

    file: Text = Field(description="CSV file with the header altitude,density.")


def _kind_of_table(value: Any) -> str:
    return "<table>" if isinstance(value, dict) else "<value>"


Vector3OrTable = Annotated[
    Annotated[Vector, Tag("<value>")] | Annotated[TableFile, Tag("<table>")], Discriminator(_kind_of_table)
]
ForceOrTable = Annotated[
    Annotated[ForceVector, Tag("<value>")] | Annotated[TableFile, Tag("<table>")],
    Discriminator(_kind_of_table),
]
FixedOrTable = Annotated[
    Annotated[Literal["fixed"], Tag("<value>")] | Annotated[MotionFile, Tag("<table>")],
    Discriminator(_kind_of_table),
]
DensityOrTable = Annotated[
    Annotated[AirDensity, Tag("<value>")] | Annotated[DensityFile, Tag("<table>")],
    Discriminator(_kind_of_table),
]
