"""Loads p(t): forces on nodes and uniform gravity, constant or changing with time.

A load is given by group and Signal; `on(net, cords, mass)` binds it to the nodes of a net.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from netdae.core.arrays import FloatArray, IntArray, Reals
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.forces.law import Law, Shares, compiled, no_bound
from netdae.model.material import Cords
from netdae.model.net import CableNet
from netdae.model.signals import Signal, signal_of


class Load(Protocol):
    """What System requires of a load."""

    def on(self, net: CableNet, cords: Cords, mass: FloatArray) -> Force:
        """The load as a force on a net of these cords whose nodes have `mass` (n,), kg."""
        ...


@dataclass(frozen=True, eq=False)
class NodalLoad:
    """The same force in N on every node of a group.

    force : three numbers, a Signal, or a smooth function of t; a function with jumps is given as
        `signals.Function` with the jumps declared.
    """

    group: str
    force: Signal | ArrayLike | Callable[[float], ArrayLike]

    def on(self, net: CableNet, cords: Cords, mass: FloatArray) -> Force:
        """Bound to the group's nodes; raises InputError for an unknown group."""
        nodes = net.nodes_of(self.group)
        return uniform_load(nodes, np.ones(len(nodes)), signal_of(self.force))


@dataclass(frozen=True, eq=False)
class Gravity:
    """Uniform gravity g in m/s²: three numbers, a Signal or a smooth function of t."""

    g: Signal | ArrayLike | Callable[[float], ArrayLike]

    def on(self, net: CableNet, cords: Cords, mass: FloatArray) -> Force:
        """Bound to all nodes, each with its mass."""
        return uniform_load(np.arange(net.node_count), mass, signal_of(self.g))


class UniformLoad(NamedTuple):
    """Parameters of f = weight · s on each node, s the signal."""

    weight: Reals  # (m,)


@compiled
def _force(p: UniformLoad, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    for c in range(3):
        f.external[0, c] = p.weight[e] * s[c]
    return True


UNIFORM_LOAD = Law(
    UniformLoad,
    force=_force,
    nodes=1,
    shares=("external",),
    external=True,
    newton="nothing",
    bound=no_bound,
)


def uniform_load(nodes: IntArray, weight: FloatArray, signal: Signal) -> ElementForce:
    """f = weight · signal(t) on each of some nodes (m,); weight (m,)."""
    return ElementForce(UNIFORM_LOAD, nodes[:, None], UniformLoad(weight), signal)
