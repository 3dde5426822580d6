"""Cords through rings, and the motors of winches, as flat arrays for compiled kernels: node i at 3i.

The formulas are those of `forces.drawcord` and `forces.motor`, whose kernels they call; symbols as there. Cords are few
and their rings are many: each is gathered into room of its own, and what it gives is scattered from there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.forces.drawcord import LEAST, SlidingCord, sliding_forces, sliding_tangents
from netdae.forces.motor import Motor, motor_of
from netdae.forces.rings import Cord


class Strings(NamedTuple):
    """Cords through rings, (c,) but for the first three."""

    begin: IntArray  # (c + 1,), where each begins in `entry`
    entry: IntArray  # (N,), 3i of the k rings of each in their order, and then of its reel's node
    first: IntArray  # (c + 1,), its first segment among those of all, (P,)
    L: FloatArray  # L̄₀, m
    share: FloatArray  # σ
    EA: FloatArray  # N
    eps: FloatArray
    engineering: BoolArray
    tau: FloatArray  # s
    size: FloatArray  # η, m
    friction: FloatArray  # μ
    creep_speed: FloatArray  # v₀, m/s
    theta: FloatArray  # θ


class StringRoom(NamedTuple):
    """Room for what is local to the cords, (N, 3) but for `tension`."""

    x: FloatArray
    v: FloatArray
    f: FloatArray  # N
    tension: FloatArray  # (P,), N_i of all segments


class StringTangents(NamedTuple):
    """Chains and dyads of the cords, see `forces.protocol.LinkedTangent`; zero rank where a cord is slack.

    The dyad r of a cord with k rings has its k + 1 rows in left, by_x and by_v from begin + r (k + 1) on.
    """

    rank: IntArray  # (c,), of each now
    begin: IntArray  # (c,), where the rows of each begin
    chain: FloatArray  # (P, 2, 3, 2, 3), N/m
    left: FloatArray  # (R, 3)
    by_x: FloatArray  # (R, 3)
    by_v: FloatArray  # (R, 3)


class Tally(NamedTuple):
    """What all cords together tell of one instant."""

    stored: float  # J
    dissipated: float  # W, of dashpots and friction
    tension: float  # N, the largest without their share
    strain: float  # the largest E11; −∞ without cords


class Motors(NamedTuple):
    """Motors of winches with their pawls, (w,)."""

    entry: IntArray  # of the drum in x
    strength: FloatArray  # N
    speed: FloatArray  # m/s
    width: FloatArray  # m/s
    creep_speed: FloatArray  # m/s


def strings_of(cords: Sequence[SlidingCord]) -> Strings:
    """The flat arrays of some cords."""
    numbers = [np.array([getattr(each.cord, name) for each in cords]) for name in Cord._fields]
    kinds = [np.bool_ if name == "engineering" else np.float64 for name in Cord._fields]
    return Strings(
        np.cumsum([0, *(each.nodes.shape[1] for each in cords)]),
        3 * np.concatenate([np.zeros(0, dtype=np.int64), *(each.nodes[0] for each in cords)]),
        np.cumsum([0, *(each.segment_count for each in cords)]),
        *(values.astype(kind) for values, kind in zip(numbers, kinds, strict=True)),
    )


def tangents_of(strings: Strings) -> StringTangents:
    """Room for the tangents of some cords."""
    nodes, pieces = np.diff(strings.begin), np.diff(strings.first)
    rows = ranks_of(strings) * nodes
    left, by_x, by_v = np.zeros((3, int(rows.sum()), 3))
    chain = np.zeros((int(pieces.sum()), 2, 3, 2, 3))
    return StringTangents(
        np.zeros(len(rows), dtype=np.int64), np.cumsum(rows) - rows, chain, left, by_x, by_v
    )


def ranks_of(strings: Strings) -> IntArray:
    """How many dyads each taut cord has, (c,)."""
    return np.where(strings.friction > 0, np.diff(strings.first) + 1, 2)


def motors_of(motors: Sequence[Motor]) -> Motors:
    """The flat arrays of some forces of motors."""
    nodes = np.concatenate([np.zeros(0, dtype=np.int64), *(each.nodes[:, 0] for each in motors)])
    names = Motors._fields[1:]
    numbers = [np.concatenate([np.zeros(0), *(getattr(each, name) for each in motors)]) for name in names]
    return Motors(3 * nodes, *numbers)


@njit(cache=True)
def string_room_of(strings: Strings) -> StringRoom:
    """Room for some cords."""
    size = len(strings.entry)
    tension = np.zeros(strings.first[-1])
    return StringRoom(np.zeros((size, 3)), np.zeros((size, 3)), np.zeros((size, 3)), tension)


@njit(cache=True)
def cord_of(strings: Strings, s: int) -> Cord:
    """Numbers of one cord."""
    return Cord(
        strings.L[s],
        strings.share[s],
        strings.EA[s],
        strings.eps[s],
        strings.engineering[s],
        strings.tau[s],
        strings.size[s],
        strings.friction[s],
        strings.creep_speed[s],
        strings.theta[s],
    )


@njit(cache=True)
def whole_length(x: FloatArray, strings: Strings, s: int) -> float:
    """L̄₀ + σ s of one cord, m; below `LEAST` of L̄₀ it is wound in whole, and forces take that share in its place."""
    return strings.L[s] + strings.share[s] * x[strings.entry[strings.begin[s + 1] - 1]]


@njit(cache=True)
def wound_in(x: FloatArray, strings: Strings) -> int:
    """A cord that is wound in whole, or −1."""
    for s in range(len(strings.L)):
        if not whole_length(x, strings, s) > LEAST * strings.L[s]:
            return s
    return -1


@njit(cache=True)
def gather_strings(x: FloatArray, v: FloatArray, strings: Strings, room: StringRoom) -> None:
    """Positions and velocities of all cords into their room."""
    for q in range(len(strings.entry)):
        for c in range(3):
            room.x[q, c], room.v[q, c] = x[strings.entry[q] + c], v[strings.entry[q] + c]


@njit(cache=True)
def string_pulls(x: FloatArray, v: FloatArray, strings: Strings, room: StringRoom) -> Tally:
    """Forces of all cords and the tensions of their segments into room."""
    gather_strings(x, v, strings, room)
    stored, dissipated, tension, strain = 0.0, 0.0, 0.0, -np.inf
    for s in range(len(strings.L)):
        at, end = strings.begin[s], strings.begin[s + 1]
        L = max(whole_length(x, strings, s), LEAST * strings.L[s])
        told = sliding_forces(
            room.x[at:end],
            room.v[at:end],
            L,
            cord_of(strings, s),
            room.f[at:end],
            room.tension[strings.first[s] : strings.first[s + 1]],
        )
        stored += told[0]
        dissipated += told[1]
        tension, strain = max(tension, told[2]), max(strain, told[3])
    return Tally(stored, dissipated, tension, strain)


@njit(cache=True)
def add_string_pulls(
    x: FloatArray, v: FloatArray, strings: Strings, f: FloatArray, room: StringRoom
) -> Tally:
    """Add the forces of all cords to f (3n,); they stay in room."""
    tally = string_pulls(x, v, strings, room)
    for q in range(len(strings.entry)):
        for c in range(3):
            f[strings.entry[q] + c] += room.f[q, c]
    return tally


@njit(cache=True)
def string_tangents(
    x: FloatArray, v: FloatArray, strings: Strings, room: StringRoom, tangents: StringTangents
) -> None:
    """∂f/∂x and ∂f/∂v of all cords, as chains and dyads, into tangents."""
    gather_strings(x, v, strings, room)
    for s in range(len(strings.L)):
        at, end, pieces = strings.begin[s], strings.begin[s + 1], strings.first[s + 1] - strings.first[s]
        rank, row = pieces + 1 if strings.friction[s] > 0.0 else 2, tangents.begin[s]
        rows, shape = rank * (end - at), (rank, end - at, 3)
        taut = sliding_tangents(
            room.x[at:end],
            room.v[at:end],
            max(whole_length(x, strings, s), LEAST * strings.L[s]),
            cord_of(strings, s),
            tangents.chain[strings.first[s] : strings.first[s + 1]],
            tangents.left[row : row + rows].reshape(shape),
            tangents.by_x[row : row + rows].reshape(shape),
            tangents.by_v[row : row + rows].reshape(shape),
        )
        tangents.rank[s] = rank if taut else 0


@njit(cache=True)
def add_motor_pulls(v: FloatArray, motors: Motors, f: FloatArray) -> tuple[float, float]:
    """Add the forces of all motors and pawls to f (3n,); the power that pawls take, and the motors' from outside."""
    dissipated = external = 0.0
    for w in range(len(motors.entry)):
        rate = v[motors.entry[w]]
        motor, pawl, _ = motor_of(
            rate, motors.strength[w], motors.speed[w], motors.width[w], motors.creep_speed[w]
        )
        f[motors.entry[w]] += motor + pawl
        dissipated -= pawl * rate
        external += motor * rate
    return dissipated, external


@njit(cache=True)
def motor_slope(v: FloatArray, motors: Motors, w: int) -> float:
    """∂f/∂ṡ of one motor with its pawl, N s/m."""
    return motor_of(
        v[motors.entry[w]], motors.strength[w], motors.speed[w], motors.width[w], motors.creep_speed[w]
    )[2]
