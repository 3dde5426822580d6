"""The section [damping] of a scenario, and the damping that it makes."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from netdae.core.errors import InputError
from netdae.scenario.section import DampingTime, Section, kind_of
from netdae.system.damping import Damping, Dashpot, NoDamping, Rayleigh


class DashpotDamping(Section):
    """A damper along each taut cable."""

    kind: Literal["dashpot"] = Field(description="Kind of damping.")
    viscosity_time: DampingTime | None = Field(None, description="Viscosity over Young's modulus, s.")
    zeta: DampingTime | None = Field(None, description="Share of critical of a cable's own axial mode.")


class RayleighDamping(Section):
    """D = α M + β T(x̄); it also damps rigid rotations of the net."""

    kind: Literal["rayleigh"] = Field(description="Kind of damping.")
    alpha: DampingTime = Field(0.0, description="Factor of the mass matrix, 1/s.")
    beta: DampingTime = Field(0.0, description="Factor of the tangent stiffness of the reference, s.")


class WithoutDamping(Section):
    """No damping."""

    kind: Literal["none"] = Field(description="Kind of damping.")


DampingEntry = Annotated[
    Annotated[DashpotDamping, Tag("dashpot")]
    | Annotated[RayleighDamping, Tag("rayleigh")]
    | Annotated[WithoutDamping, Tag("none")],
    Discriminator(kind_of),
]


def damping_of(entry: DampingEntry) -> Damping:
    """The damping of an entry; raises InputError where it damps nothing but does not say so."""
    if isinstance(entry, DashpotDamping):
        return Dashpot(viscosity_time=entry.viscosity_time, zeta=entry.zeta)
    if isinstance(entry, RayleighDamping):
        if entry.alpha == entry.beta == 0:
            raise InputError('nothing is damped: give alpha or beta above zero, or kind = "none"')
        return Rayleigh(alpha=entry.alpha, beta=entry.beta)
    return NoDamping()
