"""The driver of a flight: phases, internal steps, output times, books.

A flight is cut at the jumps of loads and motions into phases; each starts afresh, with exact stop, consistent
accelerations and the impulse of driven nodes booked. Inside a phase kinks only stop a step. Steps do not depend
on the output times: those are read from IDA's polynomial.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from time import perf_counter
from typing import Any

import numpy as np

from netdae._arrays import FloatArray
from netdae.errors import InputError
from netdae.ledger import Ledger
from netdae.options import SolverOptions
from netdae.phases import SAME
from netdae.restraints import Drive
from netdae.state import Books, State
from netdae.stepper import Share, Step, Stepper
from netdae.system import System

Watch = Callable[[State], None]


class Integration:
    """Iterator over the States at the output times; `statistics` tells what it took so far.

    `impulses` lists the (time, impulse (3,) in N s) that restraints gave in jumps of velocity.
    """

    def __init__(
        self, system: System, start: State, times: FloatArray, options: SolverOptions, watch: Sequence[Watch]
    ) -> None:
        self._system = system
        self._start = start
        self._times = times
        self._watch = watch
        self._drive = system.drive_from(start.x)
        self._drive.check_start(start.t, start.v, float(times[-1]))
        system.check_covers(float(times[0]), float(times[-1]))
        self._method = options.method
        self._solver = _stepper_of(system, self._drive, options)
        self._ledger: Ledger | None = None
        self._seconds = 0.0
        self._states = self._run()

    def __iter__(self) -> Iterator[State]:
        return self

    def __next__(self) -> State:
        begin = perf_counter()  # what the caller does with a State is not counted
        try:
            return next(self._states)
        finally:
            self._seconds += perf_counter() - begin

    @property
    def statistics(self) -> dict[str, Any]:
        """Counts of steps, residuals, setups, solves, failures and starts, and wall seconds by part.

        Failures are told from the order of IDA's calls: a setup in the middle of an attempt at a step, or a step
        back from four corrections or from ones that shrink too slowly, is a failure of Newton's iteration; any
        other step back is one of the error test.
        """
        counts = {name: self._solver.counts[name] for name in self._solver.COUNTS}
        seconds = {name: round(value, 6) for name, value in sorted(self._solver.seconds.items())}
        return {
            "method": self._method,
            **counts,
            "wall_seconds": {"total": round(self._seconds, 6), **seconds},
        }

    @property
    def impulses(self) -> list[tuple[float, FloatArray]]:
        """Times and impulses (3,) in N s of jumps of driven velocities."""
        return [] if self._ledger is None else self._ledger.impulses

    def _run(self) -> Iterator[State]:
        outputs = list(self._times[1:])
        t0, end = float(self._times[0]), float(self._times[-1])
        x, v = self._start.x.copy(), self._start.v.copy()
        for begin, stop, phase in self._system.phases(t0, end):
            state = self._phase_start(phase, begin, x, v)
            if self._ledger is None:
                self._ledger = Ledger(phase, self._drive, state)
                yield self._told(state)
            else:
                self._ledger.enter(phase, state)
            self._show(state, self._ledger.books())
            y, yp = np.stack((state.x, state.v)), np.stack((state.v, state.a))
            self._solver.enter(phase, begin, y, yp)
            for kink, part in phase.smooth_parts(begin, stop):
                self._solver.go_on(part)
                self._ledger.go_on(part)
                while state.t < kink:
                    for step in self._solver.step(kink):
                        while outputs and outputs[0] <= step.t:
                            at = float(outputs.pop(0))
                            inner = step if at == step.t else self._solver.output(at)
                            yield self._told(self._state(part, inner), inner.share, whole=at == step.t)
                        state = self._state(part, step)
                        self._close_step(state, step.share)
            x, v = state.x, state.v

    def _phase_start(self, phase: System, t: float, x: FloatArray, v: FloatArray) -> State:
        x_d, v_d, a_d = self._drive.at(phase.inside(t))
        held = self._drive.mask
        x, v = np.where(held, x_d, x), np.where(held, v_d, v)
        return _read_only(State(t, x, v, phase.acceleration(t, x, v, a_d)))

    def _state(self, phase: System, step: Step) -> State:
        x, v, a = step.y[0], step.y[1], step.yp[1]
        held = self._drive.mask
        if held.any():  # IDA's yp is a difference quotient there, and its y between steps a polynomial
            x_d, v_d, a_d = self._drive.at(phase.inside(step.t))
            x, v, a = np.where(held, x_d, x), np.where(held, v_d, v), np.where(held, a_d, a)
        return _read_only(State(step.t, x, v, a))

    def _told(self, state: State, share: Share | None = None, *, whole: bool = True) -> State:
        """State for an output time, with the books up to it; `whole` where an internal step ends there."""
        assert self._ledger is not None
        return State(state.t, state.x, state.v, state.a, self._ledger.at(state, share, whole=whole))

    def _close_step(self, state: State, share: Share | None) -> None:
        assert self._ledger is not None
        begin = perf_counter()
        books = self._ledger.advance(state, share)
        self._solver.seconds["books"] += perf_counter() - begin
        self._show(state, books)

    def _show(self, state: State, books: Books) -> None:
        begin = perf_counter()
        told = State(state.t, state.x, state.v, state.a, books)
        for watch in self._watch:
            watch(told)
        self._solver.seconds["watchers"] += perf_counter() - begin


def _read_only(state: State) -> State:
    """The state, which no watcher can change any more."""
    for array in (state.x, state.v, state.a):
        array.flags.writeable = False
    return state


_STEPPERS = {
    "ida": ("netdae.ida", "IdaSolver"),
    "explicit": ("netdae.explicit", "ExplicitSolver"),
    "cvode_bdf": ("netdae.cvode", "CvodeSolver"),
    "cvode_adams": ("netdae.cvode", "CvodeSolver"),
}


def _stepper_of(system: System, drive: Drive, options: SolverOptions) -> Stepper:
    """The integrator of a method; SUNDIALS is slow to load, so each comes when it is asked for."""
    module, name = _STEPPERS.get(options.method, ("netdae.ivp", "IvpSolver"))
    return getattr(import_module(module), name)(system, drive, options)


def integrate(
    system: System,
    start: State,
    times: Sequence[float] | FloatArray,
    *,
    options: SolverOptions | None = None,
    watch: Sequence[Watch] = (),
) -> Integration:
    """Fly `system` from `start` and yield the States at `times`, of which the first is the start's.

    watch : callables that see the State at the start and at every internal step of the integrator

    Raises InputError for times that do not rise or a start that contradicts a restraint, RunError for a run that fails.
    """
    instants = np.asarray(times, dtype=np.float64)
    if instants.ndim != 1 or len(instants) < 2 or not np.isfinite(instants).all():
        raise InputError("times: give at least two finite instants")
    if (np.diff(instants) <= 2 * SAME * np.spacing(np.abs(instants).max())).any():
        raise InputError("times: they do not rise, or by no more than round-off: give instants that rise")
    if instants[0] != start.t:
        raise InputError(
            f"times: they begin at {instants[0]:g} s, but the start is at {start.t:g} s: let them agree"
        )
    for name, values in (("x", start.x), ("v", start.v)):
        if values.shape != (system.net.node_count, 3):
            raise InputError(
                f"start: {name} has the shape {values.shape}: the net has {system.net.node_count} nodes"
            )
        if not np.isfinite(values).all():
            node = int(np.argwhere(~np.isfinite(values))[0, 0])
            raise InputError(f"start: {name} of node {node} is {values[node].tolist()}: give finite numbers")
    return Integration(system, start, instants, options or SolverOptions(), watch)
