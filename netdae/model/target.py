"""A rigid target and fixed obstacles that a net meets: their data, see `forces.contact` for the law.

Frames: the body's frame is the one in which its parts are given. With the place p of its origin and its attitude A, a
point b of it is at p + A b. A body turns about its centre of mass c, which is at X = p + A c and moves on its own path.
Compiled code sees the body in its principal axes, from its centre of mass.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from scipy.spatial.transform import Rotation

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.model.shapes.part import Part, axes_of
from netdae.model.shapes.rigid_body import RigidBody
from netdae.model.shapes.sizes import vector

TargetMotion = Literal["fixed", "moving", "free"]
TARGET_MOTIONS: tuple[TargetMotion, ...] = get_args(TargetMotion)

EXPONENTS = (1.0, 1.5)
"""n of the normal force k δⁿ: a linear spring, or that of Hertz."""


@dataclass(frozen=True)
class Contact:
    """How a part meets the net, see `forces.contact`: N = k δⁿ (1 + 1.5 λ δ̇), and Coulomb friction.

    stiffness : k, N/mⁿ; None for one that is chosen for each cord and bullet
    exponent : n, 1 or 1.5
    dissipation : λ, s/m, of Hunt and Crossley: a slow rebound keeps about 1 − λ v of its speed v
    friction : μ
    slip_speed : v_s, m/s, at which friction has 1/√2 of its full force
    closing_speed : m/s, at which a stiffness that is chosen stops a knot or bullet within 1 mm

    Raises InputError for values out of range.
    """

    stiffness: float | None = None
    exponent: float = 1.0
    dissipation: float = 0.3
    friction: float = 0.3
    slip_speed: float = 0.01
    closing_speed: float = 5.0

    def __post_init__(self) -> None:
        k = self.stiffness
        if k is not None and not (math.isfinite(k) and k > 0):
            raise InputError(f"contact: stiffness is {k:g}: give a finite number above zero, or none")
        if self.exponent not in EXPONENTS:
            raise InputError(f"contact: exponent is {self.exponent:g}: give 1 or 1.5")
        for name in ("dissipation", "friction"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise InputError(f"contact: {name} is {value:g}: give a finite number, zero or more")
        for name in ("slip_speed", "closing_speed"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"contact: {name} is {value:g} m/s: give a finite number above zero")


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A part that is fixed in space, such as a floor: its position and attitude are those of the part."""

    part: Part
    contact: Contact = Contact()


@dataclass(frozen=True, eq=False)
class Target:
    """A rigid body that a net meets.

    parts : at least one, in the body's frame
    body : mass, centre of mass and inertia; needed by a free target
    motion : "fixed"; "moving" with a prescribed velocity and spin, both constant; or "free"
    position : (3,), m, of the origin of the body's frame at the start
    attitude : (4,), quaternion (w, x, y, z) of the body's axes at the start, normalised
    velocity : (3,), m/s, of the centre of mass, which without `body` is the origin
    spin : (3,), rad/s, at the start, about the axes of the body's frame
    contact : of all parts; contacts : of each part, (P,), None where `contact` applies

    Raises InputError for data that is out of range or does not go together.
    """

    parts: tuple[Part, ...]
    body: RigidBody | None = None
    motion: TargetMotion = "free"
    position: FloatArray = (0.0, 0.0, 0.0)  # type: ignore[assignment]  # arrays below
    attitude: FloatArray = (1.0, 0.0, 0.0, 0.0)  # type: ignore[assignment]
    velocity: FloatArray = (0.0, 0.0, 0.0)  # type: ignore[assignment]
    spin: FloatArray = (0.0, 0.0, 0.0)  # type: ignore[assignment]
    contact: Contact = Contact()
    contacts: Sequence[Contact | None] = ()

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "parts", tuple(self.parts))
        if not self.parts:
            raise InputError("target: it has no parts: give one shape at least")
        if self.motion not in TARGET_MOTIONS:
            raise InputError(f"target: motion is {self.motion!r}: choose one of {', '.join(TARGET_MOTIONS)}")
        for name in ("position", "velocity", "spin"):
            put(self, name, vector("target", name, getattr(self, name)))
        attitude = vector("target", "attitude", self.attitude, count=4)
        norm = float(np.linalg.norm(attitude))
        if norm == 0.0:
            raise InputError("target: attitude is the zero quaternion: give (1, 0, 0, 0) for no rotation")
        put(self, "attitude", vector("target", "attitude", attitude / norm, count=4))
        put(self, "contacts", tuple(self.contacts))
        if self.contacts and len(self.contacts) != len(self.parts):
            raise InputError(
                f"target: contacts are given for {len(self.contacts)} parts, but it has {len(self.parts)}: "
                "give one each"
            )
        if self.motion == "free":
            if self.body is None:
                raise InputError(
                    "target: it is free but has no mass: give its mass and inertia, or let it be fixed"
                )
            if not all(math.isfinite(part.shape.core().radius) for part in self.parts):
                raise InputError("target: a plane has no end and cannot be free: let the target be fixed")
        if self.motion == "fixed" and (self.velocity.any() or self.spin.any()):
            raise InputError(
                "target: it is fixed but has a velocity or spin: leave them out, or let it be moving"
            )

    def contact_of(self, part: int) -> Contact:
        """How the part with that index meets the net."""
        own = self.contacts[part] if self.contacts else None
        return self.contact if own is None else own

    @property
    def centre(self) -> FloatArray:
        """X, the place of the centre of mass at the start, (3,), m."""
        if self.body is None:
            return self.position
        return self.position + axes_of(self.attitude) @ self.body.centre

    @property
    def principal_attitude(self) -> FloatArray:
        """Quaternion (w, x, y, z) of the principal axes at the start, (4,)."""
        if self.body is None:
            return self.attitude
        own, axes = (Rotation.from_quat(q, scalar_first=True) for q in (self.attitude, self.body.axes))
        return np.asarray((own * axes).as_quat(scalar_first=True))

    @property
    def principal_spin(self) -> FloatArray:
        """W, the spin about the principal axes at the start, (3,), rad/s."""
        return self.spin if self.body is None else axes_of(self.body.axes).T @ self.spin

    @property
    def principal_parts(self) -> tuple[Part, ...]:
        """The parts seen from the centre of mass along the principal axes."""
        if self.body is None:
            return self.parts
        return tuple(part.seen_from(self.body.centre, self.body.axes) for part in self.parts)

    def frame_of(self, principal_attitude: FloatArray) -> FloatArray:
        """Quaternion (w, x, y, z) of the body's frame where its principal axes have this attitude, (4,)."""
        if self.body is None:
            return np.asarray(principal_attitude)
        now, axes = (Rotation.from_quat(q, scalar_first=True) for q in (principal_attitude, self.body.axes))
        return np.asarray((now * axes.inv()).as_quat(scalar_first=True))

    def origin_of(self, centre: FloatArray, principal_attitude: FloatArray) -> FloatArray:
        """Place of the origin of the body's frame, (3,), m, from those of its centre of mass and principal axes."""
        if self.body is None:
            return np.asarray(centre)
        return np.asarray(centre - axes_of(self.frame_of(principal_attitude)) @ self.body.centre)
