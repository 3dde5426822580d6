"""The attitude of a rigid body: integrated from its spin, and kept beside the net's coordinates.

Symbols, in the body's principal axes from its centre of mass: q the quaternion (w, x, y, z) of the axes, R its matrix;
W spin in rad/s, I₁, I₂, I₃ its moments of inertia, m its mass, ρᵢ = √(Iᵢ/m) its radii of gyration.

A free body is two nodes. The place is its centre of mass X with the mass m. The spin is a generalised node, like the
drum of a reel: its coordinates are ϑᵢ = ρᵢ ∫ Wᵢ dt in m, its velocities ρᵢ Wᵢ in m/s, its mass m, and a torque τ acts
as the force τᵢ/ρᵢ. So m |ϑ̇|²/2 is the energy of rotation, and tolerances in m and m/s mean the same as at knots.

The attitude is no function of ϑ. It follows from the last known one, (q_n, Θ_n, W_n, t_n) with Θᵢ = ϑᵢ/ρᵢ, by the
series of W. Magnus (1954, Communications on Pure and Applied Mathematics 7, 649) up to the fourth order:

    q = q_n ∘ exp(Θ − Θ_n + h²/12 W_n × W),        h = t − t_n.

Methods move this base after each step they accept.
"""

from __future__ import annotations

from math import cos, sin, sqrt
from typing import NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray, Reals
from netdae.forces.law import Vector, compiled

Quaternion = tuple[float, float, float, float]
Matrix = tuple[float, float, float, float, float, float, float, float, float]
"""R, row after row."""

TURN = 0.05
"""rad, largest turn of a body in one step of a method that follows the series: what it leaves out is then 1e-9 rad."""

ANGLE, SPIN, TIME = 4, 7, 10
"""Places in the base after q."""


class Pose(NamedTuple):
    """Attitude of one body.

    base : (11,), q_n, Θ_n in rad, W_n in rad/s, t_n in s
    known : (16,), Θ, W, t and R of the last attitude that was asked for
    rho : (3,), ρ, m; mass : m, kg
    free : whether the base moves; that of a fixed or driven body stays, since its spin is constant
    """

    base: Reals
    known: Reals
    rho: Reals
    mass: float
    free: bool


def pose_of(attitude: FloatArray, rho: FloatArray, mass: float, *, free: bool) -> Pose:
    """The pose of a body at rest at t = 0 with Θ = 0."""
    base = np.concatenate((attitude, np.zeros(7)))
    return Pose(base, np.full(16, np.nan), rho, mass, free)


@compiled
def attitude_at(pose: Pose, angle: Vector, spin: Vector, t: float) -> Quaternion:
    """The quaternion q where Θ = angle, W = spin at t."""
    b = pose.base
    c = (t - b[TIME]) ** 2 / 12.0
    u, v, w = b[SPIN], b[SPIN + 1], b[SPIN + 2]
    x = 0.5 * (angle[0] - b[ANGLE] + c * (v * spin[2] - w * spin[1]))
    y = 0.5 * (angle[1] - b[ANGLE + 1] + c * (w * spin[0] - u * spin[2]))
    z = 0.5 * (angle[2] - b[ANGLE + 2] + c * (u * spin[1] - v * spin[0]))
    half = sqrt(x * x + y * y + z * z)
    k = sin(half) / half if half > 1e-6 else 1.0 - half * half / 6.0
    return product((b[0], b[1], b[2], b[3]), (cos(half), k * x, k * y, k * z))


@compiled
def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """p ∘ q."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


@compiled
def matrix_of(q: Quaternion) -> Matrix:
    """R of a quaternion of any length but zero."""
    w, x, y, z = q
    s = 2.0 / (w * w + x * x + y * y + z * z)
    return (
        1.0 - s * (y * y + z * z),
        s * (x * y - w * z),
        s * (x * z + w * y),
        s * (x * y + w * z),
        1.0 - s * (x * x + z * z),
        s * (y * z - w * x),
        s * (x * z - w * y),
        s * (y * z + w * x),
        1.0 - s * (x * x + y * y),
    )


@compiled
def axes_at(pose: Pose, angle: Vector, spin: Vector, t: float) -> Matrix:
    """R where Θ = angle, W = spin at t; found once for all elements of a force."""
    k = pose.known
    same = k[0] == angle[0] and k[1] == angle[1] and k[2] == angle[2] and k[6] == t
    if same and k[3] == spin[0] and k[4] == spin[1] and k[5] == spin[2]:
        return k[7], k[8], k[9], k[10], k[11], k[12], k[13], k[14], k[15]
    R = matrix_of(attitude_at(pose, angle, spin, t))
    for c in range(3):
        k[c], k[3 + c] = angle[c], spin[c]
    k[6] = t
    for c in range(9):
        k[7 + c] = R[c]
    return R


@compiled
def move_base(pose: Pose, angle: Vector, spin: Vector, t: float) -> None:
    """Let the base be where Θ = angle, W = spin at t."""
    if pose.free:
        put_base(pose, attitude_at(pose, angle, spin, t), angle, spin, t)


@compiled
def put_base(pose: Pose, q: Quaternion, angle: Vector, spin: Vector, t: float) -> None:
    """Let the base be at a given attitude; the quaternion is normalised."""
    b, k = pose.base, pose.known
    r = 1.0 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    b[0], b[1], b[2], b[3] = r * q[0], r * q[1], r * q[2], r * q[3]
    for c in range(3):
        b[ANGLE + c], b[SPIN + c] = angle[c], spin[c]
    b[TIME] = t
    k[0] = np.nan  # what is known was of the former base


@compiled
def rates_of(pose: Pose, values: FloatArray, at: int) -> Vector:
    """Θ, or W, from the spin node's entries at `at` of x, or v."""
    rho = pose.rho
    return values[at] / rho[0], values[at + 1] / rho[1], values[at + 2] / rho[2]
