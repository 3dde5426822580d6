"""A snapshot of a flight, from which it can go on, and the arrays in which it is kept."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.model.state import EnergyBalance, State

Memory = Mapping[str, Any]
"""What a flight needs to go on: names to arrays, see `Integration.memory`."""

_SOLVER, _EVENTS = "solver.", "events."


class Snapshot(NamedTuple):
    """A flight between two calls of the integrator.

    state : with its balance
    stage, phase : s, where the running stage and phase began
    frame : s, of the last frame before
    fired : times of the events that have happened, by name
    impulses : (time, impulse (3,) in N s) of jumps of velocity
    counts, seconds : of the integrator
    solver, events : what the integrator and the event search need to go on
    shown : how many internal steps the watchers have seen
    stopped : whether an event has ended the flight here
    """

    state: State
    stage: float
    phase: float
    frame: float
    fired: Mapping[str, float]
    impulses: tuple[tuple[float, FloatArray], ...]
    counts: Mapping[str, int]
    seconds: Mapping[str, float]
    solver: Mapping[str, FloatArray]
    events: Mapping[str, Any]
    shown: int
    stopped: bool

    def memory(self, frames: int, frame: float, anchor: FloatArray, total_seconds: float) -> dict[str, Any]:
        """As arrays, with the number of frames yielded, the time of the last one, and the anchors of driven nodes."""
        state, balance = self.state, self.state.balance
        return {
            "t": np.array(state.t),
            "frames": np.array(frames),
            "frame": np.array(frame),
            "frame_before": np.array(self.frame),
            "stage": np.array(self.stage),
            "phase": np.array(self.phase),
            "x": state.x,
            "v": state.v,
            "a": state.a,
            "attitude": state.attitude,
            "anchor": anchor,
            "balance": np.array([balance.dissipated_energy, balance.external_work, balance.peak_tension]),
            "impulse": np.array([balance.external_impulse, balance.external_angular_impulse]),
            **_table("fired", self.fired, np.float64),
            "impulse_times": np.array([t for t, _ in self.impulses], dtype=np.float64),
            "impulses": np.array([p for _, p in self.impulses], dtype=np.float64).reshape(-1, 3),
            **_table("counts", self.counts, np.int64),
            **_table("seconds", self.seconds, np.float64),
            "total_seconds": np.array(total_seconds),
            "shown": np.array(self.shown),
            "stopped": np.array(self.stopped),
            **{f"{_SOLVER}{name}": array for name, array in self.solver.items()},
            **{f"{_EVENTS}{name}": array for name, array in self.events.items()},
        }

    @classmethod
    def of(cls, memory: Memory) -> Snapshot:
        """The snapshot that left this memory."""
        dissipated, work, peak = memory["balance"].tolist()
        impulse, angular = (tuple(row) for row in memory["impulse"].tolist())
        balance = EnergyBalance(dissipated, work, impulse, peak, angular)
        x, v, a = (np.array(memory[name]) for name in "xva")
        return cls(
            State(float(memory["t"]), x, v, a, balance, np.array(memory.get("attitude", ()))),
            float(memory["stage"]),
            float(memory["phase"]),
            float(memory["frame_before"]),
            _from_table("fired", memory),
            tuple(zip(memory["impulse_times"].tolist(), memory["impulses"], strict=True)),
            _from_table("counts", memory),
            _from_table("seconds", memory),
            _beginning_with(_SOLVER, memory),
            _beginning_with(_EVENTS, memory),
            int(memory["shown"]),
            bool(memory["stopped"]),
        )


def _table(name: str, values: Mapping[str, float], dtype: type) -> dict[str, Any]:
    """Names and values as two arrays."""
    return {
        f"{name}_names": np.array(list(values), dtype=np.str_),
        name: np.array(list(values.values()), dtype=dtype),
    }


def _from_table(name: str, memory: Memory) -> dict[str, Any]:
    return dict(zip(memory[f"{name}_names"].tolist(), memory[name].tolist(), strict=True))


def _beginning_with(kind: str, memory: Memory) -> dict[str, Any]:
    return {name.removeprefix(kind): memory[name] for name in memory if name.startswith(kind)}
