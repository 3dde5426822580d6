"""NamedTuples of arrays and numbers at one address, for C functions that compiled code calls or consists of.

Each field of a NamedTuple class is annotated with one of the array types of `core.arrays`, int, float or bool. A
`Record` keeps the arrays; `load` rebuilds the NamedTuple in compiled code. Fields are listed in their class only.
"""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any, NamedTuple, get_args, get_origin, get_type_hints

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array
from numba.np.numpy_support import from_dtype

from netdae.core.arrays import BoolArray, FloatArray, IntArray


class Field(NamedTuple):
    """A field: its name, the kind of its numbers, its axes (0 for a number), and its first word."""

    name: str
    kind: type[np.float64] | type[np.int64] | type[np.bool_]
    axes: int
    at: int


_NUMBERS: dict[Any, Any] = {float: np.float64, int: np.int64, bool: np.bool_}
_ARRAYS: dict[Any, Any] = {FloatArray: np.float64, IntArray: np.int64, BoolArray: np.bool_}


@cache
def fields_of(kind: type) -> tuple[Field, ...]:
    """Fields of a NamedTuple class; raises TypeError for an annotation that compiled code cannot use."""
    fields: list[Field] = []
    at = 0
    for name, hint in get_type_hints(kind, include_extras=True).items():
        if hint in _NUMBERS:
            field = Field(name, _NUMBERS[hint], 0, at)
        elif get_origin(hint) is Annotated and get_args(hint)[0] in _ARRAYS:
            array, axes = get_args(hint)
            field = Field(name, _ARRAYS[array], axes, at)
        else:
            raise TypeError(
                f"{kind.__name__}.{name} is annotated {hint}: give Reals, Wholes or Flags for an array, "
                "or float, int or bool"
            )
        fields.append(field)
        at += 1 + field.axes
    return tuple(fields)


class Record:
    """A NamedTuple whose arrays are each kept contiguous, behind `address`.

    values : the NamedTuple that is kept; its arrays may be written by compiled code and from Python
    """

    def __init__(self, values: tuple[Any, ...]) -> None:
        kind = type(values)
        fields = fields_of(kind)
        kept = [_kept(value, field, kind) for value, field in zip(values, fields, strict=True)]
        self._words = np.zeros(sum(1 + field.axes for field in fields), dtype=np.int64)
        for value, field in zip(kept, fields, strict=True):
            if field.axes:
                self._words[field.at : field.at + 1 + field.axes] = value.ctypes.data, *value.shape
            elif field.kind is np.float64:
                self._words[field.at : field.at + 1].view(np.float64)[0] = value
            else:
                self._words[field.at] = value
        self.values: Any = kind(*kept)
        self.address = int(self._words.ctypes.data)


def _kept(value: Any, field: Field, kind: type) -> Any:
    if not field.axes:
        return field.kind(value).item()
    array = np.array(value, dtype=field.kind, order="C")
    if array.ndim != field.axes:
        raise TypeError(
            f"{kind.__name__}.{field.name} has the shape {array.shape}, expected {field.axes} axes"
        )
    return array


@intrinsic
def load(typingctx: Any, address: Any, kind: Any) -> Any:
    """The NamedTuple, of class `kind`, of a Record at an address, in compiled code."""
    if not isinstance(kind, types.NamedTupleClass):
        return None
    fields = fields_of(kind.instance_class)
    result = types.BaseTuple.from_types([_type_of(field) for field in fields], kind.instance_class)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        words = builder.inttoptr(args[0], context.get_value_type(types.int64).as_pointer())
        values = [_read(context, builder, words, field) for field in fields]
        return context.make_tuple(builder, result, values)

    return result(address, kind), codegen


def _type_of(field: Field) -> Any:
    number = from_dtype(np.dtype(field.kind))
    return types.Array(number, field.axes, "C") if field.axes else number


def _read(context: Any, builder: Any, words: Any, field: Field) -> Any:
    """A field as numba represents it; one function for all, since compiling an expression for each takes far longer."""

    def word(k: int) -> Any:
        return builder.load(builder.gep(words, [context.get_constant(types.intp, field.at + k)]))

    if not field.axes:
        if field.kind is np.float64:
            return builder.bitcast(word(0), context.get_value_type(types.float64))
        return word(0) if field.kind is np.int64 else builder.icmp_signed("!=", word(0), word(0).type(0))
    kind = _type_of(field)
    shape = [word(1 + k) for k in range(field.axes)]
    step = context.get_constant(types.intp, np.dtype(field.kind).itemsize)
    strides = [step]
    for length in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], length))
    array = context.make_array(kind)(context, builder)
    populate_array(
        array,
        data=builder.inttoptr(word(0), context.get_data_type(kind.dtype).as_pointer()),
        shape=cgutils.pack_array(builder, shape),
        strides=cgutils.pack_array(builder, strides),
        itemsize=step,
        meminfo=None,
    )
    return array._getvalue()
