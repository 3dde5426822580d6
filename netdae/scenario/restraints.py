"""The section [[restraints]] of a scenario, and what restrains a net: these, held bullets, and drums."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Discriminator, Field, Tag

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.initial.ejection import Launch
from netdae.model.motions import Fixed, Motion, Steady, TableMotion
from netdae.model.net import CableNet
from netdae.model.restraints import Drive, Restraint, mask_of
from netdae.model.state import State
from netdae.scenario.groups import check_nodes
from netdae.scenario.problems import InSection, section_in_words
from netdae.scenario.section import Section, Text, TimeOrEvent
from netdae.scenario.signals import MotionFile, kind_of_value, motion_of
from netdae.scenario.solver import Solver

FixedOrTable = Annotated[
    Annotated[Literal["fixed"], Tag("<value>")] | Annotated[MotionFile, Tag("<table>")],
    Discriminator(kind_of_value),
]


class Hold(Section):
    """Axes of a node group that are fixed, or driven along a table."""

    group: Text = Field(description="Node group.")
    axes: Text = Field("xyz", description="Which of x, y and z are held, for instance xyz.")
    motion: FixedOrTable = Field(
        "fixed", description='"fixed", or a table of displacements from the start, m.'
    )
    begin: TimeOrEvent | None = Field(
        None, description="Time in s, or name of an event, at which it begins; the start by default."
    )
    until: TimeOrEvent | None = Field(
        None, description="Time in s, or name of an event, at which it ends; never by default."
    )


class Given(NamedTuple):
    """A restraint, and the section, and the number in it, that it comes from."""

    restraint: Restraint
    section: str
    number: int | None = None

    @property
    def times(self) -> tuple[tuple[str, float], ...]:
        """Times in s at which it begins or ends, as far as they are known, each by the key that reports it.

        A drum is held until it begins to turn, and held for good from its lock on; a table that drives it ends there.
        """
        restraint = self.restraint
        begin, until = "begin", "until"
        if self.section in DRUM_KEYS:
            let_go, locked = DRUM_KEYS[self.section]
            begin, until = locked, let_go if isinstance(restraint.motion, Fixed) else locked
        given = ((begin, restraint.begin), (until, restraint.until))
        return tuple((key, t) for key, t in given if not isinstance(t, str) and math.isfinite(t))

    def says(self, key: str, t: float) -> str:
        """That it begins or ends at t, s, in the words of the scenario."""
        if self.section == "initial" and not isinstance(self.restraint.group, str):
            return f"the bullet at node {self.restraint.group[0]} is let go at {t:g} s"
        return f"{key} is {t:g} s"


DRUM_KEYS = {"tether": ("begin", "lock"), "closing": ("begin", "hold")}
"""Keys of the sections with drums at which a drum is let go, and at which it is held for good."""


def given_in(section: str, restraints: Iterable[Restraint]) -> list[Given]:
    """Restraints that a section brings."""
    return [Given(restraint, section) for restraint in restraints]


def restraints_of(
    entries: Sequence[Hold],
    net: CableNet,
    folder: Path,
    solver: Solver,
    section: InSection,
    *,
    alone: bool,
) -> list[Given]:
    """The restraints of the entries; raises InputError, through `section`, for groups and tables that cannot be.

    folder : of the scenario file, to which tables are relative
    alone : see `check_nodes`
    """
    given = []
    for number, entry in enumerate(entries):
        with section("restraints", number):
            check_nodes(net, entry.group, alone=alone)
            given.append(Given(_restraint_of(entry, folder, solver), "restraints", number))
    return given


def _restraint_of(hold: Hold, folder: Path, solver: Solver) -> Restraint:
    motion: Motion = Fixed()
    if not isinstance(hold.motion, str):
        motion = motion_of(hold.motion, folder, solver)
    begin = -math.inf if hold.begin is None else hold.begin
    until = math.inf if hold.until is None else hold.until
    return Restraint(hold.group, axes=hold.axes, motion=motion, begin=begin, until=until)


def held_bullets_of(launch: Launch, velocity: tuple[float, float, float], begin: float) -> list[Restraint]:
    """Bullets that the canister, which moves with the velocity (3,) of the whole net, holds until their time."""
    motion: Motion = Steady(velocity, begin) if any(velocity) else Fixed()
    held = launch.held
    return [
        Restraint((int(node),), motion=motion, until=begin + float(t), release_velocity=tuple(v.tolist()))
        for node, t, v in zip(held.nodes, held.times, held.velocities, strict=True)
    ]


def joined_velocities(
    v: FloatArray, net: CableNet, restraints: Iterable[Restraint], begin: float
) -> FloatArray:
    """Velocities (n, 3) in which driven axes that start at rest take the velocity of their table."""
    joined, t = v.copy(), np.nextafter(begin, np.inf)
    for restraint in restraints:
        if isinstance(restraint.motion, TableMotion) and restraint.holds(t, {}):
            nodes = np.ix_(restraint.nodes_of(net), restraint.axis_indices)
            velocity = restraint.motion.at(t)[1][restraint.axis_indices]
            joined[nodes] = np.where(v[nodes] == 0, velocity, v[nodes])
    return joined


def late_findings(given: Sequence[Given], begin: float, end: float, section: InSection) -> tuple[str, ...]:
    """Warnings of what begins or ends after the flight, by its section; raises InputError for times before it."""
    late = []
    for each in given:
        for key, t in each.times:
            with section(each.section, each.number):
                if t < begin:
                    raise InputError(
                        f"{each.says(key, t)}, before the flight begins at {begin:g} s: give a time of the flight's "
                        "own clock"
                    )
            if t >= end:
                place = section_in_words(each.section, each.number)
                late.append(f"{place}: {each.says(key, t)}, after the end of the flight at {end:g} s")
    # the winches of a section, and the end and the lock of a driven reel, say the same
    return tuple(dict.fromkeys(late))


def check_restraints(given: Sequence[Given], net: CableNet, start: State, section: InSection) -> None:
    """Raise InputError for what contradicts the start, or itself, by the section that it is in."""
    after = np.nextafter(start.t, math.inf)
    holding: list[Restraint] = []
    for restraint, *place in given:
        with section(*place):
            if restraint.holds(after, {}):
                holding.append(restraint)
                mask_of(tuple(holding), net)
                Drive.of((restraint,), net, start.x).check_start(start.t, start.v)
