"""What a figure needs of a run or an ensemble, read from its output folder: curves, bands, events, strengths."""

from __future__ import annotations

import json
import math
import os
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.core.files import reason_of
from netdae.output.metrics import COLUMNS
from netdae.runs.folder import FILES, FINISHED, METRICS, SCENARIO, SUMMARY


class Curve(NamedTuple):
    """A column over time, each (k,); `low` and `high`, of an ensemble's smallest and largest member, or None."""

    values: FloatArray
    low: FloatArray | None = None
    high: FloatArray | None = None


class EventMark(NamedTuple):
    """An event that happened, times in s; of an ensemble `time` is the mean of the members, `low` to `high` all."""

    name: str
    time: float
    low: float
    high: float


class Strength(NamedTuple):
    """A breaking force in N, and the cables that have it."""

    cables: str
    force: float


@dataclass(frozen=True, eq=False)
class FlownRun:
    """A run or an ensemble as far as it has come.

    title, status : of its summary; where there is none, of its scenario, and "unfinished"
    time : (k,), s, two rows or more
    curves : column of metrics.csv to its `Curve`; of an ensemble without _mean, _min, _max
    members : how many an ensemble has, 0 for a run
    """

    folder: Path
    title: str
    status: str
    time: FloatArray
    curves: Mapping[str, Curve]
    members: int
    marks: tuple[EventMark, ...]
    strengths: tuple[Strength, ...]

    @property
    def note(self) -> str:
        """What a reader has to know about a run that did not come to its end, "" for one that did."""
        if self.status == FINISHED:
            return ""
        if self.members:
            return self.status
        return f"{self.status.split(':')[0]} at t = {self.time[-1]:.4g} s"


def read_run(folder: str | os.PathLike[str]) -> FlownRun:
    """The run or ensemble in a folder; one that failed, was stopped or is under way as far as its rows go.

    Raises InputError for a folder that has none, and where there are fewer than two rows.
    """
    path = Path(folder)
    _check_folder(path)
    table = _read_rows(path / METRICS)
    summary = _read_summary(path / SUMMARY)
    scenario = _read_scenario(path / SCENARIO)
    ensemble = summary.get("ensemble")
    of_ensemble = "mouth_area_mean" in table
    members = int(ensemble["finished"]) if of_ensemble and isinstance(ensemble, dict) else int(of_ensemble)
    return FlownRun(
        folder=path,
        title=_clean(summary.get("title") or scenario.get("title") or path.resolve().name),
        status=_clean(summary.get("status") or "unfinished"),
        time=table.pop("time"),
        curves=_curves_of(table, of_ensemble=of_ensemble),
        members=members,
        marks=_ensemble_marks(path, summary) if of_ensemble else _marks_of(summary),
        strengths=_strengths_of(scenario),
    )


def _check_folder(path: Path) -> None:
    what = "give the output folder of a run or an ensemble"
    if not os.path.exists(path):  # also of a name that no folder can have
        raise InputError(f"{path}: there is no such folder: {what}")
    if not os.path.isdir(path):
        raise InputError(f"{path} is a file: {what}")
    if (path / METRICS).is_file():
        return
    if any((path / name).exists() for name in FILES):
        raise InputError(f"{path} has no {METRICS}: nothing was flown into it yet, so run its scenario first")
    raise InputError(f"{path} is not the output folder of a run, it has no {METRICS}: {what}")


def _read_rows(path: Path) -> dict[str, FloatArray]:
    """Columns of metrics.csv by name, (k,) each; a last line that is cut short, as a kill leaves it, is left out."""
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path} cannot be read: {reason_of(error)}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is not the table of a run: {error}") from error
    if not text.strip():
        raise InputError(f"{path} is empty: the run has written nothing yet, so wait for it or run it again")
    header, *lines = text.split("\n")
    lines.pop()  # what follows the last line's end: nothing, or a row that was not written whole
    names = header.strip().split(",")
    known = {name for column in COLUMNS for name in (column, f"{column}_mean")}
    if names[0] != "time" or not known.intersection(names[1:]) or len({*names}) < len(names):
        raise InputError(
            f"{path}: its first line is {_short(header)!r}, expected that of a run, {COLUMNS[0]},..."
        )
    rows = [
        _numbers_in(line, len(names), f"{path}: line {k}") for k, line in enumerate(lines, 2) if line.strip()
    ]
    if len(rows) < 2:
        found = f"one row, at t = {rows[0][0]:.4g} s" if rows else "no rows"
        raise InputError(
            f"{path} has {found}: a plot needs two rows or more, so fly further or write more frames"
        )
    table = dict(zip(names, np.array(rows, dtype=np.float64).T.copy(), strict=True))
    if not np.isfinite(table["time"]).all():
        raise InputError(f"{path} has a time that is not a finite number: run it again")
    return table


def _numbers_in(line: str, count: int, where: str) -> list[float]:
    fields = line.split(",")
    if len(fields) != count:
        raise InputError(f"{where} has {len(fields)} fields, expected {count} as in the header: run it again")
    try:
        return [float(field) for field in fields]
    except ValueError as error:
        raise InputError(f"{where}: {error}: run it again") from None


def _read_summary(path: Path) -> dict[str, Any]:
    """The summary, empty where there is none yet."""
    try:
        given = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise InputError(f"{path} cannot be read: {reason_of(error)}") from error
    except ValueError as error:
        raise InputError(f"{path} is not JSON: {error}: remove it to plot the rows alone") from error
    if not isinstance(given, dict):
        raise InputError(f"{path} is not the summary of a run: remove it to plot the rows alone")
    return given


def _read_scenario(path: Path) -> dict[str, Any]:
    """The scenario's copy; empty where it is not there or not TOML, for title and strengths alone are taken."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def _curves_of(table: Mapping[str, FloatArray], *, of_ensemble: bool) -> dict[str, Curve]:
    if not of_ensemble:
        return {name: Curve(values) for name, values in table.items()}
    names = [name.removesuffix("_mean") for name in table if name.endswith("_mean")]
    return {
        name: Curve(table[f"{name}_mean"], table.get(f"{name}_min"), table.get(f"{name}_max"))
        for name in names
    }


def _times_of(summary: Mapping[str, Any]) -> list[tuple[str, float]]:
    """Name and time in s of each event that happened."""
    records = summary.get("events")
    if not isinstance(records, list):
        return []
    return [
        (_clean(record.get("name") or "event"), float(record["time"]))
        for record in records
        if isinstance(record, dict) and isinstance(record.get("time"), int | float)
    ]


def _marks_of(summary: Mapping[str, Any]) -> tuple[EventMark, ...]:
    return tuple(EventMark(name, time, time, time) for name, time in _times_of(summary))


def _ensemble_marks(path: Path, summary: Mapping[str, Any]) -> tuple[EventMark, ...]:
    """Events of the members, each at its first time in a member."""
    members = summary.get("members")
    names = [
        str(member.get("folder"))
        for member in (members if isinstance(members, list) else [])
        if isinstance(member, dict) and member.get("status") == FINISHED
    ]
    firsts: dict[str, list[float]] = {}
    for name in names:
        of_member: dict[str, float] = {}
        for event, time in _times_of(_read_summary(path / name / SUMMARY)):
            of_member.setdefault(event, time)
        for event, time in of_member.items():
            firsts.setdefault(event, []).append(time)
    return tuple(
        EventMark(name, sum(times) / len(times), min(times), max(times)) for name, times in firsts.items()
    )


def _strengths_of(scenario: Mapping[str, Any]) -> tuple[Strength, ...]:
    """Strengths of [[material]] and [tether], in their order; a later entry for the same cables overrides."""
    materials, tether = scenario.get("material"), scenario.get("tether")
    entries: Sequence[Any] = materials if isinstance(materials, list) else []
    if isinstance(tether, dict):
        entries = [*entries, {**tether, "cables": "tether"}]
    found: dict[str, float] = {}
    for entry in entries:
        force = entry.get("strength") if isinstance(entry, dict) else None
        if isinstance(force, int | float) and math.isfinite(force) and force > 0:
            found[_clean(entry.get("cables", "all"))] = float(force)
    return tuple(Strength(cables, force) for cables, force in found.items())


def _clean(text: Any) -> str:
    """One line without characters that no picture can show."""
    return "".join(sign if sign.isprintable() else " " for sign in str(text)).strip()


def _short(text: str, length: int = 40) -> str:
    return text if len(text) <= length else f"{text[:length]}..."
