"""The motor of a winch, with the pawl that lets its drum not wind back.

Both act along x of a reel's node, see `reel`: s in m is the length that the drum has taken up, ṡ its rate.
The motor keeps a speed v as far as a force F goes, with a controller of the width v₀; the pawl is a brake on ṡ < 0:

    f = F γ((v − ṡ)/v₀) + F P(−ṡ/v₁),      γ(u) = u/√(1 + u²),       P(u) = u²/(1 + u) for u > 0, else 0.

P joins with the slope 0. Under a steady load R < F the drum runs at v − v₀ R/√(F² − R²); against R > F it stands, but
for a creep back, at which P = R/F − γ(v/v₀). The motor's power f ṡ comes from outside; its reaction is at the drum, a
matter of the net inside, so no momentum does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from netdae._arrays import FloatArray, IntArray
from netdae.forces.protocol import Account, NewtonPart, Tangent


@njit(cache=True)
def motor_of(
    rate: float, strength: float, speed: float, width: float, creep_speed: float
) -> tuple[float, float, float]:
    """Forces of motor and pawl at ṡ, N, and the derivative of their sum by ṡ."""
    u, back = (speed - rate) / width, max(-rate / creep_speed, 0.0)
    w = 1.0 / np.sqrt(1.0 + u * u)
    slope = w * w * w / width + back * (2.0 + back) / ((1.0 + back) * (1.0 + back)) / creep_speed
    return strength * u * w, strength * back * back / (1.0 + back), -strength * slope


@njit(cache=True)
def _motors(
    v: FloatArray,
    strength: FloatArray,
    speed: FloatArray,
    width: FloatArray,
    creep_speed: FloatArray,
    parts: FloatArray,
) -> None:
    """Motor, pawl and slope of all, into parts (3, m)."""
    for e in range(len(v)):
        parts[0, e], parts[1, e], parts[2, e] = motor_of(
            v[e, 0, 0], strength[e], speed[e], width[e], creep_speed[e]
        )


@dataclass(frozen=True, eq=False)
class Motor:
    """Motors of reels, with pawls, k = 1.

    nodes : (m, 1); strength : F (m,), N; speed : v (m,), m/s
    width : v₀ (m,), m/s; creep_speed : v₁ (m,), m/s
    """

    nodes: IntArray
    strength: FloatArray
    speed: FloatArray
    width: FloatArray
    creep_speed: FloatArray

    newton: NewtonPart = "symmetric"
    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()
    external: bool = False

    def _parts(self, v: FloatArray) -> FloatArray:
        """Forces of motor and pawl in N, and the derivative of their sum by ṡ, (3, m)."""
        parts = np.empty((3, len(v)))
        _motors(v, self.strength, self.speed, self.width, self.creep_speed, parts)
        return parts

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Along x of each reel node, (m, 1, 3), N."""
        f = np.zeros_like(x)
        f[:, 0, 0] = self._parts(v)[:2].sum(axis=0)
        return f

    def tangent(self, t: float, x: FloatArray, v: FloatArray) -> Tangent:
        """Zero and −F (γ′/v₀ + P′/v₁)."""
        C = np.zeros((len(v), 1, 3, 1, 3))
        C[:, 0, 0, 0, 0] = self._parts(v)[2]
        return Tangent.of_all(np.zeros_like(C), C)

    def account(self, t: float, x: FloatArray, v: FloatArray) -> Account:
        """The pawl's dissipated power, and the motor's from outside."""
        motor, pawl, _ = self._parts(v)
        rate = v[:, 0, 0]
        return Account(dissipated_power=-float(pawl @ rate), external_power=float(motor @ rate))
