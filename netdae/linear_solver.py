"""The condensed direct solve of the Newton system of the first-order residual.

Symbols: x, v (n, 3); F₁ = ẋ − v and F₂ = M v̇ − f with residual parts r₁, r₂; c_j of the BDF formula;
T = −∂f/∂x, D = −∂f/∂v. The Jacobian is J = [[c_j I, −I], [T, c_j M + D]]. Its first row gives

    dv = c_j dx − r₁,       and so       K dx = r₂ + (c_j M + D) r₁       with  K = c_j² M + c_j D + T,

a system of 3n unknowns. On restrained axes c both rows are algebraic, x − x_d = r₁ and v − v_d = r₂:

    dx_c = r₁,  dv_c = r₂,      K_ff dx_f = r₂ + c_j M r₁ + [D u]_f − [T w]_f,   u = (r₁f, −dv_c),  w = (0, dx_c),

for which the rows and columns of c are zeroed in K, with 1 on the diagonal.
K takes the symmetric parts of T and D, so that one LDLᵀ serves; what is left out slows Newton's iteration
but does not change its result. Negative pivots are accepted: gravity gradients and contact bring them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
import qdldl
from scipy import sparse

from netdae._arrays import FloatArray
from netdae.assembly import BlockPattern, newton_blocks, symmetric_product
from netdae.errors import RunError
from netdae.system import System


class Factorization(Protocol):
    """A direct solver of symmetric block matrices with one pattern: the place for another LDLᵀ or Cholesky."""

    def factor(self, K: FloatArray) -> None:
        """Factor the matrix with the upper blocks K (b, 3, 3); raises RunError if it is singular."""
        ...

    def solve(self, right: FloatArray) -> FloatArray:
        """Solution (n, 3) for a right-hand side (n, 3)."""
        ...


class QdldlFactorization:
    """Sparse LDLᵀ by qdldl in a minimum-degree order; the symbolic part is done once for the pattern."""

    def __init__(self, pattern: BlockPattern) -> None:
        self._upper, self._places = pattern.upper_csc()
        self._solver: qdldl.Solver | None = None

    def factor(self, K: FloatArray) -> None:
        """Factor the matrix with the upper blocks K (b, 3, 3)."""
        np.take(K.ravel(), self._places, out=self._upper.data)
        try:
            if self._solver is None:
                self._solver = qdldl.Solver(self._upper, upper=True)
            else:
                self._solver.update(self._upper, upper=True)
        except RuntimeError as error:
            raise RunError(f"the Newton matrix is singular: {error}") from error

    def solve(self, right: FloatArray) -> FloatArray:
        """Solution (n, 3) for a right-hand side (n, 3)."""
        assert self._solver is not None, "factor() comes first"
        return self._solver.solve(right.ravel()).reshape(-1, 3)


class CondensedSolver:
    """Factor J at one state; solve with it at later ones, whose c_j may differ a little."""

    def __init__(
        self, system: System, factorization: Callable[[BlockPattern], Factorization] = QdldlFactorization
    ) -> None:
        self._system = system
        self._factorization = factorization(system.pattern)
        blocks = len(system.pattern.rows)
        self._T, self._D, self._K = (np.zeros((blocks, 3, 3)) for _ in range(3))
        self._cj = 0.0

    def setup(self, system: System, t: float, x: FloatArray, v: FloatArray, cj: float) -> None:
        """Assemble and factor K at (t, x, v); `system` is the phase that the flight is in."""
        self._T, self._D = system.tangent_blocks(t, x, v)
        self._cj = cj
        pattern = system.pattern
        newton_blocks(
            self._T, self._D, system.mass, cj, system.restrained, pattern.rows, pattern.columns, self._K
        )
        self._factorization.factor(self._K)

    def solve(self, r1: FloatArray, r2: FloatArray, cj: float, dx: FloatArray, dv: FloatArray) -> None:
        """Write the solution of J (dx, dv) = (r1, r2), all (n, 3).

        The free part is scaled by 2/(1 + c_j/c_j,setup), as IDA does for direct solvers.
        """
        system, cj0 = self._system, self._cj
        held = system.restrained
        right = r2 + cj0 * system.mass[:, None] * r1
        work = np.empty_like(right)
        pattern = system.pattern
        u = np.where(held, -r2, r1)
        symmetric_product(self._D, pattern.rows, pattern.columns, u, work)
        right += work
        if held.any():
            symmetric_product(self._T, pattern.rows, pattern.columns, np.where(held, r1, 0.0), work)
            right -= work
            right[held] = 0.0
        scale = 2.0 / (1.0 + cj / cj0)
        dx[:] = scale * self._factorization.solve(right)
        dv[:] = cj0 * dx - scale * r1
        dx[held] = r1[held]
        dv[held] = r2[held]


def full_jacobian(system: System, t: float, x: FloatArray, v: FloatArray, cj: float) -> sparse.csr_matrix:
    """J of the whole residual, (6n, 6n), with the whole tangents: for checks and for other solvers."""
    n = system.net.node_count
    rows, columns, K_entries, C_entries = [], [], [], []
    for force in system.forces:
        nodes = force.nodes
        K, C = force.tangent(t, x[nodes], v[nodes])
        dof = (3 * nodes[:, :, None] + np.arange(3)).reshape(len(nodes), -1)
        row, column = np.broadcast_arrays(dof[:, :, None], dof[:, None, :])
        rows.append(row.ravel())
        columns.append(column.ravel())
        K_entries.append(K.ravel())
        C_entries.append(C.ravel())
    place = np.concatenate(rows), np.concatenate(columns)
    T = -sparse.csr_matrix((np.concatenate(K_entries), place), shape=(3 * n, 3 * n))
    D = -sparse.csr_matrix((np.concatenate(C_entries), place), shape=(3 * n, 3 * n))
    identity = sparse.identity(3 * n, format="csr")
    free = sparse.diags_array((~system.restrained.ravel()).astype(np.float64))
    held = sparse.diags_array(system.restrained.ravel().astype(np.float64))
    return sparse.block_array(
        [
            [cj * free @ identity + held, -free],
            [free @ T, free @ (cj * system.mass_matrix() + D) + held],
        ],
        format="csr",
    )
