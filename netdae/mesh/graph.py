"""Nets from graphs of networkx: a node has its place in `pos`, a cable its data and its groups."""

from __future__ import annotations

from typing import Any

import numpy as np

from netdae.core.errors import MeshError
from netdae.mesh.net import net_of
from netdae.mesh.raw import NUMBERS, RawMesh
from netdae.model.net import CableNet


def net_of_graph(graph: Any) -> CableNet:
    """Net of a networkx graph, in its order of nodes and edges.

    Nodes have `pos`, two or three coordinates in m, and if wanted `group`, a name or several; edges if wanted `group`
    and any of the cell data of a mesh file, in SI units. Raises MeshError for a graph that is not a net.
    """
    nodes, edges = list(graph.nodes(data=True)), list(graph.edges(data=True))
    lost = next((name for name, data in nodes if len(data.get("pos", ())) not in (2, 3)), None)
    if lost is not None:
        raise MeshError(f"node {lost!r} of the graph has no pos: give two or three coordinates, m")
    places = {name: k for k, (name, _) in enumerate(nodes)}
    points = [[*map(float, data["pos"]), 0.0][:3] for _, data in nodes]
    given = {name for _, _, data in edges for name in NUMBERS if data.get(name) is not None}
    raw = RawMesh(
        points=np.array(points, dtype=np.float64).reshape(-1, 3),
        cell_count=len(edges),
        ends=np.array([(places[i], places[j]) for i, j, _ in edges], dtype=np.int64).reshape(-1, 2),
        line_cell=np.arange(len(edges)),
        cell_data={
            name: np.array([np.nan if data.get(name) is None else float(data[name]) for *_, data in edges])
            for name in sorted(given)
        },
        point_sets=_groups([data for _, data in nodes]),
        cell_sets=_groups([data for *_, data in edges]),
    )
    return net_of(raw)[0]


def _groups(rows: list[dict[str, Any]]) -> dict[str, Any]:
    members: dict[str, list[int]] = {}
    for k, data in enumerate(rows):
        names = data.get("group") or ()
        for name in (names,) if isinstance(names, str) else names:
            members.setdefault(str(name), []).append(k)
    return {name: np.array(member, dtype=np.int64) for name, member in members.items()}
