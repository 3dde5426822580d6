"""Static equilibrium: the positions where cables and loads balance, S(x) x = p.

Symbols as in `prestress`: x (n, 3); f sum of forces (n, 3); T = −∂f/∂x; R a graph Laplacian of the cables; δ fade.

The energy of cables that pull and never push is convex in x, whatever the law, and a dead load is linear:
with dead loads every equilibrium is a global minimum. There is one if and only if no resultant load acts along
an axis on a connected part of the net that nothing holds along this axis.

Newton's method uses T + μR in place of T, since T is singular for slack or straight unstressed cables, and
searches along each step for the place where the slope −f·u vanishes: slopes stay accurate where energies are
lost in round-off. Where this fails at the many kinks of a slack net, load stepping is used, but in reverse: a
net without stiffness cannot carry the first small share of a load, so the whole load acts from the first step
on, with a prestress that fades from step to step; the last step has the law itself.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import InputError, RunError
from netdae.model.state import State
from netdae.solvers.prestress import PrestressedNet, graph_of
from netdae.system.system import System

logger = logging.getLogger(__name__)

STRAIGHT_ITERATIONS = 30  # of Newton's method before load stepping; a taut net needs about ten
STAGE_ITERATIONS = 400
LEAST_MU, MOST_MU = 1e-12, 10.0
SLOPE_LEFT = 0.1  # of the slope at the start of a line search


@dataclass(frozen=True, eq=False)
class Mechanism:
    """Nodes that no tension holds against moving together along `axes`, some of "xyz"."""

    nodes: IntArray
    axes: str


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A net at rest under its loads.

    state : the State at rest; fit for the start of a flight
    residual : N, the largest component of force left on a free axis
    reactions : (n, 3), N, what the restraints put on each node, zero on free axes
    mechanisms : slack parts, which could equally rest elsewhere; empty where tension holds every node
    iterations : of Newton's method, all steps together
    load_steps : steps in which a prestress faded; 0 where Newton's method converged directly
    """

    state: State
    residual: float
    reactions: FloatArray
    mechanisms: tuple[Mechanism, ...]
    iterations: int
    load_steps: int

    @property
    def x(self) -> FloatArray:
        """Positions (n, 3), m."""
        return self.state.x

    @property
    def zero_modes(self) -> int:
        """Number of independent motions that no tension holds.

        Each has 0 Hz, unless a cable just at its rest length stands in its way.
        """
        return sum(len(mechanism.axes) for mechanism in self.mechanisms)


def equilibrium(
    system: System,
    start: State | ArrayLike,
    *,
    t: float | None = None,
    tolerance: float = 1e-12,
) -> Equilibrium:
    """Rest position of `system` under its loads at time t, by minimising the potential energy.

    start : a State or positions (n, 3) from which to begin; it matters only where nothing else decides, as for
        slack parts. Restrained axes stay at their starting places, moved by their motions at t.
    t : s, by default the start's, or 0
    tolerance : largest residual force over the largest load or tension; round-off of the forces is always allowed

    Raises InputError for a start of the wrong shape, RunError where nothing carries a load or nothing converges.
    """
    anchor, time = _start_of(system, start, t)
    prestressed = PrestressedNet(system, time, tolerance)
    x_d, _, _ = system.drive_from(anchor).at(time)
    x = np.where(system.restrained, x_d, anchor)
    prestressed.check_carried(x)
    x, converged, iterations = _newton(prestressed, x, STRAIGHT_ITERATIONS, mu=1e-6)
    load_steps = 0
    if not converged:
        x = np.where(system.restrained, x_d, anchor)
        for delta in prestressed.fading():
            prestressed.delta, load_steps = delta, load_steps + 1
            x, converged, taken = _newton(prestressed, x, STAGE_ITERATIONS, mu=LEAST_MU)
            iterations += taken
    if not converged:
        raise RunError(prestressed.failure(x))
    zero = np.zeros_like(x)
    f = prestressed.force(x)
    found = Equilibrium(
        State(time, x, zero, zero),
        float(np.abs(f).max()),
        system.reactions(time, x, zero, zero),
        _mechanisms(system, x, 100 * prestressed.allowed(x)),
        iterations,
        load_steps,
    )
    if found.mechanisms:
        logger.info("equilibrium: %d motions have no stiffness", found.zero_modes)
    return found


def _start_of(system: System, start: State | ArrayLike, t: float | None) -> tuple[FloatArray, float]:
    own_time = start.t if isinstance(start, State) else 0.0
    x = np.array(start.x if isinstance(start, State) else start, dtype=np.float64)
    if x.shape != (system.net.node_count, 3):
        raise InputError(
            f"equilibrium: the start has the shape {x.shape}: the net has {system.net.node_count} nodes"
        )
    if not np.isfinite(x).all():
        node = int(np.argwhere(~np.isfinite(x))[0, 0])
        raise InputError(f"equilibrium: node {node} starts at {x[node].tolist()}: give finite numbers")
    return x, own_time if t is None else t


def _newton(
    prestressed: PrestressedNet, x: FloatArray, limit: int, *, mu: float
) -> tuple[FloatArray, bool, int]:
    """Positions, whether they balance, and the iterations taken, at most `limit`."""
    f = prestressed.force(x)
    for iteration in range(limit):
        if np.abs(f).max() <= prestressed.allowed(x):
            return x, True, iteration
        u, mu = _step(prestressed, x, f, mu)
        length, f = _search(prestressed.force, x, u, f)
        x = x + length * u
        # a step cut short met kinks: hold the next one back
        factor = 0.1 if length >= 1 else 0.3 if length > 0.5 else 3.0
        mu = min(max(mu * factor, LEAST_MU), MOST_MU)
    return x, bool(np.abs(f).max() <= prestressed.allowed(x)), limit


def _step(prestressed: PrestressedNet, x: FloatArray, f: FloatArray, mu: float) -> tuple[FloatArray, float]:
    """Solution u (n, 3) of (T + μR) u = f that leads downhill, and the μ that it took."""
    T = prestressed.stiffness(x)
    free = np.flatnonzero(prestressed.moving)
    while mu < 1e12:
        K = (T + mu * prestressed.R).tocsc()[free][:, free]
        try:
            factors = splu(
                K, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError:  # singular to working precision
            mu *= 100
            continue
        u = np.zeros(f.size)
        u[free] = factors.solve(f.ravel()[free])
        if np.isfinite(u).all() and u @ f.ravel() > 0:
            return u.reshape(f.shape), mu
        mu *= 100
    raise RunError(prestressed.failure(x))


def _search(
    force: Callable[[FloatArray], FloatArray], x: FloatArray, u: FloatArray, f: FloatArray
) -> tuple[float, FloatArray]:
    """Length of the step along u at which the slope −f·u is all but zero, and the forces there."""
    begin = -float(np.vdot(f, u))
    low, low_slope, high, high_slope = 0.0, begin, math.inf, math.inf
    length = 1.0
    for _ in range(40):
        f = force(x + length * u)
        slope = -float(np.vdot(f, u))
        if abs(slope) <= SLOPE_LEFT * abs(begin):
            break
        if slope < 0:
            low, low_slope = length, slope
        else:
            high, high_slope = length, slope
        if math.isinf(high):
            length *= 3
        else:
            width = high - low
            chord = low - width * low_slope / (high_slope - low_slope)
            length = min(max(chord, low + 0.1 * width), high - 0.1 * width)
    return length, f


def _mechanisms(system: System, x: FloatArray, least_tension: float) -> tuple[Mechanism, ...]:
    """Parts that hang together by tension, with the axes along which none of their nodes is restrained.

    u·T u = Σ q |uⱼ − uᵢ|² + ... vanishes only for u that is constant over such a part.
    """
    taut = system.net.cables[system.tension(x) > least_tension]
    count, part = connected_components(graph_of(taut, system.net.node_count))
    held = np.zeros((count, 3), dtype=np.bool_)
    np.logical_or.at(held, part, system.restrained)
    return tuple(
        Mechanism(np.flatnonzero(part == p), "".join(np.array(list("xyz"))[~held[p]]))
        for p in np.flatnonzero(~held.all(axis=1))
    )
