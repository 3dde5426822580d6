"""What the driver of a flight needs of an integrator.

y = (x, v) and yp = (v, a) are (2, n, 3).
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from netdae.core.arrays import FloatArray, frozen_floats
from netdae.system.system import System

_ZERO = frozen_floats(np.zeros(3))


class Share(NamedTuple):
    """What the balance gains from the end of the last internal step, from an integrator that sums it itself."""

    dissipated_energy: float  # J
    external_work: float  # J
    external_impulse: FloatArray  # (3,), N s
    peak_tension: float  # N
    external_angular_impulse: FloatArray = _ZERO  # (3,), N m s, about the origin


NOTHING = Share(0.0, 0.0, _ZERO, 0.0)
"""No gain."""


class Step(NamedTuple):
    """Where an internal step, or an instant inside it, has come to; no share where the running balance integrates."""

    t: float
    y: FloatArray
    yp: FloatArray
    share: Share | None = None


class Stepper(Protocol):
    """An integrator that goes from internal step to internal step.

    every_step : whether each call of `step` is to make one step only, so that nothing in it is missed
    """

    every_step: bool
    COUNTS: ClassVar[tuple[str, ...]]  # of `counts`, those that the statistics report
    counts: Counter[str]
    seconds: defaultdict[str, float]

    def enter(self, phase: System, t: float, y: FloatArray, yp: FloatArray) -> None:
        """Start afresh at t in a phase, from consistent y and yp."""
        ...

    def go_on(self, part: System) -> None:
        """Go on, without a new start, in the part of the phase that begins here."""
        ...

    def step(self, stop: float) -> list[Step]:
        """Go on towards `stop`, not beyond: the internal steps that were made, at least one, in their order."""
        ...

    def output(self, t: float) -> Step:
        """The state at a time between the last two internal steps."""
        ...

    def memory(self) -> dict[str, FloatArray]:
        """What it takes, beside y and yp, to go on from here just as this integrator does."""
        ...

    def restore(self, memory: Mapping[str, FloatArray]) -> None:
        """Take a memory over after `enter` and `go_on` at the place where it was reported."""
        ...
