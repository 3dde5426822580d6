"""A start that spins as a rigid body.

Symbols: m masses (n,), kg; x positions (n, 3), m; x_c = Σ m x/Σ m centre of mass; ω spin, rad/s.

The spin adds ω × (x − x_c) to the velocities. It leaves the momentum as it is, since Σ m (x − x_c) = 0, and adds J ω to
the angular momentum, about any point, with the inertia J = Σ m (r² I − r ⊗ r), r = x − x_c.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from netdae.core.errors import InputError
from netdae.model.state import State


def spun(start: State, mass: ArrayLike, spin_deg_s: ArrayLike) -> State:
    """`start` with a spin about an axis through its centre of mass, in addition to the velocities that it has.

    mass : (n,), kg, of all nodes, for instance `System.spatial_mass`
    spin_deg_s : (3,), degrees/s, right-handed about its own direction

    Raises InputError for values of the wrong shape, and where nothing has mass.
    """
    m, spin = np.asarray(mass, dtype=np.float64), np.asarray(spin_deg_s, dtype=np.float64)
    if m.shape != (len(start.x),):
        raise InputError(
            f"spin: mass has the shape {m.shape}: give one number for each of {len(start.x)} nodes"
        )
    if spin.shape != (3,) or not np.isfinite(spin).all():
        raise InputError(f"spin: spin_deg_s is {spin.tolist()}: give three finite numbers, degrees/s")
    if not m.sum() > 0:
        raise InputError("spin: no node has a mass, so there is no centre of mass: give the net a mass")
    centre = m @ start.x / m.sum()
    return State.at(start.x, start.v + np.cross(np.deg2rad(spin), start.x - centre), t=start.t)
