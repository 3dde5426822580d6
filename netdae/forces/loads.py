"""Loads p(t): forces on nodes and uniform gravity, constant or changing with time.

A load is told by group and Signal; `on(net, cords, mass)` binds it to the nodes of a net.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from netdae._arrays import FloatArray, IntArray
from netdae.forces.protocol import Account, Force, NewtonPart, Tangent
from netdae.material import Cords
from netdae.net import CableNet
from netdae.signals import Signal, signal_of


class Load(Protocol):
    """What System asks of a load."""

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
        return UniformLoad(nodes[:, None], np.ones(len(nodes)), signal_of(self.force))


@dataclass(frozen=True, eq=False)
class Gravity:
    """Uniform gravity g in m/s²: three numbers, a Signal or a smooth function of t."""

    g: Signal | ArrayLike | Callable[[float], ArrayLike]

    def on(self, net: CableNet, cords: Cords, mass: FloatArray) -> Force:
        """Bound to all nodes, each with its mass."""
        return UniformLoad(np.arange(net.node_count)[:, None], mass, signal_of(self.g))


@dataclass(frozen=True, eq=False)
class UniformLoad:
    """f = weight · signal(t) on each node; nodes (m, 1), weight (m,)."""

    nodes: IntArray
    weight: FloatArray
    signal: Signal

    newton: NewtonPart = "nothing"
    external: bool = True

    @property
    def jumps(self) -> tuple[float, ...]:
        """Jumps of the signal."""
        return self.signal.jumps

    @property
    def kinks(self) -> tuple[float, ...]:
        """Kinks of the signal."""
        return self.signal.kinks

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Force on each node, (m, 1, 3), N."""
        return self.weight[:, None, None] * self.signal(t)

    def tangent(self, t: float, x: FloatArray, v: FloatArray) -> Tangent:
        """None: a load does not depend on the motion."""
        return Tangent.none(1)

    def account(self, t: float, x: FloatArray, v: FloatArray) -> Account:
        """External power p·v."""
        return Account(external_power=float((self.weight @ v[:, 0]) @ self.signal(t)))
