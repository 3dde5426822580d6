"""Closing of a net: winches that draw pairs of nodes together, and drawcords through rings along its mouth.

Symbols: L̄₀ rest length before, s length wound in, L̄ = L̄₀ − s; F force and v speed of a motor, J/R² inertia of its drum.
Each is a cord, one or more cables of the same net, on a reel of its own (`reels`) with a motor (`forces.motor`): the
drum is held until the closing begins, winds in at v as long as F suffices, ends at a stop where L̄ is the final length,
and is held there by stop and pawl. The motor's work is external work.

How fine the tolerances of a closing must be. Bullets and corners, which have most of the mass, are moved by jerks: a
cord goes taut at some u ≈ v and pushes them off again. They are a few of the many unknowns over which IDA's error
norm is the mean, so their errors may be several times the tolerance; and BDF damps a jerk, so the errors of its N
steps have one sign: up to a_v N, not a_v √N. N is 10² to 10³, and a_v = 10⁻⁵ v keeps the error to 1 % of v. Positions
get errors of a_v times a step of some ms: a_x = a_v · 10 ms. In the orbit's frame they come to metres: rtol = 10⁻⁵
keeps them to less than the stretch of a cord. The relevant speed is that of winding in, for winches between massive
nodes as well as for cords along the mouth: see `closing_tolerances`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.forces.elements import ElementForce
from netdae.forces.motor import MOTOR, Motor
from netdae.forces.rings import Rings
from netdae.model.material import Material

WIDTH = 0.1
"""Width v₀ of a motor's speed controller over its speed: at seven tenths of its force it is that much slower."""

CREEP = 0.01
"""Creep speed v₁ of a pawl over the motor's speed."""

SHARE = 1e-5
"""rtol of a closing, and its absolute tolerance of velocities relative to the speed of winding in."""

SPIN_UP = 0.01
"""Time in s in which a motor brings its own drum to speed, where the drum's inertia is not given: J/R² = F t/v."""


@dataclass(frozen=True)
class Haul:
    """How a cord is wound in.

    speed : v, m/s; force : F, N, the largest pull of the motor
    final_length : m, rest length at which it ends
    begin : s, or the name of an event, at which it begins; None for the start
    hold : s, or the name of an event, at which the drum is locked for good; None for pawl and stop alone
    drum_inertia : J/R², kg; None for what the motor brings to speed in `SPIN_UP`

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
    length : L̄₀, m; None for its path length in x̄
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
    what: ClassVar[str] = "closing"

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
    """Tolerances at which a net closed at `speed` in m/s agrees with finer ones to 1 % of its initial area.

    Measured: areas in m² and, in percent, the share of the motors' work that is not accounted for; f is the factor on
    all three tolerances, below it the explicit method at accuracy "accurate".

    Four winches of 10 N along the sides of a 3 m net, bullets of 0.2 kg, at rest, 3 % slack; the loop through the
    corners after 0.5 and 0.8 of the time T to the final length, the share at 1.6 T, after several jerks:

                  7 × 7, 1 m/s          7 × 7, 0.3 m/s        7 × 7, 3 m/s          21 × 21, 1 m/s
        f = 10    0.700 0.268 −1.2      0.467 0.563 −1.6      2.874 0.743 −3.5      0.729 0.218 −4.1
        these     0.707 0.261 −0.1      0.476 0.548 −0.3      2.866 0.735 −0.1      0.718 0.228 −0.9
        f = 0.1   0.707 0.261 −0.0      0.476 0.548 −0.0      2.867 0.736 −0.0      0.722 0.225 −0.1
        explicit  0.707 0.261 −0.0      0.476 0.548 −0.0      2.868 0.737 −0.0      0.722 0.224 −0.0

    A drawcord of `scripts/closing_convergence.py`, from 20 m to 0.5 m at 5 m/s; the mouth when a quarter, a half and
    three quarters are wound in, the share at the end, steps:

                  6 × 6, all 20 knots of the border           11 × 11, all 40
        f = 10    16.745  7.449  1.354  −8.5    8 903         16.588  7.603  1.262  −12.0  15 872
        these     16.754  7.260  1.118  −0.1   18 468         16.533  7.612  1.423   −1.6  47 144
        f = 0.1   16.750  7.224  1.150  −0.1   31 087         16.533  7.619  1.515   −0.1  92 335

    For a slower closing a preset is silently wrong: 11 × 11 knots, a cord wound in from 20 m at 1 m/s by 50 N
    (drum 1 kg, v₀ = 0.02 v), the mouth after 6, 8 and 10 s: 10.75 5.30 1.47 by these, 10.61 5.05 1.24 by standard,
    10.15 7.46 4.75 by fast.
    """
    if not (math.isfinite(speed) and speed > 0):
        raise InputError(f"closing: speed is {speed:g} m/s: give a finite number above zero")
    atol_velocity = SHARE * speed
    return Tolerances(SHARE, 1e-2 * atol_velocity, atol_velocity)


def tightened(tolerances: tuple[float, float, float], closings: Sequence[Closing]) -> Tolerances:
    """rtol, a_x in m and a_v in m/s, or those that the slowest of the closings needs, whichever are finer."""
    needs = [closing_tolerances(closing.haul.speed) for closing in closings]
    return Tolerances(*(min(values) for values in zip(tolerances, *needs, strict=True)))


def sharp_enough(in_force: tuple[float, float, float], closings: Sequence[Closing]) -> bool:
    """Whether tolerances, rtol, m and m/s, are as fine as all of the closings need."""
    return all(
        own <= need * (1 + 1e-9) for own, need in zip(in_force, tightened(in_force, closings), strict=True)
    )


def accuracy_reported(in_force: tuple[float, float, float], closings: Sequence[Closing]) -> str | None:
    """The sentence in which a run compares its tolerances with those that its closings need; None without closings."""
    if not closings:
        return None
    speed = min(closing.haul.speed for closing in closings)
    given = "rtol {:g}, atol_position {:g} m, atol_velocity {:g} m/s"
    flown = f"closing at {speed:g} m/s is flown with {given.format(*in_force)}"
    if sharp_enough(in_force, closings):
        return f"{flown}, as it needs"
    needed = given.format(*closing_tolerances(speed))
    return f"{flown}, but it needs {needed}: the mouth may close too soon or too late"


def _check_length(length: float | None) -> None:
    if length is not None and not (math.isfinite(length) and length > 0):
        raise InputError(f"closing: length is {length:g} m: give a finite number above zero")


def motors_of(hauls: Sequence[Haul], drums: Sequence[int]) -> ElementForce:
    """The motors of drums at the nodes `drums`, one for each haul."""
    speed = np.array([haul.speed for haul in hauls], dtype=np.float64)
    strength: FloatArray = np.array([haul.force for haul in hauls], dtype=np.float64)
    motors = Motor(strength, speed, WIDTH * speed, CREEP * speed)
    return ElementForce(MOTOR, np.array(drums, dtype=np.int64)[:, None], motors)
