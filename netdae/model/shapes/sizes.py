"""Checks of the sizes of shapes, which raise InputError in one sentence."""

from __future__ import annotations

import math
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from netdae.core.arrays import FloatArray, frozen_floats
from netdae.core.errors import InputError


def check_sizes(what: str, *, at_least_zero: bool = False, **sizes: Any) -> None:
    """Lengths in m of the shape `what` by their names: finite and above zero, or zero at least."""
    bound = "zero or more" if at_least_zero else "above zero"
    for name, value in sizes.items():
        number = float(value) if isinstance(value, Real) else math.nan
        if not (math.isfinite(number) and (number >= 0 if at_least_zero else number > 0)):
            shown = f"{number:g} m" if isinstance(value, Real) else repr(value)
            raise InputError(f"{what}: {name} is {shown}: give a finite number {bound}")


def check_rounding(what: str, rounding: float, largest: float) -> None:
    """The radius of edges, m, which takes at most `largest` from each side of the part."""
    check_sizes(what, at_least_zero=True, rounding=rounding)
    if rounding > largest:
        raise InputError(
            f"{what}: rounding is {rounding:g} m, larger than the part: give less than {largest:.4g} m, "
            "the radius of the largest sphere in it"
        )


def vector(what: str, name: str, value: ArrayLike, *, count: int = 3) -> FloatArray:
    """Read-only (count,) array of finite numbers."""
    try:
        array = frozen_floats(value)
    except (TypeError, ValueError):
        array = frozen_floats(np.nan)
    if array.shape != (count,) or not np.isfinite(array).all():
        raise InputError(f"{what}: {name} is {value!r}: give {count} finite numbers")
    return array
