"""The tether that the section [tether] of a scenario makes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from netdae.errors import InputError
from netdae.material import Material
from netdae.motions import Fixed, Motion, TableMotion
from netdae.scenario import schema
from netdae.scenario.problems import bare
from netdae.scenario.signals import motion_of
from netdae.scenario.tether import ChaserEntry, PayoutFile, TetherEntry
from netdae.tables import read_table
from netdae.tether import Chaser, Tether

PAYOUT_HEADER = ("t", "paid_out")
RATE_HEADER = (*PAYOUT_HEADER, "rate")


def tether_of(entry: TetherEntry, folder: Path, solver: schema.Solver) -> Tether:
    """The tether of an entry, whose tables lie in `folder` and have to reach over the flight.

    Raises InputError for values that do not go together.
    """
    payout = entry.payout
    return Tether(
        entry.group,
        elements=entry.elements,
        material=Material(**entry.model_dump(include=schema.CORD_KEYS)),
        chaser=_chaser_of(entry.chaser, folder, solver),
        length=entry.length,
        slack=entry.slack,
        bridle=entry.bridle,
        payout=payout if isinstance(payout, str) else paid_out_of(payout, folder, solver),
        brake_force=entry.brake_force,
        ratchet=entry.ratchet,
        drum_inertia=entry.drum_inertia,
        longest=entry.longest,
        lock=entry.lock,
        begin=entry.begin,
    )


def _chaser_of(entry: ChaserEntry, folder: Path, solver: schema.Solver) -> Chaser:
    motion: Motion | None
    if isinstance(entry.motion, str):
        motion = None if entry.motion == "free" else Fixed()
    else:
        motion = motion_of(entry.motion, folder, solver)
    return Chaser(entry.position, velocity=entry.velocity, mass=entry.mass, motion=motion)


def paid_out_of(table: PayoutFile, folder: Path, solver: schema.Solver) -> TableMotion:
    """Motion along x by a table of the length paid out, which begins at zero and reaches over the flight."""
    columns = read_table(folder / table.file, PAYOUT_HEADER, RATE_HEADER)
    s, rate = (
        None if name not in columns else np.outer(columns[name], [1.0, 0.0, 0.0]) for name in RATE_HEADER[1:]
    )
    assert s is not None
    try:
        motion = TableMotion(columns["t"], s, rate, interpolation=table.interpolation)
    except InputError as error:
        raise InputError(f"{table.file}: {bare(error)}") from error
    if not motion.covers(solver.begin, solver.end):
        first, last = motion.times[0], motion.times[-1]
        raise InputError(
            f"{table.file}: the table reaches from {first:g} to {last:g} s, but the flight lasts from "
            f"{solver.begin:g} to {solver.end:g} s: add rows and fly it afresh, or end the flight earlier"
        )
    paid = float(motion.at(solver.begin)[0][0])
    if abs(paid) > 1e-12 * max(1.0, float(np.abs(s).max())):
        raise InputError(
            f"{table.file}: {paid:g} m are paid out at the start, t = {solver.begin:g} s: let paid_out begin at zero"
        )
    return motion
