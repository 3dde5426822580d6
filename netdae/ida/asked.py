"""What compiled code of IDA's driver cannot know, and asks Python for: a user's own forces, motions that are no lines.

One call for each residual, for each setup where a tangent is taken, and two for the books of each step.
"""

from __future__ import annotations

import ctypes as c
from collections.abc import Callable, Sequence

import numpy as np

from netdae._arrays import IntArray
from netdae.forces.protocol import Force
from netdae.ida.addressed import Addressed
from netdae.ida.asking import FORCES, HELD, POWERS, TANGENTS
from netdae.net_forces import NetForces
from netdae.system import System

_Call = c.CFUNCTYPE(c.c_int, c.c_double, c.c_int)


class Asked:
    """Forces that are asked for, at the state that compiled code leaves in the record's arrays.

    held : puts restrained axes at a time where they belong, None where that is not asked for
    error : the first that was raised; what was asked for is not a number then
    """

    def __init__(
        self,
        record: Addressed,
        system: System,
        forces: Sequence[Force],
        held: Callable[[float], None] | None,
    ) -> None:
        n = len(system.mass)
        self._record, self._part, self._held = record, system, held
        self._forces = NetForces.of(forces, n)
        self._outside = any(force.external for force in forces)
        self.error: BaseException | None = None
        self._blocks, places = blocks_of(system, forces)
        count = len(places)
        record.place(
            asked_y=np.zeros((2, n, 3)),
            asked_f=np.zeros((n, 3)),
            asked_rates=np.zeros(8),
            asked_block=places,
            asked_low=system.pattern.rows[places],
            asked_high=system.pattern.columns[places],
            asked_T=np.zeros((count, 3, 3)),
            asked_D=np.zeros((count, 3, 3)),
        )
        record.set(n=n, asked_blocks=count, asks_forces=bool(forces), asks_held=held is not None)
        if forces or held is not None:
            self._call = _Call(self._answer)  # kept as long as its address is
            record.set(ask=c.cast(self._call, c.c_void_p).value or 0)

    def go_on(self, part: System) -> None:
        """Go on in a part of a phase."""
        self._part = part

    def _answer(self, t: float, kind: int) -> int:
        arrays = self._record.arrays
        x, v = arrays["asked_y"]
        t = self._part.inside(t)
        try:
            if self.error is not None:
                raise self.error
            if kind == HELD and self._held is not None:
                self._held(t)
            elif kind == FORCES:
                arrays["asked_f"][:] = self._forces.force(t, x, v)
            elif kind == TANGENTS:
                T, D = self._forces.tangent_blocks(t, x, v)
                arrays["asked_T"][:], arrays["asked_D"][:] = T[self._blocks], D[self._blocks]
            elif kind == POWERS:
                rates = arrays["asked_rates"]
                rates[:2] = self._forces.account(t, x, v)[1:]
                if self._outside:
                    rates[2:] = self._forces.external_wrench(t, x, v, self._part.in_space).ravel()
        except BaseException as error:  # even an interrupt: C code cannot pass it on
            self.error = error
            self._record.set(asked_failed=1)
            for name in ("asked_f", "asked_rates", "asked_T"):
                arrays[name][:] = np.nan
        return 0


def blocks_of(system: System, forces: Sequence[Force]) -> tuple[IntArray, IntArray]:
    """Blocks that some forces of a system couple: their numbers in the forces' own pattern, and in the system's."""
    pattern = NetForces.of(forces, len(system.mass)).pattern
    coupled = np.zeros(len(system.mass), dtype=np.bool_)
    for force in forces:
        if force.newton != "nothing":
            coupled[force.nodes] = True
    own = np.flatnonzero(coupled[pattern.rows] & coupled[pattern.columns])
    n = len(system.mass)
    keys = system.pattern.columns * n + system.pattern.rows
    places = np.searchsorted(keys, pattern.columns[own] * n + pattern.rows[own])
    return own, places.astype(np.int64)
