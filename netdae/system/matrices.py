"""The paper's matrices, written as in the paper: Eqs. (1) to (9) element by element, assembled by scipy.

Nothing in a flight uses this module: it is for studying the model, and the tests compare the compiled
forces with it. Symbols: xₑ (m, 6) positions of a cable's two nodes, Δ (6, 6), Aₑ the selection of its rows.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from netdae.core.arrays import FloatArray
from netdae.forces.cables import law_of
from netdae.model.material import Cords
from netdae.model.net import CableNet
from netdae.system.assembly import assembled

DELTA = np.block([[np.eye(3), -np.eye(3)], [-np.eye(3), np.eye(3)]])
"""Δ of Eq. (2)."""


def green_lagrange_strain(xe: FloatArray, L: FloatArray) -> FloatArray:
    """E11 (m,), Eq. (3), with l² = xₑᵀ Δ xₑ of Eq. (1)."""
    return 0.5 * (np.einsum("ei,ij,ej->e", xe, DELTA, xe) - L**2) / L**2


def secant(S11: FloatArray, area: FloatArray, L: FloatArray) -> FloatArray:
    """Sₑ (m, 6, 6), Eq. (5)."""
    return (S11 * area / L)[:, None, None] * DELTA


def tangent(xe: FloatArray, S11: FloatArray, dS11: FloatArray, area: FloatArray, L: FloatArray) -> FloatArray:
    """Tₑ (m, 6, 6), Eq. (6), with dS11 the slope ∂S11/∂E11."""
    Dx = xe @ DELTA
    return secant(S11, area, L) + (dS11 * area / L**3)[:, None, None] * Dx[:, :, None] * Dx[:, None, :]


def reference_stiffness(span: FloatArray, EA: FloatArray, L: FloatArray) -> FloatArray:
    """T(x̄) of Eq. (9) (m, 6, 6) from the spans (m, 3) of the cables in x̄: directions from x̄, lengths L̄."""
    n = span / np.linalg.norm(span, axis=1)[:, None]
    N = np.concatenate((n, -n), axis=1)
    return (EA / L)[:, None, None] * N[:, :, None] * N[:, None, :]


def secant_of(net: CableNet, cords: Cords, L: FloatArray, x: FloatArray) -> sparse.csr_matrix:
    """S(x) of Eqs. (5), (8), (3n, 3n), with the rest lengths L (m,)."""
    S11, _ = _stress_and_slope(net, cords, L, x)
    return assembled(secant(S11, cords.area, L), net.cables, net.node_count)


def tangent_of(net: CableNet, cords: Cords, L: FloatArray, x: FloatArray) -> sparse.csr_matrix:
    """T(x) of Eqs. (6), (8), (3n, 3n), with the rest lengths L (m,)."""
    elements = tangent(_positions(net, x), *_stress_and_slope(net, cords, L, x), cords.area, L)
    return assembled(elements, net.cables, net.node_count)


def reference_stiffness_of(net: CableNet, cords: Cords) -> sparse.csr_matrix:
    """T(x̄) of Eq. (9), (3n, 3n)."""
    elements = reference_stiffness(net.spans, cords.axial_stiffness, net.rest_length)
    return assembled(elements, net.cables, net.node_count)


def _positions(net: CableNet, x: FloatArray) -> FloatArray:
    """xₑ (m, 6)."""
    return x[net.cables].reshape(-1, 6)


def _stress_and_slope(
    net: CableNet, cords: Cords, L: FloatArray, x: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """S11 and ∂S11/∂E11, (m,) each, Pa, of the cords' laws."""
    E11 = green_lagrange_strain(_positions(net, x), L)
    laws = [law_of(*each) for each in zip(E11, cords.toe_strain, cords.engineering, strict=True)]
    ratio, slope, *_ = np.array(laws).T
    modulus = cords.axial_stiffness / cords.area
    return modulus * ratio, modulus * slope
