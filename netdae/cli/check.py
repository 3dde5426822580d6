"""`netdae check`: build a scenario and check its Jacobian."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from netdae.core.text import as_text

if TYPE_CHECKING:
    from netdae.scenario.simulation import Simulation


def check(scenario: Path) -> None:
    """Build a scenario and compare its Jacobian with differences; nothing is flown or written.

    Parameters
    ----------
    scenario
        TOML file.
    """
    from netdae.core.errors import RunError
    from netdae.runs.jacobian_check import LIMIT, compare_jacobian
    from netdae.scenario.reader import read_scenario

    simulation = read_scenario(scenario).build()
    for line in _lines(simulation):
        print(as_text(line))
    comparisons = compare_jacobian(simulation)
    for each in comparisons:
        left_out = f", {each.at_kinks} at a kink left out" if each.at_kinks else ""
        print(
            f"Jacobian, {each.name:<8} largest error {each.error:.1e}, {each.taut} cables taut, "
            f"{each.slack} slack{left_out}"
        )
    wrong = next((each for each in comparisons if not each.agrees), None)
    if wrong is not None:
        raise RunError(
            f"{scenario}: the Jacobian disagrees with differences at the {wrong.name}: {wrong.place} is wrong by "
            f"{wrong.error:.1e} of its row's largest entry, the limit is {LIMIT:g}: look at the tangents of the forces"
        )


def _lines(simulation: Simulation) -> Iterator[str]:
    from math import pi

    from netdae.runs.jacobian_check import stiffest_frequency

    system, net, times = simulation.system, simulation.system.net, simulation.times
    rtol, atol_position, atol_velocity = simulation.options.tolerances
    mass = float(system.spatial_mass.sum())  # the inertia of drums is no mass
    cords = float(system.cords.linear_density @ net.rest_length)
    frequency = stiffest_frequency(system)
    yield simulation.title
    yield f"nodes               {net.node_count}"
    yield f"cables              {net.cable_count}"
    yield f"mass                {mass:.6g} kg, of which cables {cords:.6g} kg"
    yield f"restrained axes     {int(system.restrained.sum())}"
    yield f"flight              {times[0]:g} to {times[-1]:g} s, {len(times)} frames"
    yield f"tolerances          rtol {rtol:g}, {atol_position:g} m, {atol_velocity:g} m/s"
    yield f"stiffest frequency  {frequency:.4g} Hz with all cables taut"
    if frequency > 0:
        yield f"explicit step       an undamped explicit scheme needs steps below {1 / (pi * frequency):.3g} s"
    for finding in (*simulation.findings, *simulation.notes):
        yield f"note                {finding}"
