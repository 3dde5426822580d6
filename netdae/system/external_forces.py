"""The forces on a net by their order of magnitude: which of them a model must have, and which it may leave out.

Symbols, all of the net without a tether: m mass, m_c that of its cords, L size, v speed, w speed of a jerk between
neighbours, t flight time, D = max(L, v t) reach, A = Σ d L̄ area of the cords seen from the side; λ mass per length
of a cord and c = √(EĀ/λ) its wave speed; n, a, V mean motion, radius and speed of the orbit, see `earth`.

Snap. A cord whose end is pulled with w emits an elastic wave in which the strain is w/c and the tension
EĀ w/c = w √(EĀλ). A knot that is much heavier than the cord, or held, reflects the wave and doubles it: 2 w/c. Energy
gives about the same: a knot with the mass μ = 2 λ L̄ of its four half cables, jerked with w by the bullet before it,
stretches the cord until ½ μ w² = ½ EĀ L̄ ε², which gives ε = √2 w/c. The first is used.

Orbit. In the frame of a circular orbit the acceleration is 3n²x + 2nẏ, −2nẋ, −n²z and, at higher order, the terms of
μ/(a + x)² = n²a (1 − 2x/a + 3x²/a² ...): n times 2v, n² times 3D, n² times 3D²/a.

Oblateness. Over the pole the acceleration J₂ adds is 3 μ J₂ R²/r⁴ outward; over a distance D along r it differs by
12 μ J₂ R²/r⁵ D = 12 J₂ (R/a)² n² D. That is the largest eigenvalue of its gradient at any latitude.

Displacement. A constant F moves a mass by ½ (F/m) t². Differential forces move the ends of the reach relative to each
other, drag and sunlight the cords relative to the bullets: ½ (F/m_c) t² where areas of bullets are unknown, else ½ a t²
with the larger acceleration a of cords and bodies. Inertia carries the net v t, a snap changes speeds by w and so
shifts by w t; gravity moves it by its fall, see `scales`, and air cannot take away more than the path through it.
Nothing moves a held net further than its size.

Air. A net that falls in air gets no faster than u = √(2 m g/(ρ C_n A)), at which the drag is its weight.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from netdae.forces import air, earth, free_molecular, solar
from netdae.forces.air import AirDrag
from netdae.forces.elements import ElementForce
from netdae.system.scales import Scales
from netdae.system.surface_forces import SurfaceForce, surface_force_of
from netdae.system.system import System

ON_GROUND = {"gravity", "air"}
"""Forces that a system may have but no orbit has."""


@dataclass(frozen=True)
class ExternalForce:
    """A force by its order of magnitude.

    newtons : on the whole net, N
    displacement : m, that it causes over the flight
    included : whether the system has it
    formula, source : in the symbols of the module; author and year
    remedy : what to write into a scenario to include it; empty where netdae has no model of it
    """

    name: str
    newtons: float
    displacement: float
    included: bool
    formula: str
    source: str
    remedy: str = ""


def external_forces_of(
    system: System,
    t: float,
    scales: Scales,
    *,
    included: frozenset[str],
    altitude: float | None = None,
    charge: float = 0.0,
    current: float = 0.0,
) -> list[ExternalForce]:
    """Forces on the net of a system just after t, in no particular order.

    included : which of orbit, drag, sunlight, air and gravity the system has
    altitude : m, of the circular orbit; None leaves out what acts in orbit only
    charge : C, on a net that holds one; current : A, along a net that carries one
    """
    forces = [*_of_the_net(scales), *_of_laws(system, scales)]
    if altitude is not None:
        forces += _of_the_orbit(scales, altitude, included)
        forces += _on_the_surface(system, t, scales, altitude)
        forces.append(_lorentz(scales, altitude, charge, current))
    if included & ON_GROUND:
        forces += _of_the_ground(system, t, scales, included)
    return forces


def _of_the_net(s: Scales) -> Iterator[ExternalForce]:
    yield ExternalForce(
        "elastic tension at snap",
        2 * s.jerk * s.impedance,
        s.jerk * s.flight_time,
        True,
        "2 w √(EĀ λ), moves w t",
        "von Kármán and Duwez 1950, J. Appl. Phys. 21, 987: strain w/c; twice that where the wave is thrown back",
    )
    yield ExternalForce(
        "inertia",
        s.mass * s.speed**2 / s.size,
        s.speed * s.flight_time,
        True,
        "m v²/L, moves v t",
        "Newton's second law, the speed v turned on the way L",
    )


def _of_laws(system: System, s: Scales) -> Iterator[ExternalForce]:
    """Those of the system's forces whose law reports them."""
    for force in system.forces:
        if isinstance(force, ElementForce) and force.law.ranked is not None:
            name, newtons, formula = force.law.ranked(force.parameters, s.reach)
            shift = min(0.5 * newtons / s.mass * s.flight_time**2, s.reach)
            moves = "D the way of the net, moves ½ (F/m) t², D at most"
            yield ExternalForce(
                name, newtons, shift, True, f"{formula}, {moves}", "[[loads]] of the scenario"
            )


def _of_the_orbit(s: Scales, altitude: float, included: frozenset[str]) -> Iterator[ExternalForce]:
    a, n, has = earth.radius_of(altitude), earth.mean_motion(altitude), "orbit" in included
    remedy, clohessy = (
        f"[orbit] altitude = {altitude:g}",
        "Clohessy and Wiltshire 1960, J. Aerosp. Sci. 27, 653",
    )
    oblate = 12 * earth.J2 * (earth.RADIUS / a) ** 2
    for name, acceleration, known, formula, source in (
        ("Coriolis", 2 * n * s.speed, has, "2 m n v", clohessy),
        ("gravity gradient", 3 * n**2 * s.reach, has, "3 n² m D", clohessy),
        (
            "gravity beyond its gradient",
            3 * n**2 * s.reach**2 / a,
            None,
            "3 n² m D²/a",
            "London 1963, AIAA J. 1, 1691",
        ),
        (
            "differential J2",
            oblate * n**2 * s.reach,
            None,
            "12 J₂ (R/a)² n² m D over the pole, half over the equator",
            "Schweighart and Sedwick 2002, J. Guid. Control Dyn. 25, 1073",
        ),
    ):
        yield ExternalForce(
            name,
            s.mass * acceleration,
            0.5 * acceleration * s.flight_time**2,
            bool(known),
            f"{formula}, moves ½ (F/m) t²",
            source,
            "" if known is None else remedy,
        )


def _on_the_surface(system: System, t: float, s: Scales, altitude: float) -> Iterator[ExternalForce]:
    """Drag and sunlight, by the figures of the system's own loads where it has them."""
    V = earth.circular_speed(altitude)
    yield from _pushed(
        "aerodynamic drag",
        surface_force_of(system, t, "drag"),
        0.5 * earth.density(altitude) * V**2 * free_molecular.TYPICAL * s.area,
        s,
        ("½ ρ V² C_D A", "C_D and ρ of the scenario", f"C_D = {free_molecular.TYPICAL:g}"),
        "Cook 1965, Planet. Space Sci. 13, 929; ρ by Vallado 2013, Fundamentals of Astrodynamics, table 8-4",
        "drag",
    )
    yield from _pushed(
        "solar pressure",
        surface_force_of(system, t, "sunlight"),
        earth.SOLAR_PRESSURE * solar.TYPICAL * s.area,
        s,
        ("P C_R A", "C_R and P of the scenario", f"C_R = {solar.TYPICAL:g}"),
        "Montenbruck and Gill 2000, Satellite Orbits, section 3.4; P by Kopp and Lean 2011",
        "solar_pressure",
    )


def _pushed(
    name: str,
    push: SurfaceForce | None,
    estimate: float,
    s: Scales,
    formula: tuple[str, str, str],
    source: str,
    kind: str,
    path: float = math.inf,
) -> Iterator[ExternalForce]:
    """The system's own push where it has one, and an estimate of that on its cords, N, where they have none.

    formula : the law, and the origin of its factors in either case
    kind : of [[loads]] in a scenario; path : m, the furthest that it can move the net
    """
    law, own, typical = formula
    most = "" if path == math.inf else ", the path at most"
    if push is not None:
        shift = min(0.5 * push.acceleration * s.flight_time**2, path)
        terms = f"{law}, {own}, {_moves(push)}{most}"
        yield ExternalForce(name, push.newtons, shift, True, terms, source)
    if push is None or push.on == "bodies":
        shift = min(_shift_of_cords(estimate, s), path)
        terms = f"{law}, {typical}, moves ½ (F/m_c) t²{most}"
        if push is None:
            remedy = f'[[loads]] kind = "{kind}"'
        else:
            name, remedy = f"{name} of cords", f'cables = "all" in [[loads]] kind = "{kind}"'
        yield ExternalForce(name, estimate, shift, False, terms, source, remedy)


def _moves(push: SurfaceForce) -> str:
    """In words: on what a push acts and what it moves."""
    return {
        "cords": "on cords, moves ½ (F/m_c) t²",
        "bodies": "on bodies, moves ½ (F/m) t² with m theirs",
    }.get(push.on, "on cords and bodies, moves the faster of them ½ (F/m) t²")


def _lorentz(s: Scales, altitude: float, charge: float, current: float) -> ExternalForce:
    """Largest force of the dipole's field on a net: over a pole, where it is twice that of the equator.

    A net that floats at 1 V against the plasma, taken as a sphere of its size, holds 4πε₀ (L/2) 1 V: 4e-10 C for
    7 m, on which the field pulls with 1e-10 N.
    """
    B, V = 2 * earth.magnetic_field(altitude), earth.circular_speed(altitude)
    newtons = (abs(charge) * V + abs(current) * s.size) * B
    none = "" if charge or current else ", zero without a charge q and a current I"
    return ExternalForce(
        "Lorentz force",
        newtons,
        _shift_of_cords(newtons, s),
        False,
        f"(q V + I L) B{none}, moves ½ (F/m_c) t²",
        "Peck 2005, AIAA 2005-5995 (charge); Sanmartín et al. 1993, J. Propul. Power 9, 353 (current)",
    )


def _of_the_ground(system: System, t: float, s: Scales, included: frozenset[str]) -> Iterator[ExternalForce]:
    if "gravity" in included:
        braked = ", braked by air to u = √(2 m g/(ρ C_n A))" if s.air else ""
        yield ExternalForce(
            "uniform gravity",
            s.mass * s.fall.gravity,
            s.fall.way(s.air),
            True,
            f"m g, the largest g of the flight, moves ½ g t² or as far as a held net sags{braked}",
            "[[loads]] of the scenario",
        )
    coefficient = AirDrag().normal_coefficient
    of_cords = 0.5 * air.SEA_LEVEL * coefficient * s.area  # k, kg/m
    v, in_air = (max(s.speed, s.fall.speed(k)) for k in (s.air, s.air + of_cords))
    push = surface_force_of(system, t, "air", speed=v)
    path = max(s.speed * s.flight_time, s.fall.way(s.air if s.air else of_cords))
    yield from _pushed(
        "air drag",
        push,
        of_cords * in_air**2,
        s,
        (
            "½ ρ v² C_n A",
            "with C_n, ρ and wind of the scenario",
            f"C_n = {coefficient:g} at sea level",
        ),
        "Hoerner 1965, Fluid-Dynamic Drag, chapter 3",
        "air",
        path + (push.stream * s.flight_time if push else 0.0),
    )


def _shift_of_cords(newtons: float, s: Scales) -> float:
    """½ (F/m_c) t², m."""
    return 0.5 * newtons / (s.cord_mass or s.mass) * s.flight_time**2
