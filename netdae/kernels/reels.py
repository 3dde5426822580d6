"""Reels for the kernel of `explicit.verlet`: cables whose rest length moves, and what holds or turns their drums.

A brake is far too stiff for an explicit step: F_b/(v₀ J/R²) is 5e4 1/s for 5 N, 1 mm/s and 0.1 kg; so are a motor's
controller and pawl. Hence the force g on a drum, of its brakes, stops and motors, is taken at the velocity after the
kick,

    v⁺ = v + h (f + g(s, v⁺))/m,

one equation for each drum, whose left side less its right one rises with v⁺ by 1 at least: it has one solution,
found by Newton's method between bounds. A brake then holds at any step length, and costs no order while it slides.
A motor's work comes from outside, all else that g does is stored in stops or lost.

Symbols as in `forces.reel`, `forces.brake` and `forces.motor`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.forces.brake import friction_of
from netdae.forces.cables import law_of, strain_of
from netdae.forces.motor import motor_of
from netdae.forces.reel import reeled_forces
from netdae.kernels.strings import Motors

ITERATIONS = 60  # bisection alone is at round-off by then


class Reels(NamedTuple):
    """Cables on reels, (m,) but for `ends`."""

    ends: IntArray  # (m, 3), 3i, 3j and 3r
    L: FloatArray  # L̄₀, m
    share: FloatArray  # σ
    EA: FloatArray  # N
    eps: FloatArray
    engineering: BoolArray
    tau: FloatArray  # s
    least: FloatArray  # m, rest lengths below which the step may be too long


class Local(NamedTuple):
    """Room for what is local to the cables on reels, (m, 3, 3) but for `L` and `none` (m,)."""

    x: FloatArray
    v: FloatArray
    f: FloatArray
    elastic: FloatArray  # share of f
    viscous: FloatArray  # share of f
    L: FloatArray  # L̄, m
    none: FloatArray  # τ of no dashpot, s


class Brakes(NamedTuple):
    """Brakes, (b,)."""

    entry: IntArray  # of the drum in x
    friction: FloatArray  # N
    creep_speed: FloatArray  # m/s
    viscosity: FloatArray  # N s/m
    ratchet: BoolArray


class Stops(NamedTuple):
    """Ends of the ways of drums, (e,)."""

    entry: IntArray
    place: FloatArray  # m
    side: FloatArray
    stiffness: FloatArray  # N/m
    viscosity: FloatArray  # N s/m


class Drums(NamedTuple):
    """Drums that something holds or turns."""

    entry: IntArray  # (d,)
    brakes: Brakes
    stops: Stops
    motors: Motors


@njit(cache=True)
def local_of(reels: Reels) -> Local:
    """Room for some cables on reels."""
    m = len(reels.L)
    x, v, f = np.zeros((m, 3, 3)), np.zeros((m, 3, 3)), np.zeros((m, 3, 3))
    elastic, viscous = np.zeros((m, 3, 3)), np.zeros((m, 3, 3))
    return Local(x, v, f, elastic, viscous, np.zeros(m), np.zeros(m))


@njit(cache=True)
def add_reeled_pulls(
    x: FloatArray, v: FloatArray, reels: Reels, f: FloatArray, local: Local
) -> tuple[float, float, bool]:
    """Add pulls to f, also told in local with the dashpots' share; largest tension, strain, and if one is too short."""
    peak, strain, short = 0.0, -np.inf, False
    xe, L = local.x, local.L
    for e in range(len(L)):
        for k in range(3):
            for c in range(3):
                xe[e, k, c], local.v[e, k, c] = x[reels.ends[e, k] + c], v[reels.ends[e, k] + c]
        L[e] = reels.L[e] + reels.share[e] * xe[e, 2, 0]
        short = short or not L[e] >= reels.least[e]
        dx, dy, dz = xe[e, 1, 0] - xe[e, 0, 0], xe[e, 1, 1] - xe[e, 0, 1], xe[e, 1, 2] - xe[e, 0, 2]
        E11 = strain_of(dx, dy, dz, L[e])
        if not E11 < 0.0:
            g = law_of(E11, reels.eps[e], reels.engineering[e])[0]
            strain = max(strain, E11)
            peak = max(peak, reels.EA[e] * g * np.sqrt(1.0 + 2.0 * E11))
    law = reels.share, reels.EA, reels.eps, reels.engineering
    reeled_forces(xe, local.v, L, *law, reels.tau, local.f)
    reeled_forces(xe, local.v, L, *law, local.none, local.elastic)
    for e in range(len(L)):
        for k in range(3):
            for c in range(3):
                f[reels.ends[e, k] + c] += local.f[e, k, c]
                local.viscous[e, k, c] = local.f[e, k, c] - local.elastic[e, k, c]
    return peak, strain, short


@njit(cache=True)
def reeled_power(
    v: FloatArray, share: FloatArray, f: FloatArray, h: float, reels: Reels, local: Local
) -> float:
    """Power in W that the dashpots of reeled cables take in a step."""
    lost = 0.0
    for e in range(len(reels.L)):
        for k in range(3):
            for c in range(3):
                i = reels.ends[e, k] + c
                lost -= local.viscous[e, k, c] * (v[i] + 0.5 * h * share[i] * f[i])
    return lost


@njit(cache=True)
def _held_by(drums: Drums, entry: int, s: float, v: float) -> tuple[float, float, float, float]:
    """g in N on one drum, ∂g/∂v, and those parts of g which take energy and which bring it from outside."""
    g = slope = taking = giving = 0.0
    brakes, stops, motors = drums.brakes, drums.stops, drums.motors
    for b in range(len(brakes.entry)):
        if brakes.entry[b] == entry:
            smooth, rise = friction_of(v / brakes.creep_speed[b], brakes.ratchet[b])
            taking -= brakes.friction[b] * smooth + brakes.viscosity[b] * v
            slope -= brakes.friction[b] * rise / brakes.creep_speed[b] + brakes.viscosity[b]
    for e in range(len(stops.entry)):
        way = stops.side[e] * (s - stops.place[e])
        if stops.entry[e] == entry and way > 0.0:
            spring, damper = stops.stiffness[e] * way, stops.viscosity[e] * stops.side[e] * v
            p = max(spring + damper, 0.0)
            g -= stops.side[e] * spring
            taking -= stops.side[e] * (p - spring)
            slope -= stops.viscosity[e] if p > 0.0 else 0.0
    for w in range(len(motors.entry)):
        if motors.entry[w] == entry:
            numbers = motors.strength[w], motors.speed[w], motors.width[w], motors.creep_speed[w]
            motor, pawl, fall = motor_of(v, *numbers)
            giving += motor
            taking += pawl
            slope += fall
    return g + taking + giving, slope, taking, giving


@njit(cache=True)
def _kicked(drums: Drums, entry: int, s: float, b: float, c: float, near: float) -> float:
    """v⁺ = b + c g(s, v⁺), looked for from `near` on."""
    g, slope, taking, giving = _held_by(drums, entry, s, b)
    low, high = b - abs(c * g), b + abs(c * g)
    v = b
    if low < near < high:
        v = near
        g, slope, taking, giving = _held_by(drums, entry, s, v)
    for _ in range(ITERATIONS):
        miss = v - b - c * g
        if miss == 0.0:
            break
        if miss > 0.0:
            high = v
        else:
            low = v
        new = v - miss / (1.0 - c * slope)
        parts = abs(taking) + abs(giving) + abs(g - taking - giving)
        if abs(new - v) <= 2e-15 * (abs(new) + (abs(b) + c * parts) / (1.0 - c * slope)):  # round-off
            break
        if not low < new < high:
            new = 0.5 * (low + high)
        v = new
        g, slope, taking, giving = _held_by(drums, entry, s, v)
    return v


@njit(cache=True)
def hold_drums(
    x: FloatArray, v: FloatArray, share: FloatArray, f: FloatArray, h: float, drums: Drums
) -> tuple[float, float]:
    """Add what holds the drums to f, in which all other forces stand; the powers in W that it takes and gives."""
    lost = given = 0.0
    for d in range(len(drums.entry)):
        i = drums.entry[d]
        c = h * share[i]  # zero where the drum is driven
        after = _kicked(drums, i, x[i], v[i] + c * f[i], c, v[i])
        g, _, taking, giving = _held_by(drums, i, x[i], after)
        f[i] += g
        mean = v[i] + 0.5 * c * f[i]
        lost -= taking * mean
        given += giving * mean
    return lost, given
