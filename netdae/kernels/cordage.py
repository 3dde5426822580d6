"""Cords through rings for the kernel of `explicit.verlet`; symbols as in `forces.drawcord`.

Friction at rings is taken at the velocity half a step back, as dashpots are. Its damping Σ_j G_j C_j C_jᵀ, with
G_j = N_j μ φ_j γ/c_j and C_j = ∂c_j/∂ẋ, comes and goes with the tension N: no bound that held always would leave a step
worth its name. (G_j is the secant, not the slope, in which a ring that is thrown to and fro by too long a step would
look soft.) Hence a rate that none of its eigenvalues over M passes is watched: a step in which it passes the limit
for which h is stable ends the run of steps, as one with too large a strain does. C_j has a part on ring j itself, and
those of different rings do not meet; and one on the others and the drum r. With a_j the share of the cord before ring j
and the sums over the rings before it and after it, the rate is (√A + √B)² from A = max G_j/m_j and the trace

    B = Σ_j G_j ((1 − a_j)² Σ_{i<j} |b_i|²/m_i + a_j² Σ_{i>j} |b_i|²/m_i + (λ σ (θ − a_j))²/m_r)

with |b_i|² = 2 − 2 cos φ_i at most, and 2 at both ends of the cord: where it is closed, both are ring 0, on which C_j
is (1 − a_j) u_0 + a_j u_{p−1}, the square of which is 2 (1 − a_j)² + 2 a_j² at most.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from netdae._arrays import FloatArray
from netdae.forces.capstan import sliding_speeds, turn_at
from netdae.forces.rings import way_through
from netdae.kernels.strings import StringRoom, Strings, add_string_pulls, cord_of, string_pulls, whole_length


class Cordage(NamedTuple):
    """Cords, and the same without their dashpots."""

    strings: Strings
    elastic: Strings
    least: FloatArray  # (c,), m, rest lengths below which the step may be too long


@njit(cache=True)
def add_cord_pulls(
    x: FloatArray, v: FloatArray, cordage: Cordage, f: FloatArray, room: StringRoom
) -> tuple[float, float, bool]:
    """Add the cords' pulls to f, also told in room; largest tension, strain, and if one is too short."""
    told = add_string_pulls(x, v, cordage.strings, f, room)
    short = False
    for s in range(len(cordage.least)):
        short = short or not whole_length(x, cordage.strings, s) >= cordage.least[s]
    return told.tension, told.strain, short


@njit(cache=True)
def cord_power(
    x: FloatArray,
    v: FloatArray,
    share: FloatArray,
    f: FloatArray,
    h: float,
    cordage: Cordage,
    room: StringRoom,
    elastic: StringRoom,
) -> float:
    """Power in W that the dashpots of cords, whose pulls are in room, take in a step; elastic is room too."""
    lost = 0.0
    if not (np.any(cordage.strings.tau > 0.0) or np.any(cordage.strings.friction > 0.0)):
        return lost
    string_pulls(x, v, cordage.elastic, elastic)
    for q in range(len(room.f)):
        for c in range(3):
            i = cordage.strings.entry[q] + c
            lost -= (room.f[q, c] - elastic.f[q, c]) * (v[i] + 0.5 * h * share[i] * f[i])
    return lost


@njit(cache=True)
def friction_rate(cordage: Cordage, share: FloatArray, room: StringRoom) -> float:
    """The rate of the friction at all rings, 1/s, of cords whose pulls are in room."""
    strings, rate = cordage.strings, 0.0
    for s in range(len(strings.L)):
        tension = room.tension[strings.first[s] : strings.first[s + 1]]
        if strings.friction[s] == 0.0 or tension[0] == 0.0:
            continue
        at, end, p = strings.begin[s], strings.begin[s + 1], len(tension)
        cord, drum, k = cord_of(strings, s), strings.entry[end - 1], end - 1 - at
        way = way_through(room.x[at:end], room.v[at:end], p, cord.size)
        L = cord.L + cord.share * room.x[end - 1, 0]
        c = sliding_speeds(way, L, room.v[end - 1, 0], cord)
        turns, whole = np.zeros(p + 1), 0.0  # |b|²/m
        for j in range(p + 1):
            turned = 1.0 - way.u[j - 1] @ way.u[j] if 0 < j < p else 1.0
            turns[j] = 2.0 * turned * share[strings.entry[at + j % k]]
            whole += turns[j]
        before, length, own, others = 0.0, 0.0, 0.0, 0.0
        for j in range(1, p):
            before += turns[j - 1]
            length += way.h[j - 1]
            a, slip = length / way.length, c[j] / cord.creep_speed
            slope = max(tension[j - 1], tension[j]) * cord.friction * turn_at(way, j, cord.size)[1]
            slope /= cord.creep_speed * np.sqrt(1.0 + slip * slip)
            at_drum = way.length / L * cord.share * (cord.theta - a)
            response = (1.0 - a) ** 2 * before + a * a * (whole - before - turns[j])
            others += slope * (response + at_drum * at_drum * share[drum])
            own = max(own, slope * share[strings.entry[at + j]])
        rate += (np.sqrt(own) + np.sqrt(others)) ** 2
    return rate
