"""SUNDIALS' C library, as scikit-sundae ships it, by ctypes: found, typed and checked.

scikit-sundae calls Python at each residual, setup and solve, with fresh array views: nine tenths of the time of a small
net's flight. The underlying library takes any C function, so compiled callbacks can be put in: see `ida.native`. The
library's memory layout is found by comparison with exported symbols; where it does not agree, this way is given up.

An object of SUNDIALS is a row of words {content, [more], table of operations, context}; the content of a serial vector
is {length, ownership, data}, of which length and ownership share a word where indices have 32 bits.
"""

from __future__ import annotations

import ctypes as c
import importlib.machinery
import importlib.util
import os
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from netdae.core.arrays import FloatArray

# its messages are dropped: errors are reported by the codes that its functions return
os.environ.setdefault("SUNLOGGER_WARNING_FILENAME", os.devnull)

VERSION = 7  # of SUNDIALS, whose signatures stand below

_P, _D, _I, _L = c.c_void_p, c.c_double, c.c_int, c.c_int64
_SIGNATURES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "SUNDIALSGetVersionNumber": (_I, (_P, _P, _P, _P, _I)),
    "SUNContext_Create": (_I, (_I, _P)),
    "SUNContext_ClearErrHandlers": (_I, (_P,)),
    "SUNContext_Free": (_I, (_P,)),
    "N_VMake_Serial": (_P, (_L, _P, _P)),
    "N_VEnableFusedOps_Serial": (_I, (_P, _I)),
    "N_VGetArrayPointer": (_P, (_P,)),
    "N_VWrmsNorm": (_D, (_P, _P)),
    "N_VDestroy": (None, (_P,)),
    "SUNDenseMatrix": (_P, (_L, _L, _P)),
    "SUNMatDestroy": (None, (_P,)),
    "SUNLinSol_Dense": (_P, (_P, _P, _P)),
    "SUNLinSolNewEmpty": (_P, (_P,)),
    "SUNLinSolFree": (_I, (_P,)),
    "SUNLinSolFreeEmpty": (None, (_P,)),
    "SUNNonlinSolNewEmpty": (_P, (_P,)),
    "SUNNonlinSolFreeEmpty": (None, (_P,)),
    "SUNNonlinSol_Newton": (_P, (_P, _P)),
    "SUNNonlinSolFree": (_I, (_P,)),
    "IDACreate": (_P, (_P,)),
    "IDAFree": (None, (_P,)),
    "IDAInit": (_I, (_P, _P, _D, _P, _P)),
    "IDAReInit": (_I, (_P, _D, _P, _P)),
    "IDAWFtolerances": (_I, (_P, _P)),
    "IDASetUserData": (_I, (_P, _P)),
    "IDASetLinearSolver": (_I, (_P, _P, _P)),
    "IDASetJacFn": (_I, (_P, _P)),
    "IDASetNonlinearSolver": (_I, (_P, _P)),
    "IDASetStopTime": (_I, (_P, _D)),
    "IDASetMaxOrd": (_I, (_P, _I)),
    "IDASetMaxStep": (_I, (_P, _D)),
    "IDASetNonlinConvCoef": (_I, (_P, _D)),
    "IDASetDeltaCjLSetup": (_I, (_P, _D)),
    "IDASetEtaFixedStepBounds": (_I, (_P, _D, _D)),
    "IDAGetDky": (_I, (_P, _D, _I, _P)),
    "IDAGetNumErrTestFails": (_I, (_P, _P)),
    "IDAGetCurrentOrder": (_I, (_P, _P)),
    # called from compiled code, by address
    "IDASolve": (_I, ()),
    "IDAGetNonlinearSystemData": (_I, ()),
}


_LINEAR = tuple(f"SUNLinSol{part}_Dense" for part in ("GetType", "Setup", "Solve"))
_NEWTON = tuple(
    f"SUNNonlinSol{part}_Newton"
    for part in (
        *(
            "GetType",
            "Solve",
            "SetSysFn",
            "SetLSetupFn",
            "SetLSolveFn",
            "SetConvTestFn",
            "SetMaxIters",
            "GetCurIter",
        ),
    )
)
_OPERATIONS = (("N_VWrmsNorm_Serial",), _LINEAR, _NEWTON)
_LONGEST_TABLE = dict(zip(_OPERATIONS, (50, 16, 18), strict=True))  # words in such a table


class Unavailable(ImportError):  # noqa: N818  # it says what the library is
    """The library is missing, or does not match these signatures."""


class Sundials:
    """The library: its functions by name, and where its objects keep their operations; raises Unavailable."""

    def __init__(self) -> None:
        self._library = _loaded()
        self._functions: dict[str, Any] = {}
        for name, (result, arguments) in _SIGNATURES.items():
            try:
                function = getattr(self._library, name)
            except AttributeError as error:
                raise Unavailable(f"SUNDIALS has no {name}") from error
            function.restype, function.argtypes = result, arguments
            self._functions[name] = function
        major = c.c_int()
        label = c.create_string_buffer(64)
        others = c.byref(c.c_int()), c.byref(c.c_int())
        self.call("SUNDIALSGetVersionNumber", c.byref(major), *others, label, 64)
        if major.value != VERSION:
            raise Unavailable(f"SUNDIALS is of version {major.value}, expected {VERSION}")
        self._look_into_objects()

    def call(self, name: str, *arguments: Any) -> Any:
        """The result of a function; raises Unavailable for an error code."""
        result = self._functions[name](*arguments)
        if _SIGNATURES[name][0] is _I and result < 0:
            raise Unavailable(f"SUNDIALS: {name} gave {result}")
        return result

    def address_of(self, name: str) -> int:
        """Address of a function."""
        return c.cast(getattr(self._library, name), _P).value or 0

    def context(self) -> int:
        """A context that prints no errors."""
        context = _P()
        self.call("SUNContext_Create", 0, c.byref(context))
        self.call("SUNContext_ClearErrHandlers", context)
        return context.value or 0

    def vector(self, values: FloatArray, context: int) -> int:
        """A serial vector on the memory of `values`."""
        vector = self.call("N_VMake_Serial", values.size, values.ctypes.data, context)
        self.call("N_VEnableFusedOps_Serial", vector, 1)
        return int(vector)

    def _look_into_objects(self) -> None:
        context, two = self.context(), np.array([3.0, 4.0])
        vector, matrix = self.vector(two, context), self.call("SUNDenseMatrix", 2, 2, context)
        linear = self.call("SUNLinSol_Dense", vector, matrix, context)
        newton = self.call("SUNNonlinSol_Newton", vector, context)
        if not word(word(vector), 1) == two.ctypes.data == self.call("N_VGetArrayPointer", vector):
            raise Unavailable("the data of a vector of SUNDIALS is not where it was expected")
        self._places: dict[str, tuple[int, int]] = {}
        for thing, names in zip((vector, linear, newton), _OPERATIONS, strict=True):
            self._look_for(thing, names)
        self.call("SUNNonlinSolFree", newton)
        self.call("SUNLinSolFree", linear)
        self.call("SUNMatDestroy", matrix)
        self.call("N_VDestroy", vector)
        self.call("SUNContext_Free", c.byref(_P(context)))

    def _look_for(self, thing: int, names: tuple[str, ...]) -> None:
        """Note which word of an object points to its table of operations, and their places in it."""
        wanted = [self.address_of(name) for name in names]
        for at in (1, 2):
            table = word(thing, at)
            entries = [word(table, k) for k in range(_LONGEST_TABLE[names])] if table else []
            if all(entries.count(each) == 1 for each in wanted):
                self._places |= {
                    name: (at, entries.index(each)) for name, each in zip(names, wanted, strict=True)
                }
                return
        raise Unavailable(f"no table of SUNDIALS holds {', '.join(names)}")

    def put_operation(self, thing: int, name: str, function: int | None = None) -> None:
        """Put a function into an object's table under this name; by default the library's own function of that name."""
        at, slot = self._places[name]
        put(word(thing, at), slot, self.address_of(name) if function is None else function)


def word(address: int, index: int = 0) -> int:
    """A word of memory."""
    return c.c_size_t.from_address(address + 8 * index).value


def put(address: int, index: int, value: int) -> None:
    """Write a word of memory."""
    c.c_size_t.from_address(address + 8 * index).value = value


@cache
def sundials() -> Sundials:
    """The library, loaded once; raises Unavailable."""
    return Sundials()


def library_path() -> Path:
    """scikit-sundae's extension, through which all libraries linked to it are reached; raises Unavailable."""
    found = importlib.util.find_spec("sksundae")
    folders = [] if found is None else list(found.submodule_search_locations or [])
    for folder in folders:
        for suffix in importlib.machinery.EXTENSION_SUFFIXES:
            path = Path(folder) / f"_cy_ida{suffix}"
            if path.exists():
                return path
    raise Unavailable("scikit-sundae's extension for IDA is not there")


def _loaded() -> c.CDLL:
    path = library_path()
    try:
        return c.CDLL(str(path))
    except OSError as error:
        raise Unavailable(f"{path.name} cannot be loaded: {error}") from error
