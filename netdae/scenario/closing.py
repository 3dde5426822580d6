"""The section [[closing]] of a scenario, winches and drawcords, the closings that it makes, and their accuracy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from netdae.core.errors import InputError
from netdae.forces.rings import Rings
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.scenario.groups import check_group
from netdae.scenario.material import CordMaterial, material_of
from netdae.scenario.problems import InSection, section_in_words
from netdae.scenario.section import Length, Section, Text, TimeOrEvent, kind_of
from netdae.scenario.solver import Solver
from netdae.solvers.options import SolverOptions
from netdae.system.closing import Closing, Drawcord, Haul, Winch, tightened
from netdae.system.closing_assembly import check_closing

CREEP = 0.01
"""Creep speed of the friction at rings over the speed at which the cord is wound in."""

ReelSpeed = Annotated[float, Field(gt=0, le=1e6)]  # m/s
MotorForce = Annotated[float, Field(gt=0, le=1e12)]  # N
Inertia = Annotated[float, Field(gt=0, le=1e9)]  # kg
FrictionCoefficient = Annotated[float, Field(ge=0, le=100)]
NodeNumber = Annotated[int, Field(ge=0)]


def _kind_of_rings(value: Any) -> str:
    return "<list>" if isinstance(value, list) else "<group>"


GroupOrList = Annotated[
    Annotated[Text, Tag("<group>")] | Annotated[list[NodeNumber], Tag("<list>")],
    Discriminator(_kind_of_rings),
]


class HaulEntry(Section):
    """How a motor winds a cord in."""

    speed: ReelSpeed = Field(description="Speed at which the motor winds in, m/s.")
    force: MotorForce = Field(description="The most that the motor pulls with, N.")
    final_length: Length = Field(description="Rest length at which it ends, m.")
    begin: TimeOrEvent | None = Field(
        None, description="Time in s, or name of an event, at which it begins; the start by default."
    )
    hold: TimeOrEvent | None = Field(
        None, description="Time in s, or name of an event, at which the drum is locked for good."
    )
    length: Length | None = Field(
        None, description="Rest length before, m; its way through the mesh by default."
    )
    drum_inertia: Inertia | None = Field(
        None, description="Moment of inertia of the drum over its radius squared, kg; force · 0.01 s / speed."
    )


class WinchEntry(CordMaterial, HaulEntry):
    """Winches that draw each node of a group to its partner in another."""

    kind: Literal["winch"] = Field(description="Kind of closing.")
    first: GroupOrList = Field(description="Node group at the one end, or node numbers in order.")
    second: GroupOrList = Field(
        description="As many nodes at the other end; groups are paired in the order of their node numbers."
    )


class DrawcordEntry(CordMaterial, HaulEntry):
    """One cord through rings at several nodes."""

    kind: Literal["drawcord"] = Field(description="Kind of closing.")
    rings: GroupOrList = Field(
        description="Node group, in the order in which a closed loop of cables passes it; or node numbers in order."
    )
    loop: Text | None = Field(
        None, description="Group of the loop that passes the rings; by default the group of the rings itself."
    )
    closed: bool = Field(True, description="Whether the cord comes back to its first ring.")
    fastened: bool | None = Field(
        None,
        description="Whether the cord's end is tied; by default an open one is, a closed one has both wound in.",
    )
    friction: FrictionCoefficient = Field(
        0.0, description="Coefficient of friction at the rings, by the capstan rule."
    )
    ring_size: Length = Field(1e-3, description="Least length of cord from one ring to the next, m.")


ClosingEntry = Annotated[
    Annotated[WinchEntry, Tag("winch")] | Annotated[DrawcordEntry, Tag("drawcord")], Discriminator(kind_of)
]


def closings_of(
    entries: Sequence[WinchEntry | DrawcordEntry],
    net: CableNet,
    begin: float,
    section: InSection,
    *,
    starting: str | None = None,
) -> list[Closing]:
    """The closings of the entries, as `closing_of` makes them; raises InputError through `section`.

    starting : name of the event whose action starts those without a begin of their own
    """
    closings = []
    for number, entry in enumerate(entries):
        with section("closing", number):
            if starting and entry.begin is None:
                entry = entry.model_copy(update={"begin": starting})
            closings.append(closing_of(entry, net, begin))
    return closings


def closing_of(entry: WinchEntry | DrawcordEntry, net: CableNet, begin: float) -> Closing:
    """The closing of an entry, for a net and a flight that begins at `begin` in s.

    Raises InputError for values that do not go together or that are not in the net.
    """
    material = material_of(entry)
    haul = Haul(**entry.model_dump(include={*HaulEntry.model_fields} - {"length"}))
    closing: Closing
    if isinstance(entry, WinchEntry):
        closing = Winch(_ends_of(entry.first, net), _ends_of(entry.second, net), material, haul, entry.length)
    else:
        closing = _drawcord_of(entry, net, material, haul)
    check_closing(net, closing, begin)
    return closing


def _ends_of(given: str | list[int], net: CableNet) -> str | tuple[int, ...]:
    if not isinstance(given, str):
        return tuple(given)
    check_group(net.node_groups, given, "node")
    return given


def _drawcord_of(entry: DrawcordEntry, net: CableNet, material: Material, haul: Haul) -> Drawcord:
    if isinstance(entry.rings, str):
        check_group(net.node_groups, entry.rings, "node")
    fastened = not entry.closed if entry.fastened is None else entry.fastened
    if not fastened and not entry.closed:
        raise InputError("fastened is false: the free end of an open cord would slip out: let it be true")
    return Drawcord(
        material,
        haul,
        group=entry.rings if isinstance(entry.rings, str) else None,
        nodes=None if isinstance(entry.rings, str) else tuple(entry.rings),
        loop=entry.loop,
        closed=entry.closed,
        length=entry.length,
        rings=Rings(entry.ring_size, entry.friction, CREEP * entry.speed, fastened),
    )


def overpowered(closings: Sequence[Closing]) -> tuple[str, ...]:
    """A note on each of the closings, in the scenario's order, whose motor can break its cord."""
    return tuple(
        f"{section_in_words('closing', number)}: force is {closing.haul.force:g} N, more than the cord's strength, "
        f"{closing.material.strength:g} N: the motor can break it; give less force, or a stronger cord"
        for number, closing in enumerate(closings)
        if closing.material.strength is not None and closing.haul.force > closing.material.strength
    )


def closing_options(options: SolverOptions, solver: Solver, closings: Sequence[Closing]) -> SolverOptions:
    """The options with tolerances as fine as the closings need, but for those that the scenario gives itself."""
    if not closings or not options.in_force:
        return options
    rtol, position, velocity = tightened(options.tolerances, closings)
    return replace(
        options,
        rtol=rtol if solver.rtol is None else options.rtol,
        atol_position=position if solver.atol_position is None else options.atol_position,
        atol_velocity=velocity if solver.atol_velocity is None else options.atol_velocity,
    )
