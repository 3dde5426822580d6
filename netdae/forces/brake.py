"""What holds the drum of a reel: its brake, and the stops at the ends of its way.

Both act along x of the reel's node, see `reel`: s in m is the length paid out, ṡ its rate.

The brake is dry friction F_b, made smooth by a creep speed v₀, with a viscous part c:

    f = −F_b γ(ṡ/v₀) − c ṡ,        γ(u) = u/√(1 + u²);  with a ratchet γ(u) = u for u < 0.

Both branches of γ join with the slope 1 and the curvature 0. A steady pull F below F_b does not quite hold: γ = F/F_b
gives a creep of v₀ F/√(F_b² − F²), which is v₀/√3 at half of F_b. Winding back against a ratchet is a creep of
v₀ F/F_b, whatever the pull.

A stop at s_e is a spring k with a damper c, one-sided: with the way δ beyond it and p = k δ + c δ̇, not below zero,

    f = −p towards where s came from,        stored ½ k δ²,        dissipated (p − k δ) δ̇.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.forces.protocol import Account, NewtonPart, Tangent


@njit(cache=True)
def friction_of(u: float, ratchet: bool) -> tuple[float, float]:
    """γ(u) and γ′(u)."""
    if ratchet and u < 0.0:
        return u, 1.0
    w = 1.0 / np.sqrt(1.0 + u * u)
    return u * w, w * w * w


@njit(cache=True)
def _brakes(
    v: FloatArray,
    friction: FloatArray,
    creep_speed: FloatArray,
    viscosity: FloatArray,
    ratchet: BoolArray,
    f: FloatArray,
    C: FloatArray,
) -> float:
    """f (m,) and C = ∂f/∂ṡ (m,) of all brakes, and the power that they take."""
    power = 0.0
    for e in range(len(v)):
        rate = v[e, 0, 0]
        smooth, slope = friction_of(rate / creep_speed[e], ratchet[e])
        f[e] = -friction[e] * smooth - viscosity[e] * rate
        C[e] = -friction[e] * slope / creep_speed[e] - viscosity[e]
        power -= f[e] * rate
    return power


@njit(cache=True)
def push_of(way: float, rate: float, stiffness: float, viscosity: float) -> float:
    """p."""
    return max(stiffness * way + viscosity * rate, 0.0) if way > 0.0 else 0.0


@njit(cache=True)
def _stops(
    x: FloatArray,
    v: FloatArray,
    place: FloatArray,
    side: FloatArray,
    stiffness: FloatArray,
    viscosity: FloatArray,
    f: FloatArray,
) -> tuple[float, float]:
    """f (m,) of all stops, what they store and the power that they take."""
    stored = power = 0.0
    for e in range(len(x)):
        way, rate = max(side[e] * (x[e, 0, 0] - place[e]), 0.0), side[e] * v[e, 0, 0]
        p = push_of(way, rate, stiffness[e], viscosity[e])
        f[e] = -side[e] * p
        stored += 0.5 * stiffness[e] * way * way
        power += (p - stiffness[e] * way) * rate
    return stored, power


def _along_x(values: FloatArray) -> FloatArray:
    """Force (m, 1, 3) along x."""
    f = np.zeros((len(values), 1, 3))
    f[:, 0, 0] = values
    return f


def _tangent_along_x(elements: IntArray, dx: FloatArray, dv: FloatArray) -> Tangent:
    K, C = np.zeros((2, len(elements), 1, 3, 1, 3))
    K[:, 0, 0, 0, 0], C[:, 0, 0, 0, 0] = dx, dv
    return Tangent(elements, K, C)


@dataclass(frozen=True, eq=False)
class Brake:
    """Friction on the drums of reels, k = 1.

    nodes : (m, 1); friction : F_b (m,), N; creep_speed : v₀ (m,), m/s; viscosity : c (m,), N s/m
    ratchet : (m,), True where the drum does not wind back by itself
    """

    nodes: IntArray
    friction: FloatArray
    creep_speed: FloatArray
    viscosity: FloatArray
    ratchet: BoolArray

    newton: NewtonPart = "symmetric"
    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()
    external: bool = False

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Along x of each reel node, (m, 1, 3), N."""
        return _along_x(self._braked(v)[0])

    def tangent(self, t: float, x: FloatArray, v: FloatArray) -> Tangent:
        """Zero and −F_b γ′/v₀ − c."""
        _, C, _ = self._braked(v)
        return _tangent_along_x(np.arange(len(C)), np.zeros(len(C)), C)

    def account(self, t: float, x: FloatArray, v: FloatArray) -> Account:
        """Dissipated power −f ṡ."""
        return Account(dissipated_power=self._braked(v)[2])

    def _braked(self, v: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        f, C = np.empty((2, len(v)))
        power = _brakes(v, self.friction, self.creep_speed, self.viscosity, self.ratchet, f, C)
        return f, C, power


@dataclass(frozen=True, eq=False)
class EndStop:
    """Stops at the ends of the way of reels, k = 1.

    nodes : (m, 1); place : s_e (m,), m; side : (m,), 1 for a stop that s reaches from below, −1 from above
    stiffness : k (m,), N/m; viscosity : c (m,), N s/m
    """

    nodes: IntArray
    place: FloatArray
    side: FloatArray
    stiffness: FloatArray
    viscosity: FloatArray

    newton: NewtonPart = "symmetric"
    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()
    external: bool = False

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Along x of each reel node, (m, 1, 3), N."""
        return _along_x(self._stopped(x, v)[0])

    def tangent(self, t: float, x: FloatArray, v: FloatArray) -> Tangent:
        """−k and −c of the stops that push."""
        pushing = np.flatnonzero(self._stopped(x, v)[0])
        return _tangent_along_x(pushing, -self.stiffness[pushing], -self.viscosity[pushing])

    def account(self, t: float, x: FloatArray, v: FloatArray) -> Account:
        """Stored ½ k δ² and dissipated (p − k δ) δ̇."""
        return Account(*self._stopped(x, v)[1])

    def _stopped(self, x: FloatArray, v: FloatArray) -> tuple[FloatArray, tuple[float, float]]:
        f = np.empty(len(x))
        return f, _stops(x, v, self.place, self.side, self.stiffness, self.viscosity, f)
