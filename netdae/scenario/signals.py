"""Values of a scenario that are given by numbers or by a table, and the signals and motions that they make."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import Discriminator, Field, Tag

from netdae.core.errors import InputError
from netdae.model.motions import Motion, TableMotion
from netdae.model.signals import Constant, Pulse, Signal, Table
from netdae.scenario.problems import bare
from netdae.scenario.section import ForceVector, Section, Text, Vector
from netdae.scenario.solver import SHORTEST_FLIGHT, Solver
from netdae.scenario.table_files import read_table

FORCE_HEADER = ("t", "x", "y", "z")
MOTION_HEADER = (*FORCE_HEADER, "vx", "vy", "vz")


class TableFile(Section):
    """A CSV table with the header t,x,y,z; times in s, rising."""

    file: Text = Field(description="CSV file with the header t,x,y,z.")
    interpolation: Literal["linear", "cubic"] = Field("linear", description="Curve through the rows.")


class MotionFile(Section):
    """A CSV table with the header t,x,y,z or t,x,y,z,vx,vy,vz: displacements in m from where the nodes start."""

    file: Text = Field(description="CSV file with the header t,x,y,z or t,x,y,z,vx,vy,vz.")
    interpolation: Literal["linear", "cubic"] = Field("cubic", description="Curve through the rows.")


def kind_of_value(value: Any) -> str:
    """Tag by which pydantic chooses between a table and a value, "<table>" or "<value>"."""
    return "<table>" if isinstance(value, dict) else "<value>"


Vector3OrTable = Annotated[
    Annotated[Vector, Tag("<value>")] | Annotated[TableFile, Tag("<table>")], Discriminator(kind_of_value)
]
ForceOrTable = Annotated[
    Annotated[ForceVector, Tag("<value>")] | Annotated[TableFile, Tag("<table>")],
    Discriminator(kind_of_value),
]

Source = TypeVar("Source", Table, TableMotion)


def motion_of(table: MotionFile, folder: Path, solver: Solver) -> Motion:
    """Motion by a table in `folder`, which has to reach over the flight."""
    columns = read_table(folder / table.file, FORCE_HEADER, MOTION_HEADER)
    u = np.column_stack([columns[name] for name in MOTION_HEADER[1:4]])
    v = np.column_stack([columns[name] for name in MOTION_HEADER[4:]]) if "vx" in columns else None
    with from_table(table.file):
        return covering(TableMotion(columns["t"], u, v, interpolation=table.interpolation), solver)


def signal_of(
    value: tuple[float, float, float] | TableFile,
    folder: Path,
    solver: Solver,
    *,
    begin: float | None,
    end: float | None,
) -> Signal:
    """Signal of a load: constant, a pulse, or a table in `folder`, which has to reach over the flight.

    begin, end : s, of a pulse; None where they are not given
    """
    limited = begin is not None or end is not None
    if isinstance(value, TableFile):
        if limited:
            name = "end" if begin is None else "begin"
            raise InputError(
                f"{name} does not go with a table: put zeros into the table where it does not act"
            )
        columns = read_table(folder / value.file, FORCE_HEADER)
        with from_table(value.file):
            values = np.column_stack([columns[name] for name in FORCE_HEADER[1:]])
            return covering(Table(columns["t"], values, interpolation=value.interpolation), solver)
    if not limited:
        return Constant(value)
    begin = solver.begin if begin is None else begin
    end = np.inf if end is None else end
    if 0 < end - begin < SHORTEST_FLIGHT:
        raise InputError(
            f"it lasts {end - begin:g} s: let the end come {SHORTEST_FLIGHT:g} s after the begin at least"
        )
    return Pulse(value, begin, end)


def covering(source: Source, solver: Solver) -> Source:
    """The table, after a check that it reaches over the flight."""
    begin, end = solver.begin, solver.end
    if not source.covers(begin, end):
        raise InputError(
            f"the table reaches from {source.times[0]:g} to {source.times[-1]:g} s, but the flight lasts "
            f"from {begin:g} to {end:g} s: add rows and fly it afresh, or end the flight earlier"
        )
    return source


@contextmanager
def from_table(name: str) -> Iterator[None]:
    """Tell errors by the name of the file that a table comes from."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{name}: {bare(error)}") from error
