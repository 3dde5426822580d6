"""The Newton matrix of `ida.kernel`: assembled, factored, and the condensed solve of `linear_solver` with it.

K = c_j² M + c_j D + T in 3×3 blocks, with the symmetric parts of T = −∂f/∂x and D = −∂f/∂v. It is factored over the
nodes of those elements that act, whose graph is found anew each time: elsewhere it is c_j² M. Forces with a constant
tangent, as those of Rayleigh damping, couple all nodes always: with them the whole is factored. Symbols as in
`linear_solver`.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from netdae._arrays import Flags, FloatArray, Reals, Reals2, Reals3, Wholes, Wholes3
from netdae.addresses import call
from netdae.block_ldl import _numeric, _solve, _symbolic
from netdae.forces.loops import Elements
from netdae.forces.table import Rows, find_tangents, set_time
from netdae.ida.dyads import Dyads, add_dyad_products, complete, factor_dyads
from netdae.ida.kernel import OPTIONS, Net, look
from netdae.records import load

SINGULAR_DYADS = -2  # what `factor` tells

PAIRS, ELEMENTS, LINKS, STEADY = 1, 2, 3, 4
"""How a force couples nodes: by d and w alone, by all its nodes, along links and by dyads, or by a constant ∂f/∂v."""


class Coupling(NamedTuple):
    """How one force takes part in K."""

    kind: int
    elements: int  # address of its Elements
    row: int  # in the table
    places: (
        Wholes3  # (m, k, k), or (p, 2, 2) of links: block of each pair of nodes in K, −1 below the diagonal
    )
    nodes: Wholes3  # (p, 2, 1), 3i of the nodes of links; or (0, 0, 0)


class Matrix(NamedTuple):
    """K and its LDLᵀ, see `block_ldl`, over those nodes that are coupled at the moment, its members."""

    couplings: Wholes  # (f,), addresses
    K: Reals3  # (b, 3, 3)
    constant: Reals3  # (b, 3, 3), D of the forces with a constant tangent, or none
    diagonal: Wholes  # (n,), block of each node
    free: Reals  # (3n,), 0 on restrained axes, 1 on others; or none
    inverse: Reals  # (3n,), 1/mass, kg⁻¹
    counts: Wholes  # (3,), of couples, of the members, of the blocks beside the diagonal
    low: Wholes  # (off,), nodes of each couple, low < high, and their block
    high: Wholes
    block: Wholes
    order: Wholes  # (n,), nodes in the order of elimination
    place: Wholes  # (n,), of each node among the members, −1 for others
    members: Wholes  # (n,)
    member_diagonal: Wholes  # (n,)
    column_start: Wholes  # the blocks beside the diagonal by columns, as in `block_ldl`
    row: Wholes
    source: Wholes
    flipped: Flags
    present: Flags
    parent: Wholes
    L_start: Wholes
    L_row: Wholes
    L: Reals3
    pivots: Reals2
    flag: Wholes
    L_count: Wholes
    path: Wholes
    stack: Wholes
    Y: Reals3
    y: Reals2
    right: Reals  # (3n,)


@njit(**OPTIONS)
def assemble(t: float, y: FloatArray, cj: float, net: Net, matrix: Matrix) -> int:
    """K at y, with symmetric parts only; the rows' `Elements` keep the tangents for the solves.

    A node without mass that nothing couples, or −1.
    """
    n3 = 3 * len(net.mass)
    x, v, K = y[:n3], y[n3:], matrix.K
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
            _add_mass(cj, i, net, matrix)
    else:
        for k in range(matrix.counts[0]):  # the blocks that the former one had
            K[matrix.block[k]] = 0.0
        for k in range(matrix.counts[1]):
            matrix.place[matrix.members[k]] = -1
    count = 0
    for c in range(len(matrix.couplings)):
        coupling = load(matrix.couplings[c], Coupling)
        if coupling.kind == PAIRS:
            count = _add_pairs(cj, net, matrix, coupling, count)
        elif coupling.kind == ELEMENTS:
            count = _add_elements(cj, net, matrix, coupling, count)
        elif coupling.kind == LINKS:
            count = _add_chain(cj, net, matrix, coupling, count)
    matrix.counts[0] = count
    return _find_graph(net, matrix) if len(matrix.constant) == 0 else -1


@njit(forceinline=True, **OPTIONS)
def _join(cj: float, node: int, net: Net, matrix: Matrix) -> None:
    """Make a node a member, with its mass."""
    if len(matrix.constant) == 0 and matrix.place[node] < 0:
        matrix.place[node] = 0
        matrix.K[matrix.diagonal[node]] = 0.0
        _add_mass(cj, node, net, matrix)


@njit(forceinline=True, **OPTIONS)
def _couple(i: int, j: int, block: int, matrix: Matrix, count: int) -> int:
    """Note that two nodes are coupled by a block; how many couples there are then."""
    if len(matrix.constant) > 0:
        return count
    matrix.low[count], matrix.high[count], matrix.block[count] = min(i, j), max(i, j), block
    return count + 1


@njit(**OPTIONS)
def _add_mass(cj: float, node: int, net: Net, matrix: Matrix) -> None:
    """c_j² m on the diagonal block of a node, and 1 on its restrained axes, whose rows are else zero."""
    block = matrix.K[matrix.diagonal[node]]
    for r in range(3):
        block[r, r] += cj * cj * net.mass[node]
        if len(matrix.free):
            block[r, r] += 1.0 - matrix.free[3 * node + r]


@njit(**OPTIONS)
def _add_pairs(cj: float, net: Net, matrix: Matrix, coupling: Coupling, count: int) -> int:
    el = load(coupling.elements, Elements)
    free, masked, K, T, D = matrix.free, len(matrix.free) > 0, matrix.K, el.K, el.C
    viscous = False
    for q in range(el.counts[1]):
        e, at = el.active[q], 9 * q
        i, j = el.nodes[e, 0], el.nodes[e, 1]
        _join(cj, i // 3, net, matrix)
        _join(cj, j // 3, net, matrix)
        beside = max(coupling.places[e, 0, 1], coupling.places[e, 1, 0])
        count = _couple(i // 3, j // 3, beside, matrix, count)
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
    return count


@njit(forceinline=True, **OPTIONS)
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
    """The entry (r, c) of the blocks of both nodes and of the one between them."""
    if masked:
        A[r, c] += k * free[i + r] * free[i + c]
        B[r, c] += k * free[j + r] * free[j + c]
        C[r, c] -= k * free[low + r] * free[high + c]
    else:
        A[r, c] += k
        B[r, c] += k
        C[r, c] -= k


@njit(**OPTIONS)
def _add_elements(cj: float, net: Net, matrix: Matrix, coupling: Coupling, count: int) -> int:
    el = load(coupling.elements, Elements)
    k = el.nodes.shape[1]
    size, T, D = 9 * k * k, el.K, el.C
    for q in range(el.counts[1]):
        e, at = el.active[q], size * q
        for a in range(k):
            _join(cj, el.nodes[e, a] // 3, net, matrix)
        for a in range(k):
            for b in range(k):
                block = coupling.places[e, a, b]
                if block < 0:
                    continue
                i, j = el.nodes[e, a], el.nodes[e, b]
                if a != b:
                    count = _couple(i // 3, j // 3, block, matrix, count)
                for r in range(3):
                    for s in range(3):
                        one = at + ((3 * a + r) * k + b) * 3 + s
                        other = at + ((3 * b + s) * k + a) * 3 + r
                        value = -0.5 * (T[one] + T[other] + cj * (D[one] + D[other]))
                        _add(matrix, block, i, j, r, s, value)
    return count


@njit(**OPTIONS)
def _add_chain(cj: float, net: Net, matrix: Matrix, coupling: Coupling, count: int) -> int:
    el = load(coupling.elements, Elements)
    if el.rank[0] == 0:
        return count
    for a in range(el.nodes.shape[1]):
        _join(cj, el.nodes[0, a] // 3, net, matrix)
    chain = el.K.reshape((len(coupling.places), 2, 3, 2, 3))
    for p in range(len(chain)):
        i, j = coupling.nodes[p, 0, 0], coupling.nodes[p, 1, 0]
        beside = max(coupling.places[p, 0, 1], coupling.places[p, 1, 0])
        count = _couple(i // 3, j // 3, beside, matrix, count)
        for r in range(3):
            for s in range(3):
                _add(matrix, matrix.diagonal[i // 3], i, i, r, s, -chain[p, 0, r, 0, s])
                _add(matrix, matrix.diagonal[j // 3], j, j, r, s, -chain[p, 1, r, 1, s])
                if i < j:
                    _add(matrix, beside, i, j, r, s, -chain[p, 0, r, 1, s])
                else:
                    _add(matrix, beside, j, i, r, s, -chain[p, 1, r, 0, s])
    return count


@njit(forceinline=True, **OPTIONS)
def _add(matrix: Matrix, block: int, i: int, j: int, r: int, s: int, value: float) -> None:
    """The entry (r, s) of the block between entries i ≤ j gains a value, unless one of the axes is restrained."""
    if len(matrix.free):
        value *= matrix.free[i + r] * matrix.free[j + s]
    matrix.K[block, r, s] += value


@njit(**OPTIONS)
def _find_graph(net: Net, matrix: Matrix) -> int:
    """The members, which have place ≥ 0, in the order of elimination, and the blocks beside the diagonal by columns.

    A free node without mass that is none, or −1.
    Two elements between the same nodes put the same block there twice, which does no harm.
    """
    place, start, size, count = matrix.place, matrix.column_start, 0, matrix.counts[0]
    lost = -1
    for k in range(len(place)):
        node = matrix.order[k]
        if place[node] < 0 and net.mass[node] == 0.0:
            for c in range(3):
                if len(matrix.free) == 0 or matrix.free[3 * node + c] != 0.0:
                    lost = node
        if place[node] >= 0:
            place[node] = size
            matrix.members[size], matrix.member_diagonal[size] = node, matrix.diagonal[node]
            size += 1
    start[: size + 1] = 0
    for q in range(count):
        start[max(place[matrix.low[q]], place[matrix.high[q]]) + 1] += 1
    for k in range(size):
        start[k + 1] += start[k]
        matrix.flag[k] = start[k]
    for q in range(count):
        first, second = place[matrix.low[q]], place[matrix.high[q]]
        column = max(first, second)
        at = matrix.flag[column]
        matrix.flag[column] += 1
        matrix.row[at], matrix.source[at] = min(first, second), matrix.block[q]
        matrix.flipped[at] = first > second
    matrix.counts[1], matrix.counts[2] = size, count
    return lost


@njit(**OPTIONS)
def factor(cj: float, net: Net, matrix: Matrix, dyads: Dyads) -> int:
    """LDLᵀ of K, and its dyads; the node of a singular pivot, −2 where the dyads are singular, or −1."""
    size, blocks = matrix.counts[1], matrix.counts[2]
    start, row, source = matrix.column_start[: size + 1], matrix.row[:blocks], matrix.source[:blocks]
    present, parent, L_start = matrix.present[:blocks], matrix.parent[:size], matrix.L_start[: size + 1]
    flag = matrix.flag[:size]
    _symbolic(matrix.K, start, row, source, present, parent, L_start, flag)
    singular = _numeric(
        matrix.K,
        start,
        row,
        source,
        matrix.flipped,
        matrix.member_diagonal,
        present,
        parent,
        L_start,
        matrix.L_row,
        matrix.L,
        matrix.pivots,
        flag,
        matrix.L_count,
        matrix.path,
        matrix.stack,
        matrix.Y,
    )
    if singular >= 0:
        return matrix.members[singular]
    if len(dyads.elements) > 0:
        ldl = matrix.members[:size], matrix.L_start, matrix.L_row, matrix.L, matrix.pivots
        if not factor_dyads(dyads, cj, matrix.free, *ldl):
            return SINGULAR_DYADS
    return -1


@njit(**OPTIONS)
def _add_products(r1: FloatArray, net: Net, matrix: Matrix, right: FloatArray) -> None:
    """right (3n,) gains D r₁ of all blocks; restrained axes are not spared."""
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
            places = r1.ctypes.data, r1.ctypes.data, net.f.ctypes.data, 0, 0, net.sums.ctypes.data
            call(rows.add[coupling.row], (coupling.elements, *places))
            for k in range(len(right)):
                right[k] -= net.f[k]


@njit(**OPTIONS)
def solve(
    r: FloatArray, cj: float, cj_now: float, net: Net, matrix: Matrix, dyads: Dyads, z: FloatArray
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
    for k in range(n3):  # nodes that are no members
        z[k] = alone * matrix.inverse[k] * right[k]
    _solve(
        matrix.members[:size],
        matrix.L_start,
        matrix.L_row,
        matrix.L,
        matrix.pivots,
        right.reshape((len(net.mass), 3)),
        matrix.y,
    )
    if len(dyads.elements) > 0:
        complete(dyads, matrix.members[:size], right)
    for p in range(size):
        k = 3 * matrix.members[p]
        z[k], z[k + 1], z[k + 2] = scale * right[k], scale * right[k + 1], scale * right[k + 2]
    for k in range(n3):
        z[n3 + k] = cj * z[k] - scale * r1[k]
    for c in range(len(net.entry)):
        k = net.entry[c]
        z[k], z[n3 + k] = r1[k], r2[k]
