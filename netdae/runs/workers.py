"""Tasks in worker processes: a worker does one after the other, and a failure of one does not affect the others.

Workers are spawned, on every system alike, and get tasks and send messages through a pipe each. They compute in
one thread each, ignore Ctrl-C, and stop on request or when the process that started them is gone.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from typing import Any

from netdae.core.errors import InputError, NetdaeError

Tell = Callable[[Any], None]
"""Sends a message from a task; raises KeyboardInterrupt when the task is to stop."""

Task = Callable[[Any, Tell], None]
"""Does one item; a function at the top of a module, so that it can be sent."""

_PATIENCE = 15.0  # s that a worker may take to stop on request before it is killed
_ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
_DEAF_TO = (signal.SIGINT, signal.SIGTERM)  # Ctrl-C, and a cluster's end of a job, reach every process


@dataclass(frozen=True)
class Outcome:
    """How an item ended.

    number : of the item
    error : in one line; None for an item that is done
    bug : the traceback where the error is not one that netdae raises on purpose
    """

    number: int
    error: str | None = None
    bug: str | None = None


def processes_for(items: int, wish: int | None = None) -> int:
    """Number of workers: as requested, by default one for each processor, never more than items."""
    if wish is not None and wish < 1:
        raise InputError(f"processes is {wish}: give 1 or more")
    available = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return min(items, wish or available or 1)


def outcomes_of(
    task: Task, items: Sequence[Any], *, processes: int, hear: Callable[[int, Any], None]
) -> Generator[Outcome, None, None]:
    """Do `task(item, report)` for each item in that many processes; yield the outcomes as they come.

    hear : is called with an item's number and each message from the task

    When the iterator is closed, or anything raises, the workers are stopped.
    """
    waiting = deque(range(len(items)))
    workers: dict[Any, _Worker] = {}  # by their connection
    try:
        while waiting or any(worker.number is not None for worker in workers.values()):
            for worker in [worker for worker in workers.values() if worker.number is None]:
                if waiting:
                    worker.take(waiting.popleft(), items)
            while waiting and len(workers) < processes:
                worker = _Worker(task)
                workers[worker.connection] = worker
                worker.take(waiting.popleft(), items)
            for connection in wait([*workers]):
                worker = workers[connection]
                try:
                    kind, content = worker.connection.recv()
                except (EOFError, OSError):
                    del workers[connection]
                    yield Outcome(worker.end(), f"its process has died, {worker.exit_in_words()}")
                    continue
                if kind == "reported":
                    assert worker.number is not None
                    hear(worker.number, content)
                else:
                    yield Outcome(worker.end(), *content)
    finally:
        _stop(list(workers.values()))


class _Worker:
    """A process and the pipe to it; `number` is that of the item it is at."""

    def __init__(self, task: Task) -> None:
        context = get_context("spawn")
        self.connection, theirs = context.Pipe()
        self.process = context.Process(target=_work, args=(theirs, task), daemon=True)
        self.number: int | None = None
        with _deaf(), _environment(_ONE_THREAD):  # both are inherited
            self.process.start()
        theirs.close()

    def take(self, number: int, items: Sequence[Any]) -> None:
        self.number = number
        with contextlib.suppress(OSError):  # the process has died: recv() reports it
            self.connection.send(items[number])

    def end(self) -> int:
        assert self.number is not None
        number, self.number = self.number, None
        return number

    def exit_in_words(self) -> str:
        self.process.join(_PATIENCE)
        code = self.process.exitcode
        if code is not None and code < 0:
            return f"killed by signal {-code}: if it is short of memory, use fewer processes"
        return f"exit code {code}"


def _stop(workers: Sequence[_Worker]) -> None:
    """Stop the workers, at first by request."""
    try:
        for worker in workers:
            with contextlib.suppress(OSError):
                worker.connection.send(None)
        deadline = time.monotonic() + _PATIENCE
        for worker in workers:
            worker.process.join(max(0.0, deadline - time.monotonic()))
    finally:
        for worker in workers:
            if worker.process.is_alive():
                worker.process.kill()
                worker.process.join()
            worker.connection.close()


def _work(connection: Connection, task: Task) -> None:
    """What a worker does until it receives None, or nobody is there any more."""
    for each in _DEAF_TO:
        signal.signal(each, signal.SIG_IGN)

    def report(message: Any) -> None:
        try:
            stop = connection.poll()
            if not stop:
                connection.send(("reported", message))
        except OSError:
            stop = True
        if stop:
            raise KeyboardInterrupt

    with contextlib.suppress(EOFError, OSError):
        while (item := connection.recv()) is not None:
            connection.send(("ended", _done(task, item, report)))


def _done(task: Task, item: Any, report: Tell) -> tuple[str | None, str | None]:
    """Error and traceback of the task with an item."""
    try:
        task(item, report)
    except KeyboardInterrupt:
        return "interrupted", None
    except NetdaeError as error:
        return str(error), None
    except Exception as error:
        return f"{type(error).__name__}: {error}", traceback.format_exc()
    return None, None


@contextlib.contextmanager
def _deaf() -> Iterator[None]:
    """Ignore Ctrl-C for a moment, so that processes started meanwhile ignore it from their start."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    former = {each: signal.signal(each, signal.SIG_IGN) for each in _DEAF_TO}
    try:
        yield
    finally:
        for each, handler in former.items():
            signal.signal(each, handler or signal.SIG_DFL)  # None: not one of Python's


@contextlib.contextmanager
def _environment(values: dict[str, str]) -> Iterator[None]:
    former = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in former.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
