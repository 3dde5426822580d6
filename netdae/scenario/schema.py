"""What may stand in a scenario file: its sections and keys, with units, ranges and defaults.

Numbers are strict (no text, no true or false) and finite, SI units; angles are in degrees where a key ends in
`_deg`. File names are relative to the scenario file.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from netdae.options import COARSEST_RTOL, FINEST_RTOL, Method
from netdae.scenario import environment, springs
from netdae.scenario.closing import ClosingEntry
from netdae.scenario.events import EventEntry
from netdae.scenario.initial import Initial
from netdae.scenario.nets import Net
from netdae.scenario.section import (
    Area,
    BreakingForce,
    DampingTime,
    Density,
    LinearDensity,
    Modulus,
    NodeMass,
    Section,
    Step,
    Text,
    Thickness,
    Time,
    TimeOrEvent,
    Tolerance,
    kind_of,
)
from netdae.scenario.tables import FixedOrTable, ForceOrTable, Vector3OrTable
from netdae.scenario.tether import TetherEntry

MOST_FRAMES = 1_000_000

NONE = "none"
"""What the keys of [metrics] say where a net has no such group."""


class Cord(Section):
    """What the cables of a group are made of; a later [[material]] overrides, mesh cell data override both."""

    cables: Text = Field("all", description="Cable group.")
    youngs_modulus: Modulus = Field(description="Young's modulus, Pa.")
    density: Density | None = Field(None, description="Density, kg/m³; or give linear_density.")
    linear_density: LinearDensity | None = Field(None, description="Mass per length, kg/m.")
    diameter: Thickness | None = Field(None, description="Diameter, m; or give area.")
    area: Area | None = Field(None, description="Cross-section, m².")
    toe_strain: Annotated[float, Field(ge=0, le=10)] = Field(
        0.0, description="Strain up to which the stress rises quadratically."
    )
    law: Literal["st_venant_kirchhoff", "engineering"] = Field(
        "st_venant_kirchhoff", description="Stress over Green-Lagrange strain, or force over elongation."
    )
    strength: BreakingForce | None = Field(None, description="Breaking force, N.")


CORD_KEYS = {*Cord.model_fields} - {"cables"}
"""Keys of a cord's material, which the sections [tether] and [[closing]] have too."""


class DashpotDamping(Section):
    """A damper along each taut cable."""

    kind: Literal["dashpot"] = Field(description="Kind of damping.")
    viscosity_time: DampingTime | None = Field(None, description="Viscosity over Young's modulus, s.")
    zeta: DampingTime | None = Field(None, description="Share of critical of a cable's own axial mode.")


class RayleighDamping(Section):
    """D = α M + β T(x̄); it also damps rigid rotations of the net."""

    kind: Literal["rayleigh"] = Field(description="Kind of damping.")
    alpha: DampingTime = Field(0.0, description="Factor of the mass matrix, 1/s.")
    beta: DampingTime = Field(0.0, description="Factor of the tangent stiffness of the reference, s.")


class WithoutDamping(Section):
    """No damping."""

    kind: Literal["none"] = Field(description="Kind of damping.")


Damping = Annotated[
    Annotated[DashpotDamping, Tag("dashpot")]
    | Annotated[RayleighDamping, Tag("rayleigh")]
    | Annotated[WithoutDamping, Tag("none")],
    Discriminator(kind_of),
]


class Mass(Section):
    """Bullets, or other masses at nodes; those of several entries add up."""

    group: Text = Field(description="Node group.")
    mass: NodeMass = Field(description="Mass at each node of the group, kg.")


class Hold(Section):
    """Axes of a node group that are fixed, or driven along a table."""

    group: Text = Field(description="Node group.")
    axes: Text = Field("xyz", description="Which of x, y and z are held, for instance xyz.")
    motion: FixedOrTable = Field(
        "fixed", description='"fixed", or a table of displacements from the start, m.'
    )
    begin: TimeOrEvent | None = Field(
        None, description="Time in s, or name of an event, at which it begins; the start by default."
    )
    until: TimeOrEvent | None = Field(
        None, description="Time in s, or name of an event, at which it ends; never by default."
    )


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


Load = Annotated[
    Annotated[NodalForce, Tag("nodal")]
    | Annotated[UniformGravity, Tag("gravity")]
    | Annotated[environment.DragEntry, Tag("drag")]
    | Annotated[environment.SolarPressureEntry, Tag("solar_pressure")]
    | Annotated[environment.AirEntry, Tag("air")]
    | Annotated[springs.SpringEntry, Tag("spring")],
    Discriminator(kind_of),
]


class Solver(Section):
    """The time integration."""

    method: Method = Field(
        "ida",
        description="SUNDIALS IDA, or explicit, the velocity Verlet without tolerances; the others to compare with.",
    )
    begin: Time = Field(0.0, description="Time of the start, s.")
    end: Time = Field(description="Time of the end, s.")
    accuracy: Literal["fast", "standard", "accurate"] = Field(
        "standard", description="Preset of rtol, atol_position and atol_velocity, each of which overrides it."
    )
    rtol: Annotated[float, Field(ge=FINEST_RTOL, le=COARSEST_RTOL)] | None = Field(
        None, description="Relative tolerance."
    )
    atol_position: Tolerance | None = Field(None, description="Absolute tolerance of positions, m.")
    atol_velocity: Tolerance | None = Field(None, description="Absolute tolerance of velocities, m/s.")
    max_order: Annotated[int, Field(ge=1, le=5)] | None = Field(
        None, description="Highest order of the BDF formulas, 5 by default."
    )
    max_step: Step | None = Field(None, description="Largest time step, s.")


class Output(Section):
    """What is written."""

    frames: int = Field(
        51, ge=2, le=MOST_FRAMES, description="Frames, evenly in time, the start and the end among them."
    )


class Metrics(Section):
    """What is measured."""

    mouth: Text | None = Field(
        None,
        description='Group of the closed loop of the mouth; "border" if the net has it; "none" for none.',
    )
    corners: Text | None = Field(
        None, description='Node group of the corners; "corners" if the net has it; "none" for none.'
    )


class ScenarioData(Section):
    """A scenario: a net, how it starts, what acts on it, how it is flown."""

    title: str = Field("", description="What the flight is called.")
    net: Net = Field(description="The net: file = a mesh file, or kind = a pattern with its keys.")
    material: list[Cord] = Field(
        min_length=1, description="What the cables are made of, one per cable group."
    )
    damping: Damping = Field(description='kind = "dashpot", "rayleigh" or "none".')
    masses: list[Mass] = Field([], description="Bullets and other masses at nodes.")
    restraints: list[Hold] = Field([], description="Fixed and driven nodes.")
    initial: Initial = Field(Initial(), description="How the net starts.")
    loads: list[Load] = Field([], description="Forces from outside.")
    orbit: environment.OrbitEntry | None = Field(
        None, description="The orbit that the frame goes round with."
    )
    tether: TetherEntry | None = Field(None, description="The cord to the chaser.")
    closing: list[ClosingEntry] = Field([], description="Winches and drawcords that close the net.")
    events: list[EventEntry] = Field([], description="Instants that are looked for, and what is done then.")
    solver: Solver = Field(description="The time integration.")
    output: Output = Field(Output(), description="What is written.")
    metrics: Metrics = Field(Metrics(), description="What is measured.")
