"""The record of all that acts beside cables, damping and loads, as compiled code of IDA's driver sees it.

Reels, drums and cords through rings; orbits, air and light.

`ida.further_record` fills it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import carray, njit

from netdae._arrays import FloatArray, IntArray
from netdae.ida.addresses import bools, floats, ints, pointer_of
from netdae.kernels.reels import Brakes, Reels, Stops
from netdae.kernels.strings import Motors, StringRoom, Strings, StringTangents
from netdae.kernels.surfaces import Bodies, Skins, Tide

_SIZES = """
    n cables brakes stops motors cords cord_nodes segments rows ranks drums nodes links
    skins bodies tides signals
    ask asks_forces asks_held asked_failed asked_blocks
"""
_ARRAYS = """
    reel_ends reel_L reel_share reel_EA reel_eps reel_engineering reel_tau reel_least
    reel_x reel_v reel_f reel_now
    brake_entry brake_friction brake_creep_speed brake_viscosity brake_ratchet
    stop_entry stop_place stop_side stop_stiffness stop_viscosity
    motor_entry motor_strength motor_speed motor_width motor_creep_speed
    cord_begin cord_entry cord_first cord_L cord_share cord_EA cord_eps cord_engineering cord_tau
    cord_size cord_friction cord_creep_speed cord_theta
    cord_x cord_v cord_f cord_tension
    joined link_low link_high link_block corners chain_block
    reel_taut reel_count reel_K reel_C drum_entry drum_D
    rank rank_begin chain left by_x by_v
    skin_ends skin_L skin_across skin_along skin_kind skin_signal
    body_entry body_weight body_signal tide_entry tide_mass tide_mean_motion
    signal_start signal_rate signal_since signal_values
    on_forces on_rates on_end on_blocks on_factor on_products on_solution peak
    asked_y asked_f asked_rates asked_block asked_low asked_high asked_T asked_D
    dyad_cord dyad_row dyad_count Z W swaps amounts
"""

FURTHER = np.dtype([(name, np.int64) for name in f"{_SIZES} {_ARRAYS}".split()])


class ReelRoom(NamedTuple):
    """Room for what is local to the cables on reels, (m, 3, 3) but for `L`."""

    x: FloatArray
    v: FloatArray
    f: FloatArray  # N
    L: FloatArray  # L̄ now, m


class Winding(NamedTuple):
    """What winds cords in, and what holds the drums."""

    reels: Reels
    on_reels: ReelRoom
    brakes: Brakes
    stops: Stops
    motors: Motors
    strings: Strings
    on_strings: StringRoom


class Around(NamedTuple):
    """What acts from outside; signals (s, 3) are start + rate (t − since)."""

    tide: Tide
    skins: Skins
    bodies: Bodies
    start: FloatArray
    rate: FloatArray
    since: FloatArray  # (1,), s
    values: FloatArray  # room for the signals now


class Links(NamedTuple):
    """Blocks of the Newton matrix that reels and cords bring beside those of cables, and tangents at the last setup."""

    nodes: IntArray  # (a,), all nodes that they act on
    low: IntArray  # (b,), nodes of each block beside the diagonal
    high: IntArray
    block: IntArray
    corners: IntArray  # (m, 3), blocks of the pairs (i, j), (i, r), (j, r) of each cable on a reel
    chain: IntArray  # (P,), block of the two ends of each segment
    taut: IntArray  # (m,), the cables on reels that are
    number: IntArray  # (1,), how many
    K: FloatArray  # (m, 3, 3, 3, 3), their ∂f/∂x, N/m
    C: FloatArray  # and ∂f/∂v, N s/m
    drums: IntArray  # (d,), entries in x
    D: FloatArray  # (d,), −∂f/∂ṡ of what holds or turns each drum, N s/m


class Dyads(NamedTuple):
    """Dyads of the cords that are taut, see `linear_solver`, at the last setup."""

    cord: IntArray  # (r,)
    row: IntArray  # (r,), where the rows of each begin in the tangents
    number: IntArray  # (1,), r now
    Z: FloatArray  # (3n, r), A⁻¹ P
    W: FloatArray  # (r, r), I − Qᵀ Z, factored
    swaps: IntArray  # (r,), of its rows
    amounts: FloatArray  # (r,)


@njit(cache=True)
def further_at(address: int) -> Any:
    """The record at an address."""
    return carray(pointer_of(address), 1, FURTHER)[0]


@njit(cache=True)
def strings_at(address: int) -> Strings:
    """Cords through rings of a record."""
    u = further_at(address)
    c = u.cords
    return Strings(
        ints(u.cord_begin, c + 1),
        ints(u.cord_entry, u.cord_nodes),
        ints(u.cord_first, c + 1),
        floats(u.cord_L, c),
        floats(u.cord_share, c),
        floats(u.cord_EA, c),
        floats(u.cord_eps, c),
        bools(u.cord_engineering, c),
        floats(u.cord_tau, c),
        floats(u.cord_size, c),
        floats(u.cord_friction, c),
        floats(u.cord_creep_speed, c),
        floats(u.cord_theta, c),
    )


@njit(cache=True)
def winding_at(address: int) -> Winding:
    """What winds and holds, of a record."""
    u = further_at(address)
    m, b, e, w, k = u.cables, u.brakes, u.stops, u.motors, u.cord_nodes
    reels = Reels(
        ints(u.reel_ends, (m, 3)),
        floats(u.reel_L, m),
        floats(u.reel_share, m),
        floats(u.reel_EA, m),
        floats(u.reel_eps, m),
        bools(u.reel_engineering, m),
        floats(u.reel_tau, m),
        floats(u.reel_least, m),
    )
    room = ReelRoom(
        floats(u.reel_x, (m, 3, 3)),
        floats(u.reel_v, (m, 3, 3)),
        floats(u.reel_f, (m, 3, 3)),
        floats(u.reel_now, m),
    )
    brakes = Brakes(
        ints(u.brake_entry, b),
        floats(u.brake_friction, b),
        floats(u.brake_creep_speed, b),
        floats(u.brake_viscosity, b),
        bools(u.brake_ratchet, b),
    )
    stops = Stops(
        ints(u.stop_entry, e),
        floats(u.stop_place, e),
        floats(u.stop_side, e),
        floats(u.stop_stiffness, e),
        floats(u.stop_viscosity, e),
    )
    motors = Motors(
        ints(u.motor_entry, w),
        floats(u.motor_strength, w),
        floats(u.motor_speed, w),
        floats(u.motor_width, w),
        floats(u.motor_creep_speed, w),
    )
    on_strings = StringRoom(
        floats(u.cord_x, (k, 3)),
        floats(u.cord_v, (k, 3)),
        floats(u.cord_f, (k, 3)),
        floats(u.cord_tension, u.segments),
    )
    return Winding(reels, room, brakes, stops, motors, strings_at(address), on_strings)


@njit(cache=True)
def around_at(address: int) -> Around:
    """What acts from outside, of a record."""
    u = further_at(address)
    m, b, o, s = u.skins, u.bodies, u.tides, u.signals
    skins = Skins(
        ints(u.skin_ends, (m, 2)),
        floats(u.skin_L, m),
        floats(u.skin_across, m),
        floats(u.skin_along, m),
        ints(u.skin_kind, m),
        ints(u.skin_signal, m),
    )
    return Around(
        Tide(ints(u.tide_entry, o), floats(u.tide_mass, o), floats(u.tide_mean_motion, o)),
        skins,
        Bodies(ints(u.body_entry, b), floats(u.body_weight, b), ints(u.body_signal, b)),
        floats(u.signal_start, (s, 3)),
        floats(u.signal_rate, (s, 3)),
        floats(u.signal_since, 1),
        floats(u.signal_values, (s, 3)),
    )


@njit(cache=True)
def links_at(address: int) -> Links:
    """Blocks and tangents of a record."""
    u = further_at(address)
    m = u.cables
    return Links(
        ints(u.joined, u.nodes),
        ints(u.link_low, u.links),
        ints(u.link_high, u.links),
        ints(u.link_block, u.links),
        ints(u.corners, (m, 3)),
        ints(u.chain_block, u.segments),
        ints(u.reel_taut, m),
        ints(u.reel_count, 1),
        floats(u.reel_K, (m, 3, 3, 3, 3)),
        floats(u.reel_C, (m, 3, 3, 3, 3)),
        ints(u.drum_entry, u.drums),
        floats(u.drum_D, u.drums),
    )


@njit(cache=True)
def tangents_at(address: int) -> StringTangents:
    """Chains and dyads of a record."""
    u = further_at(address)
    return StringTangents(
        ints(u.rank, u.cords),
        ints(u.rank_begin, u.cords),
        floats(u.chain, (u.segments, 2, 3, 2, 3)),
        floats(u.left, (u.rows, 3)),
        floats(u.by_x, (u.rows, 3)),
        floats(u.by_v, (u.rows, 3)),
    )


@njit(cache=True)
def dyads_at(address: int) -> Dyads:
    """Woodbury's matrices of a record."""
    u = further_at(address)
    r = u.ranks
    return Dyads(
        ints(u.dyad_cord, r),
        ints(u.dyad_row, r),
        ints(u.dyad_count, 1),
        floats(u.Z, (3 * u.n, r)),
        floats(u.W, (r, r)),
        ints(u.swaps, r),
        floats(u.amounts, r),
    )
