"""The checkpoint of a flight: the last frame, and all that is needed to continue from it in another process.

It is a .npz file, complete at every moment, with the arrays of the frame's State and its balance by their names, those
of the flight's memory as flight.<name>, those of its observers as observers.<name>, and `notes` in JSON.
"""

from __future__ import annotations

import io
import json
import os
import struct
import zipfile
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from netdae.core.archives import check_archive
from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError, RunError
from netdae.core.files import reason_of, write_whole
from netdae.model.state import EnergyBalance, State

if TYPE_CHECKING:
    from netdae.system.system import System

FORMAT = 1
"""Of the file; a flight cannot be resumed from a file of another format."""

_FLIGHT, _OBSERVERS, _NOTES, _HISTORY = "flight.", "observers.", "notes", "history"
_BOOKS = (
    "dissipated_energy",
    "external_work",
    "external_impulse",
    "peak_tension",
    "external_angular_impulse",
)
_DAMAGED = (
    ValueError,
    KeyError,
    EOFError,
    TypeError,
    AttributeError,
    RuntimeError,
    OverflowError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
)


class Memory(NamedTuple):
    """What a checkpoint holds besides the frame.

    flight : of `Integration.memory`
    observers : what observers of the flight need for their `resume`
    notes : data that JSON can hold
    """

    flight: Mapping[str, NDArray[Any]]
    observers: Mapping[str, NDArray[Any]]
    notes: Mapping[str, Any]

    @property
    def all(self) -> dict[str, NDArray[Any]]:
        """What observers are given to resume: both memories."""
        return {**self.observers, **self.flight}


class Checkpoint:
    """Observer that keeps the last frame, with its balance, in a .npz file: complete at every moment.

    memory : called at each frame for what is needed to continue; without it the file holds the frame alone

    It comes after the observers that write files for each frame, so that these hold all frames it refers to.
    Raises InputError where nothing can be written, RunError when a frame cannot be.
    """

    def __init__(self, path: str | os.PathLike[str], *, memory: Callable[[], Memory] | None = None) -> None:
        self.path = Path(path)
        self._memory = memory

    def begin(self, system: System) -> None:
        """Make the folder and remove a former checkpoint."""
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.path.unlink(missing_ok=True)
        except OSError as error:
            raise InputError(
                f"{self.path} cannot be written: {reason_of(error)}: choose another output folder"
            ) from error

    def resume(self, system: System, memory: Mapping[str, Any]) -> None:
        """Keep the checkpoint from which the flight is resumed until the next frame."""

    def __call__(self, state: State) -> None:
        """Write a State in place of the one before."""
        write_checkpoint(self.path, state, None if self._memory is None else self._memory())


def write_checkpoint(path: Path, state: State, memory: Memory | None = None) -> None:
    """Write a frame, and what is needed to continue from it; raises RunError."""
    content = io.BytesIO()
    np.savez(content, **_frame_of(state), **({} if memory is None else _arrays_of(memory)))
    try:
        write_whole(path, content.getvalue())
    except OSError as error:
        raise RunError(
            f"the checkpoint at t = {state.t:g} s could not be written to {path}: {reason_of(error)}"
        ) from error


@dataclass(frozen=True, eq=False)
class Kept:
    """What `read_kept` finds in a checkpoint.

    state : the last frame
    memory : what is needed to continue from it
    history : rows of the metrics' history, (k, w), in the checkpoint of a flight that has ended; else None
    """

    state: State
    memory: Memory
    history: FloatArray | None = None

    @property
    def frames(self) -> int:
        """How many frames there are up to this one."""
        return int(self.memory.flight["frames"])


def read_checkpoint(path: str | os.PathLike[str]) -> State:
    """The State that a `Checkpoint` kept; raises InputError for any other file."""
    return _state_of(_read(Path(path)))


def read_kept(path: str | os.PathLike[str]) -> Kept:
    """All that a `Checkpoint` kept; raises InputError for any other file, and for one that cannot be resumed from."""
    source = Path(path)
    arrays = _read(source)
    state = _state_of(arrays)
    if _NOTES not in arrays:
        raise InputError(
            f"{source} holds a State alone, nothing to go on from: give the folder of a run that netdae run wrote"
        )
    notes = json.loads(str(arrays[_NOTES]))
    if notes.get("format") != FORMAT:
        raise InputError(
            f"{source} has the format {notes.get('format')} of another netdae, expected {FORMAT}: "
            "resume it with that one, or fly the scenario afresh"
        )
    flight, observers = (
        {name.removeprefix(kind): array for name, array in arrays.items() if name.startswith(kind)}
        for kind in (_FLIGHT, _OBSERVERS)
    )
    return Kept(state, Memory(flight, observers, notes), arrays.get(_HISTORY))


def close_checkpoint(path: str | os.PathLike[str], history: FloatArray, *, status: str) -> None:
    """Add the history (k, w) and, to the notes, the status to the checkpoint of a flight that has ended; compress it.

    Raises RunError where it cannot be written.
    """
    target = Path(path)
    arrays = _read(target)
    notes = {**json.loads(str(arrays[_NOTES])), "status": status}
    arrays |= {_NOTES: np.array(json.dumps(notes)), _HISTORY: history}
    partial = target.with_name(target.name + ".part")
    try:
        with partial.open("wb") as stream:
            np.savez_compressed(stream, **arrays)
        partial.replace(target)
    except OSError as error:
        raise RunError(f"{target} could not be written: {reason_of(error)}") from error


def _frame_of(state: State) -> dict[str, Any]:
    balance = {name: np.array(getattr(state.balance, name)) for name in _BOOKS}
    return {
        "t": np.array(state.t),
        "x": state.x,
        "v": state.v,
        "a": state.a,
        "attitude": state.attitude,
        **balance,
    }


def _arrays_of(memory: Memory) -> dict[str, Any]:
    return {
        **{_FLIGHT + name: array for name, array in memory.flight.items()},
        **{_OBSERVERS + name: array for name, array in memory.observers.items()},
        _NOTES: np.array(json.dumps({**memory.notes, "format": FORMAT})),
    }


def _state_of(arrays: Mapping[str, NDArray[Any]]) -> State:
    reported: dict[str, Any] = {name: arrays[name].tolist() for name in _BOOKS}
    for name in ("external_impulse", "external_angular_impulse"):
        reported[name] = tuple(reported[name])
    attitude = np.asarray(arrays.get("attitude", ()), dtype=np.float64)
    return State(
        float(arrays["t"]), arrays["x"], arrays["v"], arrays["a"], EnergyBalance(**reported), attitude
    )


def _read(source: Path) -> dict[str, Any]:
    """All arrays of a checkpoint, with those of a State among them."""
    try:
        check_archive(source)
        with np.load(source) as found:
            arrays = {name: found[name] for name in found.files}
        for name in ("t", "x", "v", "a", *_BOOKS):
            if name not in arrays:
                raise KeyError(f"{name} is not in it")
        return arrays
    except OSError as error:
        raise InputError(
            f"{source} cannot be read: {reason_of(error)}: give the checkpoint.npz of an output folder"
        ) from error
    except _DAMAGED as error:
        reason = error.args[0] if isinstance(error, KeyError) and error.args else error
        raise InputError(
            f"{source} is not a checkpoint of netdae, or cut short: {reason}: give the checkpoint.npz of an output "
            "folder"
        ) from error
