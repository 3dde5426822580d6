"""The step log: rows of numbers added during a flight, in memory or in a file that a kill at any byte leaves usable.

A file begins with `MAGIC` and the width of a row (int64), followed by the rows (float64), all little-endian. A last
row that is not complete is dropped when the file is opened again.
"""

from __future__ import annotations

import contextlib
import os
from array import array
from collections.abc import Iterable
from io import FileIO
from pathlib import Path

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError, RunError
from netdae.core.files import reason_of

MAGIC = b"netdae\x00\x01"
_HEAD = len(MAGIC) + 8
_AT_ONCE = 1 << 16  # numbers buffered before they are written


class StepLog:
    """Rows of `width` numbers, appended one after the other.

    width : numbers in a row
    path : the file; None keeps the rows in memory

    Rows are on disk after `flush`. Raises InputError for a file that cannot be made or is not a log of that
    width, RunError when rows cannot be written.
    """

    def __init__(self, width: int, path: str | os.PathLike[str] | None = None) -> None:
        self.width = width
        self.path = None if path is None else Path(path)
        self._rows = array("d")  # all in memory, or those that are not in the file yet
        self._stream: FileIO | None = None
        self._size = 0  # of the rows in the file, bytes

    def __len__(self) -> int:
        return (self._size // 8 + len(self._rows)) // self.width

    def clear(self) -> None:
        """Begin without rows; a former file is replaced."""
        self._rows = array("d")
        self._size = 0
        if self.path is not None:
            self.close()
            try:
                self.path.parent.mkdir(parents=True, exist_ok=True)
                self._stream = self.path.open("w+b", buffering=0)
                self._stream.write(self._head())
            except OSError as error:
                raise self._cannot_write(error) from error

    def fill(self, rows: FloatArray) -> None:
        """Begin with `rows`, (k, width): a file gets its name when they are all in it."""
        self._rows = array("d")
        if self.path is None:
            self.append(rows)
            return
        self.close()
        partial = self.path.with_name(self.path.name + ".part")
        try:
            with partial.open("wb") as stream:
                stream.write(self._head())
                for row in rows:
                    stream.write(np.ascontiguousarray(row, dtype="<f8").data)
            partial.replace(self.path)
        except OSError as error:
            raise self._cannot_write(error) from error
        self.reopen()

    def reopen(self) -> None:
        """Go on with the file of an earlier process."""
        if self.path is None:
            return
        self.close()
        self._rows = array("d")
        try:
            self._stream = self.path.open("r+b", buffering=0)
            head = self._stream.read(_HEAD)
            if head != self._head():
                if not self._head().startswith(head):
                    raise InputError(
                        f"{self.path} is not a log of rows of {self.width} numbers: it cannot be gone on from"
                    )
                self._stream.seek(0)  # killed while it was made
                self._stream.write(self._head())
            end = self._stream.seek(0, os.SEEK_END)
            self._size = (end - _HEAD) // (8 * self.width) * 8 * self.width
            self._cut()
        except OSError as error:
            raise InputError(f"{self.path} cannot be gone on from: {reason_of(error)}") from error

    def keep(self, count: int) -> None:
        """Drop all rows after the first `count`; raises InputError where there are fewer."""
        if len(self) < count:
            raise InputError(
                f"{self.path or 'log'} holds {len(self)} rows, expected {count} at least: it is damaged"
            )
        self.flush()
        if self._stream is None:
            del self._rows[count * self.width :]
            return
        self._size = count * 8 * self.width
        try:
            self._cut()
        except OSError as error:
            raise self._cannot_write(error) from error

    def append(self, values: Iterable[float]) -> None:
        """Add a row, or an array (k, width) of rows."""
        if isinstance(values, np.ndarray):
            self._rows.frombytes(np.ascontiguousarray(values, dtype=np.float64).data.cast("B"))
        else:
            self._rows.extend(values)
        if self._stream is not None and len(self._rows) >= _AT_ONCE:
            self.flush()

    def flush(self) -> None:
        """Write all rows to the file."""
        if self._stream is None or not self._rows:
            return
        data = np.array(self._rows, dtype="<f8").data.cast("B")
        done, nothing = 0, array("d")
        try:
            self._stream.seek(_HEAD + self._size)  # Ctrl-C may have ended an earlier flush half-way
            while done < len(data):
                done += self._stream.write(data[done:]) or 0
        except OSError as error:
            with contextlib.suppress(OSError):
                self._cut()
            raise RunError(f"{self.path} could not be written: {reason_of(error)}") from error
        self._size, self._rows = self._size + done, nothing

    def rows(self) -> FloatArray:
        """All rows, (k, width); those in a file are memory-mapped, so that many need no memory."""
        self.flush()
        if self.path is None:
            return np.array(self._rows, dtype=np.float64).reshape(-1, self.width)
        shape = (self._size // (8 * self.width), self.width)
        if not shape[0]:
            return np.empty(shape)
        return np.memmap(self.path, dtype="<f8", mode="r", offset=_HEAD, shape=shape)

    def close(self) -> None:
        """Flush and let go of the file; its rows are still available."""
        if self._stream is not None:
            stream = self._stream
            try:
                self.flush()
            finally:
                self._stream = None
                stream.close()

    def remove(self) -> None:
        """Remove the file."""
        if self._stream is not None:
            self._stream.close()
            self._stream = None
        self._rows = array("d")
        self._size = 0
        if self.path is not None:
            with contextlib.suppress(OSError):  # it is only in the way
                self.path.unlink()

    def _cut(self) -> None:
        """End the file after its rows, and go on writing there."""
        assert self._stream is not None
        self._stream.truncate(_HEAD + self._size)
        self._stream.seek(_HEAD + self._size)

    def _head(self) -> bytes:
        return MAGIC + self.width.to_bytes(8, "little")

    def _cannot_write(self, error: OSError) -> InputError:
        return InputError(f"{self.path} cannot be written: {reason_of(error)}: choose another output folder")
