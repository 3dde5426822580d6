"""What the driver of a flight needs from an integrator.

y = (x, v) and yp = (v, a) are (2, n, 3).
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Mapping
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from netdae.core.arrays import FloatArray, frozen_floats
from netdae.model.state import State
from netdae.solvers.options import SolverOptions
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


Scan = Callable[[FloatArray], int]
"""The first of positions (r, n, 3) after r steps from which on steps are to be reported; r if none is."""


class Step(NamedTuple):
    """The end of an internal step, or an instant inside it; no share where the running balance integrates."""

    t: float
    y: FloatArray
    yp: FloatArray
    share: Share | None = None
    attitude: FloatArray | None = None  # (4,), of a target, see `State`


def longest_step_of(system: System, options: SolverOptions) -> float:
    """`max_step` in s, or less where a target's spin at the start requires it; 0 for no limit."""
    body = system.body
    spin = np.inf if body is None else body.longest_step(body.whole(State.at(np.zeros((body.place, 3)))).v)
    longest = min(options.max_step or np.inf, spin)
    return longest if np.isfinite(longest) else 0.0


class Stepper(Protocol):
    """An integrator that goes from internal step to internal step.

    every_step : whether each step is to be reported, so that nothing in it is missed
    scan : if not None, which of many steps need not be: see `event_search.EventSearch.scan`
    """

    every_step: bool
    scan: Scan | None
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
        """Go on towards `stop`, not beyond; return the internal steps that were made, at least one, in order."""
        ...

    def output(self, t: float) -> Step:
        """The state at a time between the last two internal steps."""
        ...

    def memory(self) -> dict[str, FloatArray]:
        """What is needed, besides y and yp, to go on from here exactly as this integrator does."""
        ...

    def restore(self, memory: Mapping[str, FloatArray]) -> None:
        """Take over a memory, after `enter` and `go_on` at the place where it was taken."""
        ...
