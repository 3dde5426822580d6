"""What changes during a flight: one State, and the Trajectory of many.

Symbols: t time in s, x positions (n, 3) in m, v velocities (n, 3) in m/s, a accelerations (n, 3) in m/s².
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import ArrayLike

from netdae.core.archives import check_archive
from netdae.core.arrays import FloatArray, frozen_floats
from netdae.core.errors import InputError


@dataclass(frozen=True)
class EnergyBalance:
    """Running totals of a flight since its start, updated at every internal step of the integrator.

    dissipated_energy : J, taken by damping
    external_work : J, done by loads and by driven nodes
    external_impulse : N s, (3,), given by loads, restraints and the mass-proportional damping
    external_angular_impulse : N m s, (3,), of the same, about the origin
    peak_tension : N, the largest tension of any cable since the previous frame
    """

    dissipated_energy: float = 0.0
    external_work: float = 0.0
    external_impulse: tuple[float, float, float] = (0.0, 0.0, 0.0)
    peak_tension: float = 0.0
    external_angular_impulse: tuple[float, float, float] = (0.0, 0.0, 0.0)


def _none() -> FloatArray:
    return frozen_floats([])


@dataclass(frozen=True, eq=False)
class State:
    """Positions, velocities and accelerations of all nodes at one time, with the balance up to it.

    attitude : quaternion (w, x, y, z) of the target's principal axes, (4,); (0,) without a target
    """

    t: float
    x: FloatArray
    v: FloatArray
    a: FloatArray
    balance: EnergyBalance = field(default_factory=EnergyBalance)
    attitude: FloatArray = field(default_factory=_none)

    @classmethod
    def at(cls, x: ArrayLike, v: ArrayLike | None = None, *, t: float = 0.0) -> State:
        """An initial state: positions x (n, 3), velocities v (n, 3) or at rest; the flight finds the accelerations."""
        positions = np.array(x, dtype=np.float64)
        zero = np.zeros_like(positions)
        return cls(t, positions, zero if v is None else np.array(v, dtype=np.float64), zero)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """All frames of a flight as arrays.

    times : (k,), s
    positions, velocities, accelerations : (k, n, 3)
    dissipated_energy, external_work, peak_tension : (k,); external_impulse, external_angular_impulse : (k, 3);
        see `EnergyBalance`
    attitudes : (k, 4), quaternions of the target's principal axes, see `State`; (k, 0) without a target
    statistics : counters of the integrator (steps, residuals, setups, Newton failures, ...)
    """

    times: FloatArray
    positions: FloatArray
    velocities: FloatArray
    accelerations: FloatArray
    dissipated_energy: FloatArray
    external_work: FloatArray
    external_impulse: FloatArray
    peak_tension: FloatArray
    external_angular_impulse: FloatArray
    attitudes: FloatArray
    statistics: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, states: list[State], statistics: Mapping[str, Any] | None = None) -> Trajectory:
        """Trajectory of a list of at least one State."""
        return cls(
            np.array([s.t for s in states]),
            np.array([s.x for s in states]),
            np.array([s.v for s in states]),
            np.array([s.a for s in states]),
            np.array([s.balance.dissipated_energy for s in states]),
            np.array([s.balance.external_work for s in states]),
            np.array([s.balance.external_impulse for s in states]),
            np.array([s.balance.peak_tension for s in states]),
            np.array([s.balance.external_angular_impulse for s in states]),
            np.array([s.attitude for s in states]),
            dict(statistics or {}),
        )

    def __len__(self) -> int:
        return len(self.times)

    def __getitem__(self, index: int) -> State:
        """The frame with that index as a State."""
        balance = EnergyBalance(
            float(self.dissipated_energy[index]),
            float(self.external_work[index]),
            tuple(self.external_impulse[index]),
            float(self.peak_tension[index]),
            tuple(self.external_angular_impulse[index]),
        )
        return State(
            float(self.times[index]),
            self.positions[index],
            self.velocities[index],
            self.accelerations[index],
            balance,
            self.attitudes[index],
        )

    def __iter__(self) -> Iterator[State]:
        return (self[index] for index in range(len(self)))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the arrays as a compressed .npz file, complete or not at all."""
        target = Path(path)
        partial = target.with_name(target.name + ".part")
        with partial.open("wb") as stream:
            np.savez_compressed(stream, **{name: getattr(self, name) for name in _ARRAYS})
        partial.replace(target)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Trajectory:
        """Trajectory from a .npz file or from the output folder that holds `trajectory.npz`."""
        source = Path(path)
        if source.is_dir():
            source = source / "trajectory.npz"
        if not source.is_file():
            raise InputError(
                f"{source} is not there: give the output folder of a finished run, or its trajectory.npz"
            )
        try:
            check_archive(source)
            with np.load(source) as arrays:
                found = {name: arrays[name] for name in _ARRAYS if name in arrays.files}
                # files of an earlier netdae have no target
                return cls(**{"attitudes": np.zeros((len(found["times"]), 0)), **found})
        except (OSError, ValueError, KeyError, EOFError, TypeError, BadZipFile, zlib.error) as error:
            raise InputError(
                f"{source} is not a trajectory of netdae, or damaged: {error}: run the scenario again"
            ) from error


_ARRAYS = (
    "times",
    "positions",
    "velocities",
    "accelerations",
    "dissipated_energy",
    "external_work",
    "external_impulse",
    "peak_tension",
    "external_angular_impulse",
    "attitudes",
)
