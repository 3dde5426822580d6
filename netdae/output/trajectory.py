"""The observer that keeps all frames of a flight, for trajectory.npz."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import RunError
from netdae.core.files import reason_of
from netdae.model.state import State, Trajectory
from netdae.output.step_log import StepLog

if TYPE_CHECKING:
    from netdae.system.system import System


class Recorder:
    """Observer that keeps all frames, and writes them to a file at the end, also of a run that failed.

    path : the trajectory.npz, or None to keep them in memory only

    Until the end the frames are kept in a log beside the file, so that they need no memory, survive a kill, and
    can be resumed from; the log is removed when the file is complete.
    """

    def __init__(self, path: str | os.PathLike[str] | None = None) -> None:
        self.path = None if path is None else Path(path)
        self._log: StepLog | None = None

    @property
    def states(self) -> list[State]:
        """The frames so far."""
        return [] if self._log is None else list(self.trajectory())

    def begin(self, system: System) -> None:
        """Forget the frames of a former flight."""
        self._log = self._log_for(system.net.node_count, 0 if system.body is None else 4)
        self._log.clear()

    def resume(self, system: System, memory: Mapping[str, Any]) -> None:
        """Keep the frames that the flight has yielded; raises InputError where they are missing."""
        log = self._log_for(system.net.node_count, 0 if system.body is None else 4)
        if log.path is not None and self.path is not None:
            if log.path.exists():
                log.reopen()
            else:
                log.fill(_rows_of(Trajectory.load(self.path)))
        log.keep(int(memory["frames"]))
        self._log = log

    def __call__(self, state: State) -> None:
        """Keep a State."""
        if self._log is None:
            self._log = self._log_for(len(state.x), len(state.attitude))
            self._log.clear()
        self._log.append(_row_of(state))
        self._log.flush()

    def trajectory(self) -> Trajectory:
        """The frames so far; at least one."""
        if self._log is None:
            raise RuntimeError("no frame was shown to the Recorder")
        return _trajectory_of(self._log.rows())

    def end(self) -> None:
        """Write the file if there is a path and a frame."""
        if self.path is None or self._log is None:
            return
        try:
            if len(self._log):
                self.trajectory().save(self.path)
            self._log.remove()
        except OSError as error:
            self._log.close()
            raise RunError(f"{self.path} could not be written: {reason_of(error)}") from error
        self._log = None

    def _log_for(self, nodes: int, attitude: int) -> StepLog:
        path = None if self.path is None else self.path.with_suffix(".log")
        return StepLog(_PLACES + 9 * nodes + attitude, path)


_PLACES = 10  # of time and balance, before x, v and a


def _row_of(state: State) -> FloatArray:
    balance = state.balance
    return np.concatenate(
        (
            (state.t, balance.dissipated_energy, balance.external_work, balance.peak_tension),
            (*balance.external_impulse, *balance.external_angular_impulse),
            *(array.ravel() for array in (state.x, state.v, state.a)),
            state.attitude,
        )
    )


def _rows_of(trajectory: Trajectory) -> FloatArray:
    return np.array([_row_of(state) for state in trajectory])


def _trajectory_of(rows: FloatArray) -> Trajectory:
    """Trajectory of the rows (k, 10 + 9 n), or 4 more with a target: views, so that rows on disk stay there."""
    nodes = (rows.shape[1] - _PLACES) // 9
    x, v, a = (
        rows[:, _PLACES + 3 * nodes * k : _PLACES + 3 * nodes * (k + 1)].reshape(-1, nodes, 3)
        for k in range(3)
    )
    return Trajectory(
        times=rows[:, 0].copy(),
        positions=x,
        velocities=v,
        accelerations=a,
        dissipated_energy=rows[:, 1].copy(),
        external_work=rows[:, 2].copy(),
        peak_tension=rows[:, 3].copy(),
        external_impulse=rows[:, 4:7].copy(),
        external_angular_impulse=rows[:, 7:10].copy(),
        attitudes=rows[:, _PLACES + 9 * nodes :].copy(),
    )
