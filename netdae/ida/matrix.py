"""The Newton matrix of `ida.kernel`: assembled, factored, and the condensed solve of `linear_solver` with it.

K = c_j² M + c_j D + T in 3×3 blocks. Without Rayleigh damping it is factored over the ends of the taut cables only,
whose graph is found anew each time: elsewhere it is c_j² M. Symbols as in `linear_solver`.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.block_ldl import _numeric, _solve, _symbolic
from netdae.forces.cables import law_of
from netdae.ida.further import links_at
from netdae.ida.further_calls import add_further_blocks, add_further_products, complete, factor_further
from netdae.ida.kernel import OPTIONS, Net, look, parts_of
from netdae.kernels.cables import drag

SINGULAR_DYADS = -2  # what `factor` tells


class Matrix(NamedTuple):
    """K and its LDLᵀ, see `block_ldl`, over those nodes that are coupled at the moment, its members.

    Without Rayleigh damping these are the ends of the taut cables; elsewhere K is c_j² M, which needs no factor.
    """

    K: FloatArray  # (b, 3, 3)
    constant: FloatArray  # (b, 3, 3), D of Rayleigh damping, or none
    diagonal: IntArray  # (n,), block of each node
    beside: IntArray  # (m,), block of each cable's two nodes
    free: FloatArray  # (3n,), 0 on restrained axes, 1 on others; or none
    inverse: FloatArray  # (3n,), 1/mass, kg⁻¹
    taut: IntArray  # (m,), taut cables
    d: FloatArray  # (m, 3), their d
    c: FloatArray  # (m,), their viscosity over d dᵀ
    counts: IntArray  # (3,), of the taut cables, of the members, of the blocks beside the diagonal
    order: IntArray  # (n,), nodes in the order of elimination
    place: IntArray  # (n,), of each node among the members, −1 for others
    members: IntArray  # (n,)
    member_diagonal: IntArray  # (n,)
    column_start: IntArray  # the blocks beside the diagonal by columns, as in `block_ldl`
    row: IntArray
    source: IntArray
    flipped: BoolArray
    present: BoolArray
    parent: IntArray
    L_start: IntArray
    L_row: IntArray
    L: FloatArray
    pivots: FloatArray
    flag: IntArray
    L_count: IntArray
    path: IntArray
    stack: IntArray
    Y: FloatArray
    y: FloatArray
    right: FloatArray  # (3n,)
    right_by_node: FloatArray  # (n, 3), the same memory


@njit(**OPTIONS)
def assemble(t: float, y: FloatArray, cj: float, net: Net, matrix: Matrix) -> None:
    """K at y, with symmetric parts only, and the taut cables noted for the solves."""
    n3 = 3 * len(net.mass)
    x, v, cords, K, place = y[:n3], y[n3:], net.cords, matrix.K, matrix.place
    whole = len(matrix.constant) > 0
    if whole:
        for b in range(len(K)):
            for r in range(3):
                for s in range(3):
                    K[b, r, s] = cj * matrix.constant[b, r, s]
        for i in range(len(net.mass)):
            _add_mass(cj, i, net, matrix)
    else:
        for k in range(matrix.counts[0]):  # the blocks that the former one had
            K[matrix.beside[matrix.taut[k]]] = 0.0
        for k in range(matrix.counts[1]):
            place[matrix.members[k]] = -1
        if net.further != 0:
            _join_linked(cj, net, matrix)
    count, free, masked = 0, matrix.free, len(matrix.free) > 0
    for p in range(look(x, cords, net.near)):
        e = net.near.cables[p]
        i, j = cords.ends[e, 0], cords.ends[e, 1]
        d = (x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2])
        excess = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - cords.L2[e]
        if excess < 0.0:
            continue
        w = (v[j] - v[i], v[j + 1] - v[i + 1], v[j + 2] - v[i + 2])
        rate = d[0] * w[0] + d[1] * w[1] + d[2] * w[2]
        elastic, viscous = parts_of(cords, e, excess, rate)
        q = elastic + viscous
        if q < 0.0:
            continue
        for node in (i // 3, j // 3):
            if not whole and place[node] < 0:
                place[node] = 0
                K[matrix.diagonal[node]] = 0.0
                _add_mass(cj, node, net, matrix)
        dg, ddg = 1.0, 0.0
        if not cords.plain:
            _, dg, ddg, _ = law_of(0.5 * excess / cords.L2[e], cords.eps[e], cords.engineering[e])
        c = cords.viscous[e] * dg
        matrix.taut[count], matrix.c[count] = e, c
        matrix.d[count, 0], matrix.d[count, 1], matrix.d[count, 2] = d
        count += 1
        along = 2.0 * cords.half[e] * dg + cords.viscous[e] * ddg * rate / cords.L2[e] + cj * c
        A, B, C = K[matrix.diagonal[i // 3]], K[matrix.diagonal[j // 3]], K[matrix.beside[e]]
        low, high = min(i, j), max(i, j)
        for r in range(3):
            for s in range(3):
                k = along * d[r] * d[s] + 0.5 * c * (d[r] * w[s] + w[r] * d[s])
                if r == s:
                    k += q
                if masked:
                    A[r, s] += k * free[i + r] * free[i + s]
                    B[r, s] += k * free[j + r] * free[j + s]
                    C[r, s] -= k * free[low + r] * free[high + s]
                else:
                    A[r, s] += k
                    B[r, s] += k
                    C[r, s] -= k
    matrix.counts[0] = count
    if net.further != 0:
        add_further_blocks(net.further, t, cj, x, v, free, matrix.diagonal, K)
    if not whole:
        _find_graph(net, matrix)


@njit(**OPTIONS)
def _add_mass(cj: float, node: int, net: Net, matrix: Matrix) -> None:
    """c_j² m on the diagonal block of a node, and 1 on its restrained axes, whose rows are else zero."""
    block = matrix.K[matrix.diagonal[node]]
    for r in range(3):
        block[r, r] += cj * cj * net.mass[node]
        if len(matrix.free):
            block[r, r] += 1.0 - matrix.free[3 * node + r]


@njit(**OPTIONS)
def _join_linked(cj: float, net: Net, matrix: Matrix) -> None:
    """Nodes of reels and cords through rings are members always; their blocks begin anew."""
    links = links_at(net.further)
    for b in links.block:
        matrix.K[b] = 0.0
    for node in links.nodes:
        matrix.place[node] = 0
        matrix.K[matrix.diagonal[node]] = 0.0
        _add_mass(cj, node, net, matrix)


@njit(**OPTIONS)
def _find_graph(net: Net, matrix: Matrix) -> None:
    """The members, which have place ≥ 0, in the order of elimination, and the blocks beside the diagonal by columns.

    Two cables between the same nodes put the same block there twice, which does no harm.
    """
    place, start, ends = matrix.place, matrix.column_start, net.cords.ends
    size, count = 0, matrix.counts[0]
    for k in range(len(place)):
        node = matrix.order[k]
        if place[node] >= 0:
            place[node] = size
            matrix.members[size], matrix.member_diagonal[size] = node, matrix.diagonal[node]
            size += 1
    start[: size + 1] = 0
    for q in range(count):
        e = matrix.taut[q]
        start[max(place[ends[e, 0] // 3], place[ends[e, 1] // 3]) + 1] += 1
    if net.further != 0:
        links = links_at(net.further)
        for q in range(len(links.block)):
            start[max(place[links.low[q]], place[links.high[q]]) + 1] += 1
        count += len(links.block)
    for k in range(size):
        start[k + 1] += start[k]
        matrix.flag[k] = start[k]
    for q in range(matrix.counts[0]):
        e = matrix.taut[q]
        i, j = ends[e, 0] // 3, ends[e, 1] // 3
        _put_block(matrix, min(i, j), max(i, j), matrix.beside[e])
    if net.further != 0:
        links = links_at(net.further)
        for q in range(len(links.block)):
            _put_block(matrix, links.low[q], links.high[q], links.block[q])
    matrix.counts[1], matrix.counts[2] = size, count


@njit(**OPTIONS)
def _put_block(matrix: Matrix, low: int, high: int, block: int) -> None:
    """The block of two nodes into its column, which has flag entries already."""
    first, second = matrix.place[low], matrix.place[high]
    column = max(first, second)
    at = matrix.flag[column]
    matrix.flag[column] += 1
    matrix.row[at], matrix.source[at] = min(first, second), block
    matrix.flipped[at] = first > second


@njit(**OPTIONS)
def factor(cj: float, net: Net, matrix: Matrix) -> int:
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
    if net.further != 0:
        ldl = matrix.members[:size], matrix.L_start, matrix.L_row, matrix.L, matrix.pivots
        if not factor_further(net.further, cj, matrix.free, *ldl):
            return SINGULAR_DYADS
    return -1


@njit(**OPTIONS)
def solve(r: FloatArray, cj: float, cj_now: float, net: Net, matrix: Matrix, z: FloatArray) -> None:
    """Solution z of J z = r with the factor made for c_j, scaled by 2/(1 + c_j,now/c_j) as in IDA's direct solvers."""
    n3 = 3 * len(net.mass)
    r1, r2 = r[:n3], r[n3:]
    right, cords, held = matrix.right, net.cords, net.held
    for i in range(len(net.mass)):
        for c in range(3):
            k = 3 * i + c
            right[k] = r2[k] + cj * net.mass[i] * r1[k]
    for q in range(matrix.counts[0]):
        i, j = cords.ends[matrix.taut[q], 0], cords.ends[matrix.taut[q], 1]
        d0, d1, d2 = matrix.d[q, 0], matrix.d[q, 1], matrix.d[q, 2]
        along = matrix.c[q] * (
            d0 * (r1[j] - r1[i]) + d1 * (r1[j + 1] - r1[i + 1]) + d2 * (r1[j + 2] - r1[i + 2])
        )
        right[i] -= along * d0
        right[i + 1] -= along * d1
        right[i + 2] -= along * d2
        right[j] += along * d0
        right[j + 1] += along * d1
        right[j + 2] += along * d2
    if len(net.drags.ends) > 0 or len(net.drags.alpha) > 0:
        drag(r1, net.drags, net.f)
        for k in range(n3):
            right[k] -= net.f[k]
    if net.further != 0:
        add_further_products(net.further, r1, right)
    for c in range(len(held.entry)):
        right[held.entry[c]] = 0.0
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
        matrix.right_by_node,
        matrix.y,
    )
    if net.further != 0:
        complete(net.further, matrix.members[:size], right)
    for p in range(size):
        k = 3 * matrix.members[p]
        z[k], z[k + 1], z[k + 2] = scale * right[k], scale * right[k + 1], scale * right[k + 2]
    for k in range(n3):
        z[n3 + k] = cj * z[k] - scale * r1[k]
    for c in range(len(held.entry)):
        k = held.entry[c]
        z[k], z[n3 + k] = r1[k], r2[k]
