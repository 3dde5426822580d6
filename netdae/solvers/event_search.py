"""What the driver of a flight needs from its event search."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from netdae.core.arrays import FloatArray
from netdae.model.state import State


class Happening(Protocol):
    """The name and action of an event."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def action(self) -> str: ...  # noqa: D102


class Firing(Protocol):
    """All events of an instant; `state` is the first one at or just beyond them."""

    @property
    def events(self) -> Sequence[Happening]: ...  # noqa: D102
    @property
    def state(self) -> State: ...  # noqa: D102
    @property
    def t(self) -> float: ...  # noqa: D102


class EventSearch(Protocol):
    """The search for the events of a flight, see `events.detector.EventDetector`."""

    @property
    def needs_every_step(self) -> bool: ...  # noqa: D102

    def scan(self) -> Callable[[FloatArray], int] | None:
        """The first of positions (r, n, 3) after r steps at which an event that needs every step happens, or r.

        None where each step has to be reported.
        """
        ...

    def begin(self, start: State) -> None:
        """Start from the first state; not after `restore`."""
        ...

    def first(self, last: State, step: State, state_at: Callable[[float], State]) -> Firing | None:
        """The events of the earliest instant after `last`, up to `step`."""
        ...

    def note(self, firing: Any) -> None:
        """Record that the last firing found has been dealt with."""
        ...

    def memory(self) -> dict[str, Any]:
        """What `restore` needs to go on from here."""
        ...

    def restore(self, memory: Mapping[str, Any]) -> None:
        """Continue from such a memory."""
        ...
