"""The hand-written Verlet that all methods are measured by.

`verlet_dashpot` and `verlet_rayleigh` are frozen: they are the forty lines that anyone would write, a flat
loop over cables, and no later cleverness of netdae's own explicit method belongs here.
"""

from __future__ import annotations

import math

import numpy as np
from benchmark_flight import Clock, Flight
from numba import njit

Flown = tuple[list[np.ndarray], list[np.ndarray], dict[str, float]]
"""Positions and velocities at the times of a flight, and what was counted."""

CHUNK = 2_000_000  # cable-steps between two looks at the clock, 10 ms


@njit(fastmath=True, cache=True)
def verlet_dashpot(x, v, m, cables, L, EA, tau, dt, steps):  # type: ignore[no-untyped-def]
    """Velocity Verlet of the dashpot's law, in place."""
    n = len(m)
    f = np.zeros((n, 3))
    for step in range(steps + 1):
        if step > 0:
            for i in range(n):
                h = 0.5 * dt / m[i]
                for c in range(3):
                    v[i, c] += h * f[i, c]
                    x[i, c] += dt * v[i, c]
                    f[i, c] = 0.0
        for e in range(len(L)):
            i, j = cables[e, 0], cables[e, 1]
            dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
            strain = 0.5 * ((dx * dx + dy * dy + dz * dz) / (L[e] * L[e]) - 1.0)
            if strain > 0.0:
                wx, wy, wz = v[j, 0] - v[i, 0], v[j, 1] - v[i, 1], v[j, 2] - v[i, 2]
                q = EA[e] / L[e] * (strain + tau * (dx * wx + dy * wy + dz * wz) / (L[e] * L[e]))
                if q > 0.0:
                    f[i, 0] += q * dx
                    f[i, 1] += q * dy
                    f[i, 2] += q * dz
                    f[j, 0] -= q * dx
                    f[j, 1] -= q * dy
                    f[j, 2] -= q * dz
        if step > 0:
            for i in range(n):
                h = 0.5 * dt / m[i]
                for c in range(3):
                    v[i, c] += h * f[i, c]


@njit(fastmath=True, cache=True)
def verlet_rayleigh(x, v, m, cables, L, EA, beta, normals, dt, steps):  # type: ignore[no-untyped-def]
    """Velocity Verlet with Rayleigh damping β K₀ along the cables' directions `normals` in x̄, in place."""
    n = len(m)
    f = np.zeros((n, 3))
    for step in range(steps + 1):
        if step > 0:
            for i in range(n):
                h = 0.5 * dt / m[i]
                for c in range(3):
                    v[i, c] += h * f[i, c]
                    x[i, c] += dt * v[i, c]
                    f[i, c] = 0.0
        for e in range(len(L)):
            i, j = cables[e, 0], cables[e, 1]
            nx, ny, nz = normals[e, 0], normals[e, 1], normals[e, 2]
            wx, wy, wz = v[j, 0] - v[i, 0], v[j, 1] - v[i, 1], v[j, 2] - v[i, 2]
            k = EA[e] / L[e]
            damping = beta * k * (wx * nx + wy * ny + wz * nz)
            fx, fy, fz = damping * nx, damping * ny, damping * nz
            dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
            strain = 0.5 * ((dx * dx + dy * dy + dz * dz) / (L[e] * L[e]) - 1.0)
            if strain > 0.0:
                fx += k * strain * dx
                fy += k * strain * dy
                fz += k * strain * dz
            f[i, 0] += fx
            f[i, 1] += fy
            f[i, 2] += fz
            f[j, 0] -= fx
            f[j, 1] -= fy
            f[j, 2] -= fz
        if step > 0:
            for i in range(n):
                h = 0.5 * dt / m[i]
                for c in range(3):
                    v[i, c] += h * f[i, c]


def fly_verlet(flight: Flight, part: float, clock: Clock) -> Flown:
    """The frozen Verlet at `part` of its stable step."""
    net, cords = flight.system.net, flight.system.cords
    quarter = flight.end / len(flight.times)
    steps = math.ceil(quarter / (part * flight.stable_step()))
    dt = quarter / steps
    x, v = flight.x.copy(), flight.v.copy()
    cables, L, EA = np.array(net.cables), np.array(net.rest_length), np.array(cords.axial_stiffness)
    mass = np.array(flight.system.mass)
    span = net.nodes[cables[:, 1]] - net.nodes[cables[:, 0]]
    normals = span / np.linalg.norm(span, axis=1)[:, None]
    chunk = max(1, CHUNK // len(L))
    positions, velocities = [], []
    clock.start()
    for q in range(len(flight.times)):
        done = 0
        while done < steps:
            count = min(chunk, steps - done)
            if flight.case.beta:
                verlet_rayleigh(x, v, mass, cables, L, EA, flight.case.beta, normals, dt, count)
            else:
                verlet_dashpot(x, v, mass, cables, L, EA, flight.case.tau, dt, count)
            done += count
            clock.check(q * quarter + done * dt)
        positions.append(x.copy())
        velocities.append(v.copy())
    clock.stop()
    total = steps * len(flight.times)
    rate = total * len(L) / max(clock.seconds, 1e-9)
    return positions, velocities, {"steps": total, "cable_steps_per_second": rate}
