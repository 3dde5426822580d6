"""Rayleigh damping of Eq. (9): D = α M + β T(x̄).

T(x̄) of an unstrained, sharp net is K₀ = Σ Aₑᵀ (EĀ/L̄) [[nnᵀ, −nnᵀ], [−nnᵀ, nnᵀ]] Aₑ with n (3,) the unit
direction of the cable in x̄: constant for the whole flight, whatever the law, the toe or the rest lengths.
It keeps linear momentum but brakes a net that turns, acts on slack cables, and leaves the transverse
motion of a flat net undamped; α M takes momentum.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import njit

from netdae._arrays import FloatArray, IntArray
from netdae.forces.protocol import Account, NewtonPart, Tangent


@njit(cache=True)
def _pulls(viscosity: FloatArray, v: FloatArray, f: FloatArray) -> None:
    for e in range(len(viscosity)):
        for a in range(3):
            pull = 0.0
            for b in range(3):
                pull += viscosity[e, a, b] * (v[e, 1, b] - v[e, 0, b])
            f[e, 0, a], f[e, 1, a] = pull, -pull


@dataclass(frozen=True, eq=False)
class StiffnessDamping:
    """f = −β K₀ v, cable by cable.

    nodes : (m, 2); viscosity : (m, 3, 3), β (EĀ/L̄) nnᵀ, N s/m
    """

    nodes: IntArray
    viscosity: FloatArray

    newton: NewtonPart = "symmetric"
    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()
    external: bool = False
    _tangent: Tangent = field(init=False, repr=False)

    def __post_init__(self) -> None:
        C = np.empty((len(self.nodes), 2, 3, 2, 3))
        C[:, 0, :, 1, :] = C[:, 1, :, 0, :] = self.viscosity
        C[:, 0, :, 0, :] = C[:, 1, :, 1, :] = -self.viscosity
        object.__setattr__(self, "_tangent", Tangent.of_all(np.zeros_like(C), C))

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Force on the two nodes of each cable, (m, 2, 3), N."""
        f = np.empty_like(v)
        _pulls(self.viscosity, v, f)
        return f

    def tangent(self, t: float, x: FloatArray, v: FloatArray) -> Tangent:
        """Zero and −β K₀."""
        return self._tangent

    def account(self, t: float, x: FloatArray, v: FloatArray) -> Account:
        """Dissipated power v·β K₀ v."""
        return Account(dissipated_power=-float(np.vdot(self.force(t, x, v), v)))


@dataclass(frozen=True, eq=False)
class MassDamping:
    """f = −α M v, node by node.

    nodes : (n, 1); viscosity : (n,), α times the node's mass, N s/m
    """

    nodes: IntArray
    viscosity: FloatArray

    newton: NewtonPart = "symmetric"
    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()
    external: bool = True  # it takes momentum

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Drag on each node, (n, 1, 3), N."""
        return -self.viscosity[:, None, None] * v

    def tangent(self, t: float, x: FloatArray, v: FloatArray) -> Tangent:
        """Zero and −α M."""
        C = np.zeros((len(self.nodes), 1, 3, 1, 3))
        axes = np.arange(3)
        C[:, 0, axes, 0, axes] = -self.viscosity[:, None]
        return Tangent.of_all(np.zeros_like(C), C)

    def account(self, t: float, x: FloatArray, v: FloatArray) -> Account:
        """Dissipated power α v·M v."""
        return Account(dissipated_power=float(np.vdot(self.viscosity[:, None, None] * v, v)))
