"""What the drag models have in common: how much of a cord is seen, and the drag of a body.

Symbols, for a cable from node i to node j: d = xⱼ − xᵢ (3,), l = |d| its length from end to end, L̄ rest length;
u (3,) the direction that it is seen from, s = (L̄ − l)₊ the slack.

A straight cord of length l shows |d × u| of it along a unit vector u. A slack cord is longer than the distance between
its ends. Its tangents sum to d, whatever its shape, so this part is kept. The shape of the rest, s, is not known: it is
assumed to hang in loops that point in all directions equally. With θ the angle between u and a direction, the mean of
sin θ over the sphere is π/4, hence

    seen length  =  |d × u| + (π/4) s |u|.

It is L̄|sin θ| when the cable goes taut and π/4 L̄ when its ends meet, continuous in between, and smooth except for its
slope at s = 0, at l = 0 and where d points along u. Cords do not shade each other.

Each end of a cable carries half of it, as in Eq. (7), with the velocity of its own node: a cable that spins about
its middle is braked too, and nodes are coupled by positions alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from netdae.core.arrays import FloatArray, IntArray, Reals
from netdae.core.errors import InputError
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.forces.law import Law, Shares, compiled
from netdae.model.material import Cords
from netdae.model.net import CableNet
from netdae.model.signals import Signal, signal_of

LOOPS = 0.25 * math.pi
"""Mean of sin θ over all directions."""

PARALLEL = 1e-12
"""Sine of the angle below which a direction is nothing but round-off."""


@compiled
def slack_of(l: float, L: float) -> float:  # noqa: E741  # the page's letter
    """s = (L̄ − l)₊, m."""
    return max(L - l, 0.0)


@compiled
def across_of(dx: float, dy: float, dz: float, ux: float, uy: float, uz: float) -> float:
    """|d × u|."""
    cx, cy, cz = dy * uz - dz * uy, dz * ux - dx * uz, dx * uy - dy * ux
    return np.sqrt(cx * cx + cy * cy + cz * cz)


@compiled
def seen_length(dx: float, dy: float, dz: float, L: float, ux: float, uy: float, uz: float) -> float:
    """|d × u| + (π/4) s |u|: length in m that is seen along a unit vector u; it is proportional to |u|."""
    slack = slack_of(np.sqrt(dx * dx + dy * dy + dz * dz), L)
    loops = LOOPS * slack * np.sqrt(ux * ux + uy * uy + uz * uz)
    return across_of(dx, dy, dz, ux, uy, uz) + loops


@compiled
def seen_slopes(d: FloatArray, L: float, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Derivatives (3,) of the seen length with respect to d and u; terms whose root is zero are zero.

    ∂|d × u|/∂d = (u² d − (d·u) u)/|d × u|, and likewise by u.
    """
    dd, uu, du = d @ d, u @ u, d @ u
    l, size = np.sqrt(dd), np.sqrt(uu)  # noqa: E741
    across = across_of(d[0], d[1], d[2], u[0], u[1], u[2])
    by_d, by_u = np.zeros(3), np.zeros(3)
    if across > PARALLEL * l * size:
        by_d += (uu * d - du * u) / across
        by_u += (dd * u - du * d) / across
    slack = slack_of(l, L)
    if slack > 0.0 and l > 0.0:
        by_d -= LOOPS * size / l * d
    if size > 0.0:
        by_u += LOOPS * slack / size * u
    return by_d, by_u


def check_positive(what: str, values: Mapping[str, float | None]) -> None:
    """Raise InputError for values that are not finite numbers above zero; None means not given."""
    for name, value in values.items():
        if value is not None and not (math.isfinite(value) and value > 0):
            raise InputError(f"{what}: {name} is {value:g}: give a finite number above zero")


def thickness_of(cables: IntArray, cords: Cords, diameter: float | None) -> FloatArray:
    """Diameters (k,) in m seen of some cables: as given, or those of round cords of their area."""
    if diameter is None:
        return np.sqrt(4.0 / math.pi * cords.area[cables])
    return np.full(len(cables), diameter)


class DragOnBodies(NamedTuple):
    """Parameters of f = c |w| w with w = s − v on each node; the signal s is the wind, m/s."""

    weight: Reals  # c = ½ ρ C_D A (m,), kg/m


@compiled
def _force(p: DragOnBodies, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    wx, wy, wz = s[0] - v[0, 0], s[1] - v[0, 1], s[2] - v[0, 2]
    push = p.weight[e] * np.sqrt(wx * wx + wy * wy + wz * wz)
    f.external[0, 0], f.external[0, 1], f.external[0, 2] = push * wx, push * wy, push * wz
    return True


@compiled
def _tangent(
    p: DragOnBodies, e: int, s: FloatArray, x: FloatArray, v: FloatArray, K: FloatArray, C: FloatArray
) -> bool:
    """−c (|w| I + w wᵀ/|w|) by velocity."""
    w = s - v[0]
    size = np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    for a in range(3):
        for b in range(3):
            C[0, a, 0, b] = -p.weight[e] * (size if a == b else 0.0)
            if size > 0.0:
                C[0, a, 0, b] -= p.weight[e] * w[a] * w[b] / size
    return True


# all its power is external: where the air moves, it may drive as well as brake
BODY_DRAG = Law(
    DragOnBodies,
    force=_force,
    tangent=_tangent,
    nodes=1,
    shares=("external",),
    external=True,
    newton="nothing",
)


@dataclass(frozen=True, eq=False)
class BodyDrag:
    """Drag of bullets and other bodies that sit on the nodes of a group: ½ ρ C_D A |w| w.

    w is the velocity of the air relative to the node.

    group : node group
    area : A, m², that each body shows to the air; π D²/4 for a sphere
    density : ρ of the air, kg/m³
    drag_coefficient : C_D: of spheres about 2.2 in free molecular flow (see `forces.free_molecular`), and 0.4 to
        0.5 in dense air from Re = 1e3 to 2e5 (Hoerner 1965, Fluid-Dynamic Drag, ch. 3)
    wind : velocity of the air in m/s: three numbers, a Signal or a smooth function of t

    Raises InputError for values that are not above zero.
    """

    group: str
    area: float
    density: float
    drag_coefficient: float
    wind: Signal | ArrayLike | Callable[[float], ArrayLike] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        check_positive(
            f"drag of {self.group!r}",
            {"area": self.area, "density": self.density, "drag_coefficient": self.drag_coefficient},
        )

    def on(self, net: CableNet, cords: Cords, mass: FloatArray) -> Force:
        """Bound to those nodes of the group that have a mass; raises InputError for an unknown group."""
        nodes = net.nodes_of(self.group)
        nodes = nodes[mass[nodes] > 0]
        weight = 0.5 * self.density * self.drag_coefficient * self.area
        parameters = DragOnBodies(np.full(len(nodes), weight))
        return ElementForce(BODY_DRAG, nodes[:, None], parameters, signal_of(self.wind))
