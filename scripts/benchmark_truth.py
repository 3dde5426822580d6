"""The ensemble of tight runs that all methods are judged by.

With the dashpot it is the frozen Verlet at a quarter and an eighth of its stable step. Rayleigh damping would
shrink that step far below what accuracy asks for (to 1e-8 s at β = 1e-3 s and 41 knots): there a leapfrog
takes the damping implicitly and the cables explicitly, at the same parts of the step that is stable undamped.
"""

from __future__ import annotations

import math

import numpy as np
from benchmark_flight import Clock, Flight
from benchmark_verlet import Flown, fly_verlet
from numba import njit

PARTS = (0.25, 0.125)  # of the stable step, in turn
MEMBERS = 8


@njit(cache=True)
def _elastic(x, cables, L, EA, f):  # type: ignore[no-untyped-def]
    f[:] = 0.0
    for e in range(len(L)):
        i, j = cables[e, 0], cables[e, 1]
        dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        strain = 0.5 * ((dx * dx + dy * dy + dz * dz) / (L[e] * L[e]) - 1.0)
        if strain > 0.0:
            q = EA[e] / L[e] * strain
            f[i, 0] += q * dx
            f[i, 1] += q * dy
            f[i, 2] += q * dz
            f[j, 0] -= q * dx
            f[j, 1] -= q * dy
            f[j, 2] -= q * dz


@njit(cache=True)
def _solve(order, pivots, factors, b, u):  # type: ignore[no-untyped-def]
    """U of (M + h/2 D) u = b, tridiagonal in `order`; b is used up."""
    size = len(order)
    for p in range(1, size):
        b[order[p]] -= factors[p] * b[order[p - 1]]
    u[order[size - 1]] = b[order[size - 1]] / pivots[size - 1]
    for p in range(size - 2, -1, -1):
        u[order[p]] = b[order[p]] / pivots[p] - factors[p + 1] * u[order[p + 1]]


@njit(cache=True)
def leapfrog(x, v, w, m, cables, L, EA, order, pivots, factors, h, steps, fresh):  # type: ignore[no-untyped-def]
    """Leapfrog whose Rayleigh damping is implicit; w are the velocities half a step later, v in step with x.

    (M + h/2 D) w₊ = (M − h/2 D) w₋ + h f(x), so w₊ = (M + h/2 D)⁻¹ (2 M w₋ + h f) − w₋ and v = (w₋ + w₊)/2.
    """
    n = len(m)
    f, u = np.zeros((n, 3)), np.zeros((n, 3))
    if fresh:
        _elastic(x, cables, L, EA, f)
        for i in range(n):
            for c in range(3):
                f[i, c] = m[i] * v[i, c] + 0.5 * h * f[i, c]
        _solve(order, pivots, factors, f.reshape(-1), w.reshape(-1))
    for _ in range(steps):
        x += h * w
        _elastic(x, cables, L, EA, f)
        for i in range(n):
            for c in range(3):
                f[i, c] = 2.0 * m[i] * w[i, c] + h * f[i, c]
        _solve(order, pivots, factors, f.reshape(-1), u.reshape(-1))
        for i in range(n):
            for c in range(3):
                v[i, c] = 0.5 * u[i, c]
                w[i, c] = u[i, c] - w[i, c]


def _tridiagonal(flight: Flight, h: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Order of the unknowns in which M + h/2 D is tridiagonal, and its LDLᵀ there.

    In a spread square net the damping of a line of cables couples the unknowns along that line alone.
    """
    net = flight.system.net
    x, y, _ = np.repeat(net.nodes, 3, axis=0).T.round(9)
    axis = np.tile([0, 1, 2], net.node_count)
    order = np.lexsort((np.where(axis == 0, x, y), np.where(axis == 0, y, x), axis))
    D = flight.system.damping_matrix()[order][:, order]
    entries = D.tocoo()
    if (abs(entries.row - entries.col)[entries.data != 0] > 1).any():
        raise ValueError("the net is no square of straight lines: its damping is not tridiagonal")
    pivots = 0.5 * h * D.diagonal() + np.repeat(flight.system.mass, 3)[order]
    beside = 0.5 * h * D.diagonal(1)
    factors = np.zeros_like(pivots)
    for p in range(1, len(order)):
        factors[p] = beside[p - 1] / pivots[p - 1]
        pivots[p] -= factors[p] * beside[p - 1]
    return order, pivots, factors


def fly_leapfrog(flight: Flight, part: float, clock: Clock) -> Flown:
    """The leapfrog with implicit Rayleigh damping at `part` of the step that is stable undamped."""
    net, cords = flight.system.net, flight.system.cords
    quarter = flight.end / len(flight.times)
    steps = math.ceil(quarter / (part * 2 / flight.frequency()))
    x, v, w = flight.x.copy(), flight.v.copy(), np.zeros_like(flight.v)
    arrays = (np.array(a) for a in (flight.system.mass, net.cables, net.rest_length, cords.axial_stiffness))
    fixed = (*arrays, *_tridiagonal(flight, quarter / steps), quarter / steps)
    positions, velocities = [], []
    clock.start()
    for q in range(len(flight.times)):
        leapfrog(x, v, w, *fixed, steps, q == 0)
        clock.check((q + 1) * quarter)
        positions.append(x.copy())
        velocities.append(v.copy())
    clock.stop()
    return positions, velocities, {"steps": steps * len(flight.times)}


def fly_tightly(flight: Flight, part: float, clock: Clock) -> Flown:
    """One member of the ensemble."""
    return (fly_leapfrog if flight.case.beta else fly_verlet)(flight, part, clock)


def part_of(member: int) -> float:
    """Part of the stable step that a member of the ensemble takes."""
    return PARTS[member % len(PARTS)]
