"""The motor of a winch, with the pawl that keeps its drum from winding back.

Both act along x of a reel's node, see `reel`: s in m is the length that the drum has taken up, ṡ its rate.
The motor holds a speed v up to a force F, with a controller of the width v₀; the pawl is a brake on ṡ < 0:

    f = F γ((v − ṡ)/v₀) + F P(−ṡ/v₁),      γ(u) = u/√(1 + u²),       P(u) = u²/(1 + u) for u > 0, else 0.

P joins with slope 0. Under a steady load R < F the drum runs at v − v₀ R/√(F² − R²); against R > F it stands, except
for a creep back, at which P = R/F − γ(v/v₀). The motor's power f ṡ comes from outside; its reaction acts at the drum,
inside the net, so no momentum does.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray, Reals
from netdae.forces.law import Law, Shares, compiled, no_bound


class Motor(NamedTuple):
    """Parameters of the motors of reels, with their pawls, (m,)."""

    strength: Reals  # F, N
    speed: Reals  # v, m/s
    width: Reals  # v₀, m/s
    creep_speed: Reals  # v₁, m/s


@compiled
def _force(p: Motor, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    u, back = (p.speed[e] - v[0, 0]) / p.width[e], max(-v[0, 0] / p.creep_speed[e], 0.0)
    f.external[0, 0] = p.strength[e] * u / np.sqrt(1.0 + u * u)
    f.dissipative[0, 0] = p.strength[e] * back * back / (1.0 + back)
    return True


@compiled
def _tangent(
    p: Motor, e: int, s: FloatArray, x: FloatArray, v: FloatArray, K: FloatArray, C: FloatArray
) -> bool:
    u, back = (p.speed[e] - v[0, 0]) / p.width[e], max(-v[0, 0] / p.creep_speed[e], 0.0)
    w = 1.0 / np.sqrt(1.0 + u * u)
    slope = w * w * w / p.width[e] + back * (2.0 + back) / ((1.0 + back) * (1.0 + back)) / p.creep_speed[e]
    C[0, 0, 0, 0] = -p.strength[e] * slope
    return True


MOTOR = Law(
    Motor,
    force=_force,
    tangent=_tangent,
    nodes=1,
    shares=("dissipative", "external"),
    implicit=True,
    bound=no_bound,
)
