"""Nodes of a raw mesh that lie close together made one."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from netdae.core.arrays import IntArray
from netdae.core.errors import MeshError
from netdae.mesh.findings import many
from netdae.mesh.raw import RawMesh


def welded(raw: RawMesh, distance: float) -> RawMesh:
    """The mesh with all nodes that are at most `distance` m apart at the place of the first of them.

    Raises MeshError for a line whose two ends it joins.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    if not (np.isfinite(distance) and distance > 0):
        raise MeshError(f"merge is {distance:g}, expected a distance above zero, m")
    if not np.isfinite(raw.points).all():
        return raw  # the net says which node
    pairs = cKDTree(raw.points).query_pairs(distance, output_type="ndarray")
    count = len(raw.points)
    graph = coo_array((np.ones(len(pairs), dtype=bool), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    _, part = connected_components(graph, directed=False)
    _, first = np.unique(part, return_index=True)
    to = first[part]
    for k in np.flatnonzero(to[raw.ends[:, 0]] == to[raw.ends[:, 1]]):
        if raw.ends[k, 0] != raw.ends[k, 1]:
            raise MeshError(
                f"merge = {distance:g} joins both ends of {raw.cable_name(int(k))}: give a shorter distance"
            )
    joined = int(np.count_nonzero(to != np.arange(count)))
    findings = (
        (*raw.findings, f"{many(joined, 'node')} joined with another within {distance:g} m") if joined else ()
    )
    point_data = {name: _joined(values, to) for name, values in raw.point_data.items()}
    return replace(
        raw,
        ends=to[raw.ends],
        face_edges=to[raw.face_edges],
        vertices=to[raw.vertices],
        point_sets={name: to[nodes] for name, nodes in raw.point_sets.items()},
        point_data=point_data,
        findings=findings or raw.findings,
    )


def _joined(values: NDArray[Any], to: IntArray) -> NDArray[Any]:
    """Data of nodes, of which an integer holds for all that are joined where it is not 0 for one."""
    if values.dtype.kind not in "iub" or values.ndim > 1:
        return values
    result = values.copy()
    np.maximum.at(result, to, values)
    return result
