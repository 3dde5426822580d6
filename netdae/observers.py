"""Watchers of a flight beside those of `vtk` and `metrics`: the table, the checkpoint, frames, progress."""

from __future__ import annotations

import contextlib
import io
import logging
import os
import time
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from netdae._files import reason_of, write_whole
from netdae.errors import InputError, RunError
from netdae.metrics import COLUMNS, DeploymentMetrics
from netdae.state import Books, State, Trajectory

if TYPE_CHECKING:
    from rich.console import Console

    from netdae.system import System

_log = logging.getLogger(__name__)


class MetricsCsv:
    """Observer that writes metrics.csv, a row per frame, each on disk as soon as it is known.

    path : the file; its folder is made
    metrics : the observer that measures; it must watch the same flight, before or after this one

    Raises InputError where nothing can be written, RunError when a row cannot be.
    """

    def __init__(self, path: str | os.PathLike[str], metrics: DeploymentMetrics) -> None:
        self.path = Path(path)
        self.metrics = metrics
        self._stream: TextIO | None = None

    def begin(self, system: System) -> None:
        """Write the header."""
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._stream = self.path.open("w", encoding="utf-8", newline="\n")
            self._write(",".join(COLUMNS))
        except OSError as error:
            raise InputError(
                f"{self.path} cannot be written: {reason_of(error)}: choose another output folder"
            ) from error

    def __call__(self, state: State) -> None:
        """Write the row of a frame."""
        try:
            self._write(",".join(map(repr, self.metrics.row_of(state))))
        except OSError as error:
            raise RunError(
                f"the row at t = {state.t:g} s could not be written to {self.path}: {reason_of(error)}"
            ) from error

    def end(self) -> None:
        """Close the file."""
        if self._stream is not None:
            with contextlib.suppress(OSError):  # what could not be written was told when it was tried
                self._stream.close()
            self._stream = None

    def _write(self, line: str) -> None:
        if self._stream is None:
            raise RuntimeError("MetricsCsv was called before begin(system)")
        self._stream.write(line + "\n")  # one line, one write at the flush: a kill leaves complete lines
        self._stream.flush()


class Checkpoint:
    """Observer that keeps the last frame, with its books, in a .npz file: complete at every moment.

    Raises InputError where nothing can be written, RunError when a frame cannot be.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)

    def begin(self, system: System) -> None:
        """Make the folder and take a former checkpoint away."""
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.path.unlink(missing_ok=True)
        except OSError as error:
            raise InputError(
                f"{self.path} cannot be written: {reason_of(error)}: choose another output folder"
            ) from error

    def __call__(self, state: State) -> None:
        """Write a State in place of the one before."""
        content = io.BytesIO()
        books = state.books
        np.savez(
            content,
            t=state.t,
            x=state.x,
            v=state.v,
            a=state.a,
            dissipated_energy=books.dissipated_energy,
            external_work=books.external_work,
            external_impulse=np.array(books.external_impulse),
            peak_tension=books.peak_tension,
        )
        try:
            write_whole(self.path, content.getvalue())
        except OSError as error:
            raise RunError(
                f"the checkpoint at t = {state.t:g} s could not be written to {self.path}: {reason_of(error)}"
            ) from error


def read_checkpoint(path: str | os.PathLike[str]) -> State:
    """The State that a `Checkpoint` kept; raises InputError for a file that is none."""
    source = Path(path)
    try:
        with np.load(source) as arrays:
            books = Books(
                float(arrays["dissipated_energy"]),
                float(arrays["external_work"]),
                tuple(arrays["external_impulse"].tolist()),
                float(arrays["peak_tension"]),
            )
            return State(float(arrays["t"]), arrays["x"], arrays["v"], arrays["a"], books)
    except OSError as error:
        raise InputError(
            f"{source} cannot be read: {reason_of(error)}: give the checkpoint.npz of an output folder"
        ) from error
    except (ValueError, KeyError, EOFError, TypeError, AttributeError, zipfile.BadZipFile) as error:
        raise InputError(
            f"{source} is not a checkpoint of netdae: {error}: give the checkpoint.npz of an output folder"
        ) from error


class Recorder:
    """Observer that keeps all frames, and writes them to a file at the end, also of a run that failed.

    path : the trajectory.npz, or None to keep them in memory only
    """

    def __init__(self, path: str | os.PathLike[str] | None = None) -> None:
        self.path = None if path is None else Path(path)
        self.states: list[State] = []

    def begin(self, system: System) -> None:
        """Forget the frames of a former flight."""
        self.states = []

    def __call__(self, state: State) -> None:
        """Keep a State."""
        self.states.append(state)

    def trajectory(self) -> Trajectory:
        """The frames so far; at least one."""
        return Trajectory.of(self.states)

    def end(self) -> None:
        """Write the file if there is a path and a frame."""
        if self.path is None or not self.states:
            return
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.trajectory().save(self.path)
        except OSError as error:
            raise RunError(f"{self.path} could not be written: {reason_of(error)}") from error


class Progress:
    """Observer that shows simulated time, steps and the time left: a bar on a terminal, log lines elsewhere.

    end : the simulated time at which the flight ends, s
    console : where the bar goes; by default standard error
    title : what stands before the bar

    Elsewhere it logs a line (level INFO of this module's logger) at each tenth of the simulated time.
    """

    _PAUSE = 0.1  # s between two looks of the bar

    def __init__(self, end: float, *, console: Console | None = None, title: str = "flight") -> None:
        self.end_time = end
        self.title = title
        self.step_count = 0
        self._console = console
        self._bar: Any = None

    def begin(self, system: System) -> None:
        """Show an empty bar."""
        from rich.console import Console

        self.step_count = -1  # the first State watched is the start
        self._start_time: float | None = None
        self._t = 0.0
        self._tenth = 0
        self._began = self._looked = time.monotonic()
        console = self._console or Console(stderr=True)
        if console.is_terminal:
            self._bar = _bar_on(console)
            self._task = self._bar.add_task(self.title, total=1.0, t=0.0, end=self.end_time, steps=0)
            self._bar.start()

    def watch(self, state: State) -> None:
        """Count an internal step."""
        self.step_count += 1
        self._t = state.t
        if self._start_time is None:
            self._start_time = state.t
        if self._bar is None:
            tenth = int(10 * self._share() + 1e-9)
            if tenth > self._tenth:
                self._tenth = tenth
                self._log_line()
        elif time.monotonic() - self._looked > self._PAUSE:
            self._look()

    def __call__(self, state: State) -> None:
        """Nothing at a frame: the steps tell."""

    def end(self) -> None:
        """Leave the last look of the bar, or the last line, behind."""
        if self._bar is not None:
            self._look()
            self._bar.stop()
            self._bar = None

    def _share(self) -> float:
        start = self._start_time or 0.0
        span = self.end_time - start
        return min(1.0, (self._t - start) / span) if span > 0 else 1.0

    def _look(self) -> None:
        self._looked = time.monotonic()
        share = 0.0 if self._start_time is None else self._share()
        self._bar.update(self._task, completed=share, t=self._t, steps=max(0, self.step_count), refresh=True)

    def _log_line(self) -> None:
        spent, share = time.monotonic() - self._began, self._share()
        _log.info(
            "%s: t = %.4g s of %.4g s, %d steps, %.1f s left",
            self.title,
            self._t,
            self.end_time,
            self.step_count,
            spent * (1 - share) / share,
        )


def _bar_on(console: Console) -> Any:
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    return Bar(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("t = {task.fields[t]:.4g} s of {task.fields[end]:.4g} s"),
        TextColumn("{task.fields[steps]} steps"),
        TextColumn("spent"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        console=console,
        auto_refresh=False,  # refreshed by watch(): no thread beside the integrator
    )
