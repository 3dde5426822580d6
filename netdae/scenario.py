"""Scenario files: TOML, checked against the schema, and built into a simulation that is ready to fly."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from netdae import scenario_schema as schema
from netdae._arrays import FloatArray
from netdae._files import reason_of
from netdae.damping import Damping, Dashpot, NoDamping, Rayleigh
from netdae.errors import InputError, ScenarioError
from netdae.forces.loads import Gravity, Load, NodalLoad
from netdae.initial import ejected, scaled
from netdae.integration import Integration, Watch, integrate
from netdae.material import Material
from netdae.mesh_io import describe
from netdae.metrics import DeploymentMetrics
from netdae.motions import Fixed, Motion, TableMotion
from netdae.net import CableNet
from netdae.options import SolverOptions
from netdae.restraints import Restraint
from netdae.scenario_problems import first_problem
from netdae.signals import Constant, Pulse, Signal, Table
from netdae.state import State
from netdae.system import System
from netdae.tables import read_table

FORCE_HEADER = ("t", "x", "y", "z")
MOTION_HEADER = (*FORCE_HEADER, "vx", "vy", "vz")


@dataclass(frozen=True, eq=False)
class Simulation:
    """All that a flight needs.

    times : (k,), s, of the frames; the first is the start's
    metrics : the observer that measures the deployment
    findings : what the author of the mesh file should know
    """

    title: str
    system: System
    start: State
    times: FloatArray
    options: SolverOptions
    metrics: DeploymentMetrics
    findings: tuple[str, ...] = ()

    def integrate(self, watch: tuple[Watch, ...] = ()) -> Integration:
        """Iterator over the States at `times`."""
        return integrate(self.system, self.start, self.times, options=self.options, watch=watch)


@dataclass(frozen=True, eq=False)
class Scenario:
    """A scenario file whose sections, keys and values are in order.

    path : the file, to which the names of other files are relative
    text : its bytes
    """

    path: Path
    text: bytes
    data: schema.ScenarioData

    @property
    def title(self) -> str:
        """Title, or the file's name without its ending."""
        return self.data.title or self.path.stem

    def build(self) -> Simulation:
        """Read meshes and tables, and make all ready; raises InputError for what cannot fly."""
        data, solver = self.data, self.data.solver
        with self._section("solver"):
            if solver.end <= solver.begin:
                raise InputError(f"end is {solver.end:g} s, expected a time after begin, {solver.begin:g} s")
        net, findings = self._net()
        turned, start = scaled(
            net, data.initial.scale, rotation_deg=data.initial.rotation_deg, velocity=data.initial.velocity
        )
        for number, shot in enumerate(data.initial.ejection):
            with self._section("initial.ejection", number):
                start = ejected(
                    turned,
                    start,
                    shot.group,
                    speed=shot.speed,
                    half_angle_deg=shot.half_angle_deg,
                    axis=shot.axis,
                )
        restraints = self._restraints(turned)
        materials, masses, loads = self._materials(turned), self._masses(turned), self._loads(turned)
        with self._section():
            system = System(
                turned, materials, damping=self._damping(), masses=masses, loads=loads, restraints=restraints
            )
            start = State.at(start.x, self._joined(start.v, turned, restraints), t=solver.begin)
            system.drive_from(start.x).check_start(start.t, start.v)
            system.check_covers(solver.begin, solver.end)
        with self._section("solver"):
            options = SolverOptions(
                method=solver.method,
                accuracy=solver.accuracy,
                rtol=solver.rtol,
                atol_position=solver.atol_position,
                atol_velocity=solver.atol_velocity,
                max_order=solver.max_order,
                max_step=solver.max_step,
            )
        times = np.linspace(solver.begin, solver.end, data.output.frames)
        return Simulation(self.title, system, start, times, options, self._metrics(system), findings)

    def _file(self, name: str) -> Path:
        return self.path.parent / name

    @contextmanager
    def _section(self, name: str = "", number: int | None = None) -> Iterator[None]:
        """Tell errors of the content by file and section."""
        header = "" if not name else f"[{name}]: " if number is None else f"[[{name}]] {number + 1}: "
        try:
            yield
        except ScenarioError:
            raise
        except InputError as error:
            raise ScenarioError(f"{self.path}: {header}{_bare(error)}") from error

    def _net(self) -> tuple[CableNet, tuple[str, ...]]:
        net = self.data.net
        if isinstance(net, schema.MeshFile):
            path = self._file(net.file)
            found = describe(path, surface_edges=net.surface_edges)
            return found.net, tuple(f"{path}: {finding}" for finding in found.findings)
        pattern = getattr(CableNet, net.kind)
        with self._section("net"):
            return pattern(**net.model_dump(exclude={"kind"})), ()

    def _materials(self, net: CableNet) -> dict[str, Material]:
        materials: dict[str, Material] = {}
        for number, cord in enumerate(self.data.material):
            with self._section("material", number):
                net.cables_of(cord.cables)
                materials.pop(cord.cables, None)  # a later entry overrides all before it
                materials[cord.cables] = Material(**cord.model_dump(exclude={"cables"}))
        return materials

    def _damping(self) -> Damping:
        damping = self.data.damping
        with self._section("damping"):
            if isinstance(damping, schema.DashpotDamping):
                return Dashpot(viscosity_time=damping.viscosity_time, zeta=damping.zeta)
            if isinstance(damping, schema.RayleighDamping):
                return Rayleigh(alpha=damping.alpha, beta=damping.beta)
        return NoDamping()

    def _masses(self, net: CableNet) -> dict[str, float]:
        masses: dict[str, float] = {}
        for number, entry in enumerate(self.data.masses):
            with self._section("masses", number):
                net.nodes_of(entry.group)
            masses[entry.group] = masses.get(entry.group, 0.0) + entry.mass
        return masses

    def _restraints(self, net: CableNet) -> list[Restraint]:
        restraints = []
        for number, hold in enumerate(self.data.restraints):
            with self._section("restraints", number):
                net.nodes_of(hold.group)
                motion = Fixed() if isinstance(hold.motion, str) else self._motion(hold.motion)
                restraints.append(Restraint(hold.group, axes=hold.axes, motion=motion))
        return restraints

    def _motion(self, table: schema.MotionFile) -> Motion:
        columns = read_table(self._file(table.file), FORCE_HEADER, MOTION_HEADER)
        u = np.column_stack([columns[name] for name in MOTION_HEADER[1:4]])
        v = np.column_stack([columns[name] for name in MOTION_HEADER[4:]]) if "vx" in columns else None
        with _from_table(table.file):
            return TableMotion(columns["t"], u, v, interpolation=table.interpolation)

    def _loads(self, net: CableNet) -> list[Load]:
        loads: list[Load] = []
        for number, load in enumerate(self.data.loads):
            with self._section("loads", number):
                if isinstance(load, schema.UniformGravity):
                    loads.append(Gravity(self._signal(load.g, load)))
                else:
                    net.nodes_of(load.group)
                    loads.append(NodalLoad(load.group, self._signal(load.force, load)))
        return loads

    def _signal(
        self,
        value: tuple[float, float, float] | schema.TableFile,
        load: schema.NodalForce | schema.UniformGravity,
    ) -> Signal:
        limited = load.begin is not None or load.end is not None
        if isinstance(value, schema.TableFile):
            if limited:
                name = "end" if load.begin is None else "begin"
                raise InputError(
                    f"{name} does not go with a table: put zeros into the table where it does not act"
                )
            columns = read_table(self._file(value.file), FORCE_HEADER)
            with _from_table(value.file):
                values = np.column_stack([columns[name] for name in FORCE_HEADER[1:]])
                return Table(columns["t"], values, interpolation=value.interpolation)
        if not limited:
            return Constant(value)
        begin = self.data.solver.begin if load.begin is None else load.begin
        return Pulse(value, begin, np.inf if load.end is None else load.end)

    def _joined(self, v: FloatArray, net: CableNet, restraints: list[Restraint]) -> FloatArray:
        """Velocities (n, 3) in which driven axes that start at rest take the velocity of their table."""
        joined = v.copy()
        t = np.nextafter(self.data.solver.begin, np.inf)
        for restraint in restraints:
            if isinstance(restraint.motion, TableMotion):
                nodes = np.ix_(net.nodes_of(restraint.group), restraint.axis_indices)
                velocity = restraint.motion.at(t)[1][restraint.axis_indices]
                joined[nodes] = np.where(v[nodes] == 0, velocity, v[nodes])
        return joined

    def _metrics(self, system: System) -> DeploymentMetrics:
        chosen, net = self.data.metrics, system.net
        mouth = chosen.mouth or (
            "border" if "border" in {*net.node_groups, *net.cable_groups} else schema.NONE
        )
        corners = chosen.corners or ("corners" if "corners" in net.node_groups else schema.NONE)
        metrics = DeploymentMetrics(
            mouth=None if mouth == schema.NONE else mouth, corners=None if corners == schema.NONE else corners
        )
        with self._section("metrics"):
            if corners != schema.NONE:
                net.nodes_of(corners)
            metrics.begin(system)  # finds the loop, or says what is wrong with it
        return metrics


@contextmanager
def _from_table(name: str) -> Iterator[None]:
    try:
        yield
    except InputError as error:
        raise InputError(f"{name}: {_bare(error)}") from error


def _bare(error: InputError) -> str:
    """The message without the kind of thing in front, where section or file say it already."""
    return re.sub(r"^(material|dashpot|rayleigh|table|motion|pulse): ", "", str(error))


def read_scenario(path: str | os.PathLike[str]) -> Scenario:
    """Read a scenario file; raises ScenarioError, one line with file, section and key, for what is wrong in it."""
    source = Path(path)
    try:
        text = source.read_bytes()
    except OSError as error:
        raise ScenarioError(
            f"{source}: the scenario cannot be read: {reason_of(error)}: give the name of a TOML file"
        ) from error
    try:
        data = tomllib.loads(text.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        line = text[: error.start].count(b"\n") + 1
        raise ScenarioError(f"{source}: line {line} is not UTF-8 text: save the file as UTF-8") from error
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{source}: this is not TOML: {_with_line(str(error), text)}") from error
    except RecursionError as error:
        raise ScenarioError(
            f"{source}: this is not TOML that can be read: it is nested too deeply"
        ) from error
    try:
        return Scenario(source, text, schema.ScenarioData.model_validate(data))
    except ValidationError as error:
        raise ScenarioError(f"{source}: {first_problem(error, data)}") from error


def _with_line(reason: str, text: bytes) -> str:
    """The reason with line and column also where it is the end of the file."""
    lines = text.decode("utf-8", "replace").split("\n")
    end = f"(at line {len(lines)}, column {len(lines[-1]) + 1}, the end of the file)"
    return reason.replace("(at end of document)", end)
