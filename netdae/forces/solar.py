"""Pressure of sunlight on cords and bodies.

Symbols, for a cable from node i to node j: d = xⱼ − xᵢ (3,), L̄ rest length, D diameter; s (3,) the unit vector
along which the light travels, from the Sun to the net; p its pressure, 4.5e-6 N/m² at 1 AU; C_R the body's coefficient.

A body that absorbs the light takes the momentum p A s per second, A its area seen from the Sun; reflected light adds to
that. With the sideways parts neglected (they cancel on a sphere, and on a cord that is lit from its side)

    f = p C_R A s,        on each end of a cable  f = ½ p C_R D (|d × s| + (π/4) (L̄ − l)₊) s,

where `forces.drag` derives the seen length. Of a cylinder lit from its side C_R is 1 for black, 4/3 for a mirror (each
strip at the angle φ reflects the share cos 2φ, and the mean of 1 + cos 2φ over the width is 4/3) and 1 + π/6 =
1.52 for dull white (Lambert's law: 2/3 of a strip's light along its normal, the mean of cos φ over the width is π/4);
for a sphere 1, 1 and 13/9. Whole satellites have 1.2 to 1.5 (O. Montenbruck and E. Gill 2000, Satellite Orbits, sec.
3.4). Cords do not shade each other; the Earth's light and heat are neglected.

The frame of an orbit turns (see `forces.orbit`): in it the Sun goes round the z axis backwards, with the mean motion
n, which is 3.7° in a minute at 600 km. `sun_over_orbit` gives it; three numbers suffice for short flights.
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
from netdae.forces.drag import check_positive, seen_length, seen_slopes, thickness_of
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.forces.law import Law, Shares, compiled
from netdae.forces.loads import UNIFORM_LOAD, uniform_load
from netdae.model.material import Cords
from netdae.model.net import CableNet
from netdae.model.signals import Constant, Function, Line, Signal, is_constant, line_of, signal_of

TYPICAL = 1.3
"""C_R between black and dull white."""


def sun_over_orbit(sun: ArrayLike, mean_motion: float, *, since: float = 0.0) -> Function:
    """Direction of the Sun in the frame of an orbit, which turns about z with `mean_motion` in rad/s.

    sun : (3,), direction towards the Sun at the time `since`, s
    """
    x, y, z = np.asarray(sun, dtype=np.float64)

    def direction(t: float) -> tuple[float, float, float]:
        c, s = math.cos(mean_motion * (t - since)), math.sin(mean_motion * (t - since))
        return float(c * x + s * y), float(c * y - s * x), float(z)

    return Function(direction)


@dataclass(frozen=True, eq=False)
class Light:
    """Unit vector along which light travels from a Sun in the direction `sun`; zero where `sun` is: in shadow."""

    sun: Signal

    @property
    def jumps(self) -> tuple[float, ...]:
        """Jumps of the Sun's direction, into shadow and out of it."""
        return self.sun.jumps

    @property
    def kinks(self) -> tuple[float, ...]:
        """Kinks of the Sun's direction."""
        return self.sun.kinks

    @property
    def constant(self) -> bool:
        """Whether the Sun stands still."""
        return is_constant(self.sun)

    @property
    def times(self) -> FloatArray:
        """Times of the table behind it, s."""
        return self.sun.times  # type: ignore[attr-defined]  # needed where a table is too short

    def __call__(self, t: float) -> FloatArray:
        """Unit vector (3,), or zero."""
        sun = self.sun(t)
        size = float(np.linalg.norm(sun))
        return -sun / size if size > 0 else np.zeros(3)

    def line(self, begin: float, end: float) -> Line | None:
        """For a Sun that stands still: between rows of a table a unit vector is not linear."""
        sun = line_of(self.sun, begin, end)
        return None if sun is None or sun[1].any() else (self(begin), np.zeros(3))

    def covers(self, begin: float, end: float) -> bool:
        """Whether the Sun's direction is known from `begin` to `end`."""
        return self.sun.covers(begin, end)


def _light_of(sun: Signal | ArrayLike | Callable[[float], ArrayLike]) -> Light:
    signal = signal_of(sun)
    if isinstance(signal, Constant) and not signal(0.0).any():
        raise InputError("sun is [0, 0, 0]: give the direction towards the Sun")
    return Light(signal)


class LightOnCables(NamedTuple):
    """Parameters of the pressure of light on cables, half of it on each end, (m,).

    The signal is the unit vector along the light, or zero.
    """

    L: Reals  # L̄, m
    weight: Reals  # ½ p C_R D, N/m


@compiled
def light_push_of(
    c: float, dx: float, dy: float, dz: float, L: float, sx: float, sy: float, sz: float
) -> tuple[float, float, float]:
    """Force in N on one end of a cable; c = ½ p C_R D, N/m; s of length one, or zero in shadow."""
    push = c * seen_length(dx, dy, dz, L, sx, sy, sz)
    return push * sx, push * sy, push * sz


@compiled
def _force(p: LightOnCables, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    dx, dy, dz = x[1, 0] - x[0, 0], x[1, 1] - x[0, 1], x[1, 2] - x[0, 2]
    push = light_push_of(p.weight[e], dx, dy, dz, p.L[e], s[0], s[1], s[2])
    for end in range(2):
        f.external[end, 0], f.external[end, 1], f.external[end, 2] = push
    return True


@compiled
def _tangent(
    p: LightOnCables, e: int, s: FloatArray, x: FloatArray, v: FloatArray, K: FloatArray, C: FloatArray
) -> bool:
    by_d, _ = seen_slopes(x[1] - x[0], p.L[e], s)
    for end in range(2):
        for a in range(3):
            for b in range(3):
                K[end, a, 1, b] = p.weight[e] * s[a] * by_d[b]
                K[end, a, 0, b] = -p.weight[e] * s[a] * by_d[b]
    return True


LIGHT = Law(
    LightOnCables,
    force=_force,
    tangent=_tangent,
    shares=("external",),
    external=True,
    newton="nothing",
)


def is_light(force: Force) -> bool:
    """Whether a force is the pressure of sunlight, on cords or on bodies: other loads on nodes have no `Light`."""
    if not isinstance(force, ElementForce):
        return False
    return force.law is LIGHT or (force.law is UNIFORM_LOAD and isinstance(force.signal, Light))


@dataclass(frozen=True, eq=False)
class SolarPressure:
    """Pressure of sunlight on the cables of a group.

    sun : direction towards the Sun, of any length: three numbers, a Signal or a smooth function of t; zero in shadow
    pressure : p, N/m²
    coefficient : C_R on the projected area
    cables : cable group
    diameter : m, as seen by the light; None takes that of a round cord of the material's cross-section

    Raises InputError for values that are not above zero.
    """

    sun: Signal | ArrayLike | Callable[[float], ArrayLike]
    pressure: float
    coefficient: float = TYPICAL
    cables: str = "all"
    diameter: float | None = None

    def __post_init__(self) -> None:
        check_positive(
            "solar pressure",
            {"pressure": self.pressure, "coefficient": self.coefficient, "diameter": self.diameter},
        )

    def on(self, net: CableNet, cords: Cords, mass: FloatArray) -> Force:
        """Bound to the group's cables; raises InputError for an unknown group."""
        cables = net.cables_of(self.cables)
        weight = 0.5 * self.pressure * self.coefficient * thickness_of(cables, cords, self.diameter)
        parameters = LightOnCables(net.rest_length[cables], weight)
        return ElementForce(LIGHT, net.cables[cables], parameters, _light_of(self.sun))


@dataclass(frozen=True, eq=False)
class BodySolarPressure:
    """Pressure of sunlight on bodies that sit on the nodes of a group: p C_R A.

    group : node group
    area : A, m², that each body shows to the Sun
    sun, pressure, coefficient : as in `SolarPressure`

    Raises InputError for values that are not above zero.
    """

    group: str
    area: float
    sun: Signal | ArrayLike | Callable[[float], ArrayLike]
    pressure: float
    coefficient: float = TYPICAL

    def __post_init__(self) -> None:
        check_positive(
            f"solar pressure on {self.group!r}",
            {"area": self.area, "pressure": self.pressure, "coefficient": self.coefficient},
        )

    def on(self, net: CableNet, cords: Cords, mass: FloatArray) -> Force:
        """Bound to those nodes of the group that have a mass; raises InputError for an unknown group."""
        nodes = net.nodes_of(self.group)
        nodes = nodes[mass[nodes] > 0]
        weight = np.full(len(nodes), self.pressure * self.coefficient * self.area)
        return uniform_load(nodes, weight, _light_of(self.sun))
