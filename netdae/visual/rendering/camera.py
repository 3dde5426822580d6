"""The camera: from where a flight is seen, and how much of it.

The projection is parallel: a length across the view has one scale everywhere, m per pixel, so a scale bar is true.
Symbols: right, up, toward (3,): unit vectors of the picture, toward the eye.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import InputError
from netdae.visual.rendering.frames import Frame

VIEWS: Mapping[str, tuple[float, float, float]] = {
    "oblique": (0.95, -1.4, 0.7),
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
}
"""Named directions towards the eye."""

CameraKind = Literal["follow", "still"]
CAMERAS: tuple[CameraKind, ...] = ("follow", "still")


@dataclass(frozen=True, eq=False)
class View:
    """Three unit vectors (3,): to the right and up in the picture, and towards the eye."""

    right: FloatArray
    up: FloatArray
    toward: FloatArray

    def seen(self, points: FloatArray) -> FloatArray:
        """Coordinates to the right, up, and toward the eye, (n, 3), m."""
        return points @ np.column_stack([self.right, self.up, self.toward])


def view_of(direction: str | Sequence[float]) -> View:
    """View from a name of `VIEWS`, or from a vector towards the eye; z is up, y where one looks along z."""
    if isinstance(direction, str):
        if direction not in VIEWS:
            raise InputError(
                f"view {direction!r} is unknown: give {', '.join(VIEWS)}, or a vector towards the eye as 1,-2,0.5"
            )
        direction = VIEWS[direction]
    vector = np.asarray(direction, dtype=np.float64)
    size = np.linalg.norm(vector)
    if vector.shape != (3,) or not np.isfinite(size) or size == 0:
        raise InputError(f"view {list(direction)} is no direction: give three finite numbers, not all zero")
    toward = vector / size
    right = np.cross((0.0, 0.0, 1.0), toward)
    if np.linalg.norm(right) < 1e-6:
        right = np.cross((0.0, 1.0, 0.0), toward)
    right /= np.linalg.norm(right)
    return View(right, np.cross(toward, right), toward)


@dataclass(frozen=True, eq=False)
class Shot:
    """What one picture sees: its middle (3,) in m, m per pixel, width and height in pixels, depth in m."""

    view: View
    centre: FloatArray
    scale: float
    size: tuple[int, int]
    depth: float

    def pixels(self, points: FloatArray) -> FloatArray:
        """Columns and rows, (n, 2), at which points appear, from the upper left corner."""
        across, up, _ = self.view.seen(points - self.centre).T / self.scale
        return np.column_stack([self.size[0] / 2 + across, self.size[1] / 2 - up])


@dataclass(frozen=True, eq=False)
class Extent:
    """What the camera has to hold: lower and upper corner of each frame in the view's coordinates, (k, 3), m."""

    view: View
    low: FloatArray
    high: FloatArray

    @property
    def spans(self) -> FloatArray:
        """Width, height and depth that hold every frame, (3,), m, above zero."""
        spans = (self.high - self.low).max(axis=0)
        return np.maximum(spans, max(1e-3 * float(spans.max()), 1e-9))

    def aspect(self) -> float:
        """Height over width."""
        return float(self.spans[1] / self.spans[0])

    def shots(self, size: tuple[int, int], *, room: float) -> list[Shot]:
        """A shot of each frame, `room` pixels wider than what is in sight at each edge; all have one scale."""
        wide, high, deep = self.spans
        room = min(room, 0.3 * min(size))
        scale = float(max(wide / (size[0] - 2 * room), high / (size[1] - 2 * room)))
        axes = np.stack([self.view.right, self.view.up, self.view.toward])
        return [
            Shot(self.view, centre @ axes, scale, size, float(deep)) for centre in (self.low + self.high) / 2
        ]


def extent_of(frames: Sequence[Frame], nodes: IntArray, *, view: View, camera: CameraKind) -> Extent:
    """What the camera has to hold so that `nodes`, and the target, are in sight in every frame.

    "follow": the middle of the nodes stays in the middle of the picture; "still": the camera stands, and sees
    the whole way.
    """
    seen = [view.seen(frame.in_sight(nodes)) for frame in frames]
    low = np.stack([points.min(axis=0) for points in seen])
    high = np.stack([points.max(axis=0) for points in seen])
    if camera == "still":
        low[:], high[:] = low.min(axis=0), high.max(axis=0)
    return Extent(view, low, high)
