"""Volume, centre of mass and inertia of uniform solids.

A solid of density ρ̄ has the mass m = ∫ ρ̄ dV, the centre c = ∫ ρ̄ x dV / m and about it the inertia
J = ∫ ρ̄ (|y|² I − y yᵀ) dV, y = x − c. About another point at a distance d it is J + m (|d|² I − d dᵀ) (parallel axes).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.model.shapes.surfaces import Surface


class Solid(NamedTuple):
    """Mass properties, of unit density where nothing else is said.

    mass : kg; the volume in m³ where the density is one
    centre : (3,), m
    inertia : (3, 3), kg m², about the centre
    """

    mass: float
    centre: FloatArray
    inertia: FloatArray

    def times(self, factor: float) -> Solid:
        """The solid with its density multiplied."""
        return Solid(factor * self.mass, self.centre, factor * self.inertia)

    def placed(self, position: FloatArray, axes: FloatArray) -> Solid:
        """The solid moved, x = position + axes y."""
        return Solid(self.mass, position + axes @ self.centre, axes @ self.inertia @ axes.T)


def symmetric(volume: float, across: float, along: float) -> Solid:
    """A solid centred at the origin with the inertia `across` about x and y, and `along` about z."""
    return Solid(volume, np.zeros(3), np.diag([across, across, along]))


def joined_solids(solids: list[Solid]) -> Solid:
    """Several solids as one rigid body; where they overlap both count."""
    mass = sum(each.mass for each in solids)
    centre = np.sum([each.mass * each.centre for each in solids], axis=0) / mass
    inertia = np.zeros((3, 3))
    for each in solids:
        inertia += each.inertia + each.mass * spread(each.centre - centre)
    return Solid(mass, centre, inertia)


def spread(d: FloatArray) -> FloatArray:
    """|d|² I − d dᵀ, (3, 3)."""
    return np.dot(d, d) * np.eye(3) - np.outer(d, d)


def revolution(r1: float, r2: float, length: float) -> Solid:
    """A frustum along z with the radius r1 at z = −length/2 and r2 at z = length/2.

    A disc of thickness dz has the mass π r² dz, and the inertia ½ r² times this about z, ¼ r² about its diameters. All
    integrands are polynomials of degree four at most, so three Gauss points are exact.
    """
    at, weight = np.polynomial.legendre.leggauss(3)
    z, r = 0.5 * length * at, 0.5 * (r1 + r2) + 0.5 * (r2 - r1) * at
    mass = np.pi * r**2 * 0.5 * length * weight
    volume = float(mass.sum())
    zc = float((mass * z).sum() / volume)
    along = float((mass * r**2).sum() / 2)
    across = along / 2 + float((mass * (z - zc) ** 2).sum())
    return Solid(volume, np.array([0.0, 0.0, zc]), np.diag([across, across, along]))


def of_surface(surface: Surface) -> Solid:
    """The solid in a closed surface: the sum of signed tetrahedra from one point to its triangles.

    A tetrahedron with one corner at the origin and v₁, v₂, v₃ has V = v₁ · v₂ × v₃/6, the first moment V s/4 with
    s = v₁ + v₂ + v₃, and ∫ x xᵀ dV = V/20 (s sᵀ + Σ vᵢ vᵢᵀ). A negative volume tells that the surface is inside out.
    """
    origin = surface.points.mean(axis=0)
    v = (surface.points - origin)[surface.triangles]
    volumes = np.einsum("mi,mi->m", v[:, 0], np.cross(v[:, 1], v[:, 2])) / 6.0
    s = v.sum(axis=1)
    volume = float(volumes.sum())
    centre = np.einsum("m,mi->i", volumes, s) / (4.0 * volume) if volume else np.zeros(3)
    second = np.einsum("m,mi,mj->ij", volumes, s, s) + np.einsum("m,mki,mkj->ij", volumes, v, v)
    second = second / 20.0 - volume * np.outer(centre, centre)
    return Solid(volume, origin + centre, np.trace(second) * np.eye(3) - second)
