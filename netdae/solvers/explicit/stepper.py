"""The explicit method: chunks of steps of the velocity Verlet, whose length is stable for linear nets.

Undamped nets take the step of `discrete_gradient`, which keeps their energy at kinks too. No other promise is made: see
`guard` for what stops a flight.

The step is the stable one of `stable_step` for limits above the strain and the rate of friction so far, and for rest
lengths on reels below the present ones. A step that passes a limit ends its chunk, and the limits are set anew. Forces
without a bound of their own are checked from time to time, and at each short chunk where they may come and go.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from itertools import pairwise
from time import perf_counter
from typing import ClassVar

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import RunError
from netdae.forces.reel import WOUND_IN
from netdae.model.restraints import Drive
from netdae.model.state import State
from netdae.solvers.explicit.chunk import (
    Chunk,
    after,
    between,
    share_of,
    share_reported,
    step_of,
    sum_of,
)
from netdae.solvers.explicit.discrete_gradient import LONGEST
from netdae.solvers.explicit.guard import ROUND_OFF, Guard
from netdae.solvers.explicit.kernel import Kernel
from netdae.solvers.explicit.parts import POWERS, Tally
from netdae.solvers.explicit.stable_step import STIFF, rate_of, stable_step, without_bound
from netdae.solvers.options import SolverOptions
from netdae.solvers.stepper import NOTHING, Scan, Share, Step
from netdae.system.damping import NoDamping
from netdae.system.system import System

CHUNK, LEAST = 512, 32  # most steps in a chunk, 1 to 2 ms of a 21 x 21 net; and the least that SPAN leaves
SPAN = 0.02  # share of a phase that a chunk may last: within a chunk the largest mouth and the like go unseen
KEPT_NUMBERS = 500_000  # numbers of x, v and a that are kept at once where every step is reported
FRACTIONS = {"fast": 0.9, "standard": 0.5, "accurate": 0.2}
"""Fraction of the stable step length for each accuracy; `scripts/accuracy.py` measures what each achieves."""
LEAST_RATE = 100.0  # 1/s, of friction at rings: no step of a net comes near it
HOLD = 8  # largest number of steps for which slow forces are held
HELD = {"fast": 0.005, "standard": 0.002, "accurate": 0.0005}
"""Time for which slow forces are held, times their rate: they change by at most about this fraction meanwhile."""
RATES_HOLD = 50  # chunks after which the rate of forces without a bound is checked again
SUDDEN = 8  # steps of a chunk where such forces may come and go, as those with a part in Newton's matrix do
UNBOUND = 1e-3  # s, where no moving part bounds the step


VERLET_UNDAMPED = (
    "the cables have no damping, and with reels, pulleys or drawcords the explicit step is a velocity Verlet, which "
    "may gain energy where cables go taut and slack: watch energy_residual_share, or give a dashpot"
)


class ExplicitSolver:
    """Velocity Verlet, or the step of `discrete_gradient`, for one System; bit-for-bit repeatable.

    every_step : whether each step of a chunk is reported, or those that `scan` leaves
    note : what a user should know about its step, or empty
    """

    COUNTS: ClassVar[tuple[str, ...]] = ("steps", "step_lengths", "starts")

    def __init__(self, system: System, drive: Drive, options: SolverOptions) -> None:
        self._system = self._phase = system
        self._drive = drive
        self._options = options
        self._kernel = Kernel(system, drive, CHUNK)
        self._share = FRACTIONS[options.accuracy]  # of the stable step
        if self._kernel.lossless:
            self._share = min(self._share, LONGEST)
        undamped = isinstance(system.damping, NoDamping) and not self._kernel.lossless
        self.note = VERLET_UNDAMPED if undamped else ""
        self._boundless = without_bound(system)
        self._sudden = any(force.newton != "nothing" for force in self._boundless)
        self._look_in, self._stiffest, self._held = 0, math.inf, math.inf
        self._has_toe = bool((system.cables.eps > 0).any())
        self._now = np.zeros((3, 3 * system.net.node_count))  # x, v and a
        self._powers = np.zeros(POWERS)  # of the last step, see `verlet.fly`
        self._chunk = Chunk(0.0, 0.0, self._now, self._powers, 1)
        self._done = 0  # steps of it
        self._steps: list[Step] = []  # of the last chunk, with shares from its start
        self._t = 0.0
        self._fresh = True  # no step has been taken in the phase
        self._strain_limit = self._rate_limit = self._span = 0.0
        self._lengths = np.zeros(0)
        self._stable = 0.0
        self._peak = 0.0
        self._guard = Guard(0.0)
        cables = system.cables
        self._floor = 0.5 * ROUND_OFF**2 * float(np.sum(cables.EA * cables.L))  # J
        self.every_step = False
        self.scan: Scan | None = None
        self.counts: Counter[str] = Counter()
        self.seconds: defaultdict[str, float] = defaultdict(float)

    def enter(self, phase: System, t: float, y: FloatArray, yp: FloatArray) -> None:
        """Start afresh at t in a phase."""
        self._phase, self._t, self._fresh = phase, t, True
        self._span, self._look_in = 0.0, 0
        self._kernel.look_at_anchors()
        self._kernel.go_on(phase, t)
        self._now = np.stack((y[0].ravel(), y[1].ravel(), yp[1].ravel()))
        if (body := self._system.body) is not None and self._kernel.pose is not None:
            self._kernel.see(body.pose.values.base)
            self._now[2].reshape(-1, 3)[body.spin] -= body.gyroscopic(y[1])
        self._guard = Guard(self._energy_now())
        self._limit(float(self._system.strain(y[0]).max()), 0.0)
        self.counts["starts"] += 1

    def go_on(self, part: System) -> None:
        """Go on in the part of the phase that begins here, where accelerations of driven axes may jump."""
        self._phase = part
        self._kernel.go_on(part, self._t)
        a_d = self._drive.at(part.inside(self._t))[2].ravel()
        self._now[2, self._kernel.entries] = a_d[self._kernel.entries]

    def step(self, stop: float) -> list[Step]:
        """Up to `CHUNK` steps towards `stop`: all, or the last and before it the step of a new largest tension."""
        begin = perf_counter()
        remaining = stop - self._t
        self._span = max(self._span, SPAN * remaining)
        self._look_at_rate()
        stable = min(self._stable, self._stiffest)
        count = min(self._longest(stable), math.ceil(remaining / stable))
        last = count * stable >= remaining
        h = remaining / count if last else stable
        hold = int(max(1, min(HOLD, self._held / h)))
        self._chunk = Chunk(
            self._t, h, self._now.copy(), self._powers.copy(), hold, self._fresh, self._kernel.memory
        )
        history = None
        if self.every_step:
            history = self._rows(count)
        tally = self._kernel.fly(
            self._phase,
            (self._t, h, self._now),
            steps=count,
            hold=hold,
            limits=(self._strain_limit, self._rate_limit),
            fresh=self._fresh,
            powers=self._powers,
            history=history,
        )
        self._fresh = False
        self._done = tally.steps
        whole = last and tally.steps == count
        self._t = stop if whole else self._chunk.t + tally.steps * h
        inner = []
        if history is not None:
            inner = [
                self._inner(k + 1, history[0][k], share_reported(history[1][k], 8), history[2][k])
                for k in self._rows_reported(history[0], tally)
            ]
        elif tally.peak > self._peak and tally.peak_step < tally.steps:
            inner = [self._again(tally.peak_step)[1]]
        crest = self._crest_of(tally)
        self._steps = [*sorted([*inner, *crest], key=lambda step: step.t), self._end_of(tally)]
        self._peak = max(self._peak, tally.peak, *(step.share.peak_tension for step in crest if step.share))
        self.counts["steps"] += tally.steps
        if tally.steps < count:
            self._system.rest_lengths_on_reels(
                self._places()[0], t=self._t
            )  # names the cord that is completely wound in
        self._check_energy(self._steps[-1].share)
        if tally.steps < count or self._wasteful(tally.strain, tally.rate):
            self._limit(tally.strain, tally.rate)
        self.seconds["steps"] += perf_counter() - begin
        return [self._steps[0], *(after(step, former.share) for former, step in pairwise(self._steps))]

    def output(self, t: float) -> Step:
        """The state inside the last chunk, which is recomputed up to the step that contains t."""
        begin = perf_counter()
        before = min(int((t - self._chunk.t) / self._chunk.h), self._done - 1)
        first, last = self._again(before + 1)
        inner = between(t, first, last)
        if (body := self._system.body) is not None and first.attitude is not None:
            self._system.take(State(first.t, first.y[0], first.y[1], first.yp[1], attitude=first.attitude))
            inner = inner._replace(attitude=body.attitude_at(t, *inner.y))
        self.seconds["outputs"] += perf_counter() - begin
        history = [
            step.share for step in self._steps if step.t < t
        ]  # the running balance starts afresh at each
        return after(inner, history[-1]) if history else inner

    def memory(self) -> dict[str, FloatArray]:
        """What the next chunk of steps depends on, besides y."""
        numbers = (
            self._t,
            self._strain_limit,
            self._stable,
            self._peak,
            self._rate_limit,
            self._span,
            self._look_in,
            self._stiffest,
            self._held,
            *self._guard,
        )
        return {
            "v": self._now[1].copy(),
            "a": self._now[2].copy(),
            "lengths": self._lengths,
            "numbers": np.array(numbers),
            "powers": self._powers.copy(),
            "fresh": np.array(float(self._fresh)),
            "kernel": self._kernel.memory,
        }

    def restore(self, memory: Mapping[str, FloatArray]) -> None:
        """Continue as the integrator that left this memory."""
        self._now[1], self._now[2], self._lengths = memory["v"], memory["a"], memory["lengths"].copy()
        self._fresh, self._powers = bool(memory["fresh"]), memory["powers"].copy()
        self._kernel.remember(memory["kernel"])
        numbers = memory["numbers"].tolist()
        self._t, self._strain_limit, self._stable, self._peak, self._rate_limit, self._span = numbers[:6]
        self._look_in, self._stiffest, self._held = int(numbers[6]), numbers[7], numbers[8]
        self._guard = Guard(*numbers[9:])
        self._kernel.table.watch(WOUND_IN * self._lengths)

    def _places(self) -> tuple[FloatArray, FloatArray]:
        """Positions and velocities (n, 3), as views."""
        return self._now[0].reshape(-1, 3), self._now[1].reshape(-1, 3)

    def _longest(self, h: float) -> int:
        """How many steps of length h a chunk may have."""
        longest = min(SUDDEN if self._sudden else CHUNK, max(LEAST, self._span / h))
        if self.every_step:
            longest = min(longest, KEPT_NUMBERS / self._now.size)
        return max(1, math.floor(longest))

    def _rows(self, count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Arrays for the history of `count` steps."""
        return np.empty((count, *self._now.shape)), np.empty((count, 10)), np.empty((count, 4))

    def _rows_reported(self, states: FloatArray, tally: Tally) -> Iterable[int]:
        """Rows of the history that are reported before the end of the chunk."""
        end = tally.steps - 1
        if self.scan is None:
            return range(end)
        first = self.scan(states[: tally.steps, 0].reshape(tally.steps, -1, 3))
        rows = {*range(max(0, first - 1), end)}
        if tally.peak > self._peak:
            rows |= {tally.peak_step - 1} - {end}
        return sorted(rows)

    def _again(self, count: int) -> tuple[Step, Step]:
        """Step number `count` of the last chunk and the one before it, or the chunk's start."""
        states, sums, turned = history = self._rows(min(count, 2))
        now, begun = self._kernel.memory, self._chunk.memory
        self._kernel.remember(begun)
        start = self._chunk.t, self._chunk.h, self._chunk.xva.copy()
        fresh, powers = self._chunk.fresh, self._chunk.powers.copy()
        self._kernel.fly(
            self._phase,
            start,
            steps=count,
            hold=self._chunk.hold,
            fresh=fresh,
            powers=powers,
            history=history,
        )
        self._kernel.remember(now)
        last = self._inner(count, states[-1], share_reported(sums[-1], 9), turned[-1])
        if count == 1:
            return self._inner(0, self._chunk.xva, NOTHING, begun[:4]), last
        return self._inner(count - 1, states[0], share_reported(sums[0], 9), turned[0]), last

    def _crest_of(self, tally: Tally) -> list[Step]:
        """The state of a new largest tension inside a step, if there is one, by a step of part length."""
        before = min(int(tally.crest_at), tally.steps - 1)
        part = tally.crest_at - before
        if tally.crest <= max(self._peak, tally.peak) or not 0.0 < part < 1.0:
            return []
        xva, share = self._chunk.xva.copy(), NOTHING
        if before > 0:
            state = self._again(before)[1]
            xva = np.stack((state.y[0], state.y[1], state.yp[1])).reshape(3, -1)
            share = state.share or NOTHING
        t, h = self._chunk.t + before * self._chunk.h, part * self._chunk.h
        found = self._kernel.fly(self._phase, (t, h, xva), steps=1)
        whole = sum_of(share_of(found), share)
        return [step_of(t + h, xva, whole)]

    def _inner(self, count: int, xva: FloatArray, share: Share, attitude: FloatArray) -> Step:
        """The state (3, 3n) of the kernel after `count` steps of the last chunk."""
        return self._with_target(step_of(self._chunk.t + count * self._chunk.h, xva, share), attitude)

    def _with_target(self, step: Step, attitude: FloatArray) -> Step:
        """A step as others see it: with the target's attitude, and the gyroscopic part of its acceleration."""
        body = self._system.body
        if body is None:
            return step
        step.yp[1][body.spin] += body.gyroscopic(step.y[1])
        driven = not body.pose.values.free
        return step._replace(attitude=body.attitude_at(step.t, *step.y) if driven else attitude.copy())

    def _end_of(self, tally: Tally) -> Step:
        """The end of the last chunk."""
        return self._with_target(step_of(self._t, self._now, share_of(tally)), self._kernel.memory[:4])

    # The step length

    def _look_at_rate(self) -> None:
        """Bound the step by the current tangents of the forces that have no bound."""
        if not self._boundless:
            return
        if self._look_in == 0 or self._sudden:
            self._look_in = RATES_HOLD
            t = self._phase.inside(self._t)
            rate = rate_of(self._boundless, self._system, t, *self._places())
            share = STIFF * FRACTIONS[self._options.accuracy]
            self._stiffest = share / rate if rate > 0 else math.inf
            self._held = HELD[self._options.accuracy] / rate if rate > 0 else math.inf
        self._look_in -= 1

    def _limit(self, strain: float, rate: float) -> None:
        """Set limits well above strain and rate of friction, in powers of two, and the step that is stable below."""
        floor = 0.25 * float(self._system.cables.eps.max()) or 1e-2
        limit = floor * 2.0 ** max(0, math.ceil(math.log2(max(2.0 * strain, floor) / floor)))
        rubbing = LEAST_RATE * 2.0 ** (
            0.5 * math.ceil(2 * math.log2(max(1.4 * rate, LEAST_RATE) / LEAST_RATE))
        )
        lengths = self._system.rest_lengths_on_reels(self._places()[0])
        former = self._strain_limit, self._rate_limit
        if (limit, rubbing) != former or not np.array_equal(lengths, self._lengths):
            self._strain_limit, self._rate_limit, self._lengths = limit, rubbing, lengths
            self._kernel.table.watch(WOUND_IN * lengths)
            self._stable = self._step_length(limit, rubbing if self._kernel.rubs else 0.0)
            self.counts["step_lengths"] += 1

    def _wasteful(self, strain: float, rate: float) -> bool:
        """Whether the limits lie far from what is needed."""
        if self._rate_limit > 8.0 * max(rate, LEAST_RATE):
            return True
        if self._has_toe and self._strain_limit > 16.0 * max(strain, 0.0):
            return True
        if not len(self._lengths):
            return False
        now = self._system.rest_lengths_on_reels(self._places()[0]) / self._lengths
        return bool(now.min() < 0.5 * (1 + WOUND_IN) or now.min() > 2.0)

    def _step_length(self, strain: float, rate: float) -> float:
        """The stable step while strain and rate of friction stay below these, times the fraction of the accuracy."""
        x, _ = self._places()
        stable = self._share * stable_step(self._system, strain, rate=rate, x=x)
        longest = self._options.max_step or math.inf
        return min(stable, longest) if math.isfinite(min(stable, longest)) else UNBOUND

    # Energy

    def _energy_now(self) -> float:
        x, v = self._places()
        if self._system.body is not None:
            self._system.take(State(self._t, x, v, v, attitude=self._kernel.memory[:4]))
        return self._system.kinetic_energy(v) + self._system.elastic_energy(x, t=self._t)

    def _check_energy(self, share: Share | None) -> None:
        """Raise RunError where energy has come out of nothing for several chunks, see `guard`."""
        assert share is not None
        h, a = self._chunk.h, self._now[2].reshape(-1, 3)
        self._guard = self._guard.after(
            self._energy_now(),
            0.25 * h * h * self._system.kinetic_energy(a),
            share.external_work,
            share.dissipated_energy,
            share=self._share,
            floor=self._floor,
        )
        if not math.isfinite(self._guard.rise):
            bad = np.argwhere(~np.isfinite(self._now).reshape(3, -1, 3).all(axis=(0, 2)))
            where = f" at node {bad[0, 0]}" if len(bad) else ""
            raise RunError(
                f"the run failed at t = {self._t:.9g} s: its state{where} is not finite: a force gave no number, or "
                f"the explicit step of {self._chunk.h:.3g} s is much too long"
            )
        if self._guard.stops:
            speed = np.linalg.norm(self._places()[1], axis=1)
            node = int(np.argmax(speed))
            raise RunError(
                f"the run failed at t = {self._t:.9g} s: its energy rose by {self._guard.rise:.3g} J out of nothing, "
                f"the explicit step of {self._chunk.h:.3g} s is too long; worst is node {node} with "
                f"{speed[node]:.3g} m/s. Try a smaller max_step, or method = 'ida'"
            )
