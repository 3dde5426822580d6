"""The section [[events]] of a scenario file, and the events that it makes."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Annotated

from pydantic import Field

from netdae.events.event import ActionName, Event, FigureName, Need, check_names, check_needs
from netdae.scenario.section import Section, Text

EventValue = Annotated[float, Field(ge=-1e12, le=1e12)]  # m, m², N or a ratio


class EventEntry(Section):
    """An instant at which a figure of the flight passes a value, and what is then done."""

    figure: FigureName = Field(description="What is watched.")
    value: EventValue | None = Field(
        None,
        description="Value that it passes, in m, m², N or as a ratio; some figures have a default or none.",
    )
    action: ActionName = Field("none", description="What is done at the event.")
    repeat: bool = Field(False, description="Whether it may happen more than once.")
    name: Text | None = Field(
        None,
        description="What the summary and restraints call it; by default figure and value, mouth_area_4.5.",
    )


def event_of(entry: EventEntry, earlier: Sequence[Event] = (), *, has: Collection[Need]) -> Event:
    """The event of an entry; raises InputError for what is wrong with it, or with its name beside earlier ones.

    has : those of `events.event.NEEDS` that the net has
    """
    event = Event(entry.figure, entry.value, action=entry.action, repeat=entry.repeat, name=entry.name or "")
    check_names([*earlier, event])
    check_needs(event, has)
    return event
