"""Sphere, capsule, box, cylinder, cone and plane.

The part's frame has its origin at the middle, and the axis of revolution is z. With `rounding` ρ the core of a part is
what remains when each face recedes by ρ; the part is all within ρ of the core. So its faces stay where they are and its
edges have the radius ρ.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.model.shapes.kinds import BOX, FRUSTUM, PLANE, SEGMENT, Core
from netdae.model.shapes.sizes import check_rounding, check_sizes, vector
from netdae.model.shapes.solid import Solid, revolution, symmetric
from netdae.model.shapes.surfaces import AROUND, Surface, block, revolved

ROUNDING = 5e-3
"""Radius of edges where nothing else is given, m: a sharp edge has no normal, and cables would go deep into it."""

_ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Sphere:
    """radius : m."""

    radius: float

    def __post_init__(self) -> None:
        check_sizes("sphere", radius=self.radius)

    def core(self) -> Core:
        """A point."""
        return Core(SEGMENT, self.radius, np.zeros(1), _ORIGIN, self.radius)

    def solid(self) -> Solid:
        """Of unit density."""
        volume = 4.0 / 3.0 * math.pi * self.radius**3
        moment = 0.4 * volume * self.radius**2
        return symmetric(volume, moment, moment)

    def surface(self) -> Surface:
        """Triangles between parallels and meridians."""
        angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, AROUND // 2 + 1)
        return revolved(self.radius * np.column_stack([np.cos(angle), np.sin(angle)]))


@dataclass(frozen=True)
class Capsule:
    """A cylinder with hemispheres as ends.

    radius : m
    length : m, from end to end, twice the radius at least
    """

    radius: float
    length: float

    def __post_init__(self) -> None:
        check_sizes("capsule", radius=self.radius, length=self.length)
        if self.length < 2.0 * self.radius:
            raise InputError(
                f"capsule: length is {self.length:g} m from end to end, less than its diameter: give at least "
                f"{2.0 * self.radius:g} m, or a sphere"
            )

    def core(self) -> Core:
        """A segment."""
        half = 0.5 * self.length - self.radius
        return Core(SEGMENT, self.radius, np.array([half]), _ORIGIN, 0.5 * self.length)

    def solid(self) -> Solid:
        """Of unit density: the cylinder, and two hemispheres with their centres of mass 3 r/8 beyond its ends."""
        r, c = self.radius, self.length - 2.0 * self.radius
        middle, ends = math.pi * r * r * c, 4.0 / 3.0 * math.pi * r**3
        across = middle * (c * c / 12.0 + r * r / 4.0) + ends * (
            0.4 * r * r + c * c / 4.0 + 3.0 * c * r / 8.0
        )
        return symmetric(middle + ends, across, 0.5 * middle * r * r + 0.4 * ends * r * r)

    def surface(self) -> Surface:
        """Triangles between parallels and meridians."""
        angle = np.linspace(0.0, 0.5 * np.pi, AROUND // 4 + 1)
        cap = self.radius * np.column_stack([np.cos(angle), np.sin(angle)])
        cap[:, 1] += 0.5 * self.length - self.radius
        return revolved(np.concatenate([cap[::-1] * [1.0, -1.0], cap]))


@dataclass(frozen=True, eq=False)
class Box:
    """size : (3,), edges along x, y and z, m; rounding : radius of its edges, m."""

    size: FloatArray
    rounding: float = ROUNDING

    def __post_init__(self) -> None:
        size = vector("box", "size", self.size)
        object.__setattr__(self, "size", size)
        check_sizes("box", **{f"size along {axis}": length for axis, length in zip("xyz", size, strict=True)})
        check_rounding("box", self.rounding, 0.5 * float(size.min()))

    @property
    def half(self) -> FloatArray:
        """Half of the edges, (3,), m."""
        return 0.5 * self.size

    def core(self) -> Core:
        """A smaller box."""
        half = self.half
        core = half - self.rounding
        return Core(BOX, self.rounding, core, _ORIGIN, float(np.linalg.norm(core)) + self.rounding)

    def solid(self) -> Solid:
        """Of unit density, with sharp edges."""
        square = (2.0 * self.half) ** 2
        volume = float(np.prod(2.0 * self.half))
        return Solid(volume, np.zeros(3), np.diag(volume / 12.0 * (square.sum() - square)))

    def surface(self) -> Surface:
        """Twelve triangles, with sharp edges."""
        return block(self.half)


@dataclass(frozen=True)
class Cylinder:
    """radius, length, and rounding of the edges of its ends : m."""

    radius: float
    length: float
    rounding: float = ROUNDING

    def __post_init__(self) -> None:
        check_sizes("cylinder", radius=self.radius, length=self.length)
        check_rounding("cylinder", self.rounding, min(self.radius, 0.5 * self.length))

    def core(self) -> Core:
        """A smaller cylinder."""
        r, z = self.radius - self.rounding, 0.5 * self.length - self.rounding
        return _frustum(r, -z, r, z, (0.0, 1.0), self.rounding)

    def solid(self) -> Solid:
        """Of unit density, with sharp edges."""
        return revolution(self.radius, self.radius, self.length)

    def surface(self) -> Surface:
        """Triangles around the axis, with sharp edges."""
        return _frustum_surface(self.radius, self.radius, self.length)


@dataclass(frozen=True)
class Cone:
    """A frustum of a cone, for example a nozzle taken as closed.

    base_radius, top_radius : m, at z = −length/2 and z = length/2; one of them may be zero
    length, rounding : m; an apex becomes blunt, by rounding (1/sin α − 1) with α the half angle
    """

    base_radius: float
    top_radius: float
    length: float
    rounding: float = ROUNDING

    def __post_init__(self) -> None:
        check_sizes("cone", at_least_zero=True, base_radius=self.base_radius, top_radius=self.top_radius)
        check_sizes("cone", length=self.length)
        if not max(self.base_radius, self.top_radius) > 0:
            raise InputError("cone: both radii are 0 m: give one above zero")
        # the largest sphere inside touches the slope and an end, or both ends
        wide, narrow = (f(self.base_radius, self.top_radius) for f in (max, min))
        slope = math.hypot(self.length, wide - narrow)
        inside = wide * self.length / (slope + wide - narrow)
        check_rounding("cone", self.rounding, min(0.5 * self.length, inside) * (1 - 1e-12))

    def core(self) -> Core:
        """A smaller frustum, which ends in an apex where its slope reaches the axis before its end."""
        slope = math.hypot(self.length, self.top_radius - self.base_radius)
        tr, tz = (self.top_radius - self.base_radius) / slope, self.length / slope
        # the slope: r t_z − z t_r = level
        level = self.base_radius * tz + 0.5 * self.length * tr - self.rounding
        ends: list[tuple[float, float]] = []
        for z in (-0.5 * self.length + self.rounding, 0.5 * self.length - self.rounding):
            r = (level + z * tr) / tz
            ends.append((r, z) if r >= 0.0 else (0.0, -level / tr))
        return _frustum(*ends[0], *ends[1], (tr, tz), self.rounding)

    def solid(self) -> Solid:
        """Of unit density, with sharp edges."""
        return revolution(self.base_radius, self.top_radius, self.length)

    def surface(self) -> Surface:
        """Triangles around the axis, with sharp edges."""
        return _frustum_surface(self.base_radius, self.top_radius, self.length)


@dataclass(frozen=True)
class Plane:
    """The half-space z < 0: a floor or a wall, whose outward normal is z.

    extent : side of the square in pictures, m
    """

    extent: float = 10.0

    def __post_init__(self) -> None:
        check_sizes("plane", extent=self.extent)

    def core(self) -> Core:
        """Itself."""
        return Core(PLANE, 0.0, np.zeros(0), _ORIGIN, math.inf)

    def solid(self) -> Solid:
        """It has none: raises InputError."""
        raise InputError("plane: a half-space has no finite mass: hold it fixed, or give another shape")

    def surface(self) -> Surface:
        """A square of side `extent`."""
        corner = 0.5 * self.extent * np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
        return Surface(corner, np.array([[0, 1, 2], [0, 2, 3]]))


def _frustum(r1: float, z1: float, r2: float, z2: float, slope: tuple[float, float], offset: float) -> Core:
    numbers = np.array([r1, z1, r2, z2, *slope, math.hypot(r2 - r1, z2 - z1)])
    middle = 0.5 * (z1 + z2)
    radius = max(math.hypot(r1, z1 - middle), math.hypot(r2, z2 - middle)) + offset
    return Core(FRUSTUM, offset, numbers, (0.0, 0.0, middle), radius)


def _frustum_surface(r1: float, r2: float, length: float) -> Surface:
    z = 0.5 * length
    profile = [[0.0, -z], *([[r1, -z]] if r1 else []), *([[r2, z]] if r2 else []), [0.0, z]]
    return revolved(np.array(profile))
