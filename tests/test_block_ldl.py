"""The block LDLᵀ against dense solves and an independent sparse one, and the seam that takes either."""

from __future__ import annotations

import numpy as np
import pytest
import qdldl
from conftest import reference_flight
from numpy.random import default_rng
from scipy import sparse

from netdae.core.errors import RunError
from netdae.model.net import CableNet
from netdae.solvers.linalg.block_ldl import BlockLdl
from netdae.solvers.linalg.condensed import CondensedSolver
from netdae.system.assembly import BlockPattern


class Qdldl:
    """qdldl behind the seam: the whole pattern, as scalars."""

    def __init__(self, pattern):
        self.pattern, self.solver = pattern, None

    def factor(self, K):
        self.solver = qdldl.Solver(sparse.csc_matrix(np.triu(dense(self.pattern, K))), upper=True)

    def solve(self, right):
        return self.solver.solve(right.ravel()).reshape(-1, 3)


def dense(pattern, K):
    n = pattern.node_count
    A = np.zeros((n, 3, n, 3))
    for block, i, j in zip(K, pattern.rows, pattern.columns, strict=True):
        A[i, :, j], A[j, :, i] = block, block.T
    return A.reshape(3 * n, 3 * n)


def random_blocks(seed, *, gone=0.0, shift=6.0):
    """Blocks of a square net, a share `gone` of the couplings zero; a large shift makes them definite."""
    net = CableNet.square(side=1.0, cells=5)
    pattern = BlockPattern.of(net.node_count, [net.cables])
    rng = default_rng(seed)
    K = rng.standard_normal((len(pattern.rows), 3, 3))
    diagonal = pattern.rows == pattern.columns
    K[diagonal] = K[diagonal] + K[diagonal].transpose(0, 2, 1) + shift * np.eye(3)
    K[~diagonal & (rng.random(len(K)) < gone)] = 0.0
    return pattern, K


@pytest.mark.parametrize("gone", [0.0, 0.5, 0.9, 1.0])
@pytest.mark.parametrize("shift", [20.0, 3.0])  # definite, and with negative pivots
def test_solutions_are_those_of_the_dense_matrix(gone, shift):
    pattern, K = random_blocks(3, gone=gone, shift=shift)
    A, b = dense(pattern, K), default_rng(4).standard_normal((pattern.node_count, 3))
    if shift < 10 and gone < 1:
        assert np.linalg.eigvalsh(A)[0] < 0
    solver = BlockLdl(pattern)
    solver.factor(K)
    x = solver.solve(b.copy())
    # round-off of 108 unknowns, amplified by the growth of a factor without pivoting
    np.testing.assert_allclose(
        A @ x.ravel(), b.ravel(), rtol=0, atol=1e-11 * np.abs(A).max() * np.abs(x).max()
    )


def test_couplings_that_are_zero_cost_no_fill():
    pattern, K = random_blocks(5)
    solver = BlockLdl(pattern)
    solver.factor(K)
    whole = solver.block_count
    K[pattern.rows != pattern.columns] = 0.0
    K[np.flatnonzero(pattern.rows != pattern.columns)[:7], 1, 2] = 1e-3
    solver.factor(K)
    # seven couplings in a forest of 36 nodes: at most one fill-in for each pair of them
    assert 7 <= solver.block_count <= 7 + 21
    assert whole >= len(pattern.rows) - pattern.node_count
    solver.factor(random_blocks(5)[1])
    assert solver.block_count == whole


@pytest.mark.parametrize("seed", range(40))
def test_a_singular_matrix_is_refused_and_a_held_one_is_not(seed):
    """Laplacian of a chain of springs in random directions: nothing holds its motion as a whole."""
    rng = default_rng(seed)
    nodes = np.stack((np.arange(5), np.arange(1, 6)), axis=1)
    pattern = BlockPattern.of(6, [nodes])
    K = np.zeros((len(pattern.rows), 3, 3))
    place = pattern.places_of(nodes)
    for e in range(5):
        A = rng.standard_normal((3, 3))
        spring = 10.0 ** rng.uniform(0, 3) * (A @ A.T + 0.1 * np.eye(3))
        K[place[e, 0, 0]] += spring
        K[place[e, 1, 1]] += spring
        K[place[e, 0, 1]] -= spring
    with pytest.raises(RunError, match="singular at node"):
        BlockLdl(pattern).factor(K)
    K[pattern.rows == pattern.columns] += 1e-3 * np.eye(3)
    BlockLdl(pattern).factor(K)


def test_another_factorisation_fits_behind_the_seam():
    system, start = reference_flight(4)
    taut = 1.001 * system.net.nodes
    r1, r2 = default_rng(0).standard_normal((2, *taut.shape))
    found = []
    for factorization in (BlockLdl, Qdldl):
        solver = CondensedSolver(system, factorization)
        solver.setup(system, 0.0, taut, start.v, 3e3)
        dx, dv = np.empty((2, *taut.shape))
        solver.solve(r1, r2, 2.5e3, dx, dv)
        found.append(np.stack((dx, dv)))
    # both are direct: they differ by round-off times the condition of K, some 1e4
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-11 * np.abs(found[1]).max())
