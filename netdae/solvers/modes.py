"""Small free vibrations about a prestressed state: T φ = ω² M φ on the free axes.

Symbols: T tangent stiffness of all forces at rest and M lumped masses, both (3n, 3n); φ mode; ω circular frequency.
Damping and velocity-dependent forces are left out.
"""

from __future__ import annotations

import contextlib

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.linalg import eigh
from scipy.sparse.linalg import ArpackNoConvergence, eigsh

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.model.state import State
from netdae.solvers.linalg.condensed import full_jacobian
from netdae.solvers.statics import Equilibrium
from netdae.system.system import System

DENSE_LIMIT = 600  # free axes: up to here the dense solver takes under a tenth of a second
SPARSE_RESTARTS = 30  # a net held by tension needs less than 5


def frequencies(
    system: System, at: Equilibrium | State | ArrayLike, *, count: int = 6, t: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """The lowest natural frequencies about a prestressed state and their modes.

    at : an Equilibrium, a State or positions (n, 3)
    count : how many
    t : s, for loads that depend on time; by default the state's, or 0

    Returns the frequencies (count,) in Hz, ascending, and the modes (count, n, 3), scaled to φ·M φ = 1, zero on
    restrained axes. A motion without stiffness, as of a slack node or a floating net, has 0 Hz. A negative number
    −s indicates an unstable state, which departs as exp(2πs·t); cables and dead loads alone never give one.

    Raises InputError where fewer than `count` axes are free, or `at` has the wrong shape.
    """
    state = at.state if isinstance(at, Equilibrium) else at
    if isinstance(state, State):
        x, time = state.x, state.t if t is None else t
    else:
        x, time = np.array(state, dtype=np.float64), 0.0 if t is None else t
    n = system.net.node_count
    if x.shape != (n, 3):
        raise InputError(f"frequencies: the positions have the shape {x.shape}: the net has {n} nodes")
    free = np.flatnonzero(~system.restrained)
    if not 1 <= count <= len(free):
        raise InputError(
            f"frequencies: count is {count}: the net has {len(free)} free axes, give 1 to {len(free)}"
        )
    T = full_jacobian(system, system.inside(time), x, np.zeros_like(x), 0.0)[3 * n :, : 3 * n]
    T = (0.5 * (T + T.T)).tocsr()[free][:, free]
    root = np.sqrt(np.repeat(system.mass, 3)[free])
    # with ψ = √M φ: A ψ = ω² ψ
    A = (sparse.diags_array(1 / root) @ T @ sparse.diags_array(1 / root)).tocsc()
    stiffest = float(abs(A).sum(axis=0).max())  # bounds ω²
    squares, psi = _lowest(A, count, stiffest)
    squares[np.abs(squares) < 1e-14 * len(free) * stiffest] = 0.0  # the round-off of eigenvalues
    modes = np.zeros((count, 3 * n))
    modes[:, free] = psi.T / root
    return np.sign(squares) * np.sqrt(np.abs(squares)) / (2 * np.pi), modes.reshape(count, n, 3)


def _lowest(A: sparse.csc_matrix, count: int, stiffest: float) -> tuple[FloatArray, FloatArray]:
    """The `count` lowest eigenvalues of A, ascending, and their orthonormal vectors."""
    size = A.shape[0]
    touched = abs(A).sum(axis=0) > 0
    stiff, loose = np.flatnonzero(touched), np.flatnonzero(~touched)[:count]
    squares, psi = _lowest_stiff(A[stiff][:, stiff], min(count, len(stiff)), stiffest)
    # axes that nothing couples have 0 each; many of them would trouble the solver
    values = np.concatenate((squares, np.zeros(len(loose))))
    vectors = np.zeros((size, len(values)))
    vectors[stiff, : len(squares)] = psi
    vectors[loose, np.arange(len(squares), len(values))] = 1.0
    order = np.argsort(values, kind="stable")[:count]
    return values[order], vectors[:, order]


def _lowest_stiff(A: sparse.csc_matrix, count: int, stiffest: float) -> tuple[FloatArray, FloatArray]:
    size = A.shape[0]
    if size == 0:
        return np.zeros(0), np.zeros((0, 0))
    if size > DENSE_LIMIT and count <= size // 4:
        start = np.random.default_rng(0).standard_normal(size)  # so that a run can be repeated
        shift = -1e-9 * stiffest  # below zero, where a slack net is singular
        with contextlib.suppress(ArpackNoConvergence):  # where many motions share 0
            return eigsh(A, k=count, sigma=shift, which="LM", v0=start, maxiter=SPARSE_RESTARTS)
    return eigh(A.toarray(), subset_by_index=[0, count - 1])
