"""`netdae run`: fly a scenario into an output folder."""

from __future__ import annotations

import logging
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from netdae.errors import RunError

if TYPE_CHECKING:
    from netdae.run_folder import RunFolder
    from netdae.scenario import Simulation


def run(
    scenario: Path,
    *,
    output: Annotated[
        Path | None,
        Parameter(name=["--output", "-o"], help="Folder; by default the scenario's name with _out."),
    ] = None,
    overwrite: Annotated[bool, Parameter(negative="", help="Replace a former run in the folder.")] = False,
) -> None:
    """Run a scenario and write its frames and figures.

    Parameters
    ----------
    scenario
        TOML file.
    """
    from netdae.run_folder import RunFolder
    from netdae.scenario import read_scenario

    told = read_scenario(scenario)
    folder = RunFolder(output or f"{scenario.stem}_out", told, overwrite=overwrite)
    with _log_lines(), _stopped_by_sigterm():
        simulation = told.build()
        summary = _fly(simulation, folder)
    for line in _lines(simulation, folder, summary):
        print(line)


def _fly(simulation: Simulation, folder: RunFolder) -> dict[str, Any]:
    """Fly and return the summary, which is written also when the run fails."""
    from netdae.flight import shown, watches_of
    from netdae.observers import Progress
    from netdae.run_folder import LastStep, summary_of

    last, system, end = LastStep(), simulation.system, float(simulation.times[-1])
    observers = [*folder.observers(simulation), last, Progress(end)]
    flight = simulation.integrate(watches_of(observers))
    folder.claim()
    print(
        f"{simulation.title}: {system.net.node_count} nodes, {system.net.cable_count} cables, "
        f"t = {simulation.times[0]:g} to {end:g} s",
        flush=True,
    )
    status, frames = "failed", 0
    try:
        for _ in shown(flight, system, observers):
            frames += 1
        status = "finished"
    except RunError as error:
        status = f"failed: {error}"
        raise RunError(f"{error}; {_kept(frames, folder)}") from error
    except KeyboardInterrupt:
        status = "interrupted"
        t = simulation.start.t if last.state is None else last.state.t
        raise KeyboardInterrupt(f"interrupted at t = {t:.4g} s; {_kept(frames, folder)}") from None
    except Exception as error:
        status = f"failed: {type(error).__name__}: {error}"
        raise
    finally:
        summary = summary_of(
            simulation,
            status=status,
            statistics=flight.statistics,
            impulses=flight.impulses,
            last=last.state,
        )
        folder.write_summary(summary)
    return summary


def _kept(frames: int, folder: RunFolder) -> str:
    return f"the {frames} frames up to then are in {folder.path}"


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


@contextmanager
def _log_lines() -> Iterator[None]:
    """Print what netdae logs, a line each: the progress where there is no terminal."""
    handler = logging.StreamHandler(sys.stdout)
    logger = logging.getLogger("netdae")
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
