"""A law on elements of a net: the force that methods integrate, and its NumPy view element by element.

Symbols: m elements of k nodes each; x, v gathered positions and velocities (m, k, 3).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.core.records import Record
from netdae.forces.force import Account, LinkedTangent, Tangent
from netdae.forces.law import Law, NewtonPart
from netdae.forces.loops import DISSIPATED, EXTERNAL, STORED, SUMS, elements_of, loop_of
from netdae.model.signals import Signal


@dataclass(frozen=True, eq=False)
class ElementForce:
    """A law on some elements of a net.

    nodes : (m, k), the nodes of each element
    parameters : of the law's class, one row per element
    signal : the law sees its current value; or None

    Raises TypeError for parameters of another class.
    """

    law: Law
    nodes: IntArray
    parameters: Any
    signal: Signal | None = None

    def __post_init__(self) -> None:
        if type(self.parameters) is not self.law.parameters:
            raise TypeError(
                f"the parameters are {type(self.parameters).__name__}, the law takes {self.law.parameters.__name__}"
            )

    @property
    def newton(self) -> NewtonPart:
        """The part of its tangent that the Newton matrix takes."""
        return self.law.newton

    @property
    def external(self) -> bool:
        """True if it acts from outside and so changes the net's momentum."""
        return self.law.external

    @property
    def jumps(self) -> tuple[float, ...]:
        """Times at which its signal jumps."""
        return () if self.signal is None else self.signal.jumps

    @property
    def kinks(self) -> tuple[float, ...]:
        """Times at which only the rate of its signal jumps."""
        return () if self.signal is None else self.signal.kinks

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Force on each node, (m, k, 3), N."""
        f, sums = np.zeros(x.shape), np.zeros(SUMS)
        X, V = np.ascontiguousarray(x), np.ascontiguousarray(v)
        add = loop_of(self.law, "add").ctypes
        add(self._at(t), X.ctypes.data, V.ctypes.data, f.ctypes.data, 0, sums.ctypes.data)
        return f

    def tangent(self, t: float, x: FloatArray, v: FloatArray) -> Tangent:
        """∂f/∂x and ∂f/∂v of the elements that act."""
        k = self.nodes.shape[1]
        if self.newton == "links":
            return self.newton_part(t, x, v).whole(self.nodes, self.links)
        tangents = loop_of(self.law, "tangents")
        if tangents is None:
            return Tangent.none(k)
        X, V = np.ascontiguousarray(x), np.ascontiguousarray(v)
        tangents.ctypes(self._at(t), X.ctypes.data, V.ctypes.data)
        kept = self._alone.values
        a = int(kept.counts[1])
        elements, side = kept.active[:a].copy(), 3 if self.law.pair else 3 * k
        K, C = (each[: a * side * side] for each in (kept.K, kept.C))
        if self.law.pair:
            return Tangent(elements, pair_blocks(K.reshape(a, 3, 3)), pair_blocks(C.reshape(a, 3, 3)))
        shape = (a, k, 3, k, 3)
        return Tangent(elements, K.reshape(shape).copy(), C.reshape(shape).copy())

    @property
    def acting(self) -> IntArray:
        """The elements, or links, of which the last tangent consisted."""
        kept = self._alone.values
        return np.asarray(kept.active[: kept.counts[1]].copy())

    def account(self, t: float, x: FloatArray, v: FloatArray) -> Account:
        """Stored energy, dissipated and external power of all elements together."""
        sums = np.zeros(SUMS)
        X, V = np.ascontiguousarray(x), np.ascontiguousarray(v)
        loop_of(self.law, "rates").ctypes(self._at(t), X.ctypes.data, V.ctypes.data, sums.ctypes.data, 1)
        return Account(float(sums[STORED]), float(sums[DISSIPATED]), float(sums[EXTERNAL]))

    @cached_property
    def links(self) -> IntArray:
        """Nodes (p, 2) that the blocks of a law with links couple."""
        return np.asarray(self.law.links(self.parameters, self.nodes))

    def newton_part(self, t: float, x: FloatArray, v: FloatArray) -> LinkedTangent:
        """Blocks and dyads of a law with links; both empty where it does not act."""
        k, p = self.nodes.shape[1], len(self.links)
        X, V = np.ascontiguousarray(x), np.ascontiguousarray(v)
        loop_of(self.law, "tangents").ctypes(self._at(t), X.ctypes.data, V.ctypes.data)
        kept = self._alone.values
        rank = int(kept.rank[0])
        chain = kept.K.reshape(p, 2, 3, 2, 3)[: p if rank else 0].copy()
        dyads = (each.reshape(-1, k, 3)[:rank].copy() for each in (kept.left, kept.by_x, kept.by_v))
        return LinkedTangent(chain, np.zeros_like(chain), *dyads)

    @cached_property
    def _alone(self) -> Record:
        """Its elements without shared nodes, as in gathered positions."""
        nodes = np.arange(self.nodes.size).reshape(self.nodes.shape)
        return self.elements(nodes, np.ones(self.nodes.size, dtype=np.bool_))

    def _at(self, t: float) -> int:
        if self.signal is not None:
            self._alone.values.signal[:] = self.signal(t)
        return self._alone.address

    def elements(self, nodes: IntArray, in_space: BoolArray, *, watched: bool = False) -> Record:
        """Its elements for compiled code, on nodes (m, k) of a net; `in_space` (n,) is True at points in space.

        watched : whether rest lengths on reels are compared with a lower limit
        """
        (m, k), law = nodes.shape, self.law
        side = 3 if law.pair else 3 * k
        tangents, links, dyads = m * side * side, 0, 0
        if self.newton == "links":
            links = len(self.links)
            tangents, dyads = 36 * links, 3 * k * law.ranks(self.parameters)
        elif law.tangent is None:
            tangents = 0
        least = m if watched and law.rest is not None else 0
        address = self._kept.address
        shares = 3 * m * (1 if law.pair else k)
        return elements_of(
            address,
            nodes,
            in_space,
            tangents=tangents,
            links=links,
            dyads=dyads,
            least=least,
            taken=shares if "dissipative" in law.shares else 0,
            given=shares if "external" in law.shares else 0,
        )

    @property
    def kept(self) -> Any:
        """The parameters as compiled code sees and changes them."""
        return self._kept.values

    @cached_property
    def _kept(self) -> Record:
        return Record(self.parameters)


def pair_blocks(K: FloatArray) -> FloatArray:
    """∂(f, −f)/∂(xᵢ, xⱼ), (a, 2, 3, 2, 3), of pairs with ∂f/∂d = K (a, 3, 3)."""
    blocks = np.empty((len(K), 2, 3, 2, 3))
    blocks[:, 0, :, 1, :] = blocks[:, 1, :, 0, :] = K
    blocks[:, 0, :, 0, :] = blocks[:, 1, :, 1, :] = -K
    return blocks
