"""Orbit: what a net feels in the frame that goes round with a circular reference orbit.

Symbols: n mean motion in rad/s; x radially outward, y along the track, z along the orbit's normal (the local
vertical, local horizontal frame); r = (x, y, z) of a node in m from the frame's origin on the orbit, m its mass.

The frame turns with ω = n e_z about the Earth, whose centre stands at R = −a e_x, and n² a³ = μ. In it

    r̈ = −μ (r − R)/|r − R|³ − ω × (ω × (r − R)) − 2 ω × ṙ + (other forces)/m.

The centrifugal term is n² (x + a, y, 0), the Coriolis term 2n (ẏ, −ẋ, 0). For |r| ≪ a gravity is
n² (−a + 2x, −y, −z) to first order, so that the constant parts cancel and

    f = m (3n² x + 2n ẏ,  −2n ẋ,  −n² z)

is left: the equations of G. W. Hill (1878, American Journal of Mathematics 1) in the form of W. H. Clohessy and
R. S. Wiltshire (1960, Journal of the Aerospace Sciences 27). What is left out is 3/2 |r|/a of the tidal terms:
2e-5 for a net of 100 m at 600 km. The orbit is an ideal one: drag or pressure on it are not in the frame's motion.

The tidal part has the potential −m n² (3x² − z²)/2, and the Coriolis force does no work. In free flight, therefore,
kinetic energy in this frame, stored energy and this potential keep their sum; momentum in this frame is not kept,
and what the force gives counts as an impulse from outside.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from netdae._arrays import FloatArray, IntArray
from netdae.errors import InputError
from netdae.forces.protocol import Account, Force, NewtonPart, Tangent
from netdae.material import Cords
from netdae.net import CableNet


@njit(cache=True)
def orbit_acceleration(n: float, x: float, z: float, vx: float, vy: float) -> tuple[float, float, float]:
    """(3n² x + 2n ẏ, −2n ẋ, −n² z), m/s²."""
    return 3.0 * n * n * x + 2.0 * n * vy, -2.0 * n * vx, -n * n * z


@njit(cache=True)
def _forces(n: float, mass: FloatArray, x: FloatArray, v: FloatArray, f: FloatArray) -> None:
    for e in range(len(mass)):
        ax, ay, az = orbit_acceleration(n, x[e, 0, 0], x[e, 0, 2], v[e, 0, 0], v[e, 0, 1])
        f[e, 0, 0], f[e, 0, 1], f[e, 0, 2] = mass[e] * ax, mass[e] * ay, mass[e] * az


@dataclass(frozen=True)
class Orbit:
    """The net flies near a circular orbit; x points outward, y along the track, z along the orbit's normal.

    mean_motion : n, rad/s, 2π over the time of one revolution

    Raises InputError for a mean motion that is not above zero.
    """

    mean_motion: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.mean_motion) and self.mean_motion > 0):
            raise InputError(
                f"orbit: mean_motion is {self.mean_motion:g} rad/s: give a number above zero, "
                "for instance 1.08e-3 at an altitude of 600 km"
            )

    def on(self, net: CableNet, cords: Cords, mass: FloatArray) -> Force:
        """Bound to all nodes that have a mass."""
        nodes = np.flatnonzero(mass > 0)
        return OrbitForce(nodes[:, None], np.ascontiguousarray(mass[nodes]), self.mean_motion)


@dataclass(frozen=True, eq=False)
class OrbitForce:
    """f = m (3n² x + 2n ẏ, −2n ẋ, −n² z) on each node.

    nodes : (m, 1); mass : (m,), kg; mean_motion : n, rad/s
    newton : the tangent is of the size n² and n beside c_j² and c_j, hence "nothing"
    """

    nodes: IntArray
    mass: FloatArray
    mean_motion: float

    newton: NewtonPart = "nothing"
    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()
    external: bool = True

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Force on each node, (m, 1, 3), N."""
        f = np.empty_like(x)
        _forces(self.mean_motion, self.mass, x, v, f)
        return f

    def tangent(self, t: float, x: FloatArray, v: FloatArray) -> Tangent:
        """m diag(3n², 0, −n²), and the Coriolis term's unsymmetric 2 m n (e_x e_yᵀ − e_y e_xᵀ)."""
        n, m = self.mean_motion, self.mass
        K, C = np.zeros((2, len(m), 1, 3, 1, 3))
        K[:, 0, 0, 0, 0], K[:, 0, 2, 0, 2] = 3 * n * n * m, -n * n * m
        C[:, 0, 0, 0, 1], C[:, 0, 1, 0, 0] = 2 * n * m, -2 * n * m
        return Tangent.of_all(K, C)

    def account(self, t: float, x: FloatArray, v: FloatArray) -> Account:
        """External power of the tidal part; the Coriolis force does no work."""
        n, r, u = self.mean_motion, x[:, 0], v[:, 0]
        return Account(
            external_power=n * n * float(self.mass @ (3.0 * r[:, 0] * u[:, 0] - r[:, 2] * u[:, 2]))
        )
