"""States between the ends of steps, and at stops, in balance with the forces there.

Between the ends of a step of length h an integrator's polynomial is right within the tolerance, but its tensions are
not where κ h² > 1, with κ of `taut`: a stretch error s is an acceleration κ s, and the polynomial knows accelerations
from differences over h alone. So x is moved by the δ with which the formula of second order would end a step there,

    M (a + c² δ) = f(x + δ, v + c δ),       c = 3/(2h),

of which δ is the stretch error along a taut cable, and next to nothing across it. Nodes without a cable near taut stay:
there the polynomial is the better of the two. A step that a stop cuts short ends
with another error of its v̇ than those before: there a is extrapolated from them.
"""

from __future__ import annotations

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import RunError
from netdae.solvers.ida.taut import ITERATIONS
from netdae.solvers.linalg.condensed import CondensedSolver
from netdae.solvers.stepper import Step
from netdae.system.system import System

STRETCHED = 1.0  # κ h² above which it pays
NEAR = 1e-3  # strain below zero from which a cable counts as near taut
SETTLED = 1e-6  # of the position's tolerance: what the last iteration moves

End = tuple[float, FloatArray]
"""t and v̇ (n, 3) at the end of a step."""


class Polish:
    """Puts states of one System in balance.

    stiffest : the largest κ, 1/s²; wanted : whether waves are free, see `taut`: a dashpot takes a stretch error itself
    """

    def __init__(self, system: System, atol_position: float) -> None:
        self._system = system
        self._settled = SETTLED * atol_position
        self._solver: CondensedSolver | None = None
        self.stiffest, self.wanted = 0.0, False

    def between(self, part: System, step: Step, h: float) -> Step:
        """The state inside a step of length h, in a part of a phase; as it is where no balance is found."""
        if not (self.wanted and self.stiffest * h * h > STRETCHED):
            return step
        stays = np.ones(self._system.net.node_count, dtype=np.bool_)
        stays[self._system.net.cables[self._system.strain(step.y[0]) > -NEAR]] = False
        if stays.all():
            return step
        if self._solver is None:
            self._solver = CondensedSolver(self._system)
        c, mass, (x, v), a = 1.5 / h, self._system.mass[:, None], step.y, step.yp[1]
        moved, none, dx, dv = np.zeros((4, *x.shape))
        for _ in range(ITERATIONS):
            place, speed = x + moved, v + c * moved
            left = mass * (a + c * c * moved) - part.force(step.t, place, speed)
            left[self._system.restrained] = left[stays] = 0.0
            try:
                self._solver.setup(part, step.t, place, speed, c)
            except RunError:
                return step
            self._solver.solve(none, left, c, dx, dv)
            moved -= dx
            largest = float(np.abs(dx).max(initial=0.0))
            if largest <= self._settled:
                y = np.stack((x + moved, v + c * moved))
                return step._replace(y=y, yp=np.stack((y[1], a + c * c * moved)))
            if not np.isfinite(largest):
                return step
        return step

    def stopped(self, part: System, step: Step, earlier: End, last: End) -> Step:
        """The end of a step at a stop, after two steps that ended at `earlier` and at `last`."""
        (t0, before), (t1, then) = earlier, last
        h, rest = t1 - t0, step.t - t1
        if not rest < h:
            return step
        a = then + rest / h * (then - before)
        return self.between(part, step._replace(yp=np.stack((step.yp[0], a))), h)
