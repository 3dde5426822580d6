"""`netdae info`: what is in a mesh file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from netdae.core.text import as_text

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from netdae.core.arrays import FloatArray, IntArray
    from netdae.mesh.io import Description


def info(
    mesh: Path,
    *,
    surface_edges: Annotated[
        bool, Parameter(negative="", help="Take the edges of surface cells as cables.")
    ] = False,
    merge: Annotated[float | None, Parameter(help="Join nodes at most this far apart, m.")] = None,
) -> None:
    """Say what is in a mesh file: nodes, cables, groups, data, connected parts."""
    from netdae.mesh.io import describe

    for line in _lines(mesh, describe(mesh, surface_edges=surface_edges, merge=merge)):
        print(as_text(line))


def _lines(mesh: Path, found: Description) -> Iterator[str]:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    net = found.net
    joined = ([True] * net.cable_count, net.cables.T)
    graph = coo_array(joined, shape=(net.node_count, net.node_count))
    parts = connected_components(graph, directed=False)[0]
    yield str(mesh)
    yield f"nodes            {net.node_count}"
    yield f"cables           {net.cable_count}"
    yield f"node groups      {_sizes(net.node_groups)}"
    yield f"cable groups     {_sizes(net.cable_groups)}"
    yield f"cable data       {_ranges(net.cable_data)}"
    yield f"connected parts  {parts}"
    yield f"total length     {net.rest_length.sum():.6g} m"
    yield f"cable length     {_range(net.rest_length)} m"
    yield f"bounding box     {_box(net.nodes)} m"
    if found.unused_data:
        yield f"unused data      {', '.join(found.unused_data)}"
    for finding in found.findings:
        yield f"note             {finding}"


def _sizes(groups: Mapping[str, IntArray]) -> str:
    return ", ".join(f"{name} {len(members)}" for name, members in groups.items())


def _ranges(data: Mapping[str, FloatArray]) -> str:
    from numpy import isnan

    given = {name: values[~isnan(values)] for name, values in data.items()}
    return ", ".join(f"{name} {_range(values)}" for name, values in given.items() if len(values)) or "none"


def _range(values: FloatArray) -> str:
    low, high = f"{values.min():.6g}", f"{values.max():.6g}"
    return low if low == high else f"{low} to {high}"


def _box(nodes: FloatArray) -> str:
    pairs = zip("xyz", nodes.min(axis=0), nodes.max(axis=0), strict=True)
    return ", ".join(f"{axis} {low + 0.0:.6g} to {high + 0.0:.6g}" for axis, low, high in pairs)
