"""Lines across a figure: events, upright with their names above, and strengths, level."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.visual.plotting.figures import SHARE_OF_STRENGTH, TETHER_TENSION, Panel, curve_of
from netdae.visual.plotting.runs import EventMark, FlownRun, Strength
from netdae.visual.plotting.style import cut, look_of

_SLANT = 25  # degrees, of the names of events
_SMALL: dict[str, Any] = {"fontsize": 7.5, "color": "0.25"}
_UNDER = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}


def draw_marks(
    axis: Any, runs: Sequence[FlownRun], labels: Sequence[tuple[float, str]], middle: float
) -> None:
    """A vertical line at each event, short where it is repeated, in an ensemble with a band; names slant above."""
    for number, run in enumerate(runs):
        look = look_of(number)
        color, line = (look.color, look.line) if len(runs) > 1 else ("0.35", (0, (2, 2)))
        seen: set[str] = set()
        for mark in sorted(run.marks, key=lambda each: each.time):
            foot = 0.93 if mark.name in seen else 0.0
            seen.add(mark.name)
            axis.axvline(mark.time, foot, color=color, linestyle=line, linewidth=0.8, alpha=0.6, zorder=1.5)
            if mark.high > mark.low:
                axis.axvspan(mark.low, mark.high, color=color, alpha=0.12, linewidth=0, zorder=1.0)
    times = [time for time, _ in labels]
    leftward = bool(times) and 2 * middle < min(times) + max(times)  # towards the side that has more room
    for time, words in labels:
        axis.annotate(
            words,
            (time, 1.0),
            (-1 if leftward else 1, 3),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            horizontalalignment="right" if leftward else "left",
            rotation=-_SLANT if leftward else _SLANT,
            rotation_mode="anchor",
            fontsize=7,
            color="0.25",
            annotation_clip=False,
        )


def mark_labels(runs: Sequence[FlownRun], gap: float) -> list[tuple[float, str]]:
    """Names of the events at their first times; those within `gap` of a first one, s, stand together."""
    firsts: list[tuple[float, str, int]] = []
    for number, run in enumerate(runs, 1):
        for name, times in _times_by_name(run.marks).items():
            count = f" ×{len(times)}" if len(times) > 1 else ""
            firsts.append((min(times), cut(name, 40) + count, number))
    groups: list[tuple[float, dict[str, list[int]]]] = []
    for time, words, number in sorted(firsts):
        if not groups or time - groups[-1][0] >= gap:
            groups.append((time, {}))
        groups[-1][1].setdefault(words, []).append(number)
    several = len(runs) > 1
    return [
        (
            time,
            ", ".join(
                f"{words} [{', '.join(map(str, sorted(numbers)))}]" if several else words
                for words, numbers in group.items()
            ),
        )
        for time, group in groups
    ]


def _times_by_name(marks: Sequence[EventMark]) -> dict[str, list[float]]:
    found: dict[str, list[float]] = {}
    for mark in marks:
        found.setdefault(mark.name, []).append(mark.time)
    return found


def draw_strengths(axis: Any, panel: Panel, runs: Sequence[FlownRun]) -> int:
    """Draw a level line at each strength, or a text for one far above the curves; return how many are texts."""
    column = panel.quantities[0].column
    share = column == SHARE_OF_STRENGTH
    if column not in ("max_tension", TETHER_TENSION, SHARE_OF_STRENGTH):
        return 0
    peaks = [float(np.nanmax(_all_of(run, panel), initial=0.0)) for run in runs]
    beyond: list[str] = []
    for strength, words in _named_strengths(runs, lowest=share):
        if column == TETHER_TENSION and strength.cables != "tether":
            continue
        if not share and strength.force > 3.0 * max(peaks) > 0.0:
            beyond.append(words)
            continue
        axis.axhline(
            1.0 if share else strength.force, color="0.25", linewidth=1.0, linestyle=(0, (8, 2, 2, 2))
        )
        axis.annotate(
            words,
            (0.995, 1.0 if share else strength.force),
            (0, 2),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            horizontalalignment="right",
            **_SMALL,
        )
    for line, words in enumerate(beyond):
        axis.annotate(
            f"{words}, above this scale",
            (0.99, 1.0),
            (0, -3 - 10 * line),
            xycoords="axes fraction",
            textcoords="offset points",
            horizontalalignment="right",
            verticalalignment="top",
            bbox=_UNDER,
            **_SMALL,
        )
    return len(beyond)


def _named_strengths(runs: Sequence[FlownRun], *, lowest: bool) -> list[tuple[Strength, str]]:
    """Each strength once, and a text that says whose it is."""
    owners: dict[Strength, list[int]] = {}
    for number, run in enumerate(runs, 1):
        chosen = sorted(run.strengths, key=lambda each: each.force)
        for strength in chosen[:1] if lowest else chosen:
            owners.setdefault(strength, []).append(number)
    named = []
    for strength, numbers in owners.items():
        words = f"strength {strength.force:.4g} N"
        if strength.cables != "all":
            words += f" of {strength.cables}"
        if len(numbers) < len(runs):
            words += f" [{', '.join(map(str, numbers))}]"
        named.append((strength, words))
    return named


def _all_of(run: FlownRun, panel: Panel) -> FloatArray:
    """All finite values of a run in a panel, bands and all."""
    curves = [curve_of(run, quantity.column) for quantity in panel.quantities]
    parts = [part for curve in curves if curve is not None for part in curve if part is not None]
    values = np.concatenate([*parts, np.empty(0)])
    return values[np.isfinite(values)]


def height_of(labels: Sequence[tuple[float, str]]) -> float:
    """Height of slanted names, inch."""
    letter = 0.056  # inch, of a name's mean letter
    return max((len(words) * letter * math.sin(math.radians(_SLANT)) for _, words in labels), default=0.0)
