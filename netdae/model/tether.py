"""The tether from a net to its chaser, and the chaser: their data, before they are attached, see `tether_assembly`.

Symbols: ρ̄Ā mass per length in kg/m, J drum's moment of inertia, R its radius, s length paid out in m.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from netdae.core.arrays import BoolArray, IntArray
from netdae.core.errors import InputError
from netdae.model.material import Material
from netdae.model.motions import Motion
from netdae.model.net import CableNet

Payout = Literal["locked", "free", "braked"]
PAYOUTS: tuple[Payout, ...] = ("locked", "free", "braked")

NODE_GROUPS = ("tether", "chaser", "reel")
"""Node groups of a tether: its knots with those of a bridle, the chaser, the reel."""

PULLEY_DRUMS = "pulley_drums"
"""Node group of the drums of pulley cords, which never turn."""

PLACE, SPIN = "target", "spin of target"
"""Node groups of a target: its centre of mass and its spin."""

FOREIGN = (*NODE_GROUPS, "drums", PULLEY_DRUMS, PLACE, SPIN)
"""Node groups of all that flies with a net besides its own knots: tether, drums of its cords, target."""

CABLE_GROUPS = ("tether", "bridle")
"""Cable groups of a tether: the chain, and the legs to several nodes of the net."""


def is_own_node(net: CableNet) -> BoolArray:
    """Which nodes are not part of a tether, its chaser or its reel, and are not drums, (n,)."""
    own = np.ones(net.node_count, dtype=np.bool_)
    for name in FOREIGN:
        own[net.node_groups.get(name, [])] = False
    return own


def own_nodes_of(net: CableNet) -> IntArray:
    """Nodes of the net without those of a tether, its chaser and its reel, and drums, (k,); all if it has none."""
    return np.flatnonzero(is_own_node(net))


def own_cables_of(net: CableNet) -> IntArray:
    """Cables of the net without those of a tether and its bridle, (k,); all if it has none."""
    own = np.ones(net.cable_count, dtype=np.bool_)
    for name in CABLE_GROUPS:
        own[net.cable_groups.get(name, [])] = False
    return np.flatnonzero(own)


@dataclass(frozen=True)
class Chaser:
    """The body at the far end of the tether.

    position : (3,), m, at the start
    velocity : (3,), m/s, at the start; zero with a motion, which has its own
    mass : kg; above zero unless a motion holds it
    motion : how it moves from where it starts, `Fixed()` for not at all; None for a free mass
    """

    position: tuple[float, float, float]
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mass: float = 0.0
    motion: Motion | None = None

    def __post_init__(self) -> None:
        for name in ("position", "velocity"):
            value = np.asarray(getattr(self, name), dtype=np.float64)
            if value.shape != (3,) or not np.isfinite(value).all():
                raise InputError(
                    f"tether: {name} of the chaser is {value.tolist()}: give three finite numbers"
                )
        if not (math.isfinite(self.mass) and self.mass >= 0):
            raise InputError(
                f"tether: mass of the chaser is {self.mass:g} kg: give a finite number, zero or more"
            )
        if self.motion is None and self.mass == 0:
            raise InputError(
                "tether: the chaser is free but has no mass: give its mass, or hold it by a motion"
            )
        if self.motion is not None and np.any(self.velocity):
            raise InputError(
                f"tether: the chaser has a motion and the velocity {list(self.velocity)}: leave the velocity out"
            )


@dataclass(frozen=True)
class Tether:
    """A tether between the nodes of `group` and a chaser.

    elements : cables of the chain
    length : m, rest length of the chain at the start; or
    slack : share of the chain's path at the start by which the rest length exceeds it
    bridle : m, rest length of each leg where the group has several nodes
    payout : "locked", "free", "braked" by `brake_force`, or the Motion of s along x: a driven reel
    brake_force : N, dry friction; ratchet : True if the brake lets nothing wind back
    drum_inertia : J/R², kg
    longest : m, rest length of the chain with the drum empty: a stop ends the pay-out there; None for no limit
    begin, lock : s, or the names of events, at which the reel is released and locked for good; by default it is
        free from the start and never locked

    Raises InputError for values that are out of range or do not go together.
    """

    group: str
    elements: int
    material: Material
    chaser: Chaser
    length: float | None = None
    slack: float | None = None
    bridle: float | None = None
    payout: Payout | Motion = "locked"
    brake_force: float = 0.0
    ratchet: bool = False
    drum_inertia: float = 0.0
    longest: float | None = None
    lock: float | str | None = None
    begin: float | str | None = None

    def __post_init__(self) -> None:
        if self.elements < 1:
            raise InputError(f"tether: elements is {self.elements}: give 1 or more")
        if (self.length is None) == (self.slack is None):
            raise InputError("tether: give just one of length and slack")
        for name in ("length", "bridle", "longest"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0):
                raise InputError(f"tether: {name} is {value:g} m: give a finite number above zero")
        for name in ("slack", "brake_force", "drum_inertia"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value >= 0):
                raise InputError(f"tether: {name} is {value:g}: give a finite number, zero or more")
        self._check_payout()

    @property
    def driven(self) -> bool:
        """Whether a motion drives the reel."""
        return not isinstance(self.payout, str)

    def mass_left(self, paid_out: float) -> float:
        """Mass in kg of the length `paid_out` in m, which the model leaves at the chaser, see `tether_assembly`."""
        material = self.material
        if material.linear_density is not None:
            return material.linear_density * paid_out
        assert material.density is not None
        return material.density * material.cross_section * paid_out

    def _check_payout(self) -> None:
        if isinstance(self.payout, str) and self.payout not in PAYOUTS:
            raise InputError(
                f"tether: payout is {self.payout!r}: choose one of {', '.join(PAYOUTS)}, or a motion"
            )
        given = {
            "brake_force": self.brake_force > 0,
            "ratchet": self.ratchet,
            "drum_inertia": self.drum_inertia > 0,
            "longest": self.longest is not None,
            "begin": self.begin is not None,
            "lock": self.lock is not None,
        }
        mode = "driven" if self.driven else self.payout
        needs = {"free": {"drum_inertia"}, "braked": {"drum_inertia", "brake_force"}}.get(str(mode), set())
        if mode == "driven" and self.lock is not None:
            needs = {"drum_inertia"}
        alien = {
            "locked": set(given),
            "free": {"brake_force", "ratchet"},
            "driven": {"brake_force", "ratchet", "longest", "begin"},
        }.get(str(mode), set())
        for name, there in given.items():
            if there and name in alien:
                raise InputError(
                    f"tether: {name} says nothing where payout is {mode}: leave it out, or choose another payout"
                )
            if not there and name in needs:
                raise InputError(f"tether: payout is {mode}, which needs {name}: give it, above zero")
        times = [t for t in (self.begin, self.lock) if t is not None and not isinstance(t, str)]
        if len(times) == 2 and not times[0] < times[1]:
            raise InputError(
                f"tether: it is let go at {times[0]:g} s and locked at {times[1]:g} s: lock it later"
            )
