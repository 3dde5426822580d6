"""What summary.json reports of a run: solver, deployment, reactions, impulses, warnings, versions."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from platform import python_version
from typing import Any

import numpy as np

import netdae
from netdae.initial.ejection import velocity_after
from netdae.model.state import State
from netdae.model.tether import CABLE_GROUPS, own_nodes_of
from netdae.scenario.simulation import Simulation
from netdae.solvers.explicit.stable_step import cheaper_method
from netdae.solvers.ida.stepper import SUNDIALS_VERSION
from netdae.system.measurements import Measurements
from netdae.system.symmetry import symmetry_of
from netdae.system.system import System


class LastStep:
    """Observer that keeps the State of the last internal step.

    state : the one before the first that it sees, of a resumed flight
    """

    def __init__(self, state: State | None = None) -> None:
        self.state = state

    def watch(self, state: State) -> None:
        """Keep it."""
        self.state = state

    def __call__(self, state: State) -> None:
        """Nothing at a frame, so that the figures do not depend on the frames."""


def summary_of(
    simulation: Simulation,
    *,
    status: str,
    statistics: Mapping[str, Any],
    impulses: Sequence[tuple[float, Any]],
    fired: Mapping[str, float],
    last: State | None,
    resumes: Sequence[Mapping[str, Any]] = (),
    notes: Sequence[str] = (),
    warnings: Sequence[str] = (),
) -> dict[str, Any]:
    """What summary.json reports: no figure in it depends on the number of frames.

    status : "finished", "interrupted" or "failed: " with the reason
    statistics, impulses, fired, notes : of the `Integration`
    last : State of the last internal step, None if there is none
    warnings : of the start and of the `Integration`, beside those of the scenario and of the figures
    resumes : where the run was resumed, if it was stopped under way; the figures are of the whole flight
    """
    system, options = simulation.system, simulation.options
    begin = float(simulation.times[0])
    step = None if last is None else (last.t - begin) / max(int(statistics.get("steps", 0)), 1)
    figures = {} if last is None else simulation.metrics.summary(finer=f"{options.finer(step)} in [solver]")
    found = [*simulation.findings, *figures.pop("warnings", []), *warnings]
    return {
        "title": simulation.title,
        "status": status,
        "net": net_figures(system),
        "solver": {
            "begin": begin,
            "end": float(simulation.times[-1]),
            "reached": None if last is None else last.t,
            "accuracy": options.accuracy,
            "max_step": options.max_step,
            **options.in_force,
            "cheaper": cheaper_method(system),
            **statistics,
        },
        "ejection": _ejection(simulation),
        "deployment": figures,
        "tether": {} if last is None else simulation.metrics.tether_summary(last),
        "target": {} if last is None else simulation.metrics.target_summary(last),
        "contact": {} if last is None else simulation.metrics.contact_summary(),
        "restraints": [] if last is None else _reactions(simulation, last, fired),
        "impulses": [{"time": t, "impulse": list(map(float, impulse))} for t, impulse in impulses],
        "events": [] if simulation.events is None else simulation.events.records,
        "resumes": [*resumes],
        "notes": [*simulation.notes, *notes],
        "warnings": found,
        "versions": versions(),
    }


def net_figures(system: System) -> dict[str, Any]:
    """What the summary reports about a net; masses in kg, which add up to all that flies.

    mass, cable_mass : of the net with its bullets, and of its cords, including those that close it
    tether_mass, chaser_mass : of tether and bridle at the start, and of the chaser; left out where there is none
    """
    net = system.net
    cord_mass = system.cords.linear_density * net.rest_length
    names = CABLE_GROUPS if "tether" in net.cable_groups else ()
    tether = np.unique([e for name in names for e in net.cable_groups.get(name, [])]).astype(np.int64)
    # half of a cable is lumped at each of its ends, also where the tether begins at a knot of the net
    without = system.spatial_mass.copy()
    np.subtract.at(without, net.cables[tether], 0.5 * cord_mass[tether, None])
    result = {
        "nodes": net.node_count - (0 if system.body is None else 2),
        "cables": net.cable_count,
        "mass": float(without[own_nodes_of(net)].sum()),
        "cable_mass": float(cord_mass.sum() - cord_mass[tether].sum()),
    }
    if len(tether):
        result["tether_mass"] = float(cord_mass[tether].sum())
    chaser = float(without[net.node_groups.get("chaser", [])].sum())
    return {**result, "chaser_mass": chaser} if chaser > 0 else result


def warnings_of_start(simulation: Simulation) -> list[str]:
    """The warning of a start that is exactly symmetric."""
    symmetry = symmetry_of(simulation.system, simulation.start, float(simulation.times[-1]))
    if symmetry is None:
        return []
    return [
        f"the start is exactly symmetric, to {symmetry}, and no real one is: the figures may lie outside the band of "
        "starts that are not: set disturbance = 1e-6 (m) in [initial], or fly an --ensemble"
    ]


def _ejection(simulation: Simulation) -> dict[str, Any]:
    """How many bullets are shot, when the last one leaves, and how fast the net's centre of mass is from then on."""
    launch = simulation.launch
    if launch is None or not len(launch.nodes):
        return {}
    velocity = velocity_after(Measurements.of(simulation.system).own_mass, simulation.start, launch)
    return {
        "bullets": len(launch.nodes),
        "last_release": float(simulation.times[0] + launch.times.max()),
        "velocity_com": velocity.tolist(),
    }


def _reactions(simulation: Simulation, last: State, fired: Mapping[str, float]) -> list[dict[str, Any]]:
    """Sums over the nodes of each restraint at the last internal step, with the loads as they are just before.

    A restraint that does not hold then has no force.
    """
    system = simulation.system
    begin = float(simulation.times[0])
    before = np.nextafter(last.t, -np.inf) if last.t > begin else begin
    holding = system.holding(tuple(each for each in system.restraints if each.holds(before, fired)))
    *_, (_, _, phase) = holding.phases(begin, last.t) if last.t > begin else [(begin, begin, holding)]
    forces = phase.reactions(last.t, last.x, last.v, last.a)
    result = []
    for restraint in simulation.system.restraints:
        nodes = restraint.nodes_of(system.net)
        total = [0.0, 0.0, 0.0]
        if restraint in holding.active:
            for axis in restraint.axis_indices:
                total[axis] = float(forces[nodes, axis].sum())
        group = restraint.group if isinstance(restraint.group, str) else list(restraint.group)
        result.append({"group": group, "axes": restraint.axes, "final_reaction": total})
    return result


def versions() -> dict[str, str]:
    """Versions of netdae and of the libraries behind its figures."""
    packages = ("numpy", "scipy", "numba", "scikit-sundae")
    return {
        "netdae": netdae.__version__,
        "python": python_version(),
        **{name: version(name) for name in packages},
        "sundials": SUNDIALS_VERSION,
    }


def json_of(summary: Mapping[str, Any]) -> str:
    """The summary's text; numbers that are not finite become null."""
    return json.dumps(_plain(summary), indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def _plain(value: Any) -> Any:
    """Mappings, lists, numbers and text as JSON has them."""
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if hasattr(value, "item"):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
