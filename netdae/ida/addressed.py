"""A record for compiled code: numbers, and addresses of arrays that are kept here."""

from __future__ import annotations

from typing import Any

import numpy as np


class Addressed:
    """Numbers by `[name]`, and `arrays` by name, of which a record of the type `kind` holds the addresses.

    address : of the record itself
    """

    def __init__(self, kind: np.dtype[Any]) -> None:
        self._record = np.zeros(1, kind)
        self.address = int(self._record.ctypes.data)
        self.arrays: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        return self._record[name][0].item()

    def set(self, **numbers: float) -> None:
        """Set numbers by name."""
        for name, value in numbers.items():
            self._record[name] = value

    def place(self, **arrays: Any) -> None:
        """Keep copies of arrays, each in one piece, and their addresses."""
        for name, array in arrays.items():
            kept = np.array(array, order="C")
            self.arrays[name] = kept
            self._record[name] = kept.ctypes.data
