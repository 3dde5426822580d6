"""Pictures of runs: the figures of one run or ensemble, or of several over each other, as PNG and SVG files."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from netdae.core.errors import InputError
from netdae.core.files import reason_of, write_whole
from netdae.runs.folder import METRICS
from netdae.visual.plotting.drawing import bytes_of, draw
from netdae.visual.plotting.figures import NAMES, check_name
from netdae.visual.plotting.runs import FlownRun, read_run

FORMATS = ("png", "svg")
PLOTS = "plots"
"""Folder of the pictures, by default: in the folder of the run, or of several here."""


def plot(
    folders: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str] | None = None,
    *,
    formats: Sequence[str] = FORMATS,
    only: Sequence[str] = (),
) -> list[Path]:
    """Draw the figures of runs, each to its own file, named as the figure; return the files.

    folders : output folder of a run or an ensemble, or several that are drawn over each other. A run that failed,
        was stopped or is under way is drawn as far as its rows go; an ensemble as its mean, with the range from the
        smallest to the largest member shaded
    out : folder, by default plots in the folder of the one run, and plots here for several; it is made, and
        pictures of those names in it are replaced
    formats : "png", "svg" or both
    only : names of figures, see `plotting.figures.NAMES`; all by default, without those that no run has columns for

    The same folders give the same bytes, and no display is needed. Events stand as vertical lines. Units are SI.
    Raises InputError for a folder without a run or with fewer than two rows, an unknown name or format, figures
    that no run has, and where nothing can be written; nothing is written before all folders are read.
    """
    chosen = [folders] if isinstance(folders, str | os.PathLike) else [*folders]
    if not chosen:
        raise InputError("no folder is given: give the output folder of a run or several")
    for kind in formats:
        if kind not in FORMATS:
            raise InputError(f"{kind!r} is not a format of a picture: give {' or '.join(FORMATS)}")
    for name in only:
        check_name(name)
    runs = [read_run(folder) for folder in chosen]
    target = Path(out) if out is not None else (runs[0].folder / PLOTS if len(runs) == 1 else Path(PLOTS))
    figures = _figures_of([name for name in NAMES if name in only or not only], runs, asked=bool(only))
    try:
        target.mkdir(parents=True, exist_ok=True)
        files = []
        for name, figure in figures:
            for kind in dict.fromkeys(formats):
                files.append(target / f"{name}.{kind}")
                write_whole(files[-1], bytes_of(figure, kind))
    except OSError as error:
        raise InputError(
            f"{target}: pictures cannot be written there: {reason_of(error)}: choose another folder by -o"
        ) from error
    return files


def _figures_of(names: Sequence[str], runs: Sequence[FlownRun], *, asked: bool) -> list[tuple[str, Any]]:
    figures = []
    for name in names:
        figure = draw(name, runs)
        if figure is not None:
            figures.append((name, figure))
        elif asked:
            raise InputError(
                f"{name} cannot be drawn: {_places(runs)} no numbers for it: choose other figures"
            )
    if not figures:
        raise InputError(f"nothing can be drawn: {_places(runs)} no numbers: run it again")
    return figures


def _places(runs: Sequence[FlownRun]) -> str:
    files = [str(run.folder / METRICS) for run in runs]
    return f"{files[0]} has" if len(files) == 1 else f"{', '.join(files)} have"
