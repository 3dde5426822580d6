"""Forces of a system as arrays for the kernel of `verlet`, and those that are left for kicks between its chunks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.explicit.verlet import Forces
from netdae.forces.brake import Brake, EndStop
from netdae.forces.cables import Cables
from netdae.forces.drawcord import SlidingCord
from netdae.forces.loads import UniformLoad
from netdae.forces.motor import Motor
from netdae.forces.protocol import Force
from netdae.forces.rayleigh import MassDamping, StiffnessDamping
from netdae.forces.reel import Reeled
from netdae.kernels.cables import Cords, Drags
from netdae.kernels.cordage import Cordage
from netdae.kernels.loads import Pushes
from netdae.kernels.reels import Brakes, Drums, Reels, Stops
from netdae.kernels.strings import motors_of, strings_of
from netdae.signals import Signal
from netdae.system import System


class KernelForces(NamedTuple):
    """Forces of a system: those that the kernel knows, as it takes them, and `others`.

    signals : of the pushes, in the order of their numbers there
    """

    cords: Cords
    drags: Drags
    pushes: Pushes
    reels: Reels
    drums: Drums
    cordage: Cordage
    signals: tuple[Signal, ...]
    others: tuple[Force, ...]

    @classmethod
    def of(cls, system: System) -> KernelForces:
        """The forces of a system."""
        drags = Drags(np.zeros((0, 2), dtype=np.int64), np.zeros((0, 6)), np.zeros(0))
        loads, reeled, brakes, stops, motors, slid, others = [], [], [], [], [], [], []
        for force in system.forces:
            match force:
                case Cables():
                    cords = _cords_of(force)
                case StiffnessDamping():
                    upper = force.viscosity[:, *np.triu_indices(3)]
                    drags = drags._replace(ends=3 * force.nodes, viscosity=np.ascontiguousarray(upper))
                case MassDamping():
                    drags = drags._replace(alpha=np.repeat(force.viscosity, 3))
                case UniformLoad():
                    loads.append(force)
                case Reeled():
                    reeled.append(force)
                case Brake():
                    brakes.append(force)
                case EndStop():
                    stops.append(force)
                case Motor():
                    motors.append(force)
                case SlidingCord():
                    slid.append(force)
                case _:
                    others.append(force)
        return cls(
            cords,
            drags,
            _pushes_of(loads, system.in_space),
            _reels_of(reeled),
            _drums_of(brakes, stops, motors),
            _cordage_of(slid),
            tuple(load.signal for load in loads),
            tuple(others),
        )

    def down_to(self, least: FloatArray) -> Forces:
        """What the kernel takes; it ends where a rest length on a reel falls below `least` (m,), m.

        least : of single cables, then of whole cords, as `explicit.stable_step.reeled_lengths` tells them
        """
        of_cables, of_cords = np.split(least, [len(self.reels.L)])
        reels, cordage = self.reels._replace(least=of_cables), self.cordage._replace(least=of_cords)
        return Forces(self.cords, self.drags, self.pushes, reels, self.drums, cordage)

    @property
    def rubs(self) -> bool:
        """Whether a cord rubs at its rings."""
        return bool((self.cordage.strings.friction > 0).any())

    @property
    def reeled_count(self) -> int:
        """How many rest lengths there are on reels."""
        return len(self.reels.L) + len(self.cordage.least)


def _cords_of(cables: Cables) -> Cords:
    L, EA, tau, eps = (_floats([each]) for each in (cables.L, cables.EA, cables.tau, cables.eps))
    engineering = _flags([cables.engineering])
    plain = not ((eps > 0).any() or engineering.any())
    viscous = tau * EA / L**3
    return Cords(3 * cables.nodes, L**2, EA / (2 * L**3), viscous, EA, eps, engineering, tau, plain)


def _pushes_of(loads: list[UniformLoad], in_space: BoolArray) -> Pushes:
    groups = []
    for number, load in enumerate(loads):
        there = in_space[load.nodes[:, 0]]
        for chosen, flag in ((there, True), (~there, False)):
            if chosen.any():
                groups.append((load.nodes[chosen, 0], load.weight[chosen], number, flag))
    counts = [len(nodes) for nodes, _, _, _ in groups]
    return Pushes(
        _entries([nodes for nodes, _, _, _ in groups]),
        _floats([weight for _, weight, _, _ in groups]),
        np.repeat(np.array([number for _, _, number, _ in groups], dtype=np.int64), counts),
        np.cumsum([0, *counts]),
        _floats([weight.sum(keepdims=True) for _, weight, _, _ in groups]),
        _flags([np.array([flag]) for _, _, _, flag in groups]),
    )


def _reels_of(reeled: list[Reeled]) -> Reels:
    L = _floats([each.L for each in reeled])
    return Reels(
        _entries([each.nodes for each in reeled], 3),
        L,
        _floats([each.share for each in reeled]),
        _floats([each.EA for each in reeled]),
        _floats([each.eps for each in reeled]),
        _flags([each.engineering for each in reeled]),
        _floats([each.tau for each in reeled]),
        np.zeros(len(L)),
    )


def _drums_of(brakes: list[Brake], stops: list[EndStop], motors: list[Motor]) -> Drums:
    of_brakes = Brakes(
        _entries([each.nodes[:, 0] for each in brakes]),
        _floats([each.friction for each in brakes]),
        _floats([each.creep_speed for each in brakes]),
        _floats([each.viscosity for each in brakes]),
        _flags([each.ratchet for each in brakes]),
    )
    of_stops = Stops(
        _entries([each.nodes[:, 0] for each in stops]),
        _floats([each.place for each in stops]),
        _floats([each.side for each in stops]),
        _floats([each.stiffness for each in stops]),
        _floats([each.viscosity for each in stops]),
    )
    of_motors = motors_of(motors)
    entry = np.unique(np.concatenate((of_brakes.entry, of_stops.entry, of_motors.entry)))
    return Drums(entry, of_brakes, of_stops, of_motors)


def _cordage_of(cords: list[SlidingCord]) -> Cordage:
    strings = strings_of(cords)
    none = np.zeros_like(strings.tau)
    return Cordage(strings, strings._replace(tau=none, friction=none), none.copy())


# always fresh arrays of one layout, so that the kernel is compiled once


def _entries(nodes: list[IntArray], *k: int) -> IntArray:
    return 3 * np.concatenate((np.zeros((0, *k), dtype=np.int64), *nodes))


def _floats(parts: list[FloatArray]) -> FloatArray:
    return np.concatenate((np.zeros(0), *parts))


def _flags(parts: list[BoolArray]) -> BoolArray:
    return np.concatenate((np.zeros(0, dtype=np.bool_), *parts))
