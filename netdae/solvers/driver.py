"""The driver of a flight: stages, phases, internal steps, output times, energy balance.

A flight is cut into phases at the jumps of loads and motions, and where restraints begin or end. Each phase starts
afresh, with an exact stop, consistent accelerations and the impulse of driven nodes added to the balance. Inside a
phase, kinks only stop a step. An instant of events on which something depends ends a stage, after which the phases are
found anew; whatever the order of these events, restraints end first, then others begin, and a stop comes last.
Steps do not depend on the output times: states at these and the times of events are read from the integrator's own
polynomial.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from importlib import import_module
from time import perf_counter
from typing import Any

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import InputError
from netdae.model.phases import SAME
from netdae.model.restraints import Drive, Restraint
from netdae.model.state import EnergyBalance, State
from netdae.solvers.energy_balance import RunningBalance
from netdae.solvers.event_search import EventSearch, Firing
from netdae.solvers.options import SolverOptions
from netdae.solvers.snapshot import Memory, Snapshot
from netdae.solvers.stepper import Step, Stepper
from netdae.system.system import System

Watch = Callable[[State], None]


class Integration:
    """Iterator over the States at the output times; `statistics` reports counts and wall times so far.

    `impulses` lists the (time, impulse (3,) in N s) of restraints at jumps of velocity.
    `fired` holds the times of those events that have happened, by name.
    """

    def __init__(
        self,
        system: System,
        start: State,
        times: FloatArray,
        options: SolverOptions,
        watch: Sequence[Watch],
        events: EventSearch | None,
        resume: Memory | None,
    ) -> None:
        self._whole = system
        self._times = times
        self._watch = watch
        self._options = options
        self._events = events
        self._waited_for = {name for restraint in system.restraints for name in restraint.events}
        begin, end = float(times[0]), float(times[-1])
        self._system = system.holding(_holding(system, np.nextafter(begin, end), {}))
        self._drive = self._system.drive_from(start.x)
        self._drive.check_start(start.t, start.v, end)
        system.check_covers(begin, end)
        self._solver = _stepper_of(self._system, self._drive, options)
        self._running: RunningBalance | None = None
        self._now = _read_only(
            State(start.t, start.x.copy(), start.v.copy(), start.a.copy(), start.balance, start.attitude)
        )
        system.take(self._now)
        self._balance = start.balance
        self._part = self._system
        self._outputs = deque(map(float, times[1:]))
        self._frames, self._frame = 0, -math.inf
        self._swallowed_until = -math.inf
        self._stage = self._phase = begin
        self._snapshot: Snapshot | None = None
        self._resumed: Snapshot | None = None
        self.fired: dict[str, float] = {}
        self.impulses: list[tuple[float, FloatArray]] = []
        self._seconds = 0.0
        self._shown = 0
        if resume is not None:
            self._restore(resume)
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

        driver, of IDA: "compiled" or "python". The latter infers failures from the order of IDA's calls: a setup in the
        middle of an attempt at a step, or a step back after four corrections or after ones that shrink too slowly, is a
        failure of Newton's iteration; any other step back is one of the error test.
        """
        counts = {name: self._solver.counts[name] for name in self._solver.COUNTS}
        seconds = {name: round(value, 6) for name, value in sorted(self._solver.seconds.items())}
        driver = getattr(self._solver, "driver", None)
        return {
            "method": self._options.method,
            **({} if driver is None else {"driver": driver}),
            **counts,
            "wall_seconds": {"total": round(self._seconds, 6), **seconds},
        }

    @property
    def notes(self) -> tuple[str, ...]:
        """What a user should know about how it was flown."""
        note = getattr(self._solver, "note", "")
        return (note,) if note else ()

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a user should know about its figures."""
        return tuple(getattr(self._solver, "warnings", ()))

    # Resuming

    def memory(self) -> dict[str, Any]:
        """Arrays by name from which `integrate(..., resume=memory)` continues after the last yielded frame.

        t : s, the end of the last completed internal step; frames : number of frames yielded
        """
        if self._snapshot is None:
            raise RuntimeError("nothing was flown yet: ask for the first State before the memory")
        return self._snapshot.memory(self._frames, self._frame, self._drive.anchor, self._seconds)

    def _restore(self, memory: Memory) -> None:
        """Continue the flight that left this memory."""
        if memory["x"].shape != self._now.x.shape:
            raise InputError(
                f"resume: the memory is of {len(memory['x'])} nodes, the net has {len(self._now.x)}: "
                "resume the scenario that was flown"
            )
        snapshot = Snapshot.of(memory)
        self._now, self._balance = _read_only(snapshot.state), snapshot.state.balance
        self._stage, self._phase = snapshot.stage, snapshot.phase
        self.fired, self.impulses = dict(snapshot.fired), list(snapshot.impulses)
        self._frames, self._frame = int(memory["frames"]), snapshot.frame
        self._swallowed_until = float(memory["frame"])
        self._outputs = deque(t for t in self._outputs if t > self._frame)
        self._solver.counts.update(snapshot.counts)
        self._solver.seconds.update(snapshot.seconds)
        self._seconds = float(memory["total_seconds"])
        self._shown = snapshot.shown
        if self._events is not None:
            self._events.restore(snapshot.events)
        self._resumed = self._snapshot = snapshot
        self._hold(np.nextafter(self._phase, math.inf), snapshot.state.x)
        self._drive.anchor[...] = memory["anchor"]

    def _take_snapshot(self, *, stopped: bool = False) -> None:
        now = self._now
        self._snapshot = Snapshot(
            State(now.t, now.x, now.v, now.a, self._balance, now.attitude),
            self._stage,
            self._phase,
            self._frame,
            dict(self.fired),
            tuple(self.impulses),
            dict(self._solver.counts),
            dict(self._solver.seconds),
            self._solver.memory(),
            {} if self._events is None else self._events.memory(),
            self._shown,
            stopped,
        )

    # Stages, phases, steps

    def _run(self) -> Iterator[State]:
        end = float(self._times[-1])
        flying = self._resumed is None or not self._resumed.stopped
        while flying:
            flying = False
            for begin, stop, phase in self._system.phases(self._stage, end):
                if self._resumed is not None and begin < self._phase:
                    continue
                firing = yield from self._fly_phase(phase, begin, stop)
                if firing is not None:
                    self._stage = firing.t
                    flying = not _stops(firing) and firing.t < end
                    break

    def _fly_phase(self, phase: System, begin: float, stop: float) -> Generator[State, None, Firing | None]:
        """Fly to `stop` or to the event that ends the stage; return that event."""
        resumed, self._resumed = self._resumed, None
        if resumed is None:
            self._phase = begin
            phase = self._begin(phase, begin)
        else:
            phase = phase.holding(self._system.active)
            self._running = RunningBalance(phase, self._drive, self._now, peak=self._balance.peak_tension)
        state = self._now
        self._whole.take(state)
        self._solver.enter(phase, state.t, np.stack((state.x, state.v)), np.stack((state.v, state.a)))
        if self._frames == 0:
            if self._events is not None:
                self._events.begin(state)
            self._take_snapshot()
            yield self._as_frame(state)
        for kink, part in phase.smooth_parts(begin, stop):
            if kink <= self._now.t:
                continue
            self._solver.go_on(part)
            self._running_balance.go_on(part)
            self._part = part
            if resumed is not None:
                self._solver.restore(resumed.solver)
                resumed = None
            self._take_snapshot()
            while self._now.t < kink:
                firing = yield from self._advance(kink)
                if firing is not None:
                    return firing
        return None

    def _begin(self, phase: System, t: float) -> System:
        """Start a phase at t (restraints, consistent accelerations, impulses); return the phase as it then holds."""
        x, v = self._now.x.copy(), self._now.v.copy()
        inside = phase.inside(t)
        for ended, place in self._hold(inside, x):
            if ended.release_velocity is not None:
                v[place] = np.asarray(ended.release_velocity)[ended.axis_indices]
        phase = phase.holding(self._system.active)
        x_d, v_d, a_d = self._drive.at(inside)
        held = self._drive.mask
        x, v = np.where(held, x_d, x), np.where(held, v_d, v)
        attitude = self._now.attitude
        self._now = _read_only(State(t, x, v, phase.acceleration(t, x, v, a_d), EnergyBalance(), attitude))
        if self._running is None:
            first = State(t, x, v, self._now.a, self._balance, attitude)
            self._running = RunningBalance(phase, self._drive, first)
        else:
            impulse = self._running.enter(phase, self._drive, self._now)
            if impulse is not None:
                self.impulses.append((t, impulse))
        self._balance = self._running.balance()
        self._show()
        return phase

    def _hold(self, t: float, x: FloatArray) -> list[tuple[Restraint, tuple[IntArray, ...]]]:
        """Apply the restraints that hold from t on; return those that ended, with their places."""
        active, former = _holding(self._whole, t, self.fired), self._drive
        if active == former.restraints:
            return []
        self._system = self._system.holding(active)
        self._drive = former.followed_by(active, self._system.net, t, x)
        counts, seconds = self._solver.counts, self._solver.seconds
        self._solver = _stepper_of(self._system, self._drive, self._options)
        self._solver.counts, self._solver.seconds = counts, seconds
        return [each for each in zip(former.restraints, former.places, strict=True) if each[0] not in active]

    def _advance(self, kink: float) -> Generator[State, None, Firing | None]:
        """One call of the integrator towards `kink`, with the frames and events inside."""
        if self._events is not None:
            self._solver.every_step = self._events.needs_every_step
            self._solver.scan = self._events.scan() if self._solver.every_step else None
        steps = self._solver.step(kink)
        for step in steps:
            state = self._state(step)
            firing = None if self._events is None else self._find(self._events, state)
            if firing is not None:
                state, step = self._cut(firing.t)
            while self._outputs and self._outputs[0] < state.t:
                inner = self._solver.output(self._outputs.popleft())
                shown = self._state(inner)
                balance = self._running_balance.at(shown, inner.share)
                yield from self._frame_of(shown, balance)
            begin = perf_counter()
            self._balance = self._running_balance.advance(state, step.share)
            self._solver.seconds["balance"] += perf_counter() - begin
            self._now = state
            self._show()
            at_frame = bool(self._outputs) and self._outputs[0] == state.t
            stopped = firing is not None and _stops(firing)
            if stopped:
                self._act_before_stop()
                state = self._now
            if at_frame or stopped:
                if at_frame:
                    self._outputs.popleft()
                reported = self._running_balance.reported()
                self._balance = self._running_balance.balance()
            # no snapshot at an event that only ends a stage: the flight is resumed from before it
            if step is steps[-1] or stopped:
                self._take_snapshot(stopped=stopped)
            if at_frame or stopped:
                yield from self._frame_of(state, reported)
            if firing is not None:
                return firing
        return None

    def _find(self, events: EventSearch, state: State) -> Firing | None:
        """The first instant up to `state` at which events happen on which something depends; earlier ones are noted."""
        last = self._now
        while (firing := events.first(last, state, self._state_at)) is not None:
            events.note(firing)
            for event in firing.events:
                self.fired.setdefault(event.name, firing.t)
            if any(event.action != "none" or event.name in self._waited_for for event in firing.events):
                return firing
            last = firing.state
        return None

    def _act_before_stop(self) -> None:
        """Let restraints end and begin that wait for an event at which the flight stops."""
        t, end = self._now.t, float(self._times[-1])
        if t < end and _holding(self._whole, np.nextafter(t, end), self.fired) != self._drive.restraints:
            _, _, phase = next(self._system.phases(t, end))
            self._begin(phase, t)

    def _cut(self, t: float) -> tuple[State, Step]:
        """The running step, cut at t."""
        if t <= self._now.t:
            now = self._now
            return now, Step(now.t, np.stack((now.x, now.v)), np.stack((now.v, now.a)), None, now.attitude)
        step = self._solver.output(t)
        return self._state(step), step

    def _state_at(self, t: float) -> State:
        return self._state(self._solver.output(t))

    def _state(self, step: Step) -> State:
        x, v, a = step.y[0], step.y[1], step.yp[1]
        held = self._drive.mask
        if held.any():  # IDA's yp is a difference quotient there, and its y between steps a polynomial
            x_d, v_d, a_d = self._drive.at(self._part.inside(step.t))
            x, v, a = np.where(held, x_d, x), np.where(held, v_d, v), np.where(held, a_d, a)
        attitude = self._now.attitude if step.attitude is None else step.attitude
        return _read_only(State(step.t, x, v, a, EnergyBalance(), attitude))

    @property
    def _running_balance(self) -> RunningBalance:
        assert self._running is not None
        return self._running

    def _as_frame(self, state: State) -> State:
        self._frames, self._frame = self._frames + 1, state.t
        self._whole.take(state)
        balance = self._running_balance.reported()
        return State(state.t, state.x, state.v, state.a, balance, state.attitude)

    def _frame_of(self, state: State, balance: EnergyBalance) -> Iterator[State]:
        """The frame, unless the resumed flight has already yielded it."""
        self._frame = state.t
        if state.t > self._swallowed_until:
            self._frames += 1
            self._whole.take(state)
            yield State(state.t, state.x, state.v, state.a, balance, state.attitude)

    def _show(self) -> None:
        begin = perf_counter()
        now = self._now
        self._whole.take(now)
        reported = State(now.t, now.x, now.v, now.a, self._balance, now.attitude)
        self._shown += 1
        for watch in self._watch:
            watch(reported)
        self._solver.seconds["watchers"] += perf_counter() - begin


def _stops(firing: Firing) -> bool:
    return any(event.action == "stop" for event in firing.events)


def _holding(system: System, t: float, fired: Mapping[str, float]) -> tuple[Restraint, ...]:
    return tuple(restraint for restraint in system.restraints if restraint.holds(t, fired))


def _read_only(state: State) -> State:
    """The state, made read-only for watchers."""
    for array in (state.x, state.v, state.a):
        array.flags.writeable = False
    return state


_STEPPERS = {
    "ida": ("netdae.solvers.ida.native", "ida_stepper"),
    "explicit": ("netdae.solvers.explicit.stepper", "ExplicitSolver"),
    "cvode_bdf": ("netdae.solvers.cvode", "CvodeSolver"),
    "cvode_adams": ("netdae.solvers.cvode", "CvodeSolver"),
}


def _stepper_of(system: System, drive: Drive, options: SolverOptions) -> Stepper:
    """The integrator of a method; SUNDIALS is slow to load, so each is imported when it is needed."""
    module, name = _STEPPERS.get(options.method, ("netdae.solvers.scipy_methods", "IvpSolver"))
    return getattr(import_module(module), name)(system, drive, options)


def integrate(
    system: System,
    start: State,
    times: Sequence[float] | FloatArray,
    *,
    options: SolverOptions | None = None,
    watch: Sequence[Watch] = (),
    events: EventSearch | None = None,
    resume: Memory | None = None,
) -> Integration:
    """Fly `system` from `start` and yield the States at `times`, the first of which is the start's.

    watch : callables that see the State at the start and at every internal step of the integrator
    events : finds what happens during the flight; an event whose action is "stop" ends it with a frame of its own
    resume : `Integration.memory` of a flight of the same system, start and options up to one of its frames: the
        States after that frame are yielded, and the steps after its t are watched

    Raises InputError for times that do not increase or a start that contradicts a restraint, RunError for a failed run.
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
    start = system.whole(start)
    for name, values in (("x", start.x), ("v", start.v)):
        if values.shape != (system.net.node_count, 3):
            raise InputError(
                f"start: {name} has the shape {values.shape}: the net has {system.net.node_count} nodes"
            )
        if not np.isfinite(values).all():
            node = int(np.argwhere(~np.isfinite(values))[0, 0])
            raise InputError(f"start: {name} of node {node} is {values[node].tolist()}: give finite numbers")
    return Integration(system, start, instants, options or SolverOptions(), watch, events, resume)
