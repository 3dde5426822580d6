"""What holds the drum of a reel: its brake, and the stops at the ends of its travel.

Both act along x of the reel's node, see `reel`: s in m is the length paid out, ṡ its rate.

The brake is dry friction F_b, made smooth by a creep speed v₀, with a viscous part c:

    f = −F_b γ(ṡ/v₀) − c ṡ,        γ(u) = u/√(1 + u²);  with a ratchet γ(u) = u for u < 0.

Both branches of γ join with slope 1 and curvature 0. A steady pull F below F_b does not quite hold: γ = F/F_b
gives a creep of v₀ F/√(F_b² − F²), which is v₀/√3 at half of F_b. Winding back against a ratchet is a creep of
v₀ F/F_b, whatever the pull.

A stop at s_e is a spring k with a damper c, one-sided: with the travel δ beyond it and p = k δ + c δ̇, not below zero,

    f = −p towards where s came from,        stored ½ k δ²,        dissipated (p − k δ) δ̇.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from netdae.core.arrays import Flags, FloatArray, IntArray, Reals
from netdae.forces.law import Family, Law, Shares, compiled, no_bound


@compiled
def friction_of(u: float, ratchet: bool) -> tuple[float, float]:
    """γ(u) and γ′(u)."""
    if ratchet and u < 0.0:
        return u, 1.0
    w = 1.0 / np.sqrt(1.0 + u * u)
    return u * w, w * w * w


class Brake(NamedTuple):
    """Parameters of the friction on the drums of reels, (m,)."""

    friction: Reals  # F_b, N
    creep_speed: Reals  # v₀, m/s
    viscosity: Reals  # c, N s/m
    ratchet: Flags  # True where the drum does not wind back by itself


@compiled
def _brake(p: Brake, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    smooth, _ = friction_of(v[0, 0] / p.creep_speed[e], p.ratchet[e])
    f.dissipative[0, 0] = -p.friction[e] * smooth - p.viscosity[e] * v[0, 0]
    return True


@compiled
def _brake_tangent(
    p: Brake, e: int, s: FloatArray, x: FloatArray, v: FloatArray, K: FloatArray, C: FloatArray
) -> bool:
    _, slope = friction_of(v[0, 0] / p.creep_speed[e], p.ratchet[e])
    C[0, 0, 0, 0] = -p.friction[e] * slope / p.creep_speed[e] - p.viscosity[e]
    return True


class EndStop(NamedTuple):
    """Parameters of stops at the ends of the travel of reels, (m,)."""

    place: Reals  # s_e, m
    side: Reals  # 1 for a stop that s reaches from below, −1 from above
    stiffness: Reals  # k, N/m
    viscosity: Reals  # c, N s/m


@compiled
def _stop(p: EndStop, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    way = p.side[e] * (x[0, 0] - p.place[e])
    if not way > 0.0:
        return False
    spring = p.stiffness[e] * way
    push = max(spring + p.viscosity[e] * p.side[e] * v[0, 0], 0.0)
    f.conservative[0, 0] = -p.side[e] * spring
    f.dissipative[0, 0] = -p.side[e] * (push - spring)
    return True


@compiled
def _stop_tangent(
    p: EndStop, e: int, s: FloatArray, x: FloatArray, v: FloatArray, K: FloatArray, C: FloatArray
) -> bool:
    way = p.side[e] * (x[0, 0] - p.place[e])
    if not (way > 0.0 and p.stiffness[e] * way + p.viscosity[e] * p.side[e] * v[0, 0] > 0.0):
        return False
    K[0, 0, 0, 0], C[0, 0, 0, 0] = -p.stiffness[e], -p.viscosity[e]
    return True


@compiled
def _stop_energy(p: EndStop, e: int, x: FloatArray) -> float:
    way = max(p.side[e] * (x[0, 0] - p.place[e]), 0.0)
    return 0.5 * p.stiffness[e] * way * way


def _stop_bound(p: EndStop, nodes: IntArray, strain: float, x: FloatArray) -> list[Family]:
    return [Family(nodes, np.stack((p.stiffness, 0 * p.stiffness))[..., None])]


BRAKE = Law(
    Brake,
    force=_brake,
    tangent=_brake_tangent,
    nodes=1,
    shares=("dissipative",),
    implicit=True,
    bound=no_bound,
)
END_STOP = Law(
    EndStop,
    force=_stop,
    tangent=_stop_tangent,
    energy=_stop_energy,
    nodes=1,
    shares=("conservative", "dissipative"),
    implicit=True,
    bound=_stop_bound,
)
