"""Forces from outside beside loads, for the compiled driver of IDA: orbits, air, light."""

from __future__ import annotations

from numba import njit

from netdae._arrays import FloatArray
from netdae.ida.further import around_at
from netdae.kernels.surfaces import add_body_drags, add_skin_forces, add_tide


@njit(cache=True)
def add_outside_forces(address: int, t: float, x: FloatArray, v: FloatArray, f: FloatArray) -> None:
    """Add them to f (3n,)."""
    around = around_at(address)
    for s in range(len(around.values)):
        for c in range(3):
            around.values[s, c] = around.start[s, c] + around.rate[s, c] * (t - around.since[0])
    add_tide(x, v, around.tide, f)
    add_skin_forces(x, v, around.values, around.skins, f)
    add_body_drags(v, around.values, around.bodies, f)


@njit(cache=True)
def outside_rates(
    address: int, t: float, x: FloatArray, v: FloatArray, f: FloatArray, out: FloatArray
) -> None:
    """Add their power, force and torque to out[1:8], see `ida.books`; f is room (3n,)."""
    for k in range(len(f)):
        f[k] = 0.0
    add_outside_forces(address, t, x, v, f)
    for k in range(len(f)):
        out[1] += f[k] * v[k]
        if f[k] != 0.0:
            add_wrench(x, k, f[k], out)


@njit(cache=True)
def add_wrench(x: FloatArray, k: int, force: float, out: FloatArray) -> None:
    """The force along entry k of x, and its moment about the origin, to out[2:8]."""
    c = k % 3
    node = k - c
    after, before = (c + 1) % 3, (c + 2) % 3
    out[2 + c] += force
    out[5 + after] += x[node + before] * force
    out[5 + before] -= x[node + after] * force
