"""One cord that slides through rings at several nodes, and that a reel winds in.

Symbols: lengths and directions along the cord as in `rings`, friction as in `capstan`; r the reel's node with s in m,
L̄ = L̄₀ + σ s rest length of the whole cord; else as in `cables` and `reel`.

The energy is that of one cable of the length l, U = EĀ L̄ e(E11) with λ = l/L̄, Λ = λ² = 1 + 2 E11 and

    E11 = ½ (l²/L̄² − 1),       Ė11 = l l̇/L̄² − σ Λ ṡ/L̄.

With b = ∂l/∂x (u_i at the end of each segment, −u_i at its start) and S = g + τ g′ Ė11, not below zero, the forces are
those of `reel` with l² for d·d and l l̇ for d·w:

    f = −N b,   N = EĀ S λ,        f_s = σ EĀ (S Λ − e),        dissipated EĀ L̄ (S − g) Ė11.

Friction at the rings turns N into N_i = ν_i N in segment i:

    f on the start of segment i = N_i u_i = −f on its end,      f_s = σ EĀ (S Λ ν_d − e),
    dissipated besides Σ_j (N_j − N_{j−1}) c_j.

Derivatives. With ∇ the gradient with respect to all coordinates of the rings and s,

    ∇E11 = (l b/L̄², −σΛ/L̄),        ∇Ė11 = ((l̇ b + l ∇l̇)/L̄² − 2σ ṡ l b/L̄³, −2σ l l̇/L̄³ + 3σ² ṡ Λ/L̄²)
    ∇S = (g′ + τ g″ Ė11) ∇E11 + τ g′ ∇Ė11,        ∇N = EĀ (λ ∇S + S ∇E11/λ),        ∇N_i = ν_i (∇N + N ∇ ln ν_i)
    ∇f_s = σ EĀ (ν_d (Λ ∇S + 2S ∇E11) + S Λ ∇ν_d − g ∇E11)

and by velocities only S,v = τ g′ ∇E11. The tangent is a chain of blocks N_i (I − u_i u_iᵀ)/h_i between neighbours, and
dyads: with b_i the part of b from segment i, ∂f = −chain − Σ b_i ⊗ ∇N_i + e_s ⊗ ∇f_s. Without friction all N_i are
N, and two dyads are left: the chain goes into the factor of the Newton matrix, the dyads are kept apart, see
`linalg.condensed`.

In an explicit step friction at rings is taken at the velocity half a step back, as dashpots are. Its damping Σ_j G_j
C_j C_jᵀ, with G_j = N_j μ φ_j γ/c_j and C_j = ∂c_j/∂ẋ, comes and goes with the tension N: a bound that always held
would make the step uselessly small. (G_j is the secant, not the slope: by the slope, a ring thrown to and fro by too
long a step would look soft.) Hence a rate that no eigenvalue of it over M exceeds is monitored: a step in which it
exceeds the limit for which h is stable ends the run of steps, as does one with too large a strain. C_j has a part on
ring j itself, disjoint from those of other rings, and one on the other rings and the drum r. With a_j the share of the
cord before ring j and the sums over the rings before it and after it, the rate is (√A + √B)² from A = max G_j/m_j and
the trace

    B = Σ_j G_j ((1 − a_j)² Σ_{i<j} |b_i|²/m_i + a_j² Σ_{i>j} |b_i|²/m_i + (λ σ (θ − a_j))²/m_r)

with |b_i|² = 2 − 2 cos φ_i at most, and 2 at both ends of the cord: where it is closed, both are ring 0, on which C_j
is (1 − a_j) u_0 + a_j u_{p−1}, the square of which is 2 (1 − a_j)² + 2 a_j² at most.
"""

from __future__ import annotations

import math

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.forces.cables import law_of
from netdae.forces.capstan import share_gradients, sliding_speeds, tension_shares, turn_at
from netdae.forces.elements import ElementForce
from netdae.forces.law import Family, Law, Shares, compiled
from netdae.forces.reel import WOUND_IN
from netdae.forces.rings import Cord, Way, add_along, way_length, way_through

LEAST = 1e-3
"""Share of L̄₀ below which a cord counts as fully wound in."""


@compiled
def _rest(cord: Cord, e: int, x: FloatArray) -> tuple[float, float]:
    return cord.L + cord.share * x[len(x) - 1, 0], LEAST * cord.L


@compiled
def _length(cord: Cord, x: FloatArray) -> float:
    """L̄(s), m, not below a share of L̄₀: Newton's iteration tries states that no flight reaches, and turns back."""
    return max(cord.L + cord.share * x[len(x) - 1, 0], LEAST * cord.L)


@compiled
def _strain_and_rate(way: Way, L: float, share: float, s_rate: float) -> tuple[float, float]:
    """E11 and Ė11."""
    E11 = 0.5 * (way.length * way.length / (L * L) - 1.0)
    return E11, way.length * way.rate / (L * L) - share * (1.0 + 2.0 * E11) * s_rate / L


@compiled
def _tensions(
    cord: Cord, x: FloatArray, v: FloatArray, way: Way, c: FloatArray
) -> tuple[FloatArray, float, float]:
    """N_i (p,), g and e; way and the speeds c at rings are those of the state."""
    k, L = len(x) - 1, _length(cord, x)
    E11, rate = _strain_and_rate(way, L, cord.share, v[k, 0])
    if E11 < 0.0:
        return np.zeros(cord.segments), 0.0, 0.0
    nu = tension_shares(way, c, cord)
    g, dg, _, energy = law_of(E11, cord.eps, cord.engineering)
    S = max(g + cord.tau * dg * rate, 0.0)
    return nu * (cord.EA * S * way.length / L), g, energy


@compiled
def _force(cord: Cord, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    k, p, L = len(x) - 1, cord.segments, _length(cord, x)
    way = way_through(x, v, p, cord.size)
    stretch = way.length / L
    if stretch < 1.0:
        return False
    c = sliding_speeds(way, L, v[k, 0], cord)
    tension, g, energy = _tensions(cord, x, v, way, c)
    elastic = cord.EA * g * stretch
    for i in range(p):
        j = (i + 1) % k
        for a in range(3):
            pull, damper = elastic * way.u[i, a], (tension[i] - elastic) * way.u[i, a]
            f.conservative[i, a] += pull
            f.conservative[j, a] -= pull
            f.dissipative[i, a] += damper
            f.dissipative[j, a] -= damper
    at_drum = cord.theta * tension[0] + (1.0 - cord.theta) * tension[p - 1]  # ν_d N, and N = EĀ S λ
    f.conservative[k, 0] = cord.share * cord.EA * (g * stretch * stretch - energy)
    f.dissipative[k, 0] = cord.share * stretch * (at_drum - elastic)
    return True


@compiled
def _energy(cord: Cord, e: int, x: FloatArray) -> float:
    L = _length(cord, x)
    E11 = 0.5 * ((way_length(x, cord.segments, cord.size) / L) ** 2 - 1.0)
    return cord.EA * L * law_of(E11, cord.eps, cord.engineering)[3]


@compiled
def _measured(cord: Cord, e: int, x: FloatArray) -> tuple[float, float]:
    stretch = way_length(x, cord.segments, cord.size) / _length(cord, x)
    E11 = 0.5 * (stretch * stretch - 1.0)
    elastic = cord.EA * law_of(E11, cord.eps, cord.engineering)[0] * stretch
    return elastic * elastic, E11


@compiled
def _linked(
    cord: Cord,
    x: FloatArray,
    v: FloatArray,
    chain: FloatArray,
    left: FloatArray,
    by_x: FloatArray,
    by_v: FloatArray,
) -> bool:
    """Chain (p, 2, 3, 2, 3) and dyads (r, k + 1, 3), r = 2 or p + 1 with friction; False where the cord is slack."""
    k, p, last, s_rate = len(x) - 1, cord.segments, len(left) - 1, v[len(x) - 1, 0]
    L = _length(cord, x)
    way = way_through(x, v, p, cord.size)
    E11, rate = _strain_and_rate(way, L, cord.share, s_rate)
    if E11 < 0.0:
        return False
    c = sliding_speeds(way, L, s_rate, cord)
    nu = tension_shares(way, c, cord)
    g, dg, ddg, _ = law_of(E11, cord.eps, cord.engineering)
    S, by_E11, by_rate = g + cord.tau * dg * rate, dg + cord.tau * ddg * rate, cord.tau * dg
    if S < 0.0:
        S = by_E11 = by_rate = 0.0
    share, stretch, stretch2, LL = cord.share, way.length / L, 1.0 + 2.0 * E11, L * L
    E11_x, rate_x = np.zeros((k + 1, 3)), np.zeros((k + 1, 3))
    for i in range(p):
        add_along(way, v, i, way.length / LL, 0.0, E11_x)
        add_along(way, v, i, (way.rate - 2.0 * share * s_rate * stretch) / LL, way.length / LL, rate_x)
    E11_x[k, 0] = -share * stretch2 / L
    rate_x[k, 0] = (-2.0 * share * way.length * way.rate / L + 3.0 * share * share * s_rate * stretch2) / LL
    S_x, S_v = by_E11 * E11_x + by_rate * rate_x, by_rate * E11_x  # ∂Ė11/∂v is ∂E11/∂x
    N = cord.EA * S * stretch
    N_x, N_v = cord.EA * (stretch * S_x + S / stretch * E11_x), cord.EA * stretch * S_v
    drum_x, drum_v, at_drum = np.zeros((k + 1, 3)), np.zeros((k + 1, 3)), 1.0
    if cord.friction > 0.0:
        share_gradients(way, v, L, cord, c, nu, by_x[:last], by_v[:last])
        first, second = cord.theta * nu[0], (1.0 - cord.theta) * nu[p - 1]
        at_drum = first + second
        drum_x += first * by_x[0] + second * by_x[p - 1]
        drum_v += first * by_v[0] + second * by_v[p - 1]
        for i in range(p):
            for n in range(k + 1):
                for a in range(3):
                    by_x[i, n, a] = nu[i] * (N_x[n, a] + N * by_x[i, n, a])
                    by_v[i, n, a] = nu[i] * (N_v[n, a] + N * by_v[i, n, a])
    else:
        by_x[0], by_v[0] = N_x, N_v
    pull = share * cord.EA
    by_x[last] = pull * (at_drum * (stretch2 * S_x + 2.0 * S * E11_x) + S * stretch2 * drum_x - g * E11_x)
    by_v[last] = pull * (at_drum * stretch2 * S_v + S * stretch2 * drum_v)
    left[:] = 0.0
    left[last, k, 0] = 1.0
    for i in range(p):
        j, row = (i + 1) % k, i if cord.friction > 0.0 else 0
        for a in range(3):
            left[row, j, a] -= way.u[i, a]
            left[row, i, a] += way.u[i, a]
            for b in range(3):
                across = nu[i] * N / way.h[i] * ((1.0 if a == b else 0.0) - way.u[i, a] * way.u[i, b])
                chain[i, 0, a, 0, b] = chain[i, 1, a, 1, b] = -across
                chain[i, 0, a, 1, b] = chain[i, 1, a, 0, b] = across
    return True


@compiled
def friction_rate(cord: Cord, x: FloatArray, v: FloatArray, share: FloatArray) -> float:
    """The rate of the friction at all rings, 1/s; share (k + 1,) is 1/m of rings and drum, zero where they are held."""
    if cord.friction == 0.0:
        return 0.0
    k, p, L = len(x) - 1, cord.segments, _length(cord, x)
    way = way_through(x, v, p, cord.size)
    c = sliding_speeds(way, L, v[k, 0], cord)
    tension = _tensions(cord, x, v, way, c)[0]
    if tension[0] == 0.0:
        return 0.0
    turns, whole = np.zeros(p + 1), 0.0  # |b|²/m
    for j in range(p + 1):
        turned = 1.0 - way.u[j - 1] @ way.u[j] if 0 < j < p else 1.0
        turns[j] = 2.0 * turned * share[j % k]
        whole += turns[j]
    before, length, own, others = 0.0, 0.0, 0.0, 0.0
    for j in range(1, p):
        before += turns[j - 1]
        length += way.h[j - 1]
        a, slip = length / way.length, c[j] / cord.creep_speed
        slope = max(tension[j - 1], tension[j]) * cord.friction * turn_at(way, j, cord.size)[1]
        slope /= cord.creep_speed * np.sqrt(1.0 + slip * slip)
        at_drum = way.length / L * cord.share * (cord.theta - a)
        response = (1.0 - a) ** 2 * before + a * a * (whole - before - turns[j])
        others += slope * (response + at_drum * at_drum * share[k])
        own = max(own, slope * share[j])
    return (np.sqrt(own) + np.sqrt(others)) ** 2


def _named(nodes: IntArray) -> str:
    return f"the cord through node {nodes[0]}"


def _links(cord: Cord, nodes: IntArray) -> IntArray:
    """Nodes (p, 2) at the ends of each segment."""
    rings = nodes[0, :-1]
    return np.stack((rings, np.roll(rings, -1)), axis=1)[: cord.segments].copy()


def _ranks(cord: Cord) -> int:
    return cord.segments + 1 if cord.friction > 0 else 2


def _bound(cord: Cord, nodes: IntArray, strain: float, x: FloatArray) -> list[Family]:
    """A cord along itself, and its segments across."""
    L = WOUND_IN * max(cord.L + cord.share * float(x[nodes[0, -1], 0]), LEAST * cord.L)
    g, dg, _, _ = law_of(strain, cord.eps, cord.engineering)
    stretch2 = 1 + 2 * strain
    k = cord.EA / L * np.array([dg * stretch2 + g, cord.tau * dg * stretch2])
    pull = np.full(nodes.shape, 2.0)
    if cord.segments < nodes.shape[1] - 1:  # open: the ends have one segment each
        pull[0, [0, -2]] = 1.0
    pull[0, -1] = abs(cord.share) * math.sqrt(stretch2)
    along = Family(nodes, k[:, None, None] * pull * pull.sum(), pull / pull.sum())
    links = _links(cord, nodes)
    across = np.array([cord.EA * g * math.sqrt(stretch2) / cord.size, 0.0])
    return [along, Family(links, np.tile(across[:, None, None], (1, *links.shape)))]


DRAWCORD = Law(
    Cord,
    force=_force,
    energy=_energy,
    nodes=0,
    shares=("conservative", "dissipative"),
    newton="links",
    measured=_measured,
    rest=_rest,
    named=_named,
    linked=_linked,
    links=_links,
    ranks=_ranks,
    rate=friction_rate,
    bound=_bound,
)


def drawcord(nodes: IntArray, cord: Cord, *, closed: bool) -> ElementForce:
    """A cord through k rings: one element, nodes (1, k + 1) in their order and then the reel's node.

    cord : its numbers; closed : True where it comes back to ring 0
    """
    segments = int(nodes.shape[1]) - (1 if closed else 2)
    return ElementForce(DRAWCORD, nodes, cord._replace(segments=segments))


def tensions_of(force: ElementForce, x: FloatArray, v: FloatArray) -> FloatArray:
    """N_i of each segment of a cord, (p,), N, with the shares of friction and dashpot, from x and v (1, k + 1, 3)."""
    cord, drum = force.parameters, float(v[0, -1, 0])
    way = way_through(x[0], v[0], cord.segments, cord.size)
    return np.asarray(
        _tensions(cord, x[0], v[0], way, sliding_speeds(way, _length(cord, x[0]), drum, cord))[0]
    )
