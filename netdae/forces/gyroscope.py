"""The gyroscopic torque on a free rigid body, −W × I W in its principal axes, see `pose` for its two nodes.

On the spin node, whose velocities are w = ρ W, with Iᵢ = m ρᵢ² it is the force

    f₁ = −m (ρ₃² − ρ₂²)/(ρ₁ ρ₂ ρ₃) w₂ w₃,     and so on in turn.

It does no work, and is unsymmetric: Newton's matrix does without it. Explicit steps do not see it, they turn the body
with a fixed angular momentum, see `explicit.turning`.
"""

from __future__ import annotations

from typing import NamedTuple

from netdae.core.arrays import FloatArray, Reals, Reals2
from netdae.forces.law import Law, Shares, compiled, no_bound


class Gyroscope(NamedTuple):
    """Parameters of spin nodes."""

    rho: Reals2  # (m, 3), m
    mass: Reals  # (m,), kg


@compiled
def _weight(p: Gyroscope, e: int, a: int) -> float:
    b, c = (a + 1) % 3, (a + 2) % 3
    one, two, three = p.rho[e, a], p.rho[e, b], p.rho[e, c]
    return -p.mass[e] * (three * three - two * two) / (one * two * three)


@compiled
def _force(p: Gyroscope, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    for a in range(3):
        f.conservative[0, a] = _weight(p, e, a) * v[0, (a + 1) % 3] * v[0, (a + 2) % 3]
    return True


@compiled
def _tangent(
    p: Gyroscope, e: int, s: FloatArray, x: FloatArray, v: FloatArray, K: FloatArray, C: FloatArray
) -> bool:
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        weight = _weight(p, e, a)
        C[0, a, 0, b], C[0, a, 0, c] = weight * v[0, c], weight * v[0, b]
    return True


GYROSCOPE = Law(Gyroscope, force=_force, tangent=_tangent, nodes=1, newton="nothing", bound=no_bound)
