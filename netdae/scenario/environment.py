"""What may stand in a scenario file about orbit, thin and dense air and sunlight: [orbit] and kinds of [[loads]]."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, WithJsonSchema
from pydantic_core import PydanticCustomError

from netdae.earth import LOWEST_ALTITUDE
from netdae.scenario.section import AirDensity, Area, FactorVector, Section, Text, Thickness, Time, Vector
from netdae.scenario.tables import DensityOrTable, Vector3OrTable

LOWEST, HIGHEST = LOWEST_ALTITUDE, 1e9  # m; the Moon is at 3.8e8


def _check_altitude(value: float) -> float:
    if not LOWEST <= value <= HIGHEST:
        raise PydanticCustomError(
            "altitude",
            "120e3 to 1e9, in m above the Earth: lower down the air ends an orbit within one revolution",
        )
    return value


Altitude = Annotated[
    float,
    AfterValidator(_check_altitude),
    WithJsonSchema({"type": "number", "minimum": LOWEST, "maximum": HIGHEST}),
]
MeanMotion = Annotated[float, Field(gt=0, le=1e-2)]  # rad/s; 1.2e-3 at 120 km is the fastest about the Earth
Coefficient = Annotated[float, Field(ge=1e-6, le=100)]
LightPressure = Annotated[float, Field(ge=1e-12, le=1)]  # N/m²; 4.5e-6 at 1 AU, 0.2 at the Sun's surface

NO_CABLES = "none"
"""What `cables` says where a load acts on bodies alone."""


class OrbitEntry(Section):
    """A circular orbit that the frame goes round with: x outward, y along the track, z along the orbit's normal."""

    altitude: Altitude | None = Field(
        None, description="Altitude above the Earth's equator, m; or give mean_motion."
    )
    mean_motion: MeanMotion | None = Field(None, description="2π over the time of one revolution, rad/s.")


class Body(Section):
    """Bullets or other bodies at the nodes of a group, as the stream or the light sees them."""

    group: Text = Field(description="Node group.")
    area: Area | None = Field(None, description="Area that each body shows, m²; or give diameter.")
    diameter: Thickness | None = Field(None, description="Diameter of a sphere, m.")


class BodyInAir(Body):
    """Bullets or other bodies at the nodes of a group, in dense air."""

    drag_coefficient: Coefficient = Field(0.47, description="Drag coefficient; 0.47 is a sphere's.")


class DragEntry(Section):
    """Drag in orbit, where molecules come singly."""

    kind: Literal["drag"] = Field(description="Kind of load.")
    density: DensityOrTable | None = Field(
        None,
        description="Density of the air, kg/m³, or a table of it over altitude; by default an exponential "
        "atmosphere. Both are taken at the altitude of [orbit].",
    )
    stream: Vector | None = Field(
        None,
        description="Velocity of the air in the net's frame, m/s; by default that of air at rest about the Earth, "
        "seen from [orbit].",
    )
    drag_coefficient: Coefficient = Field(2.2, description="Drag coefficient of cables and bodies.")
    cables: Text = Field("all", description='Cable group; "none" for bodies alone.')
    diameter: Thickness | None = Field(
        None, description="Diameter of the cables in the stream, m; by default that of their cross-section."
    )
    bodies: list[Body] = Field([], description="Bullets and other bodies in the stream.")


class SolarPressureEntry(Section):
    """Pressure of sunlight."""

    kind: Literal["solar_pressure"] = Field(description="Kind of load.")
    sun: FactorVector = Field(
        description="Direction towards the Sun at the start, of any length; with [orbit] it turns with the frame."
    )
    pressure: LightPressure | None = Field(
        None, description="Pressure on what swallows the light, N/m²; by default that at 1 AU."
    )
    coefficient: Annotated[float, Field(ge=1e-6, le=2)] = Field(
        1.3,
        description="Share of the pressure that acts: 1 for black, 1.3 for a shining cord, 1.5 for white.",
    )
    cables: Text = Field("all", description='Cable group; "none" for bodies alone.')
    diameter: Thickness | None = Field(
        None, description="Diameter of the cables in the light, m; by default that of their cross-section."
    )
    bodies: list[Body] = Field([], description="Bullets and other bodies in the light.")
    begin: Time | None = Field(None, description="Time at which the light sets in, s; the start by default.")
    end: Time | None = Field(None, description="Time at which the shadow sets in, s; never by default.")


class AirEntry(Section):
    """Drag in dense air."""

    kind: Literal["air"] = Field(description="Kind of load.")
    density: AirDensity = Field(1.225, description="Density of the air, kg/m³; 1.225 is that at sea level.")
    normal_coefficient: Coefficient = Field(
        1.1, description="Drag coefficient of cables across the wind, on diameter times length."
    )
    tangential_coefficient: Annotated[float, Field(ge=0, le=10)] = Field(
        0.01, description="Friction coefficient of cables along the wind, on their whole surface."
    )
    wind: Vector3OrTable = Field((0.0, 0.0, 0.0), description="Velocity of the air, m/s, or a table of it.")
    cables: Text = Field("all", description='Cable group; "none" for bodies alone.')
    diameter: Thickness | None = Field(
        None, description="Diameter of the cables in the wind, m; by default that of their cross-section."
    )
    bodies: list[BodyInAir] = Field([], description="Bullets and other bodies in the air.")
    begin: Time | None = Field(
        None, description="Time at which a constant wind sets in, s; the start by default."
    )
    end: Time | None = Field(None, description="Time at which a constant wind ends, s; never by default.")


EnvironmentLoad = DragEntry | SolarPressureEntry | AirEntry
