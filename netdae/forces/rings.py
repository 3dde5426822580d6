"""The path of a cord through rings: the rings, and the lengths between them.

Symbols, for a cord through the rings 0 to k − 1 with p segments (p = k − 1 open, p = k closed, where the last segment
ends at ring 0): d_i, w_i differences of position and velocity along segment i, η size of a ring.

    h_i = √(d_i·d_i + η²),    u_i = d_i/h_i,    ḣ_i = u_i·w_i,    l = Σ h_i

Rings of the size η touch where their nodes coincide, and a cord needs η from one to the next: nothing is divided by
zero, and where h ≫ η, h exceeds |d| by η²/2h.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError


@dataclass(frozen=True)
class Rings:
    """The rings that a cord slides through.

    size : η, m, the least length of cord from one ring to the next
    friction : μ, by the capstan rule; creep_speed : v₀, m/s, at which friction has seven tenths of μ
    fastened : True where the cord's end is tied to its last ring; False where both ends go into the drum

    Raises InputError for values out of range.
    """

    size: float = 1e-3
    friction: float = 0.0
    creep_speed: float = 1e-2
    fastened: bool = True

    def __post_init__(self) -> None:
        for name in ("size", "creep_speed"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"rings: {name} is {value:g}: give a finite number above zero")
        if not (math.isfinite(self.friction) and self.friction >= 0):
            raise InputError(f"rings: friction is {self.friction:g}: give a finite number, zero or more")


class Cord(NamedTuple):
    """Parameters of one cord.

    L : L̄₀, m; share : σ; EA : EĀ, N; eps : ε; engineering : law; tau : τ, s
    size : η, m; friction : μ; creep_speed : v₀, m/s; theta : θ; segments : p
    """

    L: float
    share: float
    EA: float
    eps: float
    engineering: bool
    tau: float
    size: float
    friction: float
    creep_speed: float
    theta: float
    segments: int = 0


class Way(NamedTuple):
    """A cord's path through its rings at one state.

    u : (p, 3); h, h_rate : h_i and ḣ_i, (p,); length, rate : l and l̇
    """

    u: FloatArray
    h: FloatArray
    h_rate: FloatArray
    length: float
    rate: float


@njit(cache=True, forceinline=True)
def way_through(x: FloatArray, v: FloatArray, p: int, size: float) -> Way:
    """The path from the rings' x and v, (k + 1, 3); the last of these is the reel's node."""
    k = len(x) - 1
    u, h, h_rate = np.empty((p, 3)), np.empty(p), np.empty(p)
    length = rate = 0.0
    for i in range(p):
        j = (i + 1) % k
        square, product = size * size, 0.0
        for a in range(3):
            d = x[j, a] - x[i, a]
            square += d * d
            product += d * (v[j, a] - v[i, a])
        h[i] = np.sqrt(square)
        h_rate[i] = product / h[i]
        for a in range(3):
            u[i, a] = (x[j, a] - x[i, a]) / h[i]
        length += h[i]
        rate += h_rate[i]
    return Way(u, h, h_rate, length, rate)


@njit(cache=True, forceinline=True)
def way_length(x: FloatArray, p: int, size: float) -> float:
    """l, m."""
    k, length = len(x) - 1, 0.0
    for i in range(p):
        j = (i + 1) % k
        dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        length += np.sqrt(size * size + dx * dx + dy * dy + dz * dz)
    return length


@njit(cache=True, forceinline=True)
def add_along(
    way: Way, v: FloatArray, i: int, by_length: float, by_rate: float, gradient: FloatArray
) -> None:
    """Gradient (k + 1, 3) by the rings' positions gains by_length ∇h_i + by_rate ∇ḣ_i, ∇ḣ_i = (w_i − ḣ_i u_i)/h_i."""
    j = (i + 1) % (len(v) - 1)
    for a in range(3):
        turned = (v[j, a] - v[i, a] - way.h_rate[i] * way.u[i, a]) / way.h[i]
        gained = by_length * way.u[i, a] + by_rate * turned
        gradient[j, a] += gained
        gradient[i, a] -= gained
