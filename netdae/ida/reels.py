"""What winds cords in, for the compiled driver of IDA: forces and powers of reels, drums and cords through rings.

The formulas are those of `forces.reel`, `forces.brake`, `forces.motor` and `forces.drawcord`, whose kernels are called.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from netdae._arrays import FloatArray
from netdae.forces.brake import friction_of, push_of
from netdae.forces.cables import law_of, strain_of
from netdae.forces.reel import SHORTEST, reeled_forces, reeled_powers
from netdae.ida.further import ReelRoom, winding_at
from netdae.kernels.reels import Brakes, Reels, Stops
from netdae.kernels.strings import add_motor_pulls, add_string_pulls, wound_in

_LEAST = 1e-9  # share of L̄₀: nothing is divided by zero where a flight is about to be refused


@njit(cache=True)
def gather_reeled(x: FloatArray, v: FloatArray, reels: Reels, room: ReelRoom, least: float) -> None:
    """Positions, velocities and rest lengths of the cables on reels; lengths not below a share of L̄₀."""
    for e in range(len(reels.L)):
        for k in range(3):
            for c in range(3):
                room.x[e, k, c], room.v[e, k, c] = x[reels.ends[e, k] + c], v[reels.ends[e, k] + c]
        room.L[e] = max(reels.L[e] + reels.share[e] * room.x[e, 2, 0], least * reels.L[e])


@njit(cache=True)
def wound_in_whole(address: int, x: FloatArray) -> bool:
    """Whether the rest length of any cord has come to its end, which a flight does not survive."""
    w = winding_at(address)
    for e in range(len(w.reels.L)):
        if not w.reels.L[e] + w.reels.share[e] * x[w.reels.ends[e, 2]] > 0.0:
            return True
    return wound_in(x, w.strings) >= 0


@njit(cache=True)
def add_winding_forces(address: int, x: FloatArray, v: FloatArray, f: FloatArray) -> None:
    """Add all forces of the record at an address to f (3n,)."""
    w = winding_at(address)
    if len(w.reels.L):
        reels, room = w.reels, w.on_reels
        gather_reeled(x, v, reels, room, SHORTEST)
        law = reels.share, reels.EA, reels.eps, reels.engineering, reels.tau
        reeled_forces(room.x, room.v, room.L, *law, room.f)
        for e in range(len(reels.L)):
            for k in range(3):
                for c in range(3):
                    f[reels.ends[e, k] + c] += room.f[e, k, c]
    for b in range(len(w.brakes.entry)):
        f[w.brakes.entry[b]] += braked(v, w.brakes, b)[0]
    for e in range(len(w.stops.entry)):
        f[w.stops.entry[e]] -= w.stops.side[e] * stopped(x, v, w.stops, e)[0]
    add_motor_pulls(v, w.motors, f)
    if len(w.strings.L):
        add_string_pulls(x, v, w.strings, f, w.on_strings)


@njit(cache=True)
def braked(v: FloatArray, brakes: Brakes, b: int) -> tuple[float, float]:
    """f of one brake and ∂f/∂ṡ."""
    rate = v[brakes.entry[b]]
    smooth, rise = friction_of(rate / brakes.creep_speed[b], brakes.ratchet[b])
    slope = -brakes.friction[b] * rise / brakes.creep_speed[b] - brakes.viscosity[b]
    return -brakes.friction[b] * smooth - brakes.viscosity[b] * rate, slope


@njit(cache=True)
def stopped(x: FloatArray, v: FloatArray, stops: Stops, e: int) -> tuple[float, float, float]:
    """p of one stop, the way beyond it and its rate."""
    way, rate = stops.side[e] * (x[stops.entry[e]] - stops.place[e]), stops.side[e] * v[stops.entry[e]]
    return push_of(way, rate, stops.stiffness[e], stops.viscosity[e]), max(way, 0.0), rate


@njit(cache=True)
def winding_rates(address: int, x: FloatArray, v: FloatArray, f: FloatArray) -> tuple[float, float, float]:
    """Dissipated and external power in W and the largest tension in N of the record at an address; f is room (3n,)."""
    w = winding_at(address)
    dissipated = external = peak = 0.0
    if len(w.reels.L):
        reels, room = w.reels, w.on_reels
        gather_reeled(x, v, reels, room, _LEAST)
        law = reels.share, reels.EA, reels.eps, reels.engineering, reels.tau
        dissipated += reeled_powers(room.x, room.v, room.L, *law)[1]
        for e in range(len(reels.L)):
            (ax, ay, az), (bx, by, bz) = room.x[e, 0], room.x[e, 1]
            E11 = strain_of(bx - ax, by - ay, bz - az, room.L[e])
            if E11 >= 0.0:
                g = law_of(E11, reels.eps[e], reels.engineering[e])[0]
                peak = max(peak, reels.EA[e] * g * np.sqrt(1.0 + 2.0 * E11))
    for b in range(len(w.brakes.entry)):
        dissipated -= braked(v, w.brakes, b)[0] * v[w.brakes.entry[b]]
    for e in range(len(w.stops.entry)):
        p, way, rate = stopped(x, v, w.stops, e)
        dissipated += (p - w.stops.stiffness[e] * way) * rate
    taken, given = add_motor_pulls(v, w.motors, f)
    dissipated, external = dissipated + taken, external + given
    if len(w.strings.L):
        tally = add_string_pulls(x, v, w.strings, f, w.on_strings)
        dissipated, peak = dissipated + tally.dissipated, max(peak, tally.tension)
    return dissipated, external, peak
