"""Air and light on cables and bodies, and the tides of an orbit, as flat arrays for compiled kernels: node i at 3i.

The formulas are those of `forces.air`, `forces.free_molecular`, `forces.solar`, `forces.drag` and `forces.orbit`. All
of these act from outside: what they give is force and torque on the net, and f·v their power.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from netdae._arrays import FloatArray, IntArray
from netdae.forces.air import AirOnCables, air_drag_of
from netdae.forces.drag import DragOnBodies, body_drag_of
from netdae.forces.free_molecular import MolecularDrag, molecular_drag_of
from netdae.forces.orbit import orbit_acceleration
from netdae.forces.solar import LightOnCables, light_push_of

_AIR, _THIN_AIR, _LIGHT = 0, 1, 2

Surface = AirOnCables | MolecularDrag | LightOnCables | DragOnBodies
"""Forces that are known here."""


class Skins(NamedTuple):
    """Cables that air or light meets, (m,) but for `ends`; a cable stands here once for each of its forces."""

    ends: IntArray  # (m, 2), 3i and 3j
    L: FloatArray  # m
    across: FloatArray  # ¼ ρ C_n D, ¼ ρ C_D D in kg/m², or ½ p C_R D in N/m
    along: FloatArray  # ¼ ρ π C_t D of dense air, kg/m²
    kind: IntArray  # dense air, thin air, light
    signal: IntArray  # which of the signals is its wind, stream, or direction


class Bodies(NamedTuple):
    """Nodes whose bodies air meets, (b,)."""

    entry: IntArray
    weight: FloatArray  # ½ ρ C_D A, kg/m
    signal: IntArray


class Tide(NamedTuple):
    """What feels a circular orbit, (o,)."""

    entry: IntArray
    mass: FloatArray  # kg
    mean_motion: FloatArray  # rad/s


def skins_of(forces: Sequence[Surface]) -> tuple[Skins, Bodies]:
    """The flat arrays of some forces, whose signals are numbered in their order."""
    ends, numbers, entries, weights = [np.zeros((0, 2), dtype=np.int64)], [np.zeros((5, 0))], [], []
    for signal, force in enumerate(forces):
        m = len(force.nodes)
        if isinstance(force, DragOnBodies):
            entries.append(np.stack((3 * force.nodes[:, 0], np.full(m, signal))))
            weights.append(force.weight)
            continue
        if isinstance(force, AirOnCables):
            kind, across, along = _AIR, force.across, force.along
        else:
            kind = _LIGHT if isinstance(force, LightOnCables) else _THIN_AIR
            across, along = force.weight, np.zeros(m)
        ends.append(3 * force.nodes)
        numbers.append(np.stack((force.L, across, along, np.full(m, kind), np.full(m, signal))))
    L, across, along, kinds, of_signal = np.concatenate(numbers, axis=1)
    entry, of_body = np.concatenate([np.zeros((2, 0), dtype=np.int64), *entries], axis=1)
    return (
        Skins(np.concatenate(ends), L, across, along, kinds.astype(np.int64), of_signal.astype(np.int64)),
        Bodies(entry, np.concatenate([np.zeros(0), *weights]), of_body),
    )


@njit(cache=True)
def add_skin_forces(x: FloatArray, v: FloatArray, values: FloatArray, skins: Skins, f: FloatArray) -> None:
    """Add forces on cables to f (3n,), where the signals have the values (s, 3) now."""
    for e in range(len(skins.L)):
        i, j, s, c, L = skins.ends[e, 0], skins.ends[e, 1], skins.signal[e], skins.across[e], skins.L[e]
        dx, dy, dz = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
        a0, a1, a2 = values[s, 0], values[s, 1], values[s, 2]
        for k in (i, j):
            if skins.kind[e] == _LIGHT:
                fx, fy, fz = light_push_of(c, dx, dy, dz, L, a0, a1, a2)
            else:
                wx, wy, wz = a0 - v[k], a1 - v[k + 1], a2 - v[k + 2]
                if skins.kind[e] == _AIR:
                    fx, fy, fz = air_drag_of(c, skins.along[e], dx, dy, dz, L, wx, wy, wz)
                else:
                    fx, fy, fz = molecular_drag_of(c, dx, dy, dz, L, wx, wy, wz)
            f[k] += fx
            f[k + 1] += fy
            f[k + 2] += fz


@njit(cache=True)
def add_body_drags(v: FloatArray, values: FloatArray, bodies: Bodies, f: FloatArray) -> None:
    """Add the drags of bodies to f (3n,), where the signals have the values (s, 3) now."""
    for b in range(len(bodies.entry)):
        k, wind = bodies.entry[b], values[bodies.signal[b]]
        fx, fy, fz = body_drag_of(bodies.weight[b], wind[0] - v[k], wind[1] - v[k + 1], wind[2] - v[k + 2])
        f[k] += fx
        f[k + 1] += fy
        f[k + 2] += fz


@njit(cache=True)
def add_tide(x: FloatArray, v: FloatArray, tide: Tide, f: FloatArray) -> None:
    """Add the forces of orbits to f (3n,)."""
    for o in range(len(tide.entry)):
        k, m = tide.entry[o], tide.mass[o]
        ax, ay, az = orbit_acceleration(tide.mean_motion[o], x[k], x[k + 2], v[k], v[k + 1])
        f[k] += m * ax
        f[k + 1] += m * ay
        f[k + 2] += m * az
