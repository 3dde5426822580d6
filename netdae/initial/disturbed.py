"""Starts that differ a little: each free coordinate is moved by a normal random number."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.random import default_rng

from netdae.core.arrays import BoolArray
from netdae.model.state import State


def disturbed(start: State, deviation: float, seed: int | Sequence[int], restrained: BoolArray) -> State:
    """The start with positions moved by `deviation` m, the standard deviation; restrained axes (n, 3) stay."""
    noise = deviation * default_rng(seed).standard_normal(start.x.shape)
    return State.at(np.where(restrained, start.x, start.x + noise), start.v, t=start.t)
