"""Compiled kernels on disk that may be outdated, thrown away.

Numba looks whether the file of a kernel has changed, but not whether those of the kernels it calls have: a call of
machine code with records of another layout ends in a segmentation fault.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator


def forget_outdated(package: str) -> None:
    """Delete the kernels below the folder `package` that are older than the source of any of them."""
    kernels = list(_kernels_below(package))
    # a compiled file is called module.function-line and so on
    sources = {os.path.join(folder, f"{entry.name.partition('.')[0]}.py") for folder, entry in kernels}
    newest = 0.0
    for source in sources:
        with contextlib.suppress(OSError):  # its module is gone
            newest = max(newest, os.stat(source).st_mtime)
    for _, entry in kernels:
        with contextlib.suppress(OSError):  # another process may be faster, or the folder not be ours
            if entry.stat().st_mtime < newest:
                os.unlink(entry.path)


def _kernels_below(package: str) -> Iterator[tuple[str, os.DirEntry[str]]]:
    """Each compiled file with the folder of its source."""
    for folder, subfolders, _ in os.walk(package):
        if "__pycache__" not in subfolders:
            continue
        subfolders.remove("__pycache__")
        with os.scandir(os.path.join(folder, "__pycache__")) as entries:
            for entry in entries:
                if entry.name.endswith((".nbi", ".nbc")):
                    yield folder, entry
