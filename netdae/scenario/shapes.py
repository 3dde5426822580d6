"""What targets, their parts and obstacles of a scenario have in common: a shape with its place, and its contact."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import numpy as np
from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError
from scipy.spatial.transform import Rotation

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.mesh.surface import check_size, read_surface
from netdae.mesh.surface_grid import CELLS, LARGEST
from netdae.model.shapes.hull import ConvexHull
from netdae.model.shapes.part import Part, Shape
from netdae.model.shapes.solids import Box, Capsule, Cone, Cylinder, Plane, Sphere
from netdae.model.target import Contact
from netdae.scenario.section import Length, Section, Text, Vector

Kind = Literal["sphere", "box", "cylinder", "capsule", "cone", "hull", "plane"]

SIZES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "sphere": (("radius",), ()),
    "box": (("size",), ("rounding",)),
    "cylinder": (("radius", "length"), ("rounding",)),
    "capsule": (("radius", "length"), ()),
    "cone": (("base_radius", "top_radius", "length"), ("rounding",)),
    "hull": (("points",), ("rounding",)),
    "plane": ((), ("extent",)),
    "file": ((), ("scale", "rounding", "cells")),
}
"""Keys that a kind needs, and those that it may have."""

_SHAPES: dict[str, type] = {
    "sphere": Sphere,
    "box": Box,
    "cylinder": Cylinder,
    "capsule": Capsule,
    "cone": Cone,
    "hull": ConvexHull,
    "plane": Plane,
}
assert {*get_args(Kind)} == {*_SHAPES}


def _check_points(value: Any) -> Any:
    if not (isinstance(value, list) and all(isinstance(each, list) and len(each) == 3 for each in value)):
        raise PydanticCustomError("points", "a list of points, each three numbers in brackets")
    return value


Radius = Annotated[float, Field(ge=0, le=1e6)]  # m
Stiffness = Annotated[float, Field(gt=0, le=1e15)]  # N/mⁿ
Dissipation = Annotated[float, Field(ge=0, le=1e3)]  # s/m
ContactFriction = Annotated[float, Field(ge=0, le=100)]
SlipSpeed = Annotated[float, Field(gt=0, le=1e3)]  # m/s
Scale = Annotated[float, Field(ge=1e-6, le=1e6)]
Cells = Annotated[int, Field(ge=8, le=LARGEST)]
Points = Annotated[list[Vector], BeforeValidator(_check_points)]


class ContactKeys(Section):
    """How a body meets the net."""

    stiffness: Stiffness | None = Field(
        None, description="k of the normal force k δⁿ, N/mⁿ; chosen for each cord and bullet by default."
    )
    exponent: float = Field(1.0, description="n, 1 or 1.5.")
    dissipation: Dissipation = Field(0.3, description="λ of Hunt and Crossley, s/m.")
    friction: ContactFriction = Field(0.3, description="Coefficient of friction.")
    slip_speed: SlipSpeed = Field(
        0.01, description="Sliding speed at which friction has seven tenths of its full value, m/s."
    )
    closing_speed: SlipSpeed = Field(
        5.0, description="Speed, m/s, at which a stiffness that is chosen stops a knot or bullet within 1 mm."
    )


class ShapeKeys(Section):
    """A shape and its sizes."""

    kind: Kind | None = Field(None, description="Shape; left out with file.")
    file: Text | None = Field(None, description="Closed triangle mesh: .stl, .obj or .ply.")
    radius: Length | None = Field(None, description="Of sphere, cylinder and capsule, m.")
    length: Length | None = Field(None, description="Of cylinder, capsule and cone, from end to end, m.")
    size: Vector | None = Field(None, description="Of a box: edges along x, y and z, m.")
    base_radius: Radius | None = Field(None, description="Of a cone: radius at the lower end, m.")
    top_radius: Radius | None = Field(None, description="Of a cone: radius at the upper end, m.")
    points: Points | None = Field(None, description="Of a hull: points whose convex hull it is, m.")
    extent: Length | None = Field(None, description="Of a plane: side of the square in pictures, m.")
    rounding: Radius | None = Field(None, description="Radius of the edges, m; 5 mm by default.")
    scale: Scale | None = Field(None, description="Of a file: factor to metres, 1 by default.")
    cells: Cells | None = Field(
        None,
        description=f"Of a file: cells of its grid of distances along the longest side, {CELLS} by default.",
    )


def contact_of(entry: ContactKeys) -> Contact:
    """How a body meets the net; raises InputError for an exponent that is neither 1 nor 1.5."""
    return Contact(**{name: getattr(entry, name) for name in ContactKeys.model_fields})


def shape_of(entry: ShapeKeys, folder: Path, net_size: float) -> Shape:
    """The shape of an entry that has a kind or a file; raises InputError for sizes that it lacks or has too many of.

    folder : of the scenario file, to which a file is relative
    net_size : m, of the net; a file so much larger is in other units
    """
    if (entry.kind is None) == (entry.file is None):
        both = "kind and file are both given: give the one or the other"
        raise InputError(
            f"neither kind nor file is given: give kind, one of {', '.join(get_args(Kind))}, or file"
            if entry.kind is None
            else both
        )
    kind = entry.kind or "file"
    needed, allowed = SIZES[kind]
    given = {
        name for keys in SIZES.values() for part in keys for name in part if getattr(entry, name) is not None
    }
    what = "a file" if entry.kind is None else f'kind = "{kind}"'
    for name in sorted(given - {*needed, *allowed}):
        may = ", ".join((*needed, *allowed))
        raise InputError(f"{name} is no key of {what}, which has {may}: leave it out")
    for name in needed:
        if name not in given:
            raise InputError(f"{name} is missing: {what} needs {', '.join(needed)}")
    sizes: dict[str, Any] = {name: getattr(entry, name) for name in (*needed, *allowed) if name in given}
    if entry.file is None:
        shape: Shape = _SHAPES[kind](**sizes)
        return shape
    path = folder / entry.file
    mesh = read_surface(path, **sizes)
    check_size(mesh.surface(), net_size, str(path))
    return mesh


def part_of(shape: Shape, position: Any, attitude_deg: Any) -> Part:
    """A shape at its place in a body, or in space."""
    return Part(shape, np.array(position, dtype=np.float64), turned(attitude_deg))


def turned(degrees: Any, *, further: Any = (0.0, 0.0, 0.0)) -> FloatArray:
    """Quaternion (w, x, y, z) of turns about the fixed x, then y, then z axis, degrees, and of further ones after."""
    turn = Rotation.from_euler("xyz", further, degrees=True) * Rotation.from_euler(
        "xyz", degrees, degrees=True
    )
    return np.asarray(turn.as_quat(scalar_first=True))
