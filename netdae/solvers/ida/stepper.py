"""SUNDIALS IDA on the first-order residual, by scikit-sundae.

y = (x, v): F₁ = ẋ − v and F₂ = M v̇ − f(t, x, v), with x − x_d and v − v_d on restrained axes (index 1).
IDA is given GMRES whose preconditioner is the exact solve with the frozen Jacobian: it converges in one
iteration, which makes it a direct solver. Its product J·v may then return v unchanged, and so may the solve that
follows ("frozen" products). This relies on the order of calls solve, product, solve.

It takes any force, and is the fallback where `ida.native`, which does not pass through Python at each call, cannot be
used.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping
from time import perf_counter
from typing import Any, ClassVar

import numpy as np
from sksundae import SUNDIALS_VERSION as SUNDIALS_VERSION
from sksundae.ida import IDA, IDAJacTimes, IDAPrecond

from netdae.core.arrays import FloatArray
from netdae.core.errors import RunError
from netdae.model.restraints import Drive
from netdae.solvers.ida.failures import STANDS_STILL, STUCK, failure_of, not_finite, reason_of
from netdae.solvers.ida.iteration import Iteration
from netdae.solvers.ida.polish import Polish
from netdae.solvers.ida.quiet import quiet
from netdae.solvers.ida.taut import LOW_ORDER, SETTLING, TIGHT, is_undamped, warnings_of
from netdae.solvers.options import HIGHEST_ORDER, SolverOptions
from netdae.solvers.stepper import Scan, Step, longest_step_of
from netdae.system.system import System

NEWTON_ITERATIONS = 4  # IDA's default limit in one attempt of a step
NEWTON_TOLERANCE = 0.33  # IDA's limit of the norm of Newton's corrections
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
        self._iteration = Iteration(system, self._residual_at, self._counted)
        self._polish = Polish(system, options.tolerances[1])
        self._shape = (2, *drive.mask.shape)
        self._correction, self._first_correction = np.zeros((2, *self._shape))
        self._echo = self._refuses = self._each = False
        self._options = options
        _, atol_position, atol_velocity = options.tolerances
        self._atol = np.empty(self._shape)
        self._atol[0], self._atol[1] = atol_position, atol_velocity
        self.every_step = True
        self.scan: Scan | None = None
        self.counts: Counter[str] = Counter()
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self._attempt_t = -math.inf
        self._attempt_solves = 0
        self._t = 0.0
        self._frozen = options.products == "frozen"
        self._idas: dict[tuple[int, float], Any] = {}
        self._refused = np.random.default_rng(0)
        self._longest = longest_step_of(system, options)

    def _ida_for(self, order: int, strict: float) -> Any:
        """IDA with a highest order, and tolerances so many times as strict."""
        found = self._idas.get((order, strict))
        if found is None:
            atol = self._atol / strict
            if strict > 1.0:  # the error test cannot be spared what is stiff in velocities, see `taut`
                atol[1] = self._atol[1]
            product = self._frozen_product if self._frozen else self._true_product
            found = self._idas[order, strict] = IDA(
                self._residual,
                rtol=self._options.tolerances[0] / strict,
                atol=atol.ravel(),
                linsolver="gmres",
                precond=IDAPrecond(self._setup, self._solve),
                jactimes=IDAJacTimes(None, product),
                max_order=order,
                max_step=self._longest,
                algebraic_idx=np.flatnonzero(np.stack((self._held, self._held))),
            )
        return found

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a user should know about the figures."""
        rtol = self._options.tolerances[0]
        return warnings_of(self.counts["steps"], self.counts["free_steps"], self.driver, rtol)

    def enter(self, phase: System, t: float, y: FloatArray, yp: FloatArray) -> None:
        """Start afresh at t in `phase` from y = (x, v) and yp = (v, a), both (2, n, 3) and consistent."""
        self._phase, self._t = phase, t
        self.counts["starts"] += 1
        self._damped = self._iteration.enter(phase, y[0])
        self._polish.stiffest = float(self._damped.kappa[0])
        # without any dashpot on taut cables, a start with looser tolerances would only make waves
        bare = self._damped.kappa[0] > 0.0 and self._damped.tau[-1] == 0.0
        taut = self._damped.kappa[0] > 0.0 and self._system.peak_tension(y[0]) > 0.0
        self._low = bool(bare and taut)
        self._undamped, self._begun = 2 if self._low else 0, not bool(taut)
        self._iteration.free, self._polish.wanted = self._frozen and self._low, self._low
        self._state = y, yp
        self._h, self._earlier, self._last = 0.0, (t, yp[1].copy()), (t, yp[1].copy())
        self._start(t, y, yp)

    def _start(self, t: float, y: FloatArray, yp: FloatArray) -> None:
        """Start IDA afresh at t, with the order and the tolerances that the steps so far ask for."""
        self._attempt_t = -math.inf
        with quiet():
            self._ida = self._ida_for(*self._wanted)
            self._ida.init_step(t, y.ravel(), yp.ravel())
        self._in_use = self._wanted
        self._since = 0

    @property
    def _wanted(self) -> tuple[int, float]:
        """The highest order, and how many times as strict tolerances."""
        order = self._options.max_order or HIGHEST_ORDER
        if not self._low and (self._begun or self._damped.kappa[0] == 0.0):
            return order, 1.0
        return min(order, LOW_ORDER), TIGHT if self._low and self._undamped > 1 else 1.0

    def go_on(self, part: System) -> None:
        """Go on in the part of the phase that begins here."""
        self._phase = part
        self._iteration.go_on(part)

    def step(self, stop: float) -> list[Step]:
        """One internal step towards `stop`, not beyond."""
        if self._wanted != self._in_use:
            self._start(self._t, *self._state)
        t, y, yp, *_ = self._advance(stop, "onestep", stop)
        if t == self._t:  # after an output inside the last step IDA returns to its end first
            t, y, yp, *_ = self._advance(stop, "onestep", stop)
        self.counts["steps"] += 1
        stuck = t - self._t <= 4 * math.ulp(max(abs(t), 1e-300))
        self.counts["stuck"] = self.counts["stuck"] + 1 if stuck else 0
        if self.counts["stuck"] > STUCK:
            raise RunError(self._failure(reason_of(STANDS_STILL)))
        self._h, self._t, self._state = t - self._t, t, (y, yp)
        self._judge(y[0])
        self._earlier, self._last, before = self._last, (t, yp[1]), (self._earlier, self._last)
        step = self._turned(t, y, yp)
        return [self._polish.stopped(self._phase, step, *before) if t == stop else step]

    def _judge(self, x: FloatArray) -> None:
        """Find whether cables vibrate undamped in steps as long as the last, see `taut`."""
        self._since += 1
        self.counts["free_steps"] += 1 if self._low and self._undamped > 1 else 0
        if self._since < SETTLING:  # a start is no judge: its steps are short
            return
        self._undamped = is_undamped(self._undamped, self._h, self._damped.kappa, self._damped.tau)
        self._low = self._undamped > 0 and (self._low or self._system.peak_tension(x) > 0.0)
        self._begun = True
        self._iteration.free = self._frozen and self._undamped > 1
        self._polish.wanted = self._undamped > 1

    def _turned(self, t: float, y: FloatArray, yp: FloatArray) -> Step:
        """An accepted step, with the target's attitude, from which that of the next follows."""
        body = self._system.body
        return Step(t, y, yp, None, None if body is None else body.advance(t, *y))

    def output(self, t: float) -> Step:
        """The state inside the last step, by IDA's own polynomial."""
        inner, body = self._advance(t, "normal", None), self._system.body
        if body is not None:
            inner = inner._replace(attitude=body.attitude_at(t, *inner.y))
        return self._polish.between(self._phase, inner, self._h)

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
        self._refuses = False
        F = res.reshape(self._shape)
        F[:] = self._residual_at(t, y.reshape(self._shape), yp.reshape(self._shape))
        if t < self._attempt_t:
            self.counts["newton_failures" if self._diverged(y) else "error_test_failures"] += 1
        if t != self._attempt_t:
            self._attempt_t, self._attempt_solves = t, 0
        self.seconds["residual"] += perf_counter() - begin

    def _residual_at(self, t: float, y: FloatArray, yp: FloatArray) -> FloatArray:
        """F (2, n, 3)."""
        (x, v), (dx, dv), F = y, yp, np.empty(self._shape)
        np.subtract(dx, v, out=F[0])
        np.multiply(self._mass, dv, out=F[1])
        F[1] -= self._phase.force(t, x, v)
        if self._any_held:
            held, (x_d, v_d, _) = self._held, self._drive.at(self._phase.inside(t))
            F[0][held] = (x - x_d)[held]
            F[1][held] = (v - v_d)[held]
        if not math.isfinite(F.sum()):
            self._raise_not_finite(t, F)
        self.counts["residuals"] += 1
        return F

    def _setup(self, t, y, yp, res, cj) -> None:  # type: ignore[no-untyped-def]
        begin = perf_counter()
        self._factored(t, self._iteration.setup, y.reshape(self._shape), cj)
        if t == self._attempt_t and self._attempt_solves > 0:  # Newton failed with the previous matrix
            self.counts["newton_failures"] += 1
        self._attempt_solves = 0
        self.seconds["setup"] += perf_counter() - begin

    def _solve(self, t, y, yp, res, rvec, zvec, cj, delta) -> None:  # type: ignore[no-untyped-def]
        if self._echo or self._refuses:
            self._echo = False
            zvec[:] = rvec
            return
        begin = perf_counter()
        r, z, at = (each.reshape(self._shape) for each in (rvec, zvec, y))
        if self._frozen and self._attempt_solves == 0:
            self._each = self._factored(t, self._iteration.begin, at, cj)
        if self._frozen and self._each:
            weight = 1.0 / (self._options.tolerances[0] * np.abs(at) + self._atol)
            slope = yp.reshape(self._shape)
            total = self._factored(t, self._iteration.iterate, at, slope, r, cj, weight, NEWTON_TOLERANCE)
            self._refuses = total is None
            z[:] = r if total is None else total
        else:
            self._iteration.solve(r, cj, z)
        self._correction[:] = z
        if self._attempt_solves == 0:
            self._first_correction[:] = self._correction
        self._attempt_solves += 1
        self.seconds["solve"] += perf_counter() - begin

    def _frozen_product(self, t, y, yp, res, vec, Jv, cj) -> None:  # type: ignore[no-untyped-def]
        if self._refuses:  # noise, with which GMRES finds no solution: IDA then takes a shorter step
            Jv[:] = self._refused.standard_normal(Jv.size)
            return
        Jv[:] = vec
        self._echo = True

    def _true_product(self, t, y, yp, res, vec, Jv, cj) -> None:  # type: ignore[no-untyped-def]
        (x, v), (dx, dv), J = y.reshape(self._shape), vec.reshape(self._shape), Jv.reshape(self._shape)
        J[0] = cj * dx - dv
        J[1] = cj * self._mass * dv - self._phase.tangent_product(t, x, v, dx, dv)
        J[0][self._held] = dx[self._held]
        J[1][self._held] = dv[self._held]

    def _factored(self, t: float, action: Callable[..., Any], *arguments: Any) -> Any:
        """The result of an action at t that factors the matrix."""
        try:
            return action(t, *arguments)
        except RunError as error:
            text = str(error)
            told = text.startswith("at t = ")
            raise RunError(text if told else f"the run failed at t = {t:.9g} s: {text}") from error

    def _counted(self, name: str) -> None:
        self.counts[name] += 1

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
