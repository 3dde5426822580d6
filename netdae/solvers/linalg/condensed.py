"""The condensed direct solve of the Newton system of the first-order residual.

Symbols: x, v (n, 3); F₁ = ẋ − v and F₂ = M v̇ − f with residual parts r₁, r₂; c_j of the BDF formula;
T = −∂f/∂x, D = −∂f/∂v. The Jacobian is J = [[c_j I, −I], [T, c_j M + D]]. Its first row gives

    dv = c_j dx − r₁,       and so       K dx = r₂ + (c_j M + D) r₁       with  K = c_j² M + c_j D + T,

a system of 3n unknowns. On restrained axes c both rows are algebraic, x − x_d = r₁ and v − v_d = r₂:

    dx_c = r₁,  dv_c = r₂,      K_ff dx_f = r₂ + c_j M r₁ + [D u]_f − [T w]_f,   u = (r₁f, −dv_c),  w = (0, dx_c),

for which the rows and columns of c are zeroed in K, with 1 + c_j² M on the diagonal (of the size of its neighbours).
K takes the symmetric parts of T and D, so that one LDLᵀ suffices; what is left out slows Newton's iteration
but does not change its result. Negative pivots are accepted: gravity gradients and contact cause them.

A drawcord through many rings couples all of them, which would fill the factor. Its tangents are a chain of blocks
minus dyads: Σ p ⊗ q_T in T and Σ p ⊗ q_D in D. With P (3n, r) the p as columns, zeroed on restrained axes, Q those of
q_T + c_j q_D and A the matrix of the blocks alone, Woodbury's formula is exact (Sherman and Morrison's for r = 1):

    K = A − P Qᵀ,       K⁻¹ b = y + Z (I − Qᵀ Z)⁻¹ Qᵀ y  with  y = A⁻¹ b,  Z = A⁻¹ P:

This takes r more solves per setup and, besides y, none per solve. Dyads may be unsymmetric: they are kept in full.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, cast

import numpy as np
from numba import njit
from scipy import sparse

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.core.errors import RunError
from netdae.forces.force import LinkedForce
from netdae.solvers.linalg.block_ldl import BlockLdl
from netdae.system.assembly import (
    BlockPattern,
    add_symmetric_product,
    assembled,
    blocks_present,
    newton_blocks,
)
from netdae.system.system import System


class Factorization(Protocol):
    """A direct solver of symmetric block matrices with one pattern: the interface for another LDLᵀ or Cholesky."""

    def factor(self, K: FloatArray) -> None:
        """Factor the matrix with the upper blocks K (b, 3, 3); raises RunError if it is singular."""
        ...

    def solve(self, right: FloatArray) -> FloatArray:
        """Solution (n, 3) for a right-hand side (n, 3), which may be overwritten."""
        ...


@njit(cache=True)
def _condense(
    D: FloatArray,
    D_present: IntArray,
    T: FloatArray,
    T_present: IntArray,
    rows: IntArray,
    columns: IntArray,
    mass: FloatArray,
    held: BoolArray,
    cj: float,
    r1: FloatArray,
    r2: FloatArray,
    right: FloatArray,
) -> None:
    """right = r₂ + c_j M r₁ + [D u]_f − [T w]_f, zero on restrained axes."""
    u, w = np.empty_like(r1), np.zeros_like(r1)
    for i in range(len(mass)):
        for c in range(3):
            right[i, c] = r2[i, c] + cj * mass[i] * r1[i, c]
            u[i, c] = r1[i, c]
            if held[i, c]:
                u[i, c], w[i, c] = -r2[i, c], r1[i, c]
    add_symmetric_product(D, D_present, rows, columns, 1.0, u, right)
    if len(T_present):
        add_symmetric_product(T, T_present, rows, columns, -1.0, w, right)
        for i in range(len(mass)):
            for c in range(3):
                if held[i, c]:
                    right[i, c] = 0.0


@njit(cache=True)
def _expand(
    solution: FloatArray,
    held: BoolArray,
    cj: float,
    scale: float,
    r1: FloatArray,
    r2: FloatArray,
    dx: FloatArray,
    dv: FloatArray,
) -> None:
    """dx and dv = c_j dx − r₁ on free axes, r₁ and r₂ on restrained ones."""
    for i in range(len(solution)):
        for c in range(3):
            if held[i, c]:
                dx[i, c], dv[i, c] = r1[i, c], r2[i, c]
            else:
                dx[i, c] = scale * solution[i, c]
                dv[i, c] = cj * dx[i, c] - scale * r1[i, c]


class Dyads:
    """Dyads of T and D beside their blocks, at one state.

    left : p (r, 3n), zeroed on restrained axes; by_x, by_v : q_T, q_D (r, 3n)
    """

    def __init__(self, left: FloatArray, by_x: FloatArray, by_v: FloatArray, held: BoolArray) -> None:
        self._left = np.where(held.ravel(), 0.0, left)
        self._by_x, self._by_v = by_x, by_v
        self._held = held.ravel()

    @classmethod
    def of(cls, system: System, t: float, x: FloatArray, v: FloatArray) -> Dyads | None:
        """Dyads of all forces with links that have any at this state."""
        parts = []
        for force in system.forces:
            if force.newton == "links":
                linked = cast(LinkedForce, force)
                _, _, *dyads = linked.newton_part(system.inside(t), x[force.nodes], v[force.nodes])
                spread = np.zeros((3, len(dyads[0]), system.net.node_count, 3))
                spread[:, :, force.nodes[0]] = dyads  # each node once
                parts.append(spread)
        if not parts or not (whole := np.concatenate(parts, axis=1)).shape[1]:
            return None
        left, by_x, by_v = whole.reshape(3, whole.shape[1], -1)
        return cls(left, by_x, by_v, system.restrained)

    def factor(self, factorization: Factorization, cj: float) -> None:
        """Compute Z and (I − Qᵀ Z)⁻¹ with the factor of A."""
        r = len(self._left)
        self._Q = self._by_x + cj * self._by_v
        self._Z = np.empty_like(self._left)
        for column, right in zip(self._Z, self._left, strict=True):
            column[:] = factorization.solve(right.reshape(-1, 3).copy()).ravel()
        try:
            self._inverse = np.linalg.inv(np.eye(r) - self._Q @ self._Z.T)
        except np.linalg.LinAlgError as error:
            raise RunError("the Newton matrix is singular by its cords: nothing holds them") from error

    def add_products(self, r1: FloatArray, r2: FloatArray, right: FloatArray) -> None:
        """Add to right (n, 3) the parts of [D u]_f − [T w]_f that the blocks leave out."""
        held = self._held
        u = np.where(held, -r2.ravel(), r1.ravel())
        w = np.where(held, r1.ravel(), 0.0)
        right += ((self._by_x @ w - self._by_v @ u) @ self._left).reshape(right.shape)

    def complete(self, y: FloatArray) -> FloatArray:
        """K⁻¹ b (n, 3) from y = A⁻¹ b (n, 3)."""
        return y + ((self._inverse @ (self._Q @ y.ravel())) @ self._Z).reshape(y.shape)


class CondensedSolver:
    """Factor J at one state; solve with it at later ones, whose c_j may differ a little.

    factorization : makes the LDLᵀ of K for a pattern; another solver can be put here
    """

    def __init__(
        self, system: System, factorization: Callable[[BlockPattern], Factorization] = BlockLdl
    ) -> None:
        self._pattern = system.pattern
        self._mass = system.mass
        self._held = system.restrained
        self._factorization = factorization(system.pattern)
        self._T, self._D, self._K = np.zeros((3, len(system.pattern.rows), 3, 3))
        self._T_present = self._D_present = np.arange(0)
        self._right = np.empty((system.net.node_count, 3))
        self._dyads: Dyads | None = None
        self._cj = 0.0

    def setup(self, system: System, t: float, x: FloatArray, v: FloatArray, cj: float) -> None:
        """Assemble and factor K at (t, x, v); `system` is the phase that the flight is in."""
        rows, columns = self._pattern.rows, self._pattern.columns
        self._T, self._D = system.tangent_blocks(t, x, v)
        self._D_present = blocks_present(self._D)
        if self._held.any():
            self._T_present = blocks_present(self._T)
        self._cj = cj
        newton_blocks(self._T, self._D, self._mass, cj, self._held, rows, columns, self._K)
        self._factorization.factor(self._K)
        self._dyads = Dyads.of(system, t, x, v)
        if self._dyads is not None:
            self._dyads.factor(self._factorization, cj)

    def solve(self, r1: FloatArray, r2: FloatArray, cj: float, dx: FloatArray, dv: FloatArray) -> None:
        """Write the solution of J (dx, dv) = (r1, r2), all (n, 3).

        The free part is scaled by 2/(1 + c_j/c_j,setup), as IDA does for direct solvers.
        """
        pattern, cj0 = self._pattern, self._cj
        _condense(
            self._D,
            self._D_present,
            self._T,
            self._T_present,
            pattern.rows,
            pattern.columns,
            self._mass,
            self._held,
            cj0,
            r1,
            r2,
            self._right,
        )
        if self._dyads is not None:
            self._dyads.add_products(r1, r2, self._right)
        solution = self._factorization.solve(self._right)
        if self._dyads is not None:
            solution = self._dyads.complete(solution)
        _expand(solution, self._held, cj0, 2.0 / (1.0 + cj / cj0), r1, r2, dx, dv)


def whole_tangents(
    system: System, t: float, x: FloatArray, v: FloatArray
) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
    """∂f/∂x and ∂f/∂v of all forces together, (3n, 3n), with their unsymmetric parts."""
    n = system.net.node_count
    dx, dv = sparse.csr_matrix((3 * n, 3 * n)), sparse.csr_matrix((3 * n, 3 * n))
    for force in system.forces:
        elements, K, C = force.tangent(system.inside(t), x[force.nodes], v[force.nodes])
        dx = dx + assembled(K, force.nodes[elements], n)
        dv = dv + assembled(C, force.nodes[elements], n)
    return dx, dv


def full_jacobian(system: System, t: float, x: FloatArray, v: FloatArray, cj: float) -> sparse.csr_matrix:
    """J of the whole residual, (6n, 6n), with the whole tangents: for checks and for other solvers."""
    dx, dv = whole_tangents(system, t, x, v)
    free = sparse.diags_array((~system.restrained.ravel()).astype(np.float64))
    held = sparse.diags_array(system.restrained.ravel().astype(np.float64))
    return sparse.block_array(
        [
            [cj * free + held, -free],
            [-free @ dx, free @ (cj * system.mass_matrix() - dv) + held],
        ],
        format="csr",
    )
