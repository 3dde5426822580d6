"""Motions of driven axes: how far from its starting place, how fast, with which acceleration.

A motion u(t) (3,) in m begins at u = 0. Its velocity may jump, at declared times only: the flight is cut
there and the impulse booked. Positions never jump.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicHermiteSpline, CubicSpline, PPoly

from netdae._arrays import FloatArray, frozen_floats
from netdae.errors import InputError
from netdae.signals import Interpolation, check_table


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


@dataclass(frozen=True, eq=False)
class FunctionMotion:
    """u(t), u̇(t), ü(t) as functions that return three numbers; all three must belong together."""

    displacement: Callable[[float], ArrayLike]
    velocity: Callable[[float], ArrayLike]
    acceleration: Callable[[float], ArrayLike]
    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()

    def at(self, t: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """u, u̇, ü, each (3,)."""
        u, du, ddu = (
            np.asarray(f(t), dtype=np.float64) for f in (self.displacement, self.velocity, self.acceleration)
        )
        return u, du, ddu

    def covers(self, begin: float, end: float) -> bool:
        """Always."""
        return True


@dataclass(frozen=True, eq=False)
class TableMotion:
    """u(t) from a table.

    times : (k,), s, rising
    displacements : (k, 3), m, from the starting place
    velocities : (k, 3), m/s, optional, with "cubic" only: the curve then has just these at the rows
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
        """Inner rows of a linear table where the slope changes."""
        if self.interpolation == "cubic":
            return ()
        slopes = np.diff(self.displacements, axis=0) / np.diff(self.times)[:, None]
        return tuple(self.times[1:-1][(np.diff(slopes, axis=0) != 0).any(axis=1)])

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
