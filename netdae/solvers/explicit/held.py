"""Restrained axes in an explicit step: they are set, whatever acts on them, and what holds them is their reaction."""

from __future__ import annotations

from numba import njit

from netdae.core.arrays import BoolArray, FloatArray
from netdae.solvers.explicit.active import INLINED, PARTING
from netdae.solvers.explicit.parts import Held, Room
from netdae.solvers.explicit.wrench import add_force


@njit(**INLINED)
def drive(
    x: FloatArray,
    v: FloatArray,
    ahead: FloatArray,
    held: Held,
    motions: FloatArray,
    step: int,
    h: float,
    room: Room,
) -> float:
    """Set places of restrained axes and their mean velocities in this step; return how far two nodes part by that, m.

    ahead : (3n,), gets their velocities at the end of the step; or (0,)
    """
    farthest = 0.0
    for c in range(len(held.entry)):
        i, k = held.entry[c], held.motion[c]
        x[i] = held.anchor[c] + motions[step, 0, k]
        v[i] = 0.5 * (motions[step - 1, 1, k] + motions[step, 1, k])
        if len(ahead) > 0:
            ahead[i] = motions[step, 1, k]
        farthest = max(farthest, abs(x[i] - held.x[c] - h * room.drift[i]))
    return PARTING * farthest


@njit(**INLINED)
def add_reactions(x: FloatArray, in_space: BoolArray, held: Held, row: FloatArray) -> None:
    """Add the reactions, and their torques about the origin, to row (6,)."""
    for c in range(len(held.entry)):
        add_force(x, held.entry[c], held.R[c], in_space, row)
