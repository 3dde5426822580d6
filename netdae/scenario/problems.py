"""What is wrong in a scenario file, in one line that names section and key.

A place is the way to a problem: keys and indices, for instance ("loads", 1, "force", 0).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from difflib import get_close_matches
from typing import Any

from pydantic import ValidationError

from netdae.core.errors import InputError

Place = Sequence[int | str]

InSection = Callable[..., AbstractContextManager[None]]
"""Called with a section's name, and number, it reports errors by them."""

ARRAYS = (
    "material",
    "masses",
    "restraints",
    "initial.ejection",
    "loads",
    "events",
    "closing",
    "pulleys",
    "target.parts",
    "obstacles",
)
"""Sections that may stand several times, in double brackets."""

_EXPECTED = {
    "float_type": "a number",
    "int_type": "a whole number",
    "string_type": "text in quotes",
    "bool_type": "true or false",
    "tuple_type": "three numbers in brackets",
    "finite_number": "a finite number",
    "string_too_short": "a name",
    "missing": "three numbers in brackets",
    "too_long": "three numbers in brackets",
}
_BOUNDS = {
    "greater_than": ("gt", "a number above {:g}"),
    "greater_than_equal": ("ge", "{:g} or more"),
    "less_than_equal": ("le", "{:g} or less"),
}


def first_problem(error: ValidationError, data: Mapping[str, Any]) -> str:
    """The first problem that the check of a scenario's `data` found, in one line."""
    problem = error.errors()[0]
    kind, context, found = problem["type"], problem.get("ctx", {}), problem["input"]
    place = _place_of(problem["loc"], data)
    if kind == "unknown_key":
        return _unknown(place, context["key"], context["known"], data)
    if kind == "missing_key":
        return _missing(place, context["key"], context["what"])
    if kind == "union_tag_invalid" and isinstance(found, dict):
        return _wrong_kind(place, found, context["expected_tags"])
    if kind in ("model_type", "list_type", "union_tag_invalid"):
        return f"{_words_of(place)} is {_shown(found)}, expected {_form_of(place)}"
    if kind == "too_short":
        return f"{_words_of(place)} is empty: a scenario needs one at least"
    if kind in ("missing", "too_long"):  # numbers of a vector
        place = [step for step in place if isinstance(step, str) or step != place[-1]]
        found = _at(place, data)
    if kind == "literal_error":
        expected = f"{context['expected']}{_nearest(found, context['expected'])}"
    elif kind in _BOUNDS:
        limit, words = _BOUNDS[kind]
        expected = words.format(context[limit])
    elif kind == "float_type" and isinstance(found, int) and not isinstance(found, bool):
        expected = "a number that double precision holds"
    elif kind in ("float_type", "int_type") and isinstance(found, str) and _is_number(found):
        expected = f"{_EXPECTED[kind]}: leave the quotes out"
    else:
        expected = _EXPECTED.get(kind, problem["msg"])
    return f"{_words_of(place)} is {_shown(found)}, expected {expected}"


def _place_of(loc: Place, data: Any) -> list[int | str]:
    """The place of a problem in the data, without the tags by which pydantic distinguish alternatives."""
    place: list[int | str] = []
    here = data
    for step in loc:
        is_tag = isinstance(here, dict) and step == here.get("kind") and step not in here
        if is_tag or (isinstance(step, str) and step.startswith("<")):
            continue
        place.append(step)
        here = _at([step], here)
    return place


def _at(place: Place, data: Any) -> Any:
    for step in place:
        try:
            data = data[step]
        except (TypeError, KeyError, IndexError):
            return None
    return data


def _section_of(place: Place) -> tuple[str, list[int | str]]:
    """Header of the section that a place lies in, with its number where it has one, and the keys inside."""
    keys = list(place)
    name = str(keys.pop(0))
    if keys and f"{name}.{keys[0]}" in ARRAYS:
        name = f"{name}.{keys.pop(0)}"
    if name not in ARRAYS:
        return f"[{name}]", keys
    number = f" {int(keys.pop(0)) + 1}" if keys and isinstance(keys[0], int) else ""
    return f"[[{name}]]{number}", keys


def _words_of(place: Place) -> str:
    """A place in words: `[net] side`, `[[loads]] 2 force, number 1`."""
    if list(place) in ([], ["title"]):
        return "".join(map(str, place))
    header, keys = _section_of(place)
    names = ".".join(key for key in keys if isinstance(key, str))
    number = f", number {int(keys[-1]) + 1}," if keys and isinstance(keys[-1], int) else ""
    return " ".join(part for part in (header, names) if part) + number


def _form_of(place: Place) -> str:
    header, keys = _section_of(place)
    if keys:
        return "a table in braces"
    if header.startswith("[["):
        return f"double brackets: write {header.split(' ')[0]} and its keys in the lines below"
    return f"a section: write {header.split(' ')[0]} and its keys in the lines below"


def _unknown(place: Place, key: str, known: list[str], data: Mapping[str, Any]) -> str:
    if list(place) == ["net"] and key == "file":
        return "[net] has kind and file: give the one for a pattern or the other for a mesh file, not both"
    near = get_close_matches(key, known, n=1, cutoff=0.65)
    hint = f"did you mean {near[0]}? " if near else ""
    if place:
        return f"{_words_of(place)} {key} is an unknown key: {hint}{_words_of(place)} may have {', '.join(known)}"
    value = data[key]
    is_array = isinstance(value, list) and any(isinstance(each, dict) for each in value)
    name = f"[[{key}]]" if is_array else f"[{key}]" if isinstance(value, dict) else key
    what = "key before the first section" if name == key else "section"
    return f"{name} is an unknown {what}: {hint}A scenario may have {', '.join(known)}"


def _missing(place: Place, key: str, what: str | None) -> str:
    what = "it is required" if what is None else what.removesuffix(".")
    if place:
        return f"{_words_of(place)} {key} is missing: {what}"
    return f"{_section_of([key])[0]} is missing, every scenario needs this section: {what}"


def _wrong_kind(place: Place, section: Mapping[str, Any], expected_tags: str) -> str:
    tags = [tag.strip(" '") for tag in expected_tags.split(",")]
    kinds = ", ".join(tag for tag in tags if not tag.startswith("<"))
    if "kind" in section:
        nearest = _nearest(section["kind"], kinds)
        return f"{_words_of(place)} kind is {_shown(section['kind'])}, expected one of {kinds}{nearest}"
    other = "file, or " if "<file>" in tags else ""
    return f"{_words_of(place)} kind is missing: give {other}kind, one of {kinds}"


def _nearest(found: Any, expected: str) -> str:
    names = [name.strip(" '") for name in expected.replace(" or ", ",").split(",")]
    near = get_close_matches(found, names, n=1, cutoff=0.6) if isinstance(found, str) else []
    return f": did you mean {near[0]}?" if near else ""


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'the text "{_cut(value)}"'
    if isinstance(value, dict):
        return "a single table"
    if isinstance(value, list) and any(isinstance(each, dict) for each in value):
        return "a list of tables"
    return _cut(str(value))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _cut(text: str) -> str:
    text = " ".join(text.split())
    return text if len(text) <= 60 else f"{text[:57]}..."


def section_in_words(name: str, number: int | None = None) -> str:
    """How a scenario's author calls a section, by its number from 0 where there are several: `[[loads]] 2`."""
    title = f"[[{name}]]" if name in ARRAYS else f"[{name}]"
    return title if number is None else f"{title} {number + 1}"


def bare(error: InputError) -> str:
    """The message without the kind of thing in front, where section or file say it already."""
    return re.sub(
        r"^(material|dashpot|rayleigh|table|motion|pulse|spin|tether|reel|closing|pulleys|rings|target|contact): ",
        "",
        str(error),
    )
