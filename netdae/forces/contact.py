"""Contact of knots and whole cables with a rigid body, which is free, driven or fixed.

An element is a cable from node i to node j; a knot is one whose two ends are the same node. Symbols: X place of the
body and R its axes, W its spin about them, V its velocity, see `pose`; φ the signed distance of a part, g = ∇φ and
H = ∇∇φ, in the body's axes; r the cord's radius. At s between 0 and 1

    p = (1−s) xᵢ + s xⱼ,     b = Rᵀ (p − X),     u = Rᵀ (ṗ − V) + b × W,

with u the velocity of the point against the body, in its axes. A cable touches where

    ψ(s) = φ(b(s)) + 4 ε (s − ½)²,     ε = 1 mm,

is least: for a convex part at just one s. It is δ = r − ψ deep, a knot r − φ. The force on the point is

    F = N g − μ N |g| u_t/σ,     N = k δⁿ max(0, 1 − 1.5 λ g·u),     σ = √(u_t² + v_s²),

in the body's axes: the law of K. H. Hunt and F. R. E. Crossley (1975, Journal of Applied Mechanics 42, 440), and
Coulomb's with a slip speed v_s; u_t is u without its part along g. k δⁿ⁺¹/(n+1) is stored; since ψ has its least value
at s, or ends there, k δⁿ g is minus its gradient. The point's velocity is linear in those of the nodes,

    R u = G v,     G = [(1−s) I,  s I,  −I,  R [b]×]      on the velocities of i, j, the body and its spin W,

and the forces on all of them are Gᵀ R F: they have no sum and no moment, whatever R and s.

Newton's matrix gets the symmetric Gᵀ R K_c Rᵀ G and Gᵀ R C_c Rᵀ G with

    K_c = n k δⁿ⁻¹ max(0, 1 − 1.5 λ g·u) g gᵀ,
    C_c = 1.5 λ k δⁿ g gᵀ + (μ N |g|/σ) (I − n nᵀ − u_t u_tᵀ/σ²),     n = g/|g|,

whole, since a part of it would not keep momentum. Where `exact` the tangent has all other parts too: how g, G and s
change. With ψ″ = d·H d + 8 ε, d = Rᵀ (xⱼ − xᵢ), s moves by δs = −δ(g·d)/ψ″ unless it is at an end; a turn δθ of the
body moves b by b × δθ. It holds at the base of the attitude, where a small δΘ is a turn.
"""

from __future__ import annotations

from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from netdae.core.addresses import floats
from netdae.core.arrays import Flags, FloatArray, IntArray, Reals, Reals2, Wholes
from netdae.core.records import load
from netdae.forces.law import Family, Law, Shares, Vector, compiled
from netdae.forces.pose import Matrix, Pose, axes_at
from netdae.model.shapes.distance import curvature_at

REGULAR = 1e-3
"""ε, m."""

ITERATIONS = 30
PLACED, EXACTLY = 1e-9, 1e-13
"""Step of s at which Newton's method ends, and that for an exact tangent; it converges with the second order."""

UPRIGHT: Matrix = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
ORIGIN: Vector = (0.0, 0.0, 0.0)

FORCE, POINT, NORMAL, DAMPING, RUBBING = 0, 1, 4, 7, 8
"""Places in a row of `met`: k δⁿ in N, b (3,), g (3,), what damping adds to N, and the force of friction (3,)."""


class Meeting(NamedTuple):
    """Parameters of elements with a body that moves: i, j, place, spin; (m,) unless said."""

    parts: int  # address of the Parts, in the body's axes
    pose: int  # address of the Pose
    part: Wholes
    radius: Reals  # r, m
    regular: Reals  # ε, m; zero for knots
    stiffness: Reals  # k, N/mⁿ
    exponent: Reals  # n
    dissipation: Reals  # λ, s/m
    friction: Reals  # μ
    slip_speed: Reals  # v_s, m/s
    convex: Flags  # of its part
    lipschitz: Reals  # of its part
    place: Reals  # s of the last evaluation, from which the next one is searched
    met: Reals2  # (m, 11), what explicit steps need, if `elastic`
    elastic: bool  # whether damping and friction are left out, since explicit steps take them apart
    exact: bool  # whether the tangent is exact
    middle: Reals2  # (m, 3), m, of a sphere that contains its part
    sphere: Reals  # m
    asleep: Reals  # m, `way` up to which it cannot touch
    way: int  # address of how far two points may have parted since elements near were found, m; or 0


class Resting(NamedTuple):
    """The same with a body that is fixed, at the origin: i, j."""

    parts: int
    part: Wholes
    radius: Reals
    regular: Reals
    stiffness: Reals
    exponent: Reals
    dissipation: Reals
    friction: Reals
    slip_speed: Reals
    convex: Flags
    lipschitz: Reals
    place: Reals
    met: Reals2
    elastic: bool
    exact: bool
    middle: Reals2
    sphere: Reals
    asleep: Reals
    way: int


@compiled
def seen(R: Matrix, x: float, y: float, z: float) -> Vector:
    """Rᵀ of a vector."""
    return (
        R[0] * x + R[3] * y + R[6] * z,
        R[1] * x + R[4] * y + R[7] * z,
        R[2] * x + R[5] * y + R[8] * z,
    )


@compiled
def shown(R: Matrix, v: Vector) -> Vector:
    """R of a vector."""
    return (
        R[0] * v[0] + R[1] * v[1] + R[2] * v[2],
        R[3] * v[0] + R[4] * v[1] + R[5] * v[2],
        R[6] * v[0] + R[7] * v[1] + R[8] * v[2],
    )


@compiled
def cross(a: Vector, b: Vector) -> Vector:
    """a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled
def dot(a: Vector, b: Vector) -> float:
    """a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def _curved(c: Any, d: Vector) -> Vector:
    """H d, with H in a row of `curvature`."""
    return (
        c[4] * d[0] + c[7] * d[1] + c[8] * d[2],
        c[7] * d[0] + c[5] * d[1] + c[9] * d[2],
        c[8] * d[0] + c[9] * d[1] + c[6] * d[2],
    )


@compiled
def _least(p: Any, e: int, bi: Vector, d: Vector, reach: float) -> tuple[float, float, Vector, Any, float]:
    """The least ψ, its s, b there and `curvature` at b, and ψ again.

    Where it is known to be above `reach` these are those of any s, and the last is a lower bound.
    """
    s, low, high, regular, part = p.place[e], -1.0, 2.0, p.regular[e], p.part[e]
    placed = EXACTLY if p.exact else PLACED
    if not 0.0 <= s <= 1.0:  # after an evaluation at not-a-number
        s = 0.5
    length = sqrt(dot(d, d))
    b = bi[0] + s * d[0], bi[1] + s * d[1], bi[2] + s * d[2]
    c = curvature_at(p.parts, part, b[0], b[1], b[2])
    psi = c[0] + 4.0 * regular * (s - 0.5) ** 2
    for _ in range(ITERATIONS if regular > 0.0 else 0):
        slope = c[1] * d[0] + c[2] * d[1] + c[3] * d[2] + 8.0 * regular * (s - 0.5)
        descent = slope * s if slope > 0.0 else -slope * (1.0 - s)
        if not p.convex[e]:
            descent = p.lipschitz[e] * length * max(s, 1.0 - s) + regular
        if psi - descent > reach:
            p.place[e] = s
            return psi, s, b, c, psi - descent
        if slope > 0.0:
            high = s
        else:
            low = s
        curve = max(dot(d, _curved(c, d)), 0.0) + 8.0 * regular
        new = min(max(s - slope / curve, 0.0), 1.0)
        if abs(new - s) <= placed:
            break
        if not low < new < high:  # as where it is seen against a flat face from both ends
            new = 0.5 * (max(low, 0.0) + min(high, 1.0))
        s = new
        b = bi[0] + s * d[0], bi[1] + s * d[1], bi[2] + s * d[2]
        c = curvature_at(p.parts, part, b[0], b[1], b[2])
        psi = c[0] + 4.0 * regular * (s - 0.5) ** 2
    p.place[e] = s
    return psi, s, b, c, psi


@compiled
def _ends(x: FloatArray, X: Vector, R: Matrix) -> tuple[Vector, Vector]:
    """bᵢ and bⱼ − bᵢ."""
    bi = seen(R, x[0, 0] - X[0], x[0, 1] - X[1], x[0, 2] - X[2])
    return bi, seen(R, x[1, 0] - x[0, 0], x[1, 1] - x[0, 1], x[1, 2] - x[0, 2])


@compiled
def _slip(s: float, b: Vector, v: FloatArray, V: Vector, W: Vector, R: Matrix) -> Vector:
    """u."""
    r = 1.0 - s
    a = seen(
        R,
        r * v[0, 0] + s * v[1, 0] - V[0],
        r * v[0, 1] + s * v[1, 1] - V[1],
        r * v[0, 2] + s * v[1, 2] - V[2],
    )
    w = cross(b, W)
    return a[0] + w[0], a[1] + w[1], a[2] + w[2]


@compiled
def _pressed(p: Any, e: int, delta: float) -> float:
    """k δⁿ."""
    return p.stiffness[e] * (delta if p.exponent[e] == 1.0 else delta * sqrt(delta))


@compiled
def _meet(
    p: Any, e: int, x: FloatArray, v: FloatArray, X: Vector, V: Vector, R: Matrix, W: Vector
) -> tuple[bool, float, Vector, Vector, Vector]:
    """Whether it touches, s, b, and the elastic and the other part of F."""
    bi, d = _ends(x, X, R)
    radius = p.radius[e]
    psi, s, b, c, least = _least(p, e, bi, d, radius)
    delta = radius - psi
    if not delta > 0.0:
        if p.elastic:
            p.met[e, FORCE] = 0.0
            p.asleep[e] = floats(p.way, 1)[0] + (least - radius) / p.lipschitz[e]
        return False, s, b, ORIGIN, ORIGIN
    N, g = _pressed(p, e, delta), (c[1], c[2], c[3])
    elastic = N * g[0], N * g[1], N * g[2]
    if p.elastic:
        p.met[e, FORCE] = N
        for k in range(3):
            p.met[e, POINT + k], p.met[e, NORMAL + k] = b[k], g[k]
        return True, s, b, elastic, ORIGIN
    u = _slip(s, b, v, V, W, R)
    gu, gg = dot(g, u), dot(g, g)
    whole = N * max(0.0, 1.0 - 1.5 * p.dissipation[e] * gu)
    t = u[0] - gu / gg * g[0], u[1] - gu / gg * g[1], u[2] - gu / gg * g[2]
    rubs = p.friction[e] * whole * sqrt(gg) / sqrt(dot(t, t) + p.slip_speed[e] ** 2)
    more = whole - N
    return (
        True,
        s,
        b,
        elastic,
        (more * g[0] - rubs * t[0], more * g[1] - rubs * t[1], more * g[2] - rubs * t[2]),
    )


@compiled
def _placed(p: Meeting, s: FloatArray, x: FloatArray, v: FloatArray) -> tuple[Pose, Matrix, Vector]:
    """The pose, R and W."""
    pose = load(p.pose, Pose)
    rho = pose.rho
    W = v[3, 0] / rho[0], v[3, 1] / rho[1], v[3, 2] / rho[2]
    return pose, axes_at(pose, (x[3, 0] / rho[0], x[3, 1] / rho[1], x[3, 2] / rho[2]), W, s[0]), W


@compiled
def _axes_now(p: Meeting, x: FloatArray) -> tuple[Pose, Matrix]:
    """The pose, and R from the angle alone."""
    pose = load(p.pose, Pose)
    rho, base = pose.rho, pose.base
    angle = x[3, 0] / rho[0], x[3, 1] / rho[1], x[3, 2] / rho[2]
    return pose, axes_at(pose, angle, (base[7], base[8], base[9]), base[10])


@compiled
def _sleeps(p: Any, e: int) -> bool:
    """Whether it is known not to touch, in explicit steps."""
    return p.elastic and floats(p.way, 1)[0] < p.asleep[e]


@compiled
def _force(p: Meeting, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    if _sleeps(p, e):
        return False
    pose, R, W = _placed(p, s, x, v)
    X, V = (x[2, 0], x[2, 1], x[2, 2]), (v[2, 0], v[2, 1], v[2, 2])
    touches, at, b, elastic, other = _meet(p, e, x, v, X, V, R, W)
    if not touches:
        return False
    E, D = shown(R, elastic), shown(R, other)
    turning, twisting = cross(elastic, b), cross(other, b)
    for c in range(3):
        f.conservative[0, c], f.dissipative[0, c] = (1.0 - at) * E[c], (1.0 - at) * D[c]
        f.conservative[1, c], f.dissipative[1, c] = at * E[c], at * D[c]
        f.conservative[2, c], f.dissipative[2, c] = -E[c], -D[c]
        f.conservative[3, c], f.dissipative[3, c] = turning[c] / pose.rho[c], twisting[c] / pose.rho[c]
    return True


@compiled
def _rest_force(p: Resting, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    if _sleeps(p, e):
        return False
    touches, at, _, E, D = _meet(p, e, x, v, ORIGIN, ORIGIN, UPRIGHT, ORIGIN)
    if not touches:
        return False
    for c in range(3):
        f.conservative[0, c], f.dissipative[0, c] = (1.0 - at) * E[c], (1.0 - at) * D[c]
        f.conservative[1, c], f.dissipative[1, c] = at * E[c], at * D[c]
    return True


@compiled
def _stored(p: Any, e: int, x: FloatArray, X: Vector, R: Matrix) -> float:
    bi, d = _ends(x, X, R)
    psi, _, _, _, _ = _least(p, e, bi, d, p.radius[e])
    delta = max(p.radius[e] - psi, 0.0)
    return _pressed(p, e, delta) * delta / (p.exponent[e] + 1.0)


@compiled
def _energy(p: Meeting, e: int, x: FloatArray) -> float:
    _, R = _axes_now(p, x)
    return _stored(p, e, x, (x[2, 0], x[2, 1], x[2, 2]), R)


@compiled
def _rest_energy(p: Resting, e: int, x: FloatArray) -> float:
    return _stored(p, e, x, ORIGIN, UPRIGHT)


@compiled
def _comes_near(p: Any, e: int, bi: Vector, d: Vector, margin: float) -> bool:
    """Whether it is not farther than the margin, as φ's Lipschitz constant and, for convex parts, a search tell."""
    reach = p.radius[e] + p.lipschitz[e] * margin
    m = bi[0] + 0.5 * d[0], bi[1] + 0.5 * d[1], bi[2] + 0.5 * d[2]
    half = 0.5 * sqrt(dot(d, d))
    o = m[0] - p.middle[e, 0], m[1] - p.middle[e, 1], m[2] - p.middle[e, 2]
    far = p.sphere[e] + half + reach
    if dot(o, o) > far * far:
        return False
    p.asleep[e] = 0.0
    phi = curvature_at(p.parts, p.part[e], m[0], m[1], m[2])[0]
    if phi - p.lipschitz[e] * half > reach:
        return False
    if p.regular[e] == 0.0:
        return True
    if p.convex[e]:
        psi, _, _, _, _ = _least(p, e, bi, d, reach + p.regular[e])
        return not psi - p.regular[e] > reach  # true for not-a-number
    least, near = np.inf, False
    for k in range(5):
        s = 0.25 * k
        b = bi[0] + s * d[0], bi[1] + s * d[1], bi[2] + s * d[2]
        phi = curvature_at(p.parts, p.part[e], b[0], b[1], b[2])[0]
        near = near or not phi - 0.25 * p.lipschitz[e] * half > reach
        if phi < least:
            least, p.place[e] = phi, s
    return near


@compiled
def _near(p: Meeting, e: int, x: FloatArray, margin: float) -> bool:
    pose, R = _axes_now(p, x)
    bi, d = _ends(x, (x[2, 0], x[2, 1], x[2, 2]), R)
    if p.elastic:  # explicit steps count the body's turn in their way
        return _comes_near(p, e, bi, d, margin)
    rho = min(pose.rho[0], pose.rho[1], pose.rho[2])
    arm = sqrt(dot(bi, bi)) + sqrt(dot(d, d))
    return _comes_near(p, e, bi, d, margin * (1.0 + 0.5 * arm / rho))


@compiled
def _rest_near(p: Resting, e: int, x: FloatArray, margin: float) -> bool:
    bi, d = _ends(x, ORIGIN, UPRIGHT)
    return _comes_near(p, e, bi, d, margin)


def bound_of(k: FloatArray, n: FloatArray, depth: float) -> FloatArray:
    """Stiffness n k δⁿ⁻¹ at a depth in m, (m,), N/m."""
    return n * k * depth ** (n - 1.0)


DEEP = 1e-3
"""m, the depth that chosen stiffnesses allow, at which the explicit step is bounded."""


def _bound(p: Meeting, nodes: IntArray, strain: float, x: FloatArray) -> list[Family]:
    k = bound_of(p.stiffness, p.exponent, DEEP)
    # a knot counts once in the sum of its node, and once in all
    once = np.where(nodes[:, 0] == nodes[:, 1], 0.5, 1.0)[:, None]
    both = once * np.stack((k, k), axis=-1)
    return [Family(nodes[:, :2], np.stack((both, 0.0 * both)), once)]


# Tangent


@compiled
def _tangent_of(
    p: Any,
    e: int,
    x: FloatArray,
    v: FloatArray,
    X: Vector,
    V: Vector,
    R: Matrix,
    W: Vector,
    rho: Vector,
    K: FloatArray,
    C: FloatArray,
) -> bool:
    """K and C of k nodes, (k, 3, k, 3)."""
    bi, d = _ends(x, X, R)
    psi, s, b, c, _ = _least(p, e, bi, d, p.radius[e])
    delta = p.radius[e] - psi
    if not delta > 0.0:
        return False
    size, g, u = 3 * len(x), (c[1], c[2], c[3]), _slip(s, b, v, V, W, R)
    n, lam = p.exponent[e], 1.5 * p.dissipation[e]
    N0 = _pressed(p, e, delta)
    gu, gg = dot(g, u), dot(g, g)
    gamma = sqrt(gg)
    open_ = max(0.0, 1.0 - lam * gu)
    presses = open_ > 0.0
    N = N0 * open_
    normal = g[0] / gamma, g[1] / gamma, g[2] / gamma
    along = dot(normal, u)
    t = u[0] - along * normal[0], u[1] - along * normal[1], u[2] - along * normal[2]
    sigma = sqrt(dot(t, t) + p.slip_speed[e] ** 2)
    mu = p.friction[e]
    rubs = mu * N * gamma / sigma
    F = N * g[0] - rubs * t[0], N * g[1] - rubs * t[1], N * g[2] - rubs * t[2]
    stiff = n * N0 / delta
    # of a change of each coordinate: b, and by it the forces
    hd = _curved(c, d)
    curve = dot(d, hd) + 8.0 * p.regular[e]
    inner = p.regular[e] > 0.0 and 0.0 < s < 1.0 and curve > 0.0
    w = seen(R, v[1, 0] - v[0, 0], v[1, 1] - v[0, 1], v[1, 2] - v[0, 2])
    carried = cross(b, W)
    a = u[0] - carried[0], u[1] - carried[1], u[2] - carried[2]
    for q in range(size):
        node, axis = q // 3, q % 3
        unit = (1.0 if axis == 0 else 0.0), (1.0 if axis == 1 else 0.0), (1.0 if axis == 2 else 0.0)
        turn, db = ORIGIN, ORIGIN
        if node == 3:
            turn = unit[0] / rho[0], unit[1] / rho[1], unit[2] / rho[2]
            db = cross(b, turn)
        else:
            share = 1.0 - s if node == 0 else (s if node == 1 else -1.0)
            moved = seen(R, unit[0], unit[1], unit[2])
            db = share * moved[0], share * moved[1], share * moved[2]
        # by velocity: u changes by db
        gd = dot(g, db)
        dN = -N0 * lam * gd if presses else 0.0
        dF = _changed(dN, ORIGIN, db, g, normal, gamma, along, t, sigma, mu, N)
        _spread(q, dF, ORIGIN, 0.0, ORIGIN, F, s, b, R, rho, size, C)
        # by place
        if not p.exact:
            dN = -stiff * open_ * gd
            dF = dN * g[0], dN * g[1], dN * g[2]
            _spread(q, dF, ORIGIN, 0.0, ORIGIN, F, s, b, R, rho, size, K)
            continue
        dd = cross(d, turn)
        if node < 2:
            moved = seen(R, unit[0], unit[1], unit[2])
            sign = -1.0 if node == 0 else 1.0
            dd = sign * moved[0], sign * moved[1], sign * moved[2]
        ds = -(dot(hd, db) + dot(g, dd)) / curve if inner else 0.0
        whole = db[0] + ds * d[0], db[1] + ds * d[1], db[2] + ds * d[2]
        dg = _curved(c, whole)
        spun, swept = cross(a, turn), cross(whole, W)
        du = (
            spun[0] + swept[0] + ds * w[0],
            spun[1] + swept[1] + ds * w[1],
            spun[2] + swept[2] + ds * w[2],
        )
        dN = -stiff * open_ * gd
        if presses:
            dN -= N0 * lam * (dot(g, du) + dot(u, dg))
        dF = _changed(dN, dg, du, g, normal, gamma, along, t, sigma, mu, N)
        _spread(q, dF, turn, ds, whole, F, s, b, R, rho, size, K)
    return True


@compiled
def _changed(
    dN: float,
    dg: Vector,
    du: Vector,
    g: Vector,
    n: Vector,
    gamma: float,
    along: float,
    t: Vector,
    sigma: float,
    mu: float,
    N: float,
) -> Vector:
    """δF from δN, δg and δu; n = g/|g|, along = n·u, t = u_t."""
    dgamma = dot(n, dg)
    dn = (
        (dg[0] - dgamma * n[0]) / gamma,
        (dg[1] - dgamma * n[1]) / gamma,
        (dg[2] - dgamma * n[2]) / gamma,
    )
    # δu_t = δu − δ(n·u) n − (n·u) δn
    dalong = dot(n, du) + dn[0] * (t[0] + along * n[0]) + dn[1] * (t[1] + along * n[1])
    dalong += dn[2] * (t[2] + along * n[2])
    dt = (
        du[0] - dalong * n[0] - along * dn[0],
        du[1] - dalong * n[1] - along * dn[1],
        du[2] - dalong * n[2] - along * dn[2],
    )
    by_t = mu * (dN * gamma + N * dgamma) / sigma - mu * N * gamma * dot(t, dt) / sigma**3
    by_dt = mu * N * gamma / sigma
    return (
        dN * g[0] + N * dg[0] - by_t * t[0] - by_dt * dt[0],
        dN * g[1] + N * dg[1] - by_t * t[1] - by_dt * dt[1],
        dN * g[2] + N * dg[2] - by_t * t[2] - by_dt * dt[2],
    )


@compiled
def _spread(
    q: int,
    dF: Vector,
    turn: Vector,
    ds: float,
    db: Vector,
    F: Vector,
    s: float,
    b: Vector,
    R: Matrix,
    rho: Vector,
    size: int,
    K: FloatArray,
) -> None:
    """Column q of K from δF, a turn of the body, δs and δb: δ(Gᵀ R F)."""
    swung = cross(turn, F)
    whole = shown(R, (dF[0] + swung[0], dF[1] + swung[1], dF[2] + swung[2]))
    moved, still, shifted = shown(R, F), cross(dF, b), cross(F, db)
    node, axis = q // 3, q % 3
    for c in range(3):
        K[0, c, node, axis] += (1.0 - s) * whole[c] - ds * moved[c]
        K[1, c, node, axis] += s * whole[c] + ds * moved[c]
        if size > 6:
            K[2, c, node, axis] -= whole[c]
            K[3, c, node, axis] += (still[c] + shifted[c]) / rho[c]


@compiled
def _tangent(
    p: Meeting, e: int, s: FloatArray, x: FloatArray, v: FloatArray, K: FloatArray, C: FloatArray
) -> bool:
    pose, R, W = _placed(p, s, x, v)
    X, V = (x[2, 0], x[2, 1], x[2, 2]), (v[2, 0], v[2, 1], v[2, 2])
    rho = pose.rho[0], pose.rho[1], pose.rho[2]
    return _tangent_of(p, e, x, v, X, V, R, W, rho, K, C)


@compiled
def _rest_tangent(
    p: Resting, e: int, s: FloatArray, x: FloatArray, v: FloatArray, K: FloatArray, C: FloatArray
) -> bool:
    return _tangent_of(p, e, x, v, ORIGIN, ORIGIN, UPRIGHT, ORIGIN, (1.0, 1.0, 1.0), K, C)


MEETING = Law(
    Meeting,
    force=_force,
    tangent=_tangent,
    energy=_energy,
    nodes=4,
    shares=("conservative", "dissipative"),
    near=_near,
    bound=_bound,
    across=True,
)
RESTING = Law(
    Resting,
    force=_rest_force,
    tangent=_rest_tangent,
    energy=_rest_energy,
    nodes=2,
    shares=("conservative", "dissipative"),
    external=True,
    near=_rest_near,
    bound=_bound,
    across=True,
)
