"""Vectors that depend on time: a constant, a table, a function; with their jumps and kinks declared.

A signal is never evaluated at one of its jumps: the flight is split there, and within a phase the time is kept
strictly inside, so that both one-sided values are used.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from netdae.core.arrays import FloatArray, frozen_floats
from netdae.core.errors import InputError

Interpolation = Literal["linear", "cubic"]
INTERPOLATIONS: tuple[Interpolation, ...] = ("linear", "cubic")


class Signal(Protocol):
    """Vector (3,) over time; `jumps` and `kinks` are the times where it, or only its rate, jumps."""

    @property
    def jumps(self) -> tuple[float, ...]: ...  # noqa: D102
    @property
    def kinks(self) -> tuple[float, ...]: ...  # noqa: D102

    def __call__(self, t: float) -> FloatArray:
        """Value (3,) at time t."""
        ...

    def covers(self, begin: float, end: float) -> bool:
        """Whether the signal is defined from `begin` to `end`."""
        ...


def signal_of(value: Signal | ArrayLike | Callable[[float], ArrayLike]) -> Signal:
    """A Signal from a Signal, from three numbers, or from a smooth function of t."""
    if hasattr(value, "covers"):
        return value  # type: ignore[return-value]
    if callable(value):
        return Function(value)
    return Constant(value)


Line = tuple[FloatArray, FloatArray]
"""Value (3,) at a time, and rate (3,) from there on, 1/s."""


def line_of(signal: Signal, begin: float, end: float) -> Line | None:
    """A signal from `begin` to `end` as a linear function; None where it is not linear."""
    line = getattr(signal, "line", None)  # user-defined signals need not have it
    if line is None or any(begin < kink < end for kink in signal.kinks):
        return None
    return line(begin, end)


def is_constant(signal: Signal | None) -> bool:
    """Whether a signal is constant between jumps; True for None."""
    return signal is None or bool(getattr(signal, "constant", False))


@dataclass(frozen=True, eq=False)
class Constant:
    """The same three numbers at all times."""

    value: ArrayLike
    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()
    constant: ClassVar[bool] = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", _vector(self.value, "a constant"))

    def __call__(self, t: float) -> FloatArray:
        """The value (3,)."""
        return self.value  # type: ignore[return-value]

    def line(self, begin: float, end: float) -> Line:
        """The value, with zero rate."""
        return self(begin), np.zeros(3)

    def covers(self, begin: float, end: float) -> bool:
        """Always."""
        return True


@dataclass(frozen=True)
class Clock:
    """The time itself, as the first of three numbers."""

    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()

    def __call__(self, t: float) -> FloatArray:
        """(t, 0, 0)."""
        return np.array([t, 0.0, 0.0])

    def line(self, begin: float, end: float) -> Line:
        """It runs."""
        return self(begin), np.array([1.0, 0.0, 0.0])

    def covers(self, begin: float, end: float) -> bool:
        """Always."""
        return True


CLOCK = Clock()


@dataclass(frozen=True, eq=False)
class Pulse:
    """Three numbers from `begin` to `end`, zero before and after; both ends are jumps."""

    value: ArrayLike
    begin: float
    end: float
    kinks: tuple[float, ...] = ()
    constant: ClassVar[bool] = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", _vector(self.value, "a pulse"))
        if not (math.isfinite(self.begin) and self.end > self.begin):
            raise InputError(
                f"pulse: it lasts from {self.begin:g} to {self.end:g} s: let the end come after the begin"
            )

    @property
    def jumps(self) -> tuple[float, ...]:
        """Start, and end unless it is infinite."""
        return tuple(t for t in (self.begin, self.end) if math.isfinite(t))

    def __call__(self, t: float) -> FloatArray:
        """Value (3,) at time t."""
        return self.value if self.begin <= t < self.end else np.zeros(3)  # type: ignore[return-value]

    def line(self, begin: float, end: float) -> Line:
        """Value at `begin`, with zero rate."""
        return self(begin), np.zeros(3)

    def covers(self, begin: float, end: float) -> bool:
        """Always."""
        return True


@dataclass(frozen=True, eq=False)
class Function:
    """A function of t that returns three numbers, with the times of its jumps and kinks declared."""

    function: Callable[[float], ArrayLike]
    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()

    def __call__(self, t: float) -> FloatArray:
        """Value (3,) at time t; raises InputError if the function returns anything but three numbers."""
        value = np.asarray(self.function(t), dtype=np.float64)
        if value.shape != (3,):
            raise InputError(f"the function at t = {t:g} s gives {value.tolist()!r}: expected three numbers")
        return value

    def covers(self, begin: float, end: float) -> bool:
        """Always."""
        return True


@dataclass(frozen=True, eq=False)
class Table:
    """Rows of time and three values, interpolated linearly or by cubic splines.

    times : (k,), s, rising; a time that appears twice is a jump
    values : (k, 3)
    interpolation : "linear" (rows are kinks) or "cubic" (C², natural splines between jumps)
    """

    times: FloatArray
    values: FloatArray
    interpolation: Interpolation = "linear"
    _splines: tuple[tuple[float, CubicSpline], ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        times, values = frozen_floats(self.times), frozen_floats(self.values)
        check_table(times, values, self.interpolation)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)
        pieces = []
        if self.interpolation == "cubic":
            for piece in np.split(np.arange(len(times)), np.flatnonzero(np.diff(times) == 0) + 1):
                if len(piece) > 1:
                    pieces.append(
                        (times[piece[-1]], CubicSpline(times[piece], values[piece], bc_type="natural"))
                    )
        object.__setattr__(self, "_splines", tuple(pieces))

    @property
    def jumps(self) -> tuple[float, ...]:
        """Times that appear twice."""
        return tuple(self.times[1:][np.diff(self.times) == 0])

    @property
    def kinks(self) -> tuple[float, ...]:
        """Inner rows of a linear table."""
        return () if self.interpolation == "cubic" else tuple(self.times[1:-1])

    def __call__(self, t: float) -> FloatArray:
        """Value (3,) at time t."""
        if self.interpolation == "linear":
            return np.array([np.interp(t, self.times, column) for column in self.values.T])
        return next((spline for end, spline in self._splines if t < end), self._splines[-1][1])(t)

    def line(self, begin: float, end: float) -> Line | None:
        """Value at `begin` and rate up to `end`; None for a cubic table, or beyond the last row."""
        if self.interpolation == "cubic" or not self.covers(begin, end):
            return None
        start = self(begin)
        return start, (self(end) - start) / (end - begin) if end > begin else np.zeros(3)

    def covers(self, begin: float, end: float) -> bool:
        """Whether the rows reach from `begin` to `end`."""
        return bool(self.times[0] <= begin and end <= self.times[-1])


class Covering(Protocol):
    """A signal or motion, which may be defined over a part of the time only."""

    def covers(self, begin: float, end: float) -> bool:
        """Whether it is defined from `begin` to `end`."""
        ...


def check_covers(source: Covering, begin: float, end: float) -> None:
    """Raise InputError where a table does not cover the flight from `begin` to `end`."""
    if not source.covers(begin, end):
        times: FloatArray = source.times  # type: ignore[attr-defined]  # only tables end somewhere
        raise InputError(
            f"a table reaches from {times[0]:g} to {times[-1]:g} s, but the flight lasts from {begin:g} to {end:g} s: "
            "add rows and fly it afresh, or end the flight earlier"
        )


def check_table(times: FloatArray, values: FloatArray, interpolation: str) -> None:
    """Raise InputError for a table that cannot be interpolated."""
    if interpolation not in INTERPOLATIONS:
        raise InputError(
            f"table: interpolation is {interpolation!r}: choose one of {', '.join(INTERPOLATIONS)}"
        )
    if times.ndim == 1 and len(times) < 2:
        found = "only one row" if len(times) else "no row"
        raise InputError(f"table: it has {found} of numbers: give two rows at least")
    if times.ndim != 1 or values.shape != (len(times), 3):
        raise InputError(
            f"table: {times.shape} times with {values.shape} values: give rows of a time and 3 values each"
        )
    if not (np.isfinite(times).all() and np.isfinite(values).all()):
        row = int(np.argmin(np.isfinite(times) & np.isfinite(values).all(axis=1)))
        raise InputError(f"table: row {row + 1} holds a number that is not finite: mend it")
    wrong = np.diff(times) < 0
    wrong[1:] |= times[2:] == times[:-2]  # a time that appears three times
    if wrong.any():
        row = int(np.argmax(wrong)) + 2
        raise InputError(
            f"table: the times do not rise at row {row}: sort them; a time that stands twice is a jump"
        )
    if times[0] == times[1] or times[-1] == times[-2]:
        raise InputError("table: it jumps at its first or last row: let it begin and end with a single time")


def _vector(value: ArrayLike, what: str) -> FloatArray:
    vector = frozen_floats(value)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise InputError(f"{what} gives {np.asarray(value).tolist()!r}: expected three finite numbers")
    return vector
