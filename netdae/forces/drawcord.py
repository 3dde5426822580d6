"""One cord that slides through rings at several nodes, and that a reel winds in.

Symbols: lengths and directions along the cord as in `rings`, friction as in `capstan`; r the reel's node with s in m,
L̄ = L̄₀ + σ s rest length of the whole cord; else as in `cables` and `reel`.

The energy is that of one cable of the length l, U = EĀ L̄ e(E11) with λ = l/L̄, Λ = λ² = 1 + 2 E11 and

    E11 = ½ (l²/L̄² − 1),       Ė11 = l l̇/L̄² − σ Λ ṡ/L̄.

With b = ∂l/∂x (u_i at the end of each segment, −u_i at its begin) and S = g + τ g′ Ė11, not below zero, the forces are
those of `reel` with l² for d·d and l l̇ for d·w:

    f = −N b,   N = EĀ S λ,        f_s = σ EĀ (S Λ − e),        dissipated EĀ L̄ (S − g) Ė11.

Friction at the rings makes N_i = ν_i N of segment i out of N:

    f on the begin of segment i = N_i u_i = −f on its end,      f_s = σ EĀ (S Λ ν_d − e),
    dissipated besides Σ_j (N_j − N_{j−1}) c_j.

Derivatives. With ∇ by all coordinates of the rings and s,

    ∇E11 = (l b/L̄², −σΛ/L̄),        ∇Ė11 = ((l̇ b + l ∇l̇)/L̄² − 2σ ṡ l b/L̄³, −2σ l l̇/L̄³ + 3σ² ṡ Λ/L̄²)
    ∇S = (g′ + τ g″ Ė11) ∇E11 + τ g′ ∇Ė11,        ∇N = EĀ (λ ∇S + S ∇E11/λ),        ∇N_i = ν_i (∇N + N ∇ ln ν_i)
    ∇f_s = σ EĀ (ν_d (Λ ∇S + 2S ∇E11) + S Λ ∇ν_d − g ∇E11)

and by velocities S,v = τ g′ ∇E11 alone. The tangent is a chain of blocks N_i (I − u_i u_iᵀ)/h_i between neighbours, and
dyads: with b_i the part of b that segment i has, ∂f = −chain − Σ b_i ⊗ ∇N_i + e_s ⊗ ∇f_s. Without friction all N_i are
N, and two dyads are left: the Newton matrix takes the chain into its factor and the dyads apart, see `linear_solver`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit

from netdae._arrays import FloatArray, IntArray
from netdae.errors import RunError
from netdae.forces.cables import law_of
from netdae.forces.capstan import share_gradients, sliding_speeds, tension_shares
from netdae.forces.protocol import Account, LinkedTangent, NewtonPart, Tangent
from netdae.forces.rings import Cord, Way, add_along, way_through

LEAST = 1e-3
"""Share of L̄₀ under which a cord counts as wound in whole."""


@njit(cache=True)
def _strain_and_rate(way: Way, L: float, share: float, s_rate: float) -> tuple[float, float]:
    """E11 and Ė11."""
    E11 = 0.5 * (way.length * way.length / (L * L) - 1.0)
    return E11, way.length * way.rate / (L * L) - share * (1.0 + 2.0 * E11) * s_rate / L


@njit(cache=True)
def sliding_forces(
    x: FloatArray, v: FloatArray, L: float, cord: Cord, f: FloatArray, tension: FloatArray
) -> tuple[float, float, float, float]:
    """f (k + 1, 3) and N_i (p,); stored energy, dissipated power, N without dashpot and friction, and E11."""
    k, p = len(x) - 1, len(tension)
    way = way_through(x, v, p, cord.size)
    E11, rate = _strain_and_rate(way, L, cord.share, v[k, 0])
    f[:], tension[:] = 0.0, 0.0
    if E11 < 0.0:
        return 0.0, 0.0, 0.0, E11
    c = sliding_speeds(way, L, v[k, 0], cord)
    nu = tension_shares(way, c, cord)
    g, dg, _, energy = law_of(E11, cord.eps, cord.engineering)
    S = max(g + cord.tau * dg * rate, 0.0)
    N = cord.EA * S * way.length / L
    dissipated = (S - g) * rate * cord.EA * L
    for i in range(p):
        tension[i] = nu[i] * N
        if i > 0:
            dissipated += (tension[i] - tension[i - 1]) * c[i]
        for a in range(3):
            f[i, a] += tension[i] * way.u[i, a]
            f[(i + 1) % k, a] -= tension[i] * way.u[i, a]
    at_drum = cord.theta * nu[0] + (1.0 - cord.theta) * nu[p - 1]
    f[k, 0] = cord.share * cord.EA * (S * (1.0 + 2.0 * E11) * at_drum - energy)
    return cord.EA * L * energy, dissipated, cord.EA * g * way.length / L, E11


@njit(cache=True)
def sliding_tangents(
    x: FloatArray,
    v: FloatArray,
    L: float,
    cord: Cord,
    chain: FloatArray,
    left: FloatArray,
    by_x: FloatArray,
    by_v: FloatArray,
) -> bool:
    """Chain (p, 2, 3, 2, 3) and dyads (r, k + 1, 3), r = 2 or p + 1 with friction; False where the cord is slack."""
    k, p, last, s_rate = len(x) - 1, len(chain), len(left) - 1, v[len(x) - 1, 0]
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


@dataclass(frozen=True, eq=False)
class SlidingCord:
    """A cord through rings, wound in by a reel: one element of k rings and the reel's node.

    nodes : (1, k + 1), rings in their order, then the reel's node
    cord : its numbers, see `Cord`
    closed : True where it comes back to ring 0

    Raises RunError where a flight has wound it in whole.
    """

    nodes: IntArray
    cord: Cord
    closed: bool

    newton: NewtonPart = "links"
    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()
    external: bool = False

    @property
    def segment_count(self) -> int:
        """p, between k rings k if the cord is closed, else k − 1."""
        return int(self.nodes.shape[1]) - (1 if self.closed else 2)

    @cached_property
    def links(self) -> IntArray:
        """Nodes (p, 2) at the ends of each segment."""
        rings = self.nodes[0, :-1]
        return np.stack((rings, np.roll(rings, -1)), axis=1)[: self.segment_count].copy()

    def rest_length(self, x: FloatArray) -> float:
        """L̄(s), m, from x (1, k + 1, 3), not below a share of L̄₀.

        Newton's iteration tries states that no flight comes to: they get a force, so that it may turn back.
        """
        return max(self.cord.L + self.cord.share * float(x[0, -1, 0]), LEAST * self.cord.L)

    def tensions(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """N_i of each segment, (p,), N, with the shares of friction and dashpot."""
        return self._at(x, v)[1]

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Pull on the rings and, along x of the reel node, the force on s, (1, k + 1, 3), N."""
        return self._at(x, v)[0]

    def account(self, t: float, x: FloatArray, v: FloatArray) -> Account:
        """U, and the power of dashpot and friction; raises RunError where the cord is wound in whole."""
        L = self.cord.L + self.cord.share * float(x[0, -1, 0])
        if not L > LEAST * self.cord.L:
            raise RunError(
                f"at t = {t:g} s the cord through node {self.nodes[0, 0]} has the rest length {L:g} m, wound in by the "
                f"reel at node {self.nodes[0, -1]}: stop the reel before, at a length above zero"
            )
        return Account(*self._at(x, v)[2][:2])

    def tangent(self, t: float, x: FloatArray, v: FloatArray) -> Tangent:
        """∂f/∂x and ∂f/∂v, whole: for checks and products."""
        k = self.nodes.shape[1] - 1
        part = self.newton_part(t, x, v)
        if not len(part.left):
            return Tangent.none(k + 1)
        K = np.einsum("ria,rjb->iajb", part.left, part.by_x)
        C = np.einsum("ria,rjb->iajb", part.left, part.by_v)
        for i, block in enumerate(part.dx):
            ends = np.ix_([i, (i + 1) % k], range(3), [i, (i + 1) % k], range(3))
            K[ends] += block
        return Tangent(np.zeros(1, dtype=np.int64), K[None], C[None])

    def newton_part(self, t: float, x: FloatArray, v: FloatArray) -> LinkedTangent:
        """The chain on `links`, and the dyads."""
        p, k = self.segment_count, self.nodes.shape[1] - 1
        rank = p + 1 if self.cord.friction > 0 else 2
        chain, (left, by_x, by_v) = np.empty((p, 2, 3, 2, 3)), np.empty((3, rank, k + 1, 3))
        if not sliding_tangents(x[0], v[0], self.rest_length(x), self.cord, chain, left, by_x, by_v):
            return LinkedTangent(chain[:0], chain[:0], left[:0], by_x[:0], by_v[:0])
        return LinkedTangent(chain, np.zeros_like(chain), left, by_x, by_v)

    def _at(
        self, x: FloatArray, v: FloatArray
    ) -> tuple[FloatArray, FloatArray, tuple[float, float, float, float]]:
        """f, N_i, and what `sliding_forces` tells."""
        f, tension = np.empty_like(x), np.empty(self.segment_count)
        return f, tension, sliding_forces(x[0], v[0], self.rest_length(x), self.cord, f[0], tension)
