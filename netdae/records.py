"""NamedTuples of arrays and numbers behind one address, for functions of C that compiled code calls or is.

Each field of a NamedTuple class is annotated with one of the array types of `_arrays`, int, float or bool. A `Record`
keeps the arrays; `load` makes the NamedTuple again in compiled code. No field is listed but in its class.
"""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any, NamedTuple, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from numba import types
from numba.extending import overload

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.addresses import bools, floats, ints

Kind = TypeVar("Kind", bound=tuple)  # type: ignore[type-arg]


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
    """Fields of a NamedTuple class; raises TypeError for an annotation that compiled code cannot have."""
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
    """A NamedTuple whose arrays are kept in one piece each, behind `address`.

    values : the NamedTuple of what is kept; compiled code writes into its arrays, and they may be written here
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


def load(address: int, kind: type[Kind]) -> Kind:
    """The NamedTuple of a Record, in compiled code, of which `kind` is the class."""
    raise NotImplementedError("for compiled code")


_READERS = {np.float64: "floats", np.int64: "ints", np.bool_: "bools"}


@overload(load)
def _load(address, kind):  # type: ignore[no-untyped-def]
    if not isinstance(kind, types.NamedTupleClass):
        return None
    names = {"kind": kind.instance_class, "floats": floats, "ints": ints, "bools": bools}
    parts = []
    for field in fields_of(kind.instance_class):
        reader = _READERS[field.kind]
        if field.axes:
            shape = ", ".join(f"w[{field.at + 1 + k}]" for k in range(field.axes))
            parts.append(f"{reader}(w[{field.at}], ({shape},))")
        elif field.kind is np.float64:
            parts.append(f"r[{field.at}]")
        else:
            parts.append(f"w[{field.at}]" + (" != 0" if field.kind is np.bool_ else ""))
    size = max((field.at + 1 + field.axes for field in fields_of(kind.instance_class)), default=0)
    text = (
        "def make(address, kind):\n"
        f"    w, r = ints(address, {size}), floats(address, {size})\n"
        f"    return kind({', '.join(parts)})\n"
    )
    space: dict[str, Any] = dict(names)
    exec(text, space)  # written out by field, since compiled code cannot loop over a NamedTuple of many types
    return space["make"]
