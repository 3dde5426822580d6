"""The explicit method: velocity Verlet in chunks of steps, with a step length that is known to be stable.

The step is the stable one of `stable_step` for a strain limit above all strains so far. A step that passes the limit
ends its chunk, and the limit is raised.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Mapping
from time import perf_counter
from typing import ClassVar, NamedTuple

import numpy as np

from netdae._arrays import FloatArray
from netdae.errors import RunError
from netdae.kernel_forces import KernelForces
from netdae.motions import Fixed
from netdae.options import SolverOptions
from netdae.restraints import Drive
from netdae.signals import Constant
from netdae.stable_step import stable_step
from netdae.stepper import Share, Step
from netdae.system import System
from netdae.verlet import Held, Tally, fly

CHUNK = 128  # steps between two looks: 2 to 3 ms of a 21 x 21 net
FRACTIONS = {"fast": 0.9, "standard": 0.5, "accurate": 0.2}
"""Share of the stable step length that each accuracy takes; `scripts/accuracy.py` measures what each keeps."""
UNBOUND = 1e-3  # s, where nothing that moves bounds the step
UNSTABLE = 0.1  # gain of energy, as a share of the largest, that no stable flight has


class _Chunk(NamedTuple):
    """Where a chunk of steps began, so that any instant inside it can be flown again."""

    t: float
    h: float
    x: FloatArray
    v: FloatArray
    a: FloatArray


class ExplicitSolver:
    """Velocity Verlet for one System; bit-for-bit repeatable."""

    COUNTS: ClassVar[tuple[str, ...]] = ("steps", "step_lengths", "starts")

    def __init__(self, system: System, drive: Drive, options: SolverOptions) -> None:
        self._system = self._phase = system
        self._drive = drive
        self._options = options
        self._mass = np.repeat(system.mass, 3)
        self._forces = KernelForces.of(system)
        self._has_toe = bool((self._forces.cables.eps > 0).any())
        signals = self._forces.signals
        self._constant = all(isinstance(each, Constant) for each in signals)
        values = [each(0.0) for each in signals] if self._constant else []
        self._constant_signals = np.array(values).reshape(1, len(values), 3)
        self._held = _held_of(drive)
        self._fixed = all(isinstance(restraint.motion, Fixed) for restraint in drive.restraints)
        self._no_motions = np.zeros((CHUNK + 1, 3, 3 * len(drive.restraints)))
        self._share = np.divide(1.0, self._mass, out=np.zeros_like(self._mass), where=self._mass > 0)
        self._share[self._held.entry] = 0.0
        self._x, self._v, self._a = np.zeros((3, len(self._mass)))
        self._chunk = _Chunk(0.0, 0.0, self._x, self._v, self._a)
        self._first = Step(
            0.0, np.zeros(0), np.zeros(0)
        )  # of the last chunk; the ledger starts afresh at its end
        self._t = 0.0
        self._strain_limit = 0.0
        self._stable = 0.0
        self._peak = 0.0
        self._energy = self._scale = math.nan
        self._gained = 0.0
        self.every_step = False
        self.counts: Counter[str] = Counter()
        self.seconds: defaultdict[str, float] = defaultdict(float)

    def enter(self, phase: System, t: float, y: FloatArray, yp: FloatArray) -> None:
        """Start afresh at t in a phase."""
        self._phase, self._t = phase, t
        self._x, self._v, self._a = y[0].ravel().copy(), y[1].ravel().copy(), yp[1].ravel().copy()
        self._energy = self._energy_now()
        self._scale = abs(self._energy)
        self._gained = 0.0
        self._limit_strain(float(self._system.strain(y[0]).max()))
        self.counts["starts"] += 1

    def go_on(self, part: System) -> None:
        """Go on in the part of the phase that begins here, where accelerations of driven axes may jump."""
        self._phase = part
        a_d = self._drive.at(part.inside(self._t))[2].ravel()
        self._a[self._held.entry] = a_d[self._held.entry]

    def step(self, stop: float) -> list[Step]:
        """Up to `CHUNK` steps towards `stop`: their end, and before it the step of a new largest tension."""
        begin = perf_counter()
        remaining = stop - self._t
        count = min(1 if self.every_step else CHUNK, math.ceil(remaining / self._stable))
        last = count * self._stable >= remaining
        h = remaining / count if last else self._stable
        self._chunk = _Chunk(self._t, h, self._x.copy(), self._v.copy(), self._a.copy())
        tally = self._fly(self._x, self._v, self._a, count)
        self._t = stop if last and tally.steps == count else self._chunk.t + tally.steps * h
        steps = [self._end_of(tally)]
        if tally.peak > self._peak and tally.peak_step < tally.steps:
            self._peak = tally.peak
            peak, rest = self._again(tally.peak_step), self._chunk.t + tally.peak_step * h
            first = Step(rest, peak[1], peak[2], peak[0])
            assert first.share is not None
            steps = [first, _after(steps[0], first.share)]
        self._first = steps[0]
        self._peak = max(self._peak, tally.peak)
        self.counts["steps"] += tally.steps
        self._check_energy(tally)
        if tally.steps < count or self._wasteful(tally.strain):
            self._limit_strain(tally.strain)
        self.seconds["steps"] += perf_counter() - begin
        return steps

    def output(self, t: float) -> Step:
        """The state inside the last chunk, which is flown again up to the step that holds t."""
        begin = perf_counter()
        t0, h = self._chunk.t, self._chunk.h
        before = int((t - t0) / h)
        share, (x0, v0), (_, a0) = self._again(before)
        whole, (x1, v1), (_, a1) = self._again(before + 1)
        s = min(max((t - t0) / h - before, 0.0), 1.0)
        x = _hermite(s, h, x0, v0, x1, v1)
        v = _hermite(s, h, v0, a0, v1, a1)
        a = (1 - s) * a0 + s * a1
        between = Share(
            share.dissipated_energy + s * (whole.dissipated_energy - share.dissipated_energy),
            share.external_work + s * (whole.external_work - share.external_work),
            share.external_impulse + s * (whole.external_impulse - share.external_impulse),
            share.peak_tension,
        )
        self.seconds["outputs"] += perf_counter() - begin
        inner = Step(t, np.stack((x, v)), np.stack((v, a)), between)
        told = self._first
        return _after(inner, told.share) if told.share is not None and t > told.t else inner

    def memory(self) -> dict[str, FloatArray]:
        """What the next chunk of steps depends on, beside y."""
        numbers = (
            self._t,
            self._strain_limit,
            self._stable,
            self._peak,
            self._energy,
            self._scale,
            self._gained,
        )
        return {"v": self._v.copy(), "a": self._a.copy(), "numbers": np.array(numbers)}

    def restore(self, memory: Mapping[str, FloatArray]) -> None:
        """Go on as the integrator that told this memory."""
        self._v[:], self._a[:] = memory["v"], memory["a"]
        numbers = memory["numbers"].tolist()
        self._t, self._strain_limit, self._stable, self._peak, self._energy, self._scale, self._gained = (
            numbers
        )

    def _again(self, count: int) -> tuple[Share, FloatArray, FloatArray]:
        """Share, (x, v) and (v, a) after `count` steps of the last chunk."""
        x, v, a = self._chunk.x.copy(), self._chunk.v.copy(), self._chunk.a.copy()
        if count == 0:
            return Share(0.0, 0.0, np.zeros(3), 0.0), *_y_and_yp(x, v, a)
        tally = self._fly(x, v, a, count)
        return _share_of(tally), *_y_and_yp(x, v, a)

    def _fly(self, x: FloatArray, v: FloatArray, a: FloatArray, count: int) -> Tally:
        """The first `count` steps of the running chunk."""
        restraints = self._drive.restraints
        signals, motions = self._constant_signals, self._no_motions
        if not self._constant:
            signals = np.empty((count + 1, len(self._forces.signals), 3))
        if not self._fixed:
            motions = np.empty((count + 1, 3, 3 * len(restraints)))
        if not (self._constant and self._fixed):
            for k in range(count + 1):
                t = self._phase.inside(self._chunk.t + k * self._chunk.h)
                if not self._constant:
                    signals[k] = [signal(t) for signal in self._forces.signals]
                for r, restraint in enumerate(() if self._fixed else restraints):
                    motions[k, :, 3 * r : 3 * r + 3] = restraint.motion.at(t)
        return fly(
            x,
            v,
            a,
            self._mass,
            self._share,
            self._forces.cords,
            self._forces.drags,
            self._forces.pushes,
            self._held,
            signals,
            motions,
            self._chunk.h,
            count,
            self._strain_limit,
        )

    def _end_of(self, tally: Tally) -> Step:
        return Step(self._t, *_y_and_yp(self._x, self._v, self._a), _share_of(tally))

    # The step length

    def _limit_strain(self, strain: float) -> None:
        """Set the strain limit well above `strain`, a power of two, and the step length that is stable below it."""
        floor = 0.25 * float(self._forces.cables.eps.max()) or 1e-2
        limit = floor * 2.0 ** max(0, math.ceil(math.log2(max(2.0 * strain, floor) / floor)))
        if limit != self._strain_limit:
            self._strain_limit = limit
            self._stable = self._step_length(limit)
            self.counts["step_lengths"] += 1

    def _wasteful(self, strain: float) -> bool:
        """Whether the limit lies far above what is needed."""
        return self._has_toe and self._strain_limit > 16.0 * max(strain, 0.0)

    def _step_length(self, strain: float) -> float:
        """The stable step while no strain passes `strain`, times the share that the accuracy takes."""
        stable = FRACTIONS[self._options.accuracy] * stable_step(self._system, strain)
        longest = self._options.max_step or math.inf
        return min(stable, longest) if math.isfinite(min(stable, longest)) else UNBOUND

    # Energy

    def _energy_now(self) -> float:
        x, v = self._x.reshape(-1, 3), self._v.reshape(-1, 3)
        return self._system.kinetic_energy(v) + self._system.elastic_energy(x)

    def _check_energy(self, tally: Tally) -> None:
        """Raise RunError where energy has come out of nothing, as it does in a step that is too long."""
        energy = self._energy_now()
        self._gained += tally.work - tally.dissipated
        self._scale = max(self._scale, energy, abs(self._gained))
        excess = energy - self._energy - self._gained
        if not excess <= UNSTABLE * self._scale:
            speed = np.linalg.norm(self._v.reshape(-1, 3), axis=1)
            node = int(np.argmax(np.where(np.isfinite(speed), speed, np.inf)))
            raise RunError(
                f"the run failed at t = {self._t:.9g} s: its energy rose by {excess:.3g} J out of nothing, the "
                f"explicit step of {self._chunk.h:.3g} s is too long; worst is node {node} with {speed[node]:.3g} m/s. "
                "Try a smaller max_step, or method = 'ida'"
            )


def _held_of(drive: Drive) -> Held:
    entry, motion = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for r, (nodes, axes) in enumerate(drive.places):
        entry.append((3 * nodes + axes).ravel())
        motion.append(np.broadcast_to(3 * r + axes, (len(nodes), axes.size)).ravel())
    entries = np.concatenate(entry)
    return Held(entries, drive.anchor.ravel()[entries], np.concatenate(motion))


def _y_and_yp(x: FloatArray, v: FloatArray, a: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(x, v) and (v, a), (2, n, 3), of the flat arrays: two views of one copy."""
    whole = np.empty((3, len(x) // 3, 3))
    flat = whole.reshape(3, -1)
    flat[0], flat[1], flat[2] = x, v, a
    return whole[:2], whole[1:]


def _share_of(tally: Tally) -> Share:
    return Share(tally.dissipated, tally.work, np.array([tally.px, tally.py, tally.pz]), tally.peak)


def _after(step: Step, first: Share) -> Step:
    """A step whose share starts where another one's ends."""
    assert step.share is not None
    whole = step.share
    return step._replace(
        share=Share(
            whole.dissipated_energy - first.dissipated_energy,
            whole.external_work - first.external_work,
            whole.external_impulse - first.external_impulse,
            whole.peak_tension,
        )
    )


def _hermite(
    s: float, h: float, x0: FloatArray, v0: FloatArray, x1: FloatArray, v1: FloatArray
) -> FloatArray:
    """Cubic through (x0, v0) and (x1, v1) at the share s of a step of length h."""
    r = 1 - s
    return r * r * (1 + 2 * s) * x0 + s * s * (3 - 2 * s) * x1 + h * s * r * (r * v0 - s * v1)
