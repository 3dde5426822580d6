"""The section [orbit] of a scenario, and the forces of the orbit's frame that it makes."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, Field, WithJsonSchema
from pydantic_core import PydanticCustomError

from netdae.core.errors import InputError
from netdae.forces import earth
from netdae.forces.orbit import Orbit
from netdae.scenario.section import Section

LOWEST, HIGHEST = earth.LOWEST_ALTITUDE, 1e9  # m; the Moon is at 3.8e8


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


class OrbitEntry(Section):
    """A circular orbit that the frame goes round with: x outward, y along the track, z along the orbit's normal."""

    altitude: Altitude | None = Field(
        None, description="Altitude above the Earth's equator, m; or give mean_motion."
    )
    mean_motion: MeanMotion | None = Field(None, description="2π over the time of one revolution, rad/s.")


def altitude_of(orbit: OrbitEntry) -> float:
    """Altitude in m; raises InputError unless just one of altitude and mean_motion is given, or under 120 km."""
    if orbit.altitude is not None and orbit.mean_motion is None:
        return orbit.altitude
    if orbit.mean_motion is not None and orbit.altitude is None:
        return earth.altitude_of(orbit.mean_motion)
    if orbit.altitude is None:
        raise InputError("neither of altitude and mean_motion is given: give one of them")
    raise InputError("both of altitude and mean_motion are given: leave one of them out")


def mean_motion_of(orbit: OrbitEntry) -> float:
    """Mean motion in rad/s; raises InputError as `altitude_of` does."""
    altitude = altitude_of(orbit)
    return earth.mean_motion(altitude) if orbit.mean_motion is None else orbit.mean_motion


def orbit_load_of(orbit: OrbitEntry) -> Orbit:
    """The forces of the orbit's frame; raises InputError as `altitude_of` does."""
    return Orbit(mean_motion_of(orbit))
