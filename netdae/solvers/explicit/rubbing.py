"""Damping and friction of contact in an explicit step: they are taken at its end, whatever their strength.

Friction μN at the slip speed v_s has the rate μN w/v_s, with the mobility w of a point in kg⁻¹: 4e6 1/s for 100 N on a
knot of 0.7 g, far too much for an explicit step. So both are found point after point, since points share knots, from
the velocity u⁺ of each after the kick by all other forces and by those found before. With the elastic force k δⁿ g from
the table, see `forces.contact`, and y = g·u,

    D = −a ((1−θ) y + θ y⁺),  a = 1.5 λ k δⁿ,  D ≥ −k δⁿ,       y⁺ = y' + h w_g D,       θ = max(½, 1 − 1/(h w_g a))
    T = −μ N |g| u_t⁺/σ(u_t⁺),                                u_t⁺ = u_t' + h w_t T

are what damping adds to N and the force of friction. y is that before the kick, y' and u_t' those after it, w_g and w_t
the mobilities along g and u_t. Weak damping is of the second order, and any is stable. Friction never exceeds μN, and a
steady creep of one point is exact.
"""

from __future__ import annotations

from math import sqrt
from typing import Any, NamedTuple

from numba import njit

from netdae.core.addresses import floats
from netdae.core.arrays import FloatArray, Wholes
from netdae.core.compilation import OPTIONS
from netdae.core.records import load
from netdae.forces.contact import (
    DAMPING,
    FORCE,
    NORMAL,
    POINT,
    RUBBING,
    UPRIGHT,
    Meeting,
    Resting,
    cross,
    dot,
    seen,
    shown,
)
from netdae.forces.law import Vector
from netdae.forces.loops import ACTED, Elements
from netdae.forces.pose import Matrix, Pose

INLINED: dict[str, Any] = {"cache": True, "forceinline": True, **OPTIONS}
ITERATIONS = 8
"""Newton's, for the slip after friction; it comes from below and converges with the second order."""


class Contacts(NamedTuple):
    """Elements of forces of contact: addresses of those with a target, and of those with obstacles.

    way : address of what elements that sleep wait for, see `forces.contact`
    """

    way: int
    meeting: Wholes
    resting: Wholes


@njit(**INLINED)
def _velocity(
    i: int,
    j: int,
    at: int,
    s: float,
    b: Vector,
    R: Matrix,
    rho: Vector,
    v: FloatArray,
    f: FloatArray,
    kick: FloatArray,
    share: float,
) -> Vector:
    """u with the velocities v + share · kick · f; `at` is the place's entry, or −1 for a body that is fixed."""
    r = 1.0 - s
    a0 = r * (v[i] + share * kick[i] * f[i]) + s * (v[j] + share * kick[j] * f[j])
    a1 = r * (v[i + 1] + share * kick[i + 1] * f[i + 1]) + s * (v[j + 1] + share * kick[j + 1] * f[j + 1])
    a2 = r * (v[i + 2] + share * kick[i + 2] * f[i + 2]) + s * (v[j + 2] + share * kick[j + 2] * f[j + 2])
    if at < 0:
        return a0, a1, a2
    a0 -= v[at] + share * kick[at] * f[at]
    a1 -= v[at + 1] + share * kick[at + 1] * f[at + 1]
    a2 -= v[at + 2] + share * kick[at + 2] * f[at + 2]
    a = seen(R, a0, a1, a2)
    W = (
        (v[at + 3] + share * kick[at + 3] * f[at + 3]) / rho[0],
        (v[at + 4] + share * kick[at + 4] * f[at + 4]) / rho[1],
        (v[at + 5] + share * kick[at + 5] * f[at + 5]) / rho[2],
    )
    c = cross(b, W)
    return a[0] + c[0], a[1] + c[1], a[2] + c[2]


@njit(**INLINED)
def _mobility(
    i: int, j: int, at: int, s: float, b: Vector, g: Vector, R: Matrix, rho: Vector, kick: FloatArray
) -> float:
    """Gain of g·u in a step by a force g on the point, h times its mobility."""
    r, G, total = 1.0 - s, shown(R, g), 0.0
    for c in range(3):
        one, other = r * G[c], s * G[c]
        if i == j:
            total += kick[i + c] * G[c] * G[c]
        else:
            total += kick[i + c] * one * one + kick[j + c] * other * other
    if at >= 0:
        T = cross(b, g)
        for c in range(3):
            total += kick[at + c] * G[c] * G[c] + kick[at + 3 + c] * (T[c] / rho[c]) ** 2
    return total


@njit(**INLINED)
def _push(
    i: int, j: int, at: int, s: float, b: Vector, F: Vector, R: Matrix, rho: Vector, f: FloatArray
) -> None:
    """Add a force on the point, and its reaction, to f."""
    G, T = shown(R, F), cross(F, b)
    for c in range(3):
        f[i + c] += (1.0 - s) * G[c]
        f[j + c] += s * G[c]
        if at >= 0:
            f[at + c] -= G[c]
            f[at + 3 + c] += T[c] / rho[c]


@njit(**INLINED)
def _slip_after(before: float, B: float, slow: float) -> float:
    """The r with r + B r/√(r² + slow²) = before, m/s."""
    r = before * slow / (slow + B)
    for _ in range(ITERATIONS):
        root = sqrt(r * r + slow * slow)
        miss = r + B * r / root - before
        step = miss / (1.0 + B * slow * slow / (root * root * root))
        r -= step
        if abs(step) <= 1e-14 * before:
            break
    return r


@njit(**INLINED)
def _rub_one(
    p: Any,
    e: int,
    i: int,
    j: int,
    at: int,
    R: Matrix,
    rho: Vector,
    v: FloatArray,
    f: FloatArray,
    kick: FloatArray,
) -> None:
    met, s = p.met[e], p.place[e]
    N = met[FORCE]
    b, g = (met[POINT], met[POINT + 1], met[POINT + 2]), (met[NORMAL], met[NORMAL + 1], met[NORMAL + 2])
    gg = dot(g, g)
    D = 0.0
    if p.dissipation[e] > 0.0:
        a, w = 1.5 * p.dissipation[e] * N, _mobility(i, j, at, s, b, g, R, rho, kick)
        before = dot(g, _velocity(i, j, at, s, b, R, rho, v, f, kick, 0.0))
        after = dot(g, _velocity(i, j, at, s, b, R, rho, v, f, kick, 1.0))
        theta = max(0.5, 1.0 - 1.0 / (w * a)) if w * a > 0.0 else 0.5
        D = -a * ((1.0 - theta) * before + theta * after) / (1.0 + theta * a * w)
        D = max(D, -N)
        _push(i, j, at, s, b, (D * g[0], D * g[1], D * g[2]), R, rho, f)
    met[DAMPING] = D
    T = 0.0, 0.0, 0.0
    if p.friction[e] > 0.0:
        u = _velocity(i, j, at, s, b, R, rho, v, f, kick, 1.0)
        gu = dot(g, u) / gg
        t = u[0] - gu * g[0], u[1] - gu * g[1], u[2] - gu * g[2]
        slip = sqrt(dot(t, t))
        limit = p.friction[e] * (N + D) * sqrt(gg)
        if slip > 0.0 and limit > 0.0:
            n = t[0] / slip, t[1] / slip, t[2] / slip
            w = _mobility(i, j, at, s, b, n, R, rho, kick)
            r = _slip_after(slip, limit * w, p.slip_speed[e])
            size = -limit * r / sqrt(r * r + p.slip_speed[e] ** 2)
            T = size * n[0], size * n[1], size * n[2]
            _push(i, j, at, s, b, T, R, rho, f)
    met[RUBBING], met[RUBBING + 1], met[RUBBING + 2] = T


@njit(**INLINED)
def _power_of(
    p: Any,
    e: int,
    i: int,
    j: int,
    at: int,
    R: Matrix,
    rho: Vector,
    v: FloatArray,
    f: FloatArray,
    kick: FloatArray,
) -> float:
    """Power in W that damping and friction of one take, with the mean of the velocities before and after the kick."""
    met = p.met[e]
    b, g = (met[POINT], met[POINT + 1], met[POINT + 2]), (met[NORMAL], met[NORMAL + 1], met[NORMAL + 2])
    u = _velocity(i, j, at, p.place[e], b, R, rho, v, f, kick, 0.5)
    T = met[RUBBING], met[RUBBING + 1], met[RUBBING + 2]
    return -met[DAMPING] * dot(g, u) - dot(T, u)


@njit(**INLINED)
def put_way(contacts: Contacts, way: float) -> None:
    """Let elements know how far two points may have parted since those near were found, m."""
    floats(contacts.way, 1)[0] = way


@njit(cache=True, **OPTIONS, forceinline=True)
def rub(v: FloatArray, f: FloatArray, kick: FloatArray, contacts: Contacts, row: FloatArray) -> float:
    """Add damping and friction to f, which holds all other forces; return the power in W that they take.

    kick : (3n,), h/mass, zero on restrained axes
    row : (6,), gains the force and the torque about the origin of obstacles, which are external
    """
    lost = 0.0
    for a in contacts.meeting:
        el = load(a, Elements)
        p: Any = load(el.parameters, Meeting)
        pose = load(p.pose, Pose)
        k = pose.known
        R = k[7], k[8], k[9], k[10], k[11], k[12], k[13], k[14], k[15]
        rho = pose.rho[0], pose.rho[1], pose.rho[2]
        count = el.counts[ACTED]
        for q in range(count):
            e = el.acted[q]
            _rub_one(p, e, el.nodes[e, 0], el.nodes[e, 1], el.nodes[e, 2], R, rho, v, f, kick)
        for q in range(count):
            e = el.acted[q]
            lost += _power_of(p, e, el.nodes[e, 0], el.nodes[e, 1], el.nodes[e, 2], R, rho, v, f, kick)
    one = (1.0, 1.0, 1.0)
    for a in contacts.resting:
        el = load(a, Elements)
        o: Any = load(el.parameters, Resting)
        count = el.counts[ACTED]
        for q in range(count):
            e = el.acted[q]
            _rub_one(o, e, el.nodes[e, 0], el.nodes[e, 1], -1, UPRIGHT, one, v, f, kick)
            met = o.met[e]
            F = (
                met[DAMPING] * met[NORMAL] + met[RUBBING],
                met[DAMPING] * met[NORMAL + 1] + met[RUBBING + 1],
                met[DAMPING] * met[NORMAL + 2] + met[RUBBING + 2],
            )
            T = cross((met[POINT], met[POINT + 1], met[POINT + 2]), F)
            for c in range(3):
                row[c] += F[c]
                row[3 + c] += T[c]
        for q in range(count):
            e = el.acted[q]
            lost += _power_of(o, e, el.nodes[e, 0], el.nodes[e, 1], -1, UPRIGHT, one, v, f, kick)
    return lost
