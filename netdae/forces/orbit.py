"""Orbit: forces on a net in the frame that moves along a circular reference orbit.

Symbols: n mean motion in rad/s; x radially outward, y along the track, z along the orbit's normal (the local
vertical, local horizontal frame); r = (x, y, z) of a node in m from the frame's origin on the orbit, m its mass.

The frame rotates with ω = n e_z about the Earth, whose centre lies at R = −a e_x, and n² a³ = μ. In it

    r̈ = −μ (r − R)/|r − R|³ − ω × (ω × (r − R)) − 2 ω × ṙ + (other forces)/m.

The centrifugal term is n² (x + a, y, 0), the Coriolis term 2n (ẏ, −ẋ, 0). For |r| ≪ a gravity is
n² (−a + 2x, −y, −z) to first order, so that the constant parts cancel and

    f = m (3n² x + 2n ẏ,  −2n ẋ,  −n² z)

remains: the equations of G. W. Hill (1878, American Journal of Mathematics 1) in the form of W. H. Clohessy and
R. S. Wiltshire (1960, Journal of the Aerospace Sciences 27). The neglected part is 3/2 |r|/a of the tidal terms:
2e-5 for a net of 100 m at 600 km. The orbit is ideal: drag and pressure do not change the frame's motion.

The tidal part has the potential −m n² (3x² − z²)/2, and the Coriolis force does no work. In free flight the sum of
kinetic energy in this frame, stored energy and this potential is therefore conserved; momentum in this frame is not,
and what the force adds counts as an external impulse.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray, Reals
from netdae.core.errors import InputError
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.forces.law import Law, Shares, compiled
from netdae.model.material import Cords
from netdae.model.net import CableNet


class OrbitForce(NamedTuple):
    """Parameters of f = m (3n² x + 2n ẏ, −2n ẋ, −n² z) on each node."""

    mass: Reals  # (m,), kg
    mean_motion: float  # n, rad/s


@compiled
def _force(p: OrbitForce, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    n, m = p.mean_motion, p.mass[e]
    f.external[0, 0] = m * (3.0 * n * n * x[0, 0] + 2.0 * n * v[0, 1])
    f.external[0, 1] = -m * 2.0 * n * v[0, 0]
    f.external[0, 2] = -m * n * n * x[0, 2]
    return True


@compiled
def _tangent(
    p: OrbitForce, e: int, s: FloatArray, x: FloatArray, v: FloatArray, K: FloatArray, C: FloatArray
) -> bool:
    """m diag(3n², 0, −n²), and the Coriolis term's unsymmetric 2 m n (e_x e_yᵀ − e_y e_xᵀ)."""
    n, m = p.mean_motion, p.mass[e]
    K[0, 0, 0, 0], K[0, 2, 0, 2] = 3.0 * n * n * m, -n * n * m
    C[0, 0, 0, 1], C[0, 1, 0, 0] = 2.0 * n * m, -2.0 * n * m
    return True


# its tangent is of the size n² and n against c_j² and c_j: negligible in the Newton matrix
ORBIT = Law(
    OrbitForce,
    force=_force,
    tangent=_tangent,
    nodes=1,
    shares=("external",),
    external=True,
    newton="nothing",
)


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
        return ElementForce(ORBIT, nodes[:, None], OrbitForce(mass[nodes], self.mean_motion))
