"""All forces of a net together: gathered from the nodes, asked element by element, scattered back.

Symbols: n nodes, x, v (n, 3); f sum of all forces (n, 3); T = −∂f/∂x, D = −∂f/∂v.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.assembly import BlockPattern, gather, scatter_add, scatter_blocks
from netdae.errors import RunError
from netdae.forces.protocol import Force, LinkedForce


@dataclass(frozen=True, eq=False)
class Placed:
    """A force with its place in the net: nodes (m, k) and their blocks (m, k, k), None where it needs none.

    Of a force with links the blocks are those of the links, (p, 2, 2).
    """

    force: Force
    nodes: IntArray
    blocks: IntArray | None


@dataclass(frozen=True, eq=False)
class NetForces:
    """Forces with their places, and the pattern of the blocks that they couple."""

    placed: tuple[Placed, ...]
    pattern: BlockPattern

    @classmethod
    def of(cls, forces: Sequence[Force], node_count: int) -> NetForces:
        """Forces on a net of so many nodes."""
        coupled = [_coupled_by(force) for force in forces]
        pattern = BlockPattern.of(node_count, [nodes for nodes in coupled if nodes is not None])
        placed = (
            Placed(force, force.nodes, None if nodes is None else pattern.places_of(nodes))
            for force, nodes in zip(forces, coupled, strict=True)
        )
        return cls(tuple(placed), pattern)

    def with_first(self, force: Force) -> NetForces:
        """The same with another first force on the same nodes."""
        return replace(self, placed=(replace(self.placed[0], force=force), *self.placed[1:]))

    def _gathered(self, x: FloatArray, v: FloatArray) -> Iterable[tuple[Placed, FloatArray, FloatArray]]:
        for placed in self.placed:
            local = np.empty((2, *placed.nodes.shape, 3))
            gather(x, placed.nodes, local[0])
            gather(v, placed.nodes, local[1])
            yield placed, local[0], local[1]

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """f (n, 3), N."""
        total = np.zeros_like(x)
        for placed, xe, ve in self._gathered(x, v):
            f = placed.force.force(t, xe, ve)
            if f.shape != xe.shape:
                raise RunError(
                    f"{type(placed.force).__name__}.force gave an array {f.shape}, expected {xe.shape}: "
                    "a force on each node of each element"
                )
            scatter_add(f, placed.nodes, total)
        return total

    def tangent_blocks(self, t: float, x: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Symmetric parts of T and D as blocks (b, 3, 3) of `pattern`, without the dyads of linked forces."""
        T = np.zeros((len(self.pattern.rows), 3, 3))
        D = np.zeros_like(T)
        for placed, xe, ve in self._gathered(x, v):
            if placed.blocks is None:
                continue
            if placed.force.newton == "links":
                K, C, *_ = cast(LinkedForce, placed.force).newton_part(t, xe, ve)
                elements = np.arange(len(K))
            else:
                elements, K, C = placed.force.tangent(t, xe, ve)
            scatter_blocks(elements, K, C, placed.blocks, T, D)
        return T, D

    def tangent_product(
        self, t: float, x: FloatArray, v: FloatArray, dx: FloatArray, dv: FloatArray
    ) -> FloatArray:
        """(∂f/∂x) dx + (∂f/∂v) dv, (n, 3), with the whole, unsymmetric tangents."""
        total = np.zeros_like(x)
        for placed, xe, ve in self._gathered(x, v):
            elements, K, C = placed.force.tangent(t, xe, ve)
            nodes = placed.nodes[elements]
            local = np.einsum("eiajb,ejb->eia", K, dx[nodes]) + np.einsum("eiajb,ejb->eia", C, dv[nodes])
            scatter_add(local, nodes, total)
        return total

    def account(self, t: float, x: FloatArray, v: FloatArray) -> tuple[float, float, float]:
        """Stored energy in J, dissipated and external power in W."""
        accounts = [placed.force.account(t, xe, ve) for placed, xe, ve in self._gathered(x, v)]
        stored, dissipated, external = (sum(column) for column in zip(*accounts, strict=True))
        return stored, dissipated, external

    def external_wrench(self, t: float, x: FloatArray, v: FloatArray, in_space: BoolArray) -> FloatArray:
        """Force in N and torque about the origin in N m of those from outside on nodes in space (n,), (2, 3)."""
        total = np.zeros((2, 3))
        for placed, xe, ve in self._gathered(x, v):
            if placed.force.external:
                f = placed.force.force(t, xe, ve)
                total += wrench_of(xe, np.where(in_space[placed.nodes][..., None], f, 0.0))
        return total


def _coupled_by(force: Force) -> IntArray | None:
    """Nodes (m, k) among which blocks couple all, None where there are none."""
    if force.newton == "nothing":
        return None
    return cast(LinkedForce, force).links if force.newton == "links" else force.nodes


def wrench_of(x: FloatArray, f: FloatArray) -> FloatArray:
    """Sum of forces f (..., 3) at places x (..., 3), and of their moments x × f about the origin, (2, 3)."""
    xs, fs = x.reshape(-1, 3), f.reshape(-1, 3)
    moments = xs.T @ fs  # Σ xₐ f_b
    torque = (moments[1, 2] - moments[2, 1], moments[2, 0] - moments[0, 2], moments[0, 1] - moments[1, 0])
    return np.stack((fs.sum(axis=0), torque))
