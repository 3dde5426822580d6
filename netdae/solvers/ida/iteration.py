"""Newton's iteration of the driver from Python, inside what IDA takes for one solve with its preconditioner.

The rules are those of `taut`: a new factor where a cable has turned, and one at each iterate where cables are stiff.
There the solve returns the sum of all corrections, or fails. IDA's rate of convergence is then near zero, and until its
next setup or change of c_j it would take any correction of the frozen matrix for the last: so it is `spoilt`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import RunError
from netdae.forces.elements import ElementForce
from netdae.solvers.ida.taut import CONVERGED, ITERATIONS, STIFF, Damped, damped_of, has_turned, stiffness_of
from netdae.solvers.linalg.condensed import CondensedSolver
from netdae.system.net_forces import coupled_by
from netdae.system.system import System

Residual = Callable[[float, FloatArray, FloatArray], FloatArray]
"""F (2, n, 3) at t, y and ẏ."""


class Iteration:
    """The factor of one System, and corrections with it.

    counted : is told of each of the "setups" and "solves"
    free : whether cables vibrate freely, see `taut`
    """

    def __init__(self, system: System, residual: Residual, counted: Callable[[str], None]) -> None:
        self._solver = CondensedSolver(system)
        self._residual = residual
        self._at: FloatArray | None = None
        self._acting: list[IntArray] = []
        self._phase = system
        self._spoilt, self._cj = False, 0.0
        self.free = False
        self._counted = counted

    def enter(self, phase: System, x: FloatArray) -> Damped:
        """Start a phase at x (n, 3); return how its cables are damped."""
        self.go_on(phase)
        self._kappa = stiffness_of(phase, x)
        self._nodes = [3 * nodes if (nodes := coupled_by(f)) is not None else None for f in phase.forces]
        damped = damped_of(phase, x)
        self._stiffest = float(damped.kappa[0])
        self._spoilt = self.free = False
        return damped

    def go_on(self, part: System) -> None:
        """Go on in a part of the phase."""
        self._phase = part

    def setup(self, t: float, y: FloatArray, cj: float) -> None:
        """Factor the matrix at y (2, n, 3)."""
        self._solver.setup(self._phase, t, y[0], y[1], cj)
        self._at = y[0].ravel().copy()
        self._acting = [
            force.acting if isinstance(force, ElementForce) and kappa.any() else np.arange(0)
            for force, kappa in zip(self._phase.forces, self._kappa, strict=True)
        ]
        self._counted("setups")
        self._spoilt = False

    def begin(self, t: float, y: FloatArray, cj: float) -> bool:
        """Begin an attempt at a step; return whether each iterate needs a factor, of which the first is not made."""
        spoilt = self._spoilt and cj == self._cj
        each = self.free and (self._stiffest > STIFF * cj * cj or spoilt)
        self._spoilt, self._cj = each, cj
        if not each and self._has_turned(y[0], cj):
            spoilt = self._spoilt
            self.setup(t, y, cj)
            self._spoilt = spoilt
        return each

    def solve(self, r: FloatArray, cj: float, out: FloatArray) -> None:
        """One correction (2, n, 3), with the factor that there is."""
        self._solver.solve(r[0], r[1], cj, out[0], out[1])
        self._counted("solves")

    def iterate(
        self,
        t: float,
        y: FloatArray,
        yp: FloatArray,
        r: FloatArray,
        cj: float,
        weight: FloatArray,
        limit: float,
    ) -> FloatArray | None:
        """Sum of the corrections of y and ẏ, where r = −F, on; all (2, n, 3), or None without convergence.

        weight, limit : of their norm
        """
        total, z = np.zeros_like(y), np.empty_like(y)
        for k in range(ITERATIONS):
            at = y + total
            if k > 0:
                r = -self._residual(t, at, yp + cj * total)
            try:
                self.setup(t, at, cj)
            except RunError:  # singular: an iterate may be anywhere
                return None
            self._spoilt = True
            self.solve(r, cj, z)
            total += z
            if np.sqrt(np.mean((z * weight) ** 2)) <= CONVERGED * limit:
                return total
        return None

    def _has_turned(self, x: FloatArray, cj: float) -> bool:
        if self._at is None:
            return False
        now = np.ascontiguousarray(x).ravel()
        return any(
            len(acting) > 0
            and nodes is not None
            and nodes.shape[1] > 1
            and has_turned(now, self._at, nodes, acting, len(acting), kappa, cj)
            for nodes, acting, kappa in zip(self._nodes, self._acting, self._kappa, strict=True)
        )
