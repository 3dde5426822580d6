"""Scenario files: TOML, checked against the schema, and built into a simulation that is ready to fly."""

from __future__ import annotations

import os
import re
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path

from pydantic import ValidationError

from netdae.core.errors import ScenarioError
from netdae.core.files import no_file, reason_of, shown
from netdae.mesh.io import SUFFIXES
from netdae.scenario.build import Build
from netdae.scenario.files import names_of, with_full_names
from netdae.scenario.initial import spread_of
from netdae.scenario.problems import first_problem
from netdae.scenario.schema import ScenarioData
from netdae.scenario.simulation import Simulation


@dataclass(frozen=True, eq=False)
class Scenario:
    """A scenario file whose sections, keys and values are in order.

    path : the file, to which the names of other files are relative
    text : its bytes
    """

    path: Path
    text: bytes
    data: ScenarioData

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

    @property
    def has_spread(self) -> bool:
        """Whether errors of the ejection or of the target are drawn."""
        target = self.data.target
        of_target = target is not None and target.spread is not None and target.spread.draws
        return of_target or any(spread_of(shot.spread).draws for shot in self.data.initial.ejection)

    def scattered(self, member: int) -> Scenario:
        """The same scenario, with the errors of ejection and target as a member of an ensemble draws them."""
        initial = self.data.initial
        shots = [
            shot
            if shot.spread is None
            else shot.model_copy(update={"spread": shot.spread.model_copy(update={"member": member})})
            for shot in initial.ejection
        ]
        scattered = initial.model_copy(update={"ejection": shots})
        target = self.data.target
        if target is not None and target.spread is not None:
            spread = target.spread.model_copy(update={"member": member})
            target = target.model_copy(update={"spread": spread})
        return replace(self, data=self.data.model_copy(update={"initial": scattered, "target": target}))

    def build(self) -> Simulation:
        """Read meshes and tables, and make all ready; raises InputError for what cannot fly."""
        return Build(self.path, self.title, self.data).simulation()

    def _file(self, name: str) -> Path:
        return self.path.parent / name


def read_scenario(path: str | os.PathLike[str]) -> Scenario:
    """Read a scenario file; raises ScenarioError, one line with file, section and key, for what is wrong in it."""
    source = Path(path)
    if trouble := no_file(source):
        raise ScenarioError(f"{shown(source)}: the scenario cannot be read: {trouble}")
    try:
        text = source.read_bytes()
    except OSError as error:
        hint = "give the name of a TOML file"
        if source.is_dir():
            hint = f"give the TOML file itself; a run in this folder goes on by netdae run --resume {source}"
        raise ScenarioError(f"{source}: the scenario cannot be read: {reason_of(error)}: {hint}") from error
    if source.suffix.lower() in SUFFIXES:
        raise ScenarioError(
            f"{source}: this is a mesh file, not a scenario: give a TOML file whose section [net] has "
            f'file = "{source.name}"; netdae info {source} reports what is in the mesh'
        )
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
        return Scenario(source, text, ScenarioData.model_validate(data))
    except ValidationError as error:
        raise ScenarioError(f"{source}: {first_problem(error, data)}") from error


def _with_line(reason: str, text: bytes) -> str:
    """The reason with line and column also where it is the end of the file, and with what stands in the line."""
    lines = text.decode("utf-8", "replace").split("\n")
    end = f"(at line {len(lines)}, column {len(lines[-1]) + 1}, the end of the file)"
    found = re.search(r"\(at line (\d+), ", reason)
    if found is None:
        return reason.replace("(at end of document)", end)
    line = " ".join(lines[int(found[1]) - 1].split())
    return f"{reason}: look at {line!r}" if 0 < len(line) <= 80 else reason
