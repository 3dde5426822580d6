"""The dyads of drawcords in the compiled Newton matrix, by Woodbury's formula. Symbols as in `linalg.condensed`.

The p of a dyad are zero except on the cord's own nodes, which are members of the factored part of A where the cord is
taut. So Z is zero outside this part.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from netdae.core.arrays import FloatArray, IntArray, Reals, Reals2, Wholes
from netdae.core.compilation import INLINED
from netdae.core.records import load
from netdae.forces.loops import Elements
from netdae.solvers.linalg.block_ldl import Ldl

OPTIONS = {"cache": True, **INLINED}


class Dyads(NamedTuple):
    """Dyads of the active forces with links, at the last setup.

    A dyad d of an element of k nodes has its vectors in rows d k to (d + 1) k of its left, by_x and by_v, (3,) a node.
    """

    elements: Wholes  # (c,), addresses of the forces' Elements
    owner: Wholes  # (r,), address of the Elements of each dyad
    first: Wholes  # (r,), where its vectors begin
    number: Wholes  # (1,), the present r
    Z: Reals2  # (3n, r), A⁻¹ P
    W: Reals2  # (r, r), I − Qᵀ Z, factored
    swaps: Wholes  # (r,), of its rows
    amounts: Reals  # (r,)


@njit(**OPTIONS)
def factor_dyads(dyads: Dyads, cj: float, free: FloatArray, n: int, ldl: Ldl) -> bool:
    """Compute Z and I − Qᵀ Z with the factor of A, see `linalg.block_ldl`; False if the latter is singular.

    Of the tangents by_x becomes q_T + c_j q_D, and left is zeroed on restrained axes.
    """
    Z, W = dyads.Z, dyads.W
    dyads.number[0] = 0
    for c in range(len(dyads.elements)):
        el = load(dyads.elements[c], Elements)
        for d in range(el.rank[0]):
            q = dyads.number[0]
            dyads.owner[q], dyads.first[q] = dyads.elements[c], 3 * d * el.nodes.shape[1]
            dyads.number[0] += 1
    count = dyads.number[0]
    if count == 0:
        return True
    for k in range(n):
        i = ldl.order[k]
        for c in range(3):
            for d in range(count):
                Z[3 * i + c, d] = 0.0
    for d in range(count):
        el, at = load(dyads.owner[d], Elements), dyads.first[d]
        for a in range(el.nodes.shape[1]):
            i, q = el.nodes[0, a], at + 3 * a
            for c in range(3):
                el.by_x[q + c] += cj * el.by_v[q + c]
                if len(free):
                    el.left[q + c] *= free[i + c]
                Z[i + c, d] = el.left[q + c]
    _solve_many(n, ldl, Z, count)
    for d in range(count):
        el, at = load(dyads.owner[d], Elements), dyads.first[d]
        for e in range(count):
            W[d, e] = 1.0 if d == e else 0.0
        for a in range(el.nodes.shape[1]):
            i, q = el.nodes[0, a], at + 3 * a
            q0, q1, q2 = el.by_x[q], el.by_x[q + 1], el.by_x[q + 2]
            for e in range(count):
                W[d, e] -= q0 * Z[i, e] + q1 * Z[i + 1, e] + q2 * Z[i + 2, e]
    return _factor(W, dyads.swaps, count)


@njit(**OPTIONS)
def _solve_many(n: int, ldl: Ldl, Z: FloatArray, count: int) -> None:
    """Overwrite the members' rows of the first columns of Z (3n, r) with those of A⁻¹ Z, see `linalg.block_ldl`."""
    members, L_start, L_row, L, pivots = ldl.order, ldl.L_start, ldl.L_row, ldl.L, ldl.pivots
    for k in range(n):
        a = 3 * members[k]
        for p in range(L_start[k], L_start[k + 1]):
            b = 3 * members[L_row[p]]
            for row in range(3):
                l0, l1, l2 = L[p, row, 0], L[p, row, 1], L[p, row, 2]
                for d in range(count):
                    Z[b + row, d] -= l0 * Z[a, d] + l1 * Z[a + 1, d] + l2 * Z[a + 2, d]
    for k in range(n - 1, -1, -1):
        a = 3 * members[k]
        l10, l20, l21, d0, d1, d2 = pivots[k]
        for d in range(count):
            z1 = Z[a + 1, d] - l10 * Z[a, d]
            z2 = (Z[a + 2, d] - l20 * Z[a, d] - l21 * z1) * d2
            z1 = z1 * d1 - l21 * z2
            Z[a, d], Z[a + 1, d], Z[a + 2, d] = Z[a, d] * d0 - l10 * z1 - l20 * z2, z1, z2
        for p in range(L_start[k], L_start[k + 1]):
            b = 3 * members[L_row[p]]
            for row in range(3):
                l0, l1, l2 = L[p, 0, row], L[p, 1, row], L[p, 2, row]
                for d in range(count):
                    Z[a + row, d] -= l0 * Z[b, d] + l1 * Z[b + 1, d] + l2 * Z[b + 2, d]


@njit(**OPTIONS)
def _along(vectors: FloatArray, at: int, nodes: IntArray, y: FloatArray) -> float:
    """One dyad's vector times y (3n,)."""
    total = 0.0
    for a in range(nodes.shape[1]):
        i, q = nodes[0, a], at + 3 * a
        total += vectors[q] * y[i] + vectors[q + 1] * y[i + 1] + vectors[q + 2] * y[i + 2]
    return total


@njit(**OPTIONS)
def add_dyad_products(dyads: Dyads, r1: FloatArray, right: FloatArray) -> None:
    """Add to right (3n,) the part of D r₁ that the blocks leave out, −Σ p (q_D · r₁)."""
    for d in range(dyads.number[0]):
        el, at = load(dyads.owner[d], Elements), dyads.first[d]
        amount = _along(el.by_v, at, el.nodes, r1)
        for a in range(el.nodes.shape[1]):
            for c in range(3):
                right[el.nodes[0, a] + c] -= amount * el.left[at + 3 * a + c]


@njit(**OPTIONS)
def complete(dyads: Dyads, members: IntArray, y: FloatArray) -> None:
    """y = A⁻¹ b (3n,) becomes K⁻¹ b."""
    count = dyads.number[0]
    for d in range(count):
        el = load(dyads.owner[d], Elements)
        dyads.amounts[d] = _along(el.by_x, dyads.first[d], el.nodes, y)
    if count == 0:
        return
    _substitute(dyads.W, dyads.swaps, dyads.amounts, count)
    for i in members:
        for k in range(3 * i, 3 * i + 3):
            gained = 0.0
            for d in range(count):
                gained += dyads.amounts[d] * dyads.Z[k, d]
            y[k] += gained


@njit(**OPTIONS)
def _factor(W: FloatArray, swaps: IntArray, r: int) -> bool:
    """LU of the first r rows and columns of W in place, with row pivoting; False if it is singular."""
    for k in range(r):
        best = k
        for i in range(k + 1, r):
            if abs(W[i, k]) > abs(W[best, k]):
                best = i
        swaps[k] = best
        if not abs(W[best, k]) > 0.0:
            return False
        for j in range(r):
            W[k, j], W[best, j] = W[best, j], W[k, j]
        for i in range(k + 1, r):
            W[i, k] /= W[k, k]
            for j in range(k + 1, r):
                W[i, j] -= W[i, k] * W[k, j]
    return True


@njit(**OPTIONS)
def _substitute(W: FloatArray, swaps: IntArray, b: FloatArray, r: int) -> None:
    """b (r,) becomes W⁻¹ b, with W as `_factor` leaves it."""
    for k in range(r):
        b[k], b[swaps[k]] = b[swaps[k]], b[k]
    for k in range(r):
        for i in range(k + 1, r):
            b[i] -= W[i, k] * b[k]
    for k in range(r - 1, -1, -1):
        for j in range(k + 1, r):
            b[k] -= W[k, j] * b[j]
        b[k] /= W[k, k]
