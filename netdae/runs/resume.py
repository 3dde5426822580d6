"""Resuming a run that was stopped, or has ended: its folder, checked, and the flight that is left.

The notes in its checkpoint are: netdae, the version; scenario, the digests; end, s; frames, whether there are frames
for ParaView; resumes, a list of time and end, s, of each resume; about, additional entries of the summary; and
status, of a flight that has ended.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import netdae
from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.initial.disturbed import disturbed
from netdae.output.checkpoint import Kept, read_kept
from netdae.runs.folder import CHECKPOINT, FILES, FINISHED, SCENARIO, RunFolder
from netdae.scenario.digest import check_digests
from netdae.scenario.output import MOST_FRAMES
from netdae.scenario.reader import Scenario, read_scenario
from netdae.scenario.simulation import Simulation

SAME_FRAME = 1e-6
"""Frames closer than this share of their spacing count as one."""


@dataclass(frozen=True, eq=False)
class StoppedRun:
    """The folder of a run that can go on.

    kept : of its checkpoint
    end : s, where the flight is to end now
    """

    folder: RunFolder
    scenario: Scenario
    kept: Kept
    end: float

    @property
    def reached(self) -> float:
        """Time of the last frame, s."""
        return self.kept.state.t

    def build(self) -> Simulation:
        """The simulation up to `end`, with frames at the spacing of the scenario; raises InputError."""
        solver, frames = self.scenario.data.solver, self.scenario.data.output.frames
        times = np.linspace(solver.begin, solver.end, frames)
        count = (self.end - solver.begin) / (times[1] - times[0])
        if count > MOST_FRAMES:
            raise InputError(
                f"--until is {self.end:g} s, which takes {count:.3g} frames {times[1] - times[0]:g} s apart: give a "
                f"time that takes {MOST_FRAMES} at most"
            )
        update = {"solver": solver.model_copy(update={"end": self.end})}
        scenario = replace(self.scenario, data=self.scenario.data.model_copy(update=update))
        member = self.kept.memory.notes["about"].get("member", {})
        simulation = (scenario.scattered(member["number"]) if member.get("scatter") else scenario).build()
        start = simulation.start
        if member:
            drawn = (member["seed"], member["number"])
            start = disturbed(start, member["perturb"], drawn, simulation.system.restrained)
        return replace(simulation, start=start, times=times_to(self.end, times, self.reached))


def times_to(end: float, times: FloatArray, reached: float) -> FloatArray:
    """Times (k,) of frames up to `end`, s, at the even spacing of `times`; `reached` is the time of a frame."""
    begin, spacing = times[0], times[1] - times[0]
    more = begin + spacing * np.arange(len(times), math.floor((end - begin) / spacing) + 1)
    grid = np.concatenate((times, more))
    near = SAME_FRAME * spacing
    grid = grid[(grid < end - near) & ((grid == reached) | (np.abs(grid - reached) > near))]
    return np.append(grid, end)


def read_stopped_run(path: str | os.PathLike[str], *, until: float | None = None) -> StoppedRun:
    """The run in a folder, to be resumed.

    until : s, a new end of the flight; by default the one that it was flying to

    Raises InputError for a folder without a run, one whose checkpoint is missing, damaged or of another scenario,
    a run that has finished, unless it is to be extended, one that has come as far as `until`, and one that an event has
    stopped.
    """
    source = Path(path)
    if not source.is_dir():
        what = "is a file, not a folder" if source.exists() else "is not there"
        raise InputError(f"{source} {what}: give the output folder of a run")
    if not (source / CHECKPOINT).exists():
        raise InputError(f"{source}: {_why_without_checkpoint(source)}")
    kept = read_kept(source / CHECKPOINT)
    notes = kept.memory.notes
    if notes["netdae"] != netdae.__version__:
        raise InputError(
            f"{source}: its checkpoint is of netdae {notes['netdae']}, this is {netdae.__version__}: resume it with "
            "that version, or fly its scenario afresh"
        )
    scenario = read_scenario(source / SCENARIO)
    check_digests(
        scenario, notes["scenario"], since=f"the checkpoint at t = {kept.state.t:.6g} s was written"
    )
    end = _end_of(source, kept, until)
    folder = RunFolder(source, scenario, frames=notes["frames"], kept=kept)
    return StoppedRun(folder, scenario, kept, end)


def _why_without_checkpoint(folder: Path) -> str:
    inside = {file.name for file in folder.iterdir()}
    if any(name.startswith("member_") for name in inside):
        return "an ensemble is in this folder: resume one of its members, or fly it afresh with --overwrite"
    if inside & {*FILES}:
        return (
            f"there is no {CHECKPOINT}, since its run was stopped before the first frame or never begun: fly it "
            "afresh with --overwrite"
        )
    return "this is not the folder of a run: give the one that netdae run wrote"


def _end_of(folder: Path, kept: Kept, until: float | None) -> float:
    notes: Any = kept.memory.notes
    reached = kept.state.t
    if until is None:
        if notes.get("status") == FINISHED:
            raise InputError(
                f"{folder}: this run has finished, at t = {reached:.6g} s: give --until a later time to fly on"
            )
        return float(notes["end"])
    if not math.isfinite(until):
        raise InputError(f"--until is {until:g}: give a time in s")
    if notes.get("status") == FINISHED and reached < notes["end"]:
        raise InputError(
            f"{folder}: an event has stopped this run at t = {reached:.6g} s, as its scenario asks: to fly on, take "
            'action = "stop" from it and fly it afresh'
        )
    if until <= reached:
        raise InputError(
            f"--until is {until:g} s, but {folder} has come to t = {reached:.6g} s: give a later time"
        )
    return until
