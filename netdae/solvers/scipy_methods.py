"""SciPy's integrators in place of IDA, for comparison: the explicit first-order form ẏ = (v, f/M), y = (x, v).

Restrained axes follow ẋ = v_d, v̇ = a_d, so that they drift within the tolerance; States show x_d and v_d.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping
from time import perf_counter
from typing import Any, ClassVar

import numpy as np
from scipy import integrate, sparse

from netdae.core.arrays import FloatArray
from netdae.core.errors import RunError
from netdae.model.restraints import Drive
from netdae.solvers.linalg.condensed import whole_tangents
from netdae.solvers.options import SolverOptions
from netdae.solvers.stepper import Scan, Step
from netdae.system.system import System

SOLVERS = {
    "rk45": integrate.RK45,
    "dop853": integrate.DOP853,
    "radau": integrate.Radau,
    "bdf": integrate.BDF,
    "lsoda": integrate.LSODA,
}


class FirstOrder:
    """Right-hand side and Jacobian of the net as an initial value problem; y flat (6n,)."""

    def __init__(self, system: System, drive: Drive) -> None:
        self.phase = system
        self._drive = drive
        self._shape = (2, system.net.node_count, 3)
        self._any_held = bool(drive.mask.any())

    def rate(self, t: float, y: FloatArray) -> FloatArray:
        """ẏ (6n,); not finite in a trial step that is much too long, which most methods then shorten."""
        x, v = y.reshape(self._shape)
        a_d = None
        if self._any_held:
            _, v_d, a_d = self._drive.at(self.phase.inside(t))
            v = np.where(self._drive.mask, v_d, v)
        with np.errstate(over="ignore", invalid="ignore"):
            return np.stack((v, self.phase.acceleration(t, x, v, a_d))).ravel()

    def finite_rate(self, t: float, y: FloatArray) -> FloatArray:
        """ẏ (6n,); raises RunError where it is not finite."""
        ydot = self.rate(t, y)
        if not np.isfinite(ydot).all():
            raise RunError(f"the run failed at t = {t:.9g} s: an acceleration is not finite")
        return ydot

    def jacobian(self, t: float, y: FloatArray) -> sparse.csc_matrix:
        """∂ẏ/∂y (6n, 6n)."""
        x, v = y.reshape(self._shape)
        system = self.phase
        dx, dv = whole_tangents(system, t, x, v)
        free = ~system.restrained.ravel()
        share = np.zeros(len(free))
        share[free] = 1.0 / np.repeat(system.mass, 3)[free]
        M = sparse.diags_array(share)
        return sparse.block_array([[None, sparse.diags_array(free * 1.0)], [M @ dx, M @ dv]], format="csc")


class IvpSolver:
    """One of SciPy's integrators for one System, step by step."""

    COUNTS: ClassVar[tuple[str, ...]] = ("steps", "residuals", "setups", "starts")

    def __init__(self, system: System, drive: Drive, options: SolverOptions) -> None:
        self._problem = FirstOrder(system, drive)
        self._options = options
        rtol, atol_position, atol_velocity = options.tolerances
        shape = (2, system.net.node_count, 3)
        atol = np.stack((np.full(shape[1:], atol_position), np.full(shape[1:], atol_velocity))).ravel()
        self._settings: dict[str, Any] = {"rtol": rtol, "atol": atol, "max_step": options.max_step or np.inf}
        if options.method in ("radau", "bdf"):
            self._settings["jac"] = self._problem.jacobian
        self._shape = shape
        self._solver: Any = None
        self.every_step = True
        self.scan: Scan | None = None
        self.counts: Counter[str] = Counter()
        self.seconds: defaultdict[str, float] = defaultdict(float)

    def enter(self, phase: System, t: float, y: FloatArray, yp: FloatArray) -> None:
        """Start afresh at t in a phase."""
        self._problem.phase = phase
        self._begin = t, y.ravel().copy()
        self._solver = None
        self.counts["starts"] += 1

    def go_on(self, part: System) -> None:
        """Go on in the part of the phase that begins here: with a new start, since SciPy stops only at its bound."""
        self._problem.phase = part
        if self._solver is not None:
            self._begin = self._solver.t, self._solver.y.copy()
            self._solver = None

    def step(self, stop: float) -> list[Step]:
        """One internal step towards `stop`, not beyond."""
        begin = perf_counter()
        if self._solver is None:
            t, y = self._begin
            method = self._options.method
            rate = self._problem.finite_rate if method == "lsoda" else self._problem.rate
            self._solver = SOLVERS[method](rate, t, y, stop, **self._settings)
        solver, body = self._solver, self._problem.phase.body
        if body is not None:
            solver.max_step = min(
                self._settings["max_step"], body.longest_step(solver.y.reshape(self._shape)[1])
            )
        evaluations, setups = solver.nfev, solver.njev
        message = solver.step()
        if message is not None:
            raise RunError(
                f"the run failed at t = {solver.t:.9g} s: {message} "
                f"Try {self._options.finer()}, or another method"
            )
        self.counts["steps"] += 1
        self.counts["residuals"] += solver.nfev - evaluations
        self.counts["setups"] += solver.njev - setups
        self.seconds["steps"] += perf_counter() - begin
        step = self._reported(solver.t, solver.y)
        return [step if body is None else step._replace(attitude=body.advance(step.t, *step.y))]

    def output(self, t: float) -> Step:
        """The state inside the last step, by the method's own polynomial."""
        inner, body = self._reported(t, self._solver.dense_output()(t)), self._problem.phase.body
        return inner if body is None else inner._replace(attitude=body.attitude_at(t, *inner.y))

    def memory(self) -> dict[str, FloatArray]:
        """Nothing: a resumed flight starts this integrator afresh."""
        return {}

    def restore(self, memory: Mapping[str, FloatArray]) -> None:
        """Nothing to restore."""

    def _reported(self, t: float, y: FloatArray) -> Step:
        return Step(
            float(t), y.reshape(self._shape).copy(), self._problem.finite_rate(t, y).reshape(self._shape)
        )
