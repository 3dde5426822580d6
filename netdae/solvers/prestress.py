"""Forces and stiffness of a net at rest, with a prestress that may fade.

Symbols: x (n, 3); f sum of forces (n, 3), −f the gradient of the potential energy; T = −∂f/∂x; R a graph
Laplacian with EĀ/L̄ of every cable; for a cable d = xⱼ − xᵢ, E11, g = S11/E, q = S11 Ā/L̄ as in `forces.cables`.

The fading prestress is about EĀδ/2 in every cable, slack or taut,

    S11 = E g(P) dP/dE11,       P = ½ (E11 + √(E11² + 4δ²)),

and the law itself at δ = 0. Its energy is convex in x like that of the law.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.core.errors import RunError
from netdae.forces.cables import law_of
from netdae.forces.force import Force, Tangent
from netdae.system.assembly import assembled, scatter_add
from netdae.system.system import System

FIRST_FADE, FADE_FACTOR, LAST_FADE = 0.1, 0.1, 1e-15  # δ: the first makes a packed net as stiff as a taut one


@njit(cache=True)
def _fading_law(
    E11: FloatArray, eps: FloatArray, engineering: BoolArray, delta: float, g: FloatArray, dg: FloatArray
) -> None:
    for e in range(len(E11)):
        if delta == 0.0:
            g[e], dg[e], _, _ = law_of(E11[e], eps[e], engineering[e])
            continue
        root = np.sqrt(E11[e] ** 2 + 4.0 * delta**2)
        P = 0.5 * (E11[e] + root) if E11[e] > 0.0 else 2.0 * delta**2 / (root - E11[e])
        dP, ddP = P / root, 2.0 * delta**2 / root**3
        g_P, dg_P, _, _ = law_of(P, eps[e], engineering[e])
        g[e], dg[e] = g_P * dP, dg_P * dP * dP + g_P * ddP


class PrestressedNet:
    """Forces and stiffness of one static problem.

    delta : δ of the fading prestress
    moving : (n, 3), the axes to solve for
    R : (3n, 3n), N/m, positive definite
    """

    def __init__(self, system: System, t: float, tolerance: float) -> None:
        self.delta = 0.0
        self._system, self._t, self._tolerance = system, system.inside(t), tolerance
        self._cables = system.cables
        self._others = [force for force in system.forces if force is not system.cables.force]
        self._still = np.zeros((system.net.node_count, 3))
        self._load = self._least_load = 0.0
        self._parts = connected_components(graph_of(system.net.cables, system.net.node_count))[1]
        self.moving = ~system.restrained
        k = self._cables.EA / self._cables.L
        elements = self._elements(k, np.zeros((len(k), 3, 3)))
        laplacian = assembled(elements, self._cables.nodes, system.net.node_count)
        # the share of the diagonal holds a floating net
        self.R = laplacian + 1e-6 * sparse.diags_array(laplacian.diagonal())

    # Loads

    def check_carried(self, x: FloatArray) -> None:
        """Raise RunError where a load acts on a part that nothing holds; pin one node of a part that floats."""
        p = self._sum_of(self._others, x)
        loads = np.abs(np.where(self._system.restrained, 0.0, p)).max(axis=1)
        self._load = float(loads.max())
        self._least_load = float(loads[self.moving.any(axis=1)].min(initial=self._load))
        if any(f.external and self._tangent_of(f, x).dx.any() for f in self._others):
            return  # a force that changes with x may hold the net
        for part in range(int(self._parts.max()) + 1):
            nodes = np.flatnonzero(self._parts == part)
            for axis in np.flatnonzero(~self._system.restrained[nodes].any(axis=0)):
                total, weight = p[nodes, axis].sum(), np.abs(p[nodes, axis]).sum()
                if abs(total) > 1e-9 * weight:
                    raise RunError(
                        f"there is no equilibrium: a load of {total:g} N along {'xyz'[axis]} pulls on the {len(nodes)} "
                        f"connected nodes around node {nodes[0]}, none of which is restrained along "
                        f"{'xyz'[axis]}: they fall freely; restrain a node, or take the load away"
                    )
                self.moving[nodes[0], axis] = False  # the rest balances, so this node does too

    def force(self, x: FloatArray) -> FloatArray:
        """f on free axes, (n, 3), N; zero on restrained ones."""
        d, g, _ = self._law(x)
        pull = (g * self._cables.EA / self._cables.L)[:, None] * d
        f = self._sum_of(self._others, x)
        scatter_add(np.stack((pull, -pull), axis=1), self._cables.nodes, f)
        f[self._system.restrained] = 0.0
        return f

    def allowed(self, x: FloatArray) -> float:
        """Residual force allowed, N; larger while a prestress fades."""
        stiffest = float((self._cables.EA / self._cables.L).max())
        round_off = 8 * math.ulp(float(np.abs(x).max())) * stiffest
        if self.delta > 0:
            return max(round_off, 1e-2 * self._least_load, 1e-6 * self.delta * float(self._cables.EA.max()))
        return round_off + self._tolerance * max(self._load, float(self._system.tension(x).max()))

    def fading(self) -> list[float]:
        """δ of the load steps, 0 last."""
        least = max(LAST_FADE, 1e-3 * self._least_load / float(self._cables.EA.max()))
        count = max(1, math.ceil(math.log(least / FIRST_FADE) / math.log(FADE_FACTOR)))
        return [*(FIRST_FADE * FADE_FACTOR**k for k in range(count)), 0.0]

    def stiffness(self, x: FloatArray) -> sparse.csr_matrix:
        """Symmetric part of T, (3n, 3n), N/m."""
        n = self._system.net.node_count
        d, g, dg = self._law(x)
        q, c = g * self._cables.EA / self._cables.L, dg * self._cables.EA / self._cables.L**3
        along = c[:, None, None] * d[:, :, None] * d[:, None, :]
        T = assembled(self._elements(q, along), self._cables.nodes, n)
        for force in self._others:
            elements, K, _ = self._tangent_of(force, x)
            if len(elements):
                other = -assembled(K, force.nodes[elements], n)
                T = T + 0.5 * (other + other.T)
        return T

    def _tangent_of(self, force: Force, x: FloatArray) -> Tangent:
        return force.tangent(self._t, x[force.nodes], self._still[force.nodes])

    @staticmethod
    def _elements(q: FloatArray, along: FloatArray) -> FloatArray:
        """[[B, −B], [−B, B]] with B = q I + along, (m, 6, 6)."""
        B = q[:, None, None] * np.eye(3) + along
        return np.block([[B, -B], [-B, B]])

    def _law(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        cables = self._cables
        d = x[cables.nodes[:, 1]] - x[cables.nodes[:, 0]]
        g, dg = np.empty(len(d)), np.empty(len(d))
        _fading_law(cables.strain(x), cables.eps, cables.engineering, self.delta, g, dg)
        return d, g, dg

    def _sum_of(self, forces: list[Force], x: FloatArray) -> FloatArray:
        total = np.zeros_like(x)
        for force in forces:
            nodes = force.nodes
            scatter_add(force.force(self._t, x[nodes], self._still[nodes]), nodes, total)
        return total

    def failure(self, x: FloatArray) -> str:
        """The error message where nothing converges."""
        f = np.abs(self.force(x))
        node, axis = np.unravel_index(int(np.argmax(f)), f.shape)
        return (
            f"no equilibrium was found: a force of {f.max():g} N along "
            f"{'xyz'[int(axis)]} is left on node {node}, {self.allowed(x):g} N are allowed: "
            "start nearer to rest, or raise the tolerance"
        )


def graph_of(cables: IntArray, node_count: int) -> sparse.coo_matrix:
    """Nodes joined by cables (m, 2), (n, n)."""
    return sparse.coo_matrix((np.ones(len(cables)), (cables[:, 0], cables[:, 1])), shape=(node_count,) * 2)
