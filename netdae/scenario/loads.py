"""The section [[loads]] of a scenario, and the loads that it makes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from netdae.core.arrays import FloatArray
from netdae.forces.loads import Gravity, Load, NodalLoad
from netdae.model.net import CableNet
from netdae.scenario.environment import AirEntry, DragEntry, SolarPressureEntry, environment_loads_of
from netdae.scenario.groups import check_nodes
from netdae.scenario.orbit import OrbitEntry
from netdae.scenario.problems import InSection
from netdae.scenario.section import Section, Text, Time, kind_of
from netdae.scenario.signals import ForceOrTable, Vector3OrTable, signal_of
from netdae.scenario.solver import Solver
from netdae.scenario.springs import SpringEntry, spring_of


class NodalForce(Section):
    """The same force on each node of a group."""

    kind: Literal["nodal"] = Field(description="Kind of load.")
    group: Text = Field(description="Node group.")
    force: ForceOrTable = Field(description="Force on each node, N, or a table of it.")
    begin: Time | None = Field(
        None, description="Time at which a constant force sets in, s; the start by default."
    )
    end: Time | None = Field(None, description="Time at which a constant force ends, s; never by default.")


class UniformGravity(Section):
    """Gravity on all masses."""

    kind: Literal["gravity"] = Field(description="Kind of load.")
    g: Vector3OrTable = Field(description="Acceleration, m/s², or a table of it.")
    begin: Time | None = Field(
        None, description="Time at which a constant g sets in, s; the start by default."
    )
    end: Time | None = Field(None, description="Time at which a constant g ends, s; never by default.")


LoadEntry = Annotated[
    Annotated[NodalForce, Tag("nodal")]
    | Annotated[UniformGravity, Tag("gravity")]
    | Annotated[DragEntry, Tag("drag")]
    | Annotated[SolarPressureEntry, Tag("solar_pressure")]
    | Annotated[AirEntry, Tag("air")]
    | Annotated[SpringEntry, Tag("spring")],
    Discriminator(kind_of),
]


def loads_of(
    entries: Sequence[LoadEntry],
    orbit: OrbitEntry | None,
    net: CableNet,
    x: FloatArray,
    folder: Path,
    solver: Solver,
    section: InSection,
    *,
    alone: bool,
) -> list[Load]:
    """The loads of the entries, on a net whose nodes start at x (n, 3); raises InputError through `section`.

    folder : of the scenario file, to which tables are relative
    alone : see `check_nodes`
    """
    loads: list[Load] = []
    for number, entry in enumerate(entries):
        with section("loads", number):
            if isinstance(entry, UniformGravity):
                loads.append(Gravity(signal_of(entry.g, folder, solver, begin=entry.begin, end=entry.end)))
            elif isinstance(entry, NodalForce):
                check_nodes(net, entry.group, alone=alone)
                force = signal_of(entry.force, folder, solver, begin=entry.begin, end=entry.end)
                loads.append(NodalLoad(entry.group, force))
            elif isinstance(entry, SpringEntry):
                check_nodes(net, entry.group, alone=alone)
                loads.append(spring_of(entry, x))
            else:
                loads += environment_loads_of(entry, orbit, net=net, folder=folder, solver=solver)
    return loads
