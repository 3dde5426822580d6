"""Rayleigh damping of Eq. (9): D = α M + β T(x̄).

T(x̄) of an unstrained, sharp net is K₀ = Σ Aₑᵀ (EĀ/L̄) [[nnᵀ, −nnᵀ], [−nnᵀ, nnᵀ]] Aₑ with n (3,) the unit
direction of the cable in x̄: constant for the whole flight, whatever the law, the toe or the rest lengths.
It conserves linear momentum but brakes a rotating net, acts on slack cables, and leaves the transverse
motion of a flat net undamped; α M takes momentum.
"""

from __future__ import annotations

from typing import NamedTuple

from netdae.core.arrays import FloatArray, Reals, Reals2
from netdae.forces.law import Law, Shares, Vector, compiled, no_bound


class StiffnessDamping(NamedTuple):
    """Parameters of f = −β K₀ v, cable by cable."""

    along: Reals2  # a (m, 3), √(β EĀ/L̄) n, of which β (EĀ/L̄) nnᵀ = a aᵀ, (N s/m)^½


@compiled
def _along(p: StiffnessDamping, e: int, s: FloatArray, d: Vector, w: Vector, f: Shares) -> bool:
    rate = p.along[e, 0] * w[0] + p.along[e, 1] * w[1] + p.along[e, 2] * w[2]
    for a in range(3):
        f.dissipative[a] = p.along[e, a] * rate
    return True


@compiled
def _along_tangent(
    p: StiffnessDamping, e: int, s: FloatArray, d: Vector, w: Vector, K: FloatArray, C: FloatArray
) -> bool:
    for a in range(3):
        for b in range(3):
            C[a, b] = p.along[e, a] * p.along[e, b]
    return True


class MassDamping(NamedTuple):
    """Parameters of f = −α M v, node by node; it takes momentum."""

    viscosity: Reals  # (m,), α times the node's mass, N s/m


@compiled
def _of_mass(p: MassDamping, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    for a in range(3):
        f.dissipative[0, a] = -p.viscosity[e] * v[0, a]
    return True


@compiled
def _of_mass_tangent(
    p: MassDamping, e: int, s: FloatArray, x: FloatArray, v: FloatArray, K: FloatArray, C: FloatArray
) -> bool:
    for a in range(3):
        C[0, a, 0, a] = -p.viscosity[e]
    return True


# an explicit step takes both implicitly, see `explicit.rayleigh`: no bound
STIFFNESS_DAMPING = Law(
    StiffnessDamping,
    force=_along,
    tangent=_along_tangent,
    pair=True,
    shares=("dissipative",),
    steady=True,
    bound=no_bound,
)
MASS_DAMPING = Law(
    MassDamping,
    force=_of_mass,
    tangent=_of_mass_tangent,
    nodes=1,
    shares=("dissipative",),
    external=True,
    steady=True,
    bound=no_bound,
)
