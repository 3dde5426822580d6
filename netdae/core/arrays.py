"""Array types and the read-only copies that frozen data hold."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

# arrays by number of axes, as fields of the records that compiled code sees, see `records`
Reals = Annotated[FloatArray, 1]
Reals2 = Annotated[FloatArray, 2]
Reals3 = Annotated[FloatArray, 3]
Wholes = Annotated[IntArray, 1]
Wholes2 = Annotated[IntArray, 2]
Wholes3 = Annotated[IntArray, 3]
Flags = Annotated[BoolArray, 1]


def frozen_floats(values: ArrayLike) -> FloatArray:
    """Read-only float64 copy of `values`."""
    return _frozen(np.array(values, dtype=np.float64, order="C"))


def frozen_ints(values: ArrayLike) -> IntArray:
    """Read-only int64 copy of `values`."""
    return _frozen(np.array(values, dtype=np.int64, order="C"))


def _frozen(array: NDArray[Any]) -> NDArray[Any]:
    array.flags.writeable = False
    return array


def wholes(*shape: int) -> IntArray:
    """Zeros, as integers."""
    return np.zeros(shape, dtype=np.int64)
