"""Material of a cord, and the cords of all cables of a net.

Symbols: E Young's modulus, ρ̄ density, Ā cross-section, L̄ rest length, ε toe strain.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Literal

import numpy as np

from netdae._arrays import BoolArray, FloatArray, frozen_floats
from netdae.errors import InputError
from netdae.net import CableNet

Law = Literal["st_venant_kirchhoff", "engineering"]
LAWS: tuple[Law, ...] = ("st_venant_kirchhoff", "engineering")


@dataclass(frozen=True)
class Material:
    """A cord: stiffness, mass and strength per cross-section.

    youngs_modulus : E, Pa
    density : ρ̄, kg/m³; or linear_density : ρ̄Ā, kg/m
    diameter : m; or area : Ā, m²
    toe_strain : ε, the strain up to which the stress rises quadratically, see `forces.cables`
    law : "st_venant_kirchhoff", Eq. (4), or "engineering", N = EĀ (L/L̄ − 1)
    strength : breaking force, N; None where it is not known

    Raises InputError for values that are missing, given twice, not finite or out of range.
    """

    youngs_modulus: float
    density: float | None = None
    diameter: float | None = None
    linear_density: float | None = None
    area: float | None = None
    toe_strain: float = 0.0
    law: Law = "st_venant_kirchhoff"
    strength: float | None = None

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if each.name == "law" or value is None:
                continue
            low_enough = value >= 0 if each.name == "toe_strain" else value > 0
            if not (math.isfinite(value) and low_enough):
                bound = "zero or more" if each.name == "toe_strain" else "above zero"
                raise InputError(f"material: {each.name} is {value:g}: give a finite number {bound}")
        if self.law not in LAWS:
            raise InputError(f"material: law is {self.law!r}: choose one of {', '.join(LAWS)}")
        _just_one("density", self.density, "linear_density", self.linear_density)
        _just_one("diameter", self.diameter, "area", self.area)

    @property
    def cross_section(self) -> float:
        """Ā, m²."""
        return self.area if self.area is not None else math.pi * self.diameter**2 / 4  # type: ignore[operator]

    @property
    def mass_density(self) -> float:
        """ρ̄, kg/m³."""
        return self.density if self.density is not None else self.linear_density / self.cross_section  # type: ignore[operator]


def _just_one(first: str, one: float | None, second: str, other: float | None) -> None:
    if (one is None) == (other is None):
        found = "neither" if one is None else "both"
        raise InputError(f"material: {found} of {first} and {second} is given: give just one of them")


@dataclass(frozen=True, eq=False)
class Cords:
    """What every cable is made of, as arrays (m,).

    axial_stiffness : EĀ, N
    linear_density : ρ̄Ā, kg/m
    area : Ā, m²
    toe_strain : ε
    engineering : True where the law is the linear spring
    strength : N, infinite where it is not known
    """

    axial_stiffness: FloatArray
    linear_density: FloatArray
    area: FloatArray
    toe_strain: FloatArray
    engineering: BoolArray
    strength: FloatArray

    @classmethod
    def of(cls, net: CableNet, materials: Material | Mapping[str, Material]) -> Cords:
        """Cords of a net from one Material, or from cable group to Material, a later one overriding.

        The net's `cable_data` override the materials cable by cable.
        Raises InputError where a cable has no material.
        """
        by_group = {"all": materials} if isinstance(materials, Material) else dict(materials)
        m = net.cable_count
        modulus, density, area, toe = (np.full(m, np.nan) for _ in range(4))
        strength = np.full(m, np.inf)
        engineering = np.zeros(m, dtype=np.bool_)
        for group, material in by_group.items():
            cables = net.cables_of(group)
            modulus[cables] = material.youngs_modulus
            density[cables] = material.mass_density
            area[cables] = material.cross_section
            toe[cables] = material.toe_strain
            engineering[cables] = material.law == "engineering"
            strength[cables] = np.inf if material.strength is None else material.strength
        bare = np.flatnonzero(np.isnan(toe))
        if len(bare):
            raise InputError(
                f"cable {bare[0]} ({len(bare)} in all) has no material: give one for the cable group 'all' first"
            )
        data = net.cable_data
        modulus = _overridden(modulus, data.get("youngs_modulus"))
        density = _overridden(density, data.get("density"))
        if "diameter" in data:
            area = _overridden(area, np.pi * data["diameter"] ** 2 / 4)
        area = _overridden(area, data.get("area"))
        engineering.flags.writeable = False
        return cls(
            frozen_floats(modulus * area),
            frozen_floats(density * area),
            frozen_floats(area),
            frozen_floats(toe),
            engineering,
            frozen_floats(strength),
        )


def _overridden(values: FloatArray, data: FloatArray | None) -> FloatArray:
    return values if data is None else np.where(np.isnan(data), values, data)
