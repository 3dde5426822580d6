"""Linear springs that push and pull, between two nodes or from a node to the ground.

Symbols: d = xⱼ − xᵢ (3,) of a spring from node i to node j, or d = a − x from a node to its anchor a; l = |d|,
w = ḋ; L rest length, k stiffness, c viscosity of the damper in parallel.

The energy ½ k (l − L)² pulls the node i, or the one on the ground, with

    f = k (1 − L/l) d + c (d·w/l²) d,

and j with −f: a spring between nodes keeps both momenta. With n = d/l the derivatives are

    ∂f/∂d = k (I − L/l (I − n nᵀ)) + c (n wᵀ + (n·w) (I − 2 n nᵀ))/l,        ∂f/∂w = c n nᵀ.

A spring to the ground without rest length, such as one that holds a node softly in place, has no direction at its
anchor. Its damper acts along all axes instead, f = k d + c w, which the ground can take up. Where a spring with rest
length has l = 0, its direction is not known and it does not act.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from netdae.core.arrays import FloatArray, IntArray, Reals, Reals2
from netdae.core.errors import InputError
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.forces.law import Family, Law, Shares, Vector, compiled
from netdae.model.material import Cords
from netdae.model.net import CableNet


class Strut(NamedTuple):
    """Parameters of springs between two nodes, (m,)."""

    stiffness: Reals  # k, N/m
    viscosity: Reals  # c, N s/m
    L: Reals  # m


class GroundSpring(NamedTuple):
    """Parameters of springs to the ground, (m,) but for `anchor`."""

    stiffness: Reals  # k, N/m
    viscosity: Reals  # c, N s/m
    L: Reals  # m
    anchor: Reals2  # a (m, 3), m


@compiled
def _pull(
    k: float, c: float, L: float, d: Vector, w: Vector, elastic: FloatArray, viscous: FloatArray
) -> None:
    l2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    if L == 0.0:
        spring = k
    elif l2 > 0.0:
        spring = k * (1.0 - L / np.sqrt(l2))
    else:
        spring = 0.0
    damper = c * (d[0] * w[0] + d[1] * w[1] + d[2] * w[2]) / l2 if l2 > 0.0 else 0.0
    for a in range(3):
        elastic[a] = spring * d[a]
        viscous[a] = damper * d[a]


@compiled
def _slopes(k: float, c: float, L: float, d: Vector, w: Vector, K: FloatArray, C: FloatArray) -> None:
    """∂f/∂d and ∂f/∂w."""
    l2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    if l2 == 0.0:
        if L == 0.0:
            for a in range(3):
                K[a, a] = k
        return
    l = np.sqrt(l2)  # noqa: E741  # the page's letter
    rate = (d[0] * w[0] + d[1] * w[1] + d[2] * w[2]) / l  # n·w
    for a in range(3):
        for b in range(3):
            unit, nn = (1.0 if a == b else 0.0), d[a] * d[b] / l2
            K[a, b] = k * (unit - L / l * (unit - nn)) + c * (d[a] / l * w[b] + rate * (unit - 2.0 * nn)) / l
            C[a, b] = c * nn


@compiled
def _strut(p: Strut, e: int, s: FloatArray, d: Vector, w: Vector, f: Shares) -> bool:
    _pull(p.stiffness[e], p.viscosity[e], p.L[e], d, w, f.conservative, f.dissipative)
    return True


@compiled
def _strut_tangent(
    p: Strut, e: int, s: FloatArray, d: Vector, w: Vector, K: FloatArray, C: FloatArray
) -> bool:
    _slopes(p.stiffness[e], p.viscosity[e], p.L[e], d, w, K, C)
    return True


@compiled
def _strut_energy(p: Strut, e: int, d: Vector) -> float:
    stretch = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) - p.L[e]
    return 0.5 * p.stiffness[e] * stretch * stretch


@compiled
def _to_anchor(p: GroundSpring, e: int, x: FloatArray, v: FloatArray) -> tuple[Vector, Vector]:
    """d and w."""
    d = p.anchor[e, 0] - x[0, 0], p.anchor[e, 1] - x[0, 1], p.anchor[e, 2] - x[0, 2]
    return d, (-v[0, 0], -v[0, 1], -v[0, 2])


@compiled
def _ground(p: GroundSpring, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    d, w = _to_anchor(p, e, x, v)
    if p.L[e] > 0.0:
        _pull(p.stiffness[e], p.viscosity[e], p.L[e], d, w, f.conservative[0], f.dissipative[0])
    else:
        for a in range(3):
            f.conservative[0, a], f.dissipative[0, a] = p.stiffness[e] * d[a], p.viscosity[e] * w[a]
    return True


@compiled
def _ground_tangent(
    p: GroundSpring, e: int, s: FloatArray, x: FloatArray, v: FloatArray, K: FloatArray, C: FloatArray
) -> bool:
    by_d, by_w = np.zeros((3, 3)), np.zeros((3, 3))
    if p.L[e] > 0.0:
        d, w = _to_anchor(p, e, x, v)
        _slopes(p.stiffness[e], p.viscosity[e], p.L[e], d, w, by_d, by_w)
    else:
        for a in range(3):
            by_d[a, a], by_w[a, a] = p.stiffness[e], p.viscosity[e]
    for a in range(3):
        for b in range(3):
            K[0, a, 0, b], C[0, a, 0, b] = -by_d[a, b], -by_w[a, b]
    return True


@compiled
def _ground_energy(p: GroundSpring, e: int, x: FloatArray) -> float:
    dx, dy, dz = p.anchor[e, 0] - x[0, 0], p.anchor[e, 1] - x[0, 1], p.anchor[e, 2] - x[0, 2]
    stretch = np.sqrt(dx * dx + dy * dy + dz * dz) - p.L[e]
    return 0.5 * p.stiffness[e] * stretch * stretch


@compiled
def _mean_pull(k: float, L: float, d: Vector, g: Vector, f: FloatArray) -> None:
    lengths = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) + np.sqrt(
        g[0] * g[0] + g[1] * g[1] + g[2] * g[2]
    )
    q = k
    if L > 0.0:
        q = k * (1.0 - 2.0 * L / lengths) if lengths > 0.0 else 0.0
    for a in range(3):
        f[a] = 0.5 * q * (d[a] + g[a])


@compiled
def _strut_between(p: Strut, e: int, d: Vector, g: Vector, f: FloatArray) -> bool:
    _mean_pull(p.stiffness[e], p.L[e], d, g, f)
    return True


@compiled
def _ground_between(p: GroundSpring, e: int, x: FloatArray, y: FloatArray, f: FloatArray) -> bool:
    d = p.anchor[e, 0] - x[0, 0], p.anchor[e, 1] - x[0, 1], p.anchor[e, 2] - x[0, 2]
    g = p.anchor[e, 0] - y[0, 0], p.anchor[e, 1] - y[0, 1], p.anchor[e, 2] - y[0, 2]
    _mean_pull(p.stiffness[e], p.L[e], d, g, f[0])
    return True


def _is_lossless(p: Strut | GroundSpring) -> bool:
    return not p.viscosity.any()


def _bound(p: Strut | GroundSpring, nodes: IntArray, strain: float, x: FloatArray) -> list[Family]:
    of_spring = np.stack((p.stiffness, p.viscosity))
    return [Family(nodes, np.repeat(of_spring[..., None], nodes.shape[1], axis=2))]


def _ranked(p: Strut | GroundSpring, reach: float) -> tuple[str, float, str]:
    return "springs", float(p.stiffness.sum()) * reach, "Σ k D"


STRUT = Law(
    Strut,
    force=_strut,
    tangent=_strut_tangent,
    energy=_strut_energy,
    pair=True,
    shares=("conservative", "dissipative"),
    between=_strut_between,
    lossless=_is_lossless,
    ranked=_ranked,
    bound=_bound,
)
GROUND_SPRING = Law(
    GroundSpring,
    force=_ground,
    tangent=_ground_tangent,
    energy=_ground_energy,
    nodes=1,
    shares=("conservative", "dissipative"),
    between=_ground_between,
    lossless=_is_lossless,
    external=True,
    ranked=_ranked,
    bound=_bound,
)


@dataclass(frozen=True, eq=False)
class Spring:
    """Linear springs from each node of a group to one other node, or to the ground.

    group : node group
    stiffness : k, N/m, in tension and in compression
    to : node group of the one node at the other end; None for the ground
    anchor : place on the ground, three numbers in m; None for that of each node at `x`
    viscosity : c of the damper in parallel with the spring, N s/m
    rest_length : m; None for the distance at `x`
    x : positions (n, 3), m, of nodes and more that None refers to; by default those of the mesh

    Raises InputError for values out of range, and for an anchor together with `to`.
    """

    group: str
    stiffness: float
    to: str | None = None
    anchor: ArrayLike | None = None
    viscosity: float = 0.0
    rest_length: float | None = None
    x: FloatArray | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.stiffness) and self.stiffness > 0):
            raise InputError(f"spring: stiffness is {self.stiffness:g}: give a finite number above zero")
        for name in ("viscosity", "rest_length"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value >= 0):
                raise InputError(f"spring: {name} is {value:g}: give a finite number, zero or more")
        if self.to is not None and self.anchor is not None:
            raise InputError("spring: both of to and anchor are given: leave one of them out")
        if self.anchor is not None:
            anchor = np.asarray(self.anchor, dtype=np.float64)
            if anchor.shape != (3,) or not np.isfinite(anchor).all():
                raise InputError(f"spring: anchor is {anchor.tolist()}: give three finite numbers")

    def on(self, net: CableNet, cords: Cords, mass: FloatArray) -> Force:
        """Bound to the group's nodes; raises InputError for unknown groups, and for a spring without two ends."""
        nodes, x = net.nodes_of(self.group), net.nodes if self.x is None else self.x
        if not len(nodes):
            raise InputError(f"spring: the group {self.group!r} has no nodes: name another one")
        if self.to is None:
            ends = x[nodes] if self.anchor is None else np.tile(self.anchor, (len(nodes), 1))
        else:
            ends = x[np.full(len(nodes), self._other_end(net, nodes))]
        k, c = np.full(len(nodes), self.stiffness), np.full(len(nodes), self.viscosity)
        L = np.linalg.norm(ends - x[nodes], axis=1)
        if self.rest_length is not None:
            L = np.full(len(nodes), self.rest_length)
        if self.to is None:
            return ElementForce(GROUND_SPRING, nodes[:, None], GroundSpring(k, c, L, ends))
        pairs = np.column_stack((nodes, np.full(len(nodes), self._other_end(net, nodes))))
        return ElementForce(STRUT, pairs, Strut(k, c, L))

    def _other_end(self, net: CableNet, nodes: IntArray) -> int:
        assert self.to is not None
        ends = net.nodes_of(self.to)
        if len(ends) != 1:
            raise InputError(
                f"spring: the group {self.to!r} has {len(ends)} nodes: name one of a single node"
            )
        if ends[0] in nodes:
            raise InputError(
                f"spring: node {ends[0]} is in {self.group!r} and in {self.to!r}: join two nodes"
            )
        return int(ends[0])
