"""`netdae run`: fly a scenario into an output folder."""

from __future__ import annotations

import logging
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TextIO

from cyclopts import Parameter

from netdae.cli.arguments import place, whole_number
from netdae.errors import InputError

if TYPE_CHECKING:
    from netdae.run_folder import RunFolder
    from netdae.scenario import Scenario
    from netdae.simulation import Simulation
    from netdae.state import State
    from netdae.system import System

_log = logging.getLogger(__name__)


def run(
    scenario: Path,
    *,
    output: Annotated[
        Path | None,
        Parameter(
            name=["--output", "-o"], converter=place, help="Folder; by default the scenario's name with _out."
        ),
    ] = None,
    overwrite: Annotated[
        bool, Parameter(negative="", help="Replace a former run or ensemble in the folder.")
    ] = False,
    ensemble: Annotated[
        int | None,
        Parameter(
            converter=whole_number, help="Fly that many starts that differ a little; tell means and bands."
        ),
    ] = None,
    perturb: Annotated[
        float | None,
        Parameter(help="Standard deviation of each free coordinate in an ensemble, m; 1e-9 by default."),
    ] = None,
    seed: Annotated[
        int | None, Parameter(converter=whole_number, help="Of the ensemble's disturbances; 0 by default.")
    ] = None,
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
    from netdae.scenario import read_scenario

    of_ensemble = {
        "--perturb": perturb,
        "--seed": seed,
        "--processes": processes,
        "--all-frames": all_frames or None,
    }
    given = [name for name, value in of_ensemble.items() if value is not None]
    if ensemble is None and given:
        raise InputError(f"{given[0]} is for ensembles: give --ensemble N too, or leave it out")
    told = read_scenario(scenario)
    target = output or Path(f"{scenario.stem}_out")
    with _log_lines(), _stopped_by_sigterm():
        if ensemble is None:
            _fly_one(told, target, overwrite=overwrite)
        else:
            from netdae.cli.ensemble import fly_ensemble
            from netdae.ensemble import Ensemble

            fly_ensemble(
                told,
                Ensemble(ensemble, 1e-9 if perturb is None else perturb, seed or 0),
                target,
                processes=processes,
                overwrite=overwrite,
                all_frames=all_frames,
            )


def _fly_one(told: Scenario, target: Path, *, overwrite: bool) -> None:
    from netdae.compilation import COMPILING, told_when_compiling
    from netdae.observers import Progress
    from netdae.run_folder import RunFolder, fly

    folder = RunFolder(target, told, overwrite=overwrite)
    with told_when_compiling(lambda: _log.info(COMPILING)):
        simulation = told.build()
        summary = fly(
            simulation, folder, observers=[_Title(simulation), Progress(float(simulation.times[-1]))]
        )
    for line in _lines(simulation, folder, summary):
        print(line)


class _Title:
    """Observer that prints what is flown, before the first step."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation

    def begin(self, system: System) -> None:
        simulation = self._simulation
        print(
            f"{simulation.title}: {system.net.node_count} nodes, {system.net.cable_count} cables, "
            f"t = {simulation.times[0]:g} to {simulation.times[-1]:g} s",
            flush=True,
        )

    def __call__(self, state: State) -> None:
        pass


def _lines(simulation: Simulation, folder: RunFolder, summary: dict[str, Any]) -> Iterator[str]:
    figures, solver = summary["deployment"], summary["solver"]
    yield f"{len(simulation.times)} frames in {folder.path / 'series.pvd'}, figures in {folder.path / 'summary.json'}"
    if "largest_mouth_area" in figures:
        yield (
            f"largest mouth area {figures['largest_mouth_area']:.4g} m² at t = "
            f"{figures['largest_mouth_area_time']:.4g} s"
        )
    yield f"peak tension {figures['peak_tension']:.4g} N at t = {figures['peak_tension_time']:.4g} s"
    yield f"{solver['steps']} steps in {solver['wall_seconds']['total']:.3g} s"
    for warning in summary["warnings"]:
        yield f"warning: {warning}"


@contextmanager
def _stopped_by_sigterm() -> Iterator[None]:
    """Take SIGTERM, by which queues of clusters end a job, as Ctrl-C: with a summary of what was computed."""
    former = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, former)


class _LineHandler(logging.StreamHandler[TextIO]):
    """Prints a line each; a reader that has left, for instance head, ends no flight."""

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
