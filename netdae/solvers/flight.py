"""The short loop that flies a net and shows it to observers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any

from netdae.core.arrays import FloatArray
from netdae.model.state import State, Trajectory
from netdae.solvers.driver import Integration, Watch, integrate
from netdae.solvers.options import SolverOptions
from netdae.system.system import System


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
    run = integrate(system, start, times, options=options, watch=watches_of(observers))
    return Trajectory.of(list(shown(run, system, observers)), run.statistics)


def watches_of(observers: Sequence[Any]) -> tuple[Watch, ...]:
    """The `watch` methods of the observers that have one."""
    return tuple(observer.watch for observer in observers if hasattr(observer, "watch"))


def shown(run: Integration, system: System, observers: Sequence[Any]) -> Iterator[State]:
    """The States of a run, each shown to the observers first; they begin and end with the run."""
    with begun(system, observers):
        for state in run:
            show(state, observers)
            yield state


def show(state: State, observers: Sequence[Any]) -> None:
    """Show a frame to the observers, in their order."""
    for observer in observers:
        observer(state)


@contextmanager
def begun(
    system: System, observers: Sequence[Any], *, resume: Mapping[str, Any] | None = None
) -> Iterator[None]:
    """Begin the observers in order, and end them in reverse order.

    resume : memory of a resumed flight; observers that have a `resume(system, memory)` are given it instead
    """
    with ExitStack() as ends:
        for observer in observers:
            if hasattr(observer, "end"):
                ends.callback(observer.end)
            if resume is not None and hasattr(observer, "resume"):
                observer.resume(system, resume)
            elif hasattr(observer, "begin"):
                observer.begin(system)
        yield
