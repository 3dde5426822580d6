"""Watch of a turning point: where the rate of a figure changes its sign.

Symbols: c the figure, ċ its rate; s = 1 for a maximum and −1 for a minimum. The event lies where s ċ falls through
zero. It counts where s c has risen by more than the event's value since the start, or since the last turning point that
counted: round-off makes a figure at rest turn at each step.
"""

from __future__ import annotations

import math

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.events.crossing import StateAt, located
from netdae.events.event import Event
from netdae.events.quantities import Scene
from netdae.events.rates import RATES
from netdae.model.state import State

LEAST = 1e-9
"""Least rise that counts, over the largest value that the figure has had."""


class Turning:
    """Watch of a maximum or a minimum."""

    def __init__(self, event: Event, scene: Scene) -> None:
        self.event = event
        self.count = 0
        self._scene = scene
        self._sign = 1.0 if event.at == "maximum" else -1.0
        self._least = math.inf  # of s c, since the start or the last turning point that counted
        self._reach = 0.0  # the largest |c| so far
        self._turned = False  # whether the part seen last ends at a turning point or just beyond it
        self._rates: tuple[tuple[State, float], ...] = ()  # of the two states evaluated last

    def begin(self, start: State) -> None:
        """Count the rise from the start."""
        self._see(start)

    def beyond(self, state: State) -> bool:
        """Whether the part of a step that ends at the state has a turning point at its end."""
        return self._turned and self._counts(state)

    def found(self, last: State, step: State, state_at: StateAt) -> State | None:
        """Where the rate changes its sign, if it is known to do so by its signs at both ends of the step."""
        if not self._rate(step) < 0 or self._rate(last) < 0:
            return None
        top = located(self._rate, last, step, state_at)
        return top if self._counts(top) else None

    def advance(self, last: State, step: State, state_at: StateAt) -> None:
        """Update the value from which the rise counts."""
        self._turned = self._rate(last) > 0 >= self._rate(step)
        self._see(step)

    def fire(self, state: State) -> tuple[float, float, float]:
        """Count the next rise from here."""
        self.count += 1
        self._least, self._turned = self._height(state), False
        return state.t, self._scene.value("mouth_area", state), self._scene.value("distance", state)

    def memory(self) -> FloatArray:
        """Count, the value from which the rise counts, reach, and whether it has turned, (6,)."""
        return np.array([self.count, self._least, self._reach, self._turned, 0.0, 0.0])

    def restore(self, memory: FloatArray) -> None:
        """Take over what `memory` reports."""
        self.count, self._turned = int(memory[0]), bool(memory[3])
        self._least, self._reach = float(memory[1]), float(memory[2])

    def _height(self, state: State) -> float:
        return self._sign * self._scene.value(self.event.figure, state)

    def _rate(self, state: State) -> float:
        for known, rate in self._rates:
            if known is state:
                return rate
        rate = self._sign * RATES[self.event.figure](self._scene, state)
        self._rates = (*self._rates[-1:], (state, rate))
        return rate

    def _see(self, state: State) -> None:
        height = self._height(state)
        self._least = min(self._least, height)
        self._reach = max(self._reach, abs(height))

    def _counts(self, state: State) -> bool:
        height = self._height(state)
        least = max(self.event.value or 0.0, LEAST * max(self._reach, abs(height)))
        return height - self._least > least
