"""Reference against result: one small picture of a verification case."""

from __future__ import annotations

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from netdae.runs.verification.case import Picture
from netdae.visual.plotting.drawing import bytes_of
from netdae.visual.plotting.style import look_of, styled


def svg_of(picture: Picture) -> str:
    """The picture as an SVG file: references as lines, results as markers."""
    with styled():
        figure = Figure(figsize=(5.6, 3.0), layout="constrained")
        FigureCanvasAgg(figure)
        axis = figure.add_subplot()
        for number, curve in enumerate(picture.reference):
            look = look_of(number)
            alone = np.size(curve.x) == 1
            axis.plot(
                curve.x,
                curve.y,
                color="0.35" if number else "0.0",
                linestyle=look.line,
                marker="+" if alone else None,
                markersize=12,
                label=curve.label,
            )
        for number, curve in enumerate(picture.found, 1):
            look = look_of(number)
            axis.plot(
                curve.x,
                curve.y,
                color=look.color,
                linestyle="none",
                marker=look.marker,
                markerfacecolor="none",
                label=curve.label,
            )
        axis.set_xlabel(picture.x_label)
        axis.set_ylabel(picture.y_label)
        _widen(axis, picture)
        axis.legend(loc="best")
    return bytes_of(figure, "svg").decode("utf-8")


def _widen(axis: object, picture: Picture) -> None:
    """Give a flat curve a scale by which its round-off is flat."""
    y = np.concatenate([np.ravel(np.asarray(each.y, float)) for each in (*picture.reference, *picture.found)])
    low, high = float(np.nanmin(y)), float(np.nanmax(y))
    least = 0.1 * max(abs(low), abs(high))
    if high - low < least:
        axis.set_ylim((low + high - 2 * least) / 2, (low + high + 2 * least) / 2)  # type: ignore[attr-defined]
