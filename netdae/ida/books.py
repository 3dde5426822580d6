"""The books of the compiled driver of IDA: what they gain per second, and the cubics between two steps.

Symbols as in `ledger`, whose rule is followed: Simpson's with the Hermite midpoint.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from netdae._arrays import FloatArray
from netdae.ida.asking import ask_held
from netdae.ida.further_calls import add_further_rates
from netdae.ida.kernel import OPTIONS, Net, forces, look, parts_of
from netdae.ida.outside import add_wrench
from netdae.kernels.cables import drag

RATES = 8  # dissipated power, external power, force (3,), torque (3,)


@njit(**OPTIONS)
def rates(t: float, y: FloatArray, net: Net, out: FloatArray) -> float:
    """What the books gain per second at y, into out (8,); the largest tension, N."""
    n3 = 3 * len(net.mass)
    x, v, cords, drags, push, held, f = y[:n3], y[n3:], net.cords, net.drags, net.push, net.held, net.f
    power, peak2 = 0.0, 0.0
    for p in range(look(x, cords, net.near)):
        e = net.near.cables[p]
        i, j = cords.ends[e, 0], cords.ends[e, 1]
        dx, dy, dz = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
        l2 = dx * dx + dy * dy + dz * dz
        excess = l2 - cords.L2[e]
        if excess < 0.0:
            continue
        rate = dx * (v[j] - v[i]) + dy * (v[j + 1] - v[i + 1]) + dz * (v[j + 2] - v[i + 2])
        elastic, viscous = parts_of(cords, e, excess, rate)
        power += (max(elastic + viscous, 0.0) - elastic) * rate
        peak2 = max(peak2, elastic * elastic * l2)
    out[:] = 0.0
    if len(drags.ends) > 0 or len(drags.alpha) > 0:
        drag(v, drags, f)
        for k in range(n3):
            power -= f[k] * v[k]
    out[0] = power
    for k in range(len(drags.alpha)):
        add_wrench(x, k, -drags.alpha[k] * v[k], out)
    for k in range(len(push.start)):
        p = push.start[k] + push.rate[k] * (t - push.since)
        out[1] += p * v[k]
        if net.in_space[k // 3]:
            add_wrench(x, k, p, out)
    peak = np.sqrt(peak2)
    if net.further != 0:
        peak = max(peak, add_further_rates(net.further, t, x, v, f, out))
        ask_held(net.further, t)
    if len(held.entry) > 0:
        forces(t, x, v, net)
        for c in range(len(held.entry)):
            k = held.entry[c]
            reaction = net.mass[k // 3] * held.gain[c] - f[k]
            out[1] += reaction * held.speed[c]
            if net.in_space[k // 3]:
                add_wrench(x, k, reaction, out)
    return peak


@njit(**OPTIONS)
def middle(h: float, y0: FloatArray, y1: FloatArray, y: FloatArray) -> None:
    """The Hermite midpoint of a step of length h, see `ledger`, into y."""
    n3 = len(y) // 2
    for k in range(n3):
        x0, x1, v0, v1 = y0[k], y1[k], y0[n3 + k], y1[n3 + k]
        y[k] = 0.5 * (x0 + x1) + 0.125 * h * (v0 - v1)
        y[n3 + k] = 1.5 / h * (x1 - x0) - 0.25 * (v0 + v1)


@njit(**OPTIONS)
def between(
    h: float, s: float, y0: FloatArray, p0: FloatArray, y1: FloatArray, p1: FloatArray, out: FloatArray
) -> None:
    """x, v and a at the share s of a step of length h into out (9n,): cubics through x with v and through v with a."""
    n3 = len(y0) // 2
    r = 1.0 - s
    w0, w1, d0, d1 = r * r * (1 + 2 * s), s * s * (3 - 2 * s), h * s * r * r, -h * s * s * r
    slope, b0, b1 = 6 * s * r / h, r * (1 - 3 * s), s * (3 * s - 2)
    for k in range(n3):
        v0, v1, a0, a1 = y0[n3 + k], y1[n3 + k], p0[n3 + k], p1[n3 + k]
        out[k] = w0 * y0[k] + w1 * y1[k] + d0 * v0 + d1 * v1
        out[n3 + k] = w0 * v0 + w1 * v1 + d0 * a0 + d1 * a1
        out[2 * n3 + k] = slope * (v1 - v0) + b0 * a0 + b1 * a1
