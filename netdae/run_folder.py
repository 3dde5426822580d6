"""The output folder of a run: which files are in it, the flight into it, and what its summary tells."""

from __future__ import annotations

import contextlib
import json
import math
import os
import re
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from platform import python_version
from typing import Any

import netdae
from netdae._files import reason_of, write_whole
from netdae.errors import InputError, RunError
from netdae.flight import shown, watches_of
from netdae.ida import SUNDIALS_VERSION
from netdae.observers import Checkpoint, MetricsCsv, Recorder
from netdae.scenario import Scenario
from netdae.simulation import Simulation
from netdae.stable_step import cheaper_method
from netdae.state import State
from netdae.system import System

SERIES, METRICS, TRAJECTORY = "series.pvd", "metrics.csv", "trajectory.npz"
CHECKPOINT, SUMMARY, SCENARIO = "checkpoint.npz", "summary.json", "scenario.toml"
FILES = (SERIES, METRICS, TRAJECTORY, CHECKPOINT, SUMMARY, SCENARIO)
"""Files of a run, beside the folder `frames`."""

_FRAME = re.compile(r"frame_\d{6,}\.vtu(\.part)?")
_MEMBER = re.compile(r"member_\d{3,}")


class RunFolder:
    """A folder that takes the files of one run of a scenario.

    frames : whether series.pvd and the folder `frames` are written

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
    ) -> None:
        self.path = Path(path)
        self.frames = frames
        self._scenario = scenario
        former = self._former()
        own = (scenario.text, scenario.copy)
        if [file.name for file in former] == [SCENARIO] and former[0].read_bytes() not in own:
            raise InputError(
                f"{self.path}: {SCENARIO} in it is not of a run: choose another output folder by -o"
            )
        if former and not overwrite:
            raise InputError(
                f"{self.path}: a former run is in this folder ({former[0].relative_to(self.path).as_posix()}): "
                "choose another by -o, or replace the run by --overwrite"
            )
        read = {file.resolve() for file in scenario.files}
        lost = next((file for file in former if file.resolve() in read), None)
        if lost is not None:
            raise InputError(
                f"{lost}: --overwrite would delete this file, which the scenario reads: "
                "choose another output folder by -o"
            )

    def claim(self) -> None:
        """Make the folder, take the files of a former run away, copy the scenario; raises InputError."""
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            former = self._former()
            for file in former:
                file.unlink()
            for folder in sorted({file.parent for file in former} - {self.path}, reverse=True):
                _remove_if_empty(folder)
            copy = self.path / SCENARIO
            if copy.resolve() != self._scenario.path.resolve():
                write_whole(copy, self._scenario.copy)
            if self.frames:
                (self.path / "frames").mkdir(exist_ok=True)
        except OSError as error:
            raise self._not_writable(error) from error

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
            source = self._scenario.path.resolve()
            found = [file for folder in [self.path, *members] for file in _written_in(folder)]
            return [file for file in found if file.resolve() != source]
        except OSError as error:
            raise self._not_writable(error) from error

    def observers(self, simulation: Simulation) -> list[Any]:
        """Observers that measure a flight and write its files; the metrics come first."""
        series: list[Any] = []
        if self.frames:
            from netdae.vtk import VtuSeries  # VTK's import takes 0.2 s

            series.append(VtuSeries(self.path / SERIES))
        return [
            simulation.metrics,
            MetricsCsv(self.path / METRICS, simulation.metrics),
            *series,
            Checkpoint(self.path / CHECKPOINT),
            Recorder(self.path / TRAJECTORY),
        ]

    def write_summary(self, summary: Mapping[str, Any]) -> None:
        """Write summary.json, whole; numbers that are not finite become null. Raises RunError."""
        text = json.dumps(_plain(summary), indent=2, allow_nan=False, ensure_ascii=False) + "\n"
        try:
            write_whole(self.path / SUMMARY, text.encode())
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

    observers : further ones, after those that write the files
    about : entries that the summary has beside those of `summary_of`

    Raises InputError for what cannot fly before the folder is changed; RunError for a flight that fails and
    KeyboardInterrupt, both with a message that says what was kept.
    """
    last = LastStep()
    watchers = [*folder.observers(simulation), last, *observers]
    flight = simulation.integrate(watches_of(watchers))
    folder.claim()
    status, frames = "failed", 0
    try:
        for _ in shown(flight, simulation.system, watchers):
            frames += 1
        status = "finished"
    except RunError as error:
        status = f"failed: {error}"
        raise RunError(f"{error}; {_kept(frames)} in {folder.path}") from error
    except KeyboardInterrupt:
        status = "interrupted"
        t = simulation.start.t if last.state is None else last.state.t
        raise KeyboardInterrupt(f"interrupted at t = {t:.4g} s; {_kept(frames)} in {folder.path}") from None
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
        summary |= about or {}
        folder.write_summary(summary)
    return summary


def _kept(frames: int) -> str:
    return "the one frame up to then is" if frames == 1 else f"the {frames} frames up to then are"


class LastStep:
    """Observer that keeps the State of the last internal step."""

    def __init__(self) -> None:
        self.state: State | None = None

    def watch(self, state: State) -> None:
        """Keep it."""
        self.state = state

    def __call__(self, state: State) -> None:
        """Nothing at a frame, so that the figures do not depend on the frames."""


def summary_of(
    simulation: Simulation,
    *,
    status: str,
    statistics: Mapping[str, Any],
    impulses: Sequence[tuple[float, Any]],
    last: State | None,
) -> dict[str, Any]:
    """What summary.json tells: no figure in it depends on the number of frames.

    status : "finished", "interrupted" or "failed: " with the reason
    statistics, impulses : of the `Integration`
    last : State of the last internal step, None if there is none
    """
    system, options = simulation.system, simulation.options
    figures = {} if last is None else simulation.metrics.summary()
    warnings = [*simulation.findings, *figures.pop("warnings", [])]
    return {
        "title": simulation.title,
        "status": status,
        "net": net_figures(system),
        "solver": {
            "begin": float(simulation.times[0]),
            "end": float(simulation.times[-1]),
            "reached": None if last is None else last.t,
            "accuracy": options.accuracy,
            "max_step": options.max_step,
            **options.in_force,
            "cheaper": cheaper_method(system),
            **statistics,
        },
        "deployment": figures,
        "restraints": [] if last is None else _reactions(simulation, last),
        "impulses": [{"time": t, "impulse": list(map(float, impulse))} for t, impulse in impulses],
        "warnings": warnings,
        "versions": versions(),
    }


def net_figures(system: System) -> dict[str, Any]:
    """What the summary tells of a net."""
    return {
        "nodes": system.net.node_count,
        "cables": system.net.cable_count,
        "mass": float(system.mass.sum()),
        "cable_mass": float(system.cords.linear_density @ system.net.rest_length),
    }


def _reactions(simulation: Simulation, last: State) -> list[dict[str, Any]]:
    """Sums over the nodes of each restraint at the last internal step, with the loads as they are just before."""
    system = simulation.system
    begin = float(simulation.times[0])
    *_, (_, _, phase) = system.phases(begin, last.t) if last.t > begin else [(begin, begin, system)]
    forces = phase.reactions(last.t, last.x, last.v, last.a)
    told = []
    for restraint in system.restraints:
        total = [0.0, 0.0, 0.0]
        for axis in restraint.axis_indices:
            total[axis] = float(forces[system.net.nodes_of(restraint.group), axis].sum())
        told.append({"group": restraint.group, "axes": restraint.axes, "final_reaction": total})
    return told


def versions() -> dict[str, str]:
    """Versions of netdae and of what its figures stand on."""
    packages = ("numpy", "scipy", "numba", "scikit-sundae")
    return {
        "netdae": netdae.__version__,
        "python": python_version(),
        **{name: version(name) for name in packages},
        "sundials": SUNDIALS_VERSION,
    }


def _plain(value: Any) -> Any:
    """Mappings, lists, numbers and text as JSON has them."""
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if hasattr(value, "item"):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
