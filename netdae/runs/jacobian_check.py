"""The Jacobian of the residual against differences, and the stiffest frequency of a net.

Symbols: y = (x, v) as (2, n, 3), ẏ = (v, a), F = (F₁, F₂) the residual (2, n, 3), J = ∂F/∂y + c_j ∂F/∂ẏ.
J is multiplied by directions that move only nodes so far apart that each row of J meets one of them at most:
every entry is compared, with a number of residuals that does not grow with the net.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import eigsh

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.forces.cables import law_of, own_strain_of
from netdae.model.state import State
from netdae.scenario.simulation import Simulation
from netdae.solvers.linalg import condensed as linear_solver
from netdae.system import matrices
from netdae.system.assembly import assembled
from netdae.system.system import System

LIMIT = 1e-5
"""Largest error of an entry, as a share of the largest entry of its row: differences themselves err by 1e-7."""

STIFFNESS = 1e3
"""c_j in 1/s: about that of a flight's steps."""

STEP = 1e-6
"""Differences move a node by this share of the shortest rest length, or of the largest speed (1 m/s at least)."""

KINK_MARGIN = 10.0
"""A cable is at a kink of its law if nearer to it than this many times what one difference stretches it."""


@dataclass(frozen=True)
class Comparison:
    """How J agrees with differences at one state.

    at_kinks : number of cables that stand at a kink, where there is no derivative; J without them is compared
    error : largest error of an entry, as a share of the largest of its row
    place : the row and the column of that entry, in words
    """

    name: str
    taut: int
    slack: int
    at_kinks: int
    error: float
    place: str

    @property
    def agrees(self) -> bool:
        """Whether the error is within `LIMIT`."""
        return self.error <= LIMIT


def compare_jacobian(simulation: Simulation, *, states: int = 3, seed: int = 1) -> list[Comparison]:
    """J against differences at the start and at seeded states with taut and slack cables.

    A cable at a kink of its law, as all are in a net that starts in its reference shape, is left out there.
    """
    system, start = simulation.system, simulation.start
    end = float(simulation.times[-1])
    _, _, phase = next(system.phases(start.t, end))
    rng = np.random.default_rng(seed)
    named = [("start", start)]
    for number in range(states):
        named.append((f"state {number + 1}", _random_state(system, start.t, rng)))
    colours = _colours_of(system)
    return [_compared(phase, name, state, colours) for name, state in named]


def _random_state(system: System, t: float, rng: np.random.Generator) -> State:
    """About half of the cables taut by up to a few per cent, nodes moving so that the dashpot counts."""
    net = system.net
    span = np.linalg.norm(net.spans, axis=1)
    spread = float(np.median(net.rest_length[span > 0] / span[span > 0])) if span.any() else 1.0
    length = float(net.rest_length.min())
    reach = (0.01 if span.any() else 1.0) * length
    x = spread * net.nodes + reach * rng.standard_normal(net.nodes.shape)
    tau = float(system.cables.tau.max())
    speed = min(1.0, reach / tau) if tau > 0 else 1.0
    return State.at(x, speed * rng.standard_normal(x.shape), t=t)


def _colours_of(system: System) -> IntArray:
    """A colour (n,) for each node, such that no force joins a node to two of one colour."""
    n = system.net.node_count
    pairs = [np.arange(n)[:, None].repeat(2, axis=1)]
    for force in system.forces:
        k = force.nodes.shape[1]
        pairs.append(
            np.stack([force.nodes.repeat(k, axis=1), np.tile(force.nodes, (1, k))], axis=-1).reshape(-1, 2)
        )
    i, j = np.concatenate(pairs).T
    joined = sparse.csr_array((np.ones(len(i)), (i, j)), shape=(n, n))
    near = sparse.csr_array(joined @ joined)  # pairs of nodes that share a row of J
    colours = np.full(n, -1)
    for node in range(n):
        taken = set(colours[near.indices[near.indptr[node] : near.indptr[node + 1]]].tolist())
        colours[node] = next(colour for colour in range(n + 1) if colour not in taken)
    return colours


def _compared(system: System, name: str, state: State, colours: IntArray) -> Comparison:
    x, v, t = state.x, state.v, system.inside(state.t)
    strain = system.strain(x)
    steps = (STEP * float(system.net.rest_length.min()), STEP * max(1.0, float(np.abs(v).max())))
    at_kinks = _at_kinks(system, x, v, steps)
    system = system.without(at_kinks)
    n, cj = system.net.node_count, STIFFNESS
    J = linear_solver.full_jacobian(system, t, x, v, cj)
    largest = abs(J).max(axis=1).toarray().ravel()
    y = np.stack((x, v))
    ydot = np.stack((v, np.zeros_like(v)))
    F = _residual(system, t, y, ydot)
    worst, place = 0.0, ""
    for part, axis, colour in np.ndindex(2, 3, int(colours.max()) + 1):
        d = np.zeros((2, n, 3))
        d[part, colours == colour, axis] = 1.0
        h = steps[part]
        ahead, behind = (_residual(system, t, y + s * d, ydot + cj * s * d) for s in (h, -h))
        one, other = (ahead - F) / h, (F - behind) / h
        products = [J @ d.ravel()]
        error = _outside(products, one, other) / largest
        if not error.max() <= LIMIT:  # J jumps at a kink that both differences leave to the same side
            ends = (y + s * d for s in (h, -h))
            beside = [linear_solver.full_jacobian(system, t, end[0], end[1], cj) for end in ends]
            error = _outside([*products, *(each @ d.ravel() for each in beside)], one, other) / largest
        row = int(error.argmax())
        if not error[row] <= worst:
            worst = float(error[row])
            place = _place_of(row, part, axis, colours == colour, J, n)
    taut, slack = int((strain > 0).sum()), int((strain <= 0).sum())
    return Comparison(name, taut, slack, int(at_kinks.sum()), worst, place)


def _outside(products: list[FloatArray], one: FloatArray, other: FloatArray) -> FloatArray:
    """How far all products of J, (6n,), lie to the same side of the differences of both sides, (6n,).

    At a kink of a force that is no cable J lies between these differences; elsewhere they agree.
    """
    low, high = (bound(one, other).ravel() for bound in (np.minimum, np.maximum))
    below, above = low - np.max(products, axis=0), np.min(products, axis=0) - high
    return np.maximum(np.maximum(below, above), 0.0)


def _at_kinks(system: System, x: FloatArray, v: FloatArray, steps: tuple[float, float]) -> BoolArray:
    """Cables (m,) at E11 = 0, at the end of their toe or where the dashpot's clamp sets in, S11 = 0."""
    cables = system.cables
    d, w = (y[cables.nodes[:, 1]] - y[cables.nodes[:, 0]] for y in (x, v))
    LL = cables.L**2
    E11, rate = cables.strain(x), np.einsum("ei,ei->e", d, w) / LL
    each = list(zip(E11, cables.eps, cables.engineering, strict=True))
    g, dg, ddg, _ = np.array([law_of(*law) for law in each]).T
    own = np.array([own_strain_of(strain, engineering) for strain, _, engineering in each])
    length, speed = np.linalg.norm(d, axis=1), np.linalg.norm(w, axis=1)
    of_strain, of_rate = steps[0] * length / LL, (steps[0] * speed + steps[1] * length) / LL
    of_stress = (dg + cables.tau * np.abs(ddg * rate)) * of_strain + cables.tau * dg * of_rate
    turns = np.abs(E11) <= KINK_MARGIN * of_strain
    leaves_toe = (cables.eps > 0) & (np.abs(own - cables.eps) <= KINK_MARGIN * of_strain)
    clamps = (E11 > 0) & (cables.tau > 0) & (np.abs(g + cables.tau * dg * rate) <= KINK_MARGIN * of_stress)
    return turns | leaves_toe | clamps


def _residual(system: System, t: float, y: FloatArray, ydot: FloatArray) -> FloatArray:
    """F (2, n, 3), up to the constant x_d and v_d of restrained axes."""
    (x, v), (dx, dv) = y, ydot
    F = np.stack((dx - v, system.mass[:, None] * dv - system.force(t, x, v)))
    return np.where(system.restrained, y, F)


def _place_of(row: int, part: int, axis: int, moved: BoolArray, J: sparse.csr_matrix, n: int) -> str:
    equation, node, direction = np.unravel_index(row, (2, n, 3))
    columns = 3 * n * part + 3 * np.flatnonzero(moved) + axis
    entries = abs(J[[row]][:, columns].toarray().ravel())
    other = int(np.flatnonzero(moved)[int(entries.argmax())]) if entries.any() else None
    of = f"{'xv'[part]} along {'xyz'[axis]}" + (f" of node {other}" if other is not None else "")
    return f"F{'₁₂'[int(equation)]} of node {int(node)} along {'xyz'[int(direction)]} with respect to {of}"


def stiffest_frequency(system: System) -> float:
    """Highest frequency in Hz of the net in its reference shape with every cable taut and above its toe."""
    net = system.net
    span = net.spans
    stiffness = system.cords.axial_stiffness / net.rest_length
    free = ~system.restrained.ravel()
    if not free.any():
        return 0.0
    mass = np.repeat(system.mass, 3)
    lightest = float(mass[free].min())  # scales the squares of frequencies, which otherwise might overflow
    weight = np.zeros(3 * net.node_count)
    weight[free] = np.sqrt(lightest / mass[free])
    if (np.linalg.norm(span, axis=1) == 0).any():  # directions unknown: the bound of the single cables
        single = stiffness * (weight.reshape(-1, 3).max(axis=1)[net.cables] ** 2).sum(axis=1)
        # each node is shared by as many cables as end there
        shares = np.bincount(net.cables.ravel())[net.cables].max(axis=1)
        return math.sqrt(float((single * shares).max())) / math.sqrt(lightest) / (2 * math.pi)
    elements = matrices.reference_stiffness(span, system.cords.axial_stiffness, net.rest_length)
    K = assembled(elements, net.cables, net.node_count)
    scale = sparse.diags_array(weight)
    A = scale @ K @ scale
    if A.shape[0] <= 30:
        largest = float(np.linalg.eigvalsh(A.toarray())[-1])
    else:
        first = np.random.default_rng(1).standard_normal(A.shape[0])
        largest = float(eigsh(A, k=1, which="LA", v0=first, tol=1e-6, return_eigenvectors=False)[0])
    return math.sqrt(max(largest, 0.0)) / math.sqrt(lightest) / (2 * math.pi)
