"""The closings that the sections [[closing]] of a scenario make, and the accuracy that their flight gets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from netdae.closed import check_closing
from netdae.closing import Closing, Drawcord, Haul, Winch, tightened
from netdae.errors import InputError
from netdae.forces.rings import Rings
from netdae.material import Material
from netdae.net import CableNet
from netdae.options import SolverOptions
from netdae.scenario import schema
from netdae.scenario.closing import DrawcordEntry, WinchEntry
from netdae.scenario.groups import check_group
from netdae.scenario.problems import section_in_words

_HAUL = {"speed", "force", "final_length", "begin", "hold", "drum_inertia"}

CREEP = 0.01
"""Creep speed of the friction at rings over the speed at which the cord is wound in."""


def closing_of(entry: WinchEntry | DrawcordEntry, net: CableNet, begin: float) -> Closing:
    """The closing of an entry, for a net and a flight that begins at `begin` in s.

    Raises InputError for values that do not go together or that are not in the net.
    """
    material, haul = (
        Material(**entry.model_dump(include=schema.CORD_KEYS)),
        Haul(**entry.model_dump(include=_HAUL)),
    )
    closing: Closing
    if isinstance(entry, WinchEntry):
        closing = Winch(_ends_of(entry.first, net), _ends_of(entry.second, net), material, haul, entry.length)
    else:
        closing = _drawcord_of(entry, net, material, haul)
    check_closing(net, closing, begin)
    return closing


def _ends_of(told: str | list[int], net: CableNet) -> str | tuple[int, ...]:
    if not isinstance(told, str):
        return tuple(told)
    check_group(net.node_groups, told, "node")
    return told


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


def closing_options(
    options: SolverOptions, solver: schema.Solver, closings: Sequence[Closing]
) -> SolverOptions:
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
