"""Scales of a net in flight: its masses, sizes and speeds, of which orders of magnitude are made.

Symbols: m mass, L size, v speed, w speed of a jerk between neighbours, D = max(L, v t) reach in the time t,
A = Σ d L̄ area of the cords seen from the side, EĀ stiffness and λ mass per length of a cord.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.forces.loads import UniformLoad
from netdae.state import State
from netdae.system import System
from netdae.tether import CABLE_GROUPS, NODE_GROUPS


@dataclass(frozen=True)
class Scales:
    """What the orders of magnitude are made of.

    mass, cord_mass : kg, of the net with its bullets, and of its cords alone
    size : m, twice the largest distance of a knot from the middle of the open net: a square's diagonal
    area : m², of all cords seen from the side
    impedance : kg/s, √(EĀλ) of the cord with the largest
    wave_speed : m/s, in that cord
    speed : m/s, root mean square at the start, weighed by mass; of a net at rest see `scales_of`
    jerk : m/s, largest difference of velocity of the ends of a cable at the start
    flight_time : s
    gravity : m/s², largest uniform gravity during the flight, zero where there is none
    held : whether nodes of the net are restrained to the end
    """

    mass: float
    cord_mass: float
    size: float
    area: float
    impedance: float
    wave_speed: float
    speed: float
    jerk: float
    flight_time: float
    gravity: float
    held: bool

    @property
    def reach(self) -> float:
        """The larger of size and path, m."""
        return max(self.size, self.speed * self.flight_time)


def scales_of(system: System, start: State, flight_time: float) -> Scales:
    """Masses, size and speeds of the net.

    Speeds are those of the start, and of the release where nodes are held before. Under gravity there is the speed
    g t of a fall, √(2 g L) where the net is held. A net at rest else crosses its size in the flight time.
    """
    net, cords = system.net, system.cords
    nodes = _members(net.node_groups, net.node_count, NODE_GROUPS)
    cables = _members(net.cable_groups, net.cable_count, CABLE_GROUPS)
    mass = system.mass[nodes]
    x, lengths = net.nodes[nodes], net.rest_length[cables]
    size = 2 * float(np.linalg.norm(x - x.mean(axis=0), axis=1).max())
    impedances = np.sqrt(cords.axial_stiffness * cords.linear_density)[cables]
    stiffest = int(np.argmax(impedances))
    g = _gravity_during(system, start.t, start.t + flight_time)
    held = any(r.until == math.inf and nodes[r.nodes_of(net)].any() for r in system.restraints)
    v = _speeds_of(system, start)
    speed = math.sqrt(
        float(mass @ np.einsum("ni,ni->n", v[nodes], v[nodes])) / max(float(mass.sum()), 1e-300)
    )
    if g > 0:
        fall = g * flight_time
        speed = max(speed, min(fall, math.sqrt(2 * g * size)) if held else fall)
    speed = speed or size / flight_time
    ends = v[net.cables[cables]]  # (m, 2, 3)
    return Scales(
        mass=float(mass.sum()),
        cord_mass=float(cords.linear_density[cables] @ lengths),
        size=size,
        area=float(np.sqrt(4 * cords.area[cables] / np.pi) @ lengths),
        impedance=float(impedances[stiffest]),
        wave_speed=float(np.sqrt(cords.axial_stiffness / cords.linear_density)[cables][stiffest]),
        speed=speed,
        jerk=float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max()) or speed,
        flight_time=flight_time,
        gravity=g,
        held=held,
    )


def _members(groups: Mapping[str, IntArray], count: int, others: tuple[str, ...]) -> BoolArray:
    """Nodes or cables that belong to the net, not to its tether, (count,)."""
    mask = np.ones(count, dtype=np.bool_)
    for name in others:
        mask[groups.get(name, [])] = False
    return mask


def _speeds_of(system: System, start: State) -> FloatArray:
    """Velocities (n, 3) of the start, of held nodes at their release."""
    v = start.v.copy()
    for restraint in system.restraints:
        released = restraint.release_velocity
        if released is not None:
            nodes = restraint.nodes_of(system.net)
            v[np.ix_(nodes, restraint.axis_indices)] = np.asarray(released)[restraint.axis_indices]
    return v


def _gravity_during(system: System, begin: float, end: float) -> float:
    """Largest |g| of all uniform gravities together, m/s²."""
    loads, largest = gravities_of(system), 0.0
    for t in np.linspace(begin, end, 203)[1:-1].tolist():  # jumps tend to stand at round numbers
        g = np.zeros(3)
        for load in loads:
            if load.signal.covers(t, t):
                g += load.signal(t)
        largest = max(largest, float(np.linalg.norm(g)))
    return largest


def gravities_of(system: System) -> list[UniformLoad]:
    """Uniform loads that pull on every mass in proportion to it."""
    return [
        force for force in system.forces if isinstance(force, UniformLoad) and _pulls_masses(force, system)
    ]


def _pulls_masses(load: UniformLoad, system: System) -> bool:
    nodes, pulled = load.nodes[:, 0], np.zeros(system.net.node_count, dtype=np.bool_)
    pulled[nodes] = load.weight == system.spatial_mass[nodes]
    return bool(pulled[system.spatial_mass > 0].all())
