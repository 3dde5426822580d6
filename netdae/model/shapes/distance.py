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

from math import sqrt
from typing import Any

import numpy as np
from numba import njit

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.records import load
from netdae.model.shapes.kinds import BOX, CORE, FACE, FRUSTUM, HULL, OFFSET, PLANE, SEGMENT, VERTEX, Parts

# as for the laws of forces; not-a-number and infinity keep their meaning
OPTIONS: dict[str, Any] = {"fastmath": {"reassoc", "contract", "arcp", "nsz"}, "error_model": "numpy"}

_TINY = 1e-150  # its square is above the smallest number

Vector = tuple[float, float, float]
Distance = tuple[float, float, float, float]
Curved = tuple[float, float, float, float, float, float, float, float, float, float]
"""φ, n as x, y, z, and ∇∇φ as xx, yy, zz, xy, xz, yz."""


def _inlined(function: Any) -> Any:
    return njit(cache=True, forceinline=True, **OPTIONS)(function)


@_inlined
def signed_distance(kind: int, first: int, numbers: FloatArray, bx: float, by: float, bz: float) -> Distance:
    """(φ, n_x, n_y, n_z) of a part at a point of the body's frame, in its axes; to be inlined.

    kind, first : of the part, see `kinds.Parts`; numbers : of all parts
    """
    phi, nx, ny, nz, _, _, _, _, _, _ = curvature(
        kind, first, numbers, bx, by, bz
    )  # the rest is optimised away
    return phi, nx, ny, nz


@_inlined
def curvature(kind: int, first: int, numbers: FloatArray, bx: float, by: float, bz: float) -> Curved:
    """(φ, n_x, n_y, n_z, H_xx, H_yy, H_zz, H_xy, H_xz, H_yz) of a part, H = ∇∇φ; to be inlined."""
    x, y, z = bx - numbers[first], by - numbers[first + 1], bz - numbers[first + 2]
    a00, a01, a02 = numbers[first + 3], numbers[first + 4], numbers[first + 5]
    a10, a11, a12 = numbers[first + 6], numbers[first + 7], numbers[first + 8]
    a20, a21, a22 = numbers[first + 9], numbers[first + 10], numbers[first + 11]
    qx, qy, qz = a00 * x + a10 * y + a20 * z, a01 * x + a11 * y + a21 * z, a02 * x + a12 * y + a22 * z
    core = first + CORE
    if kind == SEGMENT:
        of_core = _segment(numbers[core], qx, qy, qz)
    elif kind == BOX:
        of_core = _box(numbers[core], numbers[core + 1], numbers[core + 2], qx, qy, qz)
    elif kind == FRUSTUM:
        of_core = _frustum(numbers, core, qx, qy, qz)
    elif kind == PLANE:
        of_core = qz, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    elif kind == HULL:
        of_core = _hull(numbers, first, qx, qy, qz)
    else:
        of_core = _grid(numbers, core, qx, qy, qz)
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


@_inlined
def _segment(half: float, x: float, y: float, z: float) -> Curved:
    dz = z - min(max(z, -half), half)
    d = sqrt(x * x + y * y + dz * dz)
    if not d > _TINY:
        return d, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    r = 1.0 / d
    nx, ny, nz = x * r, y * r, dz * r
    beyond = 1.0 if abs(z) > half else 0.0
    hxx, hyy, hzz = (1.0 - nx * nx) * r, (1.0 - ny * ny) * r, (beyond - nz * nz) * r
    return d, nx, ny, nz, hxx, hyy, hzz, -nx * ny * r, -nx * nz * r, -ny * nz * r


@_inlined
def _box(hx: float, hy: float, hz: float, x: float, y: float, z: float) -> Curved:
    sx, sy, sz = 1.0 if x >= 0.0 else -1.0, 1.0 if y >= 0.0 else -1.0, 1.0 if z >= 0.0 else -1.0
    ex, ey, ez = abs(x) - hx, abs(y) - hy, abs(z) - hz
    px, py, pz = max(ex, 0.0), max(ey, 0.0), max(ez, 0.0)
    d = sqrt(px * px + py * py + pz * pz)
    if not d > _TINY:
        if ex >= ey and ex >= ez:
            return ex, sx, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if ey >= ez:
            return ey, 0.0, sy, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        return ez, 0.0, 0.0, sz, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    r = 1.0 / d
    nx, ny, nz = sx * px * r, sy * py * r, sz * pz * r
    fx, fy, fz = 1.0 if px > 0.0 else 0.0, 1.0 if py > 0.0 else 0.0, 1.0 if pz > 0.0 else 0.0
    hxx, hyy, hzz = (fx - nx * nx) * r, (fy - ny * ny) * r, (fz - nz * nz) * r
    return d, nx, ny, nz, hxx, hyy, hzz, -nx * ny * r, -nx * nz * r, -ny * nz * r


@_inlined
def _frustum(numbers: FloatArray, at: int, x: float, y: float, z: float) -> Curved:
    """By its profile in the half-plane (r, z): the flat ends, the slope between them, and their two corners."""
    r1, z1, r2, z2 = numbers[at], numbers[at + 1], numbers[at + 2], numbers[at + 3]
    tr, tz, length = numbers[at + 4], numbers[at + 5], numbers[at + 6]
    r = sqrt(x * x + y * y)
    along = (r - r1) * tr + (z - z1) * tz
    above = (r - r1) * tz - (z - z1) * tr
    below, over = z1 - z, z - z2
    corner = 0.0  # 1/d where the closest point is a corner
    if above <= 0.0 and below <= 0.0 and over <= 0.0:
        if above >= below and above >= over:
            d, dr, dz = above, tz, -tr
        elif below >= over:
            d, dr, dz = below, 0.0, -1.0
        else:
            d, dr, dz = over, 0.0, 1.0
    elif below > 0.0 and r <= r1:
        d, dr, dz = below, 0.0, -1.0
    elif over > 0.0 and r <= r2:
        d, dr, dz = over, 0.0, 1.0
    elif above > 0.0 and 0.0 <= along <= length:
        d, dr, dz = above, tz, -tr
    else:
        cr, cz = (r - r1, z - z1) if along < 0.0 else (r - r2, z - z2)
        d = sqrt(cr * cr + cz * cz)
        if d > _TINY:
            corner = 1.0 / d
            dr, dz = cr * corner, cz * corner
        else:
            dr, dz = tz, -tr
    if r > _TINY:
        ex, ey, hoop = x / r, y / r, dr / r
    else:
        ex, ey, hoop = 1.0, 0.0, 0.0
    hrr, hzz, hrz = dz * dz * corner, dr * dr * corner, -dr * dz * corner
    hxx, hyy, hxy = hrr * ex * ex + hoop * ey * ey, hrr * ey * ey + hoop * ex * ex, (hrr - hoop) * ex * ey
    return d, dr * ex, dr * ey, dz, hxx, hyy, hzz, hxy, hrz * ex, hrz * ey


@_inlined
def _hull(numbers: FloatArray, first: int, x: float, y: float, z: float) -> Curved:
    """The closest of the faces that see the point, each by its inner, its edges and its vertices."""
    count = int(numbers[first + CORE])
    highest, best = -np.inf, np.inf  # best: square of the least distance
    nx, ny, nz = 0.0, 0.0, 1.0
    wx, wy, wz = 0.0, 0.0, 0.0  # from the closest point of the hull
    tx, ty, tz = 0.0, 0.0, 0.0  # along the edge that it is on
    curved = 0.0
    for i in range(count):
        face = first + CORE + 1 + FACE * i
        fx, fy, fz = numbers[face], numbers[face + 1], numbers[face + 2]
        height = fx * x + fy * y + fz * z - numbers[face + 3]
        if height > highest:
            highest = height
            if best == np.inf:
                nx, ny, nz = fx, fy, fz
        if height > 0.0 and height * height < best:
            inner = True
            start, corners = first + int(numbers[face + 4]), int(numbers[face + 5])
            for j in range(corners):
                v = start + VERTEX * j
                rx, ry, rz = x - numbers[v], y - numbers[v + 1], z - numbers[v + 2]
                if rx * numbers[v + 7] + ry * numbers[v + 8] + rz * numbers[v + 9] > 0.0:
                    inner = False
                    ux, uy, uz = numbers[v + 3], numbers[v + 4], numbers[v + 5]
                    s = rx * ux + ry * uy + rz * uz
                    on_edge = 0.0 < s < numbers[v + 6]
                    s = min(max(s, 0.0), numbers[v + 6])
                    rx, ry, rz = rx - s * ux, ry - s * uy, rz - s * uz
                    square = rx * rx + ry * ry + rz * rz
                    if square < best:
                        best = square
                        curved = 1.0
                        wx, wy, wz = rx, ry, rz
                        tx, ty, tz = (ux, uy, uz) if on_edge else (0.0, 0.0, 0.0)
            if inner:
                best = height * height
                curved = 0.0
                nx, ny, nz = fx, fy, fz
                wx, wy, wz = height * fx, height * fy, height * fz
    if not highest > 0.0:
        if highest == -np.inf:  # the point is not a number
            highest = np.nan
        return highest, nx, ny, nz, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    d = sqrt(best)
    if curved == 0.0 or not d > _TINY:
        return d, nx, ny, nz, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    r = 1.0 / d
    nx, ny, nz = wx * r, wy * r, wz * r
    hxx, hyy = (1.0 - tx * tx - nx * nx) * r, (1.0 - ty * ty - ny * ny) * r
    hzz, hxy = (1.0 - tz * tz - nz * nz) * r, -(tx * ty + nx * ny) * r
    hxz, hyz = -(tx * tz + nx * nz) * r, -(ty * tz + ny * nz) * r
    return d, nx, ny, nz, hxx, hyy, hzz, hxy, hxz, hyz


@_inlined
def _grid(numbers: FloatArray, at: int, x: float, y: float, z: float) -> Curved:
    h = numbers[at + 3]
    nx, ny, nz = int(numbers[at + 4]), int(numbers[at + 5]), int(numbers[at + 6])
    i, fx, ex, gx = _cell(x - numbers[at], h, nx)
    j, fy, ey, gy = _cell(y - numbers[at + 1], h, ny)
    k, fz, ez, gz = _cell(z - numbers[at + 2], h, nz)
    v = at + 7 + (i * ny + j) * nz + k
    w = v + ny * nz
    v00, v01, v10, v11 = numbers[v], numbers[v + 1], numbers[v + nz], numbers[v + nz + 1]
    w00, w01, w10, w11 = numbers[w], numbers[w + 1], numbers[w + nz], numbers[w + nz + 1]
    # along z, then y, then x; *z and *y the differences along these axes
    vz0, vz1, wz0, wz1 = v01 - v00, v11 - v10, w01 - w00, w11 - w10
    v0, v1, w0, w1 = v00 + fz * vz0, v10 + fz * vz1, w00 + fz * wz0, w10 + fz * wz1
    vy, wy = v1 - v0, w1 - w0
    va, wa = v0 + fy * vy, w0 + fy * wy
    vz, wz = vz0 + fy * (vz1 - vz0), wz0 + fy * (wz1 - wz0)
    value = va + fx * (wa - va)
    r = 1.0 / h
    dx, dy, dz = (wa - va) * r * gx, (vy + fx * (wy - vy)) * r * gy, (vz + fx * (wz - vz)) * r * gz
    hxy, hxz = (wy - vy) * r * r * gx * gy, (wz - vz) * r * r * gx * gz
    hyz = ((vz1 - vz0) + fx * ((wz1 - wz0) - (vz1 - vz0))) * r * r * gy * gz
    away = ex * ex + ey * ey + ez * ez
    if away == 0.0:
        return value, dx, dy, dz, 0.0, 0.0, 0.0, hxy, hxz, hyz
    phi = sqrt(value * value + away)
    r = 1.0 / phi
    mx, my, mz = (value * dx + ex) * r, (value * dy + ey) * r, (value * dz + ez) * r
    hxx, hyy = (dx * dx + 1.0 - gx - mx * mx) * r, (dy * dy + 1.0 - gy - my * my) * r
    hzz, hxy = (dz * dz + 1.0 - gz - mz * mz) * r, (dx * dy + value * hxy - mx * my) * r
    hxz, hyz = (dx * dz + value * hxz - mx * mz) * r, (dy * dz + value * hyz - my * mz) * r
    return phi, mx, my, mz, hxx, hyy, hzz, hxy, hxz, hyz


@_inlined
def _cell(x: float, h: float, count: int) -> tuple[int, float, float, float]:
    """Cell along an axis, place in it from 0 to 1, how far x is outside the grid, and 1 inside of it or 0 outside."""
    u = x / h
    if not u >= 0.0:  # also not-a-number
        return 0, 0.0, x, 0.0
    if u > count - 1:
        return count - 2, 1.0, x - (count - 1) * h, 0.0
    i = min(int(u), count - 2)
    return i, u - i, 0.0, 1.0
