"""What may stand in the section [net] of a scenario file: a mesh file, or a pattern with its keys."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from netdae.scenario.section import Count, Length, Section, Text, kind_of


class MeshFile(Section):
    """A net from a mesh file."""

    file: Text = Field(description="Mesh file: .vtu .vtk .msh .xdmf or .inp.")
    surface_edges: bool = Field(False, description="Take the edges of surface cells as cables.")


class Square(Section):
    """A square net with square meshes."""

    kind: Literal["square"] = Field(description="Pattern of the net.")
    side: Length = Field(description="Side, m.")
    cells: Count = Field(description="Meshes along a side.")
    subdivide: Count = Field(1, description="Pieces that each cable is cut into.")


class Rectangle(Section):
    """A rectangular net with rectangular meshes."""

    kind: Literal["rectangle"] = Field(description="Pattern of the net.")
    width: Length = Field(description="Length along x, m.")
    height: Length = Field(description="Length along y, m.")
    columns: Count = Field(description="Meshes along x.")
    rows: Count = Field(description="Meshes along y.")
    subdivide: Count = Field(1, description="Pieces that each cable is cut into.")


class Hexagon(Section):
    """A hexagonal net with triangular meshes."""

    kind: Literal["hexagon"] = Field(description="Pattern of the net.")
    radius: Length = Field(description="Distance from the centre to the corners, m.")
    rings: Count = Field(description="Rings of triangles about the centre.")
    subdivide: Count = Field(1, description="Pieces that each cable is cut into.")


class Radial(Section):
    """A spider-web net."""

    kind: Literal["radial"] = Field(description="Pattern of the net.")
    radius: Length = Field(description="Distance from the centre to the border, m.")
    rings: Count = Field(description="Closed rings, the border among them.")
    spokes: int = Field(ge=3, description="Cables from the centre to the border.")
    subdivide: Count = Field(1, description="Pieces that each cable is cut into.")


class Diamond(Section):
    """A square net whose meshes stand on their corners."""

    kind: Literal["diamond"] = Field(description="Pattern of the net.")
    side: Length = Field(description="Side, m.")
    cells: Count = Field(description="Diagonals of meshes along a side.")
    subdivide: Count = Field(1, description="Pieces that each cable is cut into.")


def _kind_of_net(value: Any) -> str:
    kind = kind_of(value)
    return "<file>" if kind == "<none>" and isinstance(value, dict) and "file" in value else kind


Net = Annotated[
    Annotated[MeshFile, Tag("<file>")]
    | Annotated[Square, Tag("square")]
    | Annotated[Rectangle, Tag("rectangle")]
    | Annotated[Hexagon, Tag("hexagon")]
    | Annotated[Radial, Tag("radial")]
    | Annotated[Diamond, Tag("diamond")],
    Discriminator(_kind_of_net),
]
