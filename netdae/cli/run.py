"""`netdae run`: fly a scenario into an output folder."""

from __future__ import annotations

import logging
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TextIO

from cyclopts import Parameter

from netdae.cli.arguments import place, whole_number
from netdae.core.errors import InputError
from netdae.core.text import as_text

if TYPE_CHECKING:
    from netdae.model.state import State
    from netdae.runs.folder import RunFolder
    from netdae.scenario.reader import Scenario
    from netdae.scenario.simulation import Simulation
    from netdae.system.system import System

_log = logging.getLogger(__name__)


def run(
    scenario: Annotated[Path | None, Parameter(converter=place)] = None,
    *,
    output: Annotated[
        Path | None,
        Parameter(
            name=["--output", "-o"], converter=place, help="Folder; by default the scenario's name with _out."
        ),
    ] = None,
    overwrite: Annotated[
        bool, Parameter(negative="", help="Replace an earlier run or ensemble in the folder.")
    ] = False,
    twin: Annotated[
        bool,
        Parameter(
            negative="", help="Fly a second time from a start 1e-9 m away; report how far its figures differ."
        ),
    ] = False,
    resume: Annotated[
        Path | None,
        Parameter(
            converter=place, help="Folder of a stopped or killed run: go on with it from its last frame."
        ),
    ] = None,
    until: Annotated[
        float | None, Parameter(help="Fly a run that is resumed to this time, s, not to its own end.")
    ] = None,
    ensemble: Annotated[
        int | None,
        Parameter(
            converter=whole_number, help="Fly that many starts that differ a little; report means and bands."
        ),
    ] = None,
    perturb: Annotated[
        float | None,
        Parameter(help="Standard deviation of each free coordinate in an ensemble, m; 1e-9 by default."),
    ] = None,
    seed: Annotated[
        int | None, Parameter(converter=whole_number, help="Of the ensemble's disturbances; 0 by default.")
    ] = None,
    scatter: Annotated[
        bool,
        Parameter(
            negative="",
            help="Let each member of an ensemble draw its own ejection errors by the scenario's spread.",
        ),
    ] = False,
    processes: Annotated[
        int | None,
        Parameter(
            converter=whole_number, help="How many members fly at once; by default one for each processor."
        ),
    ] = None,
    all_frames: Annotated[
        bool, Parameter(negative="", help="Write frames for each member, not for the first alone.")
    ] = False,
) -> None:
    """Run a scenario and write its frames and figures.

    Parameters
    ----------
    scenario
        TOML file.
    """
    of_ensemble = {
        "--perturb": perturb,
        "--seed": seed,
        "--scatter": scatter or None,
        "--processes": processes,
        "--all-frames": all_frames or None,
    }
    if resume is not None:
        others = {
            "--output": output,
            "--overwrite": overwrite or None,
            "--twin": twin or None,
            "--ensemble": ensemble,
            **of_ensemble,
        }
        _check_alone(resume, scenario, others)
        with _log_lines(), _stopped_by_sigterm():
            _fly_on(resume, until)
        return
    if until is not None:
        raise InputError(
            "--until is for a run that is resumed: give --resume DIR too; a new flight ends at end in [solver]"
        )
    if scenario is None:
        raise InputError("SCENARIO is missing: netdae run SCENARIO.toml. See netdae run --help")
    given = [name for name, value in of_ensemble.items() if value is not None]
    if ensemble is None and given:
        raise InputError(f"{given[0]} is for ensembles: give --ensemble N too, or leave it out")
    if ensemble is not None and twin:
        raise InputError(
            "--twin does not go with --ensemble, which measures the band itself: leave one of them out"
        )
    from netdae.scenario.reader import read_scenario

    read = read_scenario(scenario)
    target = output or Path(f"{scenario.stem}_out")
    with _log_lines(), _stopped_by_sigterm():
        if ensemble is None:
            _fly_one(read, target, overwrite=overwrite, twin=twin)
        else:
            from netdae.cli.ensemble import fly_ensemble
            from netdae.runs.ensemble import Ensemble

            fly_ensemble(
                read,
                Ensemble(ensemble, 1e-9 if perturb is None else perturb, seed or 0, scatter),
                target,
                processes=processes,
                overwrite=overwrite,
                all_frames=all_frames,
            )


def _check_alone(folder: Path, scenario: Path | None, others: dict[str, Any]) -> None:
    """Raise InputError where something besides --resume and --until is given."""
    if scenario is not None:
        raise InputError(
            f"{scenario} does not go with --resume: the scenario is the copy in {folder}: leave one of them out"
        )
    given = [name for name, value in others.items() if value is not None]
    if given:
        raise InputError(
            f"{given[0]} does not go with --resume, which goes on in {folder} as it began: leave one of them out"
        )


def _fly_one(given: Scenario, target: Path, *, overwrite: bool, twin: bool) -> None:
    from netdae.runs.folder import RunFolder

    _fly_into(RunFolder(target, given, overwrite=overwrite), given.build, twin=twin)


def _fly_on(folder: Path, until: float | None) -> None:
    from netdae.runs.resume import read_stopped_run

    stopped = read_stopped_run(folder, until=until)
    _fly_into(stopped.folder, stopped.build)


def _fly_into(folder: RunFolder, build: Callable[[], Simulation], *, twin: bool = False) -> None:
    from netdae.core.compilation import COMPILING, reported_when_compiling
    from netdae.output.observers import Progress
    from netdae.runs.folder import fly
    from netdae.runs.twin import fly_twin

    with reported_when_compiling(lambda: _log.info(COMPILING)):
        simulation = build()
        title = _Title(simulation)
        progress = Progress(float(simulation.times[-1]))
        summary = fly(simulation, folder, observers=[title, progress, _Stop()])
        if twin:
            progress = Progress(float(simulation.times[-1]), title="twin")
            summary = fly_twin(build(), folder, summary, observers=[progress, _Stop()])
    for line in _lines(title.frame_count, folder, summary):
        print(as_text(line))


class _Title:
    """Observer that prints what is flown, before the first step, and counts the frames."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self.frame_count = 0

    def begin(self, system: System) -> None:
        self._print(f"t = {self._simulation.times[0]:g}")

    def resume(self, system: System, memory: Mapping[str, Any]) -> None:
        self.frame_count = int(memory["frames"])
        self._print(f"resumed, t = {float(memory['frame']):.6g}")

    def __call__(self, state: State) -> None:
        self.frame_count += 1

    def _print(self, begin: str) -> None:
        simulation = self._simulation
        net = simulation.system.net
        print(
            f"{as_text(simulation.title)}: {net.node_count} nodes, {net.cable_count} cables, "
            f"{begin} to {simulation.times[-1]:g} s",
            flush=True,
        )


class _Stop:
    """Observer that ends a flight between two steps after Ctrl-C or SIGTERM; a second signal ends it at once.

    An exception that a signal raises anywhere may hit compiled code or VTK, some of which does not survive it.
    """

    def __init__(self) -> None:
        self._asked = False
        self._former: dict[int, Any] = {}

    def begin(self, system: System) -> None:
        if threading.current_thread() is threading.main_thread():
            self._former = {each: signal.signal(each, self._ask) for each in (signal.SIGINT, signal.SIGTERM)}

    def watch(self, state: State) -> None:
        if self._asked:
            raise KeyboardInterrupt

    def __call__(self, state: State) -> None:
        self.watch(state)

    def end(self) -> None:
        for each, handler in self._former.items():
            signal.signal(each, handler)

    def _ask(self, number: int, frame: Any) -> None:
        if self._asked:
            raise KeyboardInterrupt
        self._asked = True


def _lines(frames: int, folder: RunFolder, summary: dict[str, Any]) -> Iterator[str]:
    from netdae.runs.twin import in_words

    figures, solver = summary["deployment"], summary["solver"]
    yield f"{frames} frames in {folder.path / 'series.pvd'}, figures in {folder.path / 'summary.json'}"
    if "largest_mouth_area" in figures:
        yield (
            f"largest mouth area {figures['largest_mouth_area']:.4g} m² at t = "
            f"{figures['largest_mouth_area_time']:.4g} s"
        )
    yield f"peak tension {figures['peak_tension']:.4g} N at t = {figures['peak_tension_time']:.4g} s"
    if tether := summary["tether"]:
        yield (
            f"tether {tether['length']:.4g} m long, peak tension {tether['peak_tension']:.4g} N at t = "
            f"{tether['peak_tension_time']:.4g} s"
        )
    yield f"{solver['steps']} steps in {solver['wall_seconds']['total']:.3g} s"
    for event in summary["events"]:
        yield _line_of(event)
    if "twin" in summary:
        yield in_words(summary)
    for note in summary["notes"]:
        yield f"note: {note}"
    for warning in summary["warnings"]:
        yield f"warning: {warning}"


def _line_of(event: dict[str, Any]) -> str:
    if event["time"] is None:
        return f"event {event['name']} did not happen"
    done = "" if event["action"] == "none" else f": {event['action']}"
    known = "" if event["found"] == event["time"] else f", known at {event['found']:.4g} s"
    return f"event {event['name']} at t = {event['time']:.4g} s{known}{done}"


@contextmanager
def _stopped_by_sigterm() -> Iterator[None]:
    """Treat SIGTERM, with which cluster queues end a job, as Ctrl-C: with a summary of what was computed."""
    former = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, former)


class _LineHandler(logging.StreamHandler[TextIO]):
    """Prints a line each; a reader that has gone, for instance head, ends no flight."""

    def format(self, record: logging.LogRecord) -> str:
        return as_text(super().format(record))

    def handleError(self, record: logging.LogRecord) -> None:
        if not isinstance(sys.exc_info()[1], BrokenPipeError):
            super().handleError(record)


@contextmanager
def _log_lines() -> Iterator[None]:
    """Print what netdae logs, a line each: the progress where there is no terminal."""
    handler = _LineHandler(sys.stdout)
    logger = logging.getLogger("netdae")
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
