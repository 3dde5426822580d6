"""A lock on a folder, so that two processes do not write into it at once.

The lock is the system's (flock) on an open file: it ends with the process that holds it, however that ends, so a
file that a killed process leaves behind locks nothing. Where the system has none, nothing is locked.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from netdae.core.errors import InputError

try:
    import fcntl
except ImportError:  # not POSIX
    fcntl = None  # type: ignore[assignment]


@contextlib.contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold the lock of the file `path`, which is created and removed; raises InputError if another process has it."""
    if fcntl is None:
        yield
        return
    descriptor = _held(path)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            path.unlink()
        os.close(descriptor)


def _held(path: Path) -> int:
    """The open file `path` with its lock."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise InputError(
                    f"{path.parent}: another run{_by(descriptor)} is writing into this folder: wait for its end, "
                    "or choose another output folder by -o"
                ) from None
            except OSError:  # a file system without locks
                return descriptor
            if _is_at(descriptor, path):  # else its former holder has just removed it
                os.truncate(descriptor, 0)
                os.pwrite(descriptor, f"{os.getpid()}\n".encode(), 0)
                return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)


def _by(descriptor: int) -> str:
    reported = os.pread(descriptor, 20, 0).strip()
    return f" (process {reported.decode()})" if reported.isdigit() else ""


def _is_at(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path))
    except FileNotFoundError:
        return False
