"""Drag of cords in orbit, in free molecular flow.

Symbols, for a cable from node i to node j: d = xⱼ − xᵢ (3,), L̄ rest length, D diameter, ρ density of the air;
w (3,) velocity of the air relative to a node; θ the angle between w and the cord.

Above about 120 km molecules hit a cord more often than each other, and a satellite moves 5 to 10 times as fast as
they do. In this limit a straight cord of length l is struck by the molecules in the beam of its projected area,
D l sin θ: a mass ρ D l sin θ |w| per second, which loses the momentum w per unit of mass. The cord takes all of it, and
the recoil of the molecules when they leave. Where the surface has caught them (full accommodation) they leave with the
slow speed of its own temperature and in all directions: that adds about 5 %. So

    f = ½ ρ C_D D l sin θ |w| w,        l sin θ |w| = |d × w|,

along the stream, not across the cord, with C_D = 2 for the impact and 2.1 to 2.2 in all; where molecules bounce off
(little accommodation, above 500 km) it is larger, up to 2.8. L. H. Sentman 1961 (Free Molecule Flow Theory, Lockheed
LMSC-448514) gives the full expressions, G. E. Cook 1965 (Planetary and Space Science 13, 929) the 2.2 commonly used for
satellites; for the role of accommodation see E. Doornbos 2012, Thermospheric Density and Wind Determination from
Satellite Dynamics, ch. 3. Molecules that strike a cord from the side by their own motion when it points along the
stream are neglected: √π/(2S) of its broadside drag, a tenth at the speed ratio S = 8.

A slack cord shows the length derived in `forces.drag`, so the force on each end of a cable is

    f = ¼ ρ C_D D (|d × w| + (π/4) (L̄ − l)₊ |w|) w.

In the frame of an orbit (see `forces.orbit`) that does not turn with the Earth, the air at rest about the Earth streams
at (0, −V, 0) with V the speed on the orbit, and w = stream − v. This neglects the frame's own rotation, n |r|, against
V. Air that turns with the Earth moves eastward at 7.292e-5 rad/s times the radius: on an eastward orbit at 600 km and
0° of inclination V is 509 m/s less, and the drag 13 % less.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from numpy.typing import ArrayLike

from netdae.core.arrays import FloatArray, Reals
from netdae.forces.drag import check_positive, seen_length, seen_slopes, thickness_of
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.forces.law import Law, Shares, compiled
from netdae.model.material import Cords
from netdae.model.net import CableNet
from netdae.model.signals import Signal, signal_of

TYPICAL = 2.2
"""C_D of satellites by Cook 1965."""


class MolecularDrag(NamedTuple):
    """Parameters of the free molecular drag of cables, half of it on each end, (m,); the signal is the stream, m/s."""

    L: Reals  # L̄, m
    weight: Reals  # ¼ ρ C_D D, kg/m²


@compiled
def molecular_drag_of(
    c: float, dx: float, dy: float, dz: float, L: float, wx: float, wy: float, wz: float
) -> tuple[float, float, float]:
    """Force in N on one end of a cable; c = ¼ ρ C_D D, kg/m²."""
    push = c * seen_length(dx, dy, dz, L, wx, wy, wz)
    return push * wx, push * wy, push * wz


@compiled
def _force(p: MolecularDrag, e: int, s: FloatArray, x: FloatArray, v: FloatArray, f: Shares) -> bool:
    dx, dy, dz = x[1, 0] - x[0, 0], x[1, 1] - x[0, 1], x[1, 2] - x[0, 2]
    for end in range(2):
        w = s[0] - v[end, 0], s[1] - v[end, 1], s[2] - v[end, 2]
        push = molecular_drag_of(p.weight[e], dx, dy, dz, p.L[e], w[0], w[1], w[2])
        f.external[end, 0], f.external[end, 1], f.external[end, 2] = push
    return True


@compiled
def _tangent(
    p: MolecularDrag, e: int, s: FloatArray, x: FloatArray, v: FloatArray, K: FloatArray, C: FloatArray
) -> bool:
    d, c = x[1] - x[0], p.weight[e]
    for end in range(2):
        w = s - v[end]
        seen = seen_length(d[0], d[1], d[2], p.L[e], w[0], w[1], w[2])
        by_d, by_w = seen_slopes(d, p.L[e], w)
        for a in range(3):
            for b in range(3):
                K[end, a, 1, b], K[end, a, 0, b] = c * w[a] * by_d[b], -c * w[a] * by_d[b]
                C[end, a, end, b] = -c * (w[a] * by_w[b] + (seen if a == b else 0.0))
    return True


# all its power is external: seen from an orbit it drives a net back along the track as well as it brakes it
MOLECULAR_DRAG = Law(
    MolecularDrag,
    force=_force,
    tangent=_tangent,
    shares=("external",),
    external=True,
    newton="nothing",
)


@dataclass(frozen=True, eq=False)
class FreeMolecularDrag:
    """Drag of the cables of a group in the thin air of an orbit.

    density : ρ of the air, kg/m³
    stream : velocity of the air in the net's frame, m/s: three numbers, a Signal or a smooth function of t;
        (0, −V, 0) in the frame of an orbit with the speed V
    drag_coefficient : C_D on the projected area
    cables : cable group
    diameter : m, as seen by the air; None takes that of a round cord of the material's cross-section

    Bodies such as bullets are `forces.drag.BodyDrag` with the same stream.
    Raises InputError for values that are not above zero.
    """

    density: float
    stream: Signal | ArrayLike | Callable[[float], ArrayLike]
    drag_coefficient: float = TYPICAL
    cables: str = "all"
    diameter: float | None = None

    def __post_init__(self) -> None:
        check_positive(
            "drag",
            {
                "density": self.density,
                "drag_coefficient": self.drag_coefficient,
                "diameter": self.diameter,
            },
        )

    def on(self, net: CableNet, cords: Cords, mass: FloatArray) -> Force:
        """Bound to the group's cables; raises InputError for an unknown group."""
        cables = net.cables_of(self.cables)
        weight = 0.25 * self.density * self.drag_coefficient * thickness_of(cables, cords, self.diameter)
        parameters = MolecularDrag(net.rest_length[cables], weight)
        return ElementForce(MOLECULAR_DRAG, net.cables[cables], parameters, signal_of(self.stream))
