"""The table of forces: one row per force, over which every method loops.

A row is the address of a force's `Elements` and those of its C functions, of one signature each, see `loops`. Laws have
compiled functions; a force written in Python has callbacks in their place, see `python`.

Arrays are flat over the net, node i at 3i. Signals are start + slope (t − since) within a part of a phase; those that
are not linear are evaluated in Python.
"""

from __future__ import annotations

import ctypes as c
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from netdae.core.addresses import call, call_for_real, floats
from netdae.core.arrays import BoolArray, FloatArray, Reals, Reals2, Wholes, wholes
from netdae.core.compilation import INLINED
from netdae.core.errors import RunError
from netdae.core.records import Record
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.forces.loops import SUMS, loop_of
from netdae.forces.python import PythonRow
from netdae.model.signals import line_of

COLUMNS = ("add", "rates", "tangents", "sift", "rests", "rate", "settle", "powers", "between", "crest")
"""C functions of a row."""


ENDED = 2
"""What `rests` returns for a rest length with which no flight can continue."""


class Rows(NamedTuple):
    """All forces for compiled code, (r,) but for the last; an address is 0 where a row does not have it."""

    elements: Wholes
    add: Wholes
    rates: Wholes
    tangents: Wholes
    sift: Wholes
    rests: Wholes
    rate: Wholes
    settle: Wholes
    powers: Wholes
    between: Wholes
    crest: Wholes
    ahead: Wholes  # (r,), whether an explicit step gives it the velocity at the end of the step
    signal: Wholes  # where its value goes
    start: Reals2  # (r, 3)
    slope: Reals2  # (r, 3), 1/s
    clock: Reals  # (2,), s: since when signals are linear, and the current time
    curved: Wholes  # (2,), C function that evaluates signals that are not linear, and whether Python failed


@njit(cache=True, **INLINED)
def set_time(rows: Rows, t: float) -> None:
    """Signals as they are at t."""
    since = rows.clock[0]
    rows.clock[1] = t
    for r in range(len(rows.signal)):
        if rows.signal[r] != 0:
            s = floats(rows.signal[r], 3)
            for a in range(3):
                s[a] = rows.start[r, a] + rows.slope[r, a] * (t - since)
    if rows.curved[0] != 0:
        call(rows.curved[0], (t,))


@njit(cache=True, **INLINED)
def add_forces(
    rows: Rows,
    x: FloatArray,
    v: FloatArray,
    ahead: FloatArray,
    f: FloatArray,
    middle: int,
    sums: FloatArray,
) -> None:
    """Add all forces to f (3n,), and to sums the monitored quantities and external powers and forces, see `loops`.

    ahead : velocities (3n,) for the rows that require it, else v
    middle : address of velocities (3n,) with which the powers of dissipative and external shares are summed, those of
        this evaluation and those of the one before; or 0
    """
    places = f.ctypes.data, middle, sums.ctypes.data
    for r in range(len(rows.elements)):
        velocities = ahead.ctypes.data if rows.ahead[r] != 0 else v.ctypes.data
        call(rows.add[r], (rows.elements[r], x.ctypes.data, velocities, *places))


@njit(cache=True, **INLINED)
def add_rates(rows: Rows, x: FloatArray, v: FloatArray, sums: FloatArray, wants_energy: int) -> None:
    """Add powers, external forces and monitored quantities to sums, see `loops`; stored energy if wants_energy is 1."""
    for r in range(len(rows.elements)):
        call(
            rows.rates[r],
            (rows.elements[r], x.ctypes.data, v.ctypes.data, sums.ctypes.data, wants_energy),
        )


@njit(cache=True, **INLINED)
def find_tangents(rows: Rows, x: FloatArray, v: FloatArray) -> None:
    """Leave the tangents of the elements that act in the rows' `Elements`."""
    for r in range(len(rows.elements)):
        if rows.tangents[r] != 0:
            call(rows.tangents[r], (rows.elements[r], x.ctypes.data, v.ctypes.data))


@njit(cache=True, **INLINED)
def sift(rows: Rows, x: FloatArray, margin: float, wide: float, active: int) -> None:
    """Leave out elements that cannot act until two nodes have moved by `margin` in m relative to each other.

    wide : m, a margin larger than this to begin with those that are near by it; else with those of the last such margin
    active : address of flags (n,), set for the nodes of elements that are left; or 0
    """
    for r in range(len(rows.elements)):
        if rows.sift[r] != 0:
            call(rows.sift[r], (rows.elements[r], x.ctypes.data, margin, wide, active))


@njit(cache=True, **INLINED)
def settle(rows: Rows, v: FloatArray, sums: FloatArray) -> None:
    """Add the powers of the shares of the last evaluation to sums, at velocities v, but for forces in Python."""
    for r in range(len(rows.elements)):
        if rows.settle[r] != 0:
            call(rows.settle[r], (rows.elements[r], v.ctypes.data, sums.ctypes.data))


@njit(cache=True, **INLINED)
def forget_shares(rows: Rows) -> None:
    """Let the next evaluation count no powers of the one before."""
    for r in range(len(rows.elements)):
        if rows.settle[r] != 0:
            call(rows.settle[r], (rows.elements[r], np.int64(0), np.int64(0)))


@njit(cache=True, **INLINED)
def rests(rows: Rows, x: FloatArray) -> int:
    """1 where a rest length has fallen below its `least`, 2 where no flight can continue with one, else 0."""
    worst = 0
    for r in range(len(rows.elements)):
        if rows.rests[r] != 0:
            worst = max(worst, call(rows.rests[r], (rows.elements[r], x.ctypes.data, 0)))
    return worst


@njit(cache=True, **INLINED)
def friction_rate(rows: Rows, x: FloatArray, v: FloatArray, share: FloatArray) -> float:
    """Sum of the rates of friction that bound an explicit step, 1/s; share (3n,) is 1/mass, zero where held."""
    total = 0.0
    for r in range(len(rows.elements)):
        if rows.rate[r] != 0:
            total += call_for_real(
                rows.rate[r], (rows.elements[r], x.ctypes.data, v.ctypes.data, share.ctypes.data)
            )
    return total


@njit(cache=True, **INLINED)
def add_powers(rows: Rows, x: FloatArray, v: FloatArray, sums: FloatArray) -> None:
    """Add the powers of forces written in Python, which report no shares, to sums."""
    for r in range(len(rows.elements)):
        if rows.powers[r] != 0:
            call(rows.powers[r], (rows.elements[r], x.ctypes.data, v.ctypes.data, sums.ctypes.data))


@njit(cache=True, **INLINED)
def add_between(rows: Rows, x: FloatArray, y: FloatArray, f: FloatArray, sums: FloatArray) -> None:
    """Add the mean forces between two places of the net to f (3n,), and external forces and torques to sums."""
    for r in range(len(rows.elements)):
        call(
            rows.between[r], (rows.elements[r], x.ctypes.data, y.ctypes.data, f.ctypes.data, sums.ctypes.data)
        )


@njit(cache=True, **INLINED)
def find_crests(
    rows: Rows, x: FloatArray, v: FloatArray, y: FloatArray, w: FloatArray, h: float, found: FloatArray
) -> None:
    """Write what was largest in a step of length h in s from x, v to y, w to found (5,).

    Square of the tension in N² and strain at its end; and of an element that shortens again, the largest square inside
    the step, the share of the step at which it is reached, and the largest strain.
    """
    found[0], found[1], found[2], found[3], found[4] = 0.0, -np.inf, 0.0, 1.0, -np.inf
    for r in range(len(rows.elements)):
        if rows.crest[r] != 0:
            places = x.ctypes.data, v.ctypes.data, y.ctypes.data, w.ctypes.data
            call(rows.crest[r], (rows.elements[r], *places, h, found.ctypes.data))


_Ask = c.CFUNCTYPE(c.c_int, c.c_double)


class Table:
    """Forces on a net as rows; compiled code finds the `Rows` at `address`.

    held : sets further values that depend on time from Python, called as held(t)
    watch_lengths : whether rest lengths on reels are compared with those of `watch`
    error : the first that was raised in a force or signal written in Python; its result is then not-a-number
    """

    def __init__(
        self,
        forces: Sequence[Force],
        in_space: BoolArray,
        *,
        held: Callable[[float], None] | None = None,
        watch_lengths: bool = False,
    ) -> None:
        self.forces = tuple(forces)
        self.error: BaseException | None = None
        self._held = held
        self._clip: Callable[[float], float] = float
        n = len(in_space)
        self.elements: list[Record] = []
        self._python: list[PythonRow | None] = []
        for force in self.forces:
            if isinstance(force, ElementForce):
                self.elements.append(force.elements(force.nodes, in_space, watched=watch_lengths))
                self._python.append(None)
            else:
                row = PythonRow(force, in_space, self._failed, self.now)
                self.elements.append(row.elements)
                self._python.append(row)
        self._signals = [getattr(force, "signal", None) for force in self.forces]
        self._record = Record(self._rows())
        self.rows: Rows = self._record.values
        self.address = self._record.address
        self._curved: list[int] = []
        self._ask = _Ask(self._answer)  # kept as long as its address is
        self._prepared: set[str] = set()
        self._sums = np.zeros(SUMS)
        self._size = n

    def _rows(self) -> Rows:
        r = len(self.forces)
        places = [
            0 if signal is None else int(record.values.signal.ctypes.data)
            for signal, record in zip(self._signals, self.elements, strict=True)
        ]
        return Rows(
            elements=np.array([record.address for record in self.elements], dtype=np.int64),
            **{column: wholes(r) for column in COLUMNS},
            ahead=np.array([_goes_ahead(force) for force in self.forces], dtype=np.int64),
            signal=np.array(places, dtype=np.int64),
            start=np.zeros((r, 3)),
            slope=np.zeros((r, 3)),
            clock=np.zeros(2),
            curved=wholes(2),
        )

    def prepare(self, *columns: str) -> Table:
        """Compile the functions of some columns, or load them from disk, and put them into the rows."""
        for column in columns:
            if column in self._prepared:
                continue
            self._prepared.add(column)
            places = getattr(self.rows, column)
            for r, (force, row) in enumerate(zip(self.forces, self._python, strict=True)):
                places[r] = row.address_of(column) if row is not None else _compiled(force, column)
        return self

    def go_on(self, begin: float, end: float, clip: Callable[[float], float]) -> None:
        """Set signals for the time from `begin` to `end`, a part of a phase over which tables are linear.

        clip : the nearest time inside the part, at which Python is called
        """
        self.rows.clock[:] = begin
        self._clip = clip
        self._curved = []
        for r, signal in enumerate(self._signals):
            if signal is None:
                continue
            line = line_of(signal, begin, end)
            if line is None:
                self._curved.append(r)
            else:
                self.rows.start[r], self.rows.slope[r] = line
        asks = bool(self._curved) or self._held is not None
        self.rows.curved[0] = (c.cast(self._ask, c.c_void_p).value or 0) if asks else 0

    def watch(self, lengths: FloatArray) -> None:
        """Let `rests` report rest lengths on reels that fall below these, m, in the order of `rest_lengths`."""
        at = 0
        for record in self.elements:
            least = record.values.least
            least[:] = lengths[at : at + len(least)]
            at += len(least)

    def now(self) -> float:
        """The time at which Python is called, inside the part of the phase."""
        return self._clip(float(self.rows.clock[1]))

    def check(self) -> None:
        """Re-raise the error of a force written in Python."""
        if self.error is not None:
            error, self.error, self.rows.curved[1] = self.error, None, 0
            raise error

    def _failed(self, error: BaseException) -> None:
        if self.error is None:
            self.error = error
        self.rows.curved[1] = 1

    def _answer(self, t: float) -> int:
        at = self._clip(t)
        try:
            for r in self._curved:
                self.elements[r].values.signal[:] = self._signals[r](at)  # type: ignore[misc]
            if self._held is not None:
                self._held(at)
        except BaseException as error:  # even an interrupt: C code cannot pass it on
            self._failed(error)
            for r in self._curved:
                self.elements[r].values.signal[:] = np.nan
        return 0

    # From NumPy; arrays (n, 3)

    def at(self, t: float) -> None:
        """Set signals to t, without parts of phases."""
        self.rows.clock[1] = t
        self._clip = float
        for record, signal in zip(self.elements, self._signals, strict=True):
            if signal is not None:
                record.values.signal[:] = signal(t)

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Sum of all forces on each node at t, (n, 3), N."""
        self.prepare("add").at(t)
        f = np.zeros((self._size, 3))
        self._sums[:] = 0.0
        V = _flat(v)
        add_forces(self.rows, _flat(x), V, V, f.reshape(-1), 0, self._sums)
        self.check()
        return f

    def sums(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Stored energy, powers and external wrench of all forces at t, (11,), see `loops`."""
        self.prepare("rates").at(t)
        sums = np.zeros(SUMS)
        add_rates(self.rows, _flat(x), _flat(v), sums, 1)
        self.check()
        return sums

    def check_rests(self, t: float, x: FloatArray) -> None:
        """Raise RunError where a rest length on a reel is used up."""
        if self.prepare("rests").rows.rests.any() and rests(self.rows, _flat(x)) == ENDED:
            self.rest_lengths(t, x)

    def rest_lengths(self, t: float, x: FloatArray) -> FloatArray:
        """Current rest lengths of all that reels wind in, concatenated, m; raises RunError where one is used up."""
        self.prepare("rests")
        flat, found = _flat(x), [np.zeros(0)]
        for r, (force, record) in enumerate(zip(self.forces, self.elements, strict=True)):
            if self.rows.rests[r] == 0:
                continue
            assert isinstance(force, ElementForce)
            lengths = np.empty(len(force.nodes))
            rests_of = loop_of(force.law, "rests").ctypes
            if rests_of(record.address, flat.ctypes.data, lengths.ctypes.data) == ENDED:
                raise RunError(_ended(force, t, lengths))
            found.append(lengths)
        return np.concatenate(found)


def _goes_ahead(force: Force) -> bool:
    """Whether a force is smooth in v: dashpots, which come and go, are taken at the mean velocity of a step."""
    return not isinstance(force, ElementForce) or (
        force.law.external and force.law.tangent is not None and not force.law.across
    )


def _compiled(force: Force, column: str) -> int:
    assert isinstance(force, ElementForce)
    function = loop_of(force.law, column)
    return 0 if function is None else int(function.address)


def _flat(values: FloatArray) -> FloatArray:
    return np.array(values, dtype=np.float64).reshape(-1)


def _ended(force: ElementForce, t: float, lengths: FloatArray) -> str:
    e = int(np.argmin(lengths))
    return (
        f"at t = {t:g} s {force.law.named(force.nodes[e])} has the rest length {lengths[e]:g} m, wound in by the "
        f"reel at node {force.nodes[e, -1]}: stop the reel before, at a length above zero"
    )
