"""Compilation of the kernels, which numba caches on disk: reported when it is needed.

Compiled functions that others call are inlined (`forceinline`). A function that is not has a copy in each library that
calls it, and a process runs the copy that it loads first: which one depends on what has just been compiled and what
comes from disk. Copies differ in round-off, since LLVM fuses products and sums anew in each, and reorders sums where it
may. With one copy the same file gives the same figures.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from numba.core.event import Event, Listener, install_listener

FAST = {"reassoc", "contract", "arcp", "nsz"}  # but not-a-number and infinity keep their meaning
OPTIONS: dict[str, Any] = {"fastmath": FAST, "error_model": "numpy"}
INLINED: dict[str, Any] = {**OPTIONS, "forceinline": True}  # nor are references counted

COMPILING = "compiling the kernels, which takes up to a minute; later runs find them on disk"


@contextmanager
def reported_when_compiling(report: Callable[[], None]) -> Iterator[None]:
    """Call `report` once, just before the first kernel that numba does not find on disk is compiled."""
    with install_listener("numba:compile", _FirstOnly(report)):
        yield


class _FirstOnly(Listener):  # type: ignore[misc]  # numba has no types
    def __init__(self, report: Callable[[], None]) -> None:
        self._report: Callable[[], None] | None = report

    def on_start(self, event: Event) -> None:
        report, self._report = self._report, None
        if report is not None:
            report()

    def on_end(self, event: Event) -> None:
        pass
