"""A ranking of the forces on a net: the one that moves it most comes first; those that a system lacks are reported."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from netdae.core.errors import InputError
from netdae.forces import earth
from netdae.forces.elements import ElementForce
from netdae.forces.orbit import ORBIT
from netdae.model.state import State
from netdae.system.external_forces import ExternalForce, external_forces_of
from netdae.system.scales import Scales, gravities_of, scales_of
from netdae.system.surface_forces import kind_of
from netdae.system.system import System

SIGNIFICANT = 0.01
"""Displacement over size above which a force matters."""


@dataclass(frozen=True)
class Ranking:
    """All forces, the one that moves the net most first.

    altitude : m, of the orbit; None on the ground
    """

    scales: Scales
    altitude: float | None
    forces: tuple[ExternalForce, ...]

    def share(self, force: ExternalForce) -> float:
        """Displacement over the size of the net."""
        return force.displacement / self.scales.size

    @property
    def significant(self) -> tuple[ExternalForce, ...]:
        """Forces that move the net by `SIGNIFICANT` of its size or more."""
        return tuple(force for force in self.forces if self.share(force) >= SIGNIFICANT)

    @property
    def missing(self) -> tuple[ExternalForce, ...]:
        """Forces that are significant but not in the system."""
        return tuple(force for force in self.significant if not force.included)


def ranking_of(
    system: System,
    start: State,
    *,
    flight_time: float,
    altitude: float | None = None,
    charge: float = 0.0,
    current: float = 0.0,
) -> Ranking:
    """Forces on the net of a system that flies from `start`, ranked by the displacement that they cause.

    flight_time : s
    altitude : m, of the circular orbit; None leaves out what acts in orbit alone
    charge : C, on a net that holds one; current : A, along a net that carries one

    Uniform gravity and air are listed where the system has one of them.
    Raises InputError for a flight time, altitude, charge or current that is impossible.
    """
    if not (math.isfinite(flight_time) and flight_time > 0):
        raise InputError(f"flight time is {flight_time:g} s: give a time above zero")
    for name, value, unit in (("charge", charge, "C"), ("current", current, "A")):
        if not math.isfinite(value):
            raise InputError(f"{name} is {value:g} {unit}: give a finite number, zero where there is none")
    scales, included = scales_of(system, start, flight_time), included_in(system, start.t)
    forces = external_forces_of(
        system, start.t, scales, included=included, altitude=altitude, charge=charge, current=current
    )
    if scales.held:
        forces = [replace(force, displacement=min(force.displacement, scales.size)) for force in forces]
    forces.sort(key=lambda force: (-force.displacement, -force.newtons))
    return Ranking(scales, altitude, tuple(forces))


def included_in(system: System, t: float = 0.0) -> frozenset[str]:
    """Which of orbit, drag, sunlight, air and gravity a system has, on cords or on bodies, just after t."""
    found = {kind for force in system.forces if (kind := kind_of(force, t)) is not None}
    return frozenset(found | ({"gravity"} if gravities_of(system) else set()))


def orbit_altitude(system: System) -> float | None:
    """Altitude in m of the orbit that a system has; raises InputError where the Earth has no such orbit."""
    orbits = [force for force in system.forces if isinstance(force, ElementForce) and force.law is ORBIT]
    return earth.altitude_of(orbits[0].parameters.mean_motion) if orbits else None
