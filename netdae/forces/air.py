"""Drag of cords in dense air: drop tests and parabolic flights.

Symbols, for a cable from node i to node j: d = xⱼ − xᵢ (3,), l = |d|, L̄ rest length, s = (L̄ − l)₊ its slack,
D diameter, ρ density of the air; w (3,) velocity of the air relative to a node, w_t its part along d, w_n = w − w_t.

The cross-flow principle (S. F. Hoerner 1965, Fluid-Dynamic Drag, ch. 3; the drag term of J. R. Morison et al. 1950,
Petroleum Transactions AIME 189, taken across the cord) treats each component of the stream separately,

    f = ½ ρ D l (C_n |w_n| w_n + π C_t |w_t| w_t).

With l |w_n| = |d × w| and b = d·w this is ½ ρ D (C_n |d × w| (w − b d/l²) + π C_t |b| b d/l²), which vanishes with l.
Both terms are C¹ in w, also where they vanish. The slack of a cord is assumed to hang in loops that point in all
directions equally (see `forces.drag`): with θ the angle between w and a direction the means over the sphere of sin³ θ,
3π/16, and |cos³ θ|, 1/4, give

    + ½ ρ D s (3π/16 C_n + π/4 C_t) |w| w.

Each end of a cable carries half of it, with the velocity of its own node.

C_n of a round cord depends on Re = |w_n| D/ν, with ν = 1.5e-5 m²/s in air at sea level: 1 + 10 Re^(−2/3) fits the
measurements from 1 to 2e5 (F. M. White 1991, Viscous Fluid Flow, sec. 3-11), which is 1.1 at 1e3 and 1.2 at 350 (a
cord of 1 mm at 5 m/s), but 1.5 at 90 and 3 at 11. It is a constant here: choose it for the relevant speed.
C_t, on the whole surface π D l, is 0.01 to 0.02 for cords and cables; 0.02 on D l, Hoerner's figure, is C_t = 0.006.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from netdae.core.arrays import FloatArray, Reals
from netdae.core.errors import InputError
from netdae.forces.drag import PARALLEL, across_of, check_positive, slack_of, thickness_of
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.forces.law import Law, Shares, compiled
from netdae.model.material import Cords
from netdae.model.net import CableNet
from netdae.model.signals import Signal, signal_of

SEA_LEVEL = 1.225
"""Density of dry air at sea level and 15 °C, kg/m³ (International Standard Atmosphere, ISO 2533:1975)."""

LOOPS_ACROSS, LOOPS_ALONG = 3.0 * math.pi / 16.0, 0.25
"""Means of sin³ θ and |cos³ θ| over all directions."""


class AirOnCables(NamedTuple):
    """Parameters of the cross-flow drag of cables, half of it on each end, (m,); the signal is the wind, m/s."""

    L: Reals  # L̄, m
    across: Reals  # ¼ ρ C_n D, kg/m²
    along: Reals  # ¼ ρ π C_t D, kg/m²


@compiled
def air_drag_of(
    cn: float,
    ct: float,
    dx: float,
    dy: float,
    dz: float,
    L: float,
    wx: float,
    wy: float,
    wz: float,
) -> tuple[float, float, float]:
    """Force in N on one end of a cable; cn = ¼ ρ C_n D and ct = ¼ ρ π C_t D, kg/m²."""
    dd, b = dx * dx + dy * dy + dz * dz, dx * wx + dy * wy + dz * wz
    across = cn * across_of(dx, dy, dz, wx, wy, wz)
    loops = (LOOPS_ACROSS * cn + LOOPS_ALONG * ct) * slack_of(np.sqrt(dd), L)
    by_w = across + loops * np.sqrt(wx * wx + wy * wy + wz * wz)
    by_d = (ct * abs(b) - across) * b / dd if dd > 0.0 else 0.0
    return by_w * wx + by_d * dx, by_w * wy + by_d * dy, by_w * wz + by_d * dz


@compiled
def _force(p: AirOnCables, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    dx, dy, dz = x[1, 0] - x[0, 0], x[1, 1] - x[0, 1], x[1, 2] - x[0, 2]
    for end in range(2):
        w = s[0] - v[end, 0], s[1] - v[end, 1], s[2] - v[end, 2]
        push = air_drag_of(p.across[e], p.along[e], dx, dy, dz, p.L[e], w[0], w[1], w[2])
        f.external[end, 0], f.external[end, 1], f.external[end, 2] = push
    return True


@compiled
def _slopes(
    cn: float, ct: float, d: FloatArray, L: float, w: FloatArray, by_d: FloatArray, by_w: FloatArray
) -> None:
    """Derivatives (3, 3) of the force with respect to d and w.

    With P = w_n, a = |d × w|, a_w = ∂a/∂w = l² P/a, a_d = ∂a/∂d = (w² d − b w)/a and Q = I − d dᵀ/l²:
    of a P by w, P a_wᵀ + a Q; by d, P a_dᵀ + a (2b d dᵀ/l² − b I − d wᵀ)/l²;
    of |b| b d/l² by w, 2|b| d dᵀ/l²; by d, 2|b| d wᵀ/l² + |b| b (I − 2 d dᵀ/l²)/l².
    """
    dd, ww = d[0] * d[0] + d[1] * d[1] + d[2] * d[2], w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    b = d[0] * w[0] + d[1] * w[1] + d[2] * w[2]
    size, a = np.sqrt(ww), across_of(d[0], d[1], d[2], w[0], w[1], w[2])
    slack = slack_of(np.sqrt(dd), L)
    loops = LOOPS_ACROSS * cn + LOOPS_ALONG * ct
    for i in range(3):
        for j in range(3):
            by_d[i, j] = by_w[i, j] = 0.0
            unit = 1.0 if i == j else 0.0
            if size > 0.0:
                by_w[i, j] += loops * slack * (size * unit + w[i] * w[j] / size)
            if dd == 0.0:
                continue
            if slack > 0.0:
                by_d[i, j] -= loops * size * w[i] * d[j] / np.sqrt(dd)
            by_w[i, j] += 2.0 * ct * abs(b) * d[i] * d[j] / dd
            by_d[i, j] += ct * abs(b) * (2.0 * d[i] * w[j] + b * (unit - 2.0 * d[i] * d[j] / dd)) / dd
            if a <= PARALLEL * np.sqrt(dd * ww):  # along the cord, where both terms vanish
                continue
            P = w[i] - b * d[i] / dd
            by_w[i, j] += cn * (P * (dd * w[j] - b * d[j]) / a + a * (unit - d[i] * d[j] / dd))
            by_d[i, j] += cn * (
                P * (ww * d[j] - b * w[j]) / a
                + a * (2.0 * b * d[i] * d[j] / dd - b * unit - d[i] * w[j]) / dd
            )


@compiled
def _tangent(
    p: AirOnCables, e: int, s: FloatArray, x: FloatArray, v: FloatArray, K: FloatArray, C: FloatArray
) -> bool:
    by_d, by_w = np.empty((3, 3)), np.empty((3, 3))
    for end in range(2):
        _slopes(p.across[e], p.along[e], x[1] - x[0], p.L[e], s - v[end], by_d, by_w)
        for a in range(3):
            for b in range(3):
                K[end, a, 1, b], K[end, a, 0, b] = by_d[a, b], -by_d[a, b]
                C[end, a, end, b] = -by_w[a, b]
    return True


# all its power is external: wind drives as well as it brakes. It couples nodes of slack cables too, which the factor of
# a taut net leaves out
AIR = Law(
    AirOnCables,
    force=_force,
    tangent=_tangent,
    shares=("external",),
    external=True,
    newton="nothing",
)


@dataclass(frozen=True, eq=False)
class AirDrag:
    """Drag of the cables of a group in dense air.

    density : ρ of the air, kg/m³
    normal_coefficient : C_n, on D l
    tangential_coefficient : C_t, on π D l
    wind : velocity of the air in m/s: three numbers, a Signal or a smooth function of t
    cables : cable group
    diameter : m, as seen by the air; None takes that of a round cord of the material's cross-section

    Bodies such as bullets are `forces.drag.BodyDrag` with the same wind.
    Raises InputError for values out of range.
    """

    density: float = SEA_LEVEL
    normal_coefficient: float = 1.1
    tangential_coefficient: float = 0.01
    wind: Signal | ArrayLike | Callable[[float], ArrayLike] = (0.0, 0.0, 0.0)
    cables: str = "all"
    diameter: float | None = None

    def __post_init__(self) -> None:
        check_positive(
            "air drag",
            {
                "density": self.density,
                "normal_coefficient": self.normal_coefficient,
                "diameter": self.diameter,
            },
        )
        if not (math.isfinite(self.tangential_coefficient) and self.tangential_coefficient >= 0):
            raise InputError(
                f"air drag: tangential_coefficient is {self.tangential_coefficient:g}: give a finite number, "
                "zero or more"
            )

    def on(self, net: CableNet, cords: Cords, mass: FloatArray) -> Force:
        """Bound to the group's cables; raises InputError for an unknown group."""
        cables = net.cables_of(self.cables)
        quarter = 0.25 * self.density * thickness_of(cables, cords, self.diameter)
        across, along = self.normal_coefficient * quarter, math.pi * self.tangential_coefficient * quarter
        parameters = AirOnCables(net.rest_length[cables], across, along)
        return ElementForce(AIR, net.cables[cables], parameters, signal_of(self.wind))
