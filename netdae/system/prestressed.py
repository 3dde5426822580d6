"""Prestress as an input: rest lengths at which cables have a given tension in the reference configuration.

Symbols: T₀ prestress, N; l̄ length of a cable in x̄, L̄ rest length; λ = l̄/L̄, e the strain of the law, n(e) the law with
toe, see `forces.cables.law_of`.

The tension of a cable is N = EĀ g(E11) λ. By either law T₀ determines one stretch:

    engineering               EĀ n(e) = T₀,             λ = 1 + e
    St Venant-Kirchhoff       EĀ n(e) √(1 + 2e) = T₀,   λ = √(1 + 2e)

The first has the solution e₀ = √(2ε T₀/EĀ) in the toe, which ends at T₀ = EĀ ε/2, and T₀/EĀ + ε/2 above it. In the
second the left side rises and is convex in e; since the root is 1 or more, e₀ is not below the solution. From there
Newton's method goes down to it without ever passing it. The rest length is L̄ = l̄/λ.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from netdae.core.arrays import BoolArray, FloatArray
from netdae.core.errors import InputError
from netdae.model.material import Cords
from netdae.model.net import CableNet

MOST = 10.0
"""Largest T₀/EĀ: even rubber bears no more."""

SAME = 1e-6
"""Share by which a rest length may differ and still count as that of x̄, or of the prestress: files may hold single
precision."""


def prestressed(net: CableNet, cords: Cords) -> CableNet:
    """The net with the rest lengths at which cables have the tension `cords.prestress` in x̄.

    Cables without prestress keep theirs. A net that has these rest lengths already stays as it is.

    Raises InputError where a cable with prestress has another rest length, where the prestress is above the cable's
    strength, or where it would stretch it beyond reason.
    """
    T0 = cords.prestress
    tight = T0 > 0
    if not tight.any():
        return net
    _check(net, tight & (T0 > cords.strength), T0, lambda e: f"above its strength of {cords.strength[e]:g} N")
    EA = cords.axial_stiffness
    _check(net, tight & (T0 > MOST * EA), T0, lambda e: f"{T0[e] / EA[e]:.3g} times its axial stiffness")
    span = np.linalg.norm(net.spans, axis=1)
    L = span / stretch_under(T0, cords)
    given = net.rest_length
    other = (np.abs(given - span) > SAME * span) & (np.abs(given - L) > SAME * L)
    if (tight & other).any():
        e = int(np.argmax(tight & other))
        raise InputError(
            f"{_named(net, e)} has a prestress of {T0[e]:g} N and the rest length {given[e]:g} m, but for this "
            f"tension it needs {L[e]:.9g} m: leave out its rest_length, or its prestress"
        )
    return replace(net, rest_length=np.where(tight, L, given))


def stretch_under(tension: FloatArray, cords: Cords) -> FloatArray:
    """λ of each cable, (m,), under tensions (m,) in N, zero or more."""
    f, eps = tension / cords.axial_stiffness, cords.toe_strain
    e = np.where(f < 0.5 * eps, np.sqrt(2 * eps * f), f + 0.5 * eps)
    by_engineering = 1 + e
    for _ in range(100):
        in_toe = e < eps
        wide = np.where(eps > 0, eps, 1.0)
        n, dn = np.where(in_toe, 0.5 * e * e / wide, e - 0.5 * eps), np.where(in_toe, e / wide, 1.0)
        root = np.sqrt(1 + 2 * e)
        slope = dn * root + n / root
        step = np.divide(n * root - f, slope, out=np.zeros_like(e), where=slope > 0)
        e = np.maximum(e - step, 0.0)
        if (np.abs(step) <= 4 * np.spacing(e)).all():
            break
    return np.where(cords.engineering, by_engineering, np.sqrt(1 + 2 * e))


def _check(net: CableNet, wrong: BoolArray, T0: FloatArray, why: Callable[[int], str]) -> None:
    if wrong.any():
        e = int(np.argmax(wrong))
        raise InputError(f"{_named(net, e)} has a prestress of {T0[e]:g} N, {why(e)}: give less")


def _named(net: CableNet, e: int) -> str:
    i, j = net.cables[e]
    return f"cable {e} between nodes {i} and {j}"
