"""Observers of a flight that write the table of metrics and show its progress."""

from __future__ import annotations

import contextlib
import logging
import os
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from netdae.core.errors import InputError, RunError
from netdae.core.files import reason_of
from netdae.model.state import State
from netdae.output.metrics import COLUMNS, DeploymentMetrics

if TYPE_CHECKING:
    from rich.console import Console

    from netdae.system.system import System

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

    def resume(self, system: System, memory: Mapping[str, Any]) -> None:
        """Keep the rows of the frames that the flight has yielded; raises InputError where they are missing."""
        count = int(memory["frames"])
        try:
            data = self.path.read_bytes()
            lines = data.split(b"\n", count + 1)[: count + 1]
            if lines[0].decode(errors="replace") != ",".join(COLUMNS):
                raise InputError(
                    f"{self.path}: its first line is not that of a run: it cannot be gone on from"
                )
            end = sum(len(line) + 1 for line in lines)
            if len(lines) <= count or end > len(data):
                rows = max(0, data.count(b"\n") - 1)
                raise InputError(
                    f"{self.path} has {rows} rows, expected {count} at least: it cannot be gone on from"
                )
            self.metrics.rows = [_numbers_in(line, self.path) for line in lines[1:]]
            os.truncate(self.path, end)
            self._stream = self.path.open("a", encoding="utf-8", newline="\n")
        except OSError as error:
            raise InputError(f"{self.path} cannot be gone on from: {reason_of(error)}") from error

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
            with contextlib.suppress(OSError):  # what could not be written was reported when it was tried
                self._stream.close()
            self._stream = None

    def _write(self, line: str) -> None:
        if self._stream is None:
            raise RuntimeError("MetricsCsv was called before begin(system)")
        self._stream.write(line + "\n")  # one line, one write at the flush: a kill leaves complete lines
        self._stream.flush()


def _numbers_in(line: bytes, path: Path) -> tuple[float, ...]:
    try:
        numbers = tuple(map(float, line.split(b",")))
    except ValueError:
        numbers = ()
    if len(numbers) != len(COLUMNS):
        raise InputError(f"{path}: a row is not {len(COLUMNS)} numbers: it cannot be gone on from")
    return numbers


class Progress:
    """Observer that shows simulated time and the time left: a bar on a terminal, log lines elsewhere.

    end : the simulated time at which the flight ends, s
    console : where the bar goes; by default standard error
    title : what stands before the bar

    Elsewhere it logs a line (level INFO of this module's logger) at each tenth of the simulated time.
    """

    _PAUSE = 0.1  # s between two updates of the bar

    def __init__(self, end: float, *, console: Console | None = None, title: str = "flight") -> None:
        self.end_time = end
        self.title = title
        self._console = console
        self._bar: Any = None

    def begin(self, system: System) -> None:
        """Show an empty bar."""
        self._show_from(None)

    def resume(self, system: System, memory: Mapping[str, Any]) -> None:
        """Show an empty bar of the time that is left."""
        self._show_from(float(memory["t"]))

    def _show_from(self, start: float | None) -> None:
        from rich.console import Console

        self._start_time = start
        self._t = start or 0.0
        self._tenth = 0
        self._began = self._looked = time.monotonic()
        console = self._console or Console(stderr=True)
        if console.is_terminal:
            self._bar = _bar_on(console)
            self._task = self._bar.add_task(self.title, total=1.0, t=0.0, end=self.end_time)
            self._bar.start()

    def watch(self, state: State) -> None:
        """See how far the flight has come."""
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
        """Nothing at a frame: progress is reported at the steps."""

    def end(self) -> None:
        """Leave the last state of the bar, or the last line, behind."""
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
        self._bar.update(self._task, completed=share, t=self._t, refresh=True)

    def _log_line(self) -> None:
        spent, share = time.monotonic() - self._began, self._share()
        _log.info(
            "%s: t = %.4g s of %.4g s, %.1f s left",
            self.title,
            self._t,
            self.end_time,
            spent * (1 - share) / share,
        )


def _bar_on(console: Console) -> Any:
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    return Bar(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("t = {task.fields[t]:.4g} s of {task.fields[end]:.4g} s"),
        TextColumn("spent"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        console=console,
        auto_refresh=False,  # refreshed by watch(): no thread beside the integrator
    )
