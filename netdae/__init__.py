"""netdae: deployable cable nets for active space-debris removal, from the stowed pack to the spread net.

The names below are loaded at their first use, so that `import netdae` stays light.
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any

from netdae._kernel_cache import forget_outdated

__version__ = "0.1.0"

if TYPE_CHECKING:
    from netdae._arrays import Flags, Reals, Reals2, Wholes
    from netdae.damping import Dashpot, NoDamping, Rayleigh
    from netdae.ejection import Ejection, Launch, Spread, fired
    from netdae.errors import InputError, MeshError, NetdaeError, RunError, ScenarioError
    from netdae.events.book import EventBook
    from netdae.events.event import Event
    from netdae.flight import simulate
    from netdae.forces.air import AirDrag
    from netdae.forces.drag import BodyDrag
    from netdae.forces.elements import ElementForce
    from netdae.forces.free_molecular import FreeMolecularDrag
    from netdae.forces.law import Law, compiled
    from netdae.forces.loads import Gravity, NodalLoad
    from netdae.forces.orbit import Orbit
    from netdae.forces.protocol import Account, Force, Tangent
    from netdae.forces.solar import BodySolarPressure, SolarPressure
    from netdae.forces.spring import Spring
    from netdae.initial import ejected, scaled
    from netdae.integration import integrate
    from netdae.material import Material
    from netdae.mesh.io import read_net, write_net
    from netdae.metrics import DeploymentMetrics
    from netdae.modes import frequencies
    from netdae.motions import Fixed, FunctionMotion, Steady, TableMotion
    from netdae.net import CableNet
    from netdae.observers import MetricsCsv, Progress
    from netdae.options import SolverOptions
    from netdae.plotting.sheets import plot
    from netdae.reels import Reel
    from netdae.rendering.look import Look
    from netdae.rendering.views import Rendering, render_movie, render_page, render_picture, render_sheet
    from netdae.restraints import Restraint
    from netdae.scenario.reader import read_scenario
    from netdae.signals import Function, Pulse, Table
    from netdae.state import State, Trajectory
    from netdae.statics import Equilibrium, equilibrium
    from netdae.stowing.accordion import accordion
    from netdae.stowing.canister import Canister
    from netdae.stowing.star import star
    from netdae.system import System
    from netdae.tether import Chaser, Tether
    from netdae.tethered import with_tether
    from netdae.vtk import VtuSeries

_HOMES = {
    "netdae._arrays": ("Flags", "Reals", "Reals2", "Wholes"),
    "netdae.stowing.accordion": ("accordion",),
    "netdae.damping": ("Dashpot", "NoDamping", "Rayleigh"),
    "netdae.ejection": ("Ejection", "Launch", "Spread", "fired"),
    "netdae.errors": ("InputError", "MeshError", "NetdaeError", "RunError", "ScenarioError"),
    "netdae.events.book": ("EventBook",),
    "netdae.events.event": ("Event",),
    "netdae.forces.air": ("AirDrag",),
    "netdae.forces.drag": ("BodyDrag",),
    "netdae.forces.elements": ("ElementForce",),
    "netdae.forces.law": ("Law", "compiled"),
    "netdae.forces.free_molecular": ("FreeMolecularDrag",),
    "netdae.forces.loads": ("Gravity", "NodalLoad"),
    "netdae.forces.orbit": ("Orbit",),
    "netdae.forces.protocol": ("Account", "Force", "Tangent"),
    "netdae.forces.spring": ("Spring",),
    "netdae.forces.solar": ("BodySolarPressure", "SolarPressure"),
    "netdae.initial": ("ejected", "scaled"),
    "netdae.integration": ("integrate",),
    "netdae.material": ("Material",),
    "netdae.mesh.io": ("read_net", "write_net"),
    "netdae.metrics": ("DeploymentMetrics",),
    "netdae.modes": ("frequencies",),
    "netdae.motions": ("Fixed", "FunctionMotion", "Steady", "TableMotion"),
    "netdae.net": ("CableNet",),
    "netdae.observers": ("MetricsCsv", "Progress"),
    "netdae.options": ("SolverOptions",),
    "netdae.plotting.sheets": ("plot",),
    "netdae.reels": ("Reel",),
    "netdae.rendering.views": ("Rendering", "render_movie", "render_page", "render_picture", "render_sheet"),
    "netdae.rendering.look": ("Look",),
    "netdae.restraints": ("Restraint",),
    "netdae.scenario.reader": ("read_scenario",),
    "netdae.signals": ("Function", "Pulse", "Table"),
    "netdae.flight": ("simulate",),
    "netdae.stowing.star": ("star",),
    "netdae.state": ("State", "Trajectory"),
    "netdae.statics": ("Equilibrium", "equilibrium"),
    "netdae.stowing.canister": ("Canister",),
    "netdae.system": ("System",),
    "netdae.tether": ("Chaser", "Tether"),
    "netdae.tethered": ("with_tether",),
    "netdae.vtk": ("VtuSeries",),
}
_HOME_OF = {name: module for module, names in _HOMES.items() for name in names}

__all__ = ["__version__", *sorted(_HOME_OF)]

forget_outdated(os.path.dirname(__file__))


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'netdae' has no attribute {name!r}")
    value = getattr(import_module(_HOME_OF[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
