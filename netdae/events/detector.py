"""The event detector, which finds the events of a flight between internal steps and records them.

After each internal step the driver asks for the first instant in it at which events happen. Figures are evaluated at
the ends of steps, by the same code for every integrator; where one has passed its value, the instant is located on the
integrator's own dense output to within round-off of the clock. Events within a billionth of the step are of one
instant: they are found, recorded and acted on together, whatever their order. The order of calls:

    detector.begin(start)
    for each step from `last` to `step`:
        while (firing := detector.first(last, step, state_at)) is not None:
            detector.note(firing)
            ... the actions; the flight may go on elsewhere from firing.state
            last = firing.state

A figure that passes its value and comes back between two evaluations goes unseen; remedies are a smaller max_step, and
an evaluation at every step where `needs_every_step`. A figure that is at its value at the start has not passed it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.events.crossing import Crossing, Largest, StateAt, Watch
from netdae.events.event import QUANTITIES, Event, check_names
from netdae.events.quantities import Scene
from netdae.events.turning import Turning
from netdae.model.state import State
from netdae.system.system import System

TOGETHER = 1e-9  # share of a step within which events are of one instant: round-off of figures, with a margin


class FoundEvents(NamedTuple):
    """All events of an instant, in the order in which they were given; `state` is at all of them or just beyond."""

    events: tuple[Event, ...]
    state: State

    @property
    def t(self) -> float:
        """Time at which they were found, s."""
        return self.state.t


class _Line(NamedTuple):
    """What is reported about an event that has happened."""

    event: int
    time: float  # s; of the maximum, where it is one
    found: float  # s
    mouth_area: float  # m², at `time`
    distance: float  # m, at `time`
    paid_out: float = math.nan  # m, at `found`
    reached: float = math.nan  # the figure at a turning point


class EventDetector:
    """The events of one flight.

    system : as the flight starts; a restraint that begins or ends later changes no figure
    mouth : name of the group whose closed loop is the mouth, see `mouth.mouth_of`; "border" where there is none
        means no mouth, as None does
    corners : name of the node group of the corners, see `mouth.corners_of`

    Raises InputError for two events with the same name, and where the net lacks what an event needs.
    """

    def __init__(
        self,
        events: Sequence[Event],
        system: System,
        *,
        mouth: str | None = "border",
        corners: str | None = "corners",
    ) -> None:
        check_names(events)
        self._scene = Scene(system, events, mouth=mouth, corners=corners)
        self._reel = system.net.node_groups.get("reel", ())
        self._events = tuple(events)
        self._watches = self._fresh()
        self._lines: list[_Line] = []
        self._step: tuple[State, StateAt] | None = None  # start of the step that was searched last

    def begin(self, start: State) -> None:
        """Begin a flight at its first state, from which distances count; not after `restore`."""
        self._scene.begin(start)
        self._watches, self._lines = self._fresh(), []
        for watch in self._watches:
            watch.begin(start)

    def _fresh(self) -> tuple[Watch, ...]:
        """A watch for each event, none of which has happened."""
        return tuple(_kind_of(event)(event, self._scene) for event in self._events)

    def first(self, last: State, step: State, state_at: StateAt) -> FoundEvents | None:
        """The events of the earliest instant in the step from `last` to `step`, or None, after which the step is done.

        last : where the step began, or the state of the firing that was noted before
        state_at : time in s, between the two, to the State there
        """
        live = [watch for watch in self._watches if _live(watch)]
        self._step = last, state_at
        found = _found(live, last, step, state_at)
        if not found:
            for watch in live:
                watch.advance(last, step, state_at)
            return None
        near = max(TOGETHER * (step.t - last.t), 4 * math.ulp(step.t))
        end, at_end = min(found.values(), key=_time), found
        # a figure may have passed its value before, and come back by the end of the step
        while at_end := _found(live, last, end, state_at):
            earliest = min(at_end.values(), key=_time)
            if earliest.t >= end.t - near:
                break
            end, found = earliest, found | at_end
        end = max((state for state in found.values() if state.t <= end.t + near), key=_time)
        if step.t - end.t <= near:
            end = step
        of_it = [
            watch
            for watch in live
            if watch in at_end or watch.beyond(end) or (watch in found and found[watch].t <= end.t)
        ]
        return FoundEvents(tuple(watch.event for watch in of_it), end)

    def note(self, firing: FoundEvents) -> None:
        """Record the firing that `first` has just returned: its events are disarmed, and the step is done up to it."""
        assert self._step is not None
        last, state_at = self._step
        for watch in filter(_live, self._watches):
            watch.advance(last, firing.state, state_at)
        paid_out = float(firing.state.x[self._reel, 0].sum()) if len(self._reel) else math.nan
        for number, watch in enumerate(self._watches):
            if watch.event in firing.events:
                time, area, distance = watch.fire(firing.state)
                event = watch.event
                turns = event.at != "value"
                reached = self._scene.value(event.figure, firing.state) if turns else math.nan
                self._lines.append(_Line(number, time, firing.t, area, distance, paid_out, reached))

    @property
    def events(self) -> tuple[Event, ...]:
        """All events, in their order."""
        return tuple(watch.event for watch in self._watches)

    @property
    def needs_every_step(self) -> bool:
        """Whether an event that may still happen watches a figure that comes and goes within milliseconds."""
        return any(_live(watch) and QUANTITIES[watch.event.figure].fast for watch in self._watches)

    def scan(self) -> Callable[[FloatArray], int] | None:
        """See `solvers.event_search.EventSearch.scan`."""
        found = [
            watch.scan() if isinstance(watch, Crossing) else None
            for watch in self._watches
            if _live(watch) and QUANTITIES[watch.event.figure].fast
        ]
        firsts = [each for each in found if each is not None]
        return (lambda x: min(first(x) for first in firsts)) if len(firsts) == len(found) else None

    @property
    def fired(self) -> dict[str, float]:
        """Name of each event that has happened, and the time in s at which it was first found."""
        first: dict[str, float] = {}
        for line in self._lines:
            first.setdefault(self._watches[line.event].event.name, line.found)
        return first

    @property
    def records(self) -> list[dict[str, Any]]:
        """For the summary: each event that happened, in order, then those that did not, with time and found None.

        time : s, at which the figure passed its value, or at which the mouth was largest
        found : s, at which that was known, and the action taken
        mouth_area, distance : m² and m, at `time`; left out where the net has no mouth
        paid_out : m, of the tether at `found`, when it may be locked; left out where it has no reel
        at, reached : of a turning point, whether it is a maximum or a minimum, and the figure there
        """
        reported = [self._record(line.event, line) for line in self._lines]
        missing = [self._record(k, None) for k, watch in enumerate(self._watches) if not watch.count]
        return reported + missing

    def memory(self) -> dict[str, NDArray[Any]]:
        """All that the detector has seen, as arrays, from which `restore` makes one that goes on identically."""
        return {
            "names": np.array([watch.event.name for watch in self._watches], dtype=np.str_),
            "watches": np.array([watch.memory() for watch in self._watches]).reshape(-1, 6),
            "lines": np.array(self._lines, dtype=np.float64).reshape(-1, len(_Line._fields)),
            "origin": np.stack((self._scene.origin, self._scene.direction)),
        }

    def restore(self, memory: Mapping[str, NDArray[Any]]) -> None:
        """Go on from the memory of a detector of the same events; raises InputError where they differ."""
        names = [str(name) for name in memory["names"]]
        if names != [watch.event.name for watch in self._watches]:
            own = ", ".join(watch.event.name for watch in self._watches) or "none"
            raise InputError(
                f"the checkpoint is of a flight with the events {', '.join(names) or 'none'}, this one has {own}: "
                "resume with the same events"
            )
        for watch, seen in zip(self._watches, memory["watches"], strict=True):
            watch.restore(seen)
        self._lines = [_Line(int(number), *map(float, rest)) for number, *rest in memory["lines"].tolist()]
        self._scene.origin, self._scene.direction = np.array(memory["origin"])

    def _record(self, number: int, line: _Line | None) -> dict[str, Any]:
        event = self._watches[number].event
        record: dict[str, Any] = {
            "name": event.name,
            "figure": event.figure,
            "value": event.level
            if event.at == "value" and QUANTITIES[event.figure].takes_value
            else event.value,
            "action": event.action,
            "time": None if line is None else line.time,
            "found": None if line is None else line.found,
        }
        if event.at != "value":
            record["at"] = event.at
        if line is not None:
            if line.reached == line.reached:
                record["reached"] = line.reached
            if line.mouth_area == line.mouth_area:  # NaN of a net without a mouth
                record["mouth_area"] = line.mouth_area
            record["distance"] = line.distance
            if line.paid_out == line.paid_out:
                record["paid_out"] = line.paid_out
        return record


def _found(watches: Sequence[Watch], last: State, end: State, state_at: StateAt) -> dict[Watch, State]:
    """The state at each event that happens between two states."""
    states = ((watch, watch.found(last, end, state_at)) for watch in watches)
    return {watch: state for watch, state in states if state is not None}


def _time(state: State) -> float:
    return state.t


def _kind_of(event: Event) -> type[Turning] | type[Largest] | type[Crossing]:
    if event.at != "value":
        return Turning
    return Largest if event.figure == "largest_mouth_area" else Crossing


def _live(watch: Watch) -> bool:
    return watch.count == 0 or watch.event.repeat
