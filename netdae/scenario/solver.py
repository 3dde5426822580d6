"""The section [solver] of a scenario, and the options of the time integration that it makes."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from netdae.scenario.section import Section, Step, Time, Tolerance
from netdae.solvers.options import COARSEST_RTOL, FINEST_RTOL, Method, SolverOptions

SHORTEST_FLIGHT = 1e-9
"""Shortest flight and shortest pulse, s: far below the time that a wave takes along any cable."""


class Solver(Section):
    """The time integration."""

    method: Method = Field(
        "ida",
        description="SUNDIALS IDA, or explicit, the velocity Verlet without tolerances; the others to compare with.",
    )
    begin: Time = Field(0.0, description="Time of the start, s.")
    end: Time = Field(description="Time of the end, s.")
    accuracy: Literal["fast", "standard", "accurate"] = Field(
        "standard", description="Preset of rtol, atol_position and atol_velocity, each of which overrides it."
    )
    rtol: Annotated[float, Field(ge=FINEST_RTOL, le=COARSEST_RTOL)] | None = Field(
        None, description="Relative tolerance."
    )
    atol_position: Tolerance | None = Field(None, description="Absolute tolerance of positions, m.")
    atol_velocity: Tolerance | None = Field(None, description="Absolute tolerance of velocities, m/s.")
    max_order: Annotated[int, Field(ge=1, le=5)] | None = Field(
        None, description="Highest order of the BDF formulas, 5 by default."
    )
    max_step: Step | None = Field(None, description="Largest time step, s.")


def options_of(solver: Solver) -> SolverOptions:
    """The options of the integration; raises InputError for those that do not go with the method."""
    return SolverOptions(**solver.model_dump(exclude={"begin", "end"}))
