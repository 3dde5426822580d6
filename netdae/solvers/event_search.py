"""What the driver of a flight needs of whatever finds its events."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from netdae.model.state import State


class Happening(Protocol):
    """What an event is called and asks for."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def action(self) -> str: ...  # noqa: D102


class Firing(Protocol):
    """An event that has been found; `state` is the first one at it or just beyond."""

    @property
    def event(self) -> Happening: ...  # noqa: D102
    @property
    def state(self) -> State: ...  # noqa: D102
    @property
    def t(self) -> float: ...  # noqa: D102


class EventSearch(Protocol):
    """What finds the events of a flight, see `events.detector.EventDetector`."""

    @property
    def needs_every_step(self) -> bool: ...  # noqa: D102

    def begin(self, start: State) -> None:
        """Take in the first state; not after `restore`."""
        ...

    def first(self, last: State, step: State, state_at: Callable[[float], State]) -> Firing | None:
        """The earliest event after `last`, up to `step`; at `last` if it happens together with one noted before."""
        ...

    def note(self, firing: Any) -> None:
        """The firing that was found last has been dealt with."""
        ...

    def memory(self) -> dict[str, Any]:
        """What `restore` needs to go on from here."""
        ...

    def restore(self, memory: Mapping[str, Any]) -> None:
        """Go on from there."""
        ...
