"""Materials of the cords, and the damping, that the sections [[material]] and [damping] of a scenario make."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager

import numpy as np

from netdae.damping import Damping, Dashpot, NoDamping, Rayleigh
from netdae.errors import InputError
from netdae.material import Cords, Material
from netdae.net import CableNet
from netdae.scenario import schema
from netdae.scenario.groups import check_group


def materials_of(
    cords: Sequence[schema.Cord], net: CableNet, section: Callable[..., AbstractContextManager[None]]
) -> dict[str, Material]:
    """Cable group to Material; raises InputError, through `section`, for unknown groups and cables without one."""
    materials: dict[str, Material] = {}
    for number, cord in enumerate(cords):
        with section("material", number):
            check_group(net.cable_groups, cord.cables, "cable")
            materials.pop(cord.cables, None)  # a later entry overrides all before it
            materials[cord.cables] = Material(**cord.model_dump(exclude={"cables"}))
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


def thickest_of(net: CableNet, materials: Mapping[str, Material]) -> float:
    """Diameter of the thickest cord, m, taken as round."""
    area = Cords.of(net, materials).area
    return float(np.sqrt(4 * area.max() / np.pi))


def damping_of(damping: schema.Damping) -> Damping:
    """The damping of a section; raises InputError where it damps nothing but does not say so."""
    if isinstance(damping, schema.DashpotDamping):
        return Dashpot(viscosity_time=damping.viscosity_time, zeta=damping.zeta)
    if isinstance(damping, schema.RayleighDamping):
        if damping.alpha == damping.beta == 0:
            raise InputError('nothing is damped: give alpha or beta above zero, or kind = "none"')
        return Rayleigh(alpha=damping.alpha, beta=damping.beta)
    return NoDamping()
