"""`netdae run --ensemble`: fly a scenario from many starts that differ a little, in parallel processes."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from netdae.core.errors import InputError, RunError
from netdae.core.text import as_text

if TYPE_CHECKING:
    from rich.console import Console

    from netdae.runs.ensemble import Ensemble
    from netdae.runs.ensemble_folder import EnsembleFolder
    from netdae.runs.workers import Outcome
    from netdae.scenario.reader import Scenario
    from netdae.scenario.simulation import Simulation

_log = logging.getLogger(__name__)


def fly_ensemble(
    scenario: Scenario,
    ensemble: Ensemble,
    output: Path,
    *,
    processes: int | None,
    overwrite: bool,
    all_frames: bool,
) -> None:
    """Fly all members, write the figures over them and print the main ones."""
    from netdae.core.compilation import COMPILING, reported_when_compiling
    from netdae.runs.ensemble_folder import EnsembleFolder
    from netdae.runs.workers import processes_for

    workers = processes_for(ensemble.size, processes)
    if ensemble.scatter and not scenario.has_spread:
        raise InputError(
            f"{scenario.path}: --scatter lets each member draw its own errors of the ejection, but no "
            "[[initial.ejection]] has a spread above zero: add one, for instance spread = { speed = 0.05 }, or leave "
            "--scatter out"
        )
    folder = EnsembleFolder(output, scenario, ensemble, overwrite=overwrite, all_frames=all_frames)
    simulation = scenario.build()  # reports mistakes before any process is started
    folder.claim()
    print(
        f"{as_text(simulation.title)}: {simulation.system.net.node_count} nodes, "
        f"{simulation.system.net.cable_count} cables, "
        f"t = {simulation.times[0]:g} to {simulation.times[-1]:g} s\n"
        f"{ensemble.size} starts disturbed by {ensemble.perturb:g} m, seed {ensemble.seed}, "
        f"{'each with its own errors of the ejection, ' if ensemble.scatter else ''}in {workers} processes",
        flush=True,
    )
    with reported_when_compiling(lambda: print(COMPILING, flush=True)):
        simulation.compile()
    summary, bug = _fly(folder, simulation, workers)
    for line in _lines(folder, summary):
        print(as_text(line))
    if bug:
        raise RuntimeError(f"a member met a bug:\n{bug}")
    if summary["status"] != "finished":
        first = next(each for each in summary["members"] if each["status"].startswith("failed"))
        raise RunError(
            f"{summary['status'].removeprefix('failed: ')}, {first['folder']} first: "
            f"{first['status'].removeprefix('failed: ')}"
        )


def _fly(folder: EnsembleFolder, simulation: Simulation, workers: int) -> tuple[dict[str, Any], str | None]:
    """The summary, and the traceback of a bug if a member met one."""
    from netdae.runs.ensemble_folder import fly_member
    from netdae.runs.workers import outcomes_of

    ended: list[Outcome] = []
    began = time.monotonic()

    def close(interrupted: bool) -> dict[str, Any]:
        about = {"processes": workers, "wall_seconds": round(time.monotonic() - began, 3)}
        return folder.close(simulation, ended, interrupted=interrupted, about=about)

    progress = MembersProgress(len(folder.members))
    outcomes = outcomes_of(fly_member, folder.members, processes=workers, hear=progress.hear)
    try:
        with progress, closing(outcomes):
            for outcome in outcomes:
                ended.append(outcome)
                progress.end_of(outcome)
    except KeyboardInterrupt:
        finished = close(interrupted=True)["ensemble"]["finished"]
        raise KeyboardInterrupt(
            f"interrupted when {finished} of {len(folder.members)} members had finished; the figures over them "
            f"are in {folder.path / 'summary.json'}"
        ) from None
    return close(interrupted=False), next((each.bug for each in ended if each.bug), None)


def _lines(folder: EnsembleFolder, summary: dict[str, Any]) -> Iterator[str]:
    figures, flown = summary["deployment"], summary["ensemble"]
    yield (
        f"{flown['finished']} of {flown['size']} members flown in {flown['wall_seconds']:.3g} s; figures over them "
        f"in {folder.path / 'summary.json'}, their course in {folder.path / 'metrics.csv'}"
    )
    for name, words, unit in (
        ("largest_mouth_area", "largest mouth area", "m²"),
        ("peak_tension", "peak tension", "N"),
        ("tension_quantile_99_9", "tension for 99.9 % of the time up to", "N"),
    ):
        if name in figures:
            yield f"{words} {band_in_words(figures[name], unit)}"
    for event in summary["events"]:
        yield _line_of(event)
    for note in summary["notes"]:
        yield f"note: {note}"
    for warning in summary["warnings"]:
        yield f"warning: {warning}"


def _line_of(event: dict[str, Any]) -> str:
    time = event["time"]
    if time["n"] == 0:
        return f"event {event['name']} did not happen in any member"
    return f"event {event['name']} in {time['n']} of {event['of']} members, t = {band_in_words(time, 's')}"


def band_in_words(of: Mapping[str, float], unit: str) -> str:
    """Mean ± deviation and the range, to two digits of the deviation but to six of the mean at most."""
    mean, std = of["mean"], of["std"]
    if not (math.isfinite(std) and std > 0):  # of one member, or of members that agree
        return f"{mean:.5g} {unit}"
    wanted, most = (
        digits - math.floor(math.log10(size)) for digits, size in ((1, std), (5, max(abs(mean), std)))
    )
    decimals = max(0, min(wanted, most))
    middle, low, high = (f"{of[name]:.{decimals}f}" for name in ("mean", "min", "max"))
    deviation = f"{std:.{decimals}f}" if wanted <= most else f"{std:.2g}"
    return f"{middle} ± {deviation} {unit}, {low} to {high} {unit}"


class MembersProgress:
    """Shows how many members have ended: a bar on a terminal, a log line at each tenth elsewhere.

    size : number of members
    console : where the bar goes; by default standard error
    """

    def __init__(self, size: int, *, console: Console | None = None) -> None:
        self._size = size
        self._console = console
        self._shares: dict[int, float] = {}  # of the time that members under way have flown
        self._ended = self._tenth = 0
        self._compiling = False
        self._bar: Any = None

    def __enter__(self) -> MembersProgress:
        from rich.console import Console

        self._began = time.monotonic()
        console = self._console or Console(stderr=True)
        if console.is_terminal:
            self._bar = _bar_on(console)
            self._task = self._bar.add_task("members", total=self._size, ended=0)
            self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._look()
            self._bar.stop()

    def hear(self, number: int, message: tuple[str, Any]) -> None:
        """Take a message of `fly_member`."""
        kind, content = message
        if kind == "flown":
            self._shares[number] = content
            self._look()
        elif not self._compiling:  # each process compiles; one message is enough
            self._compiling = True
            _log.info(content)

    def end_of(self, outcome: Outcome) -> None:
        """Count a member that has ended."""
        self._shares.pop(outcome.number, None)
        self._ended += 1
        tenth = 10 * self._ended // self._size
        if self._bar is None and tenth > self._tenth:
            spent = time.monotonic() - self._began
            left = spent * (self._size - self._flown()) / self._flown()
            _log.info("ensemble: %d of %d members, %.1f s left", self._ended, self._size, left)
        self._tenth = tenth
        self._look()

    def _flown(self) -> float:
        return self._ended + sum(self._shares.values())

    def _look(self) -> None:
        if self._bar is not None:
            self._bar.update(self._task, completed=self._flown(), ended=self._ended, refresh=True)


def _bar_on(console: Console) -> Any:
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    return Bar(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[ended]} of {task.total:g}"),
        TextColumn("spent"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        console=console,
        auto_refresh=False,  # refreshed by what the members report
    )
