"""The residual for the compiled driver of IDA, and the rates of the energy balance.

Symbols as in `stepper`: F₁ = ẋ − v and F₂ = M v̇ − f. Arrays are flat, y = (x, v) (6n,) with node i at 3i. Forces are
those of the table. Restrained axes that are linear in time are predicted exactly, others are set by Newton's
correction, so that r₁ and r₂ vanish on them up to round-off: their coupling is left out of K.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from netdae.core.arrays import Flags, FloatArray, Reals, Wholes
from netdae.core.compilation import INLINED
from netdae.core.records import load
from netdae.forces.loops import DISSIPATED, FORCE, STRAIN, TENSION
from netdae.forces.table import Rows, add_forces, add_rates, set_time, sift

OPTIONS = {"cache": True, **INLINED}

RATES = 8
"""Dissipated power, external power, force (3,), torque (3,): the rates that are summed over steps."""


class Net(NamedTuple):
    """What moves, and what acts on it.

    Restrained axes are at place + speed (t − since). The table's elements that may act stay the same while no
    coordinate is farther than `reach` from near_x: two nodes then part by no more than 2√3 `reach`.
    """

    rows: int  # address of the table's
    mass: Reals  # (n,), kg
    in_space: Flags  # (n,), False on drums, which have neither momentum nor place
    entry: Wholes  # (c,), restrained entries of x
    place: Reals  # (c,), m
    speed: Reals  # (c,), m/s
    gain: Reals  # (c,), m/s²
    since: Reals  # (1,), s
    curved_axes: bool  # whether Python sets these axes
    near_x: Reals  # (3n,), m
    reach: float  # m
    pose: int  # address of the target's attitude, or 0
    spin: int  # its entries in x and v begin here
    f: Reals  # (3n,), N, workspace
    sums: Reals  # (15,), workspace, see `forces.loops`


@njit(**OPTIONS)
def look(x: FloatArray, net: Net, rows: Rows) -> None:
    """Find anew the elements that may act if the net has moved too far."""
    far = 0
    for k in range(len(x)):
        far += not abs(x[k] - net.near_x[k]) <= net.reach  # counts not-a-number
    if far > 0:
        for k in range(len(x)):
            net.near_x[k] = x[k]
        margin = 2.0 * np.sqrt(3.0) * net.reach
        sift(rows, x, margin, 2.0 * margin, 0)


@njit(**OPTIONS)
def forces(t: float, x: FloatArray, v: FloatArray, net: Net) -> None:
    """Write all forces to net.f."""
    rows = load(net.rows, Rows)
    for k in range(len(net.f)):
        net.f[k] = 0.0
    set_time(rows, t)
    look(x, net, rows)
    add_forces(rows, x, v, v, net.f, 0, net.sums)


@njit(**OPTIONS)
def residual(t: float, y: FloatArray, yp: FloatArray, net: Net, F: FloatArray) -> int:
    """Write F₁ and F₂ to F; return the first entry that is not finite, or −1."""
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
    for c in range(len(net.entry)):
        k = net.entry[c]
        F1[k] = x[k] - (net.place[c] + net.speed[c] * (t - net.since[0]))
        F2[k] = v[k] - net.speed[c]
    total = 0.0
    for k in range(2 * n3):
        total += F[k]
    if np.isfinite(total):
        return -1
    for k in range(2 * n3):
        if not np.isfinite(F[k]):
            return k
    return -1  # a sum of finite numbers may overflow


@njit(**OPTIONS)
def rates(t: float, y: FloatArray, net: Net, out: FloatArray) -> float:
    """Write powers and external wrench at y to out (8,); return the largest tension, N."""
    n3 = 3 * len(net.mass)
    x, v, sums = y[:n3], y[n3:], net.sums
    rows = load(net.rows, Rows)
    sums[:] = 0.0
    sums[STRAIN] = -np.inf
    set_time(rows, t)
    look(x, net, rows)
    add_rates(rows, x, v, sums, 0)
    for q in range(RATES):
        out[q] = sums[DISSIPATED + q]
    peak = np.sqrt(sums[TENSION])
    if len(net.entry) > 0:
        forces(t, x, v, net)
        for c in range(len(net.entry)):
            k = net.entry[c]
            reaction = net.mass[k // 3] * net.gain[c] - net.f[k]
            out[1] += reaction * net.speed[c]
            if net.in_space[k // 3]:
                add_wrench(x, k, reaction, out)
    return peak


@njit(**OPTIONS)
def add_wrench(x: FloatArray, k: int, force: float, out: FloatArray) -> None:
    """Add the force along entry k of x, and its moment about the origin, to out[2:8]."""
    c = k % 3
    node = k - c
    after, before = (c + 1) % 3, (c + 2) % 3
    out[FORCE - DISSIPATED + c] += force
    out[5 + after] += x[node + before] * force
    out[5 + before] -= x[node + after] * force


@njit(**OPTIONS)
def middle(h: float, y0: FloatArray, y1: FloatArray, y: FloatArray) -> None:
    """Write the Hermite midpoint of a step of length h, see `energy_balance`, to y."""
    n3 = len(y) // 2
    for k in range(n3):
        x0, x1, v0, v1 = y0[k], y1[k], y0[n3 + k], y1[n3 + k]
        y[k] = 0.5 * (x0 + x1) + 0.125 * h * (v0 - v1)
        y[n3 + k] = 1.5 / h * (x1 - x0) - 0.25 * (v0 + v1)


@njit(**OPTIONS)
def between(
    h: float, s: float, y0: FloatArray, p0: FloatArray, y1: FloatArray, p1: FloatArray, out: FloatArray
) -> None:
    """x, v, a at the fraction s of a step of length h, to out (9n,): cubics through x with v and through v with a."""
    n3 = len(y0) // 2
    r = 1.0 - s
    w0, w1, d0, d1 = r * r * (1 + 2 * s), s * s * (3 - 2 * s), h * s * r * r, -h * s * s * r
    slope, b0, b1 = 6 * s * r / h, r * (1 - 3 * s), s * (3 * s - 2)
    for k in range(n3):
        v0, v1, a0, a1 = y0[n3 + k], y1[n3 + k], p0[n3 + k], p1[n3 + k]
        out[k] = w0 * y0[k] + w1 * y1[k] + d0 * v0 + d1 * v1
        out[n3 + k] = w0 * v0 + w1 * v1 + d0 * a0 + d1 * a1
        out[2 * n3 + k] = slope * (v1 - v0) + b0 * a0 + b1 * a1
