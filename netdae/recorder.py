"""The observer that keeps all frames of a flight, for trajectory.npz."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from netdae._arrays import FloatArray
from netdae._files import reason_of
from netdae.errors import RunError
from netdae.journal import Journal
from netdae.state import State, Trajectory

if TYPE_CHECKING:
    from netdae.system import System


class Recorder:
    """Observer that keeps all frames, and writes them to a file at the end, also of a run that failed.

    path : the trajectory.npz, or None to keep them in memory only

    Until the end the frames stand in a journal beside the file, so that they need no memory, outlive a kill, and
    can be gone on from; the journal is taken away when the file is complete.
    """

    def __init__(self, path: str | os.PathLike[str] | None = None) -> None:
        self.path = None if path is None else Path(path)
        self._journal: Journal | None = None

    @property
    def states(self) -> list[State]:
        """The frames so far."""
        return [] if self._journal is None else list(self.trajectory())

    def begin(self, system: System) -> None:
        """Forget the frames of a former flight."""
        self._journal = self._journal_for(system.net.node_count)
        self._journal.clear()

    def resume(self, system: System, memory: Mapping[str, Any]) -> None:
        """Keep the frames that the flight has yielded; raises InputError where they are not there."""
        journal = self._journal_for(system.net.node_count)
        if journal.path is not None and self.path is not None:
            if journal.path.exists():
                journal.reopen()
            else:
                journal.fill(_rows_of(Trajectory.load(self.path)))
        journal.keep(int(memory["frames"]))
        self._journal = journal

    def __call__(self, state: State) -> None:
        """Keep a State."""
        if self._journal is None:
            self._journal = self._journal_for(len(state.x))
            self._journal.clear()
        self._journal.append(_row_of(state))
        self._journal.flush()

    def trajectory(self) -> Trajectory:
        """The frames so far; at least one."""
        if self._journal is None:
            raise RuntimeError("no frame was shown to the Recorder")
        return _trajectory_of(self._journal.rows())

    def end(self) -> None:
        """Write the file if there is a path and a frame."""
        if self.path is None or self._journal is None:
            return
        try:
            if len(self._journal):
                self.trajectory().save(self.path)
            self._journal.remove()
        except OSError as error:
            self._journal.close()
            raise RunError(f"{self.path} could not be written: {reason_of(error)}") from error
        self._journal = None

    def _journal_for(self, nodes: int) -> Journal:
        path = None if self.path is None else self.path.with_suffix(".journal")
        return Journal(_PLACES + 9 * nodes, path)


_PLACES = 10  # of time and books, before x, v and a


def _row_of(state: State) -> FloatArray:
    books = state.books
    return np.concatenate(
        (
            (state.t, books.dissipated_energy, books.external_work, books.peak_tension),
            (*books.external_impulse, *books.external_angular_impulse),
            *(array.ravel() for array in (state.x, state.v, state.a)),
        )
    )


def _rows_of(trajectory: Trajectory) -> FloatArray:
    return np.array([_row_of(state) for state in trajectory])


def _trajectory_of(rows: FloatArray) -> Trajectory:
    """Trajectory of the rows (k, 10 + 9 n): views, so that rows on disk stay there."""
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
    )
