"""Compilation of the kernels, which numba keeps on disk: told when it has to be done."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from numba.core.event import Event, Listener, install_listener

COMPILING = "compiling the kernels, which takes up to a minute; later runs find them on disk"


@contextmanager
def told_when_compiling(tell: Callable[[], None]) -> Iterator[None]:
    """Call `tell` once, just before the first kernel that numba does not find on disk is compiled."""
    with install_listener("numba:compile", _FirstOnly(tell)):
        yield


class _FirstOnly(Listener):  # type: ignore[misc]  # numba has no types
    def __init__(self, tell: Callable[[], None]) -> None:
        self._tell: Callable[[], None] | None = tell

    def on_start(self, event: Event) -> None:
        tell, self._tell = self._tell, None
        if tell is not None:
            tell()

    def on_end(self, event: Event) -> None:
        pass
