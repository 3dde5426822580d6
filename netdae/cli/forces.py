"""`netdae forces`: rank the forces on a scenario's net by their order of magnitude."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from netdae.core.text import as_text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from netdae.system.ranking import Ranking
    from netdae.system.system import System

USUAL_ALTITUDE = 600e3
"""m, of a net whose scenario has no orbit: where much of the large debris is."""


def forces(
    scenario: Path,
    *,
    altitude: Annotated[
        float | None,
        Parameter(
            help="Of the circular orbit, m; by default that of [orbit], else 600e3 unless there is gravity."
        ),
    ] = None,
    flight_time: Annotated[
        float | None, Parameter(help="Over which displacements are reported, s; by default the scenario's.")
    ] = None,
    charge: Annotated[float, Parameter(help="On a net that holds one, C.")] = 0.0,
    current: Annotated[float, Parameter(help="Along a conducting net, A.")] = 0.0,
) -> None:
    """Rank the forces on a net by what they do during the flight; nothing is flown or written.

    Parameters
    ----------
    scenario
        TOML file.
    """
    from netdae.scenario.reader import read_scenario
    from netdae.system.ranking import ranking_of

    simulation = read_scenario(scenario).build()
    height, origin = _altitude_of(simulation.system, altitude, simulation.start.t)
    ranking = ranking_of(
        simulation.system,
        simulation.start,
        flight_time=float(simulation.times[-1] - simulation.times[0]) if flight_time is None else flight_time,
        altitude=height,
        charge=charge,
        current=current,
    )
    for line in (simulation.title, *_scales(ranking, origin), *_table(ranking), *_verdict(ranking)):
        print(as_text(line))


def _altitude_of(system: System, given: float | None, t: float = 0.0) -> tuple[float | None, str]:
    """Altitude in m, None on the ground, and where it comes from."""
    from netdae.system.external_forces import ON_GROUND
    from netdae.system.ranking import included_in, orbit_altitude

    if given is not None:
        return given, "by --altitude"
    own = orbit_altitude(system)
    if own is not None:
        return own, "by [orbit]"
    if included_in(system, t) & ON_GROUND:
        return None, "none, the scenario has gravity or air: give --altitude to rank it in orbit"
    return USUAL_ALTITUDE, "taken, as the scenario has no [orbit]: give --altitude for another"


def _scales(ranking: Ranking, origin: str) -> Iterator[str]:
    from netdae.forces.earth import circular_speed, density, mean_motion

    s, h = ranking.scales, ranking.altitude
    strain = 2 * s.jerk / s.wave_speed
    yield f"net      m = {s.mass:.4g} kg, cords m_c = {s.cord_mass:.4g} kg, A = {s.area:.3g} m², L = {s.size:.4g} m"
    yield f"cord     √(EĀ λ) = {s.impedance:.4g} kg/s, waves at c = {s.wave_speed:.4g} m/s, strain 2 w/c = {strain:.2g}"
    yield f"flight   t = {s.flight_time:g} s at v = {s.speed:.4g} m/s, jerks w = {s.jerk:.4g} m/s, D = {s.reach:.4g} m"
    if s.fall.gravity > 0:
        held = f"held for {s.fall.held:g} s it sags by h = {s.fall.sag:.3g} m, " if s.fall.held > 0 else ""
        yield (
            f"fall     g = {s.fall.gravity:.4g} m/s², {held}free for {s.fall.free:g} s; "
            f"{s.fall.speed(s.air):.4g} m/s at most"
        )
    if h is None:
        yield f"orbit    {origin}"
    else:
        yield f"orbit    {h / 1e3:g} km, {origin}"
        yield f"         n = {mean_motion(h):.4g} rad/s, V = {circular_speed(h):.4g} m/s, ρ = {density(h):.3g} kg/m³"


def _table(ranking: Ranking) -> Iterator[str]:
    wide = max(len(force.name) for force in ranking.forces)
    yield ""
    yield f"rank  {'force':<{wide}}  {'newtons':>8}  {'moves, m':>8}  {'of size':>9}  in the scenario"
    for rank, force in enumerate(ranking.forces, 1):
        yield (
            f"{rank:>4}  {force.name:<{wide}}  {force.newtons:>8.1e}  {force.displacement:>8.1e}  "
            f"{_percent(ranking.share(force)):>9}  {'yes' if force.included else 'no'}"
        )
    yield ""
    for rank, force in enumerate(ranking.forces, 1):
        yield f"{rank:>4}  {force.formula}"
        yield f"      {force.source}"


def _verdict(ranking: Ranking) -> Iterator[str]:
    from netdae.system.ranking import SIGNIFICANT

    names = ", ".join(force.name for force in ranking.significant) or "none"
    yield ""
    yield f"significant  {names} ({_percent(SIGNIFICANT)} of the size or more)"
    for force in ranking.missing:
        remedy = f"add {force.remedy}" if force.remedy else "netdae has no model of it"
        yield (
            f"warning      {force.name} moves the net by {force.displacement:.2g} m, "
            f"{_percent(ranking.share(force))} of its size, but the scenario leaves it out: {remedy}"
        )
    if not ranking.missing:
        yield "verdict      the scenario has every force that is significant"


def _percent(share: float) -> str:
    if share >= 1:
        return f"{100 * share:.0f} %"
    return f"{100 * share:.2g} %" if share == 0 or share >= 1e-4 else f"{100 * share:.0e} %"
