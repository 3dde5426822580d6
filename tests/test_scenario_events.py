"""The section [[events]]: what is written is what is watched, and each mistake has its words."""

from __future__ import annotations

import subprocess
import sys
import tomllib

import pytest
from pydantic import Field, ValidationError

from netdae.core.errors import InputError
from netdae.events.event import NEEDS, Event, event_called
from netdae.scenario.events import EventEntry, event_of
from netdae.scenario.problems import first_problem
from netdae.scenario.section import Section

EVENTS = """\
[[events]]
figure = "largest_mouth_area"
action = "stop"
[[events]]
figure = "mouth_area"
value = 4.5
repeat = true
name = "half open"
[[events]]
figure = "tether_taut"
action = "lock_tether"
[[events]]
figure = "tension_over_strength"
"""


class Holder(Section):
    """A scenario of events only."""

    events: list[EventEntry] = Field([])


def events_of(text, has=tuple(NEEDS)):
    events = []
    for entry in Holder.model_validate(tomllib.loads(text)).events:
        events.append(event_of(entry, events, has=has))
    return events


def test_what_is_written_is_what_is_watched():
    assert events_of(EVENTS) == [
        Event("largest_mouth_area", action="stop"),
        Event("mouth_area", 4.5, repeat=True, name="half open"),
        Event("tether_taut", action="lock_tether"),
        Event("tension_over_strength"),
    ]
    assert events_of(EVENTS)[3].level == 1.0
    assert [event.name for event in events_of(EVENTS)] == [
        "largest_mouth_area",
        "half open",
        "tether_taut",
        "tension_over_strength",
    ]


# what is replaced in EVENTS, by what, and words of the message
OF_THE_FORM = {
    "unknown figure": ('"mouth_area"', '"mouth_aera"', ["figure", "mouth_aera", "did you mean mouth_area?"]),
    "unknown action": ('"lock_tether"', '"lock_tehter"', ["action", "did you mean lock_tether?"]),
    "unknown key": ("repeat = true", "repeats = true", ["repeats is an unknown key", "did you mean repeat?"]),
    "no figure": ('figure = "mouth_area"\n', "", ["figure is missing"]),
    "text for a number": ("value = 4.5", 'value = "4.5"', ["value", "expected a number"]),
    "not finite": ("value = 4.5", "value = inf", ["value", "expected"]),
    "number for a switch": ("repeat = true", "repeat = 1", ["repeat", "expected true or false"]),
    "empty name": ('name = "half open"', 'name = ""', ["name", "expected a name"]),
}


@pytest.mark.parametrize("mistake", OF_THE_FORM)
def test_a_mistake_of_the_form_names_its_key(mistake):
    old, new, words = OF_THE_FORM[mistake]
    assert EVENTS.count(old) == 1
    data = tomllib.loads(EVENTS.replace(old, new))
    with pytest.raises(ValidationError) as error:
        Holder.model_validate(data)
    message = first_problem(error.value, data)
    for each in ["events", *words]:
        assert each in message
    assert "\n" not in message


OF_THE_CONTENT = {
    "no value": ("value = 4.5\n", "", NEEDS, "event 'half open': value is missing: give one in m² for"),
    "a value too much": (
        'action = "lock_tether"',
        "value = 0.1",
        NEEDS,
        "event 'tether_taut_0.1': value is 0.1, but tether_taut takes none: leave it out",
    ),
    "a negative area": ("4.5", "-4.5", NEEDS, "value is -4.5, expected a finite number above 0"),
    "a name twice": (
        '"half open"',
        '"largest_mouth_area"',
        NEEDS,
        "event 'largest_mouth_area': two events have this name, numbers 1 and 2",
    ),
    "no mouth": ("", "", ["tether", "strength"], "figure largest_mouth_area needs a mouth"),
    "no tether": ("", "", ["mouth", "strength"], "figure tether_taut needs a tether: add [tether]"),
    "nothing to lock": (
        '"tether_taut"',
        '"all_slack"',
        ["mouth", "strength"],
        "event 'all_slack': action lock_tether needs a tether",
    ),
    "no strength": ("", "", ["mouth", "tether"], "figure tension_over_strength needs a cord with a strength"),
}


@pytest.mark.parametrize("mistake", OF_THE_CONTENT)
def test_a_mistake_of_the_content_names_the_event(mistake):
    old, new, has, words = OF_THE_CONTENT[mistake]
    with pytest.raises(InputError) as error:
        events_of(EVENTS.replace(old, new) if old else EVENTS, has=has)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_a_restraint_refers_to_an_event_by_its_name():
    events = events_of(EVENTS)
    assert event_called("half open", events, by="[[restraints]] 1 until") is events[1]
    with pytest.raises(InputError, match=r"until: there is no event 'halfopen': did you mean 'half open'"):
        event_called("halfopen", events, by="[[restraints]] 1 until")


def test_the_section_is_read_without_the_heavy_libraries():
    program = "import netdae.scenario.events, sys; print(*[m for m in ('numpy', 'scipy', 'numba') if m in sys.modules])"
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert found.stdout.split() == []
