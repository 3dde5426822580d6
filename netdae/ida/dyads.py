"""The dyads of cords through rings in the compiled Newton matrix, by Woodbury's formula; symbols as in `linear_solver`.

The p of a dyad are zero but on the cord's own nodes, which are always members of the factored part of A: so is Z.
"""

from __future__ import annotations

from numba import njit

from netdae._arrays import FloatArray, IntArray
from netdae.ida.further import Dyads, dyads_at, strings_at, tangents_at
from netdae.kernels.cables import FAST
from netdae.kernels.strings import Strings

OPTIONS = {"cache": True, "fastmath": FAST, "error_model": "numpy"}


@njit(**OPTIONS)
def factor_dyads(
    address: int,
    cj: float,
    free: FloatArray,
    members: IntArray,
    L_start: IntArray,
    L_row: IntArray,
    L: FloatArray,
    pivots: FloatArray,
) -> bool:
    """Make Z and I − Qᵀ Z with the factor of A, see `block_ldl`; False if that is singular.

    Of the tangents by_x becomes q_T + c_j q_D, and left is zeroed on restrained axes.
    """
    strings, tangents, dyads = strings_at(address), tangents_at(address), dyads_at(address)
    count, Z, W = 0, dyads.Z, dyads.W
    for s in range(len(strings.L)):
        nodes = strings.begin[s + 1] - strings.begin[s]
        for d in range(tangents.rank[s]):
            dyads.cord[count], dyads.row[count] = s, tangents.begin[s] + d * nodes
            count += 1
    dyads.number[0] = count
    if count == 0:
        return True
    for i in members:
        for c in range(3):
            for d in range(count):
                Z[3 * i + c, d] = 0.0
    for d in range(count):
        s, row = dyads.cord[d], dyads.row[d]
        at, end = strings.begin[s], strings.begin[s + 1]
        for q in range(at, end):
            k, r = strings.entry[q], row + q - at
            for c in range(3):
                tangents.by_x[r, c] += cj * tangents.by_v[r, c]
                if len(free):
                    tangents.left[r, c] *= free[k + c]
                Z[k + c, d] = tangents.left[r, c]
    _solve_many(members, L_start, L_row, L, pivots, Z, count)
    for d in range(count):
        s, row = dyads.cord[d], dyads.row[d]
        at, end = strings.begin[s], strings.begin[s + 1]
        for e in range(count):
            W[d, e] = 1.0 if d == e else 0.0
        for q in range(at, end):
            k, r = strings.entry[q], row + q - at
            q0, q1, q2 = tangents.by_x[r, 0], tangents.by_x[r, 1], tangents.by_x[r, 2]
            for e in range(count):
                W[d, e] -= q0 * Z[k, e] + q1 * Z[k + 1, e] + q2 * Z[k + 2, e]
    return _factor(W, dyads.swaps, count)


@njit(**OPTIONS)
def _solve_many(
    members: IntArray,
    L_start: IntArray,
    L_row: IntArray,
    L: FloatArray,
    pivots: FloatArray,
    Z: FloatArray,
    count: int,
) -> None:
    """The members' rows of the first columns of Z (3n, r) become those of A⁻¹ Z, as `block_ldl` solves for one."""
    n = len(members)
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
def _along(rows: FloatArray, d: int, dyads: Dyads, strings: Strings, y: FloatArray) -> float:
    """The vector of the dyad d in `rows` times y (3n,)."""
    s, total = dyads.cord[d], 0.0
    at, row = strings.begin[s], dyads.row[d]
    for q in range(at, strings.begin[s + 1]):
        k, r = strings.entry[q], row + q - at
        total += rows[r, 0] * y[k] + rows[r, 1] * y[k + 1] + rows[r, 2] * y[k + 2]
    return total


@njit(**OPTIONS)
def take_dyad_products(address: int, r1: FloatArray, right: FloatArray) -> None:
    """right (3n,) gains that part of D r₁ that the blocks leave out: it loses Σ p (q_D · r₁)."""
    strings, tangents, dyads = strings_at(address), tangents_at(address), dyads_at(address)
    for d in range(dyads.number[0]):
        amount = _along(tangents.by_v, d, dyads, strings, r1)
        s, row = dyads.cord[d], dyads.row[d]
        for q in range(strings.begin[s], strings.begin[s + 1]):
            for c in range(3):
                right[strings.entry[q] + c] -= amount * tangents.left[row + q - strings.begin[s], c]


@njit(**OPTIONS)
def complete(address: int, members: IntArray, y: FloatArray) -> None:
    """y = A⁻¹ b (3n,) becomes K⁻¹ b."""
    strings, tangents, dyads = strings_at(address), tangents_at(address), dyads_at(address)
    count = dyads.number[0]
    for d in range(count):
        dyads.amounts[d] = _along(tangents.by_x, d, dyads, strings, y)
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
    """LU of the first r rows and columns of W in their place, with pivots by rows; False if it is singular."""
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
