"""Loads that a scenario's [orbit] and its kinds "drag", "solar_pressure" and "air" of [[loads]] make."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from netdae import earth
from netdae._arrays import FloatArray
from netdae.errors import InputError
from netdae.forces.air import AirDrag
from netdae.forces.drag import BodyDrag
from netdae.forces.free_molecular import FreeMolecularDrag
from netdae.forces.loads import Load
from netdae.forces.orbit import Orbit
from netdae.forces.solar import BodySolarPressure, SolarPressure, sun_over_orbit
from netdae.net import CableNet
from netdae.scenario import environment, schema
from netdae.scenario.signals import signal_of
from netdae.scenario.tables import DensityFile
from netdae.signals import Constant, Function, Pulse, Signal
from netdae.tables import read_table


def altitude_of(orbit: environment.OrbitEntry) -> float:
    """Altitude in m; raises InputError unless just one of altitude and mean_motion is given, or under 120 km."""
    if orbit.altitude is not None and orbit.mean_motion is None:
        return orbit.altitude
    if orbit.mean_motion is not None and orbit.altitude is None:
        return earth.altitude_of(orbit.mean_motion)
    if orbit.altitude is None:
        raise InputError("neither of altitude and mean_motion is given: give one of them")
    raise InputError("both of altitude and mean_motion are given: leave one of them out")


def mean_motion_of(orbit: environment.OrbitEntry) -> float:
    """Mean motion in rad/s; raises InputError as `altitude_of` does."""
    altitude = altitude_of(orbit)
    return earth.mean_motion(altitude) if orbit.mean_motion is None else orbit.mean_motion


def orbit_load_of(orbit: environment.OrbitEntry) -> Orbit:
    """The forces of the orbit's frame; raises InputError as `altitude_of` does."""
    return Orbit(mean_motion_of(orbit))


def environment_loads_of(
    load: environment.EnvironmentLoad,
    orbit: environment.OrbitEntry | None,
    *,
    net: CableNet,
    folder: Path,
    solver: schema.Solver,
) -> list[Load]:
    """Loads on the cables and on each group of bodies.

    orbit : the section [orbit] of the scenario, whose errors are told as `altitude_of` does
    folder : of the scenario file, to which tables are relative

    Raises InputError for unknown groups, for what is missing or says nothing, and for a load that acts on nothing.
    """
    if load.cables != environment.NO_CABLES:
        net.cables_of(load.cables)  # raises for an unknown group
    elif not load.bodies:
        raise InputError('it acts on nothing: name a cable group instead of "none", or give bodies')
    elif load.diameter is not None:
        raise InputError(
            'diameter is that of cables, but cables is "none": leave it out, or name a cable group'
        )
    if isinstance(load, environment.AirEntry) and load.wind == (0.0, 0.0, 0.0):
        given = [name for name in ("begin", "end") if getattr(load, name) is not None]
        if given:
            raise InputError(f"{given[0]} is that of a wind, but there is none: give wind, or leave it out")
    areas = [_area_of(body, net) for body in load.bodies]
    if isinstance(load, environment.DragEntry):
        return _drag(load, orbit, areas, folder)
    if isinstance(load, environment.SolarPressureEntry):
        return _sunlight(load, orbit, areas, solver.begin)
    return _air(load, areas, signal_of(load.wind, load, folder, solver))


def _area_of(body: environment.Body, net: CableNet) -> float:
    if len(net.nodes_of(body.group)) == 0:
        raise InputError(f"the group {body.group!r} has no nodes: name another one")
    if body.area is not None and body.diameter is None:
        return body.area
    if body.diameter is not None and body.area is None:
        return math.pi * body.diameter**2 / 4
    if body.area is None:
        raise InputError(f"neither of area and diameter is given for {body.group!r}: give one of them")
    raise InputError(f"both of area and diameter are given for {body.group!r}: leave one of them out")


def _air(load: environment.AirEntry, areas: list[float], wind: Signal) -> list[Load]:
    loads: list[Load] = []
    if load.cables != environment.NO_CABLES:
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


def _drag(
    load: environment.DragEntry, orbit: environment.OrbitEntry | None, areas: list[float], folder: Path
) -> list[Load]:
    density, stream = _density_of(load, orbit, folder), load.stream
    if stream is None:
        stream = (0.0, -earth.circular_speed(_told_altitude(orbit, "stream")), 0.0)
    wind, coefficient = Constant(stream), load.drag_coefficient
    loads: list[Load] = []
    if load.cables != environment.NO_CABLES:
        loads.append(
            FreeMolecularDrag(
                density, wind, drag_coefficient=coefficient, cables=load.cables, diameter=load.diameter
            )
        )
    for body, area in zip(load.bodies, areas, strict=True):
        loads.append(BodyDrag(body.group, area, density=density, drag_coefficient=coefficient, wind=wind))
    return loads


def _density_of(load: environment.DragEntry, orbit: environment.OrbitEntry | None, folder: Path) -> float:
    if load.density is None:
        return earth.density(_told_altitude(orbit, "density"))
    if not isinstance(load.density, DensityFile):
        return load.density
    altitude = _told_altitude(orbit, "the altitude for the density table")
    name = load.density.file
    columns = read_table(folder / name, ("altitude", "density"))
    try:
        return earth.DensityTable(columns["altitude"], columns["density"]).at(altitude)
    except InputError as error:
        raise InputError(f"{name}: {error}") from error


def _told_altitude(orbit: environment.OrbitEntry | None, name: str) -> float:
    if orbit is None:
        raise InputError(f"{name} is missing: give it, or a section [orbit] that tells it")
    return altitude_of(orbit)


def _sunlight(
    load: environment.SolarPressureEntry,
    orbit: environment.OrbitEntry | None,
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
    if load.cables != environment.NO_CABLES:
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
