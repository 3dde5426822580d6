"""SUNDIALS CVODE in place of IDA, for comparison: BDF with plain GMRES, or Adams, as in `scipy_methods`."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping
from time import perf_counter
from typing import ClassVar

import numpy as np
from sksundae.cvode import CVODE

from netdae.core.arrays import FloatArray
from netdae.core.errors import RunError
from netdae.model.restraints import Drive
from netdae.solvers.ida.quiet import quiet
from netdae.solvers.options import SolverOptions
from netdae.solvers.scipy_methods import FirstOrder
from netdae.solvers.stepper import Scan, Step, longest_step_of
from netdae.system.system import System

FAMILIES = {"cvode_bdf": "BDF", "cvode_adams": "Adams"}


class CvodeSolver:
    """CVODE for one System, step by step."""

    COUNTS: ClassVar[tuple[str, ...]] = ("steps", "residuals", "starts")

    def __init__(self, system: System, drive: Drive, options: SolverOptions) -> None:
        self._problem = FirstOrder(system, drive)
        self._options = options
        rtol, atol_position, atol_velocity = options.tolerances
        self._shape = (2, system.net.node_count, 3)
        atol = np.empty(self._shape)
        atol[0], atol[1] = atol_position, atol_velocity
        self._cvode = CVODE(
            self._rate,
            method=FAMILIES[options.method],
            rtol=rtol,
            atol=atol.ravel(),
            linsolver="gmres",
            max_step=longest_step_of(system, options),
        )
        self._t = 0.0
        self.every_step = True
        self.scan: Scan | None = None
        self.counts: Counter[str] = Counter()
        self.seconds: defaultdict[str, float] = defaultdict(float)

    def _rate(self, t, y, yp) -> None:  # type: ignore[no-untyped-def]
        self.counts["residuals"] += 1
        yp[:] = self._problem.finite_rate(t, y)

    def enter(self, phase: System, t: float, y: FloatArray, yp: FloatArray) -> None:
        """Start afresh at t in a phase."""
        self._problem.phase, self._t = phase, t
        self.counts["starts"] += 1
        with quiet():
            self._cvode.init_step(t, y.ravel())

    def go_on(self, part: System) -> None:
        """Go on in the part of the phase that begins here."""
        self._problem.phase = part

    def step(self, stop: float) -> list[Step]:
        """One internal step towards `stop`, not beyond."""
        begin = perf_counter()
        step = self._advance(stop, "onestep", stop)
        if step.t == self._t:  # after an output inside the last step CVODE returns to its end first
            step = self._advance(stop, "onestep", stop)
        self._t = step.t
        self.counts["steps"] += 1
        self.seconds["steps"] += perf_counter() - begin
        body = self._problem.phase.body
        return [step if body is None else step._replace(attitude=body.advance(step.t, *step.y))]

    def output(self, t: float) -> Step:
        """The state inside the last step, from CVODE's own polynomial."""
        inner, body = self._advance(t, "normal", None), self._problem.phase.body
        return inner if body is None else inner._replace(attitude=body.attitude_at(t, *inner.y))

    def memory(self) -> dict[str, FloatArray]:
        """Nothing: a resumed flight starts this integrator afresh."""
        return {}

    def restore(self, memory: Mapping[str, FloatArray]) -> None:
        """Nothing to restore."""

    def _advance(self, t: float, method: str, stop: float | None) -> Step:
        with quiet():
            result = self._cvode.step(t, method=method, tstop=stop)
        if not result.success:
            raise RunError(
                f"the run failed at t = {self._t:.9g} s: {result.message} "
                f"Try {self._options.finer()}, or another method"
            )
        yp = self._problem.finite_rate(result.t, result.y)
        return Step(result.t, result.y.reshape(self._shape), yp.reshape(self._shape))
