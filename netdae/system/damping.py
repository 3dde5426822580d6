"""Choices of damping: the objective dashpot, Rayleigh damping, none.

Each defines the viscosity time τ (m,) of the cables and any further forces.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.forces.rayleigh import MASS_DAMPING, STIFFNESS_DAMPING, MassDamping, StiffnessDamping
from netdae.model.material import Cords
from netdae.model.net import CableNet


class Damping(Protocol):
    """What System requires of a damping."""

    def viscosity_times(self, net: CableNet, cords: Cords) -> FloatArray:
        """τ of every cable, (m,), s."""
        ...

    def forces(self, net: CableNet, cords: Cords, mass: FloatArray) -> list[Force]:
        """Damping forces besides the dashpot."""
        ...


@dataclass(frozen=True)
class NoDamping:
    """No damping at all: energy is lost in the integrator only."""

    def viscosity_times(self, net: CableNet, cords: Cords) -> FloatArray:
        """Zero for every cable."""
        return np.zeros(net.cable_count)

    def forces(self, net: CableNet, cords: Cords, mass: FloatArray) -> list[Force]:
        """None."""
        return []


@dataclass(frozen=True)
class Dashpot:
    """A damper along each taut cable: it turns with the net and never pushes.

    viscosity_time : τ, s: the stress gains τ E Ė11; or
    zeta : ζ, share of critical of the cable's own axial mode, two lumps m/2 on a spring k:
        c = ζ√(k m) = τ k with m = ρ̄ĀL̄ and k = EĀ/L̄, so τ = ζ L̄ √(ρ̄/E).
        Much of the literature writes c = 2ζ√(k m), twice this.
    """

    viscosity_time: float | None = None
    zeta: float | None = None

    def __post_init__(self) -> None:
        if (self.viscosity_time is None) == (self.zeta is None):
            raise InputError("dashpot: give just one of viscosity_time and zeta")
        name, value = (
            ("zeta", self.zeta) if self.viscosity_time is None else ("viscosity_time", self.viscosity_time)
        )
        _check_not_negative("dashpot", name, value)

    def viscosity_times(self, net: CableNet, cords: Cords) -> FloatArray:
        """τ of every cable, (m,), s."""
        if self.viscosity_time is not None:
            return np.full(net.cable_count, self.viscosity_time)
        assert self.zeta is not None
        if self.zeta > 0 and (cords.linear_density == 0).any():
            raise InputError(
                f"dashpot: cable {int(np.argmin(cords.linear_density))} has no mass, so no share of critical damping "
                "is known: give a viscosity_time in place of zeta"
            )
        return self.zeta * net.rest_length * np.sqrt(cords.linear_density / cords.axial_stiffness)

    def forces(self, net: CableNet, cords: Cords, mass: FloatArray) -> list[Force]:
        """None: the dashpot is part of the cable's own stress."""
        return []


@dataclass(frozen=True)
class Rayleigh:
    """Eq. (9): D = α M + β T(x̄), with `alpha` in 1/s and `beta` in s."""

    alpha: float = 0.0
    beta: float = 0.0

    def __post_init__(self) -> None:
        _check_not_negative("rayleigh", "alpha", self.alpha)
        _check_not_negative("rayleigh", "beta", self.beta)

    def viscosity_times(self, net: CableNet, cords: Cords) -> FloatArray:
        """Zero for every cable."""
        return np.zeros(net.cable_count)

    def forces(self, net: CableNet, cords: Cords, mass: FloatArray) -> list[Force]:
        """The two terms of Eq. (9); raises InputError where a cable has no direction in x̄."""
        span = net.spans
        length = np.linalg.norm(span, axis=1)
        if (length == 0).any():
            raise InputError(
                f"rayleigh: cable {int(np.argmin(length))} has no direction, its nodes coincide in the mesh: "
                "Eq. (9) needs the spread net as reference; or use the dashpot"
            )
        n = span / length[:, None]
        terms: list[Force] = []
        if self.beta > 0:
            viscosity = self.beta * cords.axial_stiffness / net.rest_length
            along = StiffnessDamping(np.sqrt(viscosity)[:, None] * n)
            terms.append(ElementForce(STIFFNESS_DAMPING, net.cables, along))
        if self.alpha > 0:
            nodes = np.arange(net.node_count)[:, None]
            terms.append(ElementForce(MASS_DAMPING, nodes, MassDamping(self.alpha * mass)))
        return terms


def check_damping(damping: Damping, *, slides: bool) -> None:
    """Raise InputError for an object that is no damping, and for one that a drawcord cannot have."""
    if not hasattr(damping, "viscosity_times"):
        raise InputError(f"damping is {damping!r}: give a Dashpot, Rayleigh, or NoDamping() for none")
    if slides and isinstance(damping, Rayleigh) and damping.beta > 0:
        raise InputError(
            "rayleigh: beta holds a cord through rings, which has to slide: use the dashpot, or beta = 0"
        )


def _check_not_negative(kind: str, name: str, value: float | None) -> None:
    if value is None or not (math.isfinite(value) and value >= 0):
        raise InputError(f"{kind}: {name} is {value}: give a finite number, zero or more")
