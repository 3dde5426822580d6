"""Taut cables without damping under IDA: what their directions, their waves and their tension ask of a step.

Symbols: k stiffness of a cable along itself in N/m, 1/m the sum over its nodes, κ = k/m in 1/s²; d its vector, l its
length, δd the change of d since the matrix was factored; h step length, c_j of the BDF formula, τ viscosity time.

A step of a BDF formula solves (c_j² M + T) dx = r. Along a taut cable T is k, so that a stretch far below the tolerance
of positions is a tension: 1e-6 m are 10 N where k is 1e7 N/m. A dashpot with τ ≥ h takes such errors out of the flight.
Without one

- a factor of an old direction feeds them sideways. The pull k s of a stretch s is taken along the old d and moves the
  nodes across it by κ |δd⊥|/(l c_j²) times s, so the matrix is factored where this passes `TURNED` (`has_turned`);
- where κ ≫ c_j², one correction with the matrix of the predicted state leaves a stretch of |dx⊥|²/2l, and a cable
  that is predicted slack, by a stretch error above its own, is missing in the matrix. There the matrix is factored at
  each iterate (`STIFF`), and corrections end by their own size, since they shrink only once the right cables are taut;
- BDF formulas of orders above 2 gain energy in modes of hω around 1, which no tolerance sees until they have grown
  (G. Dahlquist, BIT 3, 1963: none is stable on the whole imaginary axis). The order stays at 2, `is_undamped`;
- such a step is a step of a system of index 3: where its length changes, the velocity along a cable jumps by its
  truncation error, of order h², and no shorter step passes the error test. So this test sees a velocity's error e as
  the formula would pass it on, (c_j² M + c_j D + T)⁻¹ c_j² M e, without what is stiff in it (`calls.filter_errors`);
- at order 2 more steps are taken than at 5 for the same tolerance, and their errors add up to more: the tolerances are
  `TIGHT` times as strict where waves are free. h²√κ/τ counts them: a wave of hω = 1 fades in h²/τ steps' time, and as
  many others as h√κ are faster;
- a cubic through two ends of a step, or the formula's own polynomial, has a stretch error between them (`polish`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from netdae.core.arrays import FloatArray, IntArray, Reals
from netdae.core.compilation import OPTIONS as LAWS_OPTIONS
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.system.damping import Rayleigh
from netdae.system.system import System

OPTIONS = {"cache": True, **LAWS_OPTIONS}

TURNED = 0.02  # of a stretch error that may be fed sideways
STIFF = 10.0  # κ/c_j² above which the matrix is factored at each iterate
ITERATIONS = 8  # at most, of these
CONVERGED = 1e-3  # of the limit of corrections; the stretch that is left goes with the square of the last
LOW_ORDER = 2  # the highest order that is stable on the whole imaginary axis
SETTLING = 20  # steps at this order after a start, which show how long steps will be

# Two limits each: to begin with, and to go on with, so that they do not alternate
UNDAMPED = 0.3, 0.6  # τ/h below which cables count as undamped
FAST = 1e-3, 2e-4  # κ h² above which they do: a slower mode is resolved, and grows by (κ h²)² a step at most
FREE = 1e-3, 8e-3  # τ/(h²√κ) below which waves are free
TIGHT = 20.0  # then the tolerances are so many times as strict


class Damped(NamedTuple):
    """The cables that decide whether a net is undamped: the stiffest, and each less stiff one with a smaller τ yet."""

    kappa: Reals  # 1/s²
    tau: Reals  # s


COARSE = {"compiled": 2e-4, "python": 2e-5}  # rtol above which free waves cost more than the presets promise


def warnings_of(steps: int, free: int, driver: str, rtol: float) -> tuple[str, ...]:
    """What a user should know of a flight in which so many steps met free waves."""
    if not (2 * free > steps and rtol > COARSE[driver]):
        return ()
    return (
        f"cables vibrate undamped in {free} of {steps} steps, which pass over their waves: at rtol = {rtol:g} tensions "
        'may be 3 % of the largest off, and energies 10 %: set accuracy = "accurate", or give a dashpot in [damping]',
    )


def stiffness_of(system: System, x: FloatArray) -> list[FloatArray]:
    """κ (m,) of the elements of each force, 1/s², where reels are at x (n, 3); zero for those without a direction."""
    return [_of_force(force, system, x)[0] for force in system.forces]


def damped_of(system: System, x: FloatArray) -> Damped:
    """Of all forces of a system; one κ of zero where there are none."""
    kappa, tau = np.concatenate(
        [np.zeros((2, 1)), *(_of_force(each, system, x) for each in system.forces)], 1
    )
    if isinstance(system.damping, Rayleigh):  # it damps a cable that has about its reference direction
        tau = tau + system.damping.beta
    order = np.lexsort((tau, -kappa))
    kappa, tau = kappa[order], tau[order]
    least = np.minimum.accumulate(tau)
    first = np.flatnonzero((kappa > 0) & (np.diff(least, prepend=np.inf) < 0))
    if not len(first):
        return Damped(np.zeros(1), np.zeros(1))
    return Damped(kappa[first], tau[first])


def _of_force(force: Force, system: System, x: FloatArray) -> FloatArray:
    """κ and τ, (2, m), of the elements of a force."""
    found = np.zeros((2, len(force.nodes)))
    if not isinstance(force, ElementForce) or force.law.bound is None:
        return found
    if not (force.law.pair or force.law.measured is not None):
        return found
    mobility = np.zeros(len(system.mass))
    moves = ~system.restrained.all(axis=1) & (system.mass > 0)
    mobility[moves] = 1.0 / system.mass[moves]
    strain = float(system.toe_strain.max(initial=0.0))
    families = force.law.bound(force.parameters, force.nodes, strain, x)
    if families:  # the first is of whole elements
        nodes, (k, c), _ = families[0]
        found[0] = (k * mobility[nodes]).sum(axis=1)
        found[1] = np.divide(c[:, 0], k[:, 0], out=np.zeros(len(k)), where=k[:, 0] > 0)
    return found


@njit(forceinline=True, **OPTIONS)
def is_undamped(before: int, h: float, kappa: FloatArray, tau: FloatArray) -> int:
    """1 where cables vibrate undamped in steps of length h, 2 where waves are free, else 0; `before`: what it was."""
    level = 0
    one, two = (1 if before > 0 else 0), (1 if before > 1 else 0)
    for q in range(len(kappa)):
        square = kappa[q] * h * h
        if square > FAST[one] and tau[q] < UNDAMPED[one] * h:
            level = max(level, 1)
        if square > FAST[two] and tau[q] < FREE[two] * h * np.sqrt(square):
            level = 2
    return level


@njit(forceinline=True, **OPTIONS)
def has_turned(
    x: FloatArray,
    then: FloatArray,
    nodes: IntArray,
    acting: IntArray,
    count: int,
    kappa: FloatArray,
    cj: float,
) -> bool:
    """Whether one of the first `count` acting elements has turned too far from x `then` to x now, both (3n,).

    nodes : (m, ≥ 2), 3i of the ends of each in the first two columns; kappa : (m,), or (1,) for all
    """
    limit = (TURNED * cj * cj) ** 2
    for q in range(count):
        e = acting[q]
        k = kappa[e] if len(kappa) > 1 else kappa[0]
        if k == 0.0:
            continue
        i, j = nodes[e, 0], nodes[e, 1]
        square, along, moved = 0.0, 0.0, 0.0
        for c in range(3):
            d = then[j + c] - then[i + c]
            step = x[j + c] - x[i + c] - d
            square += d * d
            along += d * step
            moved += step * step
        if k * k * (moved * square - along * along) > limit * square * square:
            return True
    return False
