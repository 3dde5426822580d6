"""Watches: what one event has seen of the flight, and whether it lies in a step.

Symbols: c the figure, c₀ the event's value, g = c − c₀; s = ±1 the side of g from which a crossing counts.
A watch is armed while it knows its side. An event lies where g leaves that side.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

import numpy as np
from scipy.optimize import brentq

from netdae.core.arrays import FloatArray
from netdae.events.event import QUANTITIES, Event
from netdae.events.quantities import Scene
from netdae.model.state import State

StateAt = Callable[[float], State]

SIDES = {"up": (-1,), "down": (1,), "both": (-1, 1)}
NEAR = 1e-12  # share of a step to which an event is located; round-off of the clock where that is more
PEAK_NEAR = 1e-6  # the same for a maximum, whose height depends on the square of it
SMALLEST_TOP = 0.1  # share of its reference area to which a mouth has to open for its fall to count in full


class Watch(Protocol):
    """What the detector needs from the search for one event."""

    event: Event
    count: int  # times that the event has happened

    def begin(self, start: State) -> None:
        """Start from the first state of the flight."""
        ...

    def beyond(self, state: State) -> bool:
        """Whether a state that ends no step lies at the event or beyond it."""
        ...

    def found(self, last: State, step: State, state_at: StateAt) -> State | None:
        """The first state at the event or just beyond, None where the step does not reach it."""
        ...

    def advance(self, last: State, step: State, state_at: StateAt) -> None:
        """See a step, or the first part of it, in which the event does not happen."""
        ...

    def fire(self, state: State) -> tuple[float, float, float]:
        """Record the event; return its time in s, with mouth area in m² and distance in m at that time."""
        ...

    def memory(self) -> FloatArray:
        """All that it has seen, (6,)."""
        ...

    def restore(self, memory: FloatArray) -> None:
        """Take over what another one has seen."""
        ...


def located(
    g: Callable[[State], float], last: State, step: State, state_at: StateAt, *, share: float = NEAR
) -> State:
    """The first state found after g has changed from its sign at `last` to that at `step`, by Brent's method.

    share : of the step, to which the instant is located
    """
    seen = {last.t: (g(last), last), step.t: (g(step), step)}
    side = -math.copysign(1.0, seen[step.t][0])
    if seen[last.t][0] * side <= 0:
        return last

    def at(t: float) -> float:
        if t not in seen:
            state = state_at(t)
            seen[t] = g(state), state
        return seen[t][0]

    near = max(share * (step.t - last.t), 2 * math.ulp(step.t))
    brentq(at, last.t, step.t, xtol=near, maxiter=200, disp=False)
    # the method keeps a bracket, whose end beyond the event is the first such state among all evaluated
    return seen[min(t for t, (value, _) in seen.items() if value * side <= 0)][1]


class Crossing:
    """Watch of a figure through a value."""

    def __init__(self, event: Event, scene: Scene) -> None:
        self.event = event
        self.count = 0
        self._scene = scene
        self._sides = SIDES[QUANTITIES[event.figure].direction]
        self._side = 0
        self._reach = 0.0  # the farthest that g has been on a side from which a crossing counts

    def begin(self, start: State) -> None:
        """Take the side of the start; a start just at the value has none yet."""
        self._look(start)

    def beyond(self, state: State) -> bool:
        """Whether g has left its side."""
        return self._side != 0 and self._g(state) * self._side <= 0

    def scan(self) -> Callable[[FloatArray], int] | None:
        """First of the positions x (r, n, 3) after r steps at which the event is armed or happens, or r.

        None where each step must be seen: for a repeated event, and where the scene has no scan of the quantity.
        """
        scan = self._scene.scan(self.event.figure)
        if scan is None or self.event.repeat:
            return None
        leaving = (-self._side,) if self._side else self._sides

        def first(x: FloatArray) -> int:
            there = np.isin(np.sign(scan.largest(x) - self.event.level), leaving)
            return int(there.argmax()) if there.any() else len(x)

        return first

    def found(self, last: State, step: State, state_at: StateAt) -> State | None:
        """Where g changes its sign, which it is known to do from the state at the end of the step."""
        if self._side == 0 or not self._g(step) * self._side < 0:
            return None
        return located(self._g, last, step, state_at)

    def advance(self, last: State, step: State, state_at: StateAt) -> None:
        """Arm the event again where its figure has gone back far enough."""
        self._look(step)

    def fire(self, state: State) -> tuple[float, float, float]:
        """Disarm the event."""
        self.count += 1
        self._side = 0
        return state.t, self._scene.value("mouth_area", state), self._scene.value("distance", state)

    def memory(self) -> FloatArray:
        """Count, side and reach, (6,)."""
        return np.array([self.count, self._side, self._reach, 0.0, 0.0, 0.0])

    def restore(self, memory: FloatArray) -> None:
        """Take over count, side and reach."""
        self.count, self._side, self._reach = int(memory[0]), int(memory[1]), float(memory[2])

    def _g(self, state: State) -> float:
        return self._scene.value(self.event.figure, state) - self.event.level

    def _look(self, state: State) -> None:
        g = self._g(state)
        side = int(np.sign(g)) if g == g else 0
        if side not in self._sides:
            return
        self._reach = max(self._reach, abs(g))
        if self._side == 0 and abs(g) > self._way_back():
            self._side = side

    def _way_back(self) -> float:
        """How far g has to be from zero to arm the event."""
        if self.count == 0:
            return 0.0
        facts = QUANTITIES[self.event.figure]
        return max(
            facts.back_share * abs(self.event.level), facts.back_least, facts.back_of_reach * self._reach
        )


class Largest:
    """Watch of the largest mouth area: a running maximum that the area has fallen below by a share.

    The maximum inside a step is where the area's rate falls through zero. A fall counts once the mouth has opened
    to a tenth of its area in x̄, since a packed net's mouth flutters; below, shares are of this tenth.
    A repeated event is armed again once the area has risen by the same share above its smallest value since.
    """

    def __init__(self, event: Event, scene: Scene) -> None:
        self.event = event
        self.count = 0
        self._scene = scene
        self._armed = True
        self._top = (0.0, -math.inf, 0.0)  # area, time, distance
        self._bottom = 0.0
        self._ends: tuple[State, float, float] | None = None  # last state evaluated, its area and rate
        self._reported: tuple[State, State, tuple[float, float, float], State] | None = None

    def begin(self, start: State) -> None:
        """Take the start as the largest so far."""
        self._top = self._moment(start)

    def beyond(self, state: State) -> bool:
        """Whether the area has fallen below the share of its maximum."""
        return self._armed and self._fall(self._top[0], state) > 0

    def found(self, last: State, step: State, state_at: StateAt) -> State | None:
        """Where the area has fallen by the share, after its maximum up to the end of the step."""
        if not self._armed:
            return None
        top, since = self._top_after(last, step, state_at)
        if not self._fall(top[0], step) > 0:
            return None
        return located(lambda state: self._fall(top[0], state), since, step, state_at)

    def advance(self, last: State, step: State, state_at: StateAt) -> None:
        """Update the maximum with that of the step; or the minimum, after the event has happened."""
        if self._armed:
            self._top, _ = self._top_after(last, step, state_at)
            return
        area = self._scene.value("mouth_area", step)
        self._bottom = min(self._bottom, area)
        if area - self._bottom > self._share_of(area):
            self._armed, self._top = True, self._moment(step)

    def fire(self, state: State) -> tuple[float, float, float]:
        """Disarm the event, which is reported at its maximum."""
        self.count += 1
        self._armed, self._bottom = False, self._scene.value("mouth_area", state)
        area, t, distance = self._top
        return t, area, distance

    def memory(self) -> FloatArray:
        """Count, whether armed, the maximum with time and distance, and the minimum, (6,)."""
        return np.array([self.count, self._armed, *self._top, self._bottom])

    def restore(self, memory: FloatArray) -> None:
        """Take over what `memory` reports."""
        self.count, self._armed, self._bottom = int(memory[0]), bool(memory[1]), float(memory[5])
        self._top = float(memory[2]), float(memory[3]), float(memory[4])

    def _moment(self, state: State) -> tuple[float, float, float]:
        return self._scene.value("mouth_area", state), state.t, self._scene.value("distance", state)

    def _share_of(self, area: float) -> float:
        return self.event.level * max(area, SMALLEST_TOP * self._scene.reference_area)

    def _fall(self, top: float, state: State) -> float:
        """How much farther than the share the area has fallen below `top`, m²; a mouth still packed has no fall."""
        if top < SMALLEST_TOP * self._scene.reference_area:
            return -math.inf
        return top - self._share_of(top) - self._scene.value("mouth_area", state)

    def _top_after(
        self, last: State, step: State, state_at: StateAt
    ) -> tuple[tuple[float, float, float], State]:
        """The maximum up to the end of the step, and the state in the step after which the area can fall from it."""
        if self._reported is not None and self._reported[0] is last and self._reported[1] is step:
            return self._reported[2], self._reported[3]
        top, since = self._top, last
        h = step.t - last.t
        (A0, dA0), (A1, dA1) = self._area_and_rate(last), self._area_and_rate(step)
        # the tangents at both ends meet above the top of a curve that bends down between them
        if h > 0 and dA0 > 0 > dA1 and min(A0 + h * dA0, A1 - h * dA1) > max(top[0], A1):
            peak = located(
                lambda state: -self._area_and_rate(state)[1], last, step, state_at, share=PEAK_NEAR
            )
            if self._scene.value("mouth_area", peak) > top[0]:
                top, since = self._moment(peak), peak
        if A1 > top[0]:
            top = self._moment(step)
        self._reported = last, step, top, since
        return top, since

    def _area_and_rate(self, state: State) -> tuple[float, float]:
        if self._ends is None or self._ends[0] is not state:
            self._ends = state, *self._scene.area_and_rate(state)
        return self._ends[1:]
