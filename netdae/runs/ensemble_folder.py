"""The output folder of an ensemble: a run folder for each member, and the figures over all of them."""

from __future__ import annotations

import csv
import io
import json
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.compilation import COMPILING, reported_when_compiling
from netdae.core.errors import RunError
from netdae.core.files import reason_of, write_whole
from netdae.model.state import State
from netdae.output.metrics import COLUMNS
from netdae.runs.ensemble import STATISTICS, Ensemble, bands_of, common_warnings, events_over, figures_over
from netdae.runs.folder import FINISHED, METRICS, SUMMARY, RunFolder, fly
from netdae.runs.summary import net_figures, versions
from netdae.runs.workers import Outcome, Tell
from netdae.scenario.reader import Scenario
from netdae.scenario.simulation import Simulation


@dataclass(frozen=True, eq=False)
class Member:
    """A member of an ensemble: all that a process needs to fly it.

    folder : of the ensemble; the member's own is in it
    frames : whether the member's folder gets frames for ParaView
    """

    scenario: Scenario
    ensemble: Ensemble
    number: int
    folder: Path
    frames: bool

    @property
    def name(self) -> str:
        """Of the member and its folder."""
        return f"member_{self.number:03d}"


class EnsembleFolder:
    """A folder that takes the files of one ensemble.

    all_frames : whether each member gets frames; else the first alone does

    Raises InputError as `RunFolder` does; nothing is changed before `claim`.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        scenario: Scenario,
        ensemble: Ensemble,
        *,
        overwrite: bool = False,
        all_frames: bool = False,
    ) -> None:
        self.path = Path(path)
        self.ensemble = ensemble
        self._own = RunFolder(path, scenario, overwrite=overwrite, frames=False)
        self.members = [
            Member(scenario, ensemble, number, self.path, all_frames or number == 0)
            for number in range(ensemble.size)
        ]

    def claim(self) -> None:
        """Make the folder and remove the files of a former run or ensemble; raises InputError."""
        self._own.claim()

    def close(
        self,
        simulation: Simulation,
        outcomes: Sequence[Outcome],
        *,
        interrupted: bool,
        about: Mapping[str, Any],
    ) -> dict[str, Any]:
        """Write metrics.csv and summary.json over the members that have finished; return the summary.

        outcomes : of the members that have ended, in any order
        about : other entries of the summary's section `ensemble`
        """
        result = [_read_summary(self.path / member.name / SUMMARY) for member in self.members]
        errors = {outcome.number: outcome.error for outcome in outcomes if outcome.error is not None}
        finished = {
            member.name: summary
            for member, summary in zip(self.members, result, strict=True)
            if summary.get("status") == FINISHED and member.number not in errors
        }
        self._write_metrics([_read_table(self.path / name / METRICS) for name in finished])
        failed = {self.members[number].name: errors[number] for number in sorted(errors)}
        status = f"failed: {len(failed)} of {len(self.members)} members failed" if failed else FINISHED
        summary = {
            "title": simulation.title,
            "status": "interrupted" if interrupted else status,
            "ensemble": {**asdict(self.ensemble), "finished": len(finished), **about},
            "net": net_figures(simulation.system),
            "deployment": figures_over([each["deployment"] for each in finished.values()]),
            "tether": figures_over([each["tether"] for each in finished.values()]),
            "events": events_over([each["events"] for each in finished.values()]),
            "solver": figures_over([_counts(each["solver"]) for each in finished.values()]),
            "members": [
                {"folder": member.name, "status": self._status(member, summary, errors)}
                for member, summary in zip(self.members, result, strict=True)
            ],
            "notes": [*simulation.notes],
            "warnings": [
                *(f"{name} failed and is left out: {error}" for name, error in failed.items()),
                *common_warnings({name: each["warnings"] for name, each in finished.items()}),
            ],
            "versions": versions(),
        }
        self._own.write_summary(summary)
        return summary

    @staticmethod
    def _status(member: Member, summary: Mapping[str, Any], errors: Mapping[int, str]) -> str:
        if member.number in errors:
            return f"failed: {errors[member.number]}"
        return str(summary.get("status", "not flown"))

    def _write_metrics(self, tables: Sequence[Mapping[str, FloatArray]]) -> None:
        names = ["time", *(f"{name}_{part}" for name in COLUMNS[1:] for part in STATISTICS)]
        bands = bands_of(tables) if tables else dict.fromkeys(names, np.empty(0))
        rows = np.column_stack([bands[name] for name in names]).tolist()
        text = "".join(",".join(row) + "\n" for row in [names, *([*map(repr, row)] for row in rows)])
        try:
            write_whole(self.path / METRICS, text.encode())
        except OSError as error:
            raise RunError(f"{self.path / METRICS} could not be written: {reason_of(error)}") from error


def fly_member(member: Member, report: Tell) -> None:
    """Fly a member into its folder: the task of a worker.

    Reports ("compiling", a line) when kernels have to be compiled, and ("flown", the share of the time) now and then.
    """
    with reported_when_compiling(lambda: report(("compiling", COMPILING))):
        ensemble = member.ensemble
        simulation = (
            member.scenario.scattered(member.number) if ensemble.scatter else member.scenario
        ).build()
        start = ensemble.start(member.number, simulation.start, simulation.system.restrained)
        folder = RunFolder(member.folder / member.name, member.scenario, frames=member.frames)
        chosen = {"perturb": ensemble.perturb, "seed": ensemble.seed, "scatter": ensemble.scatter}
        about = {"member": {"number": member.number, **chosen}}
        fly(replace(simulation, start=start), folder, observers=[_Teller(simulation, report)], about=about)


class _Teller:
    """Observer that reports how much of the time is flown; a report also ends the flight when it is to stop."""

    _PAUSE = 0.2  # s between two messages

    def __init__(self, simulation: Simulation, report: Tell) -> None:
        self._begin, self._end = float(simulation.times[0]), float(simulation.times[-1])
        self._report = report
        self._reported = 0.0

    def watch(self, state: State) -> None:
        """Report, if some time has passed."""
        now = time.monotonic()
        if now - self._reported > self._PAUSE:
            self._reported = now
            self._report(("flown", (state.t - self._begin) / (self._end - self._begin)))

    def __call__(self, state: State) -> None:
        """Nothing at a frame: progress is reported at the steps."""


def _counts(solver: Mapping[str, Any]) -> dict[str, int]:
    """The counts of the solver: whole numbers, and no settings."""
    return {
        name: value
        for name, value in solver.items()
        if isinstance(value, int) and not isinstance(value, bool) and name != "max_order"
    }


def _read_summary(path: Path) -> dict[str, Any]:
    """A member's summary, empty if it has none."""
    try:
        result: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    return result


def _read_table(path: Path) -> dict[str, FloatArray]:
    rows = list(csv.reader(io.StringIO(path.read_text(encoding="utf-8"))))
    columns = np.array(rows[1:], dtype=np.float64).T
    return dict(zip(rows[0], columns, strict=True))
