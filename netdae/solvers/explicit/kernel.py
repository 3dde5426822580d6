"""The kernel of `verlet` bound to a system: its forces, bodies and restraints, and what they are at each step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from netdae.core.arrays import BoolArray, FloatArray, IntArray, wholes
from netdae.core.records import Record
from netdae.forces.contact import MEETING, RESTING
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.forces.gyroscope import GYROSCOPE
from netdae.forces.loops import SUMS
from netdae.forces.table import Table
from netdae.model.motions import Fixed
from netdae.model.restraints import Drive
from netdae.model.signals import is_constant
from netdae.solvers.explicit.discrete_gradient import fly_lossless, room_for
from netdae.solvers.explicit.drums import drums_of
from netdae.solvers.explicit.parts import POWERS, Acting, Bodies, Held, Room, Tally
from netdae.solvers.explicit.rayleigh import ImplicitDamping, drags_of
from netdae.solvers.explicit.rubbing import Contacts
from netdae.solvers.explicit.verlet import fly
from netdae.system.system import System

NOTHING = np.zeros(0)
"""Memory of a net that meets nothing."""


class Kernel:
    """Flies several steps at a time.

    table : the forces that act in each step; `entries` (c,) are the restrained ones of x flat
    rubs : whether the friction of a drawcord at its rings bounds the step
    lossless : whether its step is that of `discrete_gradient`
    """

    def __init__(self, system: System, drive: Drive, longest: int) -> None:
        self.pose = None if system.body is None else Record(system.body.pose.values)
        self._way = np.zeros(1)  # as long as its address is used
        system = system.seen_by(self.pose, way=int(self._way.ctypes.data))
        laws = [(force, force.law) for force in system.forces if isinstance(force, ElementForce)]
        turning = [force for force, law in laws if law is GYROSCOPE]
        apart = [force for force, law in laws if law.implicit or law.steady] + turning
        slow = [force for force, _ in laws if is_slow(force) and force not in apart]
        forces = [force for force in system.forces if force not in apart and force not in slow]
        between = lossless_of(system)
        self.lossless = len(between) > 0
        forces = [force for force in forces if force not in between]
        self.table = Table(forces, system.in_space, watch_lengths=True)
        self._between_table = Table(between, system.in_space)
        self._slow_table = Table(slow, system.in_space).prepare("add")
        self.table.prepare("add", "sift", "rests", "rate", "settle", "powers")
        drums = [force for force in apart if force.law.implicit]
        self._on_drums = [force.elements(force.nodes, system.in_space) for force in drums]
        mass = np.repeat(system.mass, 3)
        self._drive = drive
        self.look_at_anchors()
        self.entries = self._held.values.entry
        share = np.divide(1.0, mass, out=np.zeros_like(mass), where=mass > 0)
        share[self.entries] = 0.0
        drags = drags_of([force for force in apart if force.law.steady], len(mass))
        self._damping = ImplicitDamping(drags, mass, self.entries)
        shortest = float(system.net.rest_length.min(initial=math.inf))
        in_python = any(not isinstance(force, ElementForce) for force in forces)
        whole = in_python or self._damping.at(0.0).damps
        always = _nodes_of(between or [*forces, *drums], self.entries, system.net.node_count)
        whole = whole and not self.lossless
        turned = _turned_of(system, self.pose)
        self._bodies = Record(Bodies(mass, share, system.in_space, always, whole, shortest, *turned))
        self._room = Record(_room_of(len(mass)))
        if self.lossless:
            self._between_table.prepare("add", "sift", "between", "crest")
            self._between = Record(room_for(self._between_table.address, len(mass)))
        self.rubs = any(law.rate is not None and force.parameters.friction > 0 for force, law in laws)
        self._contacts, self._places = _contacts_of(self.table, int(self._way.ctypes.data))
        self._drums = Record(drums_of(drums, self._on_drums))
        self._acting = Record(
            Acting(
                rows=self.table.address,
                drums=self._drums.address,
                slow_rows=self._slow_table.address,
                slow=_zeros(len(mass), bool(slow)),
                slow_x=_zeros(len(mass), bool(slow)),
                slow_v=_zeros(len(mass), bool(slow)),
                ahead=_zeros(len(mass), bool(self.table.rows.ahead.any())),
                in_python=in_python,
                contacts=0 if self._contacts is None else self._contacts.address,
                rubs=self.rubs,
            )
        )
        self._motions = [r.motion for r in drive.restraints]
        self._fixed = all(isinstance(each, Fixed) for each in self._motions)
        self._no_history = np.empty((0, 3, len(mass))), np.empty((0, 10)), np.empty((0, 4))
        self._no_motions = np.zeros((longest + 1, 3, 3 * len(self._motions)))

    @property
    def memory(self) -> FloatArray:
        """What the next step depends on besides x, v and a: the base of a target's attitude, and s of contacts."""
        if self.pose is None and not self._places:
            return NOTHING
        base = () if self.pose is None else (self.pose.values.base,)
        return np.concatenate((*base, *self._places, np.zeros(0)))

    def see(self, base: FloatArray) -> None:
        """Let a flight begin where the base of the target's attitude is this."""
        self.remember(np.concatenate((base, self.memory[len(base) :])))

    def remember(self, memory: FloatArray) -> None:
        """Go on from another memory."""
        if self.pose is not None:
            base, memory = np.split(memory, [len(self.pose.values.base)])
            self.pose.values.base[:] = base
            self.pose.values.known[:] = np.nan
        for place in self._places:
            place[:], memory = memory[: len(place)], memory[len(place) :]

    def look_at_anchors(self) -> None:
        """Take the drive's anchors, which a resumed flight sets before it enters a phase."""
        self._held = Record(_held_of(self._drive))

    def go_on(self, part: System, t: float) -> None:
        """Go on at t in a part of a phase."""
        begin = part.inside(-math.inf)  # not t: a resumed flight has the same lines
        for table in (self.table, self._slow_table):
            table.go_on(begin if math.isfinite(begin) else t, part.inside(math.inf), part.inside)

    def fly(
        self,
        phase: System,
        start: tuple[float, float, FloatArray],
        *,
        steps: int,
        hold: int = 1,
        limits: tuple[float, float] = (math.inf, math.inf),
        fresh: bool = False,
        powers: FloatArray | None = None,
        history: tuple[FloatArray, FloatArray, FloatArray] | None = None,
    ) -> Tally:
        """Take steps, at most as many as the `longest` chunk has; raises what a force written in Python raises.

        start : t, h, and x, v, a as (3, 3n), which are advanced to the end
        hold : steps for which slow forces are held
        limits : the steps end where a strain or the rate of friction in 1/s passes its limit, or a rest length its
            minimum; nothing ends them if the first limit is infinite
        fresh : whether the flight begins here
        powers : (8,), of the previous step, advanced to the end, see `explicit.verlet.fly`
        history : room for each step, see `explicit.verlet.fly`
        """
        t, h, xva = start
        motions = self._no_motions
        if not self._fixed:
            times = [phase.inside(t + k * h) for k in range(steps + 1)]
            moves = [np.concatenate([motion.at(at) for motion in self._motions], axis=1) for at in times]
            motions = np.array(moves)
        if history is None:
            history = self._no_history
        records = self._bodies, self._acting, self._held, self._room
        addresses = tuple(record.address for record in records)
        if self.lossless:
            between = self._between.address
            tally = fly_lossless(
                xva.ctypes.data, addresses, between, motions, t, h, steps, hold, limits[0], history
            )
            self.table.check()
            return tally
        before = np.zeros(POWERS) if powers is None else powers
        tally = fly(
            xva.ctypes.data,
            addresses,
            self._damping.at(h),
            motions,
            t,
            h,
            steps,
            hold,
            limits,
            fresh,
            before,
            history,
        )
        self.table.check()
        return tally


def lossless_of(system: System) -> list[Force]:
    """Forces between two places of an undamped net, see `discrete_gradient`; none where a net cannot be so flown.

    Not with damping of the cables, nor with what slides through rings, is wound up by drums, or meets a target.
    """
    forces = [force for force in system.forces if isinstance(force, ElementForce)]
    if system.body is not None or any(force.law in (MEETING, RESTING) for force in forces):
        return []
    if system.reels or any(force.law.implicit or force.law.steady or force.law.rate for force in forces):
        return []
    found: list[Force] = [
        force
        for force in forces
        if force.law.between is not None and force.law.lossless(force.parameters) and len(force.nodes)
    ]
    return found if system.cables.force in found else []


def is_slow(force: Force) -> bool:
    """Whether an external force depends on positions and velocities alone, and changes little in a few steps."""
    if not isinstance(force, ElementForce) or force.law.shares != ("external",):
        return False
    return force.law.external and force.newton == "nothing" and is_constant(force.signal)


def _contacts_of(table: Table, way: int) -> tuple[Record | None, list[FloatArray]]:
    """Forces of contact in a table, None where there are none, and where they keep s."""
    found: dict[Any, list[int]] = {MEETING: [], RESTING: []}
    places = []
    for force, record in zip(table.forces, table.elements, strict=True):
        if isinstance(force, ElementForce) and force.law in found:
            found[force.law].append(record.address)
            places.append(force.kept.place)
    if not places:
        return None, []
    return Record(Contacts(way, *(np.array(each, dtype=np.int64) for each in found.values()))), places


def _turned_of(system: System, pose: Record | None) -> tuple[int, int, bool, float]:
    """Of a target: address of its attitude, where its spin begins, whether it is free, and its radius in m."""
    body = system.body
    if body is None or pose is None:
        return 0, 0, False, 0.0
    return pose.address, 3 * body.spin, body.target.motion == "free", body.radius


def _zeros(size: int, needed: bool) -> FloatArray:
    return np.zeros(size if needed else 0)


def _nodes_of(forces: list[Force], entries: IntArray, count: int) -> BoolArray:
    """Which of the nodes must move in each step: all but those on which only forces act that are sifted."""
    always = np.zeros(count, dtype=np.bool_)
    always[entries // 3] = True
    for force in forces:
        if not (isinstance(force, ElementForce) and force.law.near is not None):
            always[force.nodes] = True
    return always


def _room_of(size: int) -> Room:
    f, kick, viscous, now, drift = np.zeros((5, size))
    n = size // 3
    return Room(
        f=f,
        kick=kick,
        viscous=viscous,
        now=now,
        moves=np.zeros(n, dtype=np.bool_),
        begin=wholes(n),
        end=wholes(n),
        counts=wholes(3),
        reach=np.zeros(5),
        drift=drift,
        sums=np.zeros(SUMS),
        gained=np.zeros(POWERS),
        outside=np.zeros(6),
    )


def _held_of(drive: Drive) -> Held:
    entry, motion = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for r, (nodes, axes) in enumerate(drive.places):
        entry.append((3 * nodes + axes).ravel())
        motion.append(np.broadcast_to(3 * r + axes, (len(nodes), axes.size)).ravel())
    entries = np.concatenate(entry)
    x, R, speed = np.zeros((3, len(entries)))
    return Held(entries, drive.anchor.ravel()[entries], np.concatenate(motion), x, R, speed)
