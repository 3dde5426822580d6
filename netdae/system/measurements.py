"""Measurements of a net at one instant, in one pass: System's own methods take five times as long."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit

from netdae.core.arrays import BoolArray, FloatArray, IntArray, frozen_ints
from netdae.forces.cables import law_of, own_strain_of, strain_of
from netdae.forces.elements import ElementForce
from netdae.model.tether import own_nodes_of
from netdae.system.closing_assembly import CABLES, DRUMS
from netdae.system.net_forces import NetForces, stores_energy

if TYPE_CHECKING:
    from netdae.system.system import System

MEASURE_NAMES = (
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
    "tether_tension",
)
"""Names of the measurements that `Measurements.measure` returns, in SI units.

tension, load (tension over strength), strain and toe_multiple (the law's own strain over toe strain) are the
largest of the net, ..._cable their cables; taut_count and toe_count count the cables with a toe that are taut, and
those in the toe. speed_moment is Σ m |v| and turn_moment Σ m |x × v|, to which errors of momenta are related.
tether_tension is the largest of the cable group "tether", nan where there is none.
"""

_NONE = frozen_ints([])


class Cordage(NamedTuple):
    """Tether and closing cords at an instant, SI units; nan for what a net does not have.

    paid_out : s of the tether's reel; tether_tension : the largest of the cable group "tether"
    chaser_distance : from the centre of mass of the net's own nodes to the chaser
    closing_length : rest length of all closing cords that is left outside the drums; closing_tension : their largest
    """

    paid_out: float
    tether_tension: float
    chaser_distance: float
    closing_length: float
    closing_tension: float


@dataclass(frozen=True, eq=False)
class Measurements:
    """A system with the data that its measurements need.

    own_mass : (n,), kg, of the net's own nodes: without tether, chaser and reels
    tether : (m,), True at the cables of the tether, without the legs of a bridle
    others : what stores energy besides cables and contact; None where nothing does
    """

    system: System
    own_mass: FloatArray
    tether: BoolArray
    others: NetForces | None = None

    @classmethod
    def of(cls, system: System) -> Measurements:
        """Measurements of a system."""
        own = np.zeros(system.net.node_count)
        nodes = own_nodes_of(system.net)
        own[nodes] = system.spatial_mass[nodes]
        tether = np.zeros(system.net.cable_count, dtype=np.bool_)
        tether[system.net.cable_groups.get("tether", _NONE)] = True
        others = [
            force
            for force in system.forces[1:]
            if stores_energy(force) and not (isinstance(force, ElementForce) and force.law.across)
        ]
        return cls(
            system,
            own if own.sum() > 0 else system.spatial_mass,
            tether,
            NetForces.of(others, system.in_space) if others else None,
        )

    def centre_of(self, x: FloatArray) -> FloatArray:
        """Centre of mass of the net's own nodes, (3,), m."""
        return np.asarray(self.own_mass @ x / self.own_mass.sum())

    def own_momentum(self, v: FloatArray) -> FloatArray:
        """Momentum of the net's own nodes, (3,), N s."""
        return np.asarray(self.own_mass @ v)

    def cordage_at(self, x: FloatArray) -> Cordage:
        """Tether and closing cords at the positions x (n, 3)."""
        system, net = self.system, self.system.net
        reel, chaser, drums = (net.node_groups.get(name, _NONE) for name in ("reel", "chaser", DRUMS))
        closing = net.cable_groups.get(CABLES, _NONE)
        tension = system.tension(x) if self.tether.any() or len(closing) else np.zeros(0)
        wound = sum(each.share * x[each.node, 0] for each in system.reels if each.node in drums)
        return Cordage(
            float(x[reel, 0].sum()) if len(reel) else np.nan,
            float(tension[self.tether].max()) if self.tether.any() else np.nan,
            float(np.linalg.norm(x[chaser].mean(axis=0) - self.centre_of(x))) if len(chaser) else np.nan,
            float(net.rest_length[closing].sum() + wound) if len(closing) else np.nan,
            float(tension[closing].max()) if len(closing) else np.nan,
        )

    def tether_at(self, x: FloatArray) -> dict[str, float]:
        """Paid-out length, rest length and mass left of the tether and its chaser's distance; those that exist."""
        system, now = self.system, self.cordage_at(x)
        reel, density = system.net.node_groups.get("reel", _NONE), system.cords.linear_density
        left = [density[each.cables[0]] * x[each.node, 0] for each in system.reels if each.node in reel]
        figures = {
            "paid_out": now.paid_out,
            "length": float(system.rest_length(x)[self.tether].sum()),
            "mass_left": float(np.sum(left)) if left else np.nan,
            "final_distance": now.chaser_distance,
        }
        return {name: value for name, value in figures.items() if np.isfinite(value)}

    def direction_of(self, v: FloatArray) -> FloatArray | None:
        """Unit vector (3,) of the momentum of the net's own nodes; None where they have none."""
        momentum = self.own_momentum(v)
        size = float(np.linalg.norm(momentum))
        # the remainder of momenta that cancel is round-off and has no direction
        moving = size > 1e-9 * float(self.own_mass @ np.linalg.norm(v, axis=1))
        return momentum / size if moving else None

    def measure(
        self, x: FloatArray, v: FloatArray, *, t: float = 0.0, contact_energy: float | None = None
    ) -> tuple[float, ...]:
        """The measurements named in `MEASURE_NAMES`.

        contact_energy : J, stored in contact, where it is known
        """
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
            self.tether,
        )
        if contact_energy is None:
            elastic = system.elastic_energy(x) if system.stores_elsewhere else measured[1]
        else:
            elastic = (
                measured[1] + contact_energy + (0.0 if self.others is None else self.others.stored(t, x))
            )
        return (measured[0], elastic, *measured[2:])


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
    tether: BoolArray,
) -> tuple[float, float, float, float, float, float, float, float, float, float, float, float, float]:
    kinetic = elastic = speeds = turns = 0.0
    for i in range(len(mass)):
        vx, vy, vz = v[i, 0], v[i, 1], v[i, 2]
        square = vx * vx + vy * vy + vz * vz
        kinetic += 0.5 * mass[i] * square
        speeds += spatial_mass[i] * np.sqrt(square)
        cx, cy, cz = x[i, 1] * vz - x[i, 2] * vy, x[i, 2] * vx - x[i, 0] * vz, x[i, 0] * vy - x[i, 1] * vx
        turns += spatial_mass[i] * np.sqrt(cx * cx + cy * cy + cz * cz)
    tension = load = multiple = 0.0
    tether_tension = 0.0 if tether.any() else np.nan
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
        if tether[e]:
            tether_tension = max(tether_tension, N)
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
        tether_tension,
    )
