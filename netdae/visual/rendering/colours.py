"""Colours of a flight's pictures, and the tension at which they end; the same in pictures, movies and pages."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.visual.rendering.frames import KINDS, Cast, Frame

SHARE = 0.98
"""Share of the taut cables that stay below the end of the colours: else a few that snap leave all others one colour."""

STRONG = {"tether": "#0091b3", "closing": "#1a8f45"}
"""Taut tether with its bridle, and closing cord."""
PALE = {"net": "#b4b4b4", "tether": "#9fcfdb", "closing": "#6cbb8a"}
"""Slack cables of each kind."""
BULLET = "#20242b"
HELD = "#3b5bdb"
"""Node that is held or driven."""
CHASER, PANEL = "#aeb6c0", "#1d3f8f"
BODY, AXES = "#c9b78f", ("#d7263d", "#2e8b57", "#1f5fbf")
"""A target, and its axes x, y and z."""
PAPER, INK = "#ffffff", "#22262e"

assert KINDS == tuple(PALE)


def tension_map(count: int = 256) -> FloatArray:
    """Colours (count, 3), 0 to 1, from no tension to the end of the scale: darker is more, also in grey."""
    from matplotlib import colormaps

    # without the yellows, which are lost on white, and the black of bullets
    return np.asarray(colormaps["inferno"](np.linspace(0.78, 0.17, count)))[:, :3]


def peak_of(frames: Sequence[Frame], cast: Cast) -> float:
    """Tension, N, at which the colours end: a round number that `SHARE` of the net's taut cables stay below."""
    own = cast.kind == 0
    found = np.concatenate([frame.tension[own & frame.taut] for frame in frames])
    found = found[found > 0]
    return round_up(float(np.quantile(found, SHARE))) if len(found) else 1.0


def round_up(value: float) -> float:
    """The next number of the form 1, 1.5, 2, 3, 4, 5, 6, 8 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return next(
        float(f"{step * power:.6g}")
        for step in (1, 1.5, 2, 3, 4, 5, 6, 8, 10)
        if step * power >= value * (1 - 1e-9)
    )


def round_down(value: float) -> float:
    """The next smaller number of the form 1, 2, 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return next(float(f"{step * power:.6g}") for step in (5, 2, 1) if step * power <= value * (1 + 1e-9))
