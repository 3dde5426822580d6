"""The start of shape = "equilibrium": all that flies at rest under the loads of the begin."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError, RunError
from netdae.model.restraints import Restraint, mask_of
from netdae.solvers.statics import equilibrium
from netdae.system.system import System

FAR = 100.0
"""Widths of the net beyond which a place at rest is no start: such a balance of weak forces is unstable."""


class Rest(NamedTuple):
    """Positions at rest x (n, 3), m, and what the scenario's author should know."""

    x: FloatArray
    findings: tuple[str, ...]


def at_rest(system: System, x: FloatArray, begin: float) -> Rest:
    """Where a system rests under the loads and restraints that act just after `begin`, s, sought from x (n, 3).

    Drums and a chaser that are not held are held for the search: only the net, its tether and its cords find their
    places.

    Raises InputError where nothing carries a load, or no rest is found.
    """
    after = math.nextafter(begin, math.inf)
    holding = tuple(r for r in system.restraints if r.holds(after, {}))
    still = system.during(begin, math.inf).holding((*holding, *_fixed(system, holding)))
    try:
        found = equilibrium(still, x, t=begin)
    except RunError as error:
        raise InputError(str(error)) from error
    own = system.in_space
    moved, size = float(np.abs(found.x - x)[own].max()), float(np.ptp(x[own], axis=0).max())
    if moved > FAR * size:
        raise InputError(
            f"the nearest equilibrium is {moved:.3g} m away, the net is {size:.3g} m wide: restrain a node, or take "
            "loads away that nothing carries"
        )
    if not found.mechanisms:
        return Rest(found.x, ())
    node = found.mechanisms[0].nodes[0]
    return Rest(
        found.x,
        (
            f"[initial]: at rest {found.zero_modes} motions have no stiffness, first of node {node} along "
            f"{found.mechanisms[0].axes}: no tension holds them, and they could equally rest elsewhere",
        ),
    )


def _fixed(system: System, holding: Sequence[Restraint]) -> list[Restraint]:
    """Restraints of the axes of drums and chaser that nothing holds."""
    free = ~mask_of(tuple(holding), system.net)
    nodes = [*(reel.node for reel in system.reels), *system.net.node_groups.get("chaser", ())]
    axes = {int(node): "".join(np.array(list("xyz"))[free[node]]) for node in nodes}
    return [Restraint((node,), axes=names) for node, names in axes.items() if names]
