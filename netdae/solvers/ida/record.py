"""The record of a system for `ida.calls`: what compiled code works on, and what Python changes in it."""

from __future__ import annotations

from typing import Any

import numpy as np

from netdae.core.arrays import FloatArray, IntArray, wholes
from netdae.core.records import Record
from netdae.forces.elements import ElementForce
from netdae.forces.force import Force
from netdae.forces.loops import SUMS
from netdae.forces.table import Table
from netdae.model.motions import is_steady
from netdae.model.restraints import Drive
from netdae.solvers.ida.dyads import Dyads
from netdae.solvers.ida.kernel import RATES, Net
from netdae.solvers.ida.layout import RECORD, Chunk
from netdae.solvers.ida.newton import ELEMENTS, LINKS, PAIRS, STEADY, Coupling, Matrix
from netdae.solvers.ida.taut import damped_of, stiffness_of
from netdae.solvers.linalg.block_ldl import BlockLdl, Ldl
from netdae.solvers.options import SolverOptions
from netdae.system.assembly import scatter_blocks
from netdae.system.net_forces import coupled_by
from netdae.system.system import System

MARGIN = 0.02  # of the shortest cable: cables that lack more to be taut are skipped until the net has moved this far


class IdaRecord:
    """Numbers by `[name]`, and the NamedTuples of arrays behind it.

    rows : largest number of steps in a chunk
    address : of the record; whole : whether K is factored whole, as Rayleigh damping requires
    """

    def __init__(self, system: System, drive: Drive, options: SolverOptions, rows: int) -> None:
        self.pose = None if system.body is None else Record(system.body.pose.values)
        self._pose_address = 0 if self.pose is None else self.pose.address
        system = system.seen_by(self.pose)
        self._record = np.zeros(1, RECORD)
        self.address = int(self._record.ctypes.data)
        self._drive = drive
        self._entry = np.flatnonzero(drive.mask)
        self.whole = any(_is_steady(force) for force in system.forces)
        curved = not all(is_steady(each.motion) for each in drive.restraints)
        self.table = Table(system.forces, system.in_space, held=self._hold if curved else None)
        self.table.prepare("add", "rates", "tangents", "sift", "rests")
        self.table.rows.tangents[[_is_steady(force) for force in system.forces]] = 0  # they are in `constant`
        self._net = Record(_net_of(system, self.table, self._entry, self._pose_address, curved_axes=curved))
        couplings, couples = _couplings_of(system, self.table)
        self._couplings = [Record(each) for each in couplings]
        addresses = np.array([each.address for each in self._couplings], dtype=np.int64)
        ldl = BlockLdl(system.pattern).ldl
        self._matrix = Record(_matrix_of(system, drive, addresses, ldl, whole=self.whole, couples=couples))
        self._ldl = Record(_with_room(ldl, couples))
        self._dyads = Record(_dyads_of(system, self.table))
        self._chunk = Record(_chunk_of(rows, 6 * len(system.mass)))
        self.chunk: Chunk = self._chunk.values
        rtol, atol_position, atol_velocity = options.tolerances
        self.spin = self._net.values.spin
        self.set(
            n=len(system.mass),
            net=self._net.address,
            matrix=self._matrix.address,
            ldl=self._ldl.address,
            dyads=self._dyads.address,
            chunk=self._chunk.address,
            rtol=rtol,
            atol_position=atol_position,
            atol_velocity=atol_velocity,
            not_finite=-1,
            singular=-1,
        )

    def __getitem__(self, name: str) -> Any:
        return self._record[name][0].item()

    def set(self, **numbers: float) -> None:
        """Set numbers by name."""
        for name, value in numbers.items():
            self._record[name] = value

    def take(self, name: str) -> int:
        """A count, which is reset."""
        value = int(self[name])
        self.set(**{name: 0})
        return value

    def go_on(self, part: System, t: float) -> None:
        """Set loads and restrained axes to those from t on in a part of a phase, in which they are linear in time."""
        begin, end = part.inside(t), part.inside(np.inf)
        self._net.values.since[0] = begin
        self.table.go_on(begin, end, part.inside)
        if len(self._entry):
            self._hold(begin)

    def enter(self, system: System, x: FloatArray) -> float:
        """Start a phase of a system at x (n, 3): how stiff its cables are now; return the largest κ of `taut`."""
        damped, stiffness = damped_of(system, x), stiffness_of(system, x)
        for record in self._couplings:
            record.values.stiffness[:] = stiffness[record.values.row]
        self._damped = Record(damped)
        largest = float(damped.kappa[0])
        self.set(damped=self._damped.address, stiffest=largest, undamped=0, low=0, strict=1.0)
        return largest

    def _hold(self, t: float) -> None:
        """Set restrained axes to those at t: on lines that pass there with their speed."""
        net: Net = self._net.values
        x_d, v_d, a_d = (each.ravel()[self._entry] for each in self._drive.at(t))
        net.place[:], net.speed[:], net.gain[:] = x_d - v_d * (t - net.since[0]), v_d, a_d


def _is_steady(force: Force) -> bool:
    return isinstance(force, ElementForce) and force.law.steady


def _net_of(system: System, table: Table, entry: IntArray, pose: int, *, curved_axes: bool) -> Net:
    shortest = float(system.net.rest_length.min(initial=np.inf))
    return Net(
        rows=table.address,
        mass=system.mass,
        in_space=system.in_space,
        entry=entry,
        place=np.zeros(len(entry)),
        speed=np.zeros(len(entry)),
        gain=np.zeros(len(entry)),
        since=np.zeros(1),
        curved_axes=curved_axes,
        pose=pose,
        spin=0 if system.body is None else 3 * system.body.spin,
        near_x=np.full(3 * len(system.mass), np.nan),
        reach=MARGIN * shortest / (2 * np.sqrt(3)),
        f=np.zeros(3 * len(system.mass)),
        sums=np.zeros(SUMS),
    )


def _couplings_of(system: System, table: Table) -> tuple[list[Coupling], int]:
    """Couplings of all forces with a part in Newton's matrix; and how many couples of nodes they may have at once."""
    found, couples = [], 0
    for row, (force, record) in enumerate(zip(system.forces, table.elements, strict=True)):
        nodes = coupled_by(force)
        if nodes is None:
            continue
        kind = ELEMENTS
        if _is_steady(force):
            kind = STEADY
        elif force.newton == "links":
            kind = LINKS
        elif isinstance(force, ElementForce) and force.law.pair:
            kind = PAIRS
        m, k = nodes.shape
        couples += m * k * (k - 1) // 2
        stiffness = np.zeros(len(force.nodes))
        places = system.pattern.places_of(nodes)
        found.append(Coupling(kind, record.address, row, 3 * nodes, places, stiffness))
    return found, couples


def _matrix_of(
    system: System, drive: Drive, couplings: IntArray, ldl: Ldl, *, whole: bool, couples: int
) -> Matrix:
    pattern, n = system.pattern, len(system.mass)
    blocks = len(pattern.rows)
    on = pattern.rows == pattern.columns
    diagonal = np.zeros(n, dtype=np.int64)
    diagonal[pattern.rows[on]] = np.flatnonzero(on)
    constant = np.zeros((0, 3, 3))
    if whole:
        constant, held = _constant_of(system), system.restrained
        constant[held[pattern.rows][:, :, None] | held[pattern.columns][:, None, :]] = 0.0
    mass = np.repeat(system.mass, 3)
    return Matrix(
        couplings=couplings,
        K=np.zeros((blocks, 3, 3)),
        constant=constant,
        diagonal=diagonal,
        free=(~drive.mask).ravel().astype(np.float64) if drive.mask.any() else np.zeros(0),
        inverse=np.divide(1.0, mass, out=np.zeros_like(mass), where=mass > 0),
        counts=np.array([0, n if whole else 0]),
        low=wholes(couples),
        high=wholes(couples),
        block=wholes(couples),
        order=ldl.order,
        place=np.full(n, -1),
        right=np.zeros(3 * n),
        x=np.zeros(3 * n),
    )


def _with_room(ldl: Ldl, couples: int) -> Ldl:
    """Where two cables join the same nodes they share one block, and stand in the graph twice."""
    blocks = max(len(ldl.row), couples)
    names = "row", "source", "flipped", "present"
    return ldl._replace(**{name: np.resize(getattr(ldl, name), blocks) for name in names})


def _constant_of(system: System) -> FloatArray:
    """D of the forces with a constant tangent as blocks (b, 3, 3) of the system's pattern."""
    rest = np.zeros_like(system.net.nodes)
    T, D = np.zeros((2, len(system.pattern.rows), 3, 3))
    for force in system.forces:
        if _is_steady(force):
            tangent = force.tangent(0.0, rest[force.nodes], rest[force.nodes])
            scatter_blocks(*tangent, system.pattern.places_of(force.nodes), T, D)
    return D


def _dyads_of(system: System, table: Table) -> Dyads:
    linked = [
        (force, record)
        for force, record in zip(system.forces, table.elements, strict=True)
        if force.newton == "links"
    ]
    r = sum(force.law.ranks(force.parameters) for force, _ in linked if isinstance(force, ElementForce))
    return Dyads(
        elements=np.array([record.address for _, record in linked], dtype=np.int64),
        owner=wholes(r),
        first=wholes(r),
        number=wholes(1),
        Z=np.zeros((3 * len(system.mass), r)),
        W=np.zeros((r, r)),
        swaps=wholes(r),
        amounts=np.zeros(r),
    )


def _chunk_of(steps: int, size: int) -> Chunk:
    rows = steps + 1
    return Chunk(
        times=np.zeros(rows),
        states=np.zeros((rows, size)),
        slopes=np.zeros((rows, size)),
        sums=np.zeros((rows, RATES)),
        tensions=np.zeros(rows),
        attitudes=np.zeros((rows, 4)),
        rates=np.zeros(RATES),
        middle_rates=np.zeros(RATES),
        middle=np.zeros(size),
        clock=np.zeros(2),
        system=wholes(8),
        z=np.zeros(size),
        gained=np.zeros(size),
        filtered=np.zeros(size),
        weights=np.zeros(size),
    )
