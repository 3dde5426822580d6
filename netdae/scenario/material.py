"""The section [[material]] of a scenario, and the materials of cords that it makes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from netdae.core.errors import InputError
from netdae.model.material import Cords, Material
from netdae.model.net import CableNet
from netdae.scenario.groups import check_group
from netdae.scenario.problems import InSection
from netdae.scenario.section import (
    Area,
    BreakingForce,
    Density,
    LinearDensity,
    Modulus,
    Prestress,
    Section,
    Text,
    Thickness,
)
from netdae.system.prestressed import prestressed


class CordMaterial(Section):
    """What a cord is made of; named first among the bases of a section, its keys come behind those of the others."""

    youngs_modulus: Modulus = Field(description="Young's modulus, Pa.")
    density: Density | None = Field(
        None, description="Density, kg/m³, 0 for a massless cord; or give linear_density."
    )
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


CORD_KEYS = {*CordMaterial.model_fields}
"""Keys of a cord's material, which the sections [[material]], [tether] and [[closing]] have."""


class CordCables(Section):
    """Which cables a cord is, and how it is laid into them."""

    cables: Text = Field("all", description="Cable group.")
    prestress: Prestress = Field(
        0.0, description="Tension in the mesh, N, from which the rest length follows; 0 for none."
    )


class Cord(CordMaterial, CordCables):
    """What the cables of a group are made of; a later [[material]] overrides, mesh cell data override both."""


def material_of(cord: CordMaterial) -> Material:
    """The material of a cord; raises InputError for keys that are missing or given twice."""
    return Material(**cord.model_dump(include={*CORD_KEYS, "prestress"}))


def materials_of(entries: Sequence[Cord], net: CableNet, section: InSection) -> dict[str, Material]:
    """Cable group to Material; raises InputError, through `section`, for unknown groups and cables without one."""
    materials: dict[str, Material] = {}
    for number, entry in enumerate(entries):
        with section("material", number):
            check_group(net.cable_groups, entry.cables, "cable")
            materials.pop(entry.cables, None)  # a later entry overrides all before it
            materials[entry.cables] = material_of(entry)
    with section("material"):
        made = np.isin(
            np.arange(net.cable_count), np.concatenate([net.cables_of(group) for group in materials])
        )
        if not made.all():
            groups = ", ".join(
                name for name, member in net.cable_groups.items() if name != "all" and not made[member].all()
            )
            missing = f", or one for what is missing of {groups}" if groups else ""
            raise InputError(
                f"{np.count_nonzero(~made)} of {net.cable_count} cables have no material: "
                f'add an entry before the others with cables = "all"{missing}'
            )
    return materials


def thickest_of(cords: Cords) -> float:
    """Diameter of the thickest cord, m, taken as round."""
    return float(np.sqrt(4 * cords.area.max() / np.pi))


def prestressed_of(net: CableNet, materials: Mapping[str, Material], section: InSection) -> CableNet:
    """The net with the rest lengths of prestressed cables; raises InputError, through `section`, where none fits."""
    with section("material"):
        return prestressed(net, Cords.of(net, materials))
