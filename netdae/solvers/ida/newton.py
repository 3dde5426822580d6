"""The Newton matrix of `ida.kernel`: assembled, factored, and the condensed solve of `linalg.condensed` with it.

K = c_j² M + c_j D + T in 3×3 blocks, with the symmetric parts of T = −∂f/∂x and D = −∂f/∂v. It is factored over the
nodes of the active elements, whose graph is found anew each time; elsewhere it is c_j² M. Forces with a constant
tangent, such as Rayleigh damping, always couple all nodes: with them the whole matrix is factored. Symbols as in
`linalg.condensed`.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from netdae.core.addresses import call
from netdae.core.arrays import FloatArray, Reals, Reals3, Wholes, Wholes2, Wholes3
from netdae.core.records import load
from netdae.forces.loops import Elements
from netdae.forces.table import Rows, find_tangents, set_time
from netdae.solvers.ida.dyads import Dyads, add_dyad_products, complete, factor_dyads
from netdae.solvers.ida.kernel import OPTIONS, Net, look
from netdae.solvers.ida.taut import has_turned
from netdae.solvers.linalg.block_ldl import Ldl, _numeric, _solve, _symbolic

SINGULAR_DYADS = -2  # what `factor` returns

PAIRS, ELEMENTS, LINKS, STEADY = 1, 2, 3, 4
"""How a force couples nodes: by d and w alone, by all its nodes, along links and by dyads, or by a constant ∂f/∂v."""


class Coupling(NamedTuple):
    """The part of one force in K."""

    kind: int
    elements: int  # address of its Elements
    row: int  # in the table
    nodes: Wholes2  # (m, k), 3i of the nodes of each element, or of each link
    places: Wholes3  # (m, k, k), block of each pair of these nodes in K, −1 below the diagonal
    stiffness: Reals  # κ of each element, 1/s², see `taut`


class Matrix(NamedTuple):
    """K over the nodes that are coupled at present, its members, in the order of its LDLᵀ."""

    couplings: Wholes  # (f,), addresses
    K: Reals3  # (b, 3, 3)
    constant: Reals3  # (b, 3, 3), D of the forces with a constant tangent, or none
    diagonal: Wholes  # (n,), block of each node
    free: Reals  # (3n,), 0 on restrained axes, 1 on others; or none
    inverse: Reals  # (3n,), 1/mass, kg⁻¹
    counts: Wholes  # (2,), numbers of couples and of members
    low: Wholes  # (off,), nodes of each couple, low < high, and their block
    high: Wholes
    block: Wholes
    order: Wholes  # (n,), nodes in the order of elimination
    place: Wholes  # (n,), of each node among the members, −1 for others
    right: Reals  # (3n,)
    x: Reals  # (3n,), at which K was last put together


@njit(**OPTIONS)
def assemble(t: float, y: FloatArray, cj: float, net: Net, matrix: Matrix, ldl: Ldl) -> int:
    """K at y, with symmetric parts only; the rows' `Elements` keep the tangents for the solves.

    Returns a node without mass that nothing couples, or −1.
    """
    n3 = 3 * len(net.mass)
    x, v, K = y[:n3], y[n3:], matrix.K
    for k in range(n3):
        matrix.x[k] = x[k]
    rows = load(net.rows, Rows)
    set_time(rows, t)
    look(x, net, rows)
    find_tangents(rows, x, v)
    if len(matrix.constant) > 0:
        for b in range(len(K)):
            for r in range(3):
                for s in range(3):
                    K[b, r, s] = cj * matrix.constant[b, r, s]
        for i in range(len(net.mass)):
            _add_mass(cj, i, net.mass, matrix)
    else:
        for k in range(matrix.counts[0]):  # the blocks of the previous matrix
            K[matrix.block[k]] = 0.0
        for k in range(matrix.counts[1]):
            matrix.place[ldl.order[k]] = -1
    matrix.counts[0] = 0
    for c in range(len(matrix.couplings)):
        coupling = load(matrix.couplings[c], Coupling)
        if coupling.kind == PAIRS:
            _add_pairs(cj, net.mass, matrix, coupling)
        elif coupling.kind != STEADY:
            _add_elements(cj, net.mass, matrix, coupling)
    return _find_graph(net.mass, matrix, ldl) if len(matrix.constant) == 0 else -1


@njit(**OPTIONS)
def _join(cj: float, node: int, mass: FloatArray, matrix: Matrix) -> None:
    """Make a node a member, with its mass."""
    if len(matrix.constant) == 0 and matrix.place[node] < 0:
        matrix.place[node] = 0
        matrix.K[matrix.diagonal[node]] = 0.0
        _add_mass(cj, node, mass, matrix)


@njit(**OPTIONS)
def _couple(i: int, j: int, block: int, matrix: Matrix) -> None:
    """Note that two nodes are coupled by a block."""
    if len(matrix.constant) == 0:
        count = matrix.counts[0]
        matrix.low[count], matrix.high[count], matrix.block[count] = min(i, j), max(i, j), block
        matrix.counts[0] = count + 1


@njit(**OPTIONS)
def _add_mass(cj: float, node: int, mass: FloatArray, matrix: Matrix) -> None:
    """c_j² m on the diagonal block of a node, and 1 on its restrained axes, whose rows are otherwise zero."""
    block = matrix.K[matrix.diagonal[node]]
    for r in range(3):
        block[r, r] += cj * cj * mass[node]
        if len(matrix.free):
            block[r, r] += 1.0 - matrix.free[3 * node + r]


@njit(**OPTIONS)
def _add_pairs(cj: float, mass: FloatArray, matrix: Matrix, coupling: Coupling) -> None:
    el = load(coupling.elements, Elements)
    free, masked, K, T, D = matrix.free, len(matrix.free) > 0, matrix.K, el.K, el.C
    viscous = False
    for q in range(el.counts[1]):
        e, at = el.active[q], 9 * q
        i, j = el.nodes[e, 0], el.nodes[e, 1]
        _join(cj, i // 3, mass, matrix)
        _join(cj, j // 3, mass, matrix)
        beside = max(coupling.places[e, 0, 1], coupling.places[e, 1, 0])
        _couple(i // 3, j // 3, beside, matrix)
        A, B, C = K[matrix.diagonal[i // 3]], K[matrix.diagonal[j // 3]], K[beside]
        low, high = min(i, j), max(i, j)
        for r in range(3):
            for c in range(r, 3):
                one, other = at + 3 * r + c, at + 3 * c + r
                viscosity = 0.5 * (D[one] + D[other])
                D[one] = D[other] = viscosity  # products take the symmetric part too
                viscous = viscous or viscosity != 0.0
                k = 0.5 * (T[one] + T[other]) + cj * viscosity
                _add_pair(A, B, C, r, c, k, i, j, low, high, free, masked)
                if c > r:
                    _add_pair(A, B, C, c, r, k, i, j, low, high, free, masked)
    el.rank[0] = 1 if viscous else 0


@njit(**OPTIONS)
def _add_pair(
    A: FloatArray,
    B: FloatArray,
    C: FloatArray,
    r: int,
    c: int,
    k: float,
    i: int,
    j: int,
    low: int,
    high: int,
    free: FloatArray,
    masked: bool,
) -> None:
    """Add k to the entry (r, c) of the blocks of both nodes, and subtract it from that of the block between them."""
    if masked:
        A[r, c] += k * free[i + r] * free[i + c]
        B[r, c] += k * free[j + r] * free[j + c]
        C[r, c] -= k * free[low + r] * free[high + c]
    else:
        A[r, c] += k
        B[r, c] += k
        C[r, c] -= k


@njit(**OPTIONS)
def _add_elements(cj: float, mass: FloatArray, matrix: Matrix, coupling: Coupling) -> None:
    el, nodes = load(coupling.elements, Elements), coupling.nodes
    k = nodes.shape[1]
    size, T, D = 9 * k * k, el.K, el.C
    if coupling.kind == LINKS and el.counts[1] > 0:  # a drum takes part in dyads alone
        for a in range(el.nodes.shape[1]):
            _join(cj, el.nodes[0, a] // 3, mass, matrix)
    for q in range(el.counts[1]):
        e, at = el.active[q], size * q
        for a in range(k):
            _join(cj, nodes[e, a] // 3, mass, matrix)
        for a in range(k):
            for b in range(k):
                block = coupling.places[e, a, b]
                if block < 0:
                    continue
                i, j = nodes[e, a], nodes[e, b]
                if i != j:  # a knot in contact is an element whose first two nodes are the same
                    _couple(i // 3, j // 3, block, matrix)
                for r in range(3):
                    for s in range(3):
                        one = at + ((3 * a + r) * k + b) * 3 + s
                        other = at + ((3 * b + s) * k + a) * 3 + r
                        value = -0.5 * (T[one] + T[other] + cj * (D[one] + D[other]))
                        _add(matrix, block, i, j, r, s, value)


@njit(**OPTIONS)
def _add(matrix: Matrix, block: int, i: int, j: int, r: int, s: int, value: float) -> None:
    """Add a value to the entry (r, s) of the block between entries i ≤ j, unless one of the axes is restrained."""
    if len(matrix.free):
        value *= matrix.free[i + r] * matrix.free[j + s]
    matrix.K[block, r, s] += value


@njit(**OPTIONS)
def _find_graph(mass: FloatArray, matrix: Matrix, ldl: Ldl) -> int:
    """The members, which have place ≥ 0, in the order of elimination, and the blocks beside the diagonal by columns.

    Returns a free node without mass that is no member, or −1.
    Two elements between the same nodes put the same block there twice, which does no harm.
    """
    place, start, size, count = matrix.place, ldl.column_start, 0, matrix.counts[0]
    lost = -1
    for k in range(len(place)):
        node = matrix.order[k]
        if place[node] < 0 and mass[node] == 0.0:
            for c in range(3):
                if len(matrix.free) == 0 or matrix.free[3 * node + c] != 0.0:
                    lost = node
        if place[node] >= 0:
            place[node] = size
            ldl.order[size], ldl.diagonal[size] = node, matrix.diagonal[node]
            size += 1
    start[: size + 1] = 0
    for q in range(count):
        start[max(place[matrix.low[q]], place[matrix.high[q]]) + 1] += 1
    for k in range(size):
        start[k + 1] += start[k]
        ldl.flag[k] = start[k]
    for q in range(count):
        first, second = place[matrix.low[q]], place[matrix.high[q]]
        column = max(first, second)
        at = ldl.flag[column]
        ldl.flag[column] += 1
        ldl.row[at], ldl.source[at] = min(first, second), matrix.block[q]
        ldl.flipped[at] = first > second
    matrix.counts[1] = size
    return lost


@njit(**OPTIONS)
def is_out_of_line(x: FloatArray, cj: float, matrix: Matrix) -> bool:
    """Whether a taut cable has turned too far at x (3n,) for the factor, see `taut`."""
    for c in range(len(matrix.couplings)):
        coupling = load(matrix.couplings[c], Coupling)
        if coupling.nodes.shape[1] > 1 and coupling.kind != STEADY:
            el = load(coupling.elements, Elements)
            if has_turned(x, matrix.x, coupling.nodes, el.active, el.counts[1], coupling.stiffness, cj):
                return True
    return False


@njit(**OPTIONS)
def factor(cj: float, matrix: Matrix, ldl: Ldl, dyads: Dyads) -> int:
    """LDLᵀ of K, and its dyads; the node of a singular pivot, −2 where the dyads are singular, or −1."""
    size = matrix.counts[1]
    _symbolic(matrix.K, size, ldl)
    singular = _numeric(matrix.K, size, ldl)
    if singular >= 0:
        return ldl.order[singular]
    if len(dyads.elements) > 0 and not factor_dyads(dyads, cj, matrix.free, size, ldl):
        return SINGULAR_DYADS
    return -1


@njit(**OPTIONS)
def _add_products(r1: FloatArray, net: Net, matrix: Matrix, right: FloatArray) -> None:
    """Add D r₁ of all blocks to right (3n,), restrained axes included."""
    for c in range(len(matrix.couplings)):
        coupling = load(matrix.couplings[c], Coupling)
        el = load(coupling.elements, Elements)
        D = el.C
        if coupling.kind == PAIRS:
            for q in range(el.counts[1] if el.rank[0] > 0 else 0):
                i, j, at = el.nodes[el.active[q], 0], el.nodes[el.active[q], 1], 9 * q
                w0, w1, w2 = r1[j] - r1[i], r1[j + 1] - r1[i + 1], r1[j + 2] - r1[i + 2]
                for r in range(3):
                    pull = D[at + 3 * r] * w0 + D[at + 3 * r + 1] * w1 + D[at + 3 * r + 2] * w2
                    right[i + r] -= pull
                    right[j + r] += pull
        elif coupling.kind == ELEMENTS:
            k = el.nodes.shape[1]
            for q in range(el.counts[1]):
                e, at = el.active[q], 9 * k * k * q
                for a in range(k):
                    for r in range(3):
                        total = 0.0
                        for b in range(k):
                            for s in range(3):
                                one = at + ((3 * a + r) * k + b) * 3 + s
                                other = at + ((3 * b + s) * k + a) * 3 + r
                                total += (D[one] + D[other]) * r1[el.nodes[e, b] + s]
                        right[el.nodes[e, a] + r] -= 0.5 * total
        elif coupling.kind == STEADY:  # linear in v: its force at v = r₁ is −D r₁
            rows = load(net.rows, Rows)
            net.f[:] = 0.0
            places = r1.ctypes.data, r1.ctypes.data, net.f.ctypes.data, 0, net.sums.ctypes.data
            call(rows.add[coupling.row], (coupling.elements, *places))
            for k in range(len(right)):
                right[k] -= net.f[k]


@njit(**OPTIONS)
def solve(
    r: FloatArray, cj: float, cj_now: float, net: Net, matrix: Matrix, ldl: Ldl, dyads: Dyads, z: FloatArray
) -> None:
    """Solution z of J z = r with the factor made for c_j, scaled by 2/(1 + c_j,now/c_j) as in IDA's direct solvers."""
    n3 = 3 * len(net.mass)
    r1, r2, right = r[:n3], r[n3:], matrix.right
    for i in range(len(net.mass)):
        for c in range(3):
            k = 3 * i + c
            right[k] = r2[k] + cj * net.mass[i] * r1[k]
    _add_products(r1, net, matrix, right)
    if len(dyads.elements) > 0:
        add_dyad_products(dyads, r1, right)
    for c in range(len(net.entry)):
        right[net.entry[c]] = 0.0
    size, scale = matrix.counts[1], 2.0 / (1.0 + cj_now / cj)
    alone = scale / (cj * cj)
    for k in range(n3):  # nodes that are not members
        z[k] = alone * matrix.inverse[k] * right[k]
    _solve(size, ldl, right.reshape((len(net.mass), 3)))
    if len(dyads.elements) > 0:
        complete(dyads, ldl.order[:size], right)
    for p in range(size):
        k = 3 * ldl.order[p]
        z[k], z[k + 1], z[k + 2] = scale * right[k], scale * right[k + 1], scale * right[k + 2]
    for k in range(n3):
        z[n3 + k] = cj * z[k] - scale * r1[k]
    for c in range(len(net.entry)):
        k = net.entry[c]
        z[k], z[n3 + k] = r1[k], r2[k]
