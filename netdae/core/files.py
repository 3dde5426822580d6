"""Files that are written completely or not at all, even if the process is killed."""

from __future__ import annotations

import contextlib
import errno
import stat
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


def no_file(path: Path) -> str:
    """Why a name cannot be that of a file or folder, in words; empty where it can.

    A device or a pipe may never end, and a NUL or a name that is too long is of no file.
    """
    try:
        mode = path.stat().st_mode
    except ValueError:
        return "the name has a NUL: give another name"
    except OSError as error:
        return f"{reason_of(error)}: give a shorter name" if error.errno == errno.ENAMETOOLONG else ""
    if stat.S_ISREG(mode) or stat.S_ISDIR(mode):
        return ""
    return "this is a device or a pipe: give the name of a file"


def shown(path: Path) -> str:
    """A path for messages, in one line and not too long."""
    text = "".join(sign if sign.isprintable() else repr(sign)[1:-1] for sign in str(path))
    return text if len(text) <= 300 else f"{text[:300]}..."
