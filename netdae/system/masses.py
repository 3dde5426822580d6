"""The lumped masses of a net: half of each cable at its two ends by Eq. (7), bullets, drums."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.model.material import Cords
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint, mask_of
from netdae.system.reels import Reel


def lumped_masses(
    net: CableNet, cords: Cords, masses: Mapping[str, float], reels: Sequence[Reel] = ()
) -> FloatArray:
    """Knots, ½ ρ̄L̄Ā from each cable by Eq. (7), bullets and drums, (n,), kg.

    masses : node group to what each of its nodes carries besides its cables, kg

    Raises InputError for an unknown group or a mass that is negative or not finite.
    """
    half = 0.5 * cords.linear_density * net.rest_length
    mass = np.zeros(net.node_count)
    np.add.at(mass, net.cables.ravel(), np.repeat(half, 2))
    for group, value in masses.items():
        if not (math.isfinite(value) and value >= 0):
            raise InputError(f"mass of group {group!r} is {value:g} kg: give a finite number, zero or more")
        mass[net.nodes_of(group)] += value
    drums = [reel.node for reel in reels]
    mass[drums] = [reel.inertia for reel in reels]
    return mass


def check_free_nodes(mass: FloatArray, net: CableNet, restraints: Sequence[Restraint]) -> None:
    """Raise InputError for a node without mass, of the masses (n,), that is not always held."""
    always = mask_of(tuple(r for r in restraints if r.permanent), net)
    bare = np.flatnonzero((mass <= 0) & ~always.all(axis=1))
    if len(bare):
        if (net.cables == bare[0]).any():
            why, join = "its cables have none and no bullet sits on it", "give its cables a density"
        else:
            why, join = "no cable ends there and no bullet sits on it", "join it to the net"
        raise InputError(
            f"node {bare[0]} is free but has no mass: {why}; "
            f"give its group a mass, {join}, or restrain all its axes"
        )
