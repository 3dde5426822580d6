"""Restraints that a scenario makes: of its [[restraints]], of held bullets, and what the start must agree with."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import NamedTuple

import numpy as np

from netdae._arrays import FloatArray
from netdae.ejection import Launch
from netdae.errors import InputError
from netdae.motions import Fixed, Motion, Steady, TableMotion
from netdae.net import CableNet
from netdae.restraints import Drive, Restraint, mask_of
from netdae.scenario import schema
from netdae.scenario.problems import section_in_words
from netdae.scenario.signals import motion_of
from netdae.state import State

InSection = Callable[..., AbstractContextManager[None]]
"""Called with a section's name, and number, it tells errors by them."""


class Told(NamedTuple):
    """A restraint, and the section, and the number in it, that it comes from."""

    restraint: Restraint
    section: str
    number: int | None = None

    @property
    def times(self) -> tuple[tuple[str, float], ...]:
        """Times in s at which it begins or ends, as far as they are known, each by the key that tells it.

        A drum is held until it begins to turn, and held for good from its lock on; a table that drives it ends there.
        """
        restraint = self.restraint
        begin, until = "begin", "until"
        if self.section in DRUM_KEYS:
            let_go, locked = DRUM_KEYS[self.section]
            begin, until = locked, let_go if isinstance(restraint.motion, Fixed) else locked
        told = ((begin, restraint.begin), (until, restraint.until))
        return tuple((key, t) for key, t in told if not isinstance(t, str) and math.isfinite(t))

    def says(self, key: str, t: float) -> str:
        """That it begins or ends at t, s, in the words of the scenario."""
        if self.section == "initial" and not isinstance(self.restraint.group, str):
            return f"the bullet at node {self.restraint.group[0]} is let go at {t:g} s"
        return f"{key} is {t:g} s"


DRUM_KEYS = {"tether": ("begin", "lock"), "closing": ("begin", "hold")}
"""Keys of the sections with drums at which a drum is let go, and at which it is held for good."""


def told_in(section: str, restraints: Iterable[Restraint]) -> list[Told]:
    """Restraints that a section brings."""
    return [Told(restraint, section) for restraint in restraints]


def restraint_of(hold: schema.Hold, folder: Path, solver: schema.Solver) -> Restraint:
    """The restraint of an entry of [[restraints]]; raises InputError for a table that cannot be.

    folder : of the scenario file, to which tables are relative
    """
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


def late_findings(told: Sequence[Told], begin: float, end: float, section: InSection) -> tuple[str, ...]:
    """Warnings of what begins or ends after the flight, by its section; raises InputError for times before it."""
    late = []
    for each in told:
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


def check_restraints(told: Sequence[Told], net: CableNet, start: State, section: InSection) -> None:
    """Raise InputError for what contradicts the start, or itself, by the section that it is in."""
    after = np.nextafter(start.t, math.inf)
    holding: list[Restraint] = []
    for restraint, *place in told:
        with section(*place):
            if restraint.holds(after, {}):
                holding.append(restraint)
                mask_of(tuple(holding), net)
                Drive.of((restraint,), net, start.x).check_start(start.t, start.v)
