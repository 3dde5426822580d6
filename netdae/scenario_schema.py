"""What may stand in a scenario file: its sections and keys, with units, ranges and defaults.

Numbers are strict (no text, no true or false) and finite, SI units; angles are in degrees where a key ends in
`_deg`. File names are relative to the scenario file.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Strict, Tag, model_validator
from pydantic_core import PydanticCustomError

from netdae.options import COARSEST_RTOL, FINEST_RTOL, Method

# Ranges hold whatever a net can be, and far more; outside of them it is a slip of the finger or of the unit, and
# squares and cubes of the numbers leave what double precision holds.
Length = Annotated[float, Field(ge=1e-6, le=1e6)]  # m
Thickness = Annotated[float, Field(ge=1e-9, le=1e3)]  # m
Area = Annotated[float, Field(ge=1e-18, le=1e6)]  # m²
Modulus = Annotated[float, Field(ge=1e-3, le=1e15)]  # Pa; diamond has 1e12
Density = Annotated[float, Field(ge=1e-9, le=1e6)]  # kg/m³; osmium has 2e4
LinearDensity = Annotated[float, Field(ge=1e-15, le=1e6)]  # kg/m
BreakingForce = Annotated[float, Field(ge=1e-9, le=1e15)]  # N
NodeMass = Annotated[float, Field(ge=0, le=1e9)]  # kg
Speed = Annotated[float, Field(ge=0, le=1e6)]  # m/s; light has 3e8, debris 1e4
DampingTime = Annotated[float, Field(ge=0, le=1e6)]  # s, a share of critical, or 1/s
Time = Annotated[float, Field(ge=-1e9, le=1e9)]  # s; 1e9 are thirty years
Tolerance = Annotated[
    float, Field(ge=1e-15, le=1e3)
]  # m or m/s; positions of metres have no digits below 1e-16
Step = Annotated[float, Field(ge=1e-12, le=1e9)]  # s
Factor = Annotated[float, Field(ge=-1e3, le=1e3)]
Component = Annotated[float, Field(ge=-1e6, le=1e6)]  # m/s, m/s², degrees
ForceComponent = Annotated[float, Field(ge=-1e12, le=1e12)]  # N
Count = Annotated[int, Field(ge=1)]
Text = Annotated[str, Field(min_length=1)]
# TOML has lists only; the numbers stay strict
Vector = Annotated[tuple[Component, Component, Component], Strict(False)]
FactorVector = Annotated[tuple[Factor, Factor, Factor], Strict(False)]
ForceVector = Annotated[tuple[ForceComponent, ForceComponent, ForceComponent], Strict(False)]

NONE = "none"
"""What the keys of [metrics] say where a net has no such group."""


class Section(BaseModel):
    """A table of the scenario, with unknown and missing keys told by their names."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _just_the_keys(cls, data: Any) -> Any:
        if isinstance(data, dict):
            known = list(cls.model_fields)
            for key in data:
                if key not in known:
                    raise PydanticCustomError("unknown_key", "unknown key", {"key": key, "known": known})
            for key, field in cls.model_fields.items():
                if field.is_required() and key not in data:
                    raise PydanticCustomError(
                        "missing_key", "missing key", {"key": key, "what": field.description}
                    )
        return data


class TableFile(Section):
    """A CSV table with the header t,x,y,z; times in s, rising."""

    file: Text = Field(description="CSV file with the header t,x,y,z.")
    interpolation: Literal["linear", "cubic"] = Field("linear", description="Curve through the rows.")


class MotionFile(Section):
    """A CSV table with the header t,x,y,z or t,x,y,z,vx,vy,vz: displacements in m from where the nodes start."""

    file: Text = Field(description="CSV file with the header t,x,y,z or t,x,y,z,vx,vy,vz.")
    interpolation: Literal["linear", "cubic"] = Field("cubic", description="Curve through the rows.")


def _kind_of_table(value: Any) -> str:
    return "<table>" if isinstance(value, dict) else "<value>"


Vector3OrTable = Annotated[
    Annotated[Vector, Tag("<value>")] | Annotated[TableFile, Tag("<table>")], Discriminator(_kind_of_table)
]
ForceOrTable = Annotated[
    Annotated[ForceVector, Tag("<value>")] | Annotated[TableFile, Tag("<table>")],
    Discriminator(_kind_of_table),
]
FixedOrTable = Annotated[
    Annotated[Literal["fixed"], Tag("<value>")] | Annotated[MotionFile, Tag("<table>")],
    Discriminator(_kind_of_table),
]


def _kind_of(value: Any) -> str:
    kind = value.get("kind", "<none>") if isinstance(value, dict) else "<none>"
    return kind if isinstance(kind, str) else "<none>"


class MeshFile(Section):
    """A net from a mesh file."""

    file: Text = Field(description="Mesh file: .vtu .vtk .msh .xdmf or .inp.")
    surface_edges: bool = Field(False, description="Take the edges of surface cells as cables.")


class Square(Section):
    """A square net with square meshes."""

    kind: Literal["square"] = Field(description="Pattern of the net.")
    side: Length = Field(description="Side, m.")
    cells: Count = Field(description="Meshes along a side.")
    subdivide: Count = Field(1, description="Pieces that each cable is cut into.")


class Rectangle(Section):
    """A rectangular net with rectangular meshes."""

    kind: Literal["rectangle"] = Field(description="Pattern of the net.")
    width: Length = Field(description="Length along x, m.")
    height: Length = Field(description="Length along y, m.")
    columns: Count = Field(description="Meshes along x.")
    rows: Count = Field(description="Meshes along y.")
    subdivide: Count = Field(1, description="Pieces that each cable is cut into.")


class Hexagon(Section):
    """A hexagonal net with triangular meshes."""

    kind: Literal["hexagon"] = Field(description="Pattern of the net.")
    radius: Length = Field(description="Distance from the centre to the corners, m.")
    rings: Count = Field(description="Rings of triangles about the centre.")
    subdivide: Count = Field(1, description="Pieces that each cable is cut into.")


class Radial(Section):
    """A spider-web net."""

    kind: Literal["radial"] = Field(description="Pattern of the net.")
    radius: Length = Field(description="Distance from the centre to the border, m.")
    rings: Count = Field(description="Closed rings, the border among them.")
    spokes: int = Field(ge=3, description="Cables from the centre to the border.")
    subdivide: Count = Field(1, description="Pieces that each cable is cut into.")


class Diamond(Section):
    """A square net whose meshes stand on their corners."""

    kind: Literal["diamond"] = Field(description="Pattern of the net.")
    side: Length = Field(description="Side, m.")
    cells: Count = Field(description="Diagonals of meshes along a side.")
    subdivide: Count = Field(1, description="Pieces that each cable is cut into.")


def _kind_of_net(value: Any) -> str:
    kind = _kind_of(value)
    return "<file>" if kind == "<none>" and isinstance(value, dict) and "file" in value else kind


Net = Annotated[
    Annotated[MeshFile, Tag("<file>")]
    | Annotated[Square, Tag("square")]
    | Annotated[Rectangle, Tag("rectangle")]
    | Annotated[Hexagon, Tag("hexagon")]
    | Annotated[Radial, Tag("radial")]
    | Annotated[Diamond, Tag("diamond")],
    Discriminator(_kind_of_net),
]


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
    Discriminator(_kind_of),
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


class Ejection(Section):
    """Nodes that are shot outward from an axis."""

    group: Text = Field(description="Node group.")
    speed: Speed = Field(description="Speed, m/s, beside the velocity of the whole net.")
    half_angle_deg: float = Field(
        ge=0, le=180, description="Angle from the axis, outward from the middle of the group, degrees."
    )
    axis: Vector = Field((0.0, 0.0, 1.0), description="Direction in space; rotation_deg does not turn it.")


class Initial(Section):
    """How the net starts: the mesh drawn together and turned."""

    shape: Literal["scaled"] = Field("scaled", description="How the stowed shape is made of the mesh.")
    scale: FactorVector = Field((1.0, 1.0, 1.0), description="Factors along x, y and z of the mesh.")
    rotation_deg: Vector = Field(
        (0.0, 0.0, 0.0), description="Turns about the fixed x, then y, then z axis, degrees."
    )
    velocity: Vector = Field((0.0, 0.0, 0.0), description="Velocity of the whole net, m/s.")
    ejection: list[Ejection] = Field([], description="Groups that are shot.")


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
    Annotated[NodalForce, Tag("nodal")] | Annotated[UniformGravity, Tag("gravity")], Discriminator(_kind_of)
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
        51, ge=2, le=1_000_000, description="Frames, evenly in time, the start and the end among them."
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
    solver: Solver = Field(description="The time integration.")
    output: Output = Field(Output(), description="What is written.")
    metrics: Metrics = Field(Metrics(), description="What is measured.")
