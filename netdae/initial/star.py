"""The star fold: corners out, sides in, like a closed umbrella with its ribs pleated.

Symbols: r, ψ distance and azimuth of a point of the open net about the axis, which passes through the middle of its k
corners; ρ, z distance from the axis and height in the pack; aᵢ, ψᵢ distance and azimuth of the foot of the
perpendicular on side i; a the smallest aᵢ; γ the angle from a foot to the next corner; lengths in m.

**Wedges.** Rays from the middle to the corners and to the feet cut the net into 2k half sides. Each of them is cut
again by rays at equal angles into n wedges, n odd. Every other ray is drawn in, as the foot is, the others stay
out, as the corner does. Rings of the net, the lines on which

    τ = r cos(ψ − ψᵢ)/aᵢ

is the same, from 0 in the middle to 1 at the border, thus become pleated rings: with f the zig-zag from 0 to 1 over
one wedge, 0 at a foot and 1 at a corner,

    ρ = U(τ) − A(τ) (1 − f(ψ)),     U = min(R, u a τ),     A = A₁ τ,     z = H τ,

and every point keeps its azimuth. Ring lies on ring from the floor, where the middle of the net is, to the mouth,
where its border is; R is the radius of the pack. n = 1 is the plain star of k arms.

**No cable is lengthened.** In a half side |∇ψ| = 1/r ≤ 1/(aᵢτ) and |∇τ| = 1/aᵢ, and |f′| = n/γ. Since 0 ≤ A₁ ≤ R ≤ u a,

    |∇ρ| ≤ u + A₁ n/(γ aᵢ),     ρ |∇ψ| ≤ u,     |∇z| ≤ H/a.

The map stretches no line by more than the root of the sum of the three squares, and the net is convex, so

    A₁ = min(γ aᵢ) / n · (√(1 − u² − (H/a)²) − u)

brings no two points farther apart. Lengths of the open net, a and aᵢ, are drawn together beforehand by 1 − slack,
and, for a net whose cables are shorter than drawn, until they fit: so the ends of every cable are within
(1 − slack) L̄ of each other. u is R/a, at least 0.2 (below it the pleats of the inner rings crowd at the axis) and at
most 0.55; H is the depth of the canister, at most a/2.

**The smallest canister.** Pleats cannot meet at the axis: R ≥ A₁ + R₀, where the inner radius R₀ is a fifth of R, or
that at which n pleats of a cord's diameter d stand side by side in each half side, n d/γ. More pleats are narrower
(A₁ ~ 1/n) but need more room inside (R₀ ~ n): the best n is where the two are even.

(ψ, z) distinguish each point of the net from all others, so no two knots meet; nor do they on the straight lines on
which the pack opens, since ψ stays and of two points of one ray the outer one is always higher.

A star of radial arms, which are then folded or coiled themselves, is the promising pattern of the study Space Webs
(G. Tibert and M. Gärdsback, ESA Advanced Concepts Team, Ariadna 05/4109); here the pleats of the rings do both.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.initial.canister import SLACK, Canister, Plane, check_pack, check_slack_share, fitting, rounded_up
from netdae.initial.scaled import placed
from netdae.model.net import CableNet
from netdae.model.state import State

LEAST_SLOPE, LARGEST_SLOPE = 0.2, 0.55
"""Bounds of u: radius of an inner ring's hull over its distance from the middle in the open net."""

STEEPEST = 0.5
"""Largest H/a."""

INNER = 0.2
"""Least inner radius of the border ring, as a share of the outer one."""

MOST_PLEATS = 999
"""Most pleats of a half side."""


def star(
    net: CableNet,
    canister: Canister,
    *,
    pleats: int | None = None,
    corners: str = "corners",
    cord_diameter: float = 0.0,
    slack: float = SLACK,
    rotation_deg: ArrayLike = (0.0, 0.0, 0.0),
    velocity: ArrayLike = (0.0, 0.0, 0.0),
) -> tuple[CableNet, State]:
    """The flat net in a star, corners out and sides in, rotated, moving as a whole; rotated net and initial state.

    canister : a square one is filled up to the circle inside it
    pleats : wedges from the middle of a side to a corner, an odd number; 1 is the plain star, by default the
        fewest that fit
    corners : node group of the corners of the net, which is the convex polygon between them
    cord_diameter : m, the least room of a pleat at the inner radius
    slack : least slack of each cable, as a share of its rest length
    rotation_deg, velocity : as in `initial.scaled.scaled`; x̄ is rotated too

    Raises InputError where the pack does not fit, with the smallest size that does, or the net has no such corners.
    """
    check_slack_share(slack)
    if not (math.isfinite(cord_diameter) and cord_diameter >= 0):
        raise InputError(f"star: cord_diameter is {cord_diameter:g} m: give a length, zero or more")
    plane = Plane.of(net)
    flat = plane.flat(net.nodes)
    polygon = _Polygon.of(flat, flat[net.nodes_of(corners)], corners)
    width = fitting(net) * (1 - slack)
    room = _Room(
        polygon.distance.min() * width,
        float((polygon.angle * np.roll(np.repeat(polygon.distance, 2), -1)).min()) * width,
        float(polygon.angle.min()),
        canister.depth,
        cord_diameter,
    )
    n = room.fewest(canister) if pleats is None else room.checked(pleats, canister)
    tau, azimuth, f = polygon.wedged(flat, n)
    R = min(canister.width / 2, LARGEST_SLOPE * room.a)
    rho = np.minimum(R, room.slope(R) * room.a * tau) - room.amplitude(n, R) * tau * (1 - f)
    pack = np.column_stack([rho * np.cos(azimuth), rho * np.sin(azimuth), room.height * tau])
    x = plane.solid(pack + np.append(polygon.middle, 0.0))
    check_pack(net, x, shape=f"star with {n} pleats")
    return placed(net, x, rotation_deg=rotation_deg, velocity=velocity)


@dataclass(frozen=True)
class _Room:
    """Sizes of a star: a in m, reach = min(γ aᵢ) in m, least γ in rad, depth and cord in m."""

    a: float
    reach: float
    angle: float
    depth: float
    cord: float

    @property
    def height(self) -> float:
        """H."""
        return min(self.depth, STEEPEST * self.a)

    def slope(self, R: float) -> float:
        """u of a pack of radius R."""
        return max(R / self.a, LEAST_SLOPE)

    def amplitude(self, n: int, R: float) -> float:
        """A₁ of n pleats."""
        u = self.slope(R)
        return self.reach / n * (math.sqrt(1 - u**2 - (self.height / self.a) ** 2) - u)

    def lacking(self, n: int, R: float) -> float:
        """A₁ + R₀ − R: by how much the radius is too small; falls with R."""
        return self.amplitude(n, R) + max(INNER * R, n * self.cord / self.angle) - R

    def smallest(self, n: int) -> float:
        """Smallest radius that n pleats fit in; infinite where a net of this size has none."""
        low, high = 0.0, LARGEST_SLOPE * self.a
        if self.lacking(n, high) > 0:
            return math.inf
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (low, middle) if self.lacking(n, middle) <= 0 else (middle, high)
        return high

    def fewest(self, canister: Canister) -> int:
        """The smallest odd n that fits; raises InputError with the smallest possible canister."""
        R = canister.width / 2
        sizes = {}
        for n in range(1, MOST_PLEATS + 1, 2):
            sizes[n] = self.smallest(n)
            if sizes[n] <= R:
                return n
        best = min(sizes, key=lambda n: sizes[n])
        cause = f", of a cord {self.cord:g} m thick" if self.cord > 0 else ""
        raise InputError(
            f"star: no number of pleats{cause} fits into the {canister.words}: "
            f"give {_key_of(canister)} of {rounded_up(2 * sizes[best])} m at least, in which {best} pleats fit"
        )

    def checked(self, pleats: int, canister: Canister) -> int:
        """`pleats`, or InputError where they are not an odd number or do not fit."""
        whole = not isinstance(pleats, bool) and pleats == int(pleats)
        if not (whole and 1 <= pleats <= MOST_PLEATS and pleats % 2 == 1):
            raise InputError(f"star: pleats is {pleats}: give an odd whole number from 1 to {MOST_PLEATS}")
        smallest = self.smallest(pleats)
        if smallest > canister.width / 2 * (1 + 1e-9):
            if math.isinf(smallest):
                raise InputError(
                    f"star: this net with pleats = {pleats} fits into no canister: give other pleats, or none to "
                    "have them chosen"
                )
            raise InputError(
                f"star: pleats = {pleats} does not fit into the {canister.words}: give {_key_of(canister)} of "
                f"{rounded_up(2 * smallest)} m at least, or other pleats: more are narrower, fewer need less inside"
            )
        return int(pleats)


@dataclass(frozen=True, eq=False)
class _Polygon:
    """The polygon of the corners about its middle.

    middle (2,), m; distance (k,), m, and foot (k,), rad, of the perpendiculars; rays (2k + 1,), rad, the first
    foot, the corner after it, and so on, rising, once around; angle (2k,), rad, between them
    """

    middle: FloatArray
    distance: FloatArray
    foot: FloatArray
    rays: FloatArray
    angle: FloatArray

    @classmethod
    def of(cls, flat: FloatArray, corners: FloatArray, group: str) -> _Polygon:
        """Polygon of `corners` (k, 2) of a net with nodes (n, 2), widened to hold them all."""
        if len(corners) < 3:
            raise InputError(
                f"star: group {group!r} has {len(corners)} nodes: a star needs three corners at least"
            )
        middle = corners.mean(axis=0)
        offset = corners - middle
        offset = offset[np.argsort(np.arctan2(offset[:, 1], offset[:, 0]))]
        side = np.roll(offset, -1, axis=0) - offset
        normal = np.column_stack([side[:, 1], -side[:, 0]]) / np.linalg.norm(side, axis=1)[:, None]
        distance = np.einsum("ij,ij->i", normal, offset)
        corner = np.arctan2(offset[:, 1], offset[:, 0])
        after = np.append(corner[1:], corner[0] + 2 * math.pi)
        foot = np.unwrap(np.append(corner[0], np.arctan2(normal[:, 1], normal[:, 0])))[1:]
        rays = np.append(np.column_stack([corner, foot]).ravel(), after[-1])
        angle = np.diff(rays)
        if not (distance > 1e-9 * distance.max()).all() or not (angle > 1e-6).all():
            raise InputError(
                f"star: the {len(corners)} nodes of group {group!r} are not the corners of a convex polygon with "
                "the perpendicular from its middle on each side: name another group, or use another shape"
            )
        rays, angle = rays[1:], np.append(angle[1:], angle[0])  # from the first foot on
        rays = np.append(rays, rays[0] + 2 * math.pi)
        polygon = cls(middle, distance, foot, rays, angle)
        widest = float(polygon.ring(flat)[0].max())
        return cls(middle, distance * widest, foot, rays, angle)

    def ring(self, flat: FloatArray) -> tuple[FloatArray, FloatArray]:
        """τ and the azimuth, from the first foot on, of points (n, 2)."""
        offset = flat - self.middle
        azimuth = np.arctan2(offset[:, 1], offset[:, 0])
        azimuth = self.rays[0] + np.mod(azimuth - self.rays[0], 2 * math.pi)
        normal = np.column_stack([np.cos(self.foot), np.sin(self.foot)])
        tau = (offset @ normal.T / self.distance).max(axis=1)  # by the nearest side of a convex polygon
        return tau, azimuth

    def wedged(self, flat: FloatArray, n: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """τ, azimuth and f of points (n, 2) for n pleats."""
        tau, azimuth = self.ring(flat)
        half = np.clip(np.searchsorted(self.rays, azimuth, side="right") - 1, 0, len(self.angle) - 1)
        share = np.clip((azimuth - self.rays[half]) / self.angle[half], 0.0, 1.0)
        from_foot = np.where(half % 2 == 0, share, 1 - share)
        return tau, azimuth, np.abs(np.mod(n * from_foot + 1, 2) - 1)


def _key_of(canister: Canister) -> str:
    return "a side" if canister.diameter is None else "a diameter"
