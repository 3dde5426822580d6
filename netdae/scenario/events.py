"""The section [[events]] of a scenario, and the events and their detector that it makes."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from netdae.core.errors import InputError
from netdae.events.event import (
    ActionName,
    Event,
    Need,
    Place,
    QuantityName,
    check_names,
    check_needs,
    event_called,
)
from netdae.scenario.problems import InSection
from netdae.scenario.section import Section, Text

if TYPE_CHECKING:
    from netdae.events.detector import EventDetector
    from netdae.output.metrics import DeploymentMetrics
    from netdae.scenario.closing import ClosingEntry
    from netdae.scenario.restraints import Given
    from netdae.scenario.tether import TetherEntry
    from netdae.system.system import System

EventValue = Annotated[float, Field(ge=-1e12, le=1e12)]  # m, m², N or a ratio


class EventEntry(Section):
    """An instant at which a figure of the flight passes a value or turns, and what is then done."""

    figure: QuantityName = Field(description="What is watched.")
    value: EventValue | None = Field(
        None,
        description="Value that it passes, in m, m², N or as a ratio; some figures have a default or none. At a "
        "maximum or minimum, the least rise or fall before it.",
    )
    at: Place = Field(
        "value", description='Whether at the value, or at a "maximum" or "minimum" of the figure.'
    )
    action: ActionName = Field("none", description="What is done at the event.")
    repeat: bool = Field(False, description="Whether it may happen more than once.")
    name: Text | None = Field(
        None,
        description="What the summary and restraints call it; by default figure and value, mouth_area_4.5.",
    )


def event_with(action: ActionName, entries: Sequence[EventEntry], section: InSection) -> str | None:
    """Name of the event with an action that one event may have; None where there is none.

    Raises InputError, through `section`, for a second one.
    """
    found: str | None = None
    for number, entry in enumerate(entries):
        if entry.action == action:
            with section("events", number):
                if found is not None:
                    raise InputError(f"the event {found!r} has the action {action} already: let one have it")
                found = _event(entry).name
    return found


def event_of(entry: EventEntry, earlier: Sequence[Event] = (), *, has: Collection[Need]) -> Event:
    """The event of an entry; raises InputError for what is wrong with it, or with its name beside earlier ones.

    has : those of `events.event.NEEDS` that the net has
    """
    event = _event(entry)
    check_names([*earlier, event])
    check_needs(event, has)
    return event


def _event(entry: EventEntry) -> Event:
    return Event(
        entry.figure,
        entry.value,
        action=entry.action,
        repeat=entry.repeat,
        name=entry.name or "",
        at=entry.at,
    )


def needs_met(
    system: System,
    metrics: DeploymentMetrics,
    tether: TetherEntry | None,
    closing: Sequence[ClosingEntry],
) -> set[Need]:
    """Those of `events.event.NEEDS` that a net has."""
    has: set[Need] = set()
    if metrics.mouth is not None:
        has.add("mouth")
        if metrics.corners is not None:
            has.add("corners")
    if tether is not None:
        has |= {"tether", "chaser"}
    if (system.strength < math.inf).any():
        has.add("strength")
    if system.body is not None:
        has |= {"target", "contact"}
    if system.obstacles:
        has.add("contact")
    if any(entry.begin is None for entry in closing):
        has.add("closing")
    return has


def detector_of(
    entries: Sequence[EventEntry],
    has: Collection[Need],
    system: System,
    metrics: DeploymentMetrics,
    restraints: Sequence[Given],
    section: InSection,
) -> EventDetector | None:
    """The detector of all events, None where there are none.

    Raises InputError, through `section`, for what is wrong with them, and for restraints at events that are not there.
    """
    from netdae.events.detector import EventDetector

    events: list[Event] = []
    for number, entry in enumerate(entries):
        with section("events", number):
            events.append(event_of(entry, events, has=has))
    for restraint, place, which in restraints:
        with section(place, which):
            for name in restraint.events:
                event_called(name, events, by="lock" if place == "tether" else "begin or until")
    if not events:
        return None
    with section("events"):
        return EventDetector(events, system, mouth=metrics.mouth, corners=metrics.corners)
