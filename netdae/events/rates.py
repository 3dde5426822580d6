"""Rates of the figures that events watch, as functions of a State.

Symbols: d, w differences of position and velocity along a cable; E11, L̄, EĀ, σ, s as in `forces.reel`; λ = √(1 + 2 E11)
stretch; g(E11) the law over E; for a cord through rings l its length and l̇ the rate of it, see `forces.rings`.

A cable strains at the rate Ė11 = d·w/L̄² − σ λ² ṡ/L̄, all pieces of a cord through rings at l l̇/L̄² − σ λ² ṡ/L̄ with the
lengths l and L̄ of the whole. The tension N = EĀ g λ then rises at Ṅ = EĀ (g′ λ + g/λ) Ė11. Where a figure is the
largest of several cables, its rate is that of the cable that has it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.events.event import QuantityName
from netdae.events.quantities import Scene
from netdae.forces.cables import law_of
from netdae.model.state import State
from netdae.system.reels import length_of_cord
from netdae.system.system import System


def strain_rates(system: System, x: FloatArray, v: FloatArray) -> FloatArray:
    """Ė11 of each cable, (m,), 1/s."""
    ends = system.net.cables
    d, w = x[ends[:, 1]] - x[ends[:, 0]], v[ends[:, 1]] - v[ends[:, 0]]
    rates = np.einsum("ec,ec->e", d, w) / system.rest_length(x) ** 2
    for reel in system.reels:
        own, s_rate = reel.cables, float(v[reel.node, 0])
        L: FloatArray | float
        if reel.rings is None:
            L = system.rest_length(x)[own]
        else:
            whole = length_of_cord(reel, system.net, system.cables.L)
            L = whole + reel.share * float(x[reel.node, 0])
            h = np.sqrt(np.einsum("ec,ec->e", d[own], d[own]) + reel.rings.size**2)
            rates[own] = h.sum() * (np.einsum("ec,ec->e", d[own], w[own]) / h).sum() / L**2
        rates[own] -= reel.share * s_rate / L * (1 + 2 * system.strain(x)[own])
    return rates


def _tension_rate(system: System, state: State, cable: int) -> float:
    """Ṅ of one cable, N/s; zero where it is slack."""
    E11 = float(system.strain(state.x)[cable])
    if E11 < 0:
        return 0.0
    stretch = math.sqrt(1 + 2 * E11)
    g, dg, _, _ = law_of(E11, system.cords.toe_strain[cable], system.cords.engineering[cable])
    by_strain = float(system.cords.axial_stiffness[cable]) * (dg * stretch + g / stretch)
    return by_strain * float(strain_rates(system, state.x, state.v)[cable])


def _distance(scene: Scene, state: State) -> float:
    velocity = scene.centre_velocity(state)
    along = float(velocity @ scene.direction)
    return along if along == along else _apart(scene.centre(state) - scene.origin, velocity)


def _chaser_distance(scene: Scene, state: State) -> float:
    way = scene.centre(state) - state.x[scene.chaser].mean(axis=0)
    return _apart(way, scene.centre_velocity(state) - state.v[scene.chaser].mean(axis=0))


def _target_distance(scene: Scene, state: State) -> float:
    place = scene.target_place()
    return _apart(scene.centre(state) - state.x[place], scene.centre_velocity(state) - state.v[place])


def _apart(way: FloatArray, velocity: FloatArray) -> float:
    """Rate of |way|, which grows from zero at the speed."""
    length = float(np.sqrt(way @ way))
    return float(way @ velocity) / length if length > 0 else float(np.sqrt(velocity @ velocity))


def _tether_strain(scene: Scene, state: State) -> float:
    system = scene.system
    worst = scene.tether[np.argmax(system.strain(state.x)[scene.tether])]
    return float(strain_rates(system, state.x, state.v)[worst])


def _tether_tension(scene: Scene, state: State) -> float:
    worst = int(scene.tether[np.argmax(scene.system.tension(state.x)[scene.tether])])
    return _tension_rate(scene.system, state, worst)


def _largest_strain(scene: Scene, state: State) -> float:
    system = scene.system
    return float(strain_rates(system, state.x, state.v)[np.argmax(system.strain(state.x))])


def _load(scene: Scene, state: State) -> float:
    system = scene.system
    worst = int(np.argmax(system.tension(state.x) / system.strength))
    return _tension_rate(system, state, worst) / float(system.strength[worst])


RATES: Mapping[QuantityName, Callable[[Scene, State], float]] = {
    "mouth_area": lambda scene, state: scene.area_and_rate(state)[1],
    "corner_area": lambda scene, state: scene.corner_area_and_rate(state)[1],
    "distance": _distance,
    "chaser_distance": _chaser_distance,
    "tether_taut": _tether_strain,
    "tether_tension": _tether_tension,
    "all_slack": _largest_strain,
    "tension_over_strength": _load,
    "target_distance": _target_distance,
}
"""Function of each figure that can turn, in its unit per second."""
