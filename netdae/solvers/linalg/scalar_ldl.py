"""LDLᵀ of a sparse symmetric positive definite matrix: its pattern is analysed once; factor and solve are compiled.

Unknowns are in a minimum-degree order, sorted within it by their height in the elimination tree: neighbours in this
order do not wait for each other, as those along a line of cables would. The fill is that of the tree, whatever the
order of its branches.

The method is the up-looking LDLᵀ of T. A. Davis, Algorithm 849 (ACM TOMS 31, 2005, doi:10.1145/1114268.1114277).
Symbols: A = L D Lᵀ (u, u), 1 on the diagonal of L, whose l entries below it stand by columns.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy import sparse
from scipy.sparse.linalg import splu

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import RunError


class Factor(NamedTuple):
    """The factor, and workspace for the solve."""

    start: IntArray  # (u + 1,), where each column of L starts
    column: IntArray  # (l,)
    row: IntArray  # (l,)
    L: FloatArray  # (l,)
    inverse: FloatArray  # (u,), 1/D
    y: FloatArray  # (u,)


@njit(cache=True)
def _tree(start: IntArray, row: IntArray, parent: IntArray, count: IntArray, flag: IntArray) -> None:
    """Elimination tree of the upper triangle by columns, and how many entries each column of L has."""
    for k in range(len(parent)):
        parent[k], count[k], flag[k] = -1, 0, k
        for p in range(start[k], start[k + 1]):
            i = row[p]
            while flag[i] != k:
                if parent[i] == -1:
                    parent[i] = k
                count[i] += 1
                flag[i] = k
                i = parent[i]


@njit(cache=True)
def _factor(
    start: IntArray, row: IntArray, beside: FloatArray, diagonal: FloatArray, parent: IntArray, factor: Factor
) -> int:
    """Compute L and 1/D by rows; return the first unknown whose pivot is not positive, or −1."""
    n = len(parent)
    y, L, L_row = np.zeros(n), factor.L, factor.row
    flag, count, path, stack = (
        np.full(n, -1),
        np.zeros(n, dtype=np.int64),
        np.empty(n, dtype=np.int64),
        np.empty(n, dtype=np.int64),
    )
    for k in range(n):
        top, flag[k], d = n, k, diagonal[k]
        for p in range(start[k], start[k + 1]):
            i, length = row[p], 0
            y[i] = beside[p]
            while flag[i] != k:
                path[length] = i
                length += 1
                flag[i] = k
                i = parent[i]
            while length > 0:
                top -= 1
                length -= 1
                stack[top] = path[length]
        for q in range(top, n):
            i = stack[q]
            yi, last = y[i], factor.start[i] + count[i]
            y[i] = 0.0
            for p in range(factor.start[i], last):
                y[L_row[p]] -= L[p] * yi
            L_row[last], L[last] = k, yi * factor.inverse[i]
            d -= L[last] * yi
            count[i] += 1
        if not d > 0.0:
            return k
        factor.inverse[k] = 1.0 / d
    return -1


@njit(cache=True, forceinline=True)
def solve(factor: Factor) -> None:
    """`y` becomes A⁻¹ y."""
    _, column, row, L, inverse, y = factor
    for p in range(len(L)):
        y[row[p]] -= L[p] * y[column[p]]
    for k in range(len(y)):
        y[k] *= inverse[k]
    for p in range(len(L) - 1, -1, -1):
        y[column[p]] -= L[p] * y[row[p]]


class ScalarLdl:
    """LDLᵀ of matrices with entries off the diagonal at (rows, columns), each pair once.

    order : (u,), the unknowns as `Factor.y` holds them
    """

    def __init__(self, size: int, rows: IntArray, columns: IntArray) -> None:
        self.order = _minimum_degree(size, rows, columns)
        parent = self._place(rows, columns)[0]
        height = np.zeros(size, dtype=np.int64)
        for k, above in enumerate(parent):  # children stand before their parents
            if above >= 0:
                height[above] = max(height[above], height[k] + 1)
        self.order = self.order[np.argsort(height, kind="stable")]
        self._parent, count = self._place(rows, columns)
        start = np.concatenate((np.zeros(1, dtype=np.int64), np.cumsum(count)))
        entries = int(start[-1])
        column, row = np.repeat(np.arange(size), count), np.zeros(entries, dtype=np.int64)
        self.factor = Factor(start, column, row, np.zeros(entries), np.zeros(size), np.zeros(size))

    def _place(self, rows: IntArray, columns: IntArray) -> tuple[IntArray, IntArray]:
        """Sort the upper triangle by columns of the present order; its tree, and the lengths of the columns of L."""
        size = len(self.order)
        place = np.empty(size, dtype=np.int64)
        place[self.order] = np.arange(size)
        ends = np.sort(np.stack((place[rows], place[columns])), axis=0)
        self._source = np.lexsort(ends)
        self._row, column = ends[:, self._source]
        self._row = np.ascontiguousarray(self._row)
        self._start = np.searchsorted(column, np.arange(size + 1))
        parent, count, flag = np.empty((3, size), dtype=np.int64)
        _tree(self._start, self._row, parent, count, flag)
        return parent, count

    def factorize(self, diagonal: FloatArray, beside: FloatArray) -> Factor:
        """The factor of the matrix with this diagonal (u,) and these entries beside it, in the order of their pairs."""
        bad = _factor(
            self._start, self._row, beside[self._source], diagonal[self.order], self._parent, self.factor
        )
        if bad >= 0:
            raise RunError(f"the damping matrix is not positive definite at unknown {self.order[bad]}")
        return self.factor


def _minimum_degree(size: int, rows: IntArray, columns: IntArray) -> IntArray:
    """Unknowns in the minimum-degree order that SuperLU finds, (u,)."""
    if not size:
        return np.zeros(0, dtype=np.int64)
    upper = sparse.csc_matrix((np.ones(len(rows)), (rows, columns)), shape=(size, size))
    whole = sparse.csc_matrix(
        upper + upper.T + sparse.diags_array(np.full(size, float(size)))
    )  # any values do
    options = {"SymmetricMode": True}
    return np.argsort(
        splu(whole, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options).perm_c
    ).astype(np.int64)
