"""The record of a system for `ida.calls`: what compiled code works on, with the arrays behind its addresses."""

from __future__ import annotations

from typing import Any

import numpy as np

from netdae._arrays import FloatArray
from netdae.assembly import scatter_blocks
from netdae.block_ldl import BlockLdl
from netdae.explicit.forces import KernelForces
from netdae.forces.loads import UniformLoad
from netdae.forces.rayleigh import MassDamping, StiffnessDamping
from netdae.ida.addressed import Addressed
from netdae.ida.books import RATES
from netdae.ida.further_record import further_record_of
from netdae.ida.layout import RECORD
from netdae.ida.lines import is_line, is_steady, line_of
from netdae.options import SolverOptions
from netdae.restraints import Drive
from netdae.system import System

MARGIN = 0.02  # of the shortest cable: those that lack more to be taut are passed over until the net has moved so far


class IdaRecord:
    """Numbers by `[name]`, and `arrays` by name, of which compiled code has the addresses.

    rows : steps that a chunk has at most
    address : of the record; whole : whether K is factored whole, as Rayleigh damping asks for
    """

    def __init__(self, system: System, drive: Drive, options: SolverOptions, rows: int) -> None:
        self._record = Addressed(RECORD)
        self.address, self.arrays = self._record.address, self._record.arrays
        self.set, self._place = self._record.set, self._record.place
        self._drive = drive
        self._entry = np.flatnonzero(drive.mask)
        self._loads = [
            force for force in system.forces if isinstance(force, UniformLoad) and is_line(force.signal)
        ]
        self._curved = not all(is_steady(each.motion) for each in drive.restraints)
        self.whole = any(isinstance(force, StiffnessDamping | MassDamping) for force in system.forces)
        self._place_net(system)
        self._place_matrix(system)
        self._place_chunk(rows, 6 * len(system.mass))
        rtol, atol_position, atol_velocity = options.tolerances
        self.set(
            rtol=rtol, atol_position=atol_position, atol_velocity=atol_velocity, not_finite=-1, singular=-1
        )

    def __getitem__(self, name: str) -> Any:
        return self._record[name]

    @property
    def error(self) -> BaseException | None:
        """What Python raised when it was asked for forces or motions."""
        return None if self.further is None else self.further.asked.error

    def take(self, name: str) -> int:
        """A count, which begins anew."""
        value = int(self[name])
        self.set(**{name: 0})
        return value

    def go_on(self, part: System, t: float) -> None:
        """Loads and restrained axes as they are from t on in a part of a phase, in which they are linear in time."""
        arrays, begin, end = self.arrays, part.inside(t), part.inside(np.inf)
        self.set(since=begin)
        if self.further is not None:
            self.further.go_on(part, begin, end)
        arrays["push_start"][:] = arrays["push_rate"][:] = 0.0
        for load in self._loads:
            for name, value in zip(
                ("push_start", "push_rate"), line_of(load.signal, begin, end), strict=True
            ):
                np.add.at(arrays[name].reshape(-1, 3), load.nodes[:, 0], load.weight[:, None] * value)
        if len(self._entry):
            self._hold(begin)

    def _hold(self, t: float) -> None:
        """Restrained axes as they are at t: on lines that pass there with their speed."""
        x_d, v_d, a_d = (each.ravel()[self._entry] for each in self._drive.at(t))
        arrays = self.arrays
        arrays["held_place"][:] = x_d - v_d * (t - self["since"])
        arrays["held_speed"][:], arrays["held_gain"][:] = v_d, a_d

    def _place_net(self, system: System) -> None:
        forces = KernelForces.of(system)
        cords, drags, entry = forces.cords, forces.drags, self._entry
        n3, m = 3 * len(system.mass), len(cords.L2)
        loaded = n3 if self._loads else 0
        self.further = further_record_of(system, forces, self._hold if self._curved else None)
        self.set(
            n=len(system.mass),
            cables=len(cords.L2),
            plain=cords.plain,
            drags=len(drags.ends),
            alphas=len(drags.alpha),
            pushes=loaded,
            further=0 if self.further is None else self.further.address,
            held=len(entry),
            reach=MARGIN * float(np.sqrt(cords.L2.min(initial=np.inf))) / (2 * np.sqrt(3)) if m else 0.0,
        )
        self._place(
            mass=system.mass,
            in_space=system.in_space,
            ends=cords.ends.astype(np.int64),
            **{
                name: getattr(cords, name)
                for name in ("L2", "half", "viscous", "EA", "eps", "engineering", "tau")
            },
            drag_ends=drags.ends.astype(np.int64),
            drag_viscosity=drags.viscosity,
            alpha=drags.alpha,
            push_start=np.zeros(loaded),
            push_rate=np.zeros(loaded),
            held_entry=entry.astype(np.int64),
            held_place=np.zeros(len(entry)),
            held_speed=np.zeros(len(entry)),
            held_gain=np.zeros(len(entry)),
            near=np.zeros(m, dtype=np.int64),
            near_number=np.zeros(1, dtype=np.int64),
            near_x=np.full(n3, np.nan),
            dashpots=np.zeros(m, dtype=np.int64),
            dashpot_q=np.zeros(m),
            forces=np.zeros(n3),
        )

    def _place_matrix(self, system: System) -> None:
        pattern, n = system.pattern, len(system.mass)
        m, blocks = len(system.cables.L), len(pattern.rows)
        ldl = BlockLdl(pattern)
        diagonal = np.zeros(n, dtype=np.int64)
        on = pattern.rows == pattern.columns
        diagonal[pattern.rows[on]] = np.flatnonzero(on)
        places = pattern.places_of(system.cables.nodes)
        constant = np.zeros((0, 3, 3))
        if self.whole:
            constant = _rayleigh_of(system)
            held = system.restrained
            constant[held[pattern.rows][:, :, None] | held[pattern.columns][:, None, :]] = 0.0
        free = (~self._drive.mask).ravel().astype(np.float64) if self._drive.mask.any() else np.zeros(0)
        mass = np.repeat(system.mass, 3)
        links = 0 if self.further is None else self.further.links
        off = max(len(ldl._row), m + links)  # where two cables join the same nodes they share one block
        self.set(blocks=blocks, constant=len(constant), free=len(free), off=off, L_size=len(ldl._L_row))
        self._place(
            K=np.zeros((blocks, 3, 3)),
            constant_blocks=constant,
            diagonal=diagonal,
            beside=np.maximum(places[:, 0, 1], places[:, 1, 0]),
            free_axes=free,
            inverse=np.divide(1.0, mass, out=np.zeros_like(mass), where=mass > 0),
            taut=np.zeros(m, dtype=np.int64),
            d=np.zeros((m, 3)),
            c=np.zeros(m),
            graph_counts=np.array([0, n, len(ldl._row)] if self.whole else [0, 0, 0]),
            order=ldl._order,
            place=np.full(n, -1),
            members=ldl._order,
            member_diagonal=ldl._diagonal,
            column_start=ldl._column_start.astype(np.int64),
            row=np.resize(ldl._row, off),
            source=np.resize(ldl._source, off),
            flipped=np.resize(ldl._flipped, off),
            present=np.zeros(off, dtype=np.bool_),
            parent=ldl._parent,
            L_start=ldl._L_start,
            L_row=ldl._L_row,
            L=ldl._L,
            pivots=ldl._pivots,
            flag=ldl._flag,
            L_count=ldl._count,
            path=ldl._path,
            stack=ldl._stack,
            Y=ldl._Y,
            work=ldl._y,
            right=np.zeros((n, 3)),
        )

    def _place_chunk(self, steps: int, size: int) -> None:
        rows = steps + 1
        self._place(
            times=np.zeros(rows),
            states=np.zeros((rows, size)),
            slopes=np.zeros((rows, size)),
            books=np.zeros((rows, RATES)),
            tensions=np.zeros(rows),
            rates=np.zeros(RATES),
            middle_rates=np.zeros(RATES),
            middle=np.zeros(size),
            clock=np.zeros(2),
            system=np.zeros(8),
            z=np.zeros(size),
        )


def _rayleigh_of(system: System) -> FloatArray:
    """D of Rayleigh damping as blocks (b, 3, 3) of the system's pattern."""
    rest = np.zeros_like(system.net.nodes)
    T, D = np.zeros((2, len(system.pattern.rows), 3, 3))
    for force in system.forces:
        if isinstance(force, StiffnessDamping | MassDamping):
            tangent = force.tangent(0.0, rest[force.nodes], rest[force.nodes])
            scatter_blocks(*tangent, system.pattern.places_of(force.nodes), T, D)
    return D
