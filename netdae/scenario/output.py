"""The section [output] of a scenario, and the times of the frames that it makes."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.scenario.section import Section
from netdae.scenario.solver import SHORTEST_FLIGHT, Solver

MOST_FRAMES = 1_000_000


class Output(Section):
    """What is written."""

    frames: int = Field(
        51, ge=2, le=MOST_FRAMES, description="Frames, evenly in time, the start and the end among them."
    )


def times_of(output: Output, solver: Solver) -> FloatArray:
    """Times of the frames, s, from the begin to the end; raises InputError for a flight too short for them."""
    begin, end = solver.begin, solver.end
    if end <= begin:
        raise InputError(f"end is {end:g} s, expected a time after begin, {begin:g} s")
    times = np.linspace(begin, end, output.frames)
    if end - begin < SHORTEST_FLIGHT or not (np.diff(times) > 0).all():
        raise InputError(
            f"the flight lasts {end - begin:g} s from {begin:g} s on: "
            f"give an end {SHORTEST_FLIGHT:g} s after the begin at least, and fewer frames if there are many"
        )
    return times
