"""Removal of compiled kernels on disk that may be outdated.

Numba checks whether the file of a kernel has changed, but not the files of the kernels that it calls. Calling machine
code with records of another layout ends in a segmentation fault.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator

from netdae.core.sources import Sources


def forget_outdated(package: str) -> None:
    """Delete the kernels below the folder `package` that are older than any source of their module."""
    kernels = list(_kernels_below(package))
    if not kernels or max(_times_of_sources(package), default=0.0) <= min(_time(path) for _, path in kernels):
        return
    sources = Sources(package)
    newest: dict[str, float] = {}
    for module, kernel in kernels:
        if module not in newest:
            newest[module] = max(_time(source) for source in sources.closure_of(module))
        with contextlib.suppress(OSError):  # another process may be faster, or the folder may not be ours
            if _time(kernel) < newest[module]:
                os.unlink(kernel)
            else:
                os.utime(kernel)  # newer than all sources, for a quick check next time


def _time(path: str) -> float:
    """When a file was last written, s; 0 if it is gone."""
    try:
        return os.stat(path).st_mtime
    except OSError:
        return 0.0


def _times_of_sources(package: str) -> Iterator[float]:
    for folder, _, names in os.walk(package):
        yield from (_time(os.path.join(folder, name)) for name in names if name.endswith(".py"))


def _kernels_below(package: str) -> Iterator[tuple[str, str]]:
    """The source of its module and the path of each compiled file."""
    for folder, subfolders, _ in os.walk(package):
        if "__pycache__" not in subfolders:
            continue
        subfolders.remove("__pycache__")
        with os.scandir(os.path.join(folder, "__pycache__")) as entries:
            for entry in entries:
                if entry.name.endswith((".nbi", ".nbc")):  # named module.function-line and so on
                    yield os.path.join(folder, f"{entry.name.partition('.')[0]}.py"), entry.path
