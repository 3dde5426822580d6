"""Blocks of the compiled Newton matrix that reels, drums and cords through rings bring, and their products.

K = c_j² M + c_j D + T takes the symmetric parts of T = −∂f/∂x and D = −∂f/∂v, see `linear_solver`.
"""

from __future__ import annotations

from numba import njit

from netdae._arrays import FloatArray, IntArray
from netdae.forces.reel import SHORTEST, reeled_tangents
from netdae.ida.further import Links, Winding, links_at, tangents_at, winding_at
from netdae.ida.reels import braked, gather_reeled, stopped
from netdae.kernels.strings import motor_slope, string_tangents

_PAIRS = ((0, 1), (0, 2), (1, 2))


@njit(cache=True)
def add_links(
    address: int, x: FloatArray, v: FloatArray, cj: float, free: FloatArray, diagonal: IntArray, K: FloatArray
) -> None:
    """Add the symmetric parts of all blocks to K, and keep the tangents for the products with D."""
    w, links = winding_at(address), links_at(address)
    _add_reeled(w, links, x, v, cj, free, diagonal, K)
    _add_drums(w, links, x, v, cj, free, diagonal, K)
    if len(w.strings.L):
        _add_chains(address, w, links, x, v, free, diagonal, K)


@njit(cache=True)
def _add(K: FloatArray, block: int, i: int, j: int, r: int, c: int, value: float, free: FloatArray) -> None:
    """The entry (r, c) of the block between nodes i and j gains a value, unless one of the axes is restrained."""
    if len(free):
        value *= free[3 * i + r] * free[3 * j + c]
    if i <= j:
        K[block, r, c] += value
    else:
        K[block, c, r] += value


@njit(cache=True)
def _add_reeled(
    w: Winding,
    links: Links,
    x: FloatArray,
    v: FloatArray,
    cj: float,
    free: FloatArray,
    diagonal: IntArray,
    K: FloatArray,
) -> None:
    reels, room, count = w.reels, w.on_reels, 0
    gather_reeled(x, v, reels, room, SHORTEST)
    for e in range(len(reels.L)):
        square = 0.0
        for c in range(3):
            square += (room.x[e, 1, c] - room.x[e, 0, c]) ** 2
        if square >= room.L[e] * room.L[e]:
            links.taut[count] = e
            count += 1
    links.number[0] = count
    if count == 0:
        return
    law = reels.share, reels.EA, reels.eps, reels.engineering, reels.tau
    by_x, by_v = links.K[:count], links.C[:count]
    reeled_tangents(room.x, room.v, links.taut[:count], room.L, *law, by_x, by_v)
    for q in range(count):
        e = links.taut[q]
        for a in range(3):
            i = reels.ends[e, a] // 3
            for r in range(3):
                for c in range(3):
                    _add(K, diagonal[i], i, i, r, c, _symmetric(by_x[q], by_v[q], cj, a, r, a, c), free)
        for p in range(3):
            a, b = _PAIRS[p]
            i, j = reels.ends[e, a] // 3, reels.ends[e, b] // 3
            for r in range(3):
                for c in range(3):
                    value = _symmetric(by_x[q], by_v[q], cj, a, r, b, c)
                    _add(K, links.corners[e, p], i, j, r, c, value, free)


@njit(cache=True)
def _symmetric(by_x: FloatArray, by_v: FloatArray, cj: float, a: int, r: int, b: int, c: int) -> float:
    """An entry of the symmetric part of T + c_j D."""
    return -0.5 * (by_x[a, r, b, c] + by_x[b, c, a, r] + cj * (by_v[a, r, b, c] + by_v[b, c, a, r]))


@njit(cache=True)
def _add_drums(
    w: Winding,
    links: Links,
    x: FloatArray,
    v: FloatArray,
    cj: float,
    free: FloatArray,
    diagonal: IntArray,
    K: FloatArray,
) -> None:
    for d in range(len(links.drums)):
        entry = links.drums[d]
        T = D = 0.0
        for b in range(len(w.brakes.entry)):
            if w.brakes.entry[b] == entry:
                D -= braked(v, w.brakes, b)[1]
        for m in range(len(w.motors.entry)):
            if w.motors.entry[m] == entry:
                D -= motor_slope(v, w.motors, m)
        for e in range(len(w.stops.entry)):
            if w.stops.entry[e] == entry and stopped(x, v, w.stops, e)[0] > 0.0:
                T += w.stops.stiffness[e]
                D += w.stops.viscosity[e]
        links.D[d] = D
        _add(K, diagonal[entry // 3], entry // 3, entry // 3, 0, 0, T + cj * D, free)


@njit(cache=True)
def _add_chains(
    address: int,
    w: Winding,
    links: Links,
    x: FloatArray,
    v: FloatArray,
    free: FloatArray,
    diagonal: IntArray,
    K: FloatArray,
) -> None:
    strings, tangents = w.strings, tangents_at(address)
    string_tangents(x, v, strings, w.on_strings, tangents)
    for s in range(len(strings.L)):
        if tangents.rank[s] == 0:
            continue
        at, rings = strings.begin[s], strings.begin[s + 1] - strings.begin[s] - 1
        for p in range(strings.first[s], strings.first[s + 1]):
            one = p - strings.first[s]
            i, j = strings.entry[at + one] // 3, strings.entry[at + (one + 1) % rings] // 3
            for r in range(3):
                for c in range(3):
                    _add(K, diagonal[i], i, i, r, c, -tangents.chain[p, 0, r, 0, c], free)
                    _add(K, diagonal[j], j, j, r, c, -tangents.chain[p, 1, r, 1, c], free)
                    _add(K, links.chain[p], i, j, r, c, -tangents.chain[p, 0, r, 1, c], free)


@njit(cache=True)
def add_link_products(address: int, r1: FloatArray, right: FloatArray) -> None:
    """right (3n,) gains D r₁, with what `add_links` left of D; restrained axes are not spared."""
    w, links = winding_at(address), links_at(address)
    for q in range(links.number[0]):
        ends, C = w.reels.ends[links.taut[q]], links.C[q]
        for a in range(3):
            for r in range(3):
                total = 0.0
                for b in range(3):
                    for c in range(3):
                        total += (C[a, r, b, c] + C[b, c, a, r]) * r1[ends[b] + c]
                right[ends[a] + r] -= 0.5 * total
    for d in range(len(links.drums)):
        right[links.drums[d]] += links.D[d] * r1[links.drums[d]]
