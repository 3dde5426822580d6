"""The output folder of a run: which files are in it, and the flight into it."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import netdae
from netdae.core.errors import InputError, RunError
from netdae.core.files import reason_of, write_whole
from netdae.output.checkpoint import Checkpoint, Kept, Memory, close_checkpoint, write_checkpoint
from netdae.output.histories import HISTORY
from netdae.output.metrics import DeploymentMetrics
from netdae.output.observers import MetricsCsv
from netdae.output.step_log import StepLog
from netdae.output.trajectory import Recorder
from netdae.runs.lock import locked
from netdae.runs.summary import LastStep, json_of, summary_of, warnings_of_start
from netdae.scenario.digest import digests_of
from netdae.scenario.reader import Scenario
from netdae.scenario.simulation import Simulation
from netdae.solvers.flight import begun, show, watches_of

SERIES, METRICS, TRAJECTORY = "series.pvd", "metrics.csv", "trajectory.npz"
TARGET = "target.pvd"
CHECKPOINT, SUMMARY, SCENARIO = "checkpoint.npz", "summary.json", "scenario.toml"
LOGS = FRAMES_LOG, STEPS_LOG = "trajectory.log", "steps.log"
"""Of frames and of internal steps: in the folder while a run is under way, and after a kill."""
LOCK = "run.lock"
FINISHED = "finished"
"""Status of a run that has come to its end."""
FILES = (SERIES, TARGET, METRICS, TRAJECTORY, CHECKPOINT, SUMMARY, SCENARIO, *LOGS)
"""Files of a run, besides the folder `frames`."""

_FRAME = re.compile(r"(frame_\d{6,}\.vtu|target_\d{6,}\.vtp)(\.part)?")
_MEMBER = re.compile(r"member_\d{3,}")


class RunFolder:
    """A folder that takes the files of one run of a scenario.

    frames : whether series.pvd and the folder `frames` are written
    kept : of the checkpoint in the folder, from which its run is to be resumed; None for a new run

    Raises InputError for a path that is a file, or a folder with the files of a former run or ensemble in it
    unless `overwrite`, which is refused where the scenario reads one of them. Nothing is changed before `claim`.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        scenario: Scenario,
        *,
        overwrite: bool = False,
        frames: bool = True,
        kept: Kept | None = None,
    ) -> None:
        self.path = Path(path)
        self.frames = frames
        self.kept = kept
        self.scenario = scenario
        self._overwrite = overwrite
        if kept is None:
            self._check_free()

    def _check_free(self) -> None:
        scenario = self.scenario
        former = self._former()
        own = (scenario.text, scenario.copy)
        if [file.name for file in former] == [SCENARIO] and former[0].read_bytes() not in own:
            raise InputError(
                f"{self.path}: {SCENARIO} in it is not of a run: choose another output folder by -o"
            )
        if former and not self._overwrite:
            raise InputError(
                f"{self.path}: this folder already holds an earlier run "
                f"({former[0].relative_to(self.path).as_posix()}): choose another by -o, "
                "or replace the run by --overwrite"
            )
        read = {file.resolve() for file in scenario.files}
        lost = next((file for file in former if file.resolve() in read), None)
        if lost is not None:
            raise InputError(
                f"{lost}: --overwrite would delete this file, which the scenario reads: "
                "choose another output folder by -o"
            )

    def held(self) -> contextlib.ExitStack:
        """Make the folder and keep other runs out of it until the context ends; raises InputError."""
        context = contextlib.ExitStack()
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            context.enter_context(locked(self.path / LOCK))
        except OSError as error:
            raise self._not_writable(error) from error
        return context

    def notes(self, simulation: Simulation, about: Mapping[str, Any] | None) -> dict[str, Any]:
        """The checkpoint's notes on this flight, see `runs.resume`."""
        end = float(simulation.times[-1])
        if self.kept is None:
            return {
                "netdae": netdae.__version__,
                "scenario": digests_of(self.scenario, self._text),
                "end": end,
                "frames": self.frames,
                "resumes": [],
                "about": {**(about or {})},
            }
        former = {**self.kept.memory.notes}
        former.pop("status", None)
        resumes = [*former["resumes"], {"time": self.kept.state.t, "end": end}]
        return {**former, "end": end, "resumes": resumes, "about": {**former["about"], **(about or {})}}

    @property
    def _text(self) -> bytes:
        """The scenario as it stands in the folder."""
        in_place = (self.path / SCENARIO).resolve() == self.scenario.path.resolve()
        return self.scenario.text if in_place else self.scenario.copy

    def claim(self) -> None:
        """Make the folder, remove the files of a former run, copy the scenario; raises InputError."""
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            self._check_free()  # again: it may have been a while
            former = self._former()
            for file in former:
                file.unlink()
            for folder in sorted({file.parent for file in former} - {self.path}, reverse=True):
                _remove_if_empty(folder)
            copy = self.path / SCENARIO
            if copy.resolve() != self.scenario.path.resolve():
                write_whole(copy, self._text)
            if self.frames:
                (self.path / "frames").mkdir(exist_ok=True)
        except OSError as error:
            raise self._not_writable(error) from error

    def unpack(self, kept: Kept) -> None:
        """Restore the log of internal steps of a flight that had ended; raises InputError."""
        if kept.history is not None and not (self.path / STEPS_LOG).exists():
            steps = StepLog(len(HISTORY), self.path / STEPS_LOG)
            steps.fill(kept.history)
            steps.close()

    def reopen(self, kept: Kept, notes: Mapping[str, Any]) -> None:
        """Undo what marks the run as ended, once its files are known to be sound; raises InputError, RunError."""
        write_checkpoint(self.path / CHECKPOINT, kept.state, kept.memory._replace(notes=notes))
        try:
            (self.path / SUMMARY).unlink(missing_ok=True)
        except OSError as error:
            raise self._not_writable(error) from error

    def close(self, metrics: DeploymentMetrics, *, status: str) -> None:
        """Put what a later run needs to go on into the checkpoint, and remove the log; raises RunError."""
        history = metrics.history
        if (self.path / CHECKPOINT).exists():
            close_checkpoint(self.path / CHECKPOINT, history, status=status)
        metrics.forget()

    def _not_writable(self, error: OSError) -> InputError:
        return InputError(
            f"{self.path}: the output folder cannot be written: {reason_of(error)}: choose another by -o"
        )

    def _former(self) -> list[Path]:
        """Files of a former run or ensemble, but never the scenario that is run."""
        try:
            if self.path.exists() and not self.path.is_dir():
                raise InputError(
                    f"{self.path}: this is a file, not a folder: choose another output folder by -o"
                )
            inside = sorted(self.path.iterdir()) if self.path.exists() else []
            members = [each for each in inside if _MEMBER.fullmatch(each.name) and not each.is_symlink()]
            source = self.scenario.path.resolve()
            found = [file for folder in [self.path, *members] for file in _written_in(folder)]
            return [file for file in found if file.resolve() != source]
        except OSError as error:
            raise self._not_writable(error) from error

    def observers(self, simulation: Simulation, memory: Callable[[], Memory] | None = None) -> list[Any]:
        """Observers that measure a flight and write its files; the metrics come first.

        memory : for the checkpoint, which comes after all files of a frame
        """
        series: list[Any] = []
        if self.frames:
            from netdae.output.vtk import VtuSeries  # VTK's import takes 0.2 s

            detector = simulation.events
            fired = dict if detector is None else lambda: detector.fired
            series.append(VtuSeries(self.path / SERIES, fired=fired))
            if simulation.system.body is not None:
                from netdae.output.target_series import TargetSeries

                series.append(TargetSeries(self.path / TARGET))
        return [
            simulation.metrics,
            MetricsCsv(self.path / METRICS, simulation.metrics),
            *series,
            Recorder(self.path / TRAJECTORY),
            Checkpoint(self.path / CHECKPOINT, memory=memory),
        ]

    def write_summary(self, summary: Mapping[str, Any]) -> None:
        """Write summary.json, whole; numbers that are not finite become null. Raises RunError."""
        try:
            write_whole(self.path / SUMMARY, json_of(summary).encode())
        except OSError as error:
            raise RunError(f"{self.path / SUMMARY} could not be written: {reason_of(error)}") from error


def _written_in(folder: Path) -> list[Path]:
    """The files of a run that are in a folder."""
    names = [*FILES, *(f"{name}.part" for name in FILES)]
    frames = folder / "frames"
    inside = sorted(frames.iterdir()) if frames.is_dir() else []
    found = [folder / name for name in names] + [file for file in inside if _FRAME.fullmatch(file.name)]
    return [file for file in found if file.is_file()]


def _remove_if_empty(folder: Path) -> None:
    with contextlib.suppress(OSError):  # something of the user's is in it
        folder.rmdir()


def fly(
    simulation: Simulation,
    folder: RunFolder,
    *,
    observers: Sequence[Any] = (),
    about: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Fly into a folder and return the summary, which is written also when the flight fails or is interrupted.

    observers : additional ones, after those that write the files
    about : entries that the summary has besides those of `summary_of`

    Raises InputError, before the folder is changed, for what cannot fly; RunError for a flight that fails and
    KeyboardInterrupt, both with a message that says what was kept.
    """
    kept = folder.kept
    simulation = replace(simulation, metrics=simulation.metrics.kept_in(folder.path / STEPS_LOG))
    notes = folder.notes(simulation, about)

    def memory() -> Memory:
        return Memory(flight.memory(), simulation.metrics.memory(), notes)

    last = LastStep(None if kept is None else kept.state)
    watchers = [*folder.observers(simulation, memory), last, *observers]
    resume = (None, None) if kept is None else (kept.memory.flight, kept.memory.all)
    flight = simulation.integrate(watches_of(watchers), resume=resume[0])
    warnings: list[str] = []
    began, status, frames = False, "failed", 0 if kept is None else kept.frames
    with folder.held():
        folder.claim() if kept is None else folder.unpack(kept)
        try:
            with begun(simulation.system, watchers, resume=resume[1]):
                began = True
                warnings = warnings_of_start(simulation)
                if kept is not None:
                    folder.reopen(kept, notes)
                for state in flight:
                    show(state, watchers)
                    frames += 1
            status = FINISHED
        except RunError as error:
            status = f"failed: {error}"
            raise RunError(f"{error}; {_kept(frames)} in {folder.path}") from error
        except KeyboardInterrupt:
            status = "interrupted"
            t = simulation.start.t if last.state is None else last.state.t
            raise KeyboardInterrupt(
                f"interrupted at t = {t:.4g} s; {_kept(frames)} in {folder.path}"
            ) from None
        except Exception as error:
            status = f"failed: {type(error).__name__}: {error}"
            raise
        finally:
            if began:
                summary = summary_of(
                    simulation,
                    status=status,
                    statistics=flight.statistics,
                    impulses=flight.impulses,
                    fired=flight.fired,
                    last=last.state,
                    resumes=notes["resumes"],
                    notes=flight.notes,
                    warnings=[*warnings, *flight.warnings],
                )
                summary |= notes["about"]
                folder.write_summary(summary)
                folder.close(simulation.metrics, status=status)
    return summary


def _kept(frames: int) -> str:
    return "the one frame up to then is" if frames == 1 else f"the {frames} frames up to then are"
