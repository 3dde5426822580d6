"""Patterns of plane nets: nodes, cables and groups as plain arrays.

Every net lies in the xy plane and is centred at the origin. Its border cables come first and run once around
it, anticlockwise, as one closed loop. The group centre holds the crossings nearest to the origin: one node
where the pattern has a crossing there, else all that are equally near (four in a square net of odd `cells`).
Knots that `subdivide` puts into a cable belong to border where the cable does, and never to centre.
"""

from __future__ import annotations

import math
import operator
from typing import NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import InputError

LARGEST = 1_000_000
"""Most nodes that a generated net may have: a mistyped number beyond it would fill the memory."""


LONGEST = 1e6
"""Longest side of a generated net, m: nets are metres wide, and beyond this, positions lose micrometres."""


class Pattern(NamedTuple):
    """Arrays of a generated net.

    nodes (n, 3) in m; cables (m, 2); groups by name to indices:
    node groups border, corners, centre; cable groups border, inner.
    """

    nodes: FloatArray
    cables: IntArray
    node_groups: dict[str, IntArray]
    cable_groups: dict[str, IntArray]


def square(*, side: float, cells: int, subdivide: int = 1) -> Pattern:
    """Square of `side` m with `cells` × `cells` square meshes; corners: its four, anticlockwise."""
    length, count = _length("square", "side", side), _count("square", "cells", cells)
    pieces = _count("square", "subdivide", subdivide)
    return _grid("square", length, length, count, count, pieces)


def rectangle(*, width: float, height: float, columns: int, rows: int, subdivide: int = 1) -> Pattern:
    """`columns` × `rows` meshes over width (x) × height (y) in m; corners: its four, anticlockwise."""
    size = _length("rectangle", "width", width), _length("rectangle", "height", height)
    i, j = _count("rectangle", "columns", columns), _count("rectangle", "rows", rows)
    return _grid("rectangle", *size, i, j, _count("rectangle", "subdivide", subdivide))


def _grid(pattern: str, width: float, height: float, i: int, j: int, pieces: int) -> Pattern:
    """Net of `i` × `j` rectangular meshes."""
    _check_size(pattern, (i + 1) * (j + 1) + (pieces - 1) * (2 * i * j + i + j))
    ids = np.arange((i + 1) * (j + 1)).reshape(i + 1, j + 1)
    x = (np.arange(i + 1) - i / 2) * (width / i)
    y = (np.arange(j + 1) - j / 2) * (height / j)
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    border = np.concatenate([ids[:-1, 0], ids[-1, :-1], ids[:0:-1, -1], ids[0, :0:-1]])
    along = np.stack([ids[:-1, 1:-1], ids[1:, 1:-1]], axis=-1).reshape(-1, 2)
    across = np.stack([ids[1:-1, :-1], ids[1:-1, 1:]], axis=-1).reshape(-1, 2)
    corners = ids[[0, -1, -1, 0], [0, 0, -1, -1]]
    return _pattern(points, border, np.concatenate([along, across]), corners, pieces)


def hexagon(*, radius: float, rings: int, subdivide: int = 1) -> Pattern:
    """Regular hexagon of triangular meshes, corners at `radius` m; corners: six, anticlockwise from +x."""
    reach, n = _length("hexagon", "radius", radius), _count("hexagon", "rings", rings)
    pieces = _count("hexagon", "subdivide", subdivide)
    _check_size("hexagon", 3 * n * (n + 1) + 1 + (pieces - 1) * (9 * n * n + 3 * n))
    # oblique steps q along 0° and r along 60°, and ids of the nodes on their grid, −1 outside of the hexagon
    q, r = (step.ravel() for step in np.meshgrid(*2 * [np.arange(-n, n + 1)], indexing="ij"))
    inside = np.abs(q + r) <= n
    ids = np.full((2 * n + 1, 2 * n + 1), -1)
    ids[q[inside] + n, r[inside] + n] = np.arange(np.count_nonzero(inside))
    h = reach / n
    points = np.column_stack([q + r / 2, r * (math.sqrt(3) / 2)])[inside] * h
    turn = np.array([(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)])
    walk = turn[:, None, :] * n + np.roll(turn, -2, axis=0)[:, None, :] * np.arange(n)[:, None]
    border = ids[walk[..., 0] + n, walk[..., 1] + n].ravel()
    pairs = [
        np.stack([ids[:-1, :], ids[1:, :]], axis=-1),
        np.stack([ids[:, :-1], ids[:, 1:]], axis=-1),
        np.stack([ids[1:, :-1], ids[:-1, 1:]], axis=-1),
    ]
    cables = np.concatenate([pair.reshape(-1, 2) for pair in pairs])
    cables = cables[(cables >= 0).all(axis=1)]
    edge = _keys(np.column_stack([border, np.roll(border, -1)]))
    inner = cables[~np.isin(_keys(cables), edge)]
    return _pattern(points, border, inner, border[::n], pieces)


def radial(*, radius: float, rings: int, spokes: int, subdivide: int = 1) -> Pattern:
    """Spider web of `spokes` radial cables and `rings` closed rings out to `radius` m.

    The rings run straight from spoke to spoke; corners: the outer ends of the spokes, anticlockwise from +x.
    """
    reach, n = _length("radial", "radius", radius), _count("radial", "rings", rings)
    s = _count("radial", "spokes", spokes, least=3)
    pieces = _count("radial", "subdivide", subdivide)
    _check_size("radial", 1 + n * s + (pieces - 1) * 2 * n * s)
    angle = 2 * math.pi * np.arange(s) / s
    ray = np.column_stack([np.cos(angle), np.sin(angle)])
    points = np.concatenate(
        [np.zeros((1, 2)), ((np.arange(1, n + 1) / n * reach)[:, None, None] * ray).reshape(-1, 2)]
    )
    ids = 1 + np.arange(n * s).reshape(n, s)
    inward = np.concatenate([np.zeros((1, s), dtype=int), ids[:-1]])
    spoke = np.stack([inward, ids], axis=-1).reshape(-1, 2)
    ring = np.stack([ids, np.roll(ids, -1, axis=1)], axis=-1)[:-1].reshape(-1, 2)
    return _pattern(points, ids[-1], np.concatenate([spoke, ring]), ids[-1], pieces)


def diamond(*, side: float, cells: int, subdivide: int = 1) -> Pattern:
    """Square border of `side` m, meshes turned by 45° inside, `cells` of their diagonals along a side.

    corners: the four of the border, anticlockwise.
    """
    length, n = _length("diamond", "side", side), _count("diamond", "cells", cells)
    pieces = _count("diamond", "subdivide", subdivide)
    _check_size("diamond", 2 * n * (n + 1) + 1 + (pieces - 1) * 4 * n * (n + 1))
    # a grid of half diagonals: crossings where i + j is even, one cable through each of its squares
    i, j = (step.ravel() for step in np.meshgrid(*2 * [np.arange(2 * n + 1)], indexing="ij"))
    even = (i + j) % 2 == 0
    ids = np.full((2 * n + 1, 2 * n + 1), -1)
    ids[i[even], j[even]] = np.arange(np.count_nonzero(even))
    points = (np.column_stack([i, j])[even] - n) * (length / (2 * n))
    rising = np.stack([ids[:-1, :-1], ids[1:, 1:]], axis=-1).reshape(-1, 2)
    falling = np.stack([ids[1:, :-1], ids[:-1, 1:]], axis=-1).reshape(-1, 2)
    inner = np.where(rising[:, :1] >= 0, rising, falling)
    border = np.concatenate([ids[:-2:2, 0], ids[-1, :-2:2], ids[:1:-2, -1], ids[0, :1:-2]])
    return _pattern(points, border, inner, ids[[0, -1, -1, 0], [0, 0, -1, -1]], pieces)


def _pattern(
    points: FloatArray, border: IntArray, inner: IntArray, corners: IntArray, pieces: int
) -> Pattern:
    """Pattern of plane points (n, 2), the closed walk `border` (b,) and inner cables, each in `pieces`."""
    distance = np.hypot(points[:, 0], points[:, 1])
    # crossings that are equally near are mirror images to the last bit
    centre = np.flatnonzero(distance == distance.min())
    cables = np.concatenate([np.column_stack([border, np.roll(border, -1)]), inner])
    count, edge = len(points), len(border)
    nodes = np.column_stack([points, np.zeros(count)])
    if pieces > 1:
        start, end = nodes[cables[:, 0]], nodes[cables[:, 1]]
        share = np.arange(1, pieces)[None, :, None] / pieces
        knots = start[:, None] * (1 - share) + end[:, None] * share
        ids = count + np.arange(len(cables) * (pieces - 1)).reshape(len(cables), pieces - 1)
        chain = np.column_stack([cables[:, 0], ids, cables[:, 1]])
        nodes = np.concatenate([nodes, knots.reshape(-1, 3)])
        cables = np.stack([chain[:, :-1], chain[:, 1:]], axis=-1).reshape(-1, 2)
        border = np.concatenate([border, ids[:edge].ravel()])
    edge *= pieces
    return Pattern(
        nodes,
        cables.astype(np.int64),
        {"border": np.sort(border), "corners": corners, "centre": centre},
        {"border": np.arange(edge), "inner": np.arange(edge, len(cables))},
    )


def _keys(cables: IntArray) -> IntArray:
    """One number per cable, the same in both directions."""
    return np.asarray(cables.min(axis=1) * (LARGEST + 1) + cables.max(axis=1))


def _length(pattern: str, name: str, value: float) -> float:
    try:
        length = float(value)
    except (TypeError, ValueError):
        length = math.nan
    if isinstance(value, bool | str) or not 0 < length <= LONGEST:
        shown = f"{value:.6g}" if isinstance(value, float) else repr(value)
        raise InputError(f"{pattern} net: {name} is {shown}, give a length above zero, {LONGEST:g} m at most")
    return length


def _count(pattern: str, name: str, value: int, *, least: int = 1) -> int:
    try:
        count = operator.index(value)
    except TypeError:
        count = least - 1
    if isinstance(value, bool) or count < least:
        raise InputError(f"{pattern} net: {name} is {value!r}, give a whole number of at least {least}")
    return count


def _check_size(pattern: str, count: int) -> None:
    if count > LARGEST:
        raise InputError(
            f"{pattern} net: it would have {count} nodes, at most {LARGEST} are made: make it coarser"
        )
