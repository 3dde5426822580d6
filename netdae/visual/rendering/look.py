"""The look: how a flight is viewed, in pictures, movies and pages alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from netdae.core.errors import InputError
from netdae.visual.rendering.camera import CAMERAS, CameraKind, view_of

FITS = ("all", "net")

SMALLEST, LARGEST = 64, 8192
"""Pixels of a side."""


@dataclass(frozen=True)
class Look:
    """How a flight is viewed.

    view : "oblique", "x", "y", "z", or a vector towards the eye; z is up
    camera : "follow" keeps what is in sight in the middle, "still" stands and sees the whole way
    fit : what has to be in sight: "all", with tether and chaser, or the "net" alone
    size : width and height of the whole picture, pixels; None for one that suits what is in sight
    peak : N, the tension at which the colours end; None for one that 98 % of the taut cables stay below

    Raises InputError for values that are none of these.
    """

    view: str | tuple[float, float, float] = "oblique"
    camera: CameraKind = "follow"
    fit: str = "all"
    size: tuple[int, int] | None = None
    peak: float | None = None

    def __post_init__(self) -> None:
        view_of(self.view)
        for name, known in (("camera", CAMERAS), ("fit", FITS)):
            if getattr(self, name) not in known:
                raise InputError(f"{name} {getattr(self, name)!r} is unknown: give {' or '.join(known)}")
        if self.size is not None and not all(SMALLEST <= side <= LARGEST for side in self.size):
            raise InputError(
                f"size {self.size[0]},{self.size[1]} is out of range: give {SMALLEST} to {LARGEST} pixels for each side"
            )
        if self.peak is not None and not (np.isfinite(self.peak) and self.peak > 0):
            raise InputError(f"peak {self.peak:g} N is no end for the colours: give a number above zero")
