"""Array types and the read-only copies that frozen data hold."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def frozen_floats(values: ArrayLike) -> FloatArray:
    """Read-only float64 copy of `values`."""
    return _frozen(np.array(values, dtype=np.float64, order="C"))


def frozen_ints(values: ArrayLike) -> IntArray:
    """Read-only int64 copy of `values`."""
    return _frozen(np.array(values, dtype=np.int64, order="C"))


def _frozen(array: NDArray[Any]) -> NDArray[Any]:
    array.flags.writeable = False
    return array
