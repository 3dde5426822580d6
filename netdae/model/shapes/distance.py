"""Signed distance φ to a rigid part, its gradient n = ∇φ and its Hessian ∇∇φ, compiled.

φ is negative inside. Each part is a sharp core and an offset ρ, φ = d(q) − ρ, with d the signed distance to the core,
see `kinds`. Outside a convex core d = |q − y| with y its closest point, which is unique, so

    n = (q − y)/d,      ∇∇d = (P − n nᵀ)/d,

where P projects on the directions in which y does not follow q: P = I if y is a vertex, I − t tᵀ if it is on an edge
along t, and ∇∇d = 0 if it is on a face. On curved faces of revolution, with the profile's distance d(r, z),

    n = d_r e_r + d_z e_z,      ∇∇d = (the profile's own) + (d_r/r) e_φ e_φᵀ.

Inside a convex core d is the largest of the distances to the planes of its faces, all negative: exact, since the
closest point of the boundary of a convex polytope is on the face whose plane is the closest. So d is convex, and it has
slope 1, everywhere. It has a kink only where the core has its medial axis, deeper than ρ, and for ρ = 0 on its edges.
Where n is not defined it is one of the unit vectors at hand, and the Hessian is 0; neither is ever not-a-number.

A grid is interpolated trilinearly. Its n is the exact gradient of the interpolation, so that force and energy belong
together; it is no unit vector, see `SurfaceMesh.lipschitz`. With e the vector from the closest point of the grid's box
and g the value there, φ = √(g² + e²) outside of the box: a lower bound of the distance, continuous at the box.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.compilation import OPTIONS
from netdae.core.records import load
from netdae.model.shapes.cores import Curved, box, frustum, grid, hull, inlined, segment
from netdae.model.shapes.kinds import BOX, CORE, FRUSTUM, HULL, OFFSET, PLANE, SEGMENT, Parts

Distance = tuple[float, float, float, float]
"""φ, and n as x, y, z."""


@inlined
def signed_distance(kind: int, first: int, numbers: FloatArray, bx: float, by: float, bz: float) -> Distance:
    """(φ, n_x, n_y, n_z) of a part at a point of the body's frame, in its axes; to be inlined.

    kind, first : of the part, see `kinds.Parts`; numbers : of all parts
    """
    # what is not used is optimised away
    phi, nx, ny, nz, _, _, _, _, _, _ = curvature(kind, first, numbers, bx, by, bz)
    return phi, nx, ny, nz


@inlined
def curvature(kind: int, first: int, numbers: FloatArray, bx: float, by: float, bz: float) -> Curved:
    """(φ, n_x, n_y, n_z, H_xx, H_yy, H_zz, H_xy, H_xz, H_yz) of a part, H = ∇∇φ; to be inlined."""
    x, y, z = bx - numbers[first], by - numbers[first + 1], bz - numbers[first + 2]
    a00, a01, a02 = numbers[first + 3], numbers[first + 4], numbers[first + 5]
    a10, a11, a12 = numbers[first + 6], numbers[first + 7], numbers[first + 8]
    a20, a21, a22 = numbers[first + 9], numbers[first + 10], numbers[first + 11]
    qx, qy, qz = a00 * x + a10 * y + a20 * z, a01 * x + a11 * y + a21 * z, a02 * x + a12 * y + a22 * z
    core = first + CORE
    if kind == SEGMENT:
        of_core = segment(numbers[core], qx, qy, qz)
    elif kind == BOX:
        of_core = box(numbers[core], numbers[core + 1], numbers[core + 2], qx, qy, qz)
    elif kind == FRUSTUM:
        of_core = frustum(numbers, core, qx, qy, qz)
    elif kind == PLANE:
        of_core = qz, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    elif kind == HULL:
        of_core = hull(numbers, first, qx, qy, qz)
    else:
        of_core = grid(numbers, core, qx, qy, qz)
    d, mx, my, mz, h00, h11, h22, h01, h02, h12 = of_core
    # H A, then A (H A) with the transpose on the right
    g00, g01, g02 = (
        a00 * h00 + a01 * h01 + a02 * h02,
        a00 * h01 + a01 * h11 + a02 * h12,
        a00 * h02 + a01 * h12 + a02 * h22,
    )
    g10, g11, g12 = (
        a10 * h00 + a11 * h01 + a12 * h02,
        a10 * h01 + a11 * h11 + a12 * h12,
        a10 * h02 + a11 * h12 + a12 * h22,
    )
    g20, g21, g22 = (
        a20 * h00 + a21 * h01 + a22 * h02,
        a20 * h01 + a21 * h11 + a22 * h12,
        a20 * h02 + a21 * h12 + a22 * h22,
    )
    return (
        d - numbers[first + OFFSET],
        a00 * mx + a01 * my + a02 * mz,
        a10 * mx + a11 * my + a12 * mz,
        a20 * mx + a21 * my + a22 * mz,
        g00 * a00 + g01 * a01 + g02 * a02,
        g10 * a10 + g11 * a11 + g12 * a12,
        g20 * a20 + g21 * a21 + g22 * a22,
        g00 * a10 + g01 * a11 + g02 * a12,
        g00 * a20 + g01 * a21 + g02 * a22,
        g10 * a20 + g11 * a21 + g12 * a22,
    )


@njit(cache=True, **OPTIONS)
def distance_at(address: int, part: int, bx: float, by: float, bz: float) -> Distance:
    """`signed_distance` of a part of the `Parts` at the address of their record; a call, not inlined."""
    p = load(address, Parts)
    return signed_distance(p.kind[part], p.first[part], p.numbers, bx, by, bz)


@njit(cache=True, **OPTIONS)
def curvature_at(address: int, part: int, bx: float, by: float, bz: float) -> Curved:
    """`curvature` of a part of the `Parts` at the address of their record; a call, not inlined."""
    p = load(address, Parts)
    return curvature(p.kind[part], p.first[part], p.numbers, bx, by, bz)


@njit(cache=True, **OPTIONS)
def curvatures(kind: int, first: int, numbers: FloatArray, points: FloatArray) -> FloatArray:
    """Rows of `curvature` of a part at points (n, 3) of the body's frame, (n, 10)."""
    rows = np.empty((len(points), 10))
    for i in range(len(points)):
        row = curvature(kind, first, numbers, points[i, 0], points[i, 1], points[i, 2])
        for j in range(10):
            rows[i, j] = row[j]
    return rows


@njit(cache=True, **OPTIONS)
def closest_parts(
    kind: IntArray, first: IntArray, numbers: FloatArray, points: FloatArray
) -> tuple[FloatArray, IntArray]:
    """The least φ over all parts at points (n, 3) of the body's frame, (n,), and the part, (n,)."""
    least, part = np.full(len(points), np.inf), np.zeros(len(points), dtype=np.int64)
    for i in range(len(points)):
        for p in range(len(kind)):
            phi = signed_distance(kind[p], first[p], numbers, points[i, 0], points[i, 1], points[i, 2])[0]
            if phi < least[i]:
                least[i], part[i] = phi, p
    return least, part
