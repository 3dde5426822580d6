"""What may stand in a scenario file: its sections, each of which is a module with its keys and what they make.

Numbers are strict (no text, no true or false) and finite, SI units; angles are in degrees where a key ends in
`_deg`. File names are relative to the scenario file.
"""

from __future__ import annotations

from pydantic import Field

from netdae.scenario.closing import ClosingEntry
from netdae.scenario.damping import DampingEntry
from netdae.scenario.events import EventEntry
from netdae.scenario.initial import Initial
from netdae.scenario.loads import LoadEntry
from netdae.scenario.masses import Mass
from netdae.scenario.material import Cord
from netdae.scenario.metrics import Metrics
from netdae.scenario.nets import Net
from netdae.scenario.obstacles import ObstacleEntry
from netdae.scenario.orbit import OrbitEntry
from netdae.scenario.output import Output
from netdae.scenario.pulleys import PulleyCordEntry
from netdae.scenario.restraints import Hold
from netdae.scenario.section import Section
from netdae.scenario.solver import Solver
from netdae.scenario.target import TargetEntry
from netdae.scenario.tether import TetherEntry


class ScenarioData(Section):
    """A scenario: a net, how it starts, what acts on it, how it is flown."""

    title: str = Field("", description="What the flight is called.")
    net: Net = Field(description="The net: file = a mesh file, or kind = a pattern with its keys.")
    material: list[Cord] = Field(
        min_length=1, description="What the cables are made of, one per cable group."
    )
    damping: DampingEntry = Field(description='kind = "dashpot", "rayleigh" or "none".')
    masses: list[Mass] = Field([], description="Bullets and other masses at nodes.")
    restraints: list[Hold] = Field([], description="Fixed and driven nodes.")
    initial: Initial = Field(Initial(), description="How the net starts.")
    loads: list[LoadEntry] = Field([], description="Forces from outside.")
    orbit: OrbitEntry | None = Field(None, description="The orbit that the frame goes round with.")
    tether: TetherEntry | None = Field(None, description="The cord to the chaser.")
    closing: list[ClosingEntry] = Field([], description="Winches and drawcords that close the net.")
    pulleys: list[PulleyCordEntry] = Field([], description="Cords of constant length through rings.")
    target: TargetEntry | None = Field(None, description="The rigid body that the net meets.")
    obstacles: list[ObstacleEntry] = Field([], description="Fixed bodies, such as a floor.")
    events: list[EventEntry] = Field([], description="Instants that are looked for, and what is done then.")
    solver: Solver = Field(description="The time integration.")
    output: Output = Field(Output(), description="What is written.")
    metrics: Metrics = Field(Metrics(), description="What is measured.")
