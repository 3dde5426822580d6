"""A closed mesh whose faces recede, for rounded edges.

Each point moves by the smallest Δ with n · Δ = −ρ for the normals n of all faces around it, in the sense of least
squares weighted by their angles there. At corners of up to three planes, or where the surface is smooth, every face
recedes by ρ.
"""

from __future__ import annotations

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import InputError
from netdae.mesh.closest import corner_angles, face_normals, signed_distances, tree_of
from netdae.mesh.crossing import crossing_of
from netdae.model.shapes.surfaces import Surface

_FLAT = 1e-2
"""Of the largest eigenvalue: where faces differ less, by some 6°, a point moves along their mean normal."""

_DEPTH = 0.8
"""Of ρ: a point that is less deep than this after it has receded has come close to another side."""


def receded(surface: Surface, by: float) -> Surface:
    """The mesh with its faces `by` m further in; raises InputError where that crosses itself or comes out elsewhere."""
    corners = surface.points[surface.triangles]
    normals = face_normals(corners)
    angle = corner_angles(corners)
    A, b = np.zeros((len(surface.points), 3, 3)), np.zeros((len(surface.points), 3))
    for k in range(3):
        weight = angle[:, k]
        np.add.at(A, surface.triangles[:, k], np.einsum("m,mi,mj->mij", weight, normals, normals))
        np.add.at(b, surface.triangles[:, k], -by * weight[:, None] * normals)
    moved = surface.points + np.einsum("nij,nj->ni", np.linalg.pinv(A, rcond=_FLAT, hermitian=True), b)
    shallow = signed_distances(tree_of(*surface), surface.triangles, moved) > -_DEPTH * by
    if shallow.any() or _crosses(moved, surface.triangles):
        raise InputError(
            f"surface mesh: rounding is {by:g} m, larger than a part of it that is thin or finely resolved: give "
            "less, or 0"
        )
    return Surface(moved, surface.triangles)


def _crosses(points: FloatArray, triangles: IntArray) -> bool:
    return crossing_of(tree_of(points, triangles), triangles, points)[0] > 0
