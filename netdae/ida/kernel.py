"""The residual for the compiled driver of IDA, as plain loops; see `ida.matrix` for its Newton matrix.

Symbols as in `stepper`: F₁ = ẋ − v and F₂ = M v̇ − f. Arrays are flat,
y = (x, v) (6n,) with node i at 3i; cables e from i to j with d = xⱼ − xᵢ, w = vⱼ − vᵢ.

It knows cables of all laws with their dashpot, Rayleigh damping, loads and restrained axes that are linear in time. All
that may act beside stands in a record of its own, see `ida.further`: nets without it pay one comparison.
Such axes are predicted exactly, so that r₁ and r₂ vanish on them but for round-off: their coupling is left out of K.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.forces.cables import law_of
from netdae.ida.further_calls import add_further_forces
from netdae.kernels.cables import FAST, Cords, Dashpots, Drags, add_pulls, drag, find_near

OPTIONS = {"cache": True, "fastmath": FAST, "error_model": "numpy"}


class Push(NamedTuple):
    """Loads, linear in time: start + rate (t − since); (3n,) or none where empty."""

    start: FloatArray  # N
    rate: FloatArray  # N/s
    since: float  # s


class Held(NamedTuple):
    """Restrained axes, linear in time: place + speed (t − since)."""

    entry: IntArray  # (c,), entries of x
    place: FloatArray  # (c,), m
    speed: FloatArray  # (c,), m/s
    gain: FloatArray  # (c,), m/s², of those that are asked for, see `ida.asked`
    since: float  # s


class Near(NamedTuple):
    """Cables that may be taut while no coordinate is farther than `reach` from where it was at `x`.

    Two nodes then part by no more than 2√3 `reach`. `cables[:number[0]]` are they, in their order.
    """

    cables: IntArray  # (m,)
    number: IntArray  # (1,)
    x: FloatArray  # (3n,), m
    reach: float  # m


class Net(NamedTuple):
    """What moves and what acts on it."""

    mass: FloatArray  # (n,), kg
    in_space: BoolArray  # (n,), False on drums, which have neither momentum nor place
    cords: Cords
    drags: Drags
    push: Push
    held: Held
    near: Near
    dashpots: Dashpots
    f: FloatArray  # (3n,), N, room to work in
    further: int  # address of the record of all that acts else, see `ida.further`, or 0


@njit(**OPTIONS)
def parts_of(cords: Cords, e: int, excess: float, rate: float) -> tuple[float, float]:
    """The elastic and the viscous part of q, N/m, of a cable with l² − L̄² = excess ≥ 0 and d·w = rate."""
    if cords.plain:
        return cords.half[e] * excess, cords.viscous[e] * rate
    g, dg, _, _ = law_of(0.5 * excess / cords.L2[e], cords.eps[e], cords.engineering[e])
    return g * cords.EA[e] / np.sqrt(cords.L2[e]), cords.viscous[e] * dg * rate


@njit(**OPTIONS)
def look(x: FloatArray, cords: Cords, near: Near) -> int:
    """Find the near cables anew if the net has moved too far; how many they are."""
    far = 0
    for k in range(len(x)):
        far += not abs(x[k] - near.x[k]) <= near.reach  # counts not-a-number
    if far > 0:
        for k in range(len(x)):
            near.x[k] = x[k]
        near.number[0] = find_near(x, cords, 2.0 * np.sqrt(3.0) * near.reach, near.cables)
    return near.number[0]


@njit(**OPTIONS)
def forces(t: float, x: FloatArray, v: FloatArray, net: Net) -> None:
    """All forces into net.f."""
    f, push = net.f, net.push
    if len(net.drags.ends) > 0 or len(net.drags.alpha) > 0:
        drag(v, net.drags, f)
    else:
        f[:] = 0.0
    add_pulls(x, v, net.cords, net.near.cables, look(x, net.cords, net.near), f, net.dashpots)
    for k in range(len(push.start)):
        f[k] += push.start[k] + push.rate[k] * (t - push.since)
    if net.further != 0:
        add_further_forces(net.further, t, x, v, f)


@njit(**OPTIONS)
def residual(t: float, y: FloatArray, yp: FloatArray, net: Net, F: FloatArray) -> int:
    """F₁ and F₂ into F; the first entry that is not finite, or −1."""
    n3 = 3 * len(net.mass)
    x, v, dx, dv = y[:n3], y[n3:], yp[:n3], yp[n3:]
    F1, F2 = F[:n3], F[n3:]
    for k in range(n3):
        F1[k] = dx[k] - v[k]
    forces(t, x, v, net)
    for i in range(len(net.mass)):
        for c in range(3):
            k = 3 * i + c
            F2[k] = net.mass[i] * dv[k] - net.f[k]
    held = net.held
    for c in range(len(held.entry)):
        k = held.entry[c]
        F1[k] = x[k] - (held.place[c] + held.speed[c] * (t - held.since))
        F2[k] = v[k] - held.speed[c]
    total = 0.0
    for k in range(2 * n3):
        total += F[k]
    if np.isfinite(total):
        return -1
    for k in range(2 * n3):
        if not np.isfinite(F[k]):
            return k
    return -1  # a sum of finite numbers may overflow
