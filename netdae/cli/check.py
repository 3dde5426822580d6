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

    import numpy as np

    from netdae.runs.jacobian_check import stiffest_frequency

    system, net, times = simulation.system, simulation.system.net, simulation.times
    rtol, atol_position, atol_velocity = simulation.options.tolerances
    of_target = [] if system.body is None else [system.body.place, system.body.spin]
    # the inertia of drums is no mass, and the target's stands below
    mass = float(np.delete(system.spatial_mass, of_target).sum())
    cords = float(system.cords.linear_density @ net.rest_length)
    frequency = stiffest_frequency(system)
    yield simulation.title
    yield f"nodes               {net.node_count - len(of_target)}"
    yield f"cables              {net.cable_count}"
    yield f"mass                {mass:.6g} kg, of which cables {cords:.6g} kg"
    yield f"restrained axes     {int(np.delete(system.restrained, of_target, axis=0).sum())}"
    yield f"flight              {times[0]:g} to {times[-1]:g} s, {len(times)} frames"
    yield f"tolerances          rtol {rtol:g}, {atol_position:g} m, {atol_velocity:g} m/s"
    yield f"stiffest frequency  {frequency:.4g} Hz with all cables taut"
    if frequency > 0:
        yield f"explicit step       an undamped explicit scheme needs steps below {1 / (pi * frequency):.3g} s"
    if system.body is not None or system.obstacles:
        yield from _meeting_lines(simulation)
    for finding in (*simulation.findings, *simulation.notes):
        yield f"note                {finding}"


def _meeting_lines(simulation: Simulation) -> Iterator[str]:
    """What the net meets, when on a straight line, and what contact makes of the explicit step."""
    import numpy as np

    from netdae.initial.ejection import velocity_after
    from netdae.scenario.meeting import whose
    from netdae.solvers.explicit.stable_step import steps_of_cords_and_contact
    from netdae.system.approach import approach_of
    from netdae.system.measurements import Measurements

    system, start = simulation.system, simulation.start
    own = Measurements.of(system).own_mass
    if simulation.launch is None:
        velocity = own @ start.v / own.sum()
    else:
        velocity = velocity_after(own, start, simulation.launch)
    if system.body is not None:
        target = system.body.target
        mass = "" if target.body is None else f", {target.body.mass:.6g} kg"
        yield f"target              {target.motion}{mass}, parts: {len(target.parts)}"
    if system.obstacles:
        yield f"obstacles           {len(system.obstacles)}"
    found = approach_of(system, start, velocity, float(simulation.times[-1]))
    who = whose(found.nearest, system.net)
    place = ", ".join(f"{value:.3g}" for value in found.nearest.point)
    speed = f"{float(np.linalg.norm(velocity)):.4g} m/s"
    if found.touches:
        yield f"first contact       at t = {found.time:.4g} s on a straight line at {speed}: {who}, at ({place}) m"
    else:
        yield (
            f"first contact       none on a straight line at {speed}; nearest at t = {found.time:.4g} s, "
            f"{found.nearest.distance:.4g} m: {who}"
        )
    cords, contact = steps_of_cords_and_contact(system)
    ruled = "contact rules the step" if contact < cords else "the cords rule the step"
    yield f"contact step        explicit steps up to {contact:.3g} s, those of the cords {cords:.3g} s: {ruled}"
