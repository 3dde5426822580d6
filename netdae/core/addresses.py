"""Memory and C functions at given addresses, for compiled code.

A callback of a C library gets all that it needs through one address; kernels see plain arrays again.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import carray, njit, types
from numba.core import cgutils
from numba.extending import intrinsic

# numba requires these names; the functions inside generate code


@intrinsic
def pointer_of(typingctx: Any, address: Any) -> Any:
    """An integer as void*."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.inttoptr(args[0], cgutils.voidptr_t)

    return types.voidptr(types.int64), codegen


@intrinsic
def address_of(typingctx: Any, pointer: Any) -> Any:
    """void* as an integer."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.ptrtoint(args[0], ir.IntType(64))

    return types.int64(types.voidptr), codegen


@intrinsic
def call(typingctx: Any, f: Any, arguments: Any) -> Any:
    """Call the C function at the address f, which returns an int, with a tuple of ints, words and doubles."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kinds = [context.get_value_type(kind) for kind in sig.args[1]]
        kind = ir.FunctionType(ir.IntType(32), kinds)
        given = [builder.extract_value(args[1], k) for k in range(len(kinds))]
        return builder.call(builder.inttoptr(args[0], kind.as_pointer()), given)

    return types.int32(types.int64, arguments), codegen


@intrinsic
def call_for_real(typingctx: Any, f: Any, arguments: Any) -> Any:
    """The same for a function that returns a double."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kinds = [context.get_value_type(kind) for kind in sig.args[1]]
        kind = ir.FunctionType(ir.DoubleType(), kinds)
        given = [builder.extract_value(args[1], k) for k in range(len(kinds))]
        return builder.call(builder.inttoptr(args[0], kind.as_pointer()), given)

    return types.float64(types.int64, arguments), codegen


@njit(cache=True, forceinline=True)
def floats(address: int, shape: Any) -> Any:
    """Array of floats at an address."""
    return carray(pointer_of(address), shape, np.float64)


@njit(cache=True, forceinline=True)
def ints(address: int, shape: Any) -> Any:
    """Array of integers at an address."""
    return carray(pointer_of(address), shape, np.int64)


@njit(cache=True, forceinline=True)
def flags(address: int, shape: Any) -> Any:
    """Array of flags at an address."""
    return carray(pointer_of(address), shape, np.bool_)


@njit(cache=True, forceinline=True)
def index(number: Any) -> Any:
    """A number below 2³², of which the compiler then knows that it is not negative: no index counts from the end."""
    return np.int64(np.uint32(number))
