"""Silence around SUNDIALS as scikit-sundae calls it, which prints the library's messages."""

from __future__ import annotations

import contextlib
import io
import logging
import os
import sys
import threading
from typing import TextIO

# SUNDIALS writes warnings to C's stderr unless this is set before its first context
os.environ.setdefault("SUNLOGGER_WARNING_FILENAME", os.devnull)

logger = logging.getLogger(__name__)

_ONE_AT_A_TIME = threading.RLock()


class _Filter(io.TextIOBase):
    """Passes text on, except SUNDIALS' error messages, which scikit-sundae prints: they go to the log."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._swallowed = False

    def write(self, text: str) -> int:
        if ", Error: " in text:
            logger.debug("SUNDIALS: %s", text.strip())
            self._swallowed = True
        elif not (self._swallowed and text == "\n"):
            self._stream.write(text)
        else:
            self._swallowed = False
        return len(text)

    def flush(self) -> None:
        self._stream.flush()


def quiet() -> contextlib.AbstractContextManager[object]:
    """Send text of SUNDIALS to the log; one thread at a time, since all threads share standard output."""
    stack = contextlib.ExitStack()
    stack.enter_context(_ONE_AT_A_TIME)
    stack.enter_context(contextlib.redirect_stdout(_Filter(sys.stdout)))
    return stack
