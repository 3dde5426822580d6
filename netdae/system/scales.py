"""Scales of a net in flight: masses, sizes, speeds and its fall, from which orders of magnitude are estimated.

Symbols: m mass, L size, v speed, w speed of a jerk between neighbours, D = max(L, v t) reach in the time t,
A = Σ d L̄ area of the cords seen from the side, EĀ stiffness and λ mass per length of a cord, g gravity, h sag,
k v² drag of the air, u = √(m g/k) terminal velocity.

Fall, from rest against k v²: v = u tanh(g t/u) after the distance (u²/g) ln cosh(g t/u), and
v² = u² (1 − exp(−2 g h/u²)) over the height h; without air g t, ½ g t², 2 g h.

Sag: h is how far the middle of a held net comes down. A cord of the length L between ends l apart hangs in a V with
h = ½ √(L² − l²). If it is taut, the weight m g stretches it: the tension m g L/8h of a flat parabola and its strain 8/3
(h/L)² give h = L (3 m g/64 EĀ)^⅓ (H. M. Irvine 1981, Cable Structures, ch. 2). To the larger of both add, for a net
held from one side only, how far the middle is from the middle of the held knots, and how much further knots reach out
than the held ones do. The V is taut at an angle with sin θ = 2h/L, and of the speed of the sag only w = v sin θ is
along the cords. The fall of a free net jerks no cord.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.forces.elements import ElementForce
from netdae.forces.loads import UNIFORM_LOAD
from netdae.forces.solar import is_light
from netdae.model.restraints import Restraint
from netdae.model.signals import Signal
from netdae.model.state import State
from netdae.model.tether import is_own_node, own_cables_of
from netdae.system.surface_forces import surface_force_of
from netdae.system.system import System


@dataclass(frozen=True)
class Fall:
    """How a mass falls in uniform gravity against a drag k v², k in kg/m.

    gravity : m/s², largest of the flight, zero where there is none
    mass : kg
    held, free : s of the flight during which it is held and is not
    sag : m, while it is held
    """

    gravity: float
    mass: float
    held: float
    free: float
    sag: float

    def speed(self, drag: float) -> float:
        """Largest speed, m/s."""
        return max(self.sag_speed(drag), self._after(self.free, drag)[0])

    def way(self, drag: float) -> float:
        """Distance travelled by the middle, m."""
        return min(self._after(self.held, drag)[1], self.sag) + self._after(self.free, drag)[1]

    def sag_speed(self, drag: float) -> float:
        """Largest speed while it is held, m/s."""
        square = 2 * self.gravity * self.sag
        if drag > 0:
            u2 = self.mass * self.gravity / drag
            square = -u2 * math.expm1(-square / u2) if u2 > 0 else 0.0
        return min(math.sqrt(square), self._after(self.held, drag)[0])

    def _after(self, t: float, drag: float) -> tuple[float, float]:
        """Speed in m/s and distance in m after t s from rest."""
        g = self.gravity
        if drag == 0 or g == 0:
            return g * t, 0.5 * g * t**2
        u = math.sqrt(self.mass * g / drag)
        T = g * t / u
        return u * math.tanh(T), u**2 / g * (T + math.log1p(math.exp(-2 * T)) - math.log(2))


@dataclass(frozen=True)
class Scales:
    """Quantities from which orders of magnitude are estimated.

    mass, cord_mass : kg, of the net with its bullets, and of its cords alone
    size : m, twice the largest distance of a knot from the middle of the open net: a square's diagonal
    area : m², of all cords seen from the side
    impedance : kg/s, √(EĀλ) of the cord with the largest
    wave_speed : m/s, in that cord
    speed : m/s, root mean square at the start, weighted by mass; of a net at rest see `scales_of`
    jerk : m/s, largest difference of velocity of the ends of a cable at the start, or that of the sag
    flight_time : s
    air : kg/m, k of the air that the system has, zero where it has none
    fall : from rest, during the flight
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
    air: float
    fall: Fall
    held: bool

    @property
    def reach(self) -> float:
        """The larger of size and path, m."""
        return max(self.size, self.speed * self.flight_time)


def scales_of(system: System, start: State, flight_time: float) -> Scales:
    """Masses, size and speeds of the net.

    Speeds are those of the start, those of the release where nodes are held before, and under gravity those of the sag
    while they are held. The fall of a free net adds none, see `Fall`. Any other net at rest crosses its size in the
    flight time.
    """
    net, cords = system.net, system.cords
    nodes, cables = is_own_node(net), own_cables_of(net)
    mass = system.mass[nodes]
    lengths, size = net.rest_length[cables], _span(net.nodes[nodes])
    # where cords are massless the nodes' masses go along with waves
    along = np.where(cords.linear_density > 0, cords.linear_density, float(mass.sum() / lengths.sum()))
    impedances = np.sqrt(cords.axial_stiffness * along)[cables]
    stiffest = int(np.argmax(impedances))
    holds = [r for r in system.restraints if nodes[r.nodes_of(net)].any()]
    g = _gravity_during(system, start.t, start.t + flight_time)
    air = surface_force_of(system, start.t, "air", speed=1.0, still=True)
    held = max((_held_during(r, start.t, flight_time) for r in holds), default=0.0)
    stretch = float(mass.sum()) * g / float(cords.axial_stiffness[cables].max())
    sag = _sag_of(system, start, holds, stretch) if held > 0 else 0.0
    fall = Fall(g, float(mass.sum()), held, flight_time - held, sag)
    k = air.newtons if air else 0.0
    v = _speeds_of(system, start)
    rms = math.sqrt(float(mass @ np.einsum("ni,ni->n", v[nodes], v[nodes])) / max(float(mass.sum()), 1e-300))
    sagging = fall.sag_speed(k)
    speed = max(rms, sagging) or size / flight_time
    ends = v[net.cables[cables]]  # (m, 2, 3)
    jerk = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max())
    return Scales(
        mass=float(mass.sum()),
        cord_mass=float(cords.linear_density[cables] @ lengths),
        size=size,
        area=float(np.sqrt(4 * cords.area[cables] / np.pi) @ lengths),
        impedance=float(impedances[stiffest]),
        wave_speed=float(np.sqrt(cords.axial_stiffness / along)[cables][stiffest]),
        speed=speed,
        jerk=max(jerk, sagging * min(1.0, 2 * sag / size)) or speed,
        flight_time=flight_time,
        air=k,
        fall=fall,
        held=any(r.until == math.inf for r in holds),
    )


def _span(x: FloatArray) -> float:
    """Twice the largest distance from the middle of points x (n, 3), m."""
    return 2 * float(np.linalg.norm(x - x.mean(axis=0), axis=1).max())


def _held_during(restraint: Restraint, begin: float, flight_time: float) -> float:
    """How long after `begin` a restraint holds, s; to the end if it waits for an event."""
    if isinstance(restraint.until, str):
        return flight_time
    return min(max(restraint.until - begin, 0.0), flight_time)


def _sag_of(system: System, start: State, holds: list[Restraint], stretch: float) -> float:
    """h in m; stretch : m g/EĀ."""
    net, nodes = system.net, is_own_node(system.net)
    of_holds = np.unique(np.concatenate([r.nodes_of(net) for r in holds]))
    x, held = net.nodes[nodes], net.nodes[of_holds[nodes[of_holds]]]
    L, l = _span(x), _span(start.x[nodes])  # noqa: E741  # the page's letter
    V = 0.5 * math.sqrt(max(L**2 - l**2, 0.0))
    aside = float(np.linalg.norm(x.mean(axis=0) - held.mean(axis=0)))
    return min(L, max(V, L * (3 * stretch / 64) ** (1 / 3)) + aside + 0.5 * (L - min(L, _span(held))))


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
    for t in np.linspace(begin, end, 203)[1:-1].tolist():  # jumps tend to lie at round numbers
        g = np.zeros(3)
        for load in loads:
            if load.covers(t, t):
                g += load(t)
        largest = max(largest, float(np.linalg.norm(g)))
    return largest


def gravities_of(system: System) -> list[Signal]:
    """g, m/s², of the uniform loads that pull on every mass in proportion to it."""
    return [
        force.signal
        for force in system.forces
        if isinstance(force, ElementForce) and force.signal is not None and _pulls_masses(force, system)
    ]


def _pulls_masses(load: ElementForce, system: System) -> bool:
    if load.law is not UNIFORM_LOAD:
        return False
    nodes, pulled = load.nodes[:, 0], np.zeros(system.net.node_count, dtype=np.bool_)
    pulled[nodes] = load.parameters.weight == system.spatial_mass[nodes]
    return bool(pulled[system.spatial_mass > 0].all()) and not is_light(load)
