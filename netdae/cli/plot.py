"""`netdae plot`: figures of runs as PNG and SVG."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from netdae.cli.arguments import place
from netdae.core.errors import InputError


def plot(
    *dirs: Annotated[Path, Parameter(converter=place)],
    output: Annotated[
        Path | None,
        Parameter(
            name=["--output", "-o"],
            converter=place,
            help="Folder for the pictures; by default plots in DIR, of several runs plots here.",
        ),
    ] = None,
    format: Annotated[Literal["png", "svg", "both"], Parameter(help="Kind of files.")] = "both",
    only: Annotated[
        list[str] | None,
        Parameter(
            negative="",
            help="One figure: overview, area, distance, energy, tension, momentum, taut, tether, contact, target or "
            "closing; "
            "more by giving it again.",
        ),
    ] = None,
) -> None:
    """Draw the figures of a run or an ensemble, or of several over each other; one more sheet shows all of them.

    Parameters
    ----------
    dirs
        Output folders; of runs that stopped or are under way what is there is drawn.
    """
    if not dirs:
        raise InputError("DIR is missing: netdae plot DIR [DIR ...]. See netdae plot --help")
    import logging

    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # it would report its caches
    from netdae.visual.plotting.sheets import FORMATS, plot

    files = plot(dirs, output, formats=FORMATS if format == "both" else (format,), only=only or ())
    pictures = "picture" if len(files) == 1 else "pictures"
    names = ", ".join(dict.fromkeys(file.stem for file in files))
    print(f"{len(files)} {pictures} in {files[0].parent}: {names}")
