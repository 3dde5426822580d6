"""Mass, centre of mass and principal inertia of a rigid body, given or derived from its parts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from netdae.core.arrays import FloatArray, frozen_floats
from netdae.core.errors import InputError
from netdae.model.shapes.part import Part, axes_of
from netdae.model.shapes.sizes import vector
from netdae.model.shapes.solid import Solid, joined_solids

_ROUND_OFF = 1e-9  # relative; inertias come from tables and sums


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A rigid body about its centre of mass.

    mass : kg
    inertia : (3,), I₁, I₂, I₃, kg m², about the principal axes
    axes : (4,), quaternion (w, x, y, z) of the rotation whose columns are the principal axes in the body's frame
    centre : (3,), m, the centre of mass in the body's frame

    Raises InputError for a mass or moments that are not above zero, and where one moment exceeds the sum of the others.
    """

    mass: float
    inertia: FloatArray
    axes: FloatArray = (1.0, 0.0, 0.0, 0.0)  # type: ignore[assignment]  # arrays below
    centre: FloatArray = (0.0, 0.0, 0.0)  # type: ignore[assignment]

    def __post_init__(self) -> None:
        if not (math.isfinite(self.mass) and self.mass > 0):
            raise InputError(f"target: mass is {self.mass:g} kg: give a finite number above zero")
        inertia = vector("target", "inertia", self.inertia)
        if not (inertia > 0).all():
            raise InputError(
                f"target: principal moments of inertia are {_shown(inertia)} kg m²: give numbers above zero"
            )
        least, middle, most = sorted(inertia.tolist())
        if most > (least + middle) * (1.0 + _ROUND_OFF):
            raise InputError(
                f"target: principal moments of inertia are {_shown(inertia)} kg m², but no body's largest moment "
                "exceeds the sum of the other two: correct them"
            )
        object.__setattr__(self, "inertia", inertia)
        axes = vector("target", "axes", self.axes, count=4)
        if not np.isclose(np.linalg.norm(axes), 1.0, rtol=0, atol=1e-9):
            raise InputError(f"target: axes are {_shown(axes)}: give a quaternion of length one")
        object.__setattr__(self, "axes", axes)
        object.__setattr__(self, "centre", vector("target", "centre of mass", self.centre))

    @classmethod
    def from_inertia(
        cls, mass: float, inertia: ArrayLike, *, centre: ArrayLike = (0.0, 0.0, 0.0)
    ) -> RigidBody:
        """A body of given inertia about its centre of mass, in the body's axes.

        inertia : (3,), about its axes x, y, z as principal axes, or the tensor (3, 3), symmetric, kg m²
        """
        try:
            given = np.array(inertia, dtype=np.float64)
        except (TypeError, ValueError):
            given = np.array(np.nan)
        if given.shape == (3,):
            return cls(mass, given, centre=vector("target", "centre of mass", centre))
        if given.shape != (3, 3) or not np.isfinite(given).all():
            raise InputError(
                f"target: inertia is {inertia!r}: give three principal moments, or a symmetric tensor of "
                "three rows, kg m²"
            )
        uneven = np.abs(given - given.T)
        if uneven.max() > _ROUND_OFF * np.abs(given).max():
            i, j = np.unravel_index(np.argmax(uneven), (3, 3))
            raise InputError(
                f"target: inertia is not symmetric: I_{'xyz'[i]}{'xyz'[j]} is {given[i, j]:g} and "
                f"I_{'xyz'[j]}{'xyz'[i]} is {given[j, i]:g} kg m²: make them equal"
            )
        moments, axes = principal(given)
        return cls(mass, moments, axes, vector("target", "centre of mass", centre))

    @classmethod
    def of_parts(
        cls,
        parts: Sequence[Part],
        *,
        mass: float | None = None,
        masses: ArrayLike | None = None,
        density: ArrayLike | None = None,
    ) -> RigidBody:
        """A body of uniform parts; where they overlap both count.

        mass : kg, of all, at one density; or masses : (P,), kg, of each; or density : kg/m³, of all or of each, (P,)
        """
        if sum(each is not None for each in (mass, masses, density)) != 1:
            raise InputError("target: give just one of mass, masses and density")
        if not parts:
            raise InputError("target: it has no parts: give one shape at least")
        solids = [part.solid() for part in parts]
        volumes = np.array([solid.mass for solid in solids])
        if mass is not None:
            densities = np.full(len(parts), mass / volumes.sum())
        else:
            name, given = ("masses", masses) if density is None else ("density", density)
            each = np.asarray(given, dtype=np.float64)
            if each.shape not in ((), (len(parts),)) or (density is None and each.shape == ()):
                raise InputError(
                    f"target: {name} has the shape {each.shape}, but it has {len(parts)} parts: give one each"
                )
            densities = np.broadcast_to(each if density is not None else each / volumes, len(parts))
        if not (np.isfinite(densities).all() and (densities >= 0).all() and densities.any()):
            raise InputError(
                "target: mass or density of a part is negative, not finite, or zero for all: give numbers above zero"
            )
        return cls.of_solid(
            joined_solids([solid.times(float(k)) for solid, k in zip(solids, densities, strict=True)])
        )

    @classmethod
    def of_solid(cls, solid: Solid) -> RigidBody:
        """A body of given mass properties."""
        moments, axes = principal(solid.inertia)
        return cls(solid.mass, moments, axes, solid.centre)

    @property
    def tensor(self) -> FloatArray:
        """Inertia about the centre of mass in the body's axes, (3, 3), kg m²."""
        turn = axes_of(self.axes)
        return turn @ np.diag(self.inertia) @ turn.T


def principal(tensor: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Principal moments (3,) of a symmetric tensor, and the quaternion (w, x, y, z) of its principal axes.

    The axes are a right-handed frame, and of all orders and signs the closest to x, y, z, so that a diagonal tensor
    keeps its order.
    """
    tensor = 0.5 * (tensor + tensor.T)
    diagonal = np.diag(tensor)
    if np.abs(tensor - np.diag(diagonal)).max() <= 1e-13 * np.abs(diagonal).max():
        return frozen_floats(diagonal), frozen_floats([1.0, 0.0, 0.0, 0.0])
    moments, found = np.linalg.eigh(tensor)
    order = list(max(permutations(range(3)), key=lambda p: float(np.abs(np.diag(found[:, list(p)])).sum())))
    axes = found[:, order]
    axes = axes * np.where(np.diag(axes) < 0.0, -1.0, 1.0)
    if np.linalg.det(axes) < 0.0:
        axes[:, np.argmin(np.abs(np.diag(axes)))] *= -1.0
    attitude = Rotation.from_matrix(axes).as_quat(scalar_first=True)
    return frozen_floats(moments[order]), frozen_floats(attitude * (-1.0 if attitude[0] < 0 else 1.0))


def _shown(values: FloatArray) -> str:
    return ", ".join(f"{value:g}" for value in values)
