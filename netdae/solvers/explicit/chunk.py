"""A chunk of explicit steps: its start, from which any instant inside it can be recomputed, and its balance."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from netdae.core.arrays import FloatArray, frozen_floats
from netdae.solvers.explicit.parts import Tally
from netdae.solvers.stepper import Share, Step


def _none() -> FloatArray:
    return frozen_floats([])


@dataclass(frozen=True, eq=False)
class Chunk:
    """Start time t, step length h, and x, v, a, (3, 3n).

    powers : (8,), of the previous step, and hold, see `explicit.verlet.fly`; fresh : whether the flight began there
    memory : of the kernel, see `Kernel.memory`
    """

    t: float
    h: float
    xva: FloatArray
    powers: FloatArray
    hold: int
    fresh: bool = False
    memory: FloatArray = field(default_factory=_none)


def step_of(t: float, xva: FloatArray, share: Share) -> Step:
    """A step with a copy of x, v and a, (3, 3n); y and yp share its velocities."""
    whole = xva.reshape(3, -1, 3).copy()
    return Step(t, whole[:2], whole[1:], share)


def share_of(tally: Tally) -> Share:
    """What the balance gains from a run of the kernel."""
    return Share(tally.dissipated, tally.work, tally.impulse[:3], tally.peak, tally.impulse[3:])


def share_reported(row: FloatArray, peak: int) -> Share:
    """The same from a row (10,) of the history of steps, with the tension at index `peak`."""
    return Share(float(row[0]), float(row[1]), row[2:5], float(row[peak]), row[5:8])


def sum_of(one: Share | None, other: Share | None, factor: float = 1.0) -> Share:
    """One share plus `factor` times the other, with the peak of the first."""
    assert one is not None
    assert other is not None
    return Share(
        one.dissipated_energy + factor * other.dissipated_energy,
        one.external_work + factor * other.external_work,
        one.external_impulse + factor * other.external_impulse,
        one.peak_tension,
        one.external_angular_impulse + factor * other.external_angular_impulse,
    )


def after(step: Step, first: Share | None) -> Step:
    """A step whose share starts where another one's ends."""
    return step._replace(share=sum_of(step.share, first, -1.0))


def between(t: float, first: Step, last: Step) -> Step:
    """An instant inside the step from first to last: cubic x and v through both, all else linear."""
    h = last.t - first.t
    s = min(max((t - first.t) / h, 0.0), 1.0)
    (x0, v0), (x1, v1), a0, a1 = first.y, last.y, first.yp[1], last.yp[1]
    x = _hermite(s, h, x0, v0, x1, v1)
    v = _hermite(s, h, v0, a0, v1, a1)
    a = (1 - s) * a0 + s * a1
    share = sum_of(sum_of(first.share, first.share, -s), last.share, s)
    return Step(t, np.stack((x, v)), np.stack((v, a)), share)


def _hermite(
    s: float, h: float, x0: FloatArray, v0: FloatArray, x1: FloatArray, v1: FloatArray
) -> FloatArray:
    """Cubic through (x0, v0) and (x1, v1) at the fraction s of a step of length h."""
    r = 1 - s
    return r * r * (1 + 2 * s) * x0 + s * s * (3 - 2 * s) * x1 + h * s * r * (r * v0 - s * v1)
