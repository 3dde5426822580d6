"""The callbacks of SUNDIALS, compiled to C functions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import carray, cfunc, njit, types

from netdae.core.addresses import address_of, call, floats, ints
from netdae.core.arrays import FloatArray
from netdae.core.records import load
from netdae.forces.table import Rows, set_time
from netdae.solvers.ida.dyads import Dyads
from netdae.solvers.ida.kernel import OPTIONS, Net, residual
from netdae.solvers.ida.layout import Chunk, record_at
from netdae.solvers.ida.newton import Matrix, assemble, factor, is_out_of_line, solve
from netdae.solvers.ida.taut import CONVERGED, ITERATIONS, STIFF
from netdae.solvers.linalg.block_ldl import Ldl

TARGET = (
    20.0  # measured on a flip of the intermediate axis, 60 s: at 1 it loses 1e-4 of its energy, at 20 7e-6
)
_NEWTON_ITERATIONS = 4  # IDA's own limit
_GO_ON, _NOT_CONVERGED = 901, 902  # SUN_NLS_CONTINUE, SUN_NLS_CONV_RECVR
_RESIDUAL_FAILED = -8  # IDA_RES_FAIL


@njit(cache=True, forceinline=True)
def data_of(vector: int, size: int) -> Any:
    """Data of a serial vector."""
    return floats(ints(ints(vector, 1)[0], 2)[1], size)


@njit(**OPTIONS)
def put_curved_axes(t: float, predicted: FloatArray, net: Net, e: FloatArray) -> None:
    """Let the correction put axes with curved motions in place at once, so that r₁ and r₂ vanish there."""
    if not net.curved_axes:
        return
    set_time(load(net.rows, Rows), t)
    n3 = 3 * len(net.mass)
    for c in range(len(net.entry)):
        k = net.entry[c]
        e[k] = net.place[c] + net.speed[c] * (t - net.since[0]) - predicted[k]
        e[n3 + k] = net.speed[c] - predicted[n3 + k]


@njit(**OPTIONS)
def renew(address: int, t: float, cj: float, y: FloatArray) -> bool:
    """Assemble and factor K at y; False where it is singular."""
    u = record_at(address)
    matrix, ldl = load(u.matrix, Matrix), load(u.ldl, Ldl)
    u.singular = assemble(t, y, cj, load(u.net, Net), matrix, ldl)
    if u.singular == -1:
        u.singular = factor(cj, matrix, ldl, load(u.dyads, Dyads))
    u.cj = cj
    u.setups += 1
    return u.singular == -1


@njit(**OPTIONS)
def evaluate(
    address: int,
    t: float,
    cj: float,
    predicted: FloatArray,
    slope: FloatArray,
    e: FloatArray,
    y: FloatArray,
    yp: FloatArray,
    F: FloatArray,
) -> int:
    """Write the iterate with the correction e to y and yp, and its residual to F; return where that is not finite."""
    u = record_at(address)
    for k in range(len(y)):
        y[k] = predicted[k] + e[k]
        yp[k] = slope[k] + cj * e[k]
    bad = residual(t, y, yp, load(u.net, Net), F)
    u.residuals += 1
    if bad >= 0:
        u.not_finite, u.not_finite_at = bad, t
    return bad


@njit(**OPTIONS)
def iterate(
    address: int,
    t: float,
    cj: float,
    predicted: FloatArray,
    slope: FloatArray,
    y: FloatArray,
    yp: FloatArray,
    F: FloatArray,
    e: FloatArray,
    w: FloatArray,
    limit: float,
) -> int:
    """Newton's iteration with a factor at each iterate, see `taut`, from the residual F on; 0 where it converges.

    e is the correction so far, and z, in the end, what it has gained, both (6n,); w the weights of their norm.
    """
    u = record_at(address)
    net, matrix, ldl, dyads = load(u.net, Net), load(u.matrix, Matrix), load(u.ldl, Ldl), load(u.dyads, Dyads)
    chunk, size = load(u.chunk, Chunk), len(y)
    z, gained = chunk.z, chunk.gained
    for k in range(size):
        gained[k] = 0.0
    for iteration in range(ITERATIONS):
        if iteration > 0 and evaluate(address, t, cj, predicted, slope, e, y, yp, F) >= 0:
            return _RESIDUAL_FAILED
        if not renew(address, t, cj, y):  # an iterate may be anywhere
            u.singular = -1
            return _NOT_CONVERGED
        solve(F, cj, cj, net, matrix, ldl, dyads, z)
        u.solves += 1
        total = 0.0
        for k in range(size):
            e[k] -= z[k]
            gained[k] += z[k]
            total += (z[k] * w[k]) ** 2
        if np.sqrt(total / size) <= CONVERGED * limit:
            for k in range(size):
                z[k] = gained[k]
            return 0
    return _NOT_CONVERGED


@njit(**OPTIONS)
def filter_errors(address: int, cj: float, e: FloatArray, w: FloatArray) -> None:
    """Let the error test see the velocities' part of the correction e without what is stiff in it, see `taut`."""
    u = record_at(address)
    net, matrix, ldl, dyads = load(u.net, Net), load(u.matrix, Matrix), load(u.ldl, Ldl), load(u.dyads, Dyads)
    chunk, n3 = load(u.chunk, Chunk), 3 * u.n
    r, z, kept = chunk.gained, chunk.filtered, chunk.weights
    for k in range(n3):
        r[k] = 0.0
        r[n3 + k] = u.cj * u.cj * net.mass[k // 3] * e[n3 + k]
    solve(r, u.cj, u.cj, net, matrix, ldl, dyads, z)
    for k in range(2 * n3):
        kept[k] = w[k]
    for k in range(n3):
        if e[n3 + k] != 0.0:
            w[n3 + k] *= abs(z[k] / e[n3 + k])
    u.filtered = 1


_V, _D, _I = types.voidptr, types.float64, types.int32


@cfunc(_I(_D, _V, _V, _V, _V), **OPTIONS)
def on_residual(t, y, yp, F, user):  # type: ignore[no-untyped-def]
    """IDAResFn, which IDA must be given but does not call: `on_newton` evaluates the residual itself."""
    return _RESIDUAL_FAILED


@cfunc(_I(_D, _D, _V, _V, _V, _V, _V, _V, _V, _V), **OPTIONS)
def on_jacobian(t, cj, y, yp, F, J, user, one, two, three):  # type: ignore[no-untyped-def]
    """IDALsJacFn: assembles and factors K; J itself is left alone."""
    address = address_of(user)
    return 0 if renew(address, t, cj, data_of(address_of(y), 6 * record_at(address).n)) else -1


@cfunc(_I(_V, _V), **OPTIONS)
def on_linear_setup(solver, J):  # type: ignore[no-untyped-def]
    """Setup of the linear solver: all has been done in `on_jacobian`."""
    return 0


@cfunc(_I(_V, _V), **OPTIONS)
def keep_setup(solver, f):  # type: ignore[no-untyped-def]
    """SUNNonlinSolSetLSetupFn."""
    record_at(ints(address_of(solver), 1)[0]).on_setup = address_of(f)
    return 0


@cfunc(_I(_V, _V, _V), **OPTIONS)
def keep_test(solver, f, data):  # type: ignore[no-untyped-def]
    """SUNNonlinSolSetConvTestFn."""
    record_at(ints(address_of(solver), 1)[0]).on_test = address_of(f)
    return 0


@cfunc(_I(_V, _V), **OPTIONS)
def keep_nothing(solver, value):  # type: ignore[no-untyped-def]
    """Setters whose value is known already."""
    return 0


@cfunc(_I(_V, _V), **OPTIONS)
def report_iteration(solver, out):  # type: ignore[no-untyped-def]
    """SUNNonlinSolGetCurIter; an int is half a word."""
    iteration = record_at(ints(address_of(solver), 1)[0]).iteration
    carray(out, 1, np.int32)[0] = iteration
    return 0


@cfunc(_I(_V, _V, _V, _V, _D, _I, _V), **OPTIONS)
def on_newton(solver, start, correction, weights, tolerance, wants_setup, memory):  # type: ignore[no-untyped-def]
    """SUNNonlinSolSolve: Newton's iteration for the correction e of the prediction, y = ŷ + e and ẏ = ẏ̂ + c_j e.

    SUNDIALS' own makes seven more passes over vectors in each iteration.
    """
    here = address_of(solver)
    address = ints(here, 1)[0]
    u = record_at(address)
    chunk = load(u.chunk, Chunk)
    at = chunk.system.ctypes.data
    data, reals = ints(at, 8), floats(at, 8)
    call(u.system_data, (u.memory, at, at + 8, at + 16, at + 24, at + 32, at + 40, at + 48, at + 56))
    t, cj, size = reals[0], reals[6], 6 * u.n
    predicted, slope = data_of(data[1], size), data_of(data[2], size)
    y, yp, F = data_of(data[3], size), data_of(data[4], size), data_of(data[5], size)
    e, z, w = data_of(address_of(correction), size), chunk.z, data_of(address_of(weights), size)
    net, matrix, ldl, dyads = load(u.net, Net), load(u.matrix, Matrix), load(u.ldl, Ldl), load(u.dyads, Dyads)
    if u.filtered != 0:  # the last attempt at this step failed in the error test
        u.filtered = 0
        for k in range(size):
            w[k] = chunk.weights[k]
    setup, fresh, iteration = wants_setup != 0, False, 0
    u.spoilt = 1 if u.spoilt != 0 and not setup and cj == u.cj_before else 0
    whole_newton = u.undamped > 1 and (u.stiffest > STIFF * cj * cj or u.spoilt != 0)
    u.spoilt = 1 if whole_newton else 0
    u.cj_before = cj
    code = 0
    e[:] = 0.0
    put_curved_axes(t, predicted, net, e)
    while True:
        if evaluate(address, t, cj, predicted, slope, e, y, yp, F) >= 0:
            return _RESIDUAL_FAILED
        if setup:
            code = call(u.on_setup, (np.int32(0), at + 56, u.memory))
            if code != 0:
                return code
            setup, fresh = False, True
        elif (
            iteration == 0
            and not whole_newton
            and is_out_of_line(y[: size // 2], cj, matrix)
            and not renew(address, t, cj, y)
        ):
            u.singular = -1
            u.newton_failed += 1
            return _NOT_CONVERGED
        if whole_newton:
            code = iterate(address, t, cj, predicted, slope, y, yp, F, e, w, tolerance)
            if code < 0:
                return code
        else:
            solve(F, u.cj, cj, net, matrix, ldl, dyads, z)
            u.solves += 1
            for k in range(size):
                e[k] -= z[k]
        u.iteration = iteration
        verdict = _NOT_CONVERGED
        if code == 0:
            given = (address_of(correction), u.correction, tolerance, address_of(weights), u.memory)
            verdict = call(u.on_test, (here, *given))
        if verdict == 0:
            if u.undamped > 1:
                filter_errors(address, cj, e, w)
            return 0
        iteration += 1
        if verdict == _GO_ON and iteration < _NEWTON_ITERATIONS:
            continue
        u.newton_failed += 1
        if fresh or code != 0:  # whose factors were all new
            return _NOT_CONVERGED
        setup, iteration = True, 0
        e[:] = 0.0
        put_curved_axes(t, predicted, net, e)


@njit(**OPTIONS)
def weigh_target(at: FloatArray, w: FloatArray, atol_position: float, net: Net) -> None:
    """Weights of a target's rows: in the mean over all nodes they count `TARGET` times as if it were alone.

    Its angle grows without end and does not count in its own tolerance.
    """
    n3 = 3 * len(net.mass)
    alone = TARGET * np.sqrt(0.5 * len(net.mass))
    for k in range(net.spin, net.spin + 3):
        w[k] = 1.0 / atol_position
    for k in range(net.spin - 3, net.spin + 3):
        w[k] *= alone
        w[n3 + k] *= alone


@cfunc(_I(_V, _V, _V), **OPTIONS)
def on_weights(y, weights, user):  # type: ignore[no-untyped-def]
    """IDAEwtFn: 1/(rtol |y| + atol), a tolerance for x and one for v; times as strict as `taut` asks for."""
    u = record_at(address_of(user))
    n3 = 3 * u.n
    at, w = data_of(address_of(y), 2 * n3), data_of(address_of(weights), 2 * n3)
    u.filtered = 0
    strict, rtol = (
        np.float32(u.strict),
        u.rtol,
    )  # seven digits, and single numbers are divided four times as fast
    for k in range(n3):
        w[k] = strict / np.float32(rtol * abs(at[k]) + u.atol_position)
    for k in range(n3, 2 * n3):
        w[k] = strict / np.float32(rtol * abs(at[k]) + u.atol_velocity)
    net = load(u.net, Net)
    if net.pose != 0:
        weigh_target(at, w, u.atol_position, net)
    return 0


@cfunc(_D(_V, _V), **OPTIONS)
def on_norm(x, w):  # type: ignore[no-untyped-def]
    """Weighted norm √(Σ (x w)²/N); SUNDIALS' own keeps the order of its sum, which costs a twentieth of a step more."""
    size = ints(ints(address_of(x), 1)[0], 1)[0] & 0xFFFFFFFF
    a, b = data_of(address_of(x), size), data_of(address_of(w), size)
    total = 0.0
    for k in range(size):
        p = a[k] * b[k]
        total += p * p
    return np.sqrt(total / size)
