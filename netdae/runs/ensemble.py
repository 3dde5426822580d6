"""Ensembles: slightly disturbed starts, and statistics over their flights.

Symbols: N members, n nodes, x positions (n, 3) in m.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from netdae.core.arrays import BoolArray, FloatArray
from netdae.core.errors import InputError
from netdae.initial.disturbed import disturbed
from netdae.model.state import State

STATISTICS = ("mean", "std", "min", "max")
"""What is reported of a figure besides n, the number of members that have it."""

CABLE = "_cable"
"""Ending of figures that are the number of a cable: they have no mean."""

_NUMBER = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?")


@dataclass(frozen=True)
class Ensemble:
    """N starts with disturbed positions.

    size : N, 2 or more
    perturb : standard deviation of the normal disturbance of each coordinate, m
    seed : zero or more; member k is drawn from (seed, k), independently of the other members
    scatter : whether each member draws its own errors of the ejection too, from the seed of the scenario's spread and k

    Raises InputError for values out of range.
    """

    size: int
    perturb: float = 1e-9
    seed: int = 0
    scatter: bool = False

    def __post_init__(self) -> None:
        if self.size < 2:
            raise InputError(f"ensemble is {self.size}: give 2 or more members")
        if not (math.isfinite(self.perturb) and self.perturb >= 0):
            raise InputError(f"perturb is {self.perturb:g} m: give a finite number, zero or more")
        if self.seed < 0:
            raise InputError(f"seed is {self.seed}: give a whole number, zero or more")

    def start(self, member: int, start: State, restrained: BoolArray) -> State:
        """`start` as that member has it; restrained axes, (n, 3), stay where they are."""
        return disturbed(start, self.perturb, (self.seed, member), restrained)


def statistics_of(values: Iterable[float | None]) -> dict[str, float]:
    """n, mean, std, min, max of the values that are finite numbers; nan where n is too small.

    std : of the sample, with n − 1
    """
    known = np.array([value for value in values if value is not None], dtype=np.float64)
    known = known[np.isfinite(known)]
    mean, std, low, high = (float(row[0]) for row in _statistics(known[:, None]))
    return {"n": len(known), "mean": mean, "std": std, "min": low, "max": high}


def figures_over(members: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Statistics of each number in the members' figures, by its name.

    For a cable's number, see `CABLE`, n and `members` are reported: each number that occurs, and in how many members.
    """
    names = dict.fromkeys(name for figures in members for name in figures)
    result: dict[str, dict[str, Any]] = {}
    for name in names:
        values = [figures[name] for figures in members if name in figures]
        if not all(value is None or _is_number(value) for value in values):
            continue
        if name.endswith(CABLE):
            result[name] = {"n": len(values), "members": dict(sorted(Counter(values).items()))}
        else:
            result[name] = statistics_of(values)
    return result


def events_over(members: Sequence[Sequence[Mapping[str, Any]]]) -> list[dict[str, Any]]:
    """Statistics of the time at which each event first happens in a member, over the members' records of events.

    n : how many members had it; of : how many there are
    """
    result: dict[str, dict[str, Any]] = {}
    times: dict[str, list[float | None]] = {}
    for records in members:
        firsts: dict[str, float | None] = {}
        for record in records:
            result.setdefault(
                record["name"], {key: record[key] for key in ("name", "figure", "value", "action")}
            )
            firsts.setdefault(record["name"], record["time"])
        for name, time in firsts.items():
            times.setdefault(name, []).append(time)
    return [
        {**event, "of": len(members), "time": statistics_of(times[name])} for name, event in result.items()
    ]


def bands_of(tables: Sequence[Mapping[str, FloatArray]]) -> dict[str, FloatArray]:
    """Mean and band over the members' tables, column name to (k,), which share their column `time`.

    Each other column gives its name with _mean, _std, _min and _max, (k,).
    """
    bands = {"time": tables[0]["time"]}
    for name in tables[0]:
        if name != "time":
            rows = _statistics(np.array([table[name] for table in tables]))
            bands |= {f"{name}_{part}": row for part, row in zip(STATISTICS, rows, strict=True)}
    return bands


def common_warnings(warnings: Mapping[str, Sequence[str]]) -> list[str]:
    """Warnings of the members, by their name; those that differ only in numbers are reported once."""
    alike: dict[str, list[tuple[str, str]]] = {}
    for name, texts in warnings.items():
        for text in texts:
            alike.setdefault(_NUMBER.sub("#", text), []).append((name, text))
    result = []
    for group in alike.values():
        name, text = group[0]
        result.append(
            f"in {len({each for each, _ in group})} of {len(warnings)} members, first {name}: {text}"
        )
    return result


def _statistics(values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Mean, std, min, max (k,) over the rows of (N, k)."""
    count, k = values.shape
    unknown = np.full(k, np.nan)
    if count == 0:
        return unknown, unknown, unknown, unknown
    low = values.min(axis=0)
    above = values - low  # members that agree have exactly their value as mean, and no band
    std = above.std(axis=0, ddof=1) if count > 1 else unknown
    return low + above.mean(axis=0), std, low, values.max(axis=0)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
