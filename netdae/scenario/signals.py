"""Signals and motions of a scenario: its constant values, pulses and tables."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

import numpy as np

from netdae.errors import InputError
from netdae.motions import Motion, TableMotion
from netdae.scenario import schema
from netdae.scenario.environment import AirEntry
from netdae.scenario.problems import bare
from netdae.scenario.tables import MotionFile, TableFile
from netdae.signals import Constant, Pulse, Signal, Table
from netdae.tables import read_table

SHORTEST_FLIGHT = 1e-9
"""Shortest flight and shortest pulse, s: far below the time that a wave takes along any cable."""

FORCE_HEADER = ("t", "x", "y", "z")
MOTION_HEADER = (*FORCE_HEADER, "vx", "vy", "vz")

Source = TypeVar("Source", Table, TableMotion)


def motion_of(table: MotionFile, folder: Path, solver: schema.Solver) -> Motion:
    """Motion by a table in `folder`, which has to reach over the flight."""
    columns = read_table(folder / table.file, FORCE_HEADER, MOTION_HEADER)
    u = np.column_stack([columns[name] for name in MOTION_HEADER[1:4]])
    v = np.column_stack([columns[name] for name in MOTION_HEADER[4:]]) if "vx" in columns else None
    with _from_table(table.file):
        return _covering(TableMotion(columns["t"], u, v, interpolation=table.interpolation), solver)


def signal_of(
    value: tuple[float, float, float] | TableFile,
    load: schema.NodalForce | schema.UniformGravity | AirEntry,
    folder: Path,
    solver: schema.Solver,
) -> Signal:
    """Signal of a load: constant, a pulse, or a table in `folder`, which has to reach over the flight."""
    limited = load.begin is not None or load.end is not None
    if isinstance(value, TableFile):
        if limited:
            name = "end" if load.begin is None else "begin"
            raise InputError(
                f"{name} does not go with a table: put zeros into the table where it does not act"
            )
        columns = read_table(folder / value.file, FORCE_HEADER)
        with _from_table(value.file):
            values = np.column_stack([columns[name] for name in FORCE_HEADER[1:]])
            return _covering(Table(columns["t"], values, interpolation=value.interpolation), solver)
    if not limited:
        return Constant(value)
    begin = solver.begin if load.begin is None else load.begin
    end = np.inf if load.end is None else load.end
    if 0 < end - begin < SHORTEST_FLIGHT:
        raise InputError(
            f"it lasts {end - begin:g} s: let the end come {SHORTEST_FLIGHT:g} s after the begin at least"
        )
    return Pulse(value, begin, end)


def _covering(source: Source, solver: schema.Solver) -> Source:
    """The table, after a check that it reaches over the flight."""
    begin, end = solver.begin, solver.end
    if not source.covers(begin, end):
        raise InputError(
            f"the table reaches from {source.times[0]:g} to {source.times[-1]:g} s, but the flight lasts "
            f"from {begin:g} to {end:g} s: add rows and fly it afresh, or end the flight earlier"
        )
    return source


@contextmanager
def _from_table(name: str) -> Iterator[None]:
    try:
        yield
    except InputError as error:
        raise InputError(f"{name}: {bare(error)}") from error
