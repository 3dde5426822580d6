"""The record that the compiled driver of IDA works on, as compiled code sees it.

It holds numbers and the addresses of arrays; its own address is IDA's user data and the content of Newton's solver.
`ida.record` fills it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import carray, njit

from netdae.ida.addresses import bools, floats, ints, pointer_of
from netdae.ida.kernel import Held, Near, Net, Push
from netdae.ida.matrix import Matrix
from netdae.kernels.cables import Cords, Dashpots, Drags

_SIZES = "n cables drags alphas pushes held blocks constant free off L_size plain"
_ARRAYS = """
    mass in_space ends L2 half viscous EA eps engineering tau drag_ends drag_viscosity alpha
    near near_number near_x dashpots dashpot_q forces
    push_start push_rate held_entry held_place held_speed held_gain
    K constant_blocks diagonal beside free_axes inverse taut d c graph_counts order place members member_diagonal
    column_start row source flipped present parent L_start L_row L pivots flag L_count path stack Y work right
    times states slopes books tensions rates middle_rates middle clock system z
"""
_OF_SUNDIALS = "ida_solve system_data error_test_fails on_setup on_test memory y yp correction further"
_COUNTS = """
    residuals setups solves errors_failed newton_failed not_finite singular made stuck iteration
"""
_REALS = "cj rtol atol_position atol_velocity since reach not_finite_at"

RECORD = np.dtype(
    [(name, np.int64) for name in f"{_SIZES} {_ARRAYS} {_OF_SUNDIALS} {_COUNTS}".split()]
    + [(name, np.float64) for name in _REALS.split()]
)


@njit(cache=True)
def record_at(address: int) -> Any:
    """The record at an address."""
    return carray(pointer_of(address), 1, RECORD)[0]


@njit(cache=True)
def net_of(u: Any) -> Net:
    """The net of a record."""
    n, m = u.n, u.cables
    cords = Cords(
        ints(u.ends, (m, 2)),
        floats(u.L2, m),
        floats(u.half, m),
        floats(u.viscous, m),
        floats(u.EA, m),
        floats(u.eps, m),
        bools(u.engineering, m),
        floats(u.tau, m),
        u.plain != 0,
    )
    drags = Drags(
        ints(u.drag_ends, (u.drags, 2)), floats(u.drag_viscosity, (u.drags, 6)), floats(u.alpha, u.alphas)
    )
    push = Push(floats(u.push_start, u.pushes), floats(u.push_rate, u.pushes), u.since)
    held = Held(
        ints(u.held_entry, u.held),
        floats(u.held_place, u.held),
        floats(u.held_speed, u.held),
        floats(u.held_gain, u.held),
        u.since,
    )
    near = Near(ints(u.near, m), ints(u.near_number, 1), floats(u.near_x, 3 * n), u.reach)
    dashpots = Dashpots(ints(u.dashpots, m), floats(u.dashpot_q, m))
    return Net(
        floats(u.mass, n),
        bools(u.in_space, n),
        cords,
        drags,
        push,
        held,
        near,
        dashpots,
        floats(u.forces, 3 * n),
        u.further,
    )


@njit(cache=True)
def matrix_of(u: Any) -> Matrix:
    """The Newton matrix of a record."""
    n, m, b, off = u.n, u.cables, u.blocks, u.off
    return Matrix(
        floats(u.K, (b, 3, 3)),
        floats(u.constant_blocks, (u.constant, 3, 3)),
        ints(u.diagonal, n),
        ints(u.beside, m),
        floats(u.free_axes, u.free),
        floats(u.inverse, 3 * n),
        ints(u.taut, m),
        floats(u.d, (m, 3)),
        floats(u.c, m),
        ints(u.graph_counts, 3),
        ints(u.order, n),
        ints(u.place, n),
        ints(u.members, n),
        ints(u.member_diagonal, n),
        ints(u.column_start, n + 1),
        ints(u.row, off),
        ints(u.source, off),
        bools(u.flipped, off),
        bools(u.present, off),
        ints(u.parent, n),
        ints(u.L_start, n + 1),
        ints(u.L_row, u.L_size),
        floats(u.L, (u.L_size, 3, 3)),
        floats(u.pivots, (n, 6)),
        ints(u.flag, n),
        ints(u.L_count, n),
        ints(u.path, n),
        ints(u.stack, n),
        floats(u.Y, (n, 3, 3)),
        floats(u.work, (n, 3)),
        floats(u.right, 3 * n),
        floats(u.right, (n, 3)),
    )
