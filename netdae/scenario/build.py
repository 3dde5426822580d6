"""From the data of a scenario to a simulation that is ready to fly."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import repeat
from pathlib import Path

import numpy as np

from netdae._arrays import FloatArray
from netdae.closed import with_closings
from netdae.closing import Closing, accuracy_told, sharp_enough
from netdae.damping import Damping
from netdae.ejection import Launch
from netdae.errors import InputError, ScenarioError
from netdae.events.book import EventBook
from netdae.events.event import Event, Need, event_called
from netdae.forces.loads import Gravity, Load, NodalLoad
from netdae.mesh.io import describe
from netdae.metrics import DeploymentMetrics
from netdae.net import CableNet
from netdae.options import SolverOptions
from netdae.plausibility import unusual_of
from netdae.scenario import schema, springs
from netdae.scenario.closed import closing_of, closing_options, overpowered
from netdae.scenario.cords import damping_of, materials_of, thickest_of
from netdae.scenario.events import event_of
from netdae.scenario.groups import check_group
from netdae.scenario.initial import start_of
from netdae.scenario.loads import environment_loads_of, orbit_load_of
from netdae.scenario.metrics import metrics_of
from netdae.scenario.nets import MeshFile
from netdae.scenario.problems import bare, section_in_words
from netdae.scenario.restraints import (
    Told,
    check_restraints,
    held_bullets_of,
    joined_velocities,
    late_findings,
    restraint_of,
    told_in,
)
from netdae.scenario.signals import SHORTEST_FLIGHT, signal_of
from netdae.scenario.simulation import Simulation
from netdae.scenario.tethered import tether_of
from netdae.state import State
from netdae.system import System
from netdae.tethered import Tethered, with_tether


class Build:
    """What is made of a scenario's data, section by section; an error names file, section and key.

    path : of the scenario file, to which the names of other files are relative
    """

    def __init__(self, path: Path, title: str, data: schema.ScenarioData) -> None:
        self._path = path
        self._title = title
        self._data = data
        self._folder = path.parent
        self._solver = data.solver

    def simulation(self) -> Simulation:
        """All of it; raises InputError for what cannot fly."""
        times = self._times()
        net, of_mesh = self._net()
        masses = self._masses(net)
        own = materials_of(self._data.material, net, self._section)
        start = start_of(self._data.initial, net, masses, self._section, cord=thickest_of(net, own))
        state = State.at(start.state.x, start.state.v, t=self._solver.begin)
        tied = self._tied(start.net, state)
        closings = self._closings(tied.net)
        with self._section("closing"):
            closed = with_closings(tied.net, tied.start, closings)
        told = [
            *self._restraints(tied.net, start.launch),
            *told_in("tether", tied.restraints),
            *map(Told, closed.restraints, repeat("closing"), closed.numbers),
        ]
        restraints = [each.restraint for each in told]
        loads = self._loads(tied.net, tied.start.x)
        materials = {
            **materials_of(self._data.material, start.net, self._section),
            **tied.materials,
            **closed.materials,
        }
        begin, end = self._solver.begin, self._solver.end
        v = joined_velocities(closed.start.v, closed.net, restraints, begin)
        state = State.at(closed.start.x, v, t=begin)
        late = late_findings(told, begin, end, self._section)
        check_restraints(told, closed.net, state, self._section)
        with self._section():
            system = System(
                closed.net,
                materials,
                damping=self._damping(),
                masses={**masses, **tied.masses},
                loads=loads,
                restraints=restraints,
                reels=(*tied.reels, *closed.reels),
                forces=closed.forces,
            )
        with self._section("metrics"):
            metrics = metrics_of(self._data.metrics, system)
        options = closing_options(self._options(), self._solver, closings)
        findings: list[str] = [*of_mesh, *start.findings, *late]
        notes = [*overpowered(closings)]
        accuracy = accuracy_told(options.tolerances, closings) if options.in_force else None
        if accuracy is not None:
            (notes if sharp_enough(options.tolerances, closings) else findings).append(accuracy)
        notes += unusual_of(system, state, start.launch)
        return Simulation(
            self._title,
            system,
            state,
            times,
            options,
            metrics,
            tuple(findings),
            self._events(system, metrics, told),
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

    def _times(self) -> FloatArray:
        solver = self._solver
        with self._section("solver"):
            if solver.end <= solver.begin:
                raise InputError(f"end is {solver.end:g} s, expected a time after begin, {solver.begin:g} s")
            times = np.linspace(solver.begin, solver.end, self._data.output.frames)
            if solver.end - solver.begin < SHORTEST_FLIGHT or not (np.diff(times) > 0).all():
                raise InputError(
                    f"the flight lasts {solver.end - solver.begin:g} s from {solver.begin:g} s on: "
                    f"give an end {SHORTEST_FLIGHT:g} s after the begin at least, and fewer frames if there are many"
                )
        return times

    def _options(self) -> SolverOptions:
        solver = self._solver
        with self._section("solver"):
            return SolverOptions(
                method=solver.method,
                accuracy=solver.accuracy,
                rtol=solver.rtol,
                atol_position=solver.atol_position,
                atol_velocity=solver.atol_velocity,
                max_order=solver.max_order,
                max_step=solver.max_step,
            )

    # The net and what it is made of

    def _net(self) -> tuple[CableNet, tuple[str, ...]]:
        net = self._data.net
        if isinstance(net, MeshFile):
            path = self._folder / net.file
            with self._section("net", key="file"):
                found = describe(path, surface_edges=net.surface_edges)
            return found.net, tuple(f"{path}: {finding}" for finding in found.findings)
        pattern = getattr(CableNet, net.kind)
        with self._section("net"):
            return pattern(**net.model_dump(exclude={"kind"})), ()

    def _damping(self) -> Damping:
        with self._section("damping"):
            return damping_of(self._data.damping)

    def _masses(self, net: CableNet) -> dict[str, float]:
        masses: dict[str, float] = {}
        for number, entry in enumerate(self._data.masses):
            with self._section("masses", number):
                self._check_nodes(net, entry.group)
            masses[entry.group] = masses.get(entry.group, 0.0) + entry.mass
        return masses

    def _check_nodes(self, net: CableNet, group: str) -> None:
        check_group(net.node_groups, group, "node")
        if group == "all" and (self._data.tether is not None or self._data.closing):
            raise InputError(
                "group 'all' has the tether, the chaser and all drums in it too: name a group of the net alone"
            )

    def _tied(self, net: CableNet, start: State) -> Tethered:
        """The net with its tether; as it is where it has none."""
        entry = self._data.tether
        if entry is None:
            return Tethered.without(net, start)
        locking = self._event_that("lock_tether")
        if locking and entry.lock is not None:
            with self._section("tether", key="lock"):
                raise InputError(f"the event {locking!r} locks the tether too: let one of them do it")
        with self._section("tether"):
            tether = tether_of(entry, self._folder, self._solver)
            return with_tether(net, start, replace(tether, lock=locking) if locking else tether)

    def _closings(self, net: CableNet) -> list[Closing]:
        """Winches and drawcords, on the net's own nodes."""
        closings, starting = [], self._event_that("start_closing")
        for number, entry in enumerate(self._data.closing):
            with self._section("closing", number):
                if starting and entry.begin is None:
                    entry = entry.model_copy(update={"begin": starting})
                closings.append(closing_of(entry, net, self._solver.begin))
        return closings

    def _event_that(self, action: str) -> str | None:
        """Name of the event with an action that one event may have; None where there is none."""
        found: str | None = None
        for number, told in enumerate(self._data.events):
            if told.action == action:
                with self._section("events", number):
                    if found is not None:
                        raise InputError(
                            f"the event {found!r} has the action {action} already: let one have it"
                        )
                    found = Event(told.figure, told.value, action=told.action, name=told.name or "").name
        return found

    # What acts on it

    def _loads(self, net: CableNet, x: FloatArray) -> list[Load]:
        """Loads on a net whose nodes start at x (n, 3)."""
        loads: list[Load] = []
        orbit = self._data.orbit
        if orbit is not None:
            with self._section("orbit"):
                loads.append(orbit_load_of(orbit))
        for number, load in enumerate(self._data.loads):
            with self._section("loads", number):
                if isinstance(load, schema.UniformGravity):
                    loads.append(Gravity(signal_of(load.g, load, self._folder, self._solver)))
                elif isinstance(load, schema.NodalForce):
                    self._check_nodes(net, load.group)
                    signal = signal_of(load.force, load, self._folder, self._solver)
                    loads.append(NodalLoad(load.group, signal))
                elif isinstance(load, springs.SpringEntry):
                    loads.append(springs.spring_of(load, x))
                else:
                    loads += environment_loads_of(
                        load, orbit, net=net, folder=self._folder, solver=self._solver
                    )
        return loads

    def _restraints(self, net: CableNet, launch: Launch) -> list[Told]:
        """Those of [[restraints]], and those that hold the bullets."""
        told = []
        for number, hold in enumerate(self._data.restraints):
            with self._section("restraints", number):
                self._check_nodes(net, hold.group)
                told.append(Told(restraint_of(hold, self._folder, self._solver), "restraints", number))
        held = held_bullets_of(launch, self._data.initial.velocity, self._solver.begin)
        return [*told, *told_in("initial", held)]

    # What is looked for

    def _events(self, system: System, metrics: DeploymentMetrics, restraints: list[Told]) -> EventBook | None:
        has: set[Need] = set()
        if metrics.mouth is not None:
            has.add("mouth")
            if metrics.corners is not None:
                has.add("corners")
        if self._data.tether is not None:
            has |= {"tether", "chaser"}
        if np.isfinite(system.strength).any():
            has.add("strength")
        if any(entry.begin is None for entry in self._data.closing):
            has.add("closing")
        events: list[Event] = []
        for number, entry in enumerate(self._data.events):
            with self._section("events", number):
                events.append(event_of(entry, events, has=has))
        for restraint, section, place in restraints:
            with self._section(section, place):
                for name in restraint.events:
                    event_called(name, events, by="lock" if section == "tether" else "begin or until")
        if not events:
            return None
        with self._section("events"):
            return EventBook(events, system, mouth=metrics.mouth, corners=metrics.corners)
