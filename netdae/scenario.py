"""Scenario files: TOML, checked against the schema, and built into a simulation that is ready to fly."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from netdae import scenario_schema as schema
from netdae._arrays import FloatArray, IntArray
from netdae._files import reason_of
from netdae.damping import Damping, Dashpot, NoDamping, Rayleigh
from netdae.errors import InputError, ScenarioError
from netdae.forces.loads import Gravity, Load, NodalLoad
from netdae.initial import ejected, scaled
from netdae.material import Material
from netdae.mesh_io import describe
from netdae.metrics import DeploymentMetrics
from netdae.motions import Fixed, TableMotion
from netdae.net import CableNet
from netdae.options import SolverOptions
from netdae.restraints import Drive, Restraint, mask_of
from netdae.scenario_files import names_of, with_full_names
from netdae.scenario_nets import MeshFile
from netdae.scenario_problems import ARRAYS, bare, first_problem
from netdae.scenario_signals import SHORTEST, motion_of, signal_of
from netdae.simulation import Simulation
from netdae.state import State
from netdae.system import System


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

    @property
    def copy(self) -> bytes:
        """The text with the full names of its files: it flies from any folder."""
        return with_full_names(self.text, self.path.parent)

    @property
    def files(self) -> list[Path]:
        """The mesh and the tables that are read."""
        return [self._file(name) for name in names_of(tomllib.loads(self.text.decode("utf-8-sig")))]

    def build(self) -> Simulation:
        """Read meshes and tables, and make all ready; raises InputError for what cannot fly."""
        data, solver = self.data, self.data.solver
        with self._section("solver"):
            if solver.end <= solver.begin:
                raise InputError(f"end is {solver.end:g} s, expected a time after begin, {solver.begin:g} s")
            times = np.linspace(solver.begin, solver.end, data.output.frames)
            if solver.end - solver.begin < SHORTEST or not (np.diff(times) > 0).all():
                raise InputError(
                    f"the flight lasts {solver.end - solver.begin:g} s from {solver.begin:g} s on: "
                    f"give an end {SHORTEST:g} s after the begin at least, and fewer frames if there are many"
                )
        net, findings = self._net()
        turned, start = scaled(
            net, data.initial.scale, rotation_deg=data.initial.rotation_deg, velocity=data.initial.velocity
        )
        with self._section("initial"):
            if np.ptp(start.x, axis=0).max() <= 1e-9 * np.ptp(turned.nodes, axis=0).max():
                raise InputError(
                    f"scale is {[*data.initial.scale]}, which draws the whole net into one point: "
                    "give factors that leave it a width"
                )
        for number, shot in enumerate(data.initial.ejection):
            with self._section("initial.ejection", number):
                _check_group(turned.node_groups, shot.group, "node")
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
        start = State.at(start.x, self._joined(start.v, turned, restraints), t=solver.begin)
        for number, restraint in enumerate(restraints):
            with self._section("restraints", number):
                mask_of(tuple(restraints[: number + 1]), turned)
                Drive.of((restraint,), turned, start.x).check_start(start.t, start.v)
        with self._section():
            system = System(
                turned, materials, damping=self._damping(), masses=masses, loads=loads, restraints=restraints
            )
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
        return Simulation(self.title, system, start, times, options, self._metrics(system), findings)

    def _file(self, name: str) -> Path:
        return self.path.parent / name

    @contextmanager
    def _section(self, name: str = "", number: int | None = None, *, key: str = "") -> Iterator[None]:
        """Tell errors of the content by file, section and key."""
        title = f"[[{name}]]" if name in ARRAYS else f"[{name}]"
        place = [title, "" if number is None else str(number + 1), key]
        header = f"{' '.join(part for part in place if part)}: " if name else ""
        try:
            yield
        except ScenarioError:
            raise
        except InputError as error:
            raise ScenarioError(f"{self.path}: {header}{bare(error)}") from error

    def _net(self) -> tuple[CableNet, tuple[str, ...]]:
        net = self.data.net
        if isinstance(net, MeshFile):
            path = self._file(net.file)
            with self._section("net", key="file"):
                found = describe(path, surface_edges=net.surface_edges)
            return found.net, tuple(f"{path}: {finding}" for finding in found.findings)
        pattern = getattr(CableNet, net.kind)
        with self._section("net"):
            return pattern(**net.model_dump(exclude={"kind"})), ()

    def _materials(self, net: CableNet) -> dict[str, Material]:
        materials: dict[str, Material] = {}
        for number, cord in enumerate(self.data.material):
            with self._section("material", number):
                _check_group(net.cable_groups, cord.cables, "cable")
                materials.pop(cord.cables, None)  # a later entry overrides all before it
                materials[cord.cables] = Material(**cord.model_dump(exclude={"cables"}))
        with self._section("material"):
            made = np.isin(
                np.arange(net.cable_count), np.concatenate([net.cables_of(group) for group in materials])
            )
            if not made.all():
                groups = ", ".join(
                    name
                    for name, member in net.cable_groups.items()
                    if name != "all" and not made[member].all()
                )
                missing = f", or one for what is missing of {groups}" if groups else ""
                raise InputError(
                    f"{np.count_nonzero(~made)} of {net.cable_count} cables have no material: "
                    f'add an entry before the others with cables = "all"{missing}'
                )
        return materials

    def _damping(self) -> Damping:
        damping = self.data.damping
        with self._section("damping"):
            if isinstance(damping, schema.DashpotDamping):
                return Dashpot(viscosity_time=damping.viscosity_time, zeta=damping.zeta)
            if isinstance(damping, schema.RayleighDamping):
                if damping.alpha == damping.beta == 0:
                    raise InputError('nothing is damped: give alpha or beta above zero, or kind = "none"')
                return Rayleigh(alpha=damping.alpha, beta=damping.beta)
        return NoDamping()

    def _masses(self, net: CableNet) -> dict[str, float]:
        masses: dict[str, float] = {}
        for number, entry in enumerate(self.data.masses):
            with self._section("masses", number):
                _check_group(net.node_groups, entry.group, "node")
            masses[entry.group] = masses.get(entry.group, 0.0) + entry.mass
        return masses

    def _restraints(self, net: CableNet) -> list[Restraint]:
        restraints = []
        for number, hold in enumerate(self.data.restraints):
            with self._section("restraints", number):
                _check_group(net.node_groups, hold.group, "node")
                motion = (
                    Fixed()
                    if isinstance(hold.motion, str)
                    else motion_of(hold.motion, self.path.parent, self.data.solver)
                )
                restraints.append(Restraint(hold.group, axes=hold.axes, motion=motion))
        return restraints

    def _loads(self, net: CableNet) -> list[Load]:
        loads: list[Load] = []
        for number, load in enumerate(self.data.loads):
            with self._section("loads", number):
                if isinstance(load, schema.UniformGravity):
                    loads.append(Gravity(signal_of(load.g, load, self.path.parent, self.data.solver)))
                else:
                    _check_group(net.node_groups, load.group, "node")
                    loads.append(
                        NodalLoad(load.group, signal_of(load.force, load, self.path.parent, self.data.solver))
                    )
        return loads

    def _joined(self, v: FloatArray, net: CableNet, restraints: list[Restraint]) -> FloatArray:
        """Velocities (n, 3) in which driven axes that start at rest take the velocity of their table."""
        joined = v.copy()
        t = np.nextafter(self.data.solver.begin, np.inf)
        for restraint in restraints:
            if isinstance(restraint.motion, TableMotion):
                nodes = np.ix_(restraint.nodes_of(net), restraint.axis_indices)
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
            if mouth != schema.NONE:
                _check_group({**net.node_groups, **net.cable_groups}, mouth, "node")
            if corners != schema.NONE:
                _check_group(net.node_groups, corners, "node")
            metrics.begin(system)  # finds the loop, or says what is wrong with it
        return metrics


def _check_group(groups: Mapping[str, IntArray], name: str, kind: str) -> None:
    if name not in groups:
        near = get_close_matches(name, groups, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        raise InputError(f"there is no {kind} group {name!r}: {hint}The net has {', '.join(sorted(groups))}")


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
