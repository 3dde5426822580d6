"""netdae: deployable cable nets for active space-debris removal, from the stowed pack to the spread net.

The names below are loaded at their first use, so that `import netdae` stays light.
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any

from netdae.core.kernel_cache import forget_outdated

__version__ = "0.1.0"

if TYPE_CHECKING:
    from netdae.core.arrays import Flags, Reals, Reals2, Wholes
    from netdae.core.errors import InputError, MeshError, NetdaeError, RunError, ScenarioError
    from netdae.events.detector import EventDetector
    from netdae.events.event import Event
    from netdae.forces.air import AirDrag
    from netdae.forces.drag import BodyDrag
    from netdae.forces.elements import ElementForce
    from netdae.forces.force import Account, Force, Tangent
    from netdae.forces.free_molecular import FreeMolecularDrag
    from netdae.forces.law import Law, compiled
    from netdae.forces.loads import Gravity, NodalLoad
    from netdae.forces.orbit import Orbit
    from netdae.forces.rings import Rings
    from netdae.forces.solar import BodySolarPressure, SolarPressure
    from netdae.forces.spring import Spring
    from netdae.initial.accordion import accordion
    from netdae.initial.canister import Canister
    from netdae.initial.ejection import Ejection, Launch, Spread, fired
    from netdae.initial.scaled import ejected, scaled
    from netdae.initial.spin import spun
    from netdae.initial.star import star
    from netdae.mesh.graph import net_of_graph
    from netdae.mesh.io import read_net, write_net
    from netdae.mesh.surface import read_surface
    from netdae.model.material import Material
    from netdae.model.motions import Fixed, FunctionMotion, Steady, TableMotion
    from netdae.model.mouth import mouth_of, vector_area
    from netdae.model.net import CableNet
    from netdae.model.restraints import Restraint
    from netdae.model.shapes.hull import ConvexHull
    from netdae.model.shapes.part import Part
    from netdae.model.shapes.rigid_body import RigidBody
    from netdae.model.shapes.solids import Box, Capsule, Cone, Cylinder, Plane, Sphere
    from netdae.model.shapes.surface_mesh import SurfaceMesh
    from netdae.model.signals import Function, Pulse, Table
    from netdae.model.state import State, Trajectory
    from netdae.model.target import Contact, Obstacle, Target
    from netdae.model.tether import Chaser, Tether
    from netdae.output.metrics import COLUMNS, DeploymentMetrics
    from netdae.output.observers import MetricsCsv, Progress
    from netdae.output.target_series import TargetSeries
    from netdae.output.vtk import VtuSeries
    from netdae.scenario.reader import read_scenario
    from netdae.solvers.driver import integrate
    from netdae.solvers.flight import simulate
    from netdae.solvers.modes import frequencies
    from netdae.solvers.options import SolverOptions
    from netdae.solvers.statics import Equilibrium, equilibrium
    from netdae.system.closing import Drawcord, Haul, Winch
    from netdae.system.closing_assembly import rings_through, with_closings
    from netdae.system.damping import Dashpot, NoDamping, Rayleigh
    from netdae.system.pulleys import PulleyCord, with_pulleys
    from netdae.system.reels import Reel
    from netdae.system.system import System
    from netdae.system.tether_assembly import with_tether
    from netdae.visual.plotting.sheets import plot
    from netdae.visual.rendering.look import Look
    from netdae.visual.rendering.views import (
        Rendering,
        render_movie,
        render_page,
        render_picture,
        render_sheet,
    )

_HOMES = {
    "netdae.core.arrays": ("Flags", "Reals", "Reals2", "Wholes"),
    "netdae.initial.accordion": ("accordion",),
    "netdae.system.closing": ("Drawcord", "Haul", "Winch"),
    "netdae.system.closing_assembly": ("rings_through", "with_closings"),
    "netdae.system.damping": ("Dashpot", "NoDamping", "Rayleigh"),
    "netdae.initial.ejection": ("Ejection", "Launch", "Spread", "fired"),
    "netdae.core.errors": ("InputError", "MeshError", "NetdaeError", "RunError", "ScenarioError"),
    "netdae.events.detector": ("EventDetector",),
    "netdae.events.event": ("Event",),
    "netdae.forces.air": ("AirDrag",),
    "netdae.forces.drag": ("BodyDrag",),
    "netdae.forces.elements": ("ElementForce",),
    "netdae.forces.law": ("Law", "compiled"),
    "netdae.forces.free_molecular": ("FreeMolecularDrag",),
    "netdae.forces.loads": ("Gravity", "NodalLoad"),
    "netdae.forces.orbit": ("Orbit",),
    "netdae.forces.rings": ("Rings",),
    "netdae.forces.force": ("Account", "Force", "Tangent"),
    "netdae.forces.spring": ("Spring",),
    "netdae.forces.solar": ("BodySolarPressure", "SolarPressure"),
    "netdae.initial.scaled": ("ejected", "scaled"),
    "netdae.solvers.driver": ("integrate",),
    "netdae.model.material": ("Material",),
    "netdae.mesh.graph": ("net_of_graph",),
    "netdae.mesh.io": ("read_net", "write_net"),
    "netdae.mesh.surface": ("read_surface",),
    "netdae.output.metrics": ("COLUMNS", "DeploymentMetrics"),
    "netdae.solvers.modes": ("frequencies",),
    "netdae.model.motions": ("Fixed", "FunctionMotion", "Steady", "TableMotion"),
    "netdae.model.mouth": ("mouth_of", "vector_area"),
    "netdae.model.net": ("CableNet",),
    "netdae.output.observers": ("MetricsCsv", "Progress"),
    "netdae.solvers.options": ("SolverOptions",),
    "netdae.visual.plotting.sheets": ("plot",),
    "netdae.system.pulleys": ("PulleyCord", "with_pulleys"),
    "netdae.system.reels": ("Reel",),
    "netdae.visual.rendering.views": (
        "Rendering",
        "render_movie",
        "render_page",
        "render_picture",
        "render_sheet",
    ),
    "netdae.visual.rendering.look": ("Look",),
    "netdae.model.restraints": ("Restraint",),
    "netdae.model.shapes.hull": ("ConvexHull",),
    "netdae.model.shapes.part": ("Part",),
    "netdae.model.shapes.rigid_body": ("RigidBody",),
    "netdae.model.shapes.solids": ("Box", "Capsule", "Cone", "Cylinder", "Plane", "Sphere"),
    "netdae.model.shapes.surface_mesh": ("SurfaceMesh",),
    "netdae.scenario.reader": ("read_scenario",),
    "netdae.model.signals": ("Function", "Pulse", "Table"),
    "netdae.solvers.flight": ("simulate",),
    "netdae.initial.spin": ("spun",),
    "netdae.initial.star": ("star",),
    "netdae.model.state": ("State", "Trajectory"),
    "netdae.solvers.statics": ("Equilibrium", "equilibrium"),
    "netdae.initial.canister": ("Canister",),
    "netdae.system.system": ("System",),
    "netdae.model.target": ("Contact", "Obstacle", "Target"),
    "netdae.model.tether": ("Chaser", "Tether"),
    "netdae.system.tether_assembly": ("with_tether",),
    "netdae.output.target_series": ("TargetSeries",),
    "netdae.output.vtk": ("VtuSeries",),
}
_HOME_OF = {name: module for module, names in _HOMES.items() for name in names}

_RENAMED = {"EventBook": "EventDetector"}

__all__ = ["__version__", *sorted(_HOME_OF)]

forget_outdated(os.path.dirname(__file__))


def __getattr__(name: str) -> Any:
    name = _RENAMED.get(name, name)
    if name not in _HOME_OF:
        raise AttributeError(f"module 'netdae' has no attribute {name!r}")
    value = getattr(import_module(_HOME_OF[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
