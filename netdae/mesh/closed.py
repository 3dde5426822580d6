"""A triangle mesh made closed and consistently wound, with what was repaired in words."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.core.errors import MeshError
from netdae.mesh.closest import signed_distances, tree_of
from netdae.mesh.crossing import crossing_of
from netdae.mesh.findings import many
from netdae.model.shapes.solid import of_surface
from netdae.model.shapes.surfaces import Surface, distinct

_NEAR = 1e-9  # of the size: points closer than this are one; files keep seven digits or more


class _Pairs(NamedTuple):
    """The two triangles at each edge: `one` and `other` (E,), and whether both run along it the same way, (E,)."""

    one: IntArray
    other: IntArray
    same_way: BoolArray


def closed_surface(points: FloatArray, triangles: IntArray) -> tuple[Surface, list[str]]:
    """The surface with each point once, counter-clockwise seen from outside, and notes on what was repaired.

    Raises MeshError if it has no triangles, is open, branches, has one side only, or crosses itself.
    """
    notes: list[str] = []
    surface = _without_doubles(points, triangles, notes)
    pairs = _pairs(surface)
    wound = _wound(surface, pairs, notes)
    tree = tree_of(*wound)
    count, edge, triangle = crossing_of(tree, wound.triangles, wound.points)
    if count:
        raise MeshError(
            f"the surface crosses itself: {many(count, 'edge')} through a triangle, first at "
            f"{_place(wound.points[edge].mean(axis=0))} m, through triangle {triangle + 1}: mend it in the program "
            "that made it, or give its parts one by one"
        )
    return _outward(wound, pairs, notes), notes


def _without_doubles(points: FloatArray, triangles: IntArray, notes: list[str]) -> Surface:
    if not len(triangles):
        raise MeshError(
            "the file has no triangles: a target needs a closed surface, not a net of lines or points"
        )
    if not np.isfinite(points).all():
        raise MeshError("a point of the surface is not a finite number: correct the file")
    size = float(np.ptp(points, axis=0).max())
    if size == 0.0:
        raise MeshError("all points of the surface are at one place: correct the file")
    first, same = distinct(points, _NEAR * size)
    triangles = same[triangles]
    a, b, c = triangles.T
    flat = (a == b) | (b == c) | (c == a)
    if flat.any():
        notes.append(f"{many(int(flat.sum()), 'triangle')} with two corners at one place dropped")
    triangles = triangles[~flat]
    _, once = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    if len(once) < len(triangles):
        notes.append(f"{many(len(triangles) - len(once), 'triangle')} given twice, kept once")
    triangles = triangles[np.sort(once)]
    used, renamed = np.unique(triangles, return_inverse=True)
    return Surface(points[first[used]], renamed.reshape(-1, 3).astype(np.int64))


def _pairs(surface: Surface) -> _Pairs:
    triangles = surface.triangles
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    upward = ends[:, 0] < ends[:, 1]
    edges, edge, count = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True, return_counts=True)
    for wrong, state, what in (
        (count == 1, "open", "belong to one triangle only"),
        (count > 2, "branched", "join three triangles or more"),
    ):
        if wrong.any():
            which = np.flatnonzero(wrong)
            a, b = surface.points[edges[which[0]]]
            raise MeshError(
                f"the surface is {state}: {len(which)} of {len(edges)} edges {what}, the first from {_place(a)} to "
                f"{_place(b)} m: close it in the program that made it"
            )
    order = np.argsort(edge.reshape(-1), kind="stable").reshape(-1, 2)
    return _Pairs(order[:, 0] // 3, order[:, 1] // 3, upward[order[:, 0]] == upward[order[:, 1]])


def _wound(surface: Surface, pairs: _Pairs, notes: list[str]) -> Surface:
    """Neighbours run along their edge in opposite ways; the larger part of each piece stays as it is."""
    if not pairs.same_way.any():
        return surface
    count = len(surface.triangles)
    graph = coo_array((np.ones(len(pairs.one)), (pairs.one, pairs.other)), shape=(count, count)).tocsr()
    pieces, piece = connected_components(graph, directed=False)
    unlike: dict[tuple[int, int], bool] = {}
    for a, b, same in zip(pairs.one.tolist(), pairs.other.tolist(), pairs.same_way.tolist(), strict=True):
        unlike[a, b] = unlike[b, a] = same
    turned = np.zeros(count, dtype=bool)
    for k in range(pieces):
        members = np.flatnonzero(piece == k)
        order, before = breadth_first_order(graph, members[0], directed=False)
        for each in order[1:]:
            turned[each] = turned[before[each]] ^ unlike[int(before[each]), int(each)]
        if 2 * np.count_nonzero(turned[members]) > len(members):
            turned[members] = ~turned[members]
    if (turned[pairs.one] ^ turned[pairs.other] != pairs.same_way).any():
        raise MeshError(
            "the surface has one side only, like a Möbius strip, so no inside: mend it in the program that made it"
        )
    notes.append(f"{many(int(turned.sum()), 'triangle')} wound against the others turned round")
    return _turned(surface, turned)


def _outward(surface: Surface, pairs: _Pairs, notes: list[str]) -> Surface:
    """Pieces have their outside outside: a positive volume, or a negative one for a void in another piece."""
    count = len(surface.triangles)
    graph = coo_array((np.ones(len(pairs.one)), (pairs.one, pairs.other)), shape=(count, count))
    pieces, piece = connected_components(graph, directed=False)
    solids = [Surface(surface.points, surface.triangles[piece == k]) for k in range(pieces)]
    volumes = [of_surface(each).mass for each in solids]
    size = float(np.ptp(surface.points, axis=0).max())
    if min(abs(volume) for volume in volumes) < (_NEAR * size) * size**2:
        raise MeshError("a piece of the surface has no volume: it is flat, remove it or give it a thickness")
    turned = np.zeros(count, dtype=bool)
    for k in range(pieces):
        start = surface.points[solids[k].triangles[0]].mean(axis=0)[None]
        around = 0
        for other in range(pieces):
            if other != k:
                inside = _signed(solids[other], volumes[other], start)[0] < 0.0
                around += int(inside)
        if (volumes[k] > 0.0) != (around % 2 == 0):
            turned |= piece == k
    if turned.any():
        what = (
            "the surface was"
            if pieces == 1
            else f"{many(int(turned.sum()), 'triangle')} of {pieces} pieces were"
        )
        notes.append(f"{what} inside out, turned round")
    return _turned(surface, turned)


def _signed(solid: Surface, volume: float, points: FloatArray) -> FloatArray:
    distance = signed_distances(tree_of(*solid), solid.triangles, points)
    return distance if volume > 0.0 else -distance


def _turned(surface: Surface, which: BoolArray) -> Surface:
    triangles = surface.triangles.copy()
    triangles[which] = triangles[which][:, ::-1]
    return Surface(surface.points, triangles)


def _place(point: FloatArray) -> str:
    return "(" + ", ".join(f"{x:.4g}" for x in point) + ")"
