"""All forces of a net together, for methods that call from Python; see `forces.table` for compiled code.

Symbols: n nodes, x, v (n, 3); f sum of all forces (n, 3); T = −∂f/∂x, D = −∂f/∂v.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, cast

import numpy as np

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force, LinkedForce
from netdae.forces.loops import DISSIPATED, EXTERNAL, FORCE, STORED, TENSION
from netdae.forces.table import Table
from netdae.system.assembly import BlockPattern, scatter_add, scatter_blocks


class Powers(NamedTuple):
    """Energy, powers and external wrench of all forces at one instant.

    stored : J; dissipated, external : W; wrench : force in N and torque about the origin in N m from outside, (2, 3)
    """

    stored: float
    dissipated: float
    external: float
    wrench: FloatArray


@dataclass(frozen=True, eq=False)
class NetForces:
    """Forces with the blocks that they couple.

    storing : the table of those that store energy
    blocks : of each force, (m, k, k) in `pattern`, None where it needs none; of a force with links those of the links,
        (p, 2, 2)
    """

    forces: tuple[Force, ...]
    table: Table
    storing: Table
    pattern: BlockPattern
    blocks: tuple[IntArray | None, ...]

    @classmethod
    def of(cls, forces: Sequence[Force], in_space: BoolArray) -> NetForces:
        """Forces on a net; `in_space` (n,) is True at points in space."""
        coupled = [coupled_by(force) for force in forces]
        pattern = BlockPattern.of(len(in_space), [nodes for nodes in coupled if nodes is not None])
        blocks = tuple(None if nodes is None else pattern.places_of(nodes) for nodes in coupled)
        storing = [force for force in forces if stores_energy(force)]
        return cls(tuple(forces), Table(forces, in_space), Table(storing, in_space), pattern, blocks)

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """f (n, 3), N."""
        return self.table.force(t, x, v)

    def tangent_blocks(self, t: float, x: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Symmetric parts of T and D as blocks (b, 3, 3) of `pattern`, without the dyads of linked forces."""
        T = np.zeros((len(self.pattern.rows), 3, 3))
        D = np.zeros_like(T)
        for force, blocks in zip(self.forces, self.blocks, strict=True):
            if blocks is None:
                continue
            xe, ve = x[force.nodes], v[force.nodes]
            if force.newton == "links":
                K, C, *_ = cast(LinkedForce, force).newton_part(t, xe, ve)
                elements = np.arange(len(K))
            else:
                elements, K, C = force.tangent(t, xe, ve)
            scatter_blocks(elements, K, C, blocks, T, D)
        return T, D

    def tangent_product(
        self, t: float, x: FloatArray, v: FloatArray, dx: FloatArray, dv: FloatArray
    ) -> FloatArray:
        """(∂f/∂x) dx + (∂f/∂v) dv, (n, 3), with the whole, unsymmetric tangents."""
        total = np.zeros_like(x)
        for force in self.forces:
            elements, K, C = force.tangent(t, x[force.nodes], v[force.nodes])
            nodes = force.nodes[elements]
            local = np.einsum("eiajb,ejb->eia", K, dx[nodes]) + np.einsum("eiajb,ejb->eia", C, dv[nodes])
            scatter_add(local, nodes, total)
        return total

    def stored(self, t: float, x: FloatArray) -> float:
        """Stored energy, J."""
        return float(self.storing.sums(t, x, np.zeros_like(x))[STORED])

    def powers(self, t: float, x: FloatArray, v: FloatArray) -> Powers:
        """Stored energy, powers and external wrench."""
        sums = self.table.sums(t, x, v)
        wrench = sums[FORCE:TENSION].reshape(2, 3)
        return Powers(float(sums[STORED]), float(sums[DISSIPATED]), float(sums[EXTERNAL]), wrench)


def stores_energy(force: Force) -> bool:
    """Whether a force may store energy; those written in Python may."""
    return not isinstance(force, ElementForce) or force.law.energy is not None


def coupled_by(force: Force) -> IntArray | None:
    """Nodes (m, k) that blocks couple with each other, None where there are none."""
    if force.newton == "nothing":
        return None
    return cast(LinkedForce, force).links if force.newton == "links" else force.nodes


def wrench_of(x: FloatArray, f: FloatArray) -> FloatArray:
    """Sum of forces f (..., 3) at places x (..., 3), and of their moments x × f about the origin, (2, 3)."""
    xs, fs = x.reshape(-1, 3), f.reshape(-1, 3)
    moments = xs.T @ fs  # Σ xₐ f_b
    torque = (moments[1, 2] - moments[2, 1], moments[2, 0] - moments[0, 2], moments[0, 1] - moments[1, 0])
    return np.stack((fs.sum(axis=0), torque))
