"""Rayleigh damping in an explicit step, taken at the current velocity: it does not bound the step.

D of Eq. (9) is constant. With w and w′ half a step before and after an instant and f all other forces at it,

    (M + h/2 D) v = M w + h/2 f,     w′ = w + h M⁻¹ (f − D v),

so that v = (w + w′)/2 and (M + h/2 D) w′ = (M − h/2 D) w + h f: the leapfrog with the trapezoidal rule for D, of
second order and stable for h² K ≤ 4 M, whatever D. A flight begins with half a step from v,
(M + h/2 D) w′ = M v + h/2 f, which is implicit in D too. The damping force −D v is summed cable by cable, not taken
from the solution, so that it conserves momentum to round-off. In each step it dissipates exactly h v·D v.

M + h/2 D is factored once for each h. In a plane net z is undamped, and in a square one x and y are damped along
lines: in the axes of the net those unknowns are uncoupled, so the solution is computed in these axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy import sparse

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.compilation import FAST
from netdae.forces.elements import ElementForce
from netdae.solvers.linalg.scalar_ldl import Factor, ScalarLdl, solve

NOTHING = 1e-13  # of a cable's viscosity: what round-off leaves across its direction


class Drags(NamedTuple):
    """Forces with a constant ∂f/∂v: none where `ends` and `alpha` are empty."""

    ends: IntArray  # (p, 2), 3i and 3j
    viscosity: FloatArray  # (p, 6), upper triangle of ∂f/∂w of a pair by rows, N s/m
    alpha: FloatArray  # (3n,), of nodes alone, kg/s, or (0,)


def drags_of(forces: Sequence[ElementForce], size: int) -> Drags:
    """Drags of forces whose law is `steady`, on a net of `size` unknowns: pairs, and single nodes along each axis."""
    ends, upper, alpha = [np.zeros((0, 2), dtype=np.int64)], [np.zeros((0, 6))], np.zeros(0)
    for force in forces:
        still = np.zeros((*force.nodes.shape, 3))
        C = force.tangent(0.0, still, still).dv
        if force.law.pair:
            ends.append(3 * force.nodes)
            upper.append(C[:, 0, :, 1, :][:, *np.triu_indices(3)])
        else:
            alpha = np.zeros(size) if not len(alpha) else alpha
            for c in range(3):
                np.add.at(alpha, 3 * force.nodes[:, 0] + c, -C[:, 0, c, 0, c])
    return Drags(np.concatenate(ends), np.concatenate(upper), alpha)


@njit(cache=True, fastmath=FAST, forceinline=True)
def drag(v: FloatArray, drags: Drags, viscous: FloatArray) -> None:
    """Write their forces, −D v, to viscous (3n,)."""
    for i in range(len(viscous)):
        viscous[i] = 0.0
    for e in range(len(drags.ends)):
        i, j = drags.ends[e, 0], drags.ends[e, 1]
        wx, wy, wz = v[j] - v[i], v[j + 1] - v[i + 1], v[j + 2] - v[i + 2]
        V = drags.viscosity[e]
        fx = V[0] * wx + V[1] * wy + V[2] * wz
        fy = V[1] * wx + V[3] * wy + V[4] * wz
        fz = V[2] * wx + V[4] * wy + V[5] * wz
        viscous[i] += fx
        viscous[i + 1] += fy
        viscous[i + 2] += fz
        viscous[j] -= fx
        viscous[j + 1] -= fy
        viscous[j + 2] -= fz
    for i in range(len(drags.alpha)):
        viscous[i] -= drags.alpha[i] * v[i]


class Solver(NamedTuple):
    """M + h/2 D, factored."""

    damps: bool  # whether D is not zero
    alone: FloatArray  # (3n,), 1/(M + h/2 D) of uncoupled unknowns, zero on restrained axes
    entry: IntArray  # (u,), coupled unknowns, in the order of the factor
    factor: Factor
    axes: FloatArray  # (3, 3), rows
    turned: bool  # whether these differ from x, y and z
    straight: IntArray  # (s, 2), entries joined by cables along x, y or z, if these are the axes
    viscosity: FloatArray  # (s,), theirs, N s/m
    rest: Drags  # all else that damps


@njit(cache=True, fastmath=FAST, forceinline=True)
def _turn(u: FloatArray, Q: FloatArray) -> None:
    """Turn the vectors u (3n,) into the axes Q."""
    for i in range(0, len(u), 3):
        x, y, z = u[i], u[i + 1], u[i + 2]
        for c in range(3):
            u[i + c] = Q[c, 0] * x + Q[c, 1] * y + Q[c, 2] * z


@njit(cache=True, fastmath=FAST, forceinline=True)
def drag_all(v: FloatArray, solver: Solver, viscous: FloatArray) -> None:
    """Write the forces of Rayleigh damping, −D v, to viscous (3n,)."""
    drag(v, solver.rest, viscous)
    for k in range(len(solver.viscosity)):
        i, j = solver.straight[k, 0], solver.straight[k, 1]
        pull = solver.viscosity[k] * (v[j] - v[i])
        viscous[i] += pull
        viscous[j] -= pull


@njit(cache=True, fastmath=FAST, forceinline=True)
def damp(
    w: FloatArray,
    mass: FloatArray,
    f: FloatArray,
    h: float,
    solver: Solver,
    entry: IntArray,
    speed: FloatArray,
    v: FloatArray,
    viscous: FloatArray,
) -> None:
    """Write the velocities of this instant to v (3n,), and −D v to viscous (3n,), from w and the other forces f.

    entry, speed : (c,), restrained axes and their velocities now
    """
    alone, coupled, y = solver.alone, solver.entry, solver.factor.y
    moving = False
    for c in range(len(entry)):
        moving = moving or speed[c] != 0.0
    if moving:  # their effect on neighbours is known
        v[:] = 0.0
        for c in range(len(entry)):
            v[entry[c]] = speed[c]
        drag_all(v, solver, viscous)
        for i in range(len(v)):
            v[i] = mass[i] * w[i] + 0.5 * h * (f[i] + viscous[i])
    else:
        for i in range(len(v)):
            v[i] = mass[i] * w[i] + 0.5 * h * f[i]
    if solver.turned:
        _turn(v, solver.axes)
    for k in range(len(coupled)):
        y[k] = v[coupled[k]]
    solve(solver.factor)
    for i in range(len(v)):
        v[i] *= alone[i]
    for k in range(len(coupled)):
        v[coupled[k]] = y[k]
    if solver.turned:
        _turn(v, solver.axes.T)
    for c in range(len(entry)):
        v[entry[c]] = speed[c]
    drag_all(v, solver, viscous)


class ImplicitDamping:
    """Rayleigh damping of nodes with the masses (3n,), of which the entries `held` are restrained."""

    def __init__(self, drags: Drags, mass: FloatArray, held: IntArray) -> None:
        free = np.ones(len(mass), dtype=np.bool_)
        free[held] = False
        axes = np.eye(3) if _partly(held) else _axes_of(drags)
        rows, columns, beside, self._D = _entries(drags, axes, len(mass))
        if len(drags.alpha):
            self._D += drags.alpha
        meets = free[rows] & free[columns]
        rows, columns, self._beside = rows[meets], columns[meets], beside[meets]
        self._coupled, places = np.unique(np.concatenate((rows, columns)), return_inverse=True)
        self._ldl = ScalarLdl(len(self._coupled), *places.reshape(2, -1))
        self._mass, self._free = mass, free
        self._entry = self._coupled[self._ldl.order]
        self._axes, self._turned = axes, not np.array_equal(axes, np.eye(3))
        self._products = _straight_of(drags, self._turned)
        self._damps = len(drags.ends) > 0 or len(drags.alpha) > 0
        self._h = -1.0
        self._solver = self.at(0.0)

    def at(self, h: float) -> Solver:
        """M + h/2 D, factored; valid until the next call with another h."""
        if h != self._h:
            self._h = h
            whole = self._mass + 0.5 * h * self._D
            alone = np.divide(1.0, whole, out=np.zeros_like(whole), where=self._free & (whole > 0))
            factor = self._ldl.factorize(whole[self._coupled], 0.5 * h * self._beside)
            self._solver = Solver(
                self._damps, alone, self._entry, factor, self._axes, self._turned, *self._products
            )
        return self._solver


def _partly(held: IntArray) -> bool:
    """Whether a node is restrained along some axes and free along others; the axes must then be x, y and z."""
    return bool((np.unique(held // 3, return_counts=True)[1] != 3).any())


def _matrices(viscosity: FloatArray) -> FloatArray:
    """Symmetric (p, 3, 3) from their upper triangles (p, 6)."""
    return viscosity[:, [[0, 1, 2], [1, 3, 4], [2, 4, 5]]]


def _axes_of(drags: Drags) -> FloatArray:
    """Axes (3, 3) by rows: x, y and z, or those of the most frequent cables if that couples fewer unknowns."""
    V = _matrices(drags.viscosity)
    if not len(V):
        return np.eye(3)
    n = V[np.arange(len(V)), np.einsum("err->er", V).argmax(axis=1)]  # V is a multiple of n nᵀ
    n = n / np.linalg.norm(n, axis=1)[:, None]
    n *= np.sign(np.take_along_axis(n, np.abs(n.round(9)).argmax(axis=1)[:, None], axis=1))
    _, first, counts = np.unique(n.round(9), axis=0, return_index=True, return_counts=True)
    one = n[first[counts.argmax()]]
    across = np.linalg.norm(np.cross(one, n[first]), axis=1)  # the sine of the angle to it
    square = np.where(across > 1 - 1e-9, counts, 0)
    best = square.argmax() if square.any() else np.where(across > 1e-9, counts, 0).argmax()
    normal = np.cross(one, n[first[best]])
    if not np.linalg.norm(normal) > 1e-9:  # all cables are parallel
        normal = np.cross(one, np.eye(3)[np.abs(one).argmin()])
    normal = normal / np.linalg.norm(normal)
    Q = np.stack((one, np.cross(normal, one), normal))
    return Q if _meetings(Q @ V @ Q.T) < _meetings(V) else np.eye(3)


def _meetings(V: FloatArray) -> int:
    """Number of nonzero entries of all V (p, 3, 3)."""
    return int(np.count_nonzero(np.abs(V) > NOTHING * np.trace(V, axis1=1, axis2=2)[:, None, None]))


def _straight_of(drags: Drags, turned: bool) -> tuple[IntArray, FloatArray, Drags]:
    """Entries joined by cables along one of the axes and their viscosities, and the rest."""
    on_diagonal = drags.viscosity[:, [0, 3, 5]]
    axis = on_diagonal.argmax(axis=1)
    along = np.take_along_axis(on_diagonal, axis[:, None], axis=1)[:, 0]
    straight = (np.abs(drags.viscosity).sum(axis=1) == along) & (not turned)
    ends = drags.ends[straight] + axis[straight, None]
    return ends, along[straight], Drags(drags.ends[~straight], drags.viscosity[~straight], drags.alpha)


def _entries(drags: Drags, axes: FloatArray, size: int) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """β K₀ in those axes: rows, columns and values above the diagonal, and the diagonal (3n,)."""
    V = axes @ _matrices(drags.viscosity) @ axes.T
    i, j = (drags.ends[:, k, None, None] for k in (0, 1))
    r, c = np.indices((3, 3))
    places = [(i + r, i + c, V), (j + r, j + c, V), (i + r, j + c, -V), (j + r, i + c, -V)]
    row, column, value = (
        np.concatenate([np.broadcast_to(part, V.shape).ravel() for part in parts])
        for parts in zip(*places, strict=True)
    )
    K = sparse.coo_array((value, (row, column)), shape=(size, size)).tocsr()
    diagonal = K.diagonal()
    scale = np.repeat(diagonal.reshape(-1, 3).sum(axis=1), 3)
    upper = sparse.triu(K, 1).tocoo()
    there = np.abs(upper.data) > NOTHING * np.maximum(scale[upper.row], scale[upper.col])
    return *(a[there].astype(np.int64) for a in (upper.row, upper.col)), upper.data[there], diagonal
