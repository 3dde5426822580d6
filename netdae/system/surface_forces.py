"""Effect of light and of air, in orbit or dense, on the net: their force, and how fast it moves what it acts on."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.forces.air import AIR, AirOnCables
from netdae.forces.drag import BODY_DRAG
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.forces.free_molecular import MolecularDrag
from netdae.forces.orbit import OrbitForce
from netdae.forces.solar import is_light
from netdae.model.tether import is_own_node
from netdae.system.system import System

FASTEST_WIND = 1000.0
"""m/s: a faster stream is the thin air of an orbit, at 7 km/s and more; no wind on the ground is so fast."""


def kind_of(force: Force, t: float) -> str | None:
    """Which of orbit, drag, sunlight and air a force is, just after t; None for others.

    The drag of bodies has one law in orbit and in dense air: it is distinguished by `FASTEST_WIND`.
    """
    if not isinstance(force, ElementForce):
        return None
    if force.law is BODY_DRAG:
        return "drag" if size_of(force, t) > FASTEST_WIND else "air"
    return "sunlight" if is_light(force) else _KINDS.get(force.law.parameters)


_KINDS = {OrbitForce: "orbit", MolecularDrag: "drag", AirOnCables: "air"}


@dataclass(frozen=True)
class SurfaceForce:
    """Effect of the air, or of light, on the net.

    newtons : on cords and bodies together, N
    acceleration : m/s², the larger of that of the cords and those of the bodies, each force on the mass it acts on
    stream : m/s, of the air, or one for light
    on : "cords", "bodies" or "cords and bodies"
    """

    newtons: float
    acceleration: float
    stream: float
    on: str


def surface_force_of(
    system: System, t: float, kind: str, *, speed: float = 0.0, still: bool = False
) -> SurfaceForce | None:
    """All forces of a kind, drag, sunlight or air, that a system has on its net; None where it has none.

    speed : m/s, of the net through still air; still : leaves out the wind
    """
    nodes = is_own_node(system.net)
    cords, bodies, fastest, stream = 0.0, 0.0, 0.0, 0.0
    found = [force for force in system.forces if kind_of(force, t) == kind]
    cord_mass = float(
        system.cords.linear_density @ (system.net.rest_length * nodes[system.net.cables].all(axis=1))
    )
    for force in found:
        own = 0.0 if still else size_of(force, t)
        acting = nodes[force.nodes].all(axis=1)
        newtons = float(_coefficients(force) @ acting) * (own if kind == "sunlight" else (own + speed) ** 2)
        stream = max(stream, own)
        if force.nodes.shape[1] == 1:
            bodies += newtons
            mass = float(system.spatial_mass[force.nodes[acting, 0]].sum())
            fastest = max(fastest, newtons / mass if mass > 0 else 0.0)
        else:
            cords += newtons
    if not found:
        return None
    on = {force.nodes.shape[1] for force in found}
    names = " and ".join(name for number, name in ((2, "cords"), (1, "bodies")) if number in on)
    fastest = max(fastest, cords / cord_mass if cord_mass > 0 else 0.0)
    return SurfaceForce(cords + bodies, fastest, stream, names)


def _coefficients(force: Force) -> FloatArray:
    """Factor of |w|² or of the light where a force is largest, (m,)."""
    assert isinstance(force, ElementForce)
    p = force.parameters
    if force.law is AIR:
        return np.asarray(2 * p.across * p.L)
    return np.asarray(p.weight if force.nodes.shape[1] == 1 else 2 * p.weight * p.L)


def size_of(force: Force, t: float) -> float:
    """|signal| of a force just after t."""
    signal = force.signal  # type: ignore[attr-defined]  # all forces that come here have one
    return float(np.linalg.norm(signal(math.nextafter(t, math.inf))))
