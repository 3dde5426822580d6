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

from netdae._arrays import FloatArray, IntArray
from netdae.forces.protocol import Account, NewtonPart, Tangent


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

    def _parts(self, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Forces of motor and pawl, (m,), N."""
        u = (self.speed - v[:, 0, 0]) / self.width
        back = np.maximum(-v[:, 0, 0] / self.creep_speed, 0.0)
        return self.strength * u / np.sqrt(1 + u * u), self.strength * back * back / (1 + back)

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Along x of each reel node, (m, 1, 3), N."""
        f = np.zeros_like(x)
        f[:, 0, 0] = np.sum(self._parts(v), axis=0)
        return f

    def tangent(self, t: float, x: FloatArray, v: FloatArray) -> Tangent:
        """Zero and −F (γ′/v₀ + P′/v₁)."""
        u = (self.speed - v[:, 0, 0]) / self.width
        back = np.maximum(-v[:, 0, 0] / self.creep_speed, 0.0)
        C = np.zeros((len(u), 1, 3, 1, 3))
        slope = (1 + u * u) ** -1.5 / self.width + back * (2 + back) / (1 + back) ** 2 / self.creep_speed
        C[:, 0, 0, 0, 0] = -self.strength * slope
        return Tangent.of_all(np.zeros_like(C), C)

    def account(self, t: float, x: FloatArray, v: FloatArray) -> Account:
        """The pawl's dissipated power, and the motor's from outside."""
        motor, pawl = self._parts(v)
        rate = v[:, 0, 0]
        return Account(dissipated_power=-float(pawl @ rate), external_power=float(motor @ rate))
