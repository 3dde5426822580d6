"""A section of a scenario file: what all of them have in common, and the ranges of the numbers in them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Strict, Tag, model_validator
from pydantic_core import PydanticCustomError


def _none_or_above(least: float) -> Callable[[float], float]:
    """Check of a number that is zero, or `least` or more."""

    def checked(value: float) -> float:
        if 0 < value < least:
            raise PydanticCustomError("too_little", "0, or {least} or more", {"least": f"{least:g}"})
        return value

    return checked


# Ranges hold whatever a net can be, and far more; outside of them it is a slip of the finger or of the unit, and
# squares and cubes of the numbers leave what double precision holds.
Length = Annotated[float, Field(ge=1e-6, le=1e6)]  # m
Thickness = Annotated[float, Field(ge=1e-9, le=1e3)]  # m
Area = Annotated[float, Field(ge=1e-18, le=1e6)]  # m²
Modulus = Annotated[float, Field(ge=1e-3, le=1e15)]  # Pa; diamond has 1e12
Density = Annotated[float, Field(ge=0, le=1e6), AfterValidator(_none_or_above(1e-9))]  # kg/m³; osmium has 2e4
LinearDensity = Annotated[float, Field(ge=0, le=1e6), AfterValidator(_none_or_above(1e-15))]  # kg/m
BreakingForce = Annotated[float, Field(ge=1e-9, le=1e15)]  # N
Prestress = Annotated[float, Field(ge=0, le=1e15)]  # N
AirDensity = Annotated[float, Field(ge=1e-25, le=1e3)]  # kg/m³; 3e-15 at 1000 km, 1.2 at sea level
NodeMass = Annotated[float, Field(ge=0, le=1e9)]  # kg
Speed = Annotated[float, Field(ge=0, le=1e6)]  # m/s; light has 3e8, debris 1e4
DampingTime = Annotated[float, Field(ge=0, le=1e6)]  # s, a share of critical, or 1/s
Time = Annotated[float, Field(ge=-1e9, le=1e9)]  # s; 1e9 are thirty years
Tolerance = Annotated[
    float, Field(ge=1e-15, le=1e3)
]  # m or m/s; positions of metres have no digits below 1e-16
Step = Annotated[float, Field(ge=1e-12, le=1e9)]  # s
Factor = Annotated[float, Field(ge=-1e3, le=1e3)]
Component = Annotated[float, Field(ge=-1e6, le=1e6)]  # m/s, m/s², degrees
ForceComponent = Annotated[float, Field(ge=-1e12, le=1e12)]  # N
Count = Annotated[int, Field(ge=1)]
Text = Annotated[str, Field(min_length=1)]
# TOML has lists only; the numbers stay strict
Vector = Annotated[tuple[Component, Component, Component], Strict(False)]
FactorVector = Annotated[tuple[Factor, Factor, Factor], Strict(False)]
ForceVector = Annotated[tuple[ForceComponent, ForceComponent, ForceComponent], Strict(False)]


def _kind_of_instant(value: Any) -> str:
    return "<event>" if isinstance(value, str) else "<time>"


TimeOrEvent = Annotated[
    Annotated[Time, Tag("<time>")] | Annotated[Text, Tag("<event>")], Discriminator(_kind_of_instant)
]
"""A time in s, or the name of an event."""


class Section(BaseModel):
    """A table of the scenario, with unknown and missing keys given by their names."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _just_the_keys(cls, data: Any) -> Any:
        if isinstance(data, dict):
            known = list(cls.model_fields)
            for key in data:
                if key not in known:
                    raise PydanticCustomError("unknown_key", "unknown key", {"key": key, "known": known})
            for key, field in cls.model_fields.items():
                if field.is_required() and key not in data:
                    raise PydanticCustomError(
                        "missing_key", "missing key", {"key": key, "what": field.description}
                    )
        return data


def kind_of(value: Any) -> str:
    """The key `kind` of a table, by which pydantic chooses among sections."""
    kind = value.get("kind", "<none>") if isinstance(value, dict) else "<none>"
    return kind if isinstance(kind, str) else "<none>"
