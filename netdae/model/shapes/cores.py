"""Signed distance, normal and Hessian of the core of each kind of part, in the part's frame; see `distance`.

x, y, z is the point q, and the numbers of a core are those in `kinds`.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np
from numba import njit

from netdae.core.arrays import FloatArray
from netdae.core.compilation import INLINED
from netdae.model.shapes.kinds import CORE, FACE, VERTEX

Curved = tuple[float, float, float, float, float, float, float, float, float, float]
"""φ, n as x, y, z, and ∇∇φ as xx, yy, zz, xy, xz, yz."""

_TINY = 1e-150  # its square is above the smallest number


def inlined(function: Any) -> Any:
    """A compiled function that becomes part of those that call it."""
    return njit(cache=True, **INLINED)(function)


@inlined
def segment(half: float, x: float, y: float, z: float) -> Curved:
    """A segment along z."""
    dz = z - min(max(z, -half), half)
    d = sqrt(x * x + y * y + dz * dz)
    if not d > _TINY:
        return d, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    r = 1.0 / d
    nx, ny, nz = x * r, y * r, dz * r
    beyond = 1.0 if abs(z) > half else 0.0
    hxx, hyy, hzz = (1.0 - nx * nx) * r, (1.0 - ny * ny) * r, (beyond - nz * nz) * r
    return d, nx, ny, nz, hxx, hyy, hzz, -nx * ny * r, -nx * nz * r, -ny * nz * r


@inlined
def box(hx: float, hy: float, hz: float, x: float, y: float, z: float) -> Curved:
    """A box: by the distances beyond its faces along each axis; inside, its nearest face."""
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


@inlined
def frustum(numbers: FloatArray, at: int, x: float, y: float, z: float) -> Curved:
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


@inlined
def hull(numbers: FloatArray, first: int, x: float, y: float, z: float) -> Curved:
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


@inlined
def grid(numbers: FloatArray, at: int, x: float, y: float, z: float) -> Curved:
    """A grid: trilinear in the cell; outside, from the closest point of the grid's box."""
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


@inlined
def _cell(x: float, h: float, count: int) -> tuple[int, float, float, float]:
    """Cell along an axis, place in it from 0 to 1, how far x is outside the grid, and 1 inside of it or 0 outside."""
    u = x / h
    if not u >= 0.0:  # also not-a-number
        return 0, 0.0, x, 0.0
    if u > count - 1:
        return count - 2, 1.0, x - (count - 1) * h, 0.0
    i = min(int(u), count - 2)
    return i, u - i, 0.0, 1.0
