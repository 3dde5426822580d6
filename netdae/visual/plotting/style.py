"""The look of netdae's pictures: style, colours, lines and markers.

What belongs together is distinguished by line, marker and colour at once, so that a grey print can be read.
"""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Iterator
from typing import Any, NamedTuple

import matplotlib

DPI = 150
"""Of PNG files."""


class CurveStyle(NamedTuple):
    """How a curve is drawn."""

    color: str
    line: Any
    marker: str


# Okabe and Ito's colours, which the colour-blind distinguish, without the yellow that is lost on white paper.
_COLORS: tuple[str, ...] = ("#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
_LINES: tuple[Any, ...] = (
    "-",
    (0, (5, 2)),
    (0, (1, 1.3)),
    (0, (6, 2, 1, 2)),
    (0, (9, 3)),
    (0, (4, 1.5, 1, 1.5, 1, 1.5)),
)
_MARKERS: tuple[str, ...] = tuple("os^DvPX*")

_STYLE = {
    "axes.axisbelow": True,
    "axes.edgecolor": "0.3",
    "axes.formatter.limits": (-3, 4),
    "axes.formatter.useoffset": False,
    "axes.grid": True,
    "axes.labelsize": 9.0,
    "axes.linewidth": 0.7,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "figure.constrained_layout.h_pad": 0.06,
    "figure.constrained_layout.w_pad": 0.06,
    "font.family": "DejaVu Sans",  # comes with matplotlib
    "font.size": 9.0,
    "grid.color": "0.9",
    "grid.linewidth": 0.6,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "legend.handlelength": 3.2,
    "lines.linewidth": 1.3,
    "lines.markersize": 4.0,
    "savefig.facecolor": "white",
    "svg.hashsalt": "netdae",  # otherwise the names inside an SVG are random
    "text.parse_math": False,  # a title may have a $
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
}


@contextlib.contextmanager
def styled() -> Iterator[None]:
    """Netdae's style in place of the user's own; characters that the font lacks are boxes without a warning."""
    with matplotlib.rc_context(), warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_STYLE)
        yield


def look_of(number: int) -> CurveStyle:
    """Style of the curve with that number; no two among the first 168 are alike."""
    return CurveStyle(
        _COLORS[number % len(_COLORS)], _LINES[number % len(_LINES)], _MARKERS[number % len(_MARKERS)]
    )


def filling_of(number: int, look: CurveStyle) -> str:
    """Colour inside the marker of that curve."""
    return "white" if number % 2 else look.color


def cut(text: str, length: int) -> str:
    """The text, shortened to that many characters."""
    return text if len(text) <= length else f"{text[: length - 2].rstrip()} …"
