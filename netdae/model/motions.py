"""Motions of driven axes: displacement from the start, velocity and acceleration.

A motion u(t) (3,) in m begins at u = 0. Its velocity may jump, at declared times only: the flight is split there
and the impulse accounted for. Positions never jump.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicHermiteSpline, CubicSpline, PPoly

from netdae.core.arrays import FloatArray, IntArray, frozen_floats
from netdae.core.errors import InputError
from netdae.model.signals import Interpolation, check_table


class Motion(Protocol):
    """u(t) with its first two derivatives; `jumps` are the times where u̇ jumps, `kinks` where only ü does."""

    @property
    def jumps(self) -> tuple[float, ...]: ...  # noqa: D102
    @property
    def kinks(self) -> tuple[float, ...]: ...  # noqa: D102

    def at(self, t: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """u in m, u̇ in m/s, ü in m/s², each (3,)."""
        ...

    def covers(self, begin: float, end: float) -> bool:
        """Whether the motion is defined from `begin` to `end`."""
        ...


@dataclass(frozen=True)
class Fixed:
    """No motion."""

    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()

    def at(self, t: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Zeros."""
        zero = np.zeros(3)
        return zero, zero, zero

    def covers(self, begin: float, end: float) -> bool:
        """Always."""
        return True


@dataclass(frozen=True)
class Steady:
    """A constant velocity in m/s, (3,), starting at `since` in s: u = V (t − since)."""

    velocity: tuple[float, float, float]
    since: float = 0.0
    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()

    def at(self, t: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """u, u̇, ü, each (3,)."""
        velocity = np.array(self.velocity)
        return velocity * (t - self.since), velocity, np.zeros(3)

    def covers(self, begin: float, end: float) -> bool:
        """Always."""
        return True


@dataclass(frozen=True, eq=False)
class FunctionMotion:
    """u(t), u̇(t), ü(t) as functions that return three numbers; all three must be consistent.

    A flight checks this at a few times, see `check_derivatives`.
    """

    displacement: Callable[[float], ArrayLike]
    velocity: Callable[[float], ArrayLike]
    acceleration: Callable[[float], ArrayLike]
    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()

    def at(self, t: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """u, u̇, ü, each (3,); raises InputError if a function returns anything but three numbers."""
        return (
            _three("displacement", self.displacement(t), t),
            _three("velocity", self.velocity(t), t),
            _three("acceleration", self.acceleration(t), t),
        )

    def covers(self, begin: float, end: float) -> bool:
        """Always."""
        return True


@dataclass(frozen=True, eq=False)
class TableMotion:
    """u(t) from a table.

    times : (k,), s, rising
    displacements : (k, 3), m, from the start
    velocities : (k, 3), m/s, optional, with "cubic" only: the curve then has exactly these at the rows
    interpolation : "cubic", a C² spline that starts and ends at rest (C¹ Hermite with `velocities`);
        "linear", whose velocity jumps at every row where the slope changes
    """

    times: FloatArray
    displacements: FloatArray
    velocities: FloatArray | None = None
    interpolation: Interpolation = "cubic"
    _curves: tuple[PPoly, PPoly, PPoly] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        times, u = frozen_floats(self.times), frozen_floats(self.displacements)
        check_table(times, u, self.interpolation)
        if (np.diff(times) == 0).any():
            raise InputError("motion: a time stands twice, but a position cannot jump: give each time once")
        if self.interpolation == "linear":
            if self.velocities is not None:
                raise InputError(
                    "motion: a linear table has its velocities already: leave them out or choose cubic"
                )
            slopes = np.diff(u, axis=0) / np.diff(times)[:, None]
            curve = PPoly(np.stack((slopes, u[:-1])), times)
        elif self.velocities is None:
            curve = CubicSpline(times, u, bc_type="clamped")
        else:
            velocities = frozen_floats(self.velocities)
            check_table(times, velocities, self.interpolation)
            curve = CubicHermiteSpline(times, u, velocities)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "displacements", u)
        object.__setattr__(self, "_curves", (curve, curve.derivative(), curve.derivative(2)))

    @property
    def jumps(self) -> tuple[float, ...]:
        """Inner rows of a linear table where the slope changes by more than round-off."""
        if self.interpolation == "cubic":
            return ()
        steps = np.diff(self.times)
        slopes = np.diff(self.displacements, axis=0) / steps[:, None]
        # two slopes, each of two displacements and two times rounded by half an ulp; four times this
        of_u = np.spacing(np.abs(self.displacements).max(axis=0))
        of_t = np.spacing(np.abs(self.times).max()) * np.abs(slopes).max(axis=0)
        round_off = 8 * (of_u + of_t) / steps.min()
        return tuple(self.times[1:-1][(np.abs(np.diff(slopes, axis=0)) > round_off).any(axis=1)])

    @property
    def kinks(self) -> tuple[float, ...]:
        """Inner rows of a table with velocities: its acceleration jumps there."""
        return () if self.velocities is None else tuple(self.times[1:-1])

    def at(self, t: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """u, u̇, ü, each (3,)."""
        u, du, ddu = (curve(t) for curve in self._curves)
        return u, du, ddu

    def covers(self, begin: float, end: float) -> bool:
        """Whether the rows reach from `begin` to `end`."""
        return bool(self.times[0] <= begin and end <= self.times[-1])


def _three(name: str, value: ArrayLike, t: float) -> FloatArray:
    vector = np.asarray(value, dtype=np.float64)
    if vector.shape != (3,):
        raise InputError(
            f"motion: the {name} at t = {t:g} s is {vector.tolist()!r}: let its function give three numbers"
        )
    return vector


CHECKED_SHARES = tuple(k * 0.5 * (5**0.5 - 1) % 1 for k in range(9))
"""Where a motion is checked, as shares of the flight; not multiples of any time, so that an oscillation is sampled in
many phases."""

WRONG = 1e-3
"""Least error of a derivative that is reported, as a share of the largest: the loosest accuracy of a flight."""


def check_derivatives(motion: Motion, axes: IntArray, begin: float, end: float) -> None:
    """Raise InputError where u̇ and ü are not the derivatives of u and u̇ along `axes` (k,), by central differences.

    They are evaluated between `begin` and `end` only, and never across a declared jump or kink.
    """
    cuts = sorted({begin, end, *(t for t in (*motion.jumps, *motion.kinks) if begin < t < end)})
    times = [begin + share * (end - begin) for share in CHECKED_SHARES]
    largest = np.abs([[f[axes] for f in motion.at(t)] for t in times]).max(axis=(0, 2))
    # so that an oscillation at any rate is differentiated over a thousandth of a radian
    rates = [b / a for a, b in pairwise(largest) if a > 0]
    finest = 1e-3 / max([1.0 / (end - begin), *rates])
    for sample in times:
        piece = max(bisect_right(cuts[:-1], sample) - 1, 0)
        low, high = cuts[piece], cuts[piece + 1]
        h = min(finest, 0.25 * (high - low))
        t = min(max(sample, low + 2 * h), high - 2 * h)
        if not low < t - h < t - 0.5 * h < t < t + 0.5 * h < t + h < high:
            continue  # differences would be lost in round-off
        for k, (name, of) in enumerate((("velocity", "displacement"), ("acceleration", "velocity"))):
            coarse, fine = (_difference(motion, k, t, d)[axes] for d in (h, 0.5 * h))
            given = motion.at(t)[k + 1][axes]
            # errors of the differences themselves: their change with the width, and the round-off of u and t
            round_off = 8 * (np.spacing(largest[k]) + math.ulp(t) * largest[k + 1]) / h
            allowed = WRONG * largest[k + 1] + 10 * np.abs(coarse - fine) + round_off
            if (np.abs(given - fine) > allowed).any():
                raise InputError(
                    f"its {name} is {given.tolist()} at t = {t:g} s, but its {of} changes at the rate {fine.tolist()}: "
                    f"let its {name} be the derivative of its {of}, or declare its jumps and kinks"
                )


def _difference(motion: Motion, k: int, t: float, h: float) -> FloatArray:
    before, after = t - h, t + h
    return (motion.at(after)[k] - motion.at(before)[k]) / (after - before)


def is_steady(motion: Motion) -> bool:
    """Whether a motion has a constant velocity."""
    return isinstance(motion, Fixed | Steady)
