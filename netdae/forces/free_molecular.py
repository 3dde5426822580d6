"""Drag of cords in orbit, where molecules come singly.

Symbols, for a cable from node i to node j: d = xⱼ − xᵢ (3,), L̄ rest length, D diameter, ρ density of the air;
w (3,) velocity of the air relative to a node; θ the angle between w and the cord.

Above some 120 km molecules meet a cord more often than each other, and a satellite overtakes them 5 to 10
times as fast as they fly about. In this limit those that strike a straight cord of length l are those in the beam of
its projected area, D l sin θ: a mass ρ D l sin θ |w| per second, which loses the momentum w per unit of mass. The cord
takes all of it, and what the molecules take with them when they leave. Where the surface has caught them (full
accommodation) they leave with the slow speed of its own temperature and in all directions: that adds some 5 %. So

    f = ½ ρ C_D D l sin θ |w| w,        l sin θ |w| = |d × w|,

along the stream, not across the cord, with C_D = 2 for the catch and 2.1 to 2.2 in all; where
molecules bounce off (little accommodation, above 500 km) it is more, up to 2.8. L. H. Sentman 1961 (Free Molecule
Flow Theory, Lockheed LMSC-448514) gives the whole expressions, G. E. Cook 1965 (Planetary and Space Science 13, 929)
the 2.2 that satellites are reckoned with; for the part of accommodation see E. Doornbos 2012, Thermospheric
Density and Wind Determination from Satellite Dynamics, ch. 3. Left out is what strikes a cord from the side by its
own motion when it points along the stream: √π/(2S) of its broadside drag, a tenth at the speed ratio S = 8.

A slack cord shows what `forces.drag` derives, so that the force on each end of a cable is

    f = ¼ ρ C_D D (|d × w| + (π/4) (L̄ − l)₊ |w|) w.

In the frame of an orbit (see `forces.orbit`) that does not turn with the Earth, the air at rest about the Earth
streams at (0, −V, 0) with V the speed on the orbit, and w = stream − v. That takes the frame's own turning, n |r|, for
nothing beside V. Air that turns with the Earth moves eastward at 7.292e-5 rad/s times the radius: on an eastward
orbit at 600 km and 0° of inclination V is 509 m/s less, and the drag 13 %.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from netdae._arrays import FloatArray, IntArray
from netdae.forces.drag import check_positive, seen_length, seen_slopes, thickness_of
from netdae.forces.protocol import Account, Force, NewtonPart, Tangent
from netdae.material import Cords
from netdae.net import CableNet
from netdae.signals import Signal, signal_of

TYPICAL = 2.2
"""C_D of satellites by Cook 1965."""


@njit(cache=True)
def molecular_drag_of(
    c: float, dx: float, dy: float, dz: float, L: float, wx: float, wy: float, wz: float
) -> tuple[float, float, float]:
    """Force in N on one end of a cable; c = ¼ ρ C_D D, kg/m²."""
    push = c * seen_length(dx, dy, dz, L, wx, wy, wz)
    return push * wx, push * wy, push * wz


@njit(cache=True)
def _forces(
    x: FloatArray, v: FloatArray, L: FloatArray, c: FloatArray, stream: FloatArray, f: FloatArray
) -> None:
    for e in range(len(L)):
        dx, dy, dz = x[e, 1, 0] - x[e, 0, 0], x[e, 1, 1] - x[e, 0, 1], x[e, 1, 2] - x[e, 0, 2]
        for end in range(2):
            f[e, end, 0], f[e, end, 1], f[e, end, 2] = molecular_drag_of(
                c[e],
                *(dx, dy, dz, L[e]),
                *(stream[0] - v[e, end, 0], stream[1] - v[e, end, 1], stream[2] - v[e, end, 2]),
            )


@njit(cache=True)
def _tangents(
    x: FloatArray,
    v: FloatArray,
    L: FloatArray,
    c: FloatArray,
    stream: FloatArray,
    K: FloatArray,
    C: FloatArray,
) -> None:
    for e in range(len(L)):
        d = x[e, 1] - x[e, 0]
        for end in range(2):
            w = stream - v[e, end]
            seen = seen_length(d[0], d[1], d[2], L[e], w[0], w[1], w[2])
            by_d, by_w = seen_slopes(d, L[e], w)
            for a in range(3):
                for b in range(3):
                    K[e, end, a, 1, b] = c[e] * w[a] * by_d[b]
                    K[e, end, a, 0, b] = -c[e] * w[a] * by_d[b]
                    C[e, end, a, end, b] = -c[e] * (w[a] * by_w[b] + (seen if a == b else 0.0))


@dataclass(frozen=True, eq=False)
class FreeMolecularDrag:
    """Drag of the cables of a group in the thin air of an orbit.

    density : ρ of the air, kg/m³
    stream : velocity of the air in the net's frame, m/s: three numbers, a Signal or a smooth function of t;
        (0, −V, 0) in the frame of an orbit with the speed V
    drag_coefficient : C_D on the projected area
    cables : cable group
    diameter : m, as the air sees it; None takes that of a round cord of the material's cross-section

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
        return MolecularDrag(net.cables[cables], net.rest_length[cables], weight, signal_of(self.stream))


@dataclass(frozen=True, eq=False)
class MolecularDrag:
    """Free molecular drag of cables, half of it on each end.

    nodes : (m, 2); L : L̄ (m,), m; weight : ¼ ρ C_D D (m,), kg/m²; signal : the stream, m/s

    All its power is external: seen from an orbit it drives a net back along the track as well as it brakes it.
    """

    nodes: IntArray
    L: FloatArray
    weight: FloatArray
    signal: Signal

    newton: NewtonPart = "nothing"
    external: bool = True

    @property
    def jumps(self) -> tuple[float, ...]:
        """Jumps of the stream."""
        return self.signal.jumps

    @property
    def kinks(self) -> tuple[float, ...]:
        """Kinks of the stream."""
        return self.signal.kinks

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Force on the two nodes of each cable, (m, 2, 3), N."""
        f = np.empty_like(x)
        _forces(x, v, self.L, self.weight, self.signal(t), f)
        return f

    def tangent(self, t: float, x: FloatArray, v: FloatArray) -> Tangent:
        """Derivatives of all cables."""
        K, C = np.zeros((2, len(self.L), 2, 3, 2, 3))
        _tangents(x, v, self.L, self.weight, self.signal(t), K, C)
        return Tangent.of_all(K, C)

    def account(self, t: float, x: FloatArray, v: FloatArray) -> Account:
        """External power f·v."""
        return Account(external_power=float(np.vdot(self.force(t, x, v), v)))
