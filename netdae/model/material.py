"""Material of a cord, and the cords of all cables of a net.

Symbols: E Young's modulus, ρ̄ density, Ā cross-section, L̄ rest length, ε toe strain.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass, fields
from numbers import Real
from typing import Literal

import numpy as np

from netdae.core.arrays import BoolArray, FloatArray, frozen_floats
from netdae.core.errors import InputError
from netdae.model.net import CableNet

Law = Literal["st_venant_kirchhoff", "engineering"]
_SMALLEST = sys.float_info.min  # numbers below lose digits
LAWS: tuple[Law, ...] = ("st_venant_kirchhoff", "engineering")
_ZERO_OR_MORE = ("toe_strain", "prestress", "density", "linear_density")


@dataclass(frozen=True)
class Material:
    """A cord: stiffness, mass and strength per cross-section.

    youngs_modulus : E, Pa
    density : ρ̄, kg/m³; or linear_density : ρ̄Ā, kg/m; zero for a massless cord between nodes that have masses
    diameter : m; or area : Ā, m²
    toe_strain : ε, the strain up to which the stress rises quadratically, see `forces.cables`
    law : "st_venant_kirchhoff", Eq. (4), or "engineering", N = EĀ (L/L̄ − 1)
    strength : breaking force, N; None where it is not known
    prestress : T₀, N, the tension of each cable in the reference configuration, see `system.prestressed`

    Raises InputError for values that are missing, given twice, not numbers or out of range.
    """

    youngs_modulus: float
    density: float | None = None
    diameter: float | None = None
    linear_density: float | None = None
    area: float | None = None
    toe_strain: float = 0.0
    law: Law = "st_venant_kirchhoff"
    strength: float | None = None
    prestress: float = 0.0

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if each.name == "law" or (value is None and each.default is None):
                continue
            bound = "zero or more" if each.name in _ZERO_OR_MORE else "above zero"
            if not isinstance(value, Real):
                raise InputError(f"material: {each.name} is {value!r}: give a finite number {bound}")
            number = float(value)
            high_enough = number >= 0 if each.name in _ZERO_OR_MORE else number > 0
            if not (math.isfinite(number) and high_enough):
                raise InputError(f"material: {each.name} is {number:g}: give a finite number {bound}")
        if self.law not in LAWS:
            raise InputError(f"material: law is {self.law!r}: choose one of {', '.join(LAWS)}")
        _just_one("density", self.density, "linear_density", self.linear_density)
        _just_one("diameter", self.diameter, "area", self.area)
        area = self.cross_section
        per_length = area * self.density if self.linear_density is None else self.linear_density  # type: ignore[operator]
        for name, value, unit in (
            ("cross-section", area, "m²"),
            ("linear density", per_length, "kg/m"),
            ("axial stiffness", self.youngs_modulus * area, "N"),
        ):
            massless = name == "linear density" and 0 in (self.density, self.linear_density)
            if not (massless or _SMALLEST <= value < math.inf):
                raise InputError(
                    f"material: the {name} comes out as {value:g} {unit}: look at the units of diameter or area, "
                    "density and youngs_modulus"
                )

    @property
    def cross_section(self) -> float:
        """Ā, m²."""
        return self.area if self.area is not None else math.pi * self.diameter * self.diameter / 4  # type: ignore[operator]


def _just_one(first: str, one: float | None, second: str, other: float | None) -> None:
    if (one is None) == (other is None):
        if one is None:
            raise InputError(f"material: neither of {first} and {second} is given: give one of them")
        raise InputError(f"material: both of {first} and {second} are given: leave one of them out")


@dataclass(frozen=True, eq=False)
class Cords:
    """What every cable is made of, as arrays (m,).

    axial_stiffness : EĀ, N
    linear_density : ρ̄Ā, kg/m
    area : Ā, m²
    toe_strain : ε
    engineering : True where the law is the linear spring
    strength : N, infinite where it is not known
    prestress : T₀, N

    A linear_density of the material holds whatever the net's own diameter or area; only the net's density overrides it.
    """

    axial_stiffness: FloatArray
    linear_density: FloatArray
    area: FloatArray
    toe_strain: FloatArray
    engineering: BoolArray
    strength: FloatArray
    prestress: FloatArray

    @classmethod
    def of(cls, net: CableNet, materials: Material | Mapping[str, Material]) -> Cords:
        """Cords of a net from one Material, or from a mapping of cable group to Material, where later ones override.

        The net's `cable_data` override the materials cable by cable.
        Raises InputError where a cable has no material.
        """
        by_group = {"all": materials} if isinstance(materials, Material) else dict(materials)
        m = net.cable_count
        modulus, density, per_length, area, toe, prestress = (np.full(m, np.nan) for _ in range(6))
        strength = np.full(m, np.inf)
        engineering = np.zeros(m, dtype=np.bool_)
        for group, material in by_group.items():
            cables = net.cables_of(group)
            modulus[cables] = material.youngs_modulus
            density[cables] = np.nan if material.density is None else material.density
            per_length[cables] = np.nan if material.linear_density is None else material.linear_density
            area[cables] = material.cross_section
            toe[cables] = material.toe_strain
            prestress[cables] = material.prestress
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
        with np.errstate(over="ignore"):
            if "diameter" in data:
                area = _overridden(area, np.pi * data["diameter"] ** 2 / 4)
            area = _overridden(area, data.get("area"))
            per_length = np.where(np.isnan(density), per_length, density * area)
            axial_stiffness = modulus * area
        massless = np.where(np.isnan(density), per_length, density) == 0
        _check_range("axial stiffness", axial_stiffness, "N")
        _check_range("linear density", np.where(massless, 1.0, per_length), "kg/m")
        engineering.flags.writeable = False
        return cls(
            frozen_floats(axial_stiffness),
            frozen_floats(per_length),
            frozen_floats(area),
            frozen_floats(toe),
            engineering,
            frozen_floats(strength),
            frozen_floats(_overridden(prestress, data.get("prestress"))),
        )


def _check_range(name: str, values: FloatArray, unit: str) -> None:
    wrong = np.flatnonzero(~((values >= _SMALLEST) & (values < np.inf)))
    if len(wrong):
        raise InputError(
            f"cable {wrong[0]} has the {name} {values[wrong[0]]:g} {unit}: look at the units of its diameter or area, "
            "density and youngs_modulus"
        )


def _overridden(values: FloatArray, data: FloatArray | None) -> FloatArray:
    return values if data is None else np.where(np.isnan(data), values, data)
