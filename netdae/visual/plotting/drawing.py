"""Drawing of figures with matplotlib, without a display."""

from __future__ import annotations

import io
import math
import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

import netdae
from netdae.core.arrays import FloatArray
from netdae.visual.plotting.figures import OVERVIEW, Panel, curve_of, heading_of, panels_of
from netdae.visual.plotting.marks import draw_marks, draw_strengths, height_of, mark_labels
from netdae.visual.plotting.runs import FlownRun
from netdae.visual.plotting.style import DPI, cut, filling_of, look_of, styled

_MARKS = 9  # markers along a curve
_LINE = 0.17  # inch, of a line in a legend


def draw(name: str, runs: Sequence[FlownRun]) -> Any:
    """The matplotlib Figure of that name for one run or several; None where no run has anything for it."""
    panels = panels_of(name, runs)
    if not panels:
        return None
    with styled():
        columns = _columns(name, panels, several=len(runs) > 1)
        rows = math.ceil(len(panels) / columns)
        begin, end = _reach_of(runs)
        labels = mark_labels(runs, 0.04 * (end - begin))
        figure, axes = _sheet(panels, rows, columns)
        # a last row that is not full leaves the row above without labels below it
        labelled = (rows - 1 - (len(panels) % columns > 0)) * columns
        words = []
        for number, (panel, axis) in enumerate(zip(panels, axes, strict=True)):
            used = _draw_curves(axis, panel, runs, narrow=columns > 2)
            words.append(used + draw_strengths(axis, panel, runs))
            draw_marks(axis, runs, labels if number < columns else (), (begin + end) / 2)
            axis.set_xlim(begin, end)
            axis.yaxis.get_offset_text().set_horizontalalignment("right")
            axis.set_ylabel(
                panel.axis_label if len(panel.axis_label) <= 24 else f"{panel.label},\n{panel.unit}"
            )
            if number >= labelled:
                axis.set_xlabel("time, s")
            else:
                axis.tick_params(labelbottom=False)
        _scale(panels, axes, words)
        lines = _head(figure, name, runs)
        figure.set_figheight(figure.get_figheight() + _LINE * lines + height_of(labels))
    return figure


def bytes_of(figure: Any, kind: str) -> bytes:
    """The file of a Figure, kind "png" or "svg"; the same bytes for the same figure."""
    about = {"Date": None, "Creator": f"netdae {netdae.__version__}"}
    software = {"Software": f"netdae {netdae.__version__}"}
    stream = io.BytesIO()
    with styled():
        figure.savefig(stream, format=kind, dpi=DPI, metadata=about if kind == "svg" else software)
    return stream.getvalue()


def labels_of(runs: Sequence[FlownRun]) -> list[str]:
    """Legend labels of the runs: title, with the folder where titles are alike, and how far each run came."""
    titles = [run.title for run in runs]
    given = []
    for number, run in enumerate(runs, 1):
        alike = titles.count(run.title) > 1
        words = [f"{number}  {cut(run.title, 60)}"]
        words += [f"in {run.folder}"] if alike else []
        words += [f"mean and range of {run.members}"] if run.members else []
        words += [cut(run.note, 60)] if run.note else []
        given.append(", ".join(words))
    return given


def _columns(name: str, panels: Sequence[Panel], *, several: bool) -> int:
    if name == OVERVIEW:
        return 4 if len(panels) > 9 else min(3, len(panels))
    if several and len(panels) % 3 == 0 and all(panel.same_scale for panel in panels):
        return 3  # x, y, z of a vector beside each other
    return 2 if len(panels) > 3 and several else 1


def _sheet(panels: Sequence[Panel], rows: int, columns: int) -> tuple[Any, list[Any]]:
    """Figure and an axis for each panel, row by row, all with the same time axis."""
    heights = [panel.height for panel in panels] if columns == 1 else [1.0] * rows
    wide = {1: 7.2, 2: 9.6}.get(columns, 4.0 * columns)  # inch
    tall = 0.6 + (2.1 if rows > 1 else 3.0) * sum(heights)
    figure = Figure(figsize=(wide, tall), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(rows, columns, height_ratios=heights)
    axes: list[Any] = []
    for number in range(len(panels)):
        wide_last = columns == 2 and number == len(panels) - 1 and number % 2 == 0
        place = grid[number // columns, :] if wide_last else grid[number // columns, number % columns]
        axes.append(figure.add_subplot(place, sharex=axes[0] if axes else None))
    return figure, axes


def _reach_of(runs: Sequence[FlownRun]) -> tuple[float, float]:
    times = np.concatenate([*(run.time for run in runs), [each.time for run in runs for each in run.marks]])
    begin, end = float(times.min()), float(times.max())
    return (begin, end) if end > begin else (begin, begin + 1e-9)


def _draw_curves(axis: Any, panel: Panel, runs: Sequence[FlownRun], *, narrow: bool) -> int:
    """Draw a line for each run, or each quantity of one run, over its band; return the number of text lines on top."""
    pairs = [(run, quantity) for run in runs for quantity in panel.quantities]
    for number, (run, quantity) in enumerate(pairs):
        curve = curve_of(run, quantity.column)
        if curve is None:
            continue
        look, rows = look_of(number), len(run.time)
        if curve.low is not None and curve.high is not None:
            axis.fill_between(run.time, curve.low, curve.high, color=look.color, alpha=0.22, linewidth=0)
        step = max(1, rows // _MARKS)
        axis.plot(
            run.time,
            curve.values,
            color=look.color,
            linestyle=look.line,
            marker=look.marker if len(pairs) > 1 or len(runs) > 1 else None,
            markevery=((number * step) // max(2, len(pairs)) % step, step),
            markerfacecolor=filling_of(number, look),
            label=quantity.short,
        )
    if len(runs) > 1 or len(pairs) == 1:
        return 0
    if not narrow:
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
        return 0
    columns = 2 if len(pairs) == 4 else 3
    axis.legend(
        loc="upper left", ncols=columns, fontsize=7, handlelength=2.6, columnspacing=1.2, borderaxespad=0.0
    )
    return math.ceil(len(pairs) / columns)


def _scale(panels: Sequence[Panel], axes: Sequence[Any], words: Sequence[int]) -> None:
    """Limits with a margin: round-off about a constant stays a flat line, components of a vector share a scale.

    words : lines of text that each axis has at its top
    """
    drawn = [_drawn_on(axis) for axis in axes]
    for panel, axis, values, lines in zip(panels, axes, drawn, words, strict=True):
        if panel.same_scale:
            alike = [v for other, v in zip(panels, drawn, strict=True) if _same_vector(other, panel)]
            values = np.concatenate(alike)
        if not len(values):
            continue
        low, high = float(values.min()), float(values.max())
        least = max(panel.least_span, 1e-3 * max(abs(low), abs(high)))
        spread = max(high - low, least if low or high else 1.0)
        middle = (low + high) / 2
        axis.set_ylim(middle - 0.56 * spread, middle + (0.56 + 0.11 * lines) * spread)


def _same_vector(one: Panel, other: Panel) -> bool:
    return one.quantities[0].column[:-1] == other.quantities[0].column[:-1]


def _drawn_on(axis: Any) -> FloatArray:
    """Finite heights of the curves, bands and level lines on an axis."""
    parts = [
        np.asarray(line.get_ydata(), float) for line in axis.lines if line.get_transform() == axis.transData
    ]
    parts += [
        np.asarray(line.get_ydata(), float)
        for line in axis.lines
        if line.get_transform() == axis.get_yaxis_transform()
    ]
    parts += [path.vertices[:, 1] for band in axis.collections for path in band.get_paths()]
    values = np.concatenate([*parts, np.empty(0)])
    return values[np.isfinite(values)]


def _head(figure: Any, name: str, runs: Sequence[FlownRun]) -> int:
    """Draw a heading above and, for several runs, a legend below; return how many lines they have."""
    inches = figure.get_figwidth()
    rows = 0
    if len(runs) == 1:
        run = runs[0]
        words = [run.title, *([f"mean and range of {run.members} members"] if run.members else []), run.note]
        heading = ", ".join(word for word in words if word)
    else:
        heading = heading_of(name)
        labels = labels_of(runs)
        wide = 0.6 + 0.072 * max(map(len, labels))  # inch, of line and words
        rows = math.ceil(len(runs) / max(1, int(inches / wide)))
        columns = math.ceil(len(runs) / rows)
        figure.legend(_handles(len(runs)), labels, loc="outside lower left", ncols=columns)
    lines = textwrap.wrap(heading, int(12.5 * inches), max_lines=3, placeholder=" …") or [""]
    figure.suptitle("\n".join(lines), fontsize=10.5, x=0.01, horizontalalignment="left")
    return rows + len(lines)


def _handles(count: int) -> list[Line2D]:
    """Lines of a legend of that many runs."""
    return [
        Line2D(
            [],
            [],
            color=look.color,
            linestyle=look.line,
            marker=look.marker,
            markerfacecolor=filling_of(number, look),
        )
        for number, look in enumerate(map(look_of, range(count)))
    ]
