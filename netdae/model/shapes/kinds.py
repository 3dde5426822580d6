"""The rigid parts of a body as compiled code sees them, and where each kind of part keeps its numbers.

Frames: b is a point in the body's frame, q the same point in the part's, b = c + A q.

All numbers of all parts are in one array. Those of part p begin at a = first[p]:

    0-2     c, place of the part's origin in the body, m
    3-11    A, row after row; its columns are the part's axes in the body
    12      ρ, the offset, m: φ(q) = distance to the core of the part − ρ
    13-     the core, by kind

    SEGMENT   half its length: q = (0, 0, ±h). Spheres (h = 0) and capsules; ρ is their radius
    BOX       half its edges, (3,)
    FRUSTUM   r₁, z₁, r₂, z₂, the unit direction (t_r, t_z) from the first to the second, their distance; for cylinders
              and cones
    PLANE     nothing: the half-space q_z < 0
    HULL      number of faces; then for each face: outward normal (3,), offset, first number of its loop (from a),
              vertices of its loop; then the loops: for each vertex its place (3,), the unit direction t to the next
              (3,), the distance to the next, and the outward normal of this edge in the face, t × n (3,)
    GRID      place of its first node (3,), spacing, counts (3,), then signed distances, the last axis fastest
"""

from __future__ import annotations

from typing import NamedTuple

from netdae.core.arrays import Flags, FloatArray, Reals, Reals2, Wholes

SEGMENT, BOX, FRUSTUM, PLANE, HULL, GRID = range(6)

OFFSET = 12
CORE = 13
FACE = 6  # numbers of a face of a hull
VERTEX = 10  # numbers of a vertex in the loop of a face


class Parts(NamedTuple):
    """P parts of a body; a record of `core.records`.

    kind : (P,), SEGMENT to GRID; first : (P,), where the numbers of each begin; numbers : all of them
    centre : (P, 3), m, of a sphere that contains the part, in the body's frame; radius : (P,), m, inf for a plane
    lipschitz : (P,), largest |∇φ|: 1, but for grids, whose interpolation may exceed it
    convex : (P,), whether φ is convex
    """

    kind: Wholes
    first: Wholes
    numbers: Reals
    centre: Reals2
    radius: Reals
    lipschitz: Reals
    convex: Flags


class Core(NamedTuple):
    """One part in its own frame, as a row of `Parts` before it is placed; fields as there, `offset` is ρ."""

    kind: int
    offset: float
    numbers: FloatArray
    centre: tuple[float, float, float]
    radius: float
    lipschitz: float = 1.0
    convex: bool = True
