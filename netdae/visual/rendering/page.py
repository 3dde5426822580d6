"""The page: one HTML file in which a flight plays and turns, with its data inside; it loads nothing else.

The data stand in the page as JSON, see `data_of`; the viewer beside this module draws them with WebGL 2.
"""

from __future__ import annotations

import base64
import json
import re
import tomllib
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from netdae.core.arrays import IntArray
from netdae.visual.rendering.camera import View
from netdae.visual.rendering.colours import (
    AXES,
    BODY,
    BULLET,
    CHASER,
    HELD,
    INK,
    PALE,
    PANEL,
    PAPER,
    STRONG,
    tension_map,
)
from netdae.visual.rendering.frames import KINDS, Body, Footage, Frame
from netdae.visual.rendering.scene import axis_length

TEMPLATE = Path(__file__).with_name("page.html")
_FINENESS = 1e-4  # the step over the size of the net, at most: a tenth of a pixel on a screen of a thousand


def page_of(
    footage: Footage,
    shown: Sequence[Frame],
    *,
    view: View,
    follow: bool,
    nodes: IntArray,
    peak: float,
    rate: float,
) -> str:
    """The page of the frames shown, first seen from `view` with `nodes` in sight."""
    data = data_of(footage, shown, peak=peak)
    renumbered = {int(node): place for place, node in enumerate(footage.cast.drawn)}
    data["start"] = {
        "axes": [axis.tolist() for axis in (view.right, view.up, view.toward)],
        "follow": follow,
        "rate": rate,
        "nodes": [renumbered[int(node)] for node in nodes],
    }
    title = _title(footage)
    text = json.dumps({"title": title, **data}, separators=(",", ":")).replace("<", "\\u003c")
    page = TEMPLATE.read_text(encoding="utf-8")
    parts = {"{{title}}": escape(title), "{{data}}": text}
    # in one pass: a title may itself have such a mark
    return re.sub(r"\{\{(?:title|data)\}\}", lambda found: parts[found[0]], page)


def data_of(footage: Footage, shown: Sequence[Frame], *, peak: float) -> dict[str, Any]:
    """What the page holds, ready for JSON.

    step : m; positions are whole multiples of it from the frame's origin, so off by half of it at most
    nodes : numbers in the frames of the nodes that the page has, k
    cables : (m, 2), places in `nodes`; kind : (m,), index into `kinds`; bullets, chaser : places in `nodes`
    peak : N; colours : the colours from 0 to it
    frames : number, time in s, origin in m, positions (k, 3), little-endian 16 or 32 bit integers by `width`,
        tension (m,), bytes: 0 slack, 1 no tension to 255 the peak or more; both in base64; held, places in `nodes` of
        those that are held or driven; largest tension, N; with a target, place in m of the origin of its frame, and
        turn, the matrix of its axes, row after row
    body : of a target, corners of its triangles (3 j, 3), m, in its frame, and lengths of its axes, m; null without one
    """
    cast = footage.cast
    spans = [np.ptp(frame.points[cast.net], axis=0) for frame in shown]
    step = 10.0 ** np.floor(np.log10(max(float(np.linalg.norm(spans, axis=1).max()) * _FINENESS, 1e-9)))
    points = [frame.points[cast.drawn] for frame in shown]
    origins = [step * np.round((x.min(axis=0) + x.max(axis=0)) / 2 / step) for x in points]
    whole = [np.round((x - origin) / step) for x, origin in zip(points, origins, strict=True)]
    width = 16 if max(np.abs(q).max() for q in whole) < 2**15 else 32
    places = np.zeros(cast.drawn.max() + 1, dtype=np.int64)
    places[cast.drawn] = np.arange(len(cast.drawn))
    own = cast.kind == 0
    frames = [
        {
            "number": frame.number,
            "time": frame.t,
            "origin": origin.tolist(),
            "positions": _base64(q.astype(f"<i{width // 8}")),
            "tension": _base64(_bytes(frame, peak)),
            "held": places[frame.held].tolist(),
            "largest": float(f"{frame.tension[own].max(initial=0.0):.4g}"),
            **_pose_of(frame.body),
        }
        for frame, q, origin in zip(shown, whole, origins, strict=True)
    ]
    return {
        "step": step,
        "width": width,
        "decimals": footage.decimals(),
        "nodes": cast.drawn.tolist(),
        "cables": places[cast.cables].tolist(),
        "kinds": list(KINDS),
        "kind": cast.kind.tolist(),
        "bullets": places[cast.bullets].tolist(),
        "chaser": places[cast.chaser].tolist(),
        "mesh": cast.typical_length,
        "body": _surface_of(shown[0].body),
        "peak": peak,
        "colours": {
            "tension": [_hex(rgb) for rgb in tension_map(17)],
            "strong": STRONG,
            "pale": PALE,
            "bullet": BULLET,
            "held": HELD,
            "chaser": CHASER,
            "panel": PANEL,
            "body": BODY,
            "axes": AXES,
            "paper": PAPER,
            "ink": INK,
        },
        "frames": frames,
    }


def _surface_of(body: Body | None) -> dict[str, Any] | None:
    if body is None:
        return None
    own = body.own_points
    corners = own[body.triangles].reshape(-1, 3)
    return {
        "corners": _base64(corners.astype("<f4")),
        "axes": [axis_length(own, axis) for axis in range(3)],
    }


def _pose_of(body: Body | None) -> dict[str, Any]:
    return {} if body is None else {"place": body.origin.tolist(), "turn": body.axes.ravel().tolist()}


def _bytes(frame: Frame, peak: float) -> Any:
    share = np.clip(frame.tension / peak, 0.0, 1.0)
    return np.where(frame.taut, 1 + np.round(254 * share), 0).astype(np.uint8)


def _base64(values: Any) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")


def _hex(rgb: Any) -> str:
    return "#" + "".join(f"{round(255 * float(value)):02x}" for value in rgb)


def _title(footage: Footage) -> str:
    """The title of the run's scenario where there is one, else the folder's name."""
    try:
        title = tomllib.loads((footage.folder / "scenario.toml").read_text(encoding="utf-8"))["title"]
        return str(title)
    except (OSError, ValueError, KeyError):
        return footage.folder.resolve().name
