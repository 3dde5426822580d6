"""Two processes that take tasks: timed ones run one at a time, untimed ones side by side."""

from __future__ import annotations

import multiprocessing
import os
import warnings
from collections.abc import Sequence
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any

Task = tuple[str, dict[str, Any]]
"""Name of a function of `benchmark_tasks` and its arguments."""

GRACE = 120.0  # s beside a task's limit: imports, compilation, building of models


class Crashed(Exception):  # noqa: N818, it is shown in the table
    """The process died or hung in a task."""


def _serve(pipe: Connection) -> None:
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)  # Exudyn and SUNDIALS print
    warnings.simplefilter("ignore")
    import benchmark_tasks

    while (task := pipe.recv()) is not None:
        name, arguments = task
        try:
            pipe.send((True, getattr(benchmark_tasks, name)(**arguments)))
        except Exception as reason:
            pipe.send((False, f"{type(reason).__name__}: {reason}"))


class Worker:
    """A process that takes one task after the other; it is made anew after a crash."""

    def __init__(self) -> None:
        self._process: SpawnProcess | None = None
        self._pipe: Connection | None = None
        self._limit = 0.0

    def begin(self, task: Task) -> None:
        """Hand over a task."""
        if self._process is None or not self._process.is_alive():
            context = multiprocessing.get_context("spawn")
            self._pipe, other = context.Pipe()
            self._process = context.Process(target=_serve, args=(other,), daemon=True)
            self._process.start()
            other.close()
        assert self._pipe is not None
        self._limit = task[1].get("limit", 600.0)
        self._pipe.send(task)

    def result(self) -> Any:
        """Wait for the task's result; raises Crashed."""
        assert self._pipe is not None
        try:
            if self._pipe.poll(2 * self._limit + GRACE):
                done, result = self._pipe.recv()
                if done:
                    return result
                raise Crashed(result)
            reason = "it hung"
        except (EOFError, ConnectionError):
            reason = "its process died"
        self.end()
        raise Crashed(reason)

    def run(self, name: str, **arguments: Any) -> Any:
        """Result of one task."""
        self.begin((name, arguments))
        return self.result()

    def end(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process = None


def side_by_side(workers: Sequence[Worker], tasks: Sequence[Task]) -> list[Any]:
    """Results of untimed tasks, as many at once as there are workers."""
    results = []
    for k in range(0, len(tasks), len(workers)):
        pairs = list(zip(workers, tasks[k : k + len(workers)], strict=False))
        for worker, task in pairs:
            worker.begin(task)
        try:
            results += [worker.result() for worker, _ in pairs]
        except Crashed:
            for worker in workers:  # none may keep a result that nobody waits for
                worker.end()
            raise
    return results
