"""The section [net] of a scenario, a mesh file or a pattern with its keys, and the net that it makes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from netdae.core.errors import InputError
from netdae.mesh.io import describe
from netdae.model.net import CableNet
from netdae.scenario.problems import InSection
from netdae.scenario.section import Count, Length, Section, Text, kind_of

BYTES_PER_NODE = 8192
"""Memory of a flight for each node: measured 7.9 kB by `netdae check` of square nets with 200² and 300² meshes."""

MOST_NODES = 2 * 2**30 // BYTES_PER_NODE
"""Most nodes of a net that is flown: 2 GiB of memory."""


class MeshFile(Section):
    """A net from a mesh file."""

    file: Text = Field(description="Mesh file: .vtu .vtp .vtk .msh .xdmf .inp .obj or .csv.")
    surface_edges: bool = Field(False, description="Take the edges of surface cells as cables.")
    merge: Length | None = Field(None, description="Nodes at most this far apart are joined, m.")


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


def net_of(entry: Net, folder: Path, section: InSection) -> tuple[CableNet, tuple[str, ...]]:
    """The net of an entry, and findings on its mesh file; raises InputError, through `section`, for what is no net.

    folder : of the scenario file, to which the mesh file is relative
    """
    if isinstance(entry, MeshFile):
        path = folder / entry.file
        with section("net", key="file"):
            found = describe(path, surface_edges=entry.surface_edges, merge=entry.merge)
            _check_size(found.net)
        return found.net, tuple(f"{path}: {finding}" for finding in found.findings)
    pattern = getattr(CableNet, entry.kind)
    with section("net"):
        net = pattern(**entry.model_dump(exclude={"kind"}))
        _check_size(net)
        return net, ()


def _check_size(net: CableNet) -> None:
    if net.node_count > MOST_NODES:
        memory = net.node_count * BYTES_PER_NODE / 2**30
        raise InputError(
            f"the net has {net.node_count} nodes, whose flight would take some {memory:.1f} GiB of memory: "
            f"take at most {MOST_NODES} nodes (2 GiB), by fewer cells or pieces"
        )
