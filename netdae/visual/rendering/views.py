"""Pictures, contact sheets, movies and pages of a flight, from the frames in a run's folder.

Drawn off-screen: no display is needed. Frames are given by their number in the series, from 0.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from netdae.core.arrays import IntArray
from netdae.core.errors import InputError
from netdae.core.files import reason_of, write_whole
from netdae.visual.rendering.camera import Extent, Shot, extent_of, view_of
from netdae.visual.rendering.colours import peak_of
from netdae.visual.rendering.frames import Footage, Frame, read_footage
from netdae.visual.rendering.labels import Footer, font_size, footer_height, framed, time_text, with_time
from netdae.visual.rendering.look import Look
from netdae.visual.rendering.movie_file import MOVIE_ENDINGS, best_ending, check_ending, write_movie
from netdae.visual.rendering.page import page_of
from netdae.visual.rendering.scene import Stage, room_for

PICTURE, SHEET, MOVIE, PAGE = "picture.png", "sheet.png", "movie", "flight.html"
"""Names in the run's folder of what is written where no file is given; the movie's gets its ending."""

MOST_IN_SHEET = 100
RATE = 20.0
"""Frames a second."""

_WIDTH, _SHEET_WIDTH, _MOVIE_WIDTH = 1280, 1600, 800  # pixels
_FLATTEST, _STEEPEST = 0.4, 0.85  # height over width of a panel whose size is not given

Tell = Callable[[int, int], None]
"""Called with the number of frames drawn and the total."""


@dataclass(frozen=True)
class Rendering:
    """What was written: the file, and the numbers and times, s, of the frames in it."""

    file: Path
    frames: tuple[int, ...]
    times: tuple[float, ...]


def render_picture(
    folder: str | os.PathLike[str],
    file: str | os.PathLike[str] | None = None,
    *,
    frame: int | None = None,
    time: float | None = None,
    look: Look | None = None,
) -> Rendering:
    """Write a PNG of one frame.

    folder : output folder of a run; file : by default picture.png in it
    frame : number of the frame, or time : s, the nearest is taken; by default that of the largest mouth

    Raises InputError where there is no such frame, a frame is damaged, or the file cannot be written.
    """
    footage = read_footage(folder)
    target = _target(footage, file, PICTURE, (".png",))
    if frame is not None and time is not None:
        raise InputError("frame and time are both given: give one of them")
    if frame is None:
        frame = footage.widest() if time is None else footage.at(time)
    picture = next(_pictures(footage, [footage.frame(frame)], look or Look(), width=_WIDTH))
    return _written(footage, target, [frame], _png(picture))


def render_sheet(
    folder: str | os.PathLike[str],
    file: str | os.PathLike[str] | None = None,
    *,
    frames: Sequence[int] | None = None,
    count: int = 6,
    look: Look | None = None,
) -> Rendering:
    """Write a PNG of several frames side by side, all on one scale: those given, or `count` evenly spread ones.

    folder : output folder of a run; file : by default sheet.png in it

    Raises InputError where there is no such frame, a frame is damaged, or the file cannot be written.
    """
    footage, look = read_footage(folder), look or Look()
    target = _target(footage, file, SHEET, (".png",))
    if frames is None:
        if count < 1:
            raise InputError(f"a sheet of {count} frames is empty: give 1 to {MOST_IN_SHEET}")
        frames = footage.spread(count)
    if len(frames) > MOST_IN_SHEET or count > MOST_IN_SHEET:
        raise InputError(
            f"a sheet of {max(count, len(frames))} frames is too large: give 1 to {MOST_IN_SHEET}, or make a movie"
        )
    shown = _read(footage, frames)
    extent = _extent(footage, shown, look)
    columns = _columns(len(shown))
    rows = -(-len(shown) // columns)
    size = look.size or _suited(extent, _SHEET_WIDTH, columns=columns, rows=rows)
    panel = _panel((size[0], size[1]), columns=columns, rows=rows)
    peak = look.peak or peak_of(shown, footage.cast)
    sheet = Image.new("RGB", (size[0], size[1] - footer_height(size[0])), "white")
    held = _any_held(shown)
    shots = extent.shots(panel, room=room_for(footage.cast, panel, held=held))
    letters = min(0.8 * font_size(size[0]), panel[0] / 12)
    for place, image in enumerate(_panels(footage, shown, shots, peak=peak, letters=letters)):
        sheet.paste(image, (place % columns * panel[0], place // columns * panel[1]))
    footer = Footer(footage.cast, shots[0].scale, peak, held).draw(size[0])
    return _written(footage, target, frames, _png(framed(sheet, footer)))


def render_movie(
    folder: str | os.PathLike[str],
    file: str | os.PathLike[str] | None = None,
    *,
    frames: Sequence[int] | None = None,
    rate: float = RATE,
    look: Look | None = None,
    report: Tell | None = None,
) -> Rendering:
    """Write a movie, .mp4 or .gif, of the frames given or of all.

    folder : output folder of a run; file : by default movie.mp4 in it, movie.gif where imageio-ffmpeg is missing
    rate : frames a second
    report : is called with the number of frames drawn and the total

    Raises InputError where there is no such frame, a frame is damaged, or the file cannot be written.
    """
    footage = read_footage(folder)
    target = _target(footage, file, MOVIE + best_ending(), MOVIE_ENDINGS)
    check_ending(target)
    _check_rate(rate)
    numbers = list(range(len(footage.files)) if frames is None else frames)
    shown = _read(footage, numbers)
    pictures = _pictures(footage, shown, look or Look(), width=_MOVIE_WIDTH, even=True, report=report)
    try:
        write_movie(target, pictures, rate=rate)
    except OSError as error:
        raise _not_writable(target, error) from error
    return _rendering(footage, target, numbers)


def render_page(
    folder: str | os.PathLike[str],
    file: str | os.PathLike[str] | None = None,
    *,
    frames: Sequence[int] | None = None,
    rate: float = RATE,
    look: Look | None = None,
) -> Rendering:
    """Write a page for browsers in which the flight plays and turns, of the frames given or of all.

    The page is one file that loads nothing else; its positions are rounded to the step that it states.

    folder : output folder of a run; file : by default flight.html in it
    rate : frames a second, at first

    Raises InputError where there is no such frame, a frame is damaged, or the file cannot be written.
    """
    footage, look = read_footage(folder), look or Look()
    target = _target(footage, file, PAGE, (".html", ".htm"))
    _check_rate(rate)
    if look.size is not None:
        raise InputError("a page has no size, it fills its window: leave size out")
    numbers = list(range(len(footage.files)) if frames is None else frames)
    shown = _read(footage, numbers)
    page = page_of(
        footage,
        shown,
        view=view_of(look.view),
        follow=look.camera == "follow",
        nodes=_nodes(footage, look),
        peak=look.peak or peak_of(shown, footage.cast),
        rate=rate,
    )
    return _written(footage, target, numbers, page.encode())


def _pictures(
    footage: Footage,
    shown: Sequence[Frame],
    look: Look,
    *,
    width: int,
    even: bool = False,
    report: Tell | None = None,
) -> Iterator[Image.Image]:
    """Pictures of the frames, each with time and footer; `even`: whether their sides are even, as movies need."""
    extent = _extent(footage, shown, look)
    size = look.size or _suited(extent, width)
    if even:
        size = (size[0] - size[0] % 2, size[1] - size[1] % 2)
    peak = look.peak or peak_of(shown, footage.cast)
    panel = _panel(size)
    held = _any_held(shown)
    shots = extent.shots(panel, room=room_for(footage.cast, panel, held=held))
    footer = Footer(footage.cast, shots[0].scale, peak, held).draw(size[0])
    letters = font_size(size[0])
    for count, image in enumerate(_panels(footage, shown, shots, peak=peak, letters=letters), 1):
        if report is not None:
            report(count, len(shown))
        yield framed(image, footer)


def _panels(
    footage: Footage, shown: Sequence[Frame], shots: Sequence[Shot], *, peak: float, letters: float
) -> Iterator[Image.Image]:
    decimals = footage.decimals()
    with Stage(footage.cast, shots[0].size, peak=peak) as stage:
        for frame, shot in zip(shown, shots, strict=True):
            yield with_time(stage.draw(frame, shot), time_text(frame.t, decimals), size=letters)


def _check_rate(rate: float) -> None:
    if not 0.1 <= rate <= 60:
        raise InputError(f"a rate of {rate:g} frames a second is out of range: give 0.1 to 60")


def _read(footage: Footage, numbers: Sequence[int]) -> list[Frame]:
    if not numbers:
        raise InputError("no frames are given: give their numbers")
    for number in numbers:  # before the slow reading of them
        footage.check(number)
    return [footage.frame(number) for number in numbers]


def _nodes(footage: Footage, look: Look) -> IntArray:
    return footage.cast.net if look.fit == "net" else footage.cast.drawn


def _extent(footage: Footage, shown: Sequence[Frame], look: Look) -> Extent:
    return extent_of(shown, _nodes(footage, look), view=view_of(look.view), camera=look.camera)


def _any_held(shown: Sequence[Frame]) -> bool:
    return any(len(frame.held) > 0 for frame in shown)


def _columns(count: int) -> int:
    """Columns of a sheet: one row up to five, then rows that are wider than high."""
    return count if count <= 5 else int(np.ceil(np.sqrt(1.4 * count)))


def _suited(extent: Extent, width: int, *, columns: int = 1, rows: int = 1) -> tuple[int, int]:
    """Size of a picture of that width whose panels have the shape of what is in sight."""
    high = width / columns * float(np.clip(1.05 * extent.aspect(), _FLATTEST, _STEEPEST))
    return width, round(high) * rows + footer_height(width)


def _panel(size: tuple[int, int], *, columns: int = 1, rows: int = 1) -> tuple[int, int]:
    return max(1, size[0] // columns), max(1, (size[1] - footer_height(size[0])) // rows)


def _target(footage: Footage, file: str | os.PathLike[str] | None, name: str, endings: Sequence[str]) -> Path:
    """The file to write, its folder made; raises InputError for another ending, and where there can be no file."""
    target = footage.folder / name if file is None else Path(file)
    if target.suffix.lower() not in endings:
        raise InputError(f"{target}: give a name that ends in {' or '.join(endings)}")
    if target.is_dir():
        raise InputError(f"{target} cannot be written: it is a folder: give another name by -o")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _not_writable(target, error) from error
    return target


def _png(picture: Image.Image) -> bytes:
    data = io.BytesIO()
    picture.save(data, format="PNG", optimize=True)
    return data.getvalue()


def _written(footage: Footage, target: Path, numbers: Sequence[int], data: bytes) -> Rendering:
    try:
        write_whole(target, data)
    except OSError as error:
        raise _not_writable(target, error) from error
    return _rendering(footage, target, numbers)


def _rendering(footage: Footage, target: Path, numbers: Sequence[int]) -> Rendering:
    return Rendering(target, tuple(numbers), tuple(footage.times[number] for number in numbers))


def _not_writable(target: Path, error: OSError) -> InputError:
    return InputError(f"{target} cannot be written: {reason_of(error)}: give another name by -o")
