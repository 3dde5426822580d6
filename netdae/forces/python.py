"""A force written in Python as a row of the table: callbacks in place of compiled functions, see `loops`.

One call costs about ten microseconds, each time that the method evaluates forces.
"""

from __future__ import annotations

import ctypes as c
from collections.abc import Callable

import numpy as np

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.core.errors import RunError
from netdae.forces.force import Force
from netdae.forces.loops import DISSIPATED, EXTERNAL, FORCE, STORED, SUMS, TORQUE, elements_of

_A = c.c_int64
_Add, _Rates, _Powers, _Tangents = (c.CFUNCTYPE(c.c_int, *[_A] * count) for count in (6, 5, 4, 3))


class PythonRow:
    """A force that follows the protocol of `force.Force`.

    failed : receives what the force raises; now : the time at which it is evaluated, s
    """

    def __init__(
        self,
        force: Force,
        in_space: BoolArray,
        failed: Callable[[BaseException], None],
        now: Callable[[], float],
    ) -> None:
        self._force, self._in_space, self._failed, self._now = force, in_space, failed, now
        self._nodes: IntArray = np.asarray(force.nodes, dtype=np.int64)
        m, k = self._nodes.shape
        tangents = m * 9 * k * k if force.newton == "symmetric" else 0
        self.elements = elements_of(0, self._nodes, in_space, tangents=tangents)
        self._calls = {
            "add": _Add(self._add),
            "rates": _Rates(self._rates),
            "powers": _Powers(self._powers),
        }
        if tangents:
            self._calls["tangents"] = _Tangents(self._tangents)

    def address_of(self, column: str) -> int:
        """Address of the callback, or 0."""
        call = self._calls.get(column)
        return 0 if call is None else c.cast(call, c.c_void_p).value or 0

    def _local(self, *addresses: int) -> list[FloatArray]:
        """Arrays over the net at addresses, gathered (m, k, 3)."""
        return [self._at(address)[self._nodes] for address in addresses]

    def _at(self, address: int) -> FloatArray:
        n = len(self._in_space)
        return _floats(address, 3 * n).reshape(n, 3)

    def _evaluated(self, x: FloatArray, v: FloatArray) -> FloatArray:
        f = np.asarray(self._force.force(self._now(), x, v))
        if f.shape != x.shape:
            raise RunError(
                f"{type(self._force).__name__}.force gave an array {f.shape}, expected {x.shape}: "
                "a force on each node of each element"
            )
        return f

    def _add(self, elements: int, x: int, v: int, f: int, middle: int, sums: int) -> int:
        total, out = self._at(f), _floats(sums, SUMS)
        try:
            xe, ve = self._local(x, v)
            local = self._evaluated(xe, ve)
            np.add.at(total, self._nodes, local)
            if self._force.external:
                self._add_wrench(xe, local, out)
        except BaseException as error:  # even an interrupt: C code cannot pass it on
            self._failed(error)
            total[:] = np.nan
        return 0

    def _rates(self, elements: int, x: int, v: int, sums: int, wants_energy: int) -> int:
        out = _floats(sums, SUMS)
        try:
            xe, ve = self._local(x, v)
            account = self._force.account(self._now(), xe, ve)
            out[STORED] += account.stored_energy
            out[DISSIPATED] += account.dissipated_power
            out[EXTERNAL] += account.external_power
            if self._force.external:
                self._add_wrench(xe, self._evaluated(xe, ve), out)
        except BaseException as error:
            self._failed(error)
            out[:] = np.nan
        return 0

    def _powers(self, elements: int, x: int, v: int, sums: int) -> int:
        out = _floats(sums, SUMS)
        try:
            account = self._force.account(self._now(), *self._local(x, v))
            out[DISSIPATED] += account.dissipated_power
            out[EXTERNAL] += account.external_power
        except BaseException as error:
            self._failed(error)
            out[:] = np.nan
        return 0

    def _tangents(self, elements: int, x: int, v: int) -> int:
        kept = self.elements.values
        try:
            found, K, C = self._force.tangent(self._now(), *self._local(x, v))
            a = len(found)
            kept.active[:a] = found
            kept.K[: K.size], kept.C[: C.size] = np.ravel(K), np.ravel(C)
            kept.counts[1] = a
        except BaseException as error:
            self._failed(error)
            kept.K[:] = np.nan
        return 0

    def _add_wrench(self, x: FloatArray, f: FloatArray, out: FloatArray) -> None:
        f = np.where(self._in_space[self._nodes][..., None], f, 0.0)
        out[FORCE : FORCE + 3] += f.sum(axis=(0, 1))
        out[TORQUE : TORQUE + 3] += np.cross(x, f).sum(axis=(0, 1))


def _floats(address: int, size: int) -> FloatArray:
    """The array at an address."""
    return np.ctypeslib.as_array((c.c_double * size).from_address(address))
