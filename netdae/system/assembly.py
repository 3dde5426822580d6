"""From elements to the net: scatter, and the block pattern of symmetric matrices.

Symbols: n nodes, m elements of k nodes, b blocks (3, 3) of the upper triangle, one for each pair of nodes
that share an element and one for each node; block (I, J) has I ≤ J.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy import sparse

from netdae.core.arrays import BoolArray, FloatArray, IntArray, frozen_ints


@njit(cache=True)
def scatter_add(local: FloatArray, nodes: IntArray, values: FloatArray) -> None:
    """Σ Aₑᵀ of Eq. (8): values (n, 3) gain local (m, k, 3)."""
    for e in range(nodes.shape[0]):
        for a in range(nodes.shape[1]):
            for c in range(3):
                values[nodes[e, a], c] += local[e, a, c]


@njit(cache=True)
def scatter_blocks(
    elements: IntArray, K: FloatArray, C: FloatArray, places: IntArray, T: FloatArray, D: FloatArray
) -> None:
    """Σ Aₑᵀ (·)ₑ Aₑ of Eq. (8): T and D (b, 3, 3) lose the symmetric parts of K and C (a, k, 3, k, 3).

    elements : (a,), which of the m elements K and C are of; places : (m, k, k)
    A tangent is the derivative of a force, a matrix of the net its negative: hence the minus sign.
    """
    k = places.shape[1]
    for e in range(len(elements)):
        for i in range(k):
            for j in range(k):
                place = places[elements[e], i, j]
                if place < 0:
                    continue
                for r in range(3):
                    for c in range(3):
                        T[place, r, c] -= 0.5 * (K[e, i, r, j, c] + K[e, j, c, i, r])
                        D[place, r, c] -= 0.5 * (C[e, i, r, j, c] + C[e, j, c, i, r])


@njit(cache=True)
def blocks_present(blocks: FloatArray) -> IntArray:
    """Indices of the blocks (b, 3, 3) that are not zero."""
    present = np.empty(len(blocks), dtype=np.int64)
    count = 0
    for b in range(len(blocks)):
        there = False
        for r in range(3):
            for c in range(3):
                there = there or blocks[b, r, c] != 0.0
        if there:
            present[count] = b
            count += 1
    return present[:count].copy()


@njit(cache=True, forceinline=True)
def add_symmetric_product(
    blocks: FloatArray,
    present: IntArray,
    rows: IntArray,
    columns: IntArray,
    factor: float,
    u: FloatArray,
    out: FloatArray,
) -> None:
    """Out (n, 3) gains `factor` times the symmetric matrix of the blocks `present` times u (n, 3)."""
    for b in present:
        i, j = rows[b], columns[b]
        for r in range(3):
            for c in range(3):
                out[i, r] += factor * blocks[b, r, c] * u[j, c]
                if i != j:
                    out[j, c] += factor * blocks[b, r, c] * u[i, r]


@njit(cache=True)
def newton_blocks(
    T: FloatArray,
    D: FloatArray,
    mass: FloatArray,
    cj: float,
    mask: BoolArray,
    rows: IntArray,
    columns: IntArray,
    K: FloatArray,
) -> None:
    """K = c_j² M + c_j D + T with rows and columns of restrained axes zeroed but for their diagonal."""
    for b in range(len(rows)):
        i, j = rows[b], columns[b]
        for r in range(3):
            for c in range(3):
                K[b, r, c] = cj * D[b, r, c] + T[b, r, c]
                if mask[i, r] or mask[j, c]:
                    K[b, r, c] = 0.0
            if i == j:
                # with c_j² m too, a restrained axis stays near the other pivots in the smallest steps
                K[b, r, r] = (1.0 if mask[i, r] else K[b, r, r]) + cj * cj * mass[i]


def assembled(elements: FloatArray, nodes: IntArray, node_count: int) -> sparse.csr_matrix:
    """Σ Aₑᵀ (·)ₑ Aₑ, Eq. (8), of elements (a, 3k, 3k) or (a, k, 3, k, 3) with nodes (a, k), as (3n, 3n)."""
    dof = (3 * nodes[:, :, None] + np.arange(3)).reshape(len(nodes), 3 * nodes.shape[1])
    rows, columns = np.broadcast_arrays(dof[:, :, None], dof[:, None, :])
    size = 3 * node_count
    return sparse.csr_matrix((elements.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size))


@dataclass(frozen=True, eq=False)
class BlockPattern:
    """Which blocks a symmetric matrix of the net has.

    node_count : n
    rows, columns : (b,), nodes I ≤ J of each block, by column and then by row
    """

    node_count: int
    rows: IntArray
    columns: IntArray

    @classmethod
    def of(cls, node_count: int, elements: list[IntArray]) -> BlockPattern:
        """Pattern of elements given by their nodes, each (m, k)."""
        diagonal = np.arange(node_count)
        pairs = [np.stack((diagonal, diagonal), axis=1)]
        for nodes in elements:
            k = nodes.shape[1]
            for i in range(k):
                for j in range(i + 1, k):
                    pairs.append(np.sort(nodes[:, [i, j]], axis=1))
        column_row = np.unique(np.concatenate(pairs)[:, ::-1], axis=0)
        return cls(node_count, frozen_ints(column_row[:, 1]), frozen_ints(column_row[:, 0]))

    def places_of(self, nodes: IntArray) -> IntArray:
        """Block of each pair of an element's nodes, (m, k, k); −1 below the diagonal."""
        i, j = nodes[:, :, None], nodes[:, None, :]
        keys = self.columns * self.node_count + self.rows
        wanted = np.maximum(i, j) * self.node_count + np.minimum(i, j)
        return np.ascontiguousarray(np.where(i <= j, np.searchsorted(keys, wanted), -1))
