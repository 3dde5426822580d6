"""The short loop that flies a net and shows it to observers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from netdae._arrays import FloatArray
from netdae.integrate import integrate
from netdae.options import SolverOptions
from netdae.state import State, Trajectory
from netdae.system import System


def simulate(
    system: System,
    start: State,
    times: Sequence[float] | FloatArray,
    *,
    observers: Sequence[Any] = (),
    options: SolverOptions | None = None,
) -> Trajectory:
    """Fly `system` from `start` and return the frames at `times`.

    observers : callables that take the State of each frame. They may have a `begin(system)` that is called
        first, a `watch(state)` that is called at the start and at each internal step, and an `end()` that is
        called last, also after a failure.

    Raises InputError for a start that cannot be flown, RunError for a run that fails.
    """
    watch = [observer.watch for observer in observers if hasattr(observer, "watch")]
    run = integrate(system, start, times, options=options, watch=watch)
    states: list[State] = []
    try:
        for observer in observers:
            if hasattr(observer, "begin"):
                observer.begin(system)
        for state in run:
            states.append(state)
            for observer in observers:
                observer(state)
    finally:
        for observer in observers:
            if hasattr(observer, "end"):
                observer.end()
    return Trajectory.of(states, run.statistics)
