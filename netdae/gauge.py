"""What is measured of a net at one instant, in one pass: System's own methods take five times as long."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.forces.cables import law_of, own_strain_of, strain_of
from netdae.tether import own_nodes_of

if TYPE_CHECKING:
    from netdae.system import System

MEASURES = (
    "kinetic_energy",
    "elastic_energy",
    "tension",
    "tension_cable",
    "load",
    "load_cable",
    "strain",
    "toe_multiple",
    "taut_count",
    "toe_count",
    "speed_moment",
    "turn_moment",
)
"""Names of what `Gauge.measure` gives, in SI units.

tension, load (tension over strength), strain and toe_multiple (the law's own strain over toe strain) are the
largest of the net, ..._cable their cables; taut_count and toe_count count the cables with a toe that are taut, and
that are in it. speed_moment is Σ m |v| and turn_moment Σ m |x × v|, against which errors of momenta are told.
"""


@dataclass(frozen=True, eq=False)
class Gauge:
    """A system with what its measures need.

    own_mass : (n,), kg, of the net's own nodes: without tether, chaser and reels
    """

    system: System
    own_mass: FloatArray

    @classmethod
    def of(cls, system: System) -> Gauge:
        """Gauge of a system."""
        own = np.zeros(system.net.node_count)
        nodes = own_nodes_of(system.net)
        own[nodes] = system.spatial_mass[nodes]
        return cls(system, own if own.sum() > 0 else system.spatial_mass)

    def centre_of(self, x: FloatArray) -> FloatArray:
        """Centre of mass of the net's own nodes, (3,), m."""
        return np.asarray(self.own_mass @ x / self.own_mass.sum())

    def own_momentum(self, v: FloatArray) -> FloatArray:
        """Momentum of the net's own nodes, (3,), N s."""
        return np.asarray(self.own_mass @ v)

    def measure(self, x: FloatArray, v: FloatArray) -> tuple[float, ...]:
        """What `MEASURES` names."""
        system = self.system
        cables = system.cables_at(x)
        measured = _measured(
            x,
            v,
            system.mass,
            system.spatial_mass,
            cables.nodes,
            cables.L,
            cables.EA,
            cables.eps,
            cables.engineering,
            system.strength,
        )
        if not system.reels:
            return measured
        return (measured[0], system.elastic_energy(x), *measured[2:])  # with the stops of the reels


@njit(cache=True)
def _measured(
    x: FloatArray,
    v: FloatArray,
    mass: FloatArray,
    spatial_mass: FloatArray,
    nodes: IntArray,
    L: FloatArray,
    EA: FloatArray,
    eps: FloatArray,
    engineering: BoolArray,
    strength: FloatArray,
) -> tuple[float, float, float, float, float, float, float, float, float, float, float, float]:
    kinetic = elastic = speeds = turns = 0.0
    for i in range(len(mass)):
        vx, vy, vz = v[i, 0], v[i, 1], v[i, 2]
        square = vx * vx + vy * vy + vz * vz
        kinetic += 0.5 * mass[i] * square
        speeds += spatial_mass[i] * np.sqrt(square)
        cx, cy, cz = x[i, 1] * vz - x[i, 2] * vy, x[i, 2] * vx - x[i, 0] * vz, x[i, 0] * vy - x[i, 1] * vx
        turns += spatial_mass[i] * np.sqrt(cx * cx + cy * cy + cz * cz)
    tension = load = multiple = 0.0
    strain = -np.inf
    tension_cable = load_cable = taut_count = toe_count = 0
    for e in range(len(L)):
        i, j = nodes[e]
        E11 = strain_of(x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2], L[e])
        strain = max(strain, E11)
        if E11 <= 0.0:
            continue
        g, _, _, energy = law_of(E11, eps[e], engineering[e])
        elastic += EA[e] * L[e] * energy
        N = EA[e] * g * np.sqrt(1.0 + 2.0 * E11)
        if tension < N:
            tension, tension_cable = N, e
        if load * strength[e] < N:  # never for an infinite strength
            load, load_cable = N / strength[e], e
        if eps[e] > 0.0:
            taut_count += 1
            own = own_strain_of(E11, engineering[e])
            toe_count += eps[e] > own
            multiple = max(multiple, own / eps[e])
    return (
        kinetic,
        elastic,
        tension,
        float(tension_cable),
        load,
        float(load_cable),
        strain,
        multiple,
        float(taut_count),
        float(toe_count),
        speeds,
        turns,
    )
