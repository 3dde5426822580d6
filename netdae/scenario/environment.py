"""The kinds "drag", "solar_pressure" and "air" of [[loads]] of a scenario, and the loads that they make."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.forces import earth
from netdae.forces.air import AirDrag
from netdae.forces.drag import BodyDrag
from netdae.forces.free_molecular import FreeMolecularDrag
from netdae.forces.loads import Load
from netdae.forces.solar import BodySolarPressure, SolarPressure, sun_over_orbit
from netdae.model.net import CableNet
from netdae.model.signals import Constant, Function, Pulse, Signal
from netdae.scenario.orbit import OrbitEntry, altitude_of, mean_motion_of
from netdae.scenario.section import AirDensity, Area, FactorVector, Section, Text, Thickness, Time, Vector
from netdae.scenario.signals import Vector3OrTable, from_table, kind_of_value, signal_of
from netdae.scenario.solver import Solver
from netdae.scenario.table_files import read_table

Coefficient = Annotated[float, Field(ge=1e-6, le=100)]
LightPressure = Annotated[float, Field(ge=1e-12, le=1)]  # N/m²; 4.5e-6 at 1 AU, 0.2 at the Sun's surface

NO_CABLES = "none"
"""What `cables` says where a load acts on bodies alone."""


class DensityFile(Section):
    """A CSV table with the header altitude,density; altitudes in m, rising, densities in kg/m³."""

    file: Text = Field(description="CSV file with the header altitude,density.")


DensityOrTable = Annotated[
    Annotated[AirDensity, Tag("<value>")] | Annotated[DensityFile, Tag("<table>")],
    Discriminator(kind_of_value),
]


class Body(Section):
    """Bullets or other bodies at the nodes of a group, as the stream or the light sees them."""

    group: Text = Field(description="Node group.")
    area: Area | None = Field(None, description="Area that each body shows, m²; or give diameter.")
    diameter: Thickness | None = Field(None, description="Diameter of a sphere, m.")


class BodyInAir(Body):
    """Bullets or other bodies at the nodes of a group, in dense air."""

    drag_coefficient: Coefficient = Field(0.47, description="Drag coefficient; 0.47 is a sphere's.")


class DragEntry(Section):
    """Drag in orbit, where molecules come singly."""

    kind: Literal["drag"] = Field(description="Kind of load.")
    density: DensityOrTable | None = Field(
        None,
        description="Density of the air, kg/m³, or a table of it over altitude; by default an exponential "
        "atmosphere. Both are taken at the altitude of [orbit].",
    )
    stream: Vector | None = Field(
        None,
        description="Velocity of the air in the net's frame, m/s; by default that of air at rest about the Earth, "
        "seen from [orbit].",
    )
    drag_coefficient: Coefficient = Field(2.2, description="Drag coefficient of cables and bodies.")
    cables: Text = Field("all", description='Cable group; "none" for bodies alone.')
    diameter: Thickness | None = Field(
        None, description="Diameter of the cables in the stream, m; by default that of their cross-section."
    )
    bodies: list[Body] = Field([], description="Bullets and other bodies in the stream.")


class SolarPressureEntry(Section):
    """Pressure of sunlight."""

    kind: Literal["solar_pressure"] = Field(description="Kind of load.")
    sun: FactorVector = Field(
        description="Direction towards the Sun at the start, of any length; with [orbit] it turns with the frame."
    )
    pressure: LightPressure | None = Field(
        None, description="Pressure on what swallows the light, N/m²; by default that at 1 AU."
    )
    coefficient: Annotated[float, Field(ge=1e-6, le=2)] = Field(
        1.3,
        description="Share of the pressure that acts: 1 for black, 1.3 for a shining cord, 1.5 for white.",
    )
    cables: Text = Field("all", description='Cable group; "none" for bodies alone.')
    diameter: Thickness | None = Field(
        None, description="Diameter of the cables in the light, m; by default that of their cross-section."
    )
    bodies: list[Body] = Field([], description="Bullets and other bodies in the light.")
    begin: Time | None = Field(None, description="Time at which the light sets in, s; the start by default.")
    end: Time | None = Field(None, description="Time at which the shadow sets in, s; never by default.")


class AirEntry(Section):
    """Drag in dense air."""

    kind: Literal["air"] = Field(description="Kind of load.")
    density: AirDensity = Field(1.225, description="Density of the air, kg/m³; 1.225 is that at sea level.")
    normal_coefficient: Coefficient = Field(
        1.1, description="Drag coefficient of cables across the wind, on diameter times length."
    )
    tangential_coefficient: Annotated[float, Field(ge=0, le=10)] = Field(
        0.01, description="Friction coefficient of cables along the wind, on their whole surface."
    )
    wind: Vector3OrTable = Field((0.0, 0.0, 0.0), description="Velocity of the air, m/s, or a table of it.")
    cables: Text = Field("all", description='Cable group; "none" for bodies alone.')
    diameter: Thickness | None = Field(
        None, description="Diameter of the cables in the wind, m; by default that of their cross-section."
    )
    bodies: list[BodyInAir] = Field([], description="Bullets and other bodies in the air.")
    begin: Time | None = Field(
        None, description="Time at which a constant wind sets in, s; the start by default."
    )
    end: Time | None = Field(None, description="Time at which a constant wind ends, s; never by default.")


EnvironmentLoad = DragEntry | SolarPressureEntry | AirEntry


def environment_loads_of(
    load: EnvironmentLoad,
    orbit: OrbitEntry | None,
    *,
    net: CableNet,
    folder: Path,
    solver: Solver,
) -> list[Load]:
    """Loads on the cables and on each group of bodies.

    orbit : the section [orbit] of the scenario, whose errors are given as `altitude_of` does
    folder : of the scenario file, to which tables are relative

    Raises InputError for unknown groups, for what is missing or says nothing, and for a load that acts on nothing.
    """
    if load.cables != NO_CABLES:
        net.cables_of(load.cables)  # raises for an unknown group
    elif not load.bodies:
        raise InputError('it acts on nothing: name a cable group instead of "none", or give bodies')
    elif load.diameter is not None:
        raise InputError(
            'diameter is that of cables, but cables is "none": leave it out, or name a cable group'
        )
    if isinstance(load, AirEntry) and load.wind == (0.0, 0.0, 0.0):
        given = [name for name in ("begin", "end") if getattr(load, name) is not None]
        if given:
            raise InputError(f"{given[0]} is that of a wind, but there is none: give wind, or leave it out")
    areas = [_area_of(body, net) for body in load.bodies]
    if isinstance(load, DragEntry):
        return _drag(load, orbit, areas, folder)
    if isinstance(load, SolarPressureEntry):
        return _sunlight(load, orbit, areas, solver.begin)
    wind = signal_of(load.wind, folder, solver, begin=load.begin, end=load.end)
    return _air(load, areas, wind)


def _area_of(body: Body, net: CableNet) -> float:
    if len(net.nodes_of(body.group)) == 0:
        raise InputError(f"the group {body.group!r} has no nodes: name another one")
    if body.area is not None and body.diameter is None:
        return body.area
    if body.diameter is not None and body.area is None:
        return math.pi * body.diameter**2 / 4
    if body.area is None:
        raise InputError(f"neither of area and diameter is given for {body.group!r}: give one of them")
    raise InputError(f"both of area and diameter are given for {body.group!r}: leave one of them out")


def _air(load: AirEntry, areas: list[float], wind: Signal) -> list[Load]:
    loads: list[Load] = []
    if load.cables != NO_CABLES:
        loads.append(
            AirDrag(
                load.density,
                normal_coefficient=load.normal_coefficient,
                tangential_coefficient=load.tangential_coefficient,
                wind=wind,
                cables=load.cables,
                diameter=load.diameter,
            )
        )
    for body, area in zip(load.bodies, areas, strict=True):
        loads.append(
            BodyDrag(
                body.group, area, density=load.density, drag_coefficient=body.drag_coefficient, wind=wind
            )
        )
    return loads


def _drag(load: DragEntry, orbit: OrbitEntry | None, areas: list[float], folder: Path) -> list[Load]:
    density, stream = _density_of(load, orbit, folder), load.stream
    if stream is None:
        stream = (0.0, -earth.circular_speed(_given_altitude(orbit, "stream")), 0.0)
    wind, coefficient = Constant(stream), load.drag_coefficient
    loads: list[Load] = []
    if load.cables != NO_CABLES:
        loads.append(
            FreeMolecularDrag(
                density, wind, drag_coefficient=coefficient, cables=load.cables, diameter=load.diameter
            )
        )
    for body, area in zip(load.bodies, areas, strict=True):
        loads.append(BodyDrag(body.group, area, density=density, drag_coefficient=coefficient, wind=wind))
    return loads


def _density_of(load: DragEntry, orbit: OrbitEntry | None, folder: Path) -> float:
    if load.density is None:
        return earth.density(_given_altitude(orbit, "density"))
    if not isinstance(load.density, DensityFile):
        return load.density
    altitude = _given_altitude(orbit, "the altitude for the density table")
    name = load.density.file
    columns = read_table(folder / name, ("altitude", "density"))
    with from_table(name):
        return earth.DensityTable(columns["altitude"], columns["density"]).at(altitude)


def _given_altitude(orbit: OrbitEntry | None, name: str) -> float:
    if orbit is None:
        raise InputError(f"{name} is missing: give it, or a section [orbit] that reports it")
    return altitude_of(orbit)


def _sunlight(
    load: SolarPressureEntry,
    orbit: OrbitEntry | None,
    areas: list[float],
    start: float,
) -> list[Load]:
    if not any(load.sun):
        raise InputError("sun is [0, 0, 0]: give the direction towards the Sun")
    sun = _lit(
        Constant(load.sun) if orbit is None else sun_over_orbit(load.sun, mean_motion_of(orbit), since=start),
        start if load.begin is None else load.begin,
        math.inf if load.end is None else load.end,
        always=load.begin is None and load.end is None,
    )
    pressure = earth.SOLAR_PRESSURE if load.pressure is None else load.pressure
    loads: list[Load] = []
    if load.cables != NO_CABLES:
        loads.append(
            SolarPressure(
                sun,
                pressure,
                coefficient=load.coefficient,
                cables=load.cables,
                diameter=load.diameter,
            )
        )
    for body, area in zip(load.bodies, areas, strict=True):
        loads.append(
            BodySolarPressure(body.group, area, sun=sun, pressure=pressure, coefficient=load.coefficient)
        )
    return loads


def _lit(sun: Signal, begin: float, end: float, *, always: bool) -> Signal:
    """The Sun from `begin` to `end`, zero in the shadow before and after."""
    if always:
        return sun
    shine = Pulse(np.ones(3), begin, end)  # raises where it ends before it begins

    def direction(t: float) -> FloatArray:
        return shine(t) * sun(t)

    return Function(direction, jumps=shine.jumps)
