"""Files that are written completely or not at all, even if the process is killed."""

from __future__ import annotations

import contextlib
from pathlib import Path


def write_whole(path: Path, data: bytes) -> None:
    """Write `data` to `path` through a temporary name in the same folder; raises OSError.

    The rename is atomic: a reader finds the old file or the new one, also after a kill.
    """
    partial = path.with_name(path.name + ".part")
    try:
        partial.write_bytes(data)
        partial.replace(path)
    except OSError:
        with contextlib.suppress(OSError):
            partial.unlink()
        raise


def reason_of(error: OSError) -> str:
    """The operating system's reason in words, for messages that name the file themselves."""
    return error.strerror or str(error)
