"""A shape placed in the frame of its body, and all parts of a body as compiled code sees them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.model.shapes.kinds import Core, Parts
from netdae.model.shapes.sizes import vector
from netdae.model.shapes.solid import Solid
from netdae.model.shapes.surfaces import Surface, joined


class Shape(Protocol):
    """A rigid shape in its own frame."""

    def core(self) -> Core:
        """What compiled code takes the signed distance to."""

    def solid(self) -> Solid:
        """Mass properties of unit density, with sharp edges; raises InputError where there are none."""

    def surface(self) -> Surface:
        """Triangles, with sharp edges."""


@dataclass(frozen=True, eq=False)
class Part:
    """A shape in its body's frame: b = position + A q.

    position : (3,), m; attitude : (4,), the quaternion (w, x, y, z) of A, normalised
    """

    shape: Shape
    position: FloatArray = (0.0, 0.0, 0.0)  # type: ignore[assignment]  # an array below
    attitude: FloatArray = (1.0, 0.0, 0.0, 0.0)  # type: ignore[assignment]

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", vector("part", "position", self.position))
        attitude = vector("part", "attitude", self.attitude, count=4)
        norm = float(np.linalg.norm(attitude))
        if norm == 0.0:
            raise InputError("part: attitude is the zero quaternion: give (1, 0, 0, 0) for no rotation")
        object.__setattr__(self, "attitude", vector("part", "attitude", attitude / norm, count=4))

    @property
    def axes(self) -> FloatArray:
        """A, (3, 3): its columns are the part's axes in the body."""
        return axes_of(self.attitude)

    def seen_from(self, position: ArrayLike, attitude: ArrayLike) -> Part:
        """The same part in the frame at this place in the body's, for example at `RigidBody.centre` with its `axes`."""
        turn = Rotation.from_quat(np.asarray(attitude), scalar_first=True).inv()
        own = Rotation.from_quat(self.attitude, scalar_first=True)
        return Part(
            self.shape,
            turn.apply(self.position - np.asarray(position)),
            (turn * own).as_quat(scalar_first=True),
        )

    def solid(self) -> Solid:
        """Mass properties of unit density in the body's frame."""
        return self.shape.solid().placed(self.position, self.axes)

    def surface(self) -> Surface:
        """Triangles in the body's frame."""
        return self.shape.surface().placed(self.position, self.axes)


def axes_of(attitude: ArrayLike) -> FloatArray:
    """Rotation matrix (3, 3) of a unit quaternion (w, x, y, z)."""
    if np.array_equal(attitude, (1.0, 0.0, 0.0, 0.0)):
        return np.eye(3)
    return Rotation.from_quat(np.asarray(attitude), scalar_first=True).as_matrix()


def parts_of(parts: Sequence[Part]) -> Parts:
    """Parts of a body for compiled code; raises InputError if there are none."""
    if not parts:
        raise InputError("target: it has no parts: give one shape at least")
    cores = [part.shape.core() for part in parts]
    numbers = [
        np.concatenate([part.position, part.axes.reshape(-1), [core.offset], core.numbers])
        for part, core in zip(parts, cores, strict=True)
    ]
    return Parts(
        kind=np.array([core.kind for core in cores], dtype=np.int64),
        first=np.cumsum([0, *(len(each) for each in numbers[:-1])], dtype=np.int64),
        numbers=np.concatenate(numbers),
        centre=np.array(
            [part.position + part.axes @ core.centre for part, core in zip(parts, cores, strict=True)]
        ),
        radius=np.array([core.radius for core in cores]),
        lipschitz=np.array([core.lipschitz for core in cores]),
        convex=np.array([core.convex for core in cores]),
    )


def surface_of(shape: Shape | Part | Sequence[Part]) -> Surface:
    """Triangles of a shape in its frame, or of parts in that of their body; edges are shown sharp."""
    if isinstance(shape, Sequence):
        return joined([part.surface() for part in shape])
    return shape.surface()
