"""IDA with compiled callbacks, for all forces of the table; those written in Python are callbacks in it.

`stepper.IdaSolver` goes through scikit-sundae and so through Python three times per Newton iteration; this one puts
compiled functions into the same library and takes whole chunks of steps without Python. It solves the same equations
with the same formulas and tolerances. Measured on the reference flight at standard accuracy: 17 times faster with
11 × 11 knots, 8 times with 21 × 21, 7 times with 41 × 41; scripts/closing_*.toml 13 to 18 times, a tether in orbit 6
times, a fall through air 8 times, a load that is a Python function 3 times. `ida_stepper` uses it where it can.
"""

from __future__ import annotations

import logging
import weakref
from collections import Counter, defaultdict
from collections.abc import Mapping
from functools import cache
from time import perf_counter
from typing import ClassVar, cast

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import RunError
from netdae.forces.elements import ElementForce
from netdae.forces.pose import TURN
from netdae.model.restraints import Drive
from netdae.solvers.ida import chunk as ida_chunk
from netdae.solvers.ida.failures import WOUND_IN, failure_of, not_finite, reason_of
from netdae.solvers.ida.kernel import RATES
from netdae.solvers.ida.memory import IdaMemory
from netdae.solvers.ida.newton import SINGULAR_DYADS
from netdae.solvers.ida.polish import End, Polish
from netdae.solvers.ida.record import IdaRecord
from netdae.solvers.ida.sundials import Unavailable, sundials
from netdae.solvers.ida.taut import warnings_of
from netdae.solvers.ida.trial import check_agreement
from netdae.solvers.options import SolverOptions
from netdae.solvers.stepper import Scan, Share, Step, Stepper
from netdae.system.system import System

logger = logging.getLogger(__name__)

_COUNTED = {
    "residuals": "residuals",
    "setups": "setups",
    "solves": "solves",
    "newton_failures": "newton_failed",
    "free_steps": "free",
}

# Watchers see the ends of chunks and each new largest tension. With 64 steps they take 4 % of the time of a
# 21 x 21 net, as against 290 % with one; mouth areas agree to 5 digits, the quantile of tension to a tenth.
CHUNK = 64  # steps in a chunk
SPAN = 1e-3  # s, the longest chunk unless its only step is longer: no history misses what takes longer
CHUNK_MEMORY = 16e6  # bytes, at most, of a chunk's states


def ida_stepper(system: System, drive: Drive, options: SolverOptions) -> Stepper:
    """The compiled driver if it knows all forces and the library is available, else `ida.stepper.IdaSolver`."""
    note = ""
    if options.products == "frozen":  # else the other one is wanted, as a check
        try:
            check_knows(system)
            _check_library()
            return NativeIda(system, drive, options)
        except Unavailable as reason:
            note = f"IDA was driven from Python, which takes 3 to 17 times as long: {reason}"
            logger.info(note)
    from netdae.solvers.ida.stepper import IdaSolver  # scikit-sundae is slow to load

    return cast(Stepper, IdaSolver(system, drive, options, note=note))


@cache
def _check_library() -> None:
    """Raise Unavailable where the compiled driver cannot be trusted with the library found."""
    check_agreement(NativeIda)


def check_knows(system: System) -> None:
    """Raise Unavailable for a force that the compiled driver does not take: one with links, written in Python."""
    for force in system.forces:
        if force.newton == "links" and not isinstance(force, ElementForce):
            raise Unavailable(f"{type(force).__name__} has links and is written in Python: write it as a Law")


class NativeIda:
    """IDA's compiled driver for one System; bit-for-bit repeatable."""

    COUNTS: ClassVar[tuple[str, ...]] = (
        "steps",
        "residuals",
        "setups",
        "solves",
        "newton_failures",
        "error_test_failures",
        "starts",
    )
    driver = "compiled"
    note = ""

    def __init__(self, system: System, drive: Drive, options: SolverOptions) -> None:
        library = sundials()
        self._system = system
        self._meets = system.body is not None or bool(system.obstacles)
        self._options = options
        self._size = 6 * system.net.node_count
        self._rows = int(max(1, min(CHUNK, CHUNK_MEMORY / (16 * self._size))))
        self._record = IdaRecord(system, drive, options, self._rows)
        self._chunk = self._record.chunk
        self._memory = IdaMemory(library, self._record, options)
        weakref.finalize(self, self._memory.free)
        self._polish = Polish(system, options.tolerances[1])
        self._part = system
        self._earlier: End = 0.0, np.zeros((system.net.node_count, 3))  # of the step before the last
        self._row = 0
        self._peak = 0.0
        self._reported = [0, 0]  # rows of the last chunk that were reported
        self._failed: BaseException | None = None
        self._t = 0.0
        self.every_step = False
        self.scan: Scan | None = None
        self._failed_before = 0
        self._bound = options.max_step or np.inf
        self.counts: Counter[str] = Counter()
        self.seconds: defaultdict[str, float] = defaultdict(float)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a user should know about the figures."""
        rtol = self._options.tolerances[0]
        return warnings_of(self.counts["steps"], self.counts["free_steps"], self.driver, rtol)

    def enter(self, phase: System, t: float, y: FloatArray, yp: FloatArray) -> None:
        """Start afresh at t in `phase` from y = (x, v) and yp = (v, a), both (2, n, 3) and consistent."""
        chunk = self._chunk
        self._row, self._t, self._earlier = 0, t, (t, yp[1])
        chunk.times[0] = chunk.clock[0] = t
        chunk.states[0], chunk.slopes[0] = y.ravel(), yp.ravel()
        self._record.set(stuck=0)
        self._polish.stiffest, self._polish.wanted = self._record.enter(phase, y[0]), False
        if (body := self._system.body) is not None:
            chunk.attitudes[0] = body.pose.values.base[:4]
            self._record.set(made=0)
            ida_chunk.begin_attitude(self._record.address)
        taut = self._polish.stiffest > 0.0 and self._system.peak_tension(y[0]) > 0.0
        self._memory.start(t, taut)
        self._failed_before = self._record["errors_failed"]
        self.counts["starts"] += 1
        self.go_on(phase)

    def go_on(self, part: System) -> None:
        """Go on in the part of the phase that begins here, in which loads and motions are linear in time."""
        self._part = part
        self._record.go_on(part, self._t)
        ida_chunk.begin_rates(self._record.address, self._row)

    def step(self, stop: float) -> list[Step]:
        """A chunk of internal steps towards `stop`: its end, and before it those around a new largest tension."""
        begin = perf_counter()
        if self._failed is not None:
            raise self._failed
        self._memory.stop_at(stop)
        count = 1 if self.every_step and self.scan is None else self._rows
        self._bound_turn()
        code = ida_chunk.fly(self._record.address, self._row, count, stop, SPAN)
        made = self._row = int(self._record["made"])
        self._count_up()
        self.counts["steps"] += made
        self._t = float(self._chunk.times[made])
        error = self._record.table.error
        if error is not None or code < 0:
            self._failed = error or self._error(code, made)
            if made == 0 or not isinstance(self._failed, Exception):
                raise self._failed
        steps = self._report(made)
        self._polish.wanted = self._record["undamped"] > 1
        if self._t == stop:
            earlier = self._end_of(made - 2) if made > 1 else self._earlier
            steps[-1] = self._polish.stopped(self._part, steps[-1], earlier, self._end_of(made - 1))
        self._earlier = self._end_of(made - 1)
        self.seconds["steps"] += perf_counter() - begin
        return steps

    def _bound_turn(self) -> None:
        """Let no step turn the target by more than `TURN`, on which its attitude relies."""
        if self._record.pose is None:
            return
        pose, at = self._record.pose.values, self._size // 2 + self._record.spin
        spin = float(np.linalg.norm(self._chunk.states[self._row][at : at + 3] / pose.rho))
        longest = self._options.max_step or np.inf
        # in powers of two, so that it changes rarely
        bound = min(longest, TURN * 2.0 ** -np.ceil(np.log2(spin)) if spin > 0 else np.inf)
        if bound != self._bound:
            self._bound = bound
            self._memory.bound_step(bound)

    def _report(self, made: int) -> list[Step]:
        """The end of a chunk, and before it a new largest tension and the steps beside it: it may last one step.

        With a target or obstacles it is every step, since a touch lasts few of them.
        """
        tensions = self._chunk.tensions
        best = int(tensions[1 : made + 1].argmax()) + 1
        rows = {0, made}
        if tensions[best] > self._peak:
            self._peak = float(tensions[best])
            rows |= {row for row in (best - 1, best, best + 1) if 0 < row < made}
        if self._meets:
            rows |= {*range(1, made)}
        if self.every_step and self.scan is not None:
            places = self._chunk.states[1 : made + 1, : self._size // 2].reshape(made, -1, 3)
            rows |= {*range(max(1, self.scan(places)), made)}
        self._reported = sorted(rows)
        return [
            Step(
                float(self._chunk.times[row]),
                *self._row_of(row),
                self._share_up_to(self._chunk.sums[row], k),
                None if self._record.pose is None else self._chunk.attitudes[row].copy(),
            )
            for k, row in enumerate(self._reported)
            if row > 0
        ]

    def _share_up_to(self, balance: FloatArray, k: int, row: int | None = None) -> Share:
        """What the balance gains since the step reported before number k, with the largest tension up to `row`."""
        first = self._reported[k - 1]
        gained = balance - self._chunk.sums[first]
        peak = self._chunk.tensions[first + 1 : (self._reported[k] if row is None else row) + 1].max(
            initial=0.0
        )
        return Share(float(gained[0]), float(gained[1]), gained[2:5], float(peak), gained[5:8])

    def output(self, t: float) -> Step:
        """The state inside the last chunk, by cubics from step to step."""
        begin = perf_counter()
        times = self._chunk.times[: self._row + 1]
        row = min(max(int(np.searchsorted(times, t, side="right")) - 1, 0), self._row - 1)
        out, balance = np.empty(3 * self._size // 2), np.empty(RATES)
        attitude = np.empty(4)
        ida_chunk.inside(self._record.address, row, t, out, balance, attitude)
        if (error := self._record.table.error) is not None:
            raise error
        whole = out.reshape(3, -1, 3)
        k = max(1, int(np.searchsorted(times[self._reported], t)))
        self.seconds["outputs"] += perf_counter() - begin
        turned = None if self._record.pose is None else attitude
        step = Step(t, whole[:2], whole[1:], self._share_up_to(balance, k, row), turned)
        return self._polish.between(self._part, step, float(times[row + 1] - times[row]))

    def _end_of(self, row: int) -> End:
        """Time and v̇ (n, 3) in a row of the chunk."""
        return float(self._chunk.times[row]), self._chunk.slopes[row, self._size // 2 :].reshape(-1, 3).copy()

    def memory(self) -> dict[str, FloatArray]:
        """Nothing: a resumed flight starts this integrator afresh."""
        return {}

    def restore(self, memory: Mapping[str, FloatArray]) -> None:
        """Nothing to restore."""

    def _row_of(self, row: int) -> tuple[FloatArray, FloatArray]:
        """(x, v) and (v, a), (2, n, 3), of a row of the chunk: two views of one copy."""
        whole = np.empty((3, self._size // 6, 3))
        flat = whole.reshape(-1)
        flat[: self._size] = self._chunk.states[row]
        flat[self._size :] = self._chunk.slopes[row][self._size // 2 :]
        return whole[:2], whole[1:]

    def _count_up(self) -> None:
        """Add the record's counts since the last call."""
        for name, counted in _COUNTED.items():
            self.counts[name] += self._record.take(counted)
        failed = self._record["errors_failed"] + self._record["failed_earlier"]
        self.counts["error_test_failures"] += failed - self._failed_before
        self._failed_before = failed

    def _error(self, code: int, made: int) -> RunError:
        if code == WOUND_IN:
            t, (x, v) = float(self._chunk.times[made + 1]), self._row_of(made + 1)[0]
            try:
                self._system.account(t, x, v)
            except RunError as error:  # the cord's own message
                return error
        return RunError(self._failure(code))

    def _failure(self, code: int) -> str:
        record, n = self._record, self._size // 6
        if (bad := record["not_finite"]) >= 0:
            return not_finite(record["not_finite_at"], np.unravel_index(bad, (2, n, 3)))
        if (node := record["singular"]) != -1:
            what = "by its cords: nothing holds them"
            if node != SINGULAR_DYADS:
                what = f"at node {node}: nothing holds it"
            reason = f"the Newton matrix is singular {what}"
            return f"the run failed at t = {self._t:.9g} s: {reason}"
        rtol, atol_position, atol_velocity = self._options.tolerances
        correction = np.abs(self._chunk.z).reshape(2, n, 3)  # Newton's last
        weighted = correction / np.array([atol_position, atol_velocity])[:, None, None]
        return failure_of(self._system, self._t, reason_of(code), weighted, rtol)
