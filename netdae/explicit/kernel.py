"""The kernel of `verlet` bound to a system: its forces, bodies and restraints, and what they are at each step."""

from __future__ import annotations

import math

import numpy as np

from netdae._arrays import FloatArray
from netdae.explicit.forces import KernelForces
from netdae.explicit.verlet import Bodies, Held, Tally, fly
from netdae.kernels.rayleigh import ImplicitDamping
from netdae.motions import Fixed
from netdae.restraints import Drive
from netdae.signals import Constant
from netdae.system import System


class Kernel:
    """Flies several steps at a time.

    `forces` are those of the system; `entries` (c,) are the restrained ones of x flat.
    """

    def __init__(self, system: System, drive: Drive, longest: int) -> None:
        self.forces = KernelForces.of(system)
        self._unlimited = self.forces.down_to(np.zeros(self.forces.reeled_count))
        mass = np.repeat(system.mass, 3)
        self._drive = drive
        self.look_at_anchors()
        self.entries = self._held.entry
        share = np.divide(1.0, mass, out=np.zeros_like(mass), where=mass > 0)
        share[self.entries] = 0.0
        self._damping = ImplicitDamping(self.forces.drags, mass, self.entries)
        self._bodies = Bodies(mass, share, system.in_space.copy())
        self._signals, self._motions = self.forces.signals, [r.motion for r in drive.restraints]
        self._constant = all(isinstance(each, Constant) for each in self._signals)
        self._fixed = all(isinstance(each, Fixed) for each in self._motions)
        values = [each(0.0) for each in self._signals] if self._constant else []
        self._constant_signals = np.array(values).reshape(1, len(values), 3)
        self._nothing_told = np.empty((0, 3, len(mass))), np.empty((0, 10))
        self._no_motions = np.zeros((longest + 1, 3, 3 * len(self._motions)))

    def look_at_anchors(self) -> None:
        """Take those of the drive, which a flight that is resumed puts in their place before it enters a phase."""
        self._held = _held_of(self._drive)

    def fly(
        self,
        phase: System,
        start: tuple[float, float, FloatArray],
        *,
        steps: int,
        limits: tuple[float, float] = (math.inf, math.inf),
        least_length: FloatArray | None = None,
        fresh: bool = False,
        powers: FloatArray | None = None,
        told: tuple[FloatArray, FloatArray] | None = None,
    ) -> Tally:
        """Take steps, at most as many as the `longest` chunk has.

        start : t, h, and x, v, a as (3, 3n), which go on to the end
        limits, least_length : where a strain or the rate of friction in 1/s passes the one or the rest length of a
            reeled cable falls below the other, (m,), m, the steps end
        fresh : whether the flight begins here
        powers : (2,), of the step before, which go on to the end, see `explicit.verlet.fly`
        told : what each step is told in, see `explicit.verlet.fly`
        """
        t, h, (x, v, a) = start
        signals, motions = self._constant_signals, self._no_motions
        if not (self._constant and self._fixed):
            times = [phase.inside(t + k * h) for k in range(steps + 1)]
            if not self._constant:
                signals = np.array([[signal(at) for signal in self._signals] for at in times])
            if not self._fixed:
                moves = [np.concatenate([motion.at(at) for motion in self._motions], axis=1) for at in times]
                motions = np.array(moves)
        if told is None:
            told = self._nothing_told
        forces = self._unlimited if least_length is None else self.forces.down_to(least_length)
        solver = self._damping.at(h)
        bound = self._bodies, forces, self._held, solver
        before = np.zeros(2) if powers is None else powers
        return fly(x, v, a, *bound, signals, motions, h, steps, limits, fresh, before, told)


def _held_of(drive: Drive) -> Held:
    entry, motion = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for r, (nodes, axes) in enumerate(drive.places):
        entry.append((3 * nodes + axes).ravel())
        motion.append(np.broadcast_to(3 * r + axes, (len(nodes), axes.size)).ravel())
    entries = np.concatenate(entry)
    return Held(entries, drive.anchor.ravel()[entries], np.concatenate(motion))
