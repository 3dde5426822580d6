"""The section [tether] of a scenario, the cord to the chaser and its reel, and the tether that it makes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag

from netdae.core.errors import InputError
from netdae.model.motions import Fixed, Motion, TableMotion
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.model.tether import Chaser, Tether
from netdae.scenario.material import CordMaterial, material_of
from netdae.scenario.problems import InSection
from netdae.scenario.section import Count, Length, NodeMass, Section, Text, TimeOrEvent, Vector
from netdae.scenario.signals import MotionFile, covering, from_table, kind_of_value, motion_of
from netdae.scenario.solver import Solver
from netdae.scenario.table_files import read_table
from netdae.system.tether_assembly import Tethered, with_tether

PAYOUT_HEADER = ("t", "paid_out")
RATE_HEADER = (*PAYOUT_HEADER, "rate")

Slack = Annotated[float, Field(ge=0, le=1e3)]
BrakeForce = Annotated[float, Field(ge=0, le=1e12)]  # N


class PayoutFile(Section):
    """A CSV table with the header t,paid_out or t,paid_out,rate: the length paid out in m, zero at the start."""

    file: Text = Field(description="CSV file with the header t,paid_out or t,paid_out,rate.")
    interpolation: Literal["linear", "cubic"] = Field("cubic", description="Curve through the rows.")


FreeFixedOrTable = Annotated[
    Annotated[Literal["free", "fixed"], Tag("<value>")] | Annotated[MotionFile, Tag("<table>")],
    Discriminator(kind_of_value),
]
PayoutOrTable = Annotated[
    Annotated[Literal["locked", "free", "braked"], Tag("<value>")] | Annotated[PayoutFile, Tag("<table>")],
    Discriminator(kind_of_value),
]


class ChaserEntry(Section):
    """The spacecraft, or the stand, at the other end of the tether."""

    position: Vector = Field(description="Place at the start, m; rotation_deg does not turn it.")
    velocity: Vector = Field((0.0, 0.0, 0.0), description="Velocity at the start of a free chaser, m/s.")
    mass: NodeMass = Field(0.0, description="Mass, kg; a free chaser needs one.")
    motion: FreeFixedOrTable = Field(
        "free", description='"free", "fixed", or a table of displacements from the start, m.'
    )


class TetherCourse(Section):
    """From where to where a tether goes, and how long it is."""

    group: Text = Field(description="Node group of the net that it is tied to.")
    chaser: ChaserEntry = Field(description="What it ends at.")
    elements: Count = Field(description="Cables that it is cut into.")
    length: Length | None = Field(None, description="Rest length at the start, m; or give slack.")
    slack: Slack | None = Field(
        None, description="Share by which the rest length exceeds the way at the start."
    )
    bridle: Length | None = Field(
        None, description="Rest length of the leg to each node of a group of several, m."
    )


class TetherEntry(CordMaterial, TetherCourse):
    """A cord from a node, or by a bridle from several nodes, of the net to its chaser."""

    payout: PayoutOrTable = Field(
        "locked", description='"locked", "free", "braked", or a table of the length paid out, m.'
    )
    brake_force: BrakeForce = Field(0.0, description="Dry friction of the reel, N, where it is braked.")
    ratchet: bool = Field(False, description="Whether a braked reel lets nothing wind back.")
    drum_inertia: NodeMass = Field(
        0.0, description="Moment of inertia of the drum over its radius squared, kg."
    )
    longest: Length | None = Field(None, description="Rest length at which the drum is empty, m.")
    begin: TimeOrEvent | None = Field(
        None, description="Time in s, or name of an event, at which the reel is let go; the start by default."
    )
    lock: TimeOrEvent | None = Field(
        None, description="Time in s, or name of an event, at which the reel is locked."
    )


def net_with_tether(
    entry: TetherEntry | None,
    net: CableNet,
    start: State,
    folder: Path,
    solver: Solver,
    section: InSection,
    *,
    locking: str | None = None,
) -> Tethered:
    """The net with its tether, as it is where it has none; raises InputError, through `section`.

    locking : name of the event whose action locks the tether
    """
    if entry is None:
        return Tethered.without(net, start)
    if locking and entry.lock is not None:
        with section("tether", key="lock"):
            raise InputError(f"the event {locking!r} locks the tether too: let one of them do it")
    with section("tether"):
        tether = tether_of(entry, folder, solver)
        return with_tether(net, start, replace(tether, lock=locking) if locking else tether)


def tether_of(entry: TetherEntry, folder: Path, solver: Solver) -> Tether:
    """The tether of an entry, whose tables lie in `folder` and have to reach over the flight.

    Raises InputError for values that do not go together.
    """
    payout = entry.payout
    return Tether(
        entry.group,
        elements=entry.elements,
        material=material_of(entry),
        chaser=_chaser_of(entry.chaser, folder, solver),
        length=entry.length,
        slack=entry.slack,
        bridle=entry.bridle,
        payout=payout if isinstance(payout, str) else _paid_out_of(payout, folder, solver),
        brake_force=entry.brake_force,
        ratchet=entry.ratchet,
        drum_inertia=entry.drum_inertia,
        longest=entry.longest,
        lock=entry.lock,
        begin=entry.begin,
    )


def _chaser_of(entry: ChaserEntry, folder: Path, solver: Solver) -> Chaser:
    motion: Motion | None
    if isinstance(entry.motion, str):
        motion = None if entry.motion == "free" else Fixed()
    else:
        motion = motion_of(entry.motion, folder, solver)
    return Chaser(entry.position, velocity=entry.velocity, mass=entry.mass, motion=motion)


def _paid_out_of(table: PayoutFile, folder: Path, solver: Solver) -> TableMotion:
    """Motion along x by a table of the length paid out, which begins at zero and reaches over the flight."""
    columns = read_table(folder / table.file, PAYOUT_HEADER, RATE_HEADER)
    s, rate = (
        None if name not in columns else np.outer(columns[name], [1.0, 0.0, 0.0]) for name in RATE_HEADER[1:]
    )
    assert s is not None
    with from_table(table.file):
        motion = covering(TableMotion(columns["t"], s, rate, interpolation=table.interpolation), solver)
        paid = float(motion.at(solver.begin)[0][0])
        if abs(paid) > 1e-12 * max(1.0, float(np.abs(s).max())):
            raise InputError(
                f"{paid:g} m are paid out at the start, t = {solver.begin:g} s: let paid_out begin at zero"
            )
    return motion
