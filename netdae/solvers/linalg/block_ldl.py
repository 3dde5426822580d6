"""Sparse LDLᵀ in 3×3 blocks over the couplings that are nonzero at present.

A slack cable adds nothing to T, nor, with its dashpot, to D: its block in K is zero. In a flight about a
tenth of the cables are taut, so the elimination graph of the nonzero blocks is far smaller than that of the
whole net. Elimination tree and factor are made anew at each setup, in a minimum-degree order of the nodes
that is found once. With Rayleigh damping all blocks are nonzero and the factor is the full one.

The method is the up-looking LDLᵀ of T. A. Davis, Algorithm 849 (ACM TOMS 31, 2005, doi:10.1145/1114268.1114277),
with nodes for unknowns and 3×3 blocks for numbers: K = L D Lᵀ with unit blocks on the diagonal of L.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy import sparse
from scipy.sparse.linalg import splu

from netdae.core.arrays import Flags, FloatArray, IntArray, Reals2, Reals3, Wholes, wholes
from netdae.core.errors import RunError
from netdae.system.assembly import BlockPattern


class Ldl(NamedTuple):
    """A matrix of n nodes by block columns, its factor, and workspace; arrays may be longer than n requires.

    order : the node at each place of the elimination; diagonal : its block in K
    """

    order: Wholes  # (n,)
    diagonal: Wholes  # (n,)
    column_start: Wholes  # (n + 1,), where the blocks above the diagonal begin, by columns
    row: Wholes  # (b,), place
    source: Wholes  # (b,), block in K
    flipped: Flags  # (b,), whether that is the transposed one
    present: Flags  # (b,), whether it is not zero
    parent: Wholes  # (n,), in the elimination tree
    L_start: Wholes  # (n + 1,)
    L_row: Wholes
    L: Reals3
    pivots: Reals2  # (n, 6)
    flag: Wholes  # (n,)
    filled: Wholes  # (n,), blocks of L in each column
    path: Wholes  # (n,)
    stack: Wholes  # (n,)
    Y: Reals3  # (n, 3, 3)
    y: Reals2  # (n, 3)


SINGULAR = 1e-14  # a pivot over the diagonal of its block before elimination: round-off of some terms is left


@njit(cache=True, forceinline=True)
def _symbolic(K: FloatArray, n: int, ldl: Ldl) -> None:
    """Find the nonzero couplings of n nodes, their elimination tree, and where the columns of L start."""
    present, parent, L_start, flag = ldl.present, ldl.parent, ldl.L_start, ldl.flag
    L_start[: n + 1] = 0
    for k in range(n):
        parent[k] = -1
        flag[k] = k
        for p in range(ldl.column_start[k], ldl.column_start[k + 1]):
            block = K[ldl.source[p]]
            there = False
            for r in range(3):
                for c in range(3):
                    there = there or block[r, c] != 0.0
            present[p] = there
            if not there:
                continue
            i = ldl.row[p]
            while flag[i] != k:
                if parent[i] == -1:
                    parent[i] = k
                L_start[i + 1] += 1
                flag[i] = k
                i = parent[i]
    for k in range(n):
        L_start[k + 1] += L_start[k]


@njit(cache=True, forceinline=True)
def _factor_pivot(A: FloatArray, scale: float, pivot: FloatArray) -> bool:
    """LDLᵀ of a symmetric 3×3 block as (l10, l20, l21, 1/d0, 1/d1, 1/d2); False if it is singular.

    scale : largest diagonal entry of the block before elimination, to which round-off is relative

    The inverse is not used: stiff along a cable and soft across it, the block would lose digits of the momentum.
    """
    least = SINGULAR * scale
    d0 = A[0, 0]
    if not abs(d0) > least:
        return False
    l10, l20 = A[1, 0] / d0, A[2, 0] / d0
    d1 = A[1, 1] - l10 * A[1, 0]
    if not abs(d1) > least:
        return False
    b21 = A[2, 1] - l20 * A[1, 0]
    l21 = b21 / d1
    d2 = A[2, 2] - l20 * A[2, 0] - l21 * b21
    if not abs(d2) > least:
        return False
    pivot[0], pivot[1], pivot[2] = l10, l20, l21
    pivot[3], pivot[4], pivot[5] = 1.0 / d0, 1.0 / d1, 1.0 / d2
    return True


@njit(cache=True, forceinline=True)
def _solve_pivot(pivot: FloatArray, b0: float, b1: float, b2: float) -> tuple[float, float, float]:
    """Solution of the 3×3 block for one right-hand side."""
    w1 = b1 - pivot[0] * b0
    w2 = b2 - pivot[1] * b0 - pivot[2] * w1
    z2 = w2 * pivot[5]
    z1 = w1 * pivot[4] - pivot[2] * z2
    z0 = b0 * pivot[3] - pivot[0] * z1 - pivot[1] * z2
    return z0, z1, z2


@njit(cache=True, forceinline=True)
def _numeric(K: FloatArray, n: int, ldl: Ldl) -> int:
    """Compute L and the factored pivots D by rows; return the number of the first singular pivot, or −1."""
    parent, flag, path, stack, Y = ldl.parent, ldl.flag, ldl.path, ldl.stack, ldl.Y
    L_start, L_row, L_count, L, pivots = ldl.L_start, ldl.L_row, ldl.filled, ldl.L, ldl.pivots
    D = np.empty((3, 3))
    for k in range(n):
        L_count[k] = 0
        top = n
        flag[k] = k
        Y[k] = 0.0
        for p in range(ldl.column_start[k], ldl.column_start[k + 1]):
            if not ldl.present[p]:
                continue
            i = ldl.row[p]
            block = K[ldl.source[p]]
            for r in range(3):
                for c in range(3):
                    Y[i, r, c] = block[c, r] if ldl.flipped[p] else block[r, c]
            length = 0
            while flag[i] != k:
                path[length] = i
                length += 1
                flag[i] = k
                i = parent[i]
            while length > 0:
                top -= 1
                length -= 1
                stack[top] = path[length]
        own = K[ldl.diagonal[k]]
        for r in range(3):
            for c in range(3):
                D[r, c] = own[r, c]
        scale = max(abs(D[0, 0]), abs(D[1, 1]), abs(D[2, 2]))
        for q in range(top, n):
            i = stack[q]
            y00, y01, y02 = Y[i, 0, 0], Y[i, 0, 1], Y[i, 0, 2]
            y10, y11, y12 = Y[i, 1, 0], Y[i, 1, 1], Y[i, 1, 2]
            y20, y21, y22 = Y[i, 2, 0], Y[i, 2, 1], Y[i, 2, 2]
            Y[i] = 0.0
            last = L_start[i] + L_count[i]
            for p in range(L_start[i], last):
                j = L_row[p]
                for r in range(3):
                    l0, l1, l2 = L[p, r, 0], L[p, r, 1], L[p, r, 2]
                    Y[j, r, 0] -= l0 * y00 + l1 * y10 + l2 * y20
                    Y[j, r, 1] -= l0 * y01 + l1 * y11 + l2 * y21
                    Y[j, r, 2] -= l0 * y02 + l1 * y12 + l2 * y22
            # L[k, i] = yᵀ D⁻¹[i], and D[k] loses L[k, i] y
            L[last, 0, 0], L[last, 0, 1], L[last, 0, 2] = _solve_pivot(pivots[i], y00, y10, y20)
            L[last, 1, 0], L[last, 1, 1], L[last, 1, 2] = _solve_pivot(pivots[i], y01, y11, y21)
            L[last, 2, 0], L[last, 2, 1], L[last, 2, 2] = _solve_pivot(pivots[i], y02, y12, y22)
            for r in range(3):
                l0, l1, l2 = L[last, r, 0], L[last, r, 1], L[last, r, 2]
                D[r, 0] -= l0 * y00 + l1 * y10 + l2 * y20
                D[r, 1] -= l0 * y01 + l1 * y11 + l2 * y21
                D[r, 2] -= l0 * y02 + l1 * y12 + l2 * y22
            L_row[last] = k
            L_count[i] += 1
        if not _factor_pivot(D, scale, pivots[k]):
            return k
    return -1


@njit(cache=True, forceinline=True)
def _solve(n: int, ldl: Ldl, b: FloatArray) -> None:
    """Overwrite the rows of b (·, 3) of the n nodes with those of K⁻¹ b."""
    order, L_start, L_row, L, pivots, y = ldl.order, ldl.L_start, ldl.L_row, ldl.L, ldl.pivots, ldl.y
    for k in range(n):
        for c in range(3):
            y[k, c] = b[order[k], c]
    for k in range(n):
        y0, y1, y2 = y[k, 0], y[k, 1], y[k, 2]
        for p in range(L_start[k], L_start[k + 1]):
            j = L_row[p]
            for r in range(3):
                y[j, r] -= L[p, r, 0] * y0 + L[p, r, 1] * y1 + L[p, r, 2] * y2
    for k in range(n - 1, -1, -1):
        y0, y1, y2 = y[k, 0], y[k, 1], y[k, 2]
        y[k, 0], y[k, 1], y[k, 2] = _solve_pivot(pivots[k], y0, y1, y2)
        for p in range(L_start[k], L_start[k + 1]):
            j = L_row[p]
            for r in range(3):
                y[k, r] -= L[p, 0, r] * y[j, 0] + L[p, 1, r] * y[j, 1] + L[p, 2, r] * y[j, 2]
    for k in range(n):
        for c in range(3):
            b[order[k], c] = y[k, c]


def minimum_degree_order(pattern: BlockPattern) -> IntArray:
    """Nodes in the minimum-degree order that SuperLU finds for the whole pattern, (n,)."""
    n = pattern.node_count
    upper = sparse.csc_matrix((np.ones(len(pattern.rows)), (pattern.rows, pattern.columns)), shape=(n, n))
    dominant = sparse.csc_matrix(
        upper + upper.T + sparse.diags_array(np.full(n, float(n)))
    )  # any values would do
    place = splu(
        dominant, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    ).perm_c
    return np.argsort(place).astype(np.int64)


class BlockLdl:
    """LDLᵀ of symmetric block matrices with blocks in `pattern`, of which some may be zero for a time."""

    def __init__(self, pattern: BlockPattern) -> None:
        n = self._size = pattern.node_count
        order = minimum_degree_order(pattern)
        place = np.empty(n, dtype=np.int64)
        place[order] = np.arange(n)
        rows, columns = place[pattern.rows], place[pattern.columns]
        blocks = np.arange(len(rows))
        on_diagonal = rows == columns
        diagonal = np.empty(n, dtype=np.int64)
        diagonal[rows[on_diagonal]] = blocks[on_diagonal]
        off = np.flatnonzero(~on_diagonal)
        upper_row, upper_column = np.minimum(rows, columns)[off], np.maximum(rows, columns)[off]
        by_column = np.lexsort((upper_row, upper_column))
        source = off[by_column]
        empty = Ldl(
            order=order,
            diagonal=diagonal,
            column_start=np.searchsorted(upper_column[by_column], np.arange(n + 1)),
            row=upper_row[by_column],
            source=source,
            flipped=(rows > columns)[source],
            present=np.ones(len(off), dtype=np.bool_),
            parent=wholes(n),
            L_start=wholes(n + 1),
            L_row=wholes(0),
            L=np.empty((0, 3, 3)),
            pivots=np.empty((n, 6)),
            flag=wholes(n),
            filled=wholes(n),
            path=wholes(n),
            stack=wholes(n),
            Y=np.zeros((n, 3, 3)),
            y=np.empty((n, 3)),
        )
        _symbolic(np.ones((len(rows), 3, 3)), n, empty)
        count = empty.L_start[-1]
        self.ldl = empty._replace(L_row=wholes(count), L=np.empty((count, 3, 3)))

    @property
    def block_count(self) -> int:
        """Number of 3×3 blocks below the diagonal of L in the present factor."""
        return int(self.ldl.L_start[-1])

    def factor(self, K: FloatArray) -> None:
        """Factor the matrix with the upper blocks K (b, 3, 3); raises RunError if it is singular."""
        _symbolic(K, self._size, self.ldl)
        singular = _numeric(K, self._size, self.ldl)
        if singular >= 0:
            node = self.ldl.order[singular]
            raise RunError(f"the Newton matrix is singular at node {node}: nothing holds it")

    def solve(self, right: FloatArray) -> FloatArray:
        """Solution (n, 3) for a right-hand side (n, 3), written over it."""
        _solve(self._size, self.ldl, right)
        return right
