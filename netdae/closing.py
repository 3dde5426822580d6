"""What closes a net: winches that draw pairs of nodes together, and drawcords through rings along its mouth.

Symbols: L̄₀ rest length before, s length wound in, L̄ = L̄₀ − s; F force and v speed of a motor, J/R² inertia of its
drum. Each is a cord, one or more cables of the same net, on a reel of its own (`reels`) with a motor (`forces.motor`):
the drum is held until the closing begins, winds in at v as far as F goes, ends at a stop where L̄ is the final length,
and is held there by stop and pawl. The motor's work is external work.

How sharply a closing has to be flown. It takes long, l/v, and its knots move at some v/2π, slower than those of an
ejection. Each step adds an error of up to a_v, the absolute tolerance, to velocities; after N steps the errors, of
either sign, have come to a_v √N. N is 10³ to 10⁵ (cables chatter), so a_v ≤ 10⁻⁴ v leaves 0.3 to 3 % of v. Positions
take errors of a_v times a step of some ms: a_x = a_v · 10 ms. See `closing_tolerances`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from netdae._arrays import FloatArray
from netdae.errors import InputError
from netdae.forces.motor import Motor
from netdae.forces.rings import Rings
from netdae.material import Material

WIDTH = 0.1
"""Width v₀ of a motor's speed controller over its speed: at seven tenths of its force it is that much slower."""

CREEP = 0.01
"""Creep speed v₁ of a pawl over the motor's speed."""

SPIN_UP = 0.01
"""Time in s in which a motor gives its own drum its speed, where the drum's inertia is not told: J/R² = F t/v."""


@dataclass(frozen=True)
class Haul:
    """How a cord is wound in.

    speed : v, m/s; force : F, N, the most that the motor pulls with
    final_length : m, rest length at which it ends
    begin : s, or the name of an event, at which it begins; None for the start
    hold : s, or the name of an event, at which the drum is locked for good; None for pawl and stop alone
    drum_inertia : J/R², kg; None for what the motor gives its speed to in `SPIN_UP`

    Raises InputError for values out of range.
    """

    speed: float
    force: float
    final_length: float
    begin: float | str | None = None
    hold: float | str | None = None
    drum_inertia: float | None = None

    def __post_init__(self) -> None:
        for name, unit in (
            ("speed", " m/s"),
            ("force", " N"),
            ("final_length", " m"),
            ("drum_inertia", " kg"),
        ):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0):
                raise InputError(f"closing: {name} is {value:g}{unit}: give a finite number above zero")
        for name in ("begin", "hold"):
            value = getattr(self, name)
            if isinstance(value, float | int) and not math.isfinite(value):
                raise InputError(
                    f"closing: {name} is {value:g} s: give a finite time, or the name of an event"
                )
        begin, hold = self.begin, self.hold
        if isinstance(hold, float | int) and isinstance(begin, float | int) and not begin < hold:
            raise InputError(
                f"closing: it begins at {begin:g} s and is held from {hold:g} s on: hold it later"
            )

    @property
    def inertia(self) -> float:
        """J/R², kg."""
        return self.force * SPIN_UP / self.speed if self.drum_inertia is None else self.drum_inertia


@dataclass(frozen=True)
class Winch:
    """Winches that draw each node of one group to its partner of another one.

    first, second : node groups of one size, whose nodes are paired in the order of their numbers; or the nodes'
        numbers, paired in their own order
    length : L̄₀, m, of each cable; None for the distance in x̄
    """

    first: str | tuple[int, ...]
    second: str | tuple[int, ...]
    material: Material
    haul: Haul
    length: float | None = None

    def __post_init__(self) -> None:
        _check_length(self.length)


@dataclass(frozen=True)
class Drawcord:
    """One cord through rings at several nodes.

    group : node group through whose nodes it runs; or
    nodes : their numbers, in the order of the cord
    closed : True where it comes back to its first ring, in front of the drum
    length : L̄₀, m; None for its way in x̄
    rings : size and friction; both ends of a closed cord go into the drum unless `rings.fastened`

    With a group, the order is that of the closed loop of net cables through it, see `mouth`, from its smallest node;
    where not all nodes of that loop have rings, name the loop's group as `loop`.
    """

    material: Material
    haul: Haul
    group: str | None = None
    nodes: tuple[int, ...] | None = None
    loop: str | None = None
    closed: bool = True
    length: float | None = None
    rings: Rings = field(default_factory=Rings)

    def __post_init__(self) -> None:
        _check_length(self.length)
        if (self.group is None) == (self.nodes is None):
            raise InputError(
                "closing: give just one of a group and a list of nodes for the rings of a drawcord"
            )
        if self.loop is not None and self.nodes is not None:
            raise InputError("closing: a list of rings has its own order: leave the loop out")


Closing = Winch | Drawcord


class Tolerances(NamedTuple):
    """rtol, atol_position in m, atol_velocity in m/s."""

    rtol: float
    atol_position: float
    atol_velocity: float


def closing_tolerances(speed: float) -> Tolerances:
    """The coarsest tolerances at which a net that is closed at `speed` in m/s closes as it does at finer ones.

    Measured: a 5 m net with 11 × 11 knots, 3 % slack and at rest, a cord through the 40 of its border that is wound in
    from 20 m at 1 m/s by 50 N (drum 1 kg, v₀ = 0.02 v); area of the mouth in m² after 6, 8 and 10 s, and steps:

        1e-5, 1e-7 m, 1e-5 m/s   10.75  5.30  1.47   13 686
        1e-4, 1e-6 m, 1e-4 m/s   10.58  5.14  1.46    5 299   these; other starts 10.62 5.16 1.49, 10.71 5.25 1.52
        1e-3, 1e-6 m, 1e-4 m/s   10.90  5.32  1.47    5 094
        accurate                 10.69  5.16  1.48    5 796
        standard                 10.61  5.05  1.24    3 410
        1e-3, 1e-5 m, 1e-3 m/s   12.72  6.46  2.72    1 824
        fast                     10.15  7.46  4.75      184

    At 0.2 m/s, after 30, 40 and 50 s: 10.69 5.29 1.81 at these, 10.40 4.93 1.43 at a tenth of them, 12.64 9.38 6.19
    at 1e-3, a_v = 1e-3 v.
    With 6 × 6 knots at 4 m/s, after 1.5 and 2 s: a_v/v = 1e-6 11.93 5.42, 1e-5 11.92 5.41, these 11.97 5.67,
    1e-3 13.25 7.09, 1e-2 14.57 9.40.
    """
    if not (math.isfinite(speed) and speed > 0):
        raise InputError(f"closing: speed is {speed:g} m/s: give a finite number above zero")
    atol_velocity = 1e-4 * speed
    return Tolerances(1e-4, 1e-2 * atol_velocity, atol_velocity)


def tightened(tolerances: tuple[float, float, float], closings: Sequence[Closing]) -> Tolerances:
    """rtol, a_x in m and a_v in m/s, or those that the slowest of the closings needs, whichever are finer."""
    needs = [closing_tolerances(closing.haul.speed) for closing in closings]
    return Tolerances(*(min(values) for values in zip(tolerances, *needs, strict=True)))


def sharp_enough(in_force: tuple[float, float, float], closings: Sequence[Closing]) -> bool:
    """Whether tolerances, rtol, m and m/s, are as fine as all of the closings need."""
    return all(
        own <= need * (1 + 1e-9) for own, need in zip(in_force, tightened(in_force, closings), strict=True)
    )


def accuracy_told(in_force: tuple[float, float, float], closings: Sequence[Closing]) -> str | None:
    """The sentence with which a run says how its tolerances stand to its closings; None where there are none."""
    if not closings:
        return None
    speed = min(closing.haul.speed for closing in closings)
    told = "rtol {:g}, atol_position {:g} m, atol_velocity {:g} m/s"
    flown = f"closing at {speed:g} m/s is flown with {told.format(*in_force)}"
    if sharp_enough(in_force, closings):
        return f"{flown}, as it needs"
    needed = told.format(*closing_tolerances(speed))
    return f"{flown}, but it needs {needed}: the mouth may close by tens of percents too soon or too late"


def _check_length(length: float | None) -> None:
    if length is not None and not (math.isfinite(length) and length > 0):
        raise InputError(f"closing: length is {length:g} m: give a finite number above zero")


def motors_of(hauls: Sequence[Haul], drums: Sequence[int]) -> Motor:
    """The motors of drums at the nodes `drums`, one for each haul."""
    speed = np.array([haul.speed for haul in hauls], dtype=np.float64)
    strength: FloatArray = np.array([haul.force for haul in hauls], dtype=np.float64)
    return Motor(np.array(drums, dtype=np.int64)[:, None], strength, speed, WIDTH * speed, CREEP * speed)
