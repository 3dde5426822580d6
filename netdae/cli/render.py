"""`netdae render`: pictures, contact sheets, movies and pages of a run."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter, Token

from netdae.cli.arguments import place, whole_number
from netdae.core.errors import InputError

if TYPE_CHECKING:
    from netdae.visual.rendering.views import Rendering

_MOVIES, _PAGES = (".mp4", ".gif"), (".html", ".htm")


def _numbers(kind: Any, tokens: Sequence[Token]) -> tuple[int, ...]:
    """Numbers of frames as 0,10,20, or from:to or from:to:step, the last included."""
    text = tokens[0].value
    given: list[int] = []
    for part in text.split(","):
        if not re.fullmatch(r" *[0-9]+ *(: *[0-9]+ *){0,2}", part):
            raise ValueError(f'"{text}", expected numbers of frames as 0,10,20 or 0:60:5')
        first, *rest = map(int, part.split(":"))
        last, step = (*rest, 1)[:2] if rest else (first, 1)
        if step == 0 or last < first:
            raise ValueError(f'"{text}", expected from:to:step upwards, as 0:60:5')
        if last >= 10**7:
            raise ValueError(f'"{text}", expected numbers of frames below 10000000')
        given += range(first, last + 1, step)
    return tuple(given)


def _size(kind: Any, tokens: Sequence[Token]) -> tuple[int, int]:
    text = tokens[0].value
    found = re.fullmatch(r" *([0-9]{1,6}) *[,x] *([0-9]{1,6}) *", text)
    if not found:
        raise ValueError(f'"{text}", expected width and height in pixels as 1280,960')
    return int(found[1]), int(found[2])


def _direction(kind: Any, tokens: Sequence[Token]) -> str | tuple[float, ...]:
    text = tokens[0].value
    if "," not in text:
        return text
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise ValueError(f'"{text}", expected a vector towards the eye as 1,-2,0.5') from None


def render(
    folder: Annotated[Path, Parameter(converter=place)],
    *,
    output: Annotated[
        Path | None,
        Parameter(
            name=["--output", "-o"],
            converter=place,
            help="File; its ending reports what is made: .png, .mp4, .gif or .html. By default one in the folder.",
        ),
    ] = None,
    frame: Annotated[
        int | None,
        Parameter(converter=whole_number, help="Number of the frame; by default that of the largest mouth."),
    ] = None,
    time: Annotated[float | None, Parameter(help="Show the frame nearest to this time, s.")] = None,
    frames: Annotated[
        Any,
        Parameter(
            converter=_numbers,
            n_tokens=1,
            help="Numbers of the frames in a sheet, a movie or a page, as 0,10,20 or 0:60:5.",
        ),
    ] = None,
    sheet: Annotated[
        int | None,
        Parameter(converter=whole_number, help="Make a contact sheet of that many frames, evenly spread."),
    ] = None,
    movie: Annotated[bool, Parameter(negative="", help="Make a movie.")] = False,
    html: Annotated[
        bool, Parameter(negative="", help="Make a page in which the flight plays and turns.")
    ] = False,
    camera: Annotated[
        Literal["follow", "still"],
        Parameter(help="Keep the net in the middle, or stand and see the whole way."),
    ] = "follow",
    view: Annotated[
        Any,
        Parameter(
            converter=_direction,
            n_tokens=1,
            help="oblique, x, y, z, or a vector towards the eye as --view=1,-2,0.5; z is up.",
        ),
    ] = "oblique",
    fit: Annotated[
        Literal["all", "net"],
        Parameter(help="What has to be in sight: all, with tether and chaser, or the net alone."),
    ] = "all",
    size: Annotated[
        Any,
        Parameter(converter=_size, n_tokens=1, help="Width and height, pixels, as 1280,960."),
    ] = None,
    peak: Annotated[
        float | None,
        Parameter(help="Tension at which the colours end, N; by default 98 % of the taut cables stay below."),
    ] = None,
    rate: Annotated[
        float | None, Parameter(help="Frames a second of a movie or a page; 20 by default.")
    ] = None,
) -> None:
    """Make a picture, a contact sheet, a movie or a page of a run.

    Parameters
    ----------
    folder
        Output folder of a run.
    """
    kind = _kind_of(output, frame=frame, time=time, frames=frames, sheet=sheet, movie=movie, html=html)
    if rate is not None and kind in ("picture", "sheet"):
        raise InputError("--rate is for movies and pages: give --movie or --html too, or leave it out")
    from netdae.visual.rendering.look import Look
    from netdae.visual.rendering.views import RATE, render_movie, render_page, render_picture, render_sheet

    look = Look(view=view, camera=camera, fit=fit, size=size, peak=peak)
    pace = RATE if rate is None else rate
    done: Rendering
    if kind == "movie":
        done = render_movie(folder, output, frames=frames, rate=pace, look=look, report=_report)
    elif kind == "page":
        done = render_page(folder, output, frames=frames, rate=pace, look=look)
    elif kind == "sheet":
        done = render_sheet(folder, output, frames=frames, count=6 if sheet is None else sheet, look=look)
    else:
        done = render_picture(folder, output, frame=frame, time=time, look=look)
    print(_line(done))


def _kind_of(
    output: Path | None,
    *,
    frame: int | None,
    time: float | None,
    frames: tuple[int, ...] | None,
    sheet: int | None,
    movie: bool,
    html: bool,
) -> str:
    """What is wanted: "picture", "sheet", "movie" or "page"; raises InputError where options do not go together."""
    of_picture = {"--frame": frame, "--time": time}
    of_sheet = {"--sheet": sheet}
    one = [name for name, value in of_picture.items() if value is not None]
    many = [name for name, value in of_sheet.items() if value is not None]
    flags = [name for name, value in (("--movie", movie), ("--html", html)) if value]
    several = ["--frames"] if frames is not None else []
    for names in (one + several, one + many, one + flags, many + flags, many + several):
        if len(names) > 1:
            raise InputError(f"{names[0]} and {names[1]} do not go together: leave one of them out")
    ending = "" if output is None else output.suffix.lower()
    by_ending = "movie" if ending in _MOVIES else "page" if ending in _PAGES else ""
    if flags:
        kind = "movie" if movie else "page"
    elif by_ending and not one + many:
        kind = by_ending
    else:
        kind = "sheet" if many + several else "picture"
    if output is not None and ending not in (".png", *_MOVIES, *_PAGES):
        given = f'"{output.suffix}" is unknown' if ending else "is missing"
        raise InputError(f"{output}: its ending {given}: give .png, .mp4, .gif or .html")
    return kind


def _line(done: Rendering) -> str:
    first, last = done.times[0], done.times[-1]
    if len(done.frames) == 1:
        return f"{done.file}: frame {done.frames[0]}, t = {first:.6g} s"
    return f"{done.file}: {len(done.frames)} frames, t = {first:.6g} to {last:.6g} s"


def _report(count: int, total: int) -> None:
    if sys.stderr.isatty():
        print(f"\rframe {count} of {total}", end="\n" if count == total else "", file=sys.stderr, flush=True)
