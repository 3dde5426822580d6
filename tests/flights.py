"""What tests that fly a system share: the options of the explicit method, and the energy that is kept."""

from __future__ import annotations

from typing import Any

from netdae.model.state import State
from netdae.solvers.options import SolverOptions
from netdae.system.system import System


def explicit_options(**more: Any) -> SolverOptions:
    return SolverOptions(method="explicit", **more)


def energy_of(system: System, state: State) -> float:
    """What is kept: kinetic, stored and dissipated energy, less the work from outside, J."""
    energy = system.kinetic_energy(state.v) + system.elastic_energy(state.x)
    return energy + state.balance.dissipated_energy - state.balance.external_work
