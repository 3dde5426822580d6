"""A free body in explicit steps: torques kick its angular momentum, and between kicks it turns by plane rotations.

The free motion of a rigid body is that of three spins about fixed axes of its own, taken in turn:

    1(h/2) 2(h/2) 3(h) 2(h/2) 1(h/2)       with  a(h): a turn by h Lₐ/Iₐ about axis a,

where L is its angular momentum in these axes (R. I. McLachlan 1993, Physical Review Letters 71, 3043; A. Dullweber,
B. Leimkuhler, R. McLachlan 1997, Journal of Chemical Physics 107, 5840). Each of them is exact, so that the angular
momentum in space is kept to round-off and the energy oscillates by (h |W|)² without drift. Three passes in a row, of
γ h, (1 − 2γ) h and γ h with γ = 1/(2 − ∛2), are of the fourth order (H. Yoshida 1990, Physics Letters A 150, 262). A
body on which nothing acts turns through many steps at once.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from netdae.core.arrays import FloatArray
from netdae.core.compilation import FAST
from netdae.core.records import load
from netdae.forces.pose import ANGLE, Pose, product, put_base, rates_of

FINEST = 2e-4
"""rad, in one pass through the axes: in the flip of an intermediate axis energy then oscillates by 5e-10 of itself."""

COARSEST = 5e-3
"""rad, in three passes: then by 2e-12."""

GAMMA = 1.0 / (2.0 - 2.0 ** (1.0 / 3.0))
TRIPLE = (GAMMA, 1.0 - 2.0 * GAMMA, GAMMA)

ORDER = ((0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5))
"""Axes in their turn, and shares of the time."""


@njit(cache=True, fastmath=FAST, forceinline=True)
def turn(x: FloatArray, v: FloatArray, h: float, t: float, address: int, at: int) -> None:
    """Turn the body freely for h s up to t, with its spin node's entries from `at` on."""
    pose = load(address, Pose)
    rho, base = pose.rho, pose.base
    W = rates_of(pose, v, at)
    spin = np.sqrt(W[0] * W[0] + W[1] * W[1] + W[2] * W[2])
    triple = h * spin > FINEST
    passes = 3 * (1 + int(h * spin / COARSEST)) if triple else 1
    whole = 3.0 * h / passes if triple else h
    q = base[0], base[1], base[2], base[3]
    L, angle, inverse = np.empty(3), np.zeros(3), np.empty(3)
    for c in range(3):
        L[c], inverse[c] = rho[c] * rho[c] * W[c], 1.0 / (rho[c] * rho[c])
    for k in range(passes):
        dt = whole * TRIPLE[k % 3] if triple else whole
        for a, share in ORDER:
            b, c = (a + 1) % 3, (a + 2) % 3
            theta = share * dt * L[a] * inverse[a]
            cosine, sine = np.cos(theta), np.sin(theta)
            L[b], L[c] = cosine * L[b] + sine * L[c], cosine * L[c] - sine * L[b]
            half, angle[a] = np.sin(0.5 * theta), angle[a] + theta
            q = product(
                q,
                (np.cos(0.5 * theta), half * (a == 0), half * (a == 1), half * (a == 2)),
            )
    for c in range(3):
        x[at + c] = rho[c] * (base[ANGLE + c] + angle[c])
        v[at + c] = rho[c] * L[c] * inverse[c]
    put_base(pose, q, rates_of(pose, x, at), rates_of(pose, v, at), t)


@njit(cache=True, fastmath=FAST, forceinline=True)
def pace_of(v: FloatArray, address: int, at: int, radius: float) -> float:
    """Speed in m/s at which the points of a body within `radius` may move by its spin."""
    W = rates_of(load(address, Pose), v, at)
    return radius * np.sqrt(W[0] * W[0] + W[1] * W[1] + W[2] * W[2])


@njit(cache=True, fastmath=FAST, forceinline=True)
def attitude_now(address: int, out: FloatArray) -> None:
    """Write q of the base to out (4,)."""
    base = load(address, Pose).base
    for c in range(4):
        out[c] = base[c]
