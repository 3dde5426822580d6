"""Functions of C for what acts beside cables, damping and loads, called by way of `ida.further_calls`.

Arguments that are arrays there are addresses here, with their lengths behind them where they are not known.
"""

# ruff: noqa: D103  # each is described there

from __future__ import annotations

from numba import cfunc, types

from netdae.ida.addresses import floats, ints
from netdae.ida.asking import add_asked_blocks, add_asked_forces, add_asked_products, add_asked_rates
from netdae.ida.dyads import complete, factor_dyads, take_dyad_products
from netdae.ida.further import further_at
from netdae.ida.links import add_link_products, add_links
from netdae.ida.outside import add_outside_forces, outside_rates
from netdae.ida.reels import add_winding_forces, winding_rates, wound_in_whole

_I, _A, _D = types.int32, types.int64, types.float64


@cfunc(_I(_A, _D, _A, _A, _A), cache=True)
def on_forces(address, t, x, v, f):  # type: ignore[no-untyped-def]
    n3 = 3 * further_at(address).n
    xs, vs, fs = floats(x, n3), floats(v, n3), floats(f, n3)
    add_winding_forces(address, xs, vs, fs)
    add_outside_forces(address, t, xs, vs, fs)
    add_asked_forces(address, t, xs, vs, fs)
    return 0


@cfunc(_I(_A, _D, _A, _A, _A, _A), cache=True)
def on_rates(address, t, x, v, f, out):  # type: ignore[no-untyped-def]
    u = further_at(address)
    n3 = 3 * u.n
    xs, vs, fs, sums = floats(x, n3), floats(v, n3), floats(f, n3), floats(out, 8)
    dissipated, external, tension = winding_rates(address, xs, vs, fs)
    sums[0] += dissipated
    sums[1] += external
    floats(u.peak, 1)[0] = tension
    outside_rates(address, t, xs, vs, fs, sums)
    add_asked_rates(address, t, xs, vs, sums)
    return 0


@cfunc(_I(_A, _A), cache=True)
def on_end(address, x):  # type: ignore[no-untyped-def]
    return 1 if wound_in_whole(address, floats(x, 3 * further_at(address).n)) else 0


@cfunc(_I(_A, _D, _D, _A, _A, _A, _A, _A, _A, _A), cache=True)
def on_blocks(address, t, cj, x, v, free, axes, diagonal, K, count):  # type: ignore[no-untyped-def]
    n = further_at(address).n
    xs, vs, frees, blocks = floats(x, 3 * n), floats(v, 3 * n), floats(free, axes), floats(K, (count, 3, 3))
    add_links(address, xs, vs, cj, frees, ints(diagonal, n), blocks)
    add_asked_blocks(address, t, xs, vs, cj, frees, blocks)
    return 0


@cfunc(_I(_A, _D, _A, _A, _A, _A, _A, _A, _A, _A, _A), cache=True)
def on_factor(address, cj, free, axes, members, size, L_start, L_row, count, L, pivots):  # type: ignore[no-untyped-def]
    n = further_at(address).n
    done = factor_dyads(
        address,
        cj,
        floats(free, axes),
        ints(members, size),
        ints(L_start, n + 1),
        ints(L_row, count),
        floats(L, (count, 3, 3)),
        floats(pivots, (n, 6)),
    )
    return 0 if done else 1


@cfunc(_I(_A, _A, _A), cache=True)
def on_products(address, r1, right):  # type: ignore[no-untyped-def]
    n3 = 3 * further_at(address).n
    given, gained = floats(r1, n3), floats(right, n3)
    add_link_products(address, given, gained)
    take_dyad_products(address, given, gained)
    add_asked_products(address, given, gained)
    return 0


@cfunc(_I(_A, _A, _A, _A), cache=True)
def on_solution(address, members, size, y):  # type: ignore[no-untyped-def]
    complete(address, ints(members, size), floats(y, 3 * further_at(address).n))
    return 0


FUNCTIONS = {
    "on_forces": on_forces,
    "on_rates": on_rates,
    "on_end": on_end,
    "on_blocks": on_blocks,
    "on_factor": on_factor,
    "on_products": on_products,
    "on_solution": on_solution,
}
"""By their names in the record."""
