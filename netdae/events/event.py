"""Events: instants at which a figure of the flight passes a value or turns, and what is then done.

An event is data: which of `QUANTITIES`, which value, which of `ACTIONS`. It is found between the integrator's internal
steps by `events.detector.EventDetector`. To add a figure, add an entry here, its function in
`events.quantities.MEASURES` and that of its rate in `events.rates.RATES`; to add an action, add an entry here and its
effect in the driver.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Literal, NamedTuple

from netdae.core.errors import InputError

QuantityName = Literal[
    "largest_mouth_area",
    "mouth_area",
    "corner_area",
    "distance",
    "chaser_distance",
    "tether_taut",
    "tether_tension",
    "all_slack",
    "tension_over_strength",
    "target_distance",
    "first_contact",
    "contacts",
]
Place = Literal["value", "maximum", "minimum"]
ActionName = Literal["none", "stop", "start_closing", "lock_tether", "next_phase"]
Need = Literal["mouth", "corners", "tether", "chaser", "strength", "closing", "target", "contact"]

NEEDS: Mapping[Need, str] = {
    "mouth": "a mouth: name the group of its closed loop, in [metrics] as mouth",
    "corners": "three corners or more on a mouth: name their node group, in [metrics] as corners",
    "tether": "a tether: add [tether], or a cable group of that name",
    "chaser": "a chaser at the end of a tether: add [tether], or a node group of that name",
    "strength": "a cord with a strength: give it to a [[material]]",
    "target": "a target: add [target]",
    "contact": "something to touch: add [target] or [[obstacles]]",
    "closing": "what closes it: add [[closing]] without begin",
}
"""What a net has to have for a figure or an action."""


class Quantity(NamedTuple):
    """What a figure is, when it fires, and how far it has to go back before it may fire again.

    what, unit : in words, and SI
    direction : in which it passes the value, or "both"
    takes_value, default, above, below : whether events give a value, its default, and the open range of it
    needs : what the net has to have
    fast : whether it can pass a value and come back within milliseconds, as tensions do
    back_share, back_least, back_of_reach : a repeated event is armed again once its figure has gone back from
        the value by back_share of the value, by back_least in its unit, and by back_of_reach of the farthest that it
        has been there so far
    turns : whether events may watch its maxima and minima
    """

    what: str
    unit: str
    direction: Literal["up", "down", "both"] = "both"
    takes_value: bool = True
    default: float | None = None
    above: float = 0.0
    below: float = math.inf
    needs: Need | None = None
    fast: bool = False
    back_share: float = 0.01
    back_least: float = 0.0
    back_of_reach: float = 0.0
    turns: bool = True


# Lengths and areas go back by 1 %, the fall by which the largest mouth area is reported; bullet paths to 1 mm.
# A tether that has contracted by 1 % is slack again: cords of net and tether stretch by less than 0.1 % in flight,
# so that their ringing does not arm the event again. How far cables stretch is known only from the flight, so
# all_slack requires a tenth of their largest strain so far. In ringing, tension swings between zero and twice its
# mean: a load counts as another one if it comes after half the value.
QUANTITIES: Mapping[QuantityName, Quantity] = {
    "largest_mouth_area": Quantity(
        "the largest mouth area so far, once the area has fallen by the share `value` of it",
        "1",
        "down",
        default=0.01,
        below=1.0,
        needs="mouth",
        turns=False,
    ),
    "mouth_area": Quantity("area of the mouth", "m²", needs="mouth"),
    "corner_area": Quantity("area of the loop through the corners", "m²", needs="corners"),
    "distance": Quantity(
        "way of the net's centre of mass along its first momentum", "m", above=-math.inf, back_least=1e-3
    ),
    "chaser_distance": Quantity(
        "distance from the net's centre of mass to the chaser", "m", needs="chaser", back_least=1e-3
    ),
    "tether_taut": Quantity(
        "largest strain E11 of the tether through zero",
        "1",
        "up",
        takes_value=False,
        needs="tether",
        fast=True,
        back_least=0.01,
    ),
    "tether_tension": Quantity(
        "largest tension of the tether, without the dashpot's share",
        "N",
        "up",
        needs="tether",
        fast=True,
        back_share=0.5,
    ),
    "all_slack": Quantity(
        "largest strain E11 of all cables through zero",
        "1",
        "down",
        takes_value=False,
        fast=True,
        back_of_reach=0.1,
    ),
    "tension_over_strength": Quantity(
        "largest ratio of tension, without the dashpot's share, to strength",
        "1",
        "up",
        default=1.0,
        needs="strength",
        fast=True,
        back_share=0.5,
    ),
    "target_distance": Quantity(
        "distance from the net's centre of mass to the target's", "m", needs="target", back_least=1e-3
    ),
    "first_contact": Quantity(
        "depth of the deepest knot or cable in a body through zero",
        "m",
        "up",
        takes_value=False,
        needs="contact",
        fast=True,
        back_least=1e-2,
        turns=False,
    ),
    "contacts": Quantity(
        "number of knots and cables that touch a body",
        "1",
        "up",
        above=-1.0,
        needs="contact",
        fast=True,
        back_share=0.5,
        turns=False,
    ),
}
"""The figures that an event may watch."""


PLACES: tuple[Place, ...] = ("value", "maximum", "minimum")


class Action(NamedTuple):
    """What an action does, in words, and what the net has to have for it."""

    what: str
    needs: Need | None = None


ACTIONS: Mapping[ActionName, Action] = {
    "none": Action("the event is recorded"),
    "stop": Action("the flight ends"),
    "start_closing": Action("winches and drawcords without a begin of their own start", "closing"),
    "lock_tether": Action("the tether is paid out no further", "tether"),
    "next_phase": Action("the integration starts afresh"),
}
"""What may be done at an event; restraints can begin and end at any event by its name."""


@dataclass(frozen=True)
class Event:
    """An instant of the flight at which a figure passes a value, or turns.

    figure : one of `QUANTITIES`
    value : in the figure's unit; None where it has none, or for the default. At a turning point, the least rise before
        a maximum, or fall before a minimum, that counts
    action : one of `ACTIONS`
    repeat : whether it may happen again, after the figure has gone back, see `Quantity`
    name : by which summary and restraints refer to it; by default figure and value, for instance "mouth_area_4.5", or
        "mouth_area_maximum"
    at : "value", or "maximum" or "minimum" for the instants at which the figure turns

    Raises InputError for an unknown figure or action, or a value that is missing, out of range or superfluous.
    """

    figure: QuantityName
    value: float | None = None
    action: ActionName = "none"
    repeat: bool = False
    name: str = ""
    at: Place = "value"

    def __post_init__(self) -> None:
        if self.figure not in QUANTITIES:
            raise InputError(f"event: figure is {self.figure!r}: {_choice(self.figure, QUANTITIES)}")
        if not self.name:
            tail = "" if self.value is None else f"_{self.value:.9g}"
            turn = "" if self.at == "value" else f"_{self.at}"
            object.__setattr__(self, "name", f"{self.figure}{turn}{tail}")
        if self.action not in ACTIONS:
            raise InputError(
                f"event {self.name!r}: action is {self.action!r}: {_choice(self.action, ACTIONS)}"
            )
        if self.at not in PLACES:
            raise InputError(f"event {self.name!r}: at is {self.at!r}: {_choice(self.at, PLACES)}")
        facts = QUANTITIES[self.figure]
        if self.at != "value":
            self._check_turning()
            return
        if not facts.takes_value:
            if self.value is not None:
                raise InputError(
                    f"event {self.name!r}: value is {self.value:g}, but {self.figure} takes none: leave it out"
                )
            return
        if self.value is None and facts.default is None:
            raise InputError(
                f"event {self.name!r}: value is missing: give one in {facts.unit} for {self.figure}"
            )
        if not (math.isfinite(self.level) and facts.above < self.level < facts.below):
            expected = "a finite number"
            if facts.above > -math.inf:
                expected += f" above {facts.above:g}"
            if facts.below < math.inf:
                expected += f" and below {facts.below:g}"
            raise InputError(
                f"event {self.name!r}: value is {self.level:g}, expected {expected} for {self.figure}"
            )

    def _check_turning(self) -> None:
        if not QUANTITIES[self.figure].turns and self.figure != "largest_mouth_area":
            raise InputError(
                f"event {self.name!r}: at is {self.at!r}, but {self.figure} does not turn smoothly: leave at out"
            )
        if self.figure == "largest_mouth_area":
            raise InputError(
                f"event {self.name!r}: at is {self.at!r}, but {self.figure} is a maximum itself: leave at out, or "
                "watch mouth_area"
            )
        if self.value is not None and not (math.isfinite(self.value) and self.value >= 0):
            way = "rise before a maximum" if self.at == "maximum" else "fall before a minimum"
            raise InputError(
                f"event {self.name!r}: value is {self.value:g}, expected zero or more: the least {way} that counts"
            )

    @property
    def level(self) -> float:
        """The value in force; zero for a figure without one."""
        if self.value is not None:
            return self.value
        default = QUANTITIES[self.figure].default
        return 0.0 if default is None else default

    @property
    def needs(self) -> dict[Need, str]:
        """What the net has to have, and for what: its figure or its action."""
        both = (
            (QUANTITIES[self.figure].needs, f"figure {self.figure}"),
            (ACTIONS[self.action].needs, f"action {self.action}"),
        )
        return {need: what for need, what in reversed(both) if need is not None}


def check_needs(event: Event, has: Collection[Need]) -> None:
    """Raise InputError where an event needs something that the net does not have."""
    for need, what in event.needs.items():
        if need not in has:
            raise InputError(f"event {event.name!r}: {what} needs {NEEDS[need]}")


def check_names(events: Sequence[Event]) -> None:
    """Raise InputError where two events have the same name."""
    names = [event.name for event in events]
    for number, name in enumerate(names):
        if name in names[:number]:
            raise InputError(
                f"event {name!r}: two events have this name, numbers {names.index(name) + 1} and {number + 1}: "
                "give one of them a name of its own"
            )


def event_called(name: str, events: Iterable[Event], *, by: str) -> Event:
    """The event that `by`, for instance a restraint, refers to; raises InputError that lists the events there are."""
    by_name = {event.name: event for event in events}
    if name not in by_name:
        none = "the flight has no events at all, add one under [[events]] or give a time in s"
        there = _choice(name, by_name) if by_name else none
        raise InputError(f"{by}: there is no event {name!r}: {there}")
    return by_name[name]


def _choice(found: object, names: Iterable[str]) -> str:
    known = list(names)
    near = get_close_matches(found, known, n=1, cutoff=0.6) if isinstance(found, str) else []
    hint = f"did you mean {near[0]!r}? " if near else ""
    return f"{hint}Choose one of {', '.join(known)}" if hint else f"choose one of {', '.join(known)}"
