"""The way from compiled code of IDA's driver to what acts beside cables, damping and loads: functions at addresses.

`ida.further_functions` has them. Called by address they are compiled once, and not at all where nothing asks for them.
"""

from __future__ import annotations

from numba import njit

from netdae._arrays import FloatArray, IntArray
from netdae.ida.addresses import call, floats
from netdae.ida.further import further_at


@njit(cache=True)
def add_further_forces(address: int, t: float, x: FloatArray, v: FloatArray, f: FloatArray) -> None:
    """Add all forces of the record at an address to f (3n,)."""
    call(further_at(address).on_forces, (address, t, x.ctypes.data, v.ctypes.data, f.ctypes.data))


@njit(cache=True)
def add_further_rates(
    address: int, t: float, x: FloatArray, v: FloatArray, f: FloatArray, out: FloatArray
) -> float:
    """Add what the books gain to out (8,), see `ida.books`; the largest tension in N. f is room (3n,)."""
    u = further_at(address)
    given = address, t, x.ctypes.data, v.ctypes.data, f.ctypes.data, out.ctypes.data
    call(u.on_rates, given)
    return floats(u.peak, 1)[0]


@njit(cache=True)
def wound_in_whole(address: int, x: FloatArray) -> bool:
    """Whether the rest length of any cord has come to its end, which a flight does not survive."""
    return call(further_at(address).on_end, (address, x.ctypes.data)) != 0


@njit(cache=True)
def add_further_blocks(
    address: int,
    t: float,
    cj: float,
    x: FloatArray,
    v: FloatArray,
    free: FloatArray,
    diagonal: IntArray,
    K: FloatArray,
) -> None:
    """Add the symmetric parts of all blocks to K, and keep the tangents for the products with D."""
    places = free.ctypes.data, len(free), diagonal.ctypes.data, K.ctypes.data, len(K)
    call(further_at(address).on_blocks, (address, t, cj, x.ctypes.data, v.ctypes.data, *places))


@njit(cache=True)
def factor_further(
    address: int,
    cj: float,
    free: FloatArray,
    members: IntArray,
    L_start: IntArray,
    L_row: IntArray,
    L: FloatArray,
    pivots: FloatArray,
) -> bool:
    """Prepare the dyads with the factor of the blocks; False where they are singular."""
    places = free.ctypes.data, len(free), members.ctypes.data, len(members)
    ldl = L_start.ctypes.data, L_row.ctypes.data, len(L_row), L.ctypes.data, pivots.ctypes.data
    return call(further_at(address).on_factor, (address, cj, *places, *ldl)) == 0


@njit(cache=True)
def add_further_products(address: int, r1: FloatArray, right: FloatArray) -> None:
    """right (3n,) gains D r₁, at restrained axes too."""
    call(further_at(address).on_products, (address, r1.ctypes.data, right.ctypes.data))


@njit(cache=True)
def complete(address: int, members: IntArray, y: FloatArray) -> None:
    """y = A⁻¹ b (3n,) becomes K⁻¹ b."""
    call(further_at(address).on_solution, (address, members.ctypes.data, len(members), y.ctypes.data))
