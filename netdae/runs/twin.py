"""A twin flight: the same scenario from a start that differs by a nanometre, to see what chaos makes of the figures.

After the first snaps a flight is chaotic: a difference of `TWIN` m grows until single knots are centimetres apart. How
far a figure of the twin lies from the flight's own is a sample of how well the figure is determined. Of a normal
distribution two samples lie 1.1 standard deviations apart on average: an ensemble measures the band itself.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from netdae.core.errors import RunError
from netdae.initial.disturbed import disturbed
from netdae.model.state import State, Trajectory
from netdae.runs.ensemble import CABLE
from netdae.runs.folder import RunFolder
from netdae.runs.summary import LastStep
from netdae.scenario.simulation import Simulation
from netdae.solvers.flight import begun, show, watches_of

TWIN = 1e-9
"""m, standard deviation by which each free coordinate of the twin's start differs."""

SEED = 1
"""Of the twin's start."""

Figures = Mapping[str, Any]


def fly_twin(
    simulation: Simulation, folder: RunFolder, summary: Figures, *, observers: Sequence[Any] = ()
) -> dict[str, Any]:
    """Fly the twin of the finished flight in a folder; return and write its summary with the section `twin`.

    simulation : built anew, for the twin
    observers : of the twin, which itself writes nothing
    """
    last = Trajectory.load(folder.path)[-1]
    whole = {**summary, "twin": twin_of(simulation, summary, last, observers=observers)}
    folder.write_summary(whole)
    return whole


def twin_of(
    simulation: Simulation, summary: Figures, last: State, *, observers: Sequence[Any] = ()
) -> dict[str, Any]:
    """The section `twin` of a summary: what a second flight has in difference from the first.

    simulation : built anew, for the second
    summary, last : of the first, with the State of its last frame

    Members are perturb in m, seed, status, and, of a twin that has finished: at the end bullets, m, the largest
    distance between the bullets of both, knots, m, that between any two nodes, and momentum, N s; and for each number
    in the sections deployment and tether the size of the difference, in the figure's unit.
    """
    chosen = {"perturb": TWIN, "seed": SEED}
    start = disturbed(simulation.start, TWIN, SEED, simulation.system.restrained)
    final = LastStep()
    watchers = [simulation.metrics, final, *observers]
    flight = replace(simulation, start=start).integrate(watches_of(watchers))
    try:
        with begun(simulation.system, watchers):
            for state in flight:
                show(state, watchers)
    except RunError as error:
        return {**chosen, "status": f"failed: {error}"}
    there = final.state
    assert there is not None
    own = {name: summary[name] for name in ("deployment", "tether")}
    its = {
        "deployment": simulation.metrics.summary(),
        "tether": simulation.metrics.tether_summary(there),
    }
    space = simulation.system.in_space
    apart = np.linalg.norm(there.x - last.x, axis=1) * space
    launch = simulation.launch
    bullets = apart[launch.nodes] if launch is not None and len(launch.nodes) else np.zeros(0)
    return {
        **chosen,
        "status": "finished",
        **({"bullets": float(bullets.max())} if len(bullets) else {}),
        "knots": float(apart.max()),
        "momentum": float(np.linalg.norm(simulation.system.momentum(there.v - last.v))),
        **{name: _differences(own[name], its[name]) for name in own},
    }


def _differences(own: Figures, its: Figures) -> dict[str, float]:
    return {
        name: abs(its[name] - value)
        for name, value in own.items()
        if _is_number(value) and _is_number(its.get(name)) and not name.endswith(CABLE)
    }


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


TOLD = {
    "largest_mouth_area": "largest mouth area",
    "final_kinetic_energy": "kinetic energy",
    "final_dissipated_energy": "dissipated energy",
    "peak_tension": "peak tension",
    "tension_quantile_99_9": "tension for 99.9 % of the time",
}
"""Figures of `deployment` that the end of a run reports, in words."""


def in_words(summary: Figures) -> str:
    """The line in which a run reports its twin: differences in per cent of the figures, and lengths."""
    twin, figures = summary["twin"], summary["deployment"]
    whose = f"the twin, from a start {twin['perturb']:g} m away"
    if twin["status"] != "finished":
        return f"{whose}, {twin['status']}"
    told = [
        f"{words} ± {100 * twin['deployment'][name] / abs(figures[name]):.2g} %"
        for name, words in TOLD.items()
        if name in twin["deployment"] and figures[name]
    ]
    told += [
        f"{name} ± {1e3 * twin[name]:.2g} mm at the end" for name in ("bullets", "knots") if name in twin
    ]
    told.append(f"momentum ± {twin['momentum']:.2g} N s")
    return f"{whose}: {', '.join(told)}"
