"""The record of the compiled driver of IDA: numbers that change, and the addresses of all other data.

Its own address is IDA's user data and the content of Newton's solver. `ida.record` fills it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import carray, njit

from netdae.core.addresses import pointer_of
from netdae.core.arrays import Reals, Reals2, Wholes

_PARTS = (
    "net matrix ldl dyads chunk damped"  # addresses of the records of these classes, see `core.records.load`
)
_OF_SUNDIALS = """
    ida_solve system_data error_test_fails get_order set_highest_order start_anew
    on_setup on_test memory y yp correction
"""
_COUNTS = """
    residuals setups solves errors_failed newton_failed not_finite singular made stuck iteration
    undamped low spoilt filtered order allowed highest since above failed_earlier free
"""
_REALS = "h_before strict stiffest cj cj_before rtol atol_position atol_velocity not_finite_at"

RECORD = np.dtype(
    [(name, np.int64) for name in f"n {_PARTS} {_OF_SUNDIALS} {_COUNTS}".split()]
    + [(name, np.float64) for name in _REALS.split()]
)


class Chunk(NamedTuple):
    """The steps of a chunk, (rows,), and workspace for one step."""

    times: Reals
    states: Reals2  # (rows, 6n), x and v
    slopes: Reals2  # (rows, 6n), ẋ and v̇
    sums: Reals2  # (rows, 8), see `kernel.rates`, since the chunk began
    tensions: Reals  # N
    attitudes: Reals2  # (rows, 4), q of a target
    rates: Reals  # (8,) now
    middle_rates: Reals
    middle: Reals  # (6n,)
    clock: Reals
    system: Wholes  # (8,), what IDA reports of its nonlinear system
    z: Reals  # (6n,), Newton's last correction
    gained: Reals  # (6n,), sum of some of them
    filtered: Reals  # (6n,), a correction without what is stiff in it
    weights: Reals  # (6n,), of the error norm, before the error test saw others


@njit(cache=True, forceinline=True)
def record_at(address: int) -> Any:
    """The record at an address."""
    return carray(pointer_of(address), 1, RECORD)[0]
