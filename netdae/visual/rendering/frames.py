"""Footage: the frames of a run's folder as pictures need them, and who is who in them.

Symbols: n nodes, m cables; points x (n, 3), m; tension (m,), N; taut (m,), true where the strain is above zero.
"""

from __future__ import annotations

import csv
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.core.errors import InputError
from netdae.model.shapes.part import axes_of
from netdae.output.pvd import read_series
from netdae.output.vtk import RESTRAINED, read_frame

SERIES = "series.pvd"
TARGET = "target.pvd"
METRICS = "metrics.csv"

KINDS = ("net", "tether", "closing")
"""Kinds of cables: of the net itself, of the tether or its bridle, or a cord that closes the net."""

_KIND_OF_GROUP = {"tether": 1, "bridle": 1, "closing": 2}
_HEAVIER = 10.0  # times the mass of a knot's share of cords: then a bullet


@dataclass(frozen=True, eq=False)
class Body:
    """A target in one frame: its surface, points (k, 3) in m and triangles (j, 3), and its frame.

    origin : (3,), m; axes : (3, 3), whose columns are its axes in space
    """

    points: FloatArray
    triangles: IntArray
    origin: FloatArray
    axes: FloatArray

    @property
    def own_points(self) -> FloatArray:
        """Points in its frame, (k, 3), m."""
        return (self.points - self.origin) @ self.axes


@dataclass(frozen=True, eq=False)
class Frame:
    """One frame: number in the series from 0, time t in s, points (n, 3) in m, tension (m,) in N, taut (m,).

    held : nodes, without the chaser, of which an axis is held or driven; none in frames that do not record it
    body : the target; None where there is none
    """

    number: int
    t: float
    points: FloatArray
    tension: FloatArray
    taut: BoolArray
    held: IntArray
    body: Body | None = None

    def in_sight(self, nodes: IntArray) -> FloatArray:
        """Places of nodes, and of the target's surface, (k, 3), m."""
        seen = self.points[nodes]
        return seen if self.body is None else np.concatenate((seen, self.body.points))


@dataclass(frozen=True, eq=False)
class Cast:
    """Who is who among the nodes and cables of a flight; the same in all of its frames.

    cables : (m, 2), nodes
    kind : (m,), index into `KINDS`
    net : nodes of the net; drawn : those and the nodes of tether and chaser, all but nodes without a cable
    bullets : nodes of the net that carry a mass; chaser : nodes
    typical_length : median length of the net's cables in the reference configuration, m
    """

    cables: IntArray
    kind: IntArray
    net: IntArray
    drawn: IntArray
    bullets: IntArray
    chaser: IntArray
    typical_length: float


@dataclass(frozen=True, eq=False)
class Footage:
    """The series of a run's folder: times in s and files of its frames, and who is in them.

    bodies : files of the target's frames; none where there is no target
    """

    folder: Path
    times: tuple[float, ...]
    files: tuple[Path, ...]
    cast: Cast
    bodies: tuple[Path, ...] = ()

    def frame(self, number: int) -> Frame:
        """Read a frame; raises InputError where there is none of that number or its file is damaged."""
        self.check(number)
        grid = _whole(self.files[number])
        cells, points = grid.cell_data, np.asarray(grid.points, dtype=np.float64)
        if not np.array_equal(_cables_of(grid), self.cast.cables) or len(points) <= self.cast.drawn.max():
            raise InputError(
                f"{self.files[number]} shows another net than {self.files[0]}: give the folder of one run"
            )
        return Frame(
            number,
            self.times[number],
            points,
            np.asarray(cells["tension"], dtype=np.float64),
            np.asarray(cells["taut"]) == 1,
            self._held(grid),
            _body_in(self.bodies[number]) if number < len(self.bodies) else None,
        )

    def _held(self, grid: Any) -> IntArray:
        if RESTRAINED not in grid.point_data:
            return np.zeros(0, dtype=np.int64)
        held = np.flatnonzero(grid.point_data[RESTRAINED])
        return np.setdiff1d(np.intersect1d(held, self.cast.drawn), self.cast.chaser)

    def check(self, number: int) -> None:
        """Raise InputError unless there is a frame of that number."""
        last = len(self.files) - 1
        if not 0 <= number <= last:
            raise InputError(f"frame {number} is not in {self.folder}: its frames are 0 to {last}")

    def at(self, t: float) -> int:
        """Number of the frame nearest to the time t, s; raises InputError outside of the flight."""
        first, last = self.times[0], self.times[-1]
        if not first <= t <= last:  # also for nan
            raise InputError(
                f"time {t:g} s is not in {self.folder}: its frames are from {first:g} to {last:g} s"
            )
        return int(np.abs(np.asarray(self.times) - t).argmin())

    def spread(self, count: int) -> list[int]:
        """Numbers of `count` frames, evenly spread from the first to the last; all where there are fewer."""
        last = len(self.files) - 1
        chosen = np.linspace(0, last, min(count, last + 1)).round().astype(int)
        return [int(number) for number in chosen]

    def widest(self) -> int:
        """Number of the frame with the largest mouth by metrics.csv; the last one without such data."""
        try:
            with (self.folder / METRICS).open(newline="", encoding="utf-8") as stream:
                rows = [(float(row["mouth_area"]), float(row["time"])) for row in csv.DictReader(stream)]
            _, t = max((row for row in rows if np.isfinite(row).all()), key=lambda row: row[0])
            return self.at(t)
        except (OSError, ValueError, KeyError, TypeError):  # without metrics the series will do
            return len(self.files) - 1

    def decimals(self) -> int:
        """Digits after the point that show the frames' times, 2 to 6."""
        times = np.unique(self.times)
        finest = float(np.diff(times).min()) if len(times) > 1 else 1.0
        given = (
            digits for digits in range(2, 6) if np.abs(times - times.round(digits)).max() < 0.01 * finest
        )
        return next(given, 6)


def read_footage(folder: str | os.PathLike[str]) -> Footage:
    """The frames of a run's folder; raises InputError where there are none yet, or none that can be read."""
    place = Path(folder)
    if not (place / SERIES).is_file():
        if members := sorted(place.glob(f"member_*/{SERIES}")):
            raise InputError(
                f"{place} is the folder of an ensemble: give that of a member, {members[0].parent}"
            )
        what = "has no frames" if place.is_dir() else "is not a folder"
        raise InputError(f"{place} {what}: give the output folder of netdae run, in which {SERIES} is")
    series = read_series(place / SERIES)
    if not series:
        raise InputError(f"{place} has no frames yet: wait for the first, or give another run's folder")
    times, files = zip(*series, strict=True)
    bodies = tuple(file for _, file in read_series(place / TARGET)) if (place / TARGET).is_file() else ()
    return Footage(place, times, files, cast_of(_whole(files[0])), bodies)


def cast_of(grid: Any) -> Cast:
    """Who is who in a frame, given by its groups and masses."""
    n, m = grid.n_points, grid.n_cells
    cables = _cables_of(grid)
    kind = np.zeros(m, dtype=np.int64)
    for name in grid.cell_data:
        group = name.removeprefix("group_")
        if group != name:
            found = next((k for word, k in _KIND_OF_GROUP.items() if group.startswith(word)), 0)
            kind[(np.asarray(grid.cell_data[name]) == 1) & (found > 0)] = found
    chaser, tether = _members(grid, "chaser"), _members(grid, "tether")
    drawn = np.zeros(n, dtype=np.bool_)
    drawn[cables] = True
    drawn |= chaser
    net = drawn & ~chaser & ~tether
    if not net.any():
        net = drawn
    ends = np.asarray(grid.points) - np.asarray(grid.point_data["displacement"])
    length = np.linalg.norm(ends[cables[:, 1]] - ends[cables[:, 0]], axis=1)
    share = np.bincount(cables.ravel(), np.repeat(length, 2), minlength=n)  # m of cord at each knot
    heft = np.asarray(grid.point_data["mass"], dtype=np.float64) / np.where(share > 0, share, np.inf)
    usual = float(np.quantile(heft[net], 0.25))
    return Cast(
        cables=cables,
        kind=kind,
        net=np.flatnonzero(net),
        drawn=np.flatnonzero(drawn),
        bullets=np.flatnonzero(net & (heft > _HEAVIER * usual)),
        chaser=np.flatnonzero(chaser),
        typical_length=float(np.median(length[kind == 0])) if (kind == 0).any() else float(np.median(length)),
    )


def _body_in(file: Path) -> Body:
    """The target in a frame; raises InputError where the file is damaged."""
    given = pv.VtkErrorCatcher(send_to_logging=False)
    with pv.vtk_verbosity("off"), given:
        surface = pv.XMLPolyDataReader(str(file)).read()
    if given.error_events or not surface.n_points or "attitude" not in surface.field_data:
        raise InputError(_damaged(file))
    axes = axes_of(np.asarray(surface.field_data["attitude"]))
    points = np.asarray(surface.points, dtype=np.float64)
    triangles = np.asarray(surface.regular_faces, dtype=np.int64)
    return Body(points, triangles, np.asarray(surface.field_data["origin"]), axes)


def _members(grid: Any, group: str) -> BoolArray:
    if f"group_{group}" not in grid.point_data:
        return np.zeros(grid.n_points, dtype=np.bool_)
    return np.asarray(grid.point_data[f"group_{group}"]) == 1


def _cables_of(grid: Any) -> IntArray:
    return np.asarray(grid.cells, dtype=np.int64).reshape(-1, 3)[:, 1:]


def _whole(file: Path) -> Any:
    """The grid of a frame; raises InputError where VTK finds its data damaged."""
    given = pv.VtkErrorCatcher(send_to_logging=False)
    try:
        with pv.vtk_verbosity("off"), given:
            grid = read_frame(file)
    except InputError:
        if given.error_events:  # it names the arrays that are lost, not why
            raise InputError(_damaged(file)) from None
        raise
    arrays = [grid.points, *(data[name] for data in (grid.point_data, grid.cell_data) for name in data)]
    if given.error_events or not grid.n_cells or not all(np.isfinite(array).all() for array in arrays):
        raise InputError(_damaged(file))
    return grid


def _damaged(file: Path) -> str:
    return f"{file} is damaged: choose other frames, or fly the run again"
