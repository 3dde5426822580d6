"""From the data of a scenario to a simulation that is ready to fly."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import repeat
from pathlib import Path
from typing import NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError, ScenarioError
from netdae.forces.loads import Load
from netdae.initial.disturbed import disturbed
from netdae.initial.ejection import Launch
from netdae.model.material import Cords, Material
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.model.target import Obstacle, Target
from netdae.scenario.closing import closing_options, closings_of, overpowered
from netdae.scenario.damping import damping_of
from netdae.scenario.equilibrium import at_rest
from netdae.scenario.events import detector_of, event_with, needs_met
from netdae.scenario.initial import start_of
from netdae.scenario.loads import loads_of
from netdae.scenario.masses import masses_of
from netdae.scenario.material import materials_of, prestressed_of
from netdae.scenario.meeting import check_apart
from netdae.scenario.metrics import metrics_of, mouth_note
from netdae.scenario.nets import net_of
from netdae.scenario.obstacles import obstacles_of
from netdae.scenario.orbit import orbit_load_of
from netdae.scenario.output import times_of
from netdae.scenario.plausibility import unusual_of
from netdae.scenario.problems import bare, section_in_words
from netdae.scenario.pulleys import pulleys_of
from netdae.scenario.restraints import (
    Given,
    check_restraints,
    given_in,
    held_bullets_of,
    joined_velocities,
    late_findings,
    restraints_of,
)
from netdae.scenario.schema import ScenarioData
from netdae.scenario.simulation import Simulation
from netdae.scenario.solver import options_of
from netdae.scenario.target import target_of
from netdae.scenario.tether import net_with_tether
from netdae.system.closing import Closing, accuracy_reported, sharp_enough
from netdae.system.closing_assembly import Closed, with_closings
from netdae.system.damping import Damping
from netdae.system.pulleys import Strung, with_pulleys
from netdae.system.system import System
from netdae.system.tether_assembly import Tethered


class _Parts(NamedTuple):
    """What a System is made of, but for its restraints, which depend on when bullets are let go."""

    tied: Tethered
    whole: Closed
    strung: Strung
    materials: dict[str, Material]
    masses: dict[str, float]
    loads: list[Load]
    damping: Damping
    target: Target | None
    obstacles: tuple[Obstacle, ...]


class Build:
    """What is made of a scenario's data, section by section; an error names file, section and key.

    path : of the scenario file, to which the names of other files are relative
    """

    def __init__(self, path: Path, title: str, data: ScenarioData) -> None:
        self._path = path
        self._title = title
        self._data = data
        self._folder = path.parent
        self._solver = data.solver
        self._alone = data.tether is None and not data.closing and not data.pulleys

    def simulation(self) -> Simulation:
        """All of it; raises InputError for what cannot fly."""
        data, section = self._data, self._section
        begin, end = self._solver.begin, self._solver.end
        with section("solver"):
            times = times_of(data.output, self._solver)
        net, of_mesh = net_of(data.net, self._folder, section)
        masses = masses_of(data.masses, net, section, alone=self._alone)
        own = materials_of(data.material, net, section)
        net = prestressed_of(net, own, section)
        cords = Cords.of(net, own)
        start = start_of(data.initial, net, masses, section, cords=cords)
        tied = self._tied(start.net, State.at(start.state.x, start.state.v, t=begin))
        closings = self._closings(tied.net)
        with section("closing"):
            whole = with_closings(tied.net, tied.start, closings)
        with section("pulleys"):
            strung = with_pulleys(whole.net, whole.start, pulleys_of(data.pulleys, tied.net, section))
        size = float(np.ptp(net.nodes, axis=0).max())
        target = target_of(data.target, self._folder, size, section)
        obstacles = obstacles_of(data.obstacles, self._folder, size, section)
        parts = _Parts(
            tied,
            whole,
            strung,
            {
                **materials_of(data.material, start.net, section),
                **tied.materials,
                **whole.materials,
                **strung.materials,
            },
            {**masses, **tied.masses},
            self._loads(tied.net, tied.start.x),
            self._damping(),
            target,
            obstacles,
        )
        x, v, found = strung.start.x, strung.start.v.copy(), start.findings
        if data.initial.shape == "equilibrium":
            with section("initial", key="shape"):
                alone = parts._replace(target=None)
                rest = at_rest(self._system(alone, self._given(parts, start.launch)), x, begin)
            x, own_count = rest.x, start.net.node_count
            start = start_of(data.initial, net, masses, section, cords=cords, rest=x[:own_count])
            v[:own_count], found = start.state.v, rest.findings
        given = self._given(parts, start.launch)
        v = joined_velocities(v, strung.net, [each.restraint for each in given], begin)
        state = State.at(x, v, t=begin)
        late = late_findings(given, begin, end, section)
        check_restraints(given, strung.net, state, section)
        system = self._system(parts, given)
        check_apart(target, obstacles, system, state, section)
        state = system.whole(state)
        if data.initial.disturbance > 0:
            kept = system.restrained | ~system.in_space[:, None]
            if system.body is not None:
                kept[system.body.place] = True
            state = disturbed(state, data.initial.disturbance, data.initial.disturbance_seed, kept)
        with section("metrics"):
            metrics = metrics_of(data.metrics, system, contact_sums=self._solver.method != "explicit")
        with section("solver"):
            options = options_of(self._solver)
        options = closing_options(options, self._solver, closings)
        findings: list[str] = [*of_mesh, *found, *late]
        notes = [*overpowered(closings)]
        accuracy = accuracy_reported(options.tolerances, closings) if options.in_force else None
        if accuracy is not None:
            (notes if sharp_enough(options.tolerances, closings) else findings).append(accuracy)
        notes += unusual_of(system, state, start.launch)
        notes += mouth_note(data.metrics, system.net)
        has = needs_met(system, metrics, data.tether, data.closing)
        return Simulation(
            self._title,
            system,
            state,
            times,
            options,
            metrics,
            tuple(findings),
            detector_of(data.events, has, system, metrics, given, section),
            start.launch,
            tuple(notes),
        )

    @contextmanager
    def _section(self, name: str = "", number: int | None = None, *, key: str = "") -> Iterator[None]:
        """Tell errors of the content by file, section and key."""
        place = [section_in_words(name, number), key]
        header = f"{' '.join(part for part in place if part)}: " if name else ""
        try:
            yield
        except ScenarioError:
            raise
        except InputError as error:
            raise ScenarioError(f"{self._path}: {header}{bare(error)}") from error

    def _tied(self, net: CableNet, start: State) -> Tethered:
        """The net with its tether; as it is where it has none."""
        data = self._data
        locking = None if data.tether is None else event_with("lock_tether", data.events, self._section)
        return net_with_tether(
            data.tether, net, start, self._folder, self._solver, self._section, locking=locking
        )

    def _closings(self, net: CableNet) -> list[Closing]:
        """Winches and drawcords, on the net's own nodes."""
        data = self._data
        starting = event_with("start_closing", data.events, self._section)
        return closings_of(data.closing, net, self._solver.begin, self._section, starting=starting)

    def _loads(self, net: CableNet, x: FloatArray) -> list[Load]:
        """Loads on a net whose nodes start at x (n, 3)."""
        data = self._data
        loads: list[Load] = []
        if data.orbit is not None:
            with self._section("orbit"):
                loads.append(orbit_load_of(data.orbit))
        return loads + loads_of(
            data.loads, data.orbit, net, x, self._folder, self._solver, self._section, alone=self._alone
        )

    def _damping(self) -> Damping:
        with self._section("damping"):
            return damping_of(self._data.damping)

    def _given(self, parts: _Parts, launch: Launch) -> list[Given]:
        """All restraints, those that hold the bullets of a launch among them."""
        whole = parts.whole
        return [
            *self._restraints(parts.tied.net, launch),
            *given_in("tether", parts.tied.restraints),
            *map(Given, whole.restraints, repeat("closing"), whole.numbers),
            *given_in("pulleys", parts.strung.restraints),
        ]

    def _system(self, parts: _Parts, given: Sequence[Given]) -> System:
        with self._section():
            return System(
                parts.strung.net,
                parts.materials,
                damping=parts.damping,
                masses=parts.masses,
                loads=parts.loads,
                restraints=[each.restraint for each in given],
                reels=(*parts.tied.reels, *parts.whole.reels, *parts.strung.reels),
                target=parts.target,
                obstacles=parts.obstacles,
                forces=parts.whole.forces,
            )

    def _restraints(self, net: CableNet, launch: Launch) -> list[Given]:
        """Those of [[restraints]], and those that hold the bullets."""
        given = restraints_of(
            self._data.restraints, net, self._folder, self._solver, self._section, alone=self._alone
        )
        held = held_bullets_of(launch, self._data.initial.velocity, self._solver.begin)
        return [*given, *given_in("initial", held)]
