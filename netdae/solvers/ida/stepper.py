"""SUNDIALS IDA on the first-order residual, by scikit-sundae.

y = (x, v): F₁ = ẋ − v and F₂ = M v̇ − f(t, x, v), with x − x_d and v − v_d on restrained axes (index 1).
IDA is given GMRES whose preconditioner is the exact solve with the frozen Jacobian: it converges in one
iteration, which makes it a direct solver. Its product J·v may then return v unchanged, and so may the solve that
follows ("frozen" products). This relies on the order of calls solve, product, solve.

It takes any force, and is the fallback where `ida.native`, which does not pass through Python at each call, cannot be
used.
"""

from __future__ import annotations

import contextlib
import io
import logging
import math
import os
import sys
import threading
from collections import Counter, defaultdict
from collections.abc import Mapping
from time import perf_counter
from typing import ClassVar, TextIO

# SUNDIALS writes warnings to C's stderr unless this is set before its first context
os.environ.setdefault("SUNLOGGER_WARNING_FILENAME", os.devnull)

import numpy as np
from sksundae import SUNDIALS_VERSION as SUNDIALS_VERSION
from sksundae.ida import IDA, IDAJacTimes, IDAPrecond

from netdae.core.arrays import FloatArray
from netdae.core.errors import RunError
from netdae.model.restraints import Drive
from netdae.solvers.ida.failures import STANDS_STILL, STUCK, failure_of, not_finite, reason_of
from netdae.solvers.linalg.condensed import CondensedSolver
from netdae.solvers.options import HIGHEST_ORDER, SolverOptions
from netdae.solvers.stepper import Scan, Step, longest_step_of
from netdae.system.system import System

logger = logging.getLogger(__name__)

_ONE_AT_A_TIME = threading.RLock()

NEWTON_ITERATIONS = 4  # IDA's default limit in one attempt of a step
DIVERGING = 0.9  # IDA's limit of the mean ratio of successive corrections


class IdaSolver:
    """IDA with its callbacks, counters and buffers for one System; phases are entered by `enter`.

    note : why the compiled driver is not used, for the summary
    """

    COUNTS: ClassVar[tuple[str, ...]] = (
        "steps",
        "residuals",
        "setups",
        "solves",
        "newton_failures",
        "error_test_failures",
        "starts",
    )
    driver = "python"

    def __init__(self, system: System, drive: Drive, options: SolverOptions, *, note: str = "") -> None:
        self.note = note
        self._system = self._phase = system
        self._drive = drive
        self._held = drive.mask
        self._any_held = bool(drive.mask.any())
        self._mass = np.repeat(system.mass[:, None], 3, axis=1)
        self._solver = CondensedSolver(system)
        self._shape = (2, *drive.mask.shape)
        self._correction, self._first_correction = np.zeros((2, *self._shape))
        self._echo = False
        self._options = options
        rtol, atol_position, atol_velocity = options.tolerances
        self._atol = np.empty(self._shape)
        self._atol[0], self._atol[1] = atol_position, atol_velocity
        self.every_step = True
        self.scan: Scan | None = None
        self.counts: Counter[str] = Counter()
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self._attempt_t = -math.inf
        self._attempt_solves = 0
        self._t = 0.0
        true = options.products == "true"
        self._ida = IDA(
            self._residual,
            rtol=rtol,
            atol=self._atol.ravel(),
            linsolver="gmres",
            precond=IDAPrecond(self._setup, self._solve),
            jactimes=IDAJacTimes(None, self._true_product if true else self._frozen_product),
            max_order=options.max_order or HIGHEST_ORDER,
            max_step=longest_step_of(system, options),
            algebraic_idx=np.flatnonzero(np.stack((drive.mask, drive.mask))),
        )

    def enter(self, phase: System, t: float, y: FloatArray, yp: FloatArray) -> None:
        """Start afresh at t in `phase` from y = (x, v) and yp = (v, a), both (2, n, 3) and consistent."""
        self._phase, self._t = phase, t
        self._attempt_t = -math.inf
        self.counts["starts"] += 1
        with quiet():
            self._ida.init_step(t, y.ravel(), yp.ravel())

    def go_on(self, part: System) -> None:
        """Go on in the part of the phase that begins here."""
        self._phase = part

    def step(self, stop: float) -> list[Step]:
        """One internal step towards `stop`, not beyond."""
        t, y, yp, *_ = self._advance(stop, "onestep", stop)
        if t == self._t:  # after an output inside the last step IDA returns to its end first
            t, y, yp, *_ = self._advance(stop, "onestep", stop)
        self.counts["steps"] += 1
        stuck = t - self._t <= 4 * math.ulp(max(abs(t), 1e-300))
        self.counts["stuck"] = self.counts["stuck"] + 1 if stuck else 0
        if self.counts["stuck"] > STUCK:
            raise RunError(self._failure(reason_of(STANDS_STILL)))
        self._t = t
        return [self._turned(t, y, yp)]

    def _turned(self, t: float, y: FloatArray, yp: FloatArray) -> Step:
        """An accepted step, with the target's attitude, from which that of the next follows."""
        body = self._system.body
        return Step(t, y, yp, None, None if body is None else body.advance(t, *y))

    def output(self, t: float) -> Step:
        """The state inside the last step, by IDA's own polynomial."""
        inner, body = self._advance(t, "normal", None), self._system.body
        return inner if body is None else inner._replace(attitude=body.attitude_at(t, *inner.y))

    def memory(self) -> dict[str, FloatArray]:
        """Nothing: a resumed flight starts this integrator afresh."""
        return {}

    def restore(self, memory: Mapping[str, FloatArray]) -> None:
        """Nothing to restore."""

    def _advance(self, t: float, method: str, stop: float | None) -> Step:
        try:
            with quiet():
                result = self._ida.step(t, method=method, tstop=stop)
        except KeyError as error:  # scikit-sundae has no message for some of SUNDIALS' codes
            raise RunError(self._failure(f"SUNDIALS gave up with code {error}")) from error
        if not result.success:
            raise RunError(self._failure(reason_of(result.status, result.message)))
        return Step(result.t, result.y.reshape(self._shape), result.yp.reshape(self._shape))

    # Callbacks; the arrays they get are views of SUNDIALS' own memory

    def _residual(self, t, y, yp, res) -> None:  # type: ignore[no-untyped-def]
        begin = perf_counter()
        (x, v), (dx, dv) = y.reshape(self._shape), yp.reshape(self._shape)
        F = res.reshape(self._shape)
        np.subtract(dx, v, out=F[0])
        np.multiply(self._mass, dv, out=F[1])
        F[1] -= self._phase.force(t, x, v)
        if self._any_held:
            held, (x_d, v_d, _) = self._held, self._drive.at(self._phase.inside(t))
            F[0][held] = (x - x_d)[held]
            F[1][held] = (v - v_d)[held]
        if not math.isfinite(res.sum()):
            self._raise_not_finite(t, F)
        if t < self._attempt_t:
            self.counts["newton_failures" if self._diverged(y) else "error_test_failures"] += 1
        if t != self._attempt_t:
            self._attempt_t, self._attempt_solves = t, 0
        self.counts["residuals"] += 1
        self.seconds["residual"] += perf_counter() - begin

    def _setup(self, t, y, yp, res, cj) -> None:  # type: ignore[no-untyped-def]
        begin = perf_counter()
        x, v = y.reshape(self._shape)
        try:
            self._solver.setup(self._phase, t, x, v, cj)
        except RunError as error:
            raise RunError(f"the run failed at t = {t:.9g} s: {error}") from error
        if t == self._attempt_t and self._attempt_solves > 0:  # Newton failed with the previous matrix
            self.counts["newton_failures"] += 1
        self._attempt_solves = 0
        self.counts["setups"] += 1
        self.seconds["setup"] += perf_counter() - begin

    def _solve(self, t, y, yp, res, rvec, zvec, cj, delta) -> None:  # type: ignore[no-untyped-def]
        if self._echo:
            self._echo = False
            zvec[:] = rvec
            return
        begin = perf_counter()
        (r1, r2), (dx, dv) = rvec.reshape(self._shape), zvec.reshape(self._shape)
        self._solver.solve(r1, r2, cj, dx, dv)
        self._correction[:] = zvec.reshape(self._shape)
        if self._attempt_solves == 0:
            self._first_correction[:] = self._correction
        self._attempt_solves += 1
        self.counts["solves"] += 1
        self.seconds["solve"] += perf_counter() - begin

    def _frozen_product(self, t, y, yp, res, vec, Jv, cj) -> None:  # type: ignore[no-untyped-def]
        Jv[:] = vec
        self._echo = True

    def _true_product(self, t, y, yp, res, vec, Jv, cj) -> None:  # type: ignore[no-untyped-def]
        (x, v), (dx, dv), J = y.reshape(self._shape), vec.reshape(self._shape), Jv.reshape(self._shape)
        J[0] = cj * dx - dv
        J[1] = cj * self._mass * dv - self._phase.tangent_product(t, x, v, dx, dv)
        J[0][self._held] = dx[self._held]
        J[1][self._held] = dv[self._held]

    # Failures

    def _diverged(self, y: FloatArray) -> bool:
        """Whether the attempt that IDA steps back from failed in Newton's iteration, by IDA's own criteria."""
        iterations = self._attempt_solves - 1
        if iterations < 1:
            return False
        if self._attempt_solves >= NEWTON_ITERATIONS:
            return True
        weight = 1.0 / (self._options.tolerances[0] * np.abs(y.reshape(self._shape)) + self._atol)
        last, first = (np.linalg.norm(d * weight) for d in (self._correction, self._first_correction))
        return bool(last > DIVERGING**iterations * first)

    def _raise_not_finite(self, t: float, F: FloatArray) -> None:
        raise RunError(not_finite(t, np.argwhere(~np.isfinite(F))[0]))

    def _failure(self, reason: str) -> str:
        weighted = np.abs(self._correction) / self._atol  # of the last Newton correction
        return failure_of(self._system, self._t, reason, weighted, self._options.tolerances[0])


class _Filter(io.TextIOBase):
    """Passes text on, except SUNDIALS' error messages, which scikit-sundae prints: they go to the log."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._swallowed = False

    def write(self, text: str) -> int:
        if ", Error: " in text:
            logger.debug("SUNDIALS: %s", text.strip())
            self._swallowed = True
        elif not (self._swallowed and text == "\n"):
            self._stream.write(text)
        else:
            self._swallowed = False
        return len(text)

    def flush(self) -> None:
        self._stream.flush()


def quiet() -> contextlib.AbstractContextManager[object]:
    """Send text of SUNDIALS to the log; one thread at a time, since all threads share standard output."""
    stack = contextlib.ExitStack()
    stack.enter_context(_ONE_AT_A_TIME)
    stack.enter_context(contextlib.redirect_stdout(_Filter(sys.stdout)))
    return stack
