"""`netdae mesh`: generate a net, or read one, and write it to a mesh file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from netdae.cli.arguments import WholeNumber, place
from netdae.core.text import as_text

if TYPE_CHECKING:
    from netdae.model.net import CableNet

app = App(name="mesh", help="Generate a net in the xy plane, centred at the origin, or convert a mesh file.")

Output = Annotated[
    Path,
    Parameter(name=["--output", "-o"], converter=place, help="File: .vtu .vtp .vtk .msh .xdmf .inp or .obj."),
]
Subdivide = Annotated[WholeNumber, Parameter(help="Pieces that each cable is cut into.")]
Overwrite = Annotated[bool, Parameter(negative="", help="Replace the file if it exists.")]
Side = Annotated[float, Parameter(help="Side of the net, m.")]
Radius = Annotated[float, Parameter(help="Distance from the centre to the corners, m.")]


@app.default
def convert(
    *,
    source: Annotated[
        Path | None, Parameter(name="--from", converter=place, help="Mesh file to convert.")
    ] = None,
    output: Output | None = None,
    surface_edges: Annotated[
        bool, Parameter(negative="", help="Take the edges of surface cells as cables.")
    ] = False,
    merge: Annotated[float | None, Parameter(help="Join nodes at most this far apart, m.")] = None,
    overwrite: Overwrite = False,
) -> None:
    """Convert a mesh file to another format: netdae mesh --from FILE -o FILE."""
    from netdae.core.errors import InputError
    from netdae.mesh.io import describe

    if source is None or output is None:
        raise InputError(
            "netdae mesh takes a pattern, such as square, or --from FILE -o FILE: see netdae mesh --help"
        )
    found = describe(source, surface_edges=surface_edges, merge=merge)
    for finding in found.findings:
        print(as_text(f"{source}: {finding}"))
    _write(found.net, output, overwrite)


@app.command
def square(
    *,
    side: Side,
    cells: Annotated[WholeNumber, Parameter(help="Meshes along a side.")],
    output: Output,
    subdivide: Subdivide = 1,
    overwrite: Overwrite = False,
) -> None:
    """Square net with square meshes."""
    from netdae.model.net import CableNet

    _write(CableNet.square(side=side, cells=cells, subdivide=subdivide), output, overwrite)


@app.command
def rectangle(
    *,
    width: Annotated[float, Parameter(help="Length along x, m.")],
    height: Annotated[float, Parameter(help="Length along y, m.")],
    columns: Annotated[WholeNumber, Parameter(help="Meshes along x.")],
    rows: Annotated[WholeNumber, Parameter(help="Meshes along y.")],
    output: Output,
    subdivide: Subdivide = 1,
    overwrite: Overwrite = False,
) -> None:
    """Rectangular net with rectangular meshes."""
    from netdae.model.net import CableNet

    net = CableNet.rectangle(width=width, height=height, columns=columns, rows=rows, subdivide=subdivide)
    _write(net, output, overwrite)


@app.command
def hexagon(
    *,
    radius: Radius,
    rings: Annotated[WholeNumber, Parameter(help="Rings of triangles about the centre.")],
    output: Output,
    subdivide: Subdivide = 1,
    overwrite: Overwrite = False,
) -> None:
    """Hexagonal net with triangular meshes."""
    from netdae.model.net import CableNet

    _write(CableNet.hexagon(radius=radius, rings=rings, subdivide=subdivide), output, overwrite)


@app.command
def radial(
    *,
    radius: Radius,
    rings: Annotated[WholeNumber, Parameter(help="Closed rings, the border among them.")],
    spokes: Annotated[WholeNumber, Parameter(help="Cables from the centre to the border.")],
    output: Output,
    subdivide: Subdivide = 1,
    overwrite: Overwrite = False,
) -> None:
    """Spider-web net of spokes and rings."""
    from netdae.model.net import CableNet

    _write(CableNet.radial(radius=radius, rings=rings, spokes=spokes, subdivide=subdivide), output, overwrite)


@app.command
def diamond(
    *,
    side: Side,
    cells: Annotated[WholeNumber, Parameter(help="Diagonals of meshes along a side.")],
    output: Output,
    subdivide: Subdivide = 1,
    overwrite: Overwrite = False,
) -> None:
    """Square net whose meshes stand on their corners."""
    from netdae.model.net import CableNet

    _write(CableNet.diamond(side=side, cells=cells, subdivide=subdivide), output, overwrite)


def _write(net: CableNet, output: Path, overwrite: bool) -> None:
    from netdae.mesh.io import write_net

    write_net(net, output, overwrite=overwrite)
    print(
        f"{output}: {net.node_count} nodes, {net.cable_count} cables, {net.rest_length.sum():.6g} m of cord"
    )
