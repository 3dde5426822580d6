"""The net in motion: M ẍ + D ẋ + S(x) x = p(t), Eq. (10), gathered from local forces.

Symbols: n nodes, x, v, a (n, 3); M lumped masses (n,); f sum of all forces (n, 3); T = −∂f/∂x, D = −∂f/∂v.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from netdae import matrices
from netdae._arrays import BoolArray, FloatArray, IntArray, frozen_floats
from netdae.assembly import BlockPattern, assembled, gather, scatter_add, scatter_blocks
from netdae.damping import Damping, Rayleigh
from netdae.errors import InputError
from netdae.forces.cables import Cables, law_of
from netdae.forces.loads import Load
from netdae.forces.protocol import Force
from netdae.material import Cords, Material
from netdae.net import CableNet
from netdae.phases import pieces_of
from netdae.restraints import Drive, Restraint, mask_of


@dataclass(frozen=True, eq=False)
class Placed:
    """A force with its place in the net: nodes (m, k) and their blocks (m, k, k), None where it needs none."""

    force: Force
    nodes: IntArray
    blocks: IntArray | None


class System:
    """A net of cords with masses, damping, loads and restraints.

    net : topology and reference x̄
    cord : a Material, or cable group to Material, a later one overriding
    masses : node group to the mass in kg that each of its nodes carries beside its cables
    damping : Dashpot, Rayleigh or NoDamping; there is no default
    loads, restraints : what acts on the net from outside
    forces : further forces of one's own, see `forces.protocol`

    Raises InputError for what cannot fly: unknown groups, a free node without mass.
    """

    def __init__(
        self,
        net: CableNet,
        cord: Material | Mapping[str, Material],
        *,
        damping: Damping,
        masses: Mapping[str, float] | None = None,
        loads: Iterable[Load] = (),
        restraints: Iterable[Restraint] = (),
        forces: Iterable[Force] = (),
    ) -> None:
        self.net = net
        self.cords = Cords.of(net, cord)
        self.restraints = tuple(restraints)
        for restraint in self.restraints:
            mask_of((restraint,), net)
        self._hold(tuple(r for r in self.restraints if r.begin == -math.inf))
        self.mass = frozen_floats(_mass_of(net, self.cords, masses or {}))
        self._check_mass()
        if not hasattr(damping, "viscosity_times"):
            raise InputError(f"damping is {damping!r}: give a Dashpot, Rayleigh, or NoDamping() for none")
        self.damping = damping
        self.cables = Cables(
            net.cables,
            net.rest_length,
            self.cords.axial_stiffness,
            self.cords.toe_strain,
            self.cords.engineering,
            frozen_floats(damping.viscosity_times(net, self.cords)),
        )
        self.forces: tuple[Force, ...] = (
            self.cables,
            *damping.forces(net, self.cords, self.mass),
            *(load.on(net, self.cords, self.mass) for load in loads),
            *forces,
        )
        coupled = [force.nodes for force in self.forces if force.newton != "nothing"]
        self.pattern = BlockPattern.of(net.node_count, coupled)
        self._placed = tuple(
            Placed(f, f.nodes, self.pattern.places_of(f.nodes) if f.newton != "nothing" else None)
            for f in self.forces
        )
        self._phase = (-math.inf, math.inf)

    def _check_mass(self) -> None:
        always = mask_of(tuple(r for r in self.restraints if r.permanent), self.net)
        bare = np.flatnonzero((self.mass <= 0) & ~always.all(axis=1))
        if len(bare):
            raise InputError(
                f"node {bare[0]} is free but has no mass: no cable ends there and no bullet sits on it; "
                "give its group a mass, join it to the net, or restrain all its axes"
            )

    def _hold(self, active: tuple[Restraint, ...]) -> None:
        self.active = active
        self.restrained = mask_of(active, self.net)

    def holding(self, active: tuple[Restraint, ...]) -> System:
        """The same system, of whose restraints those in `active` hold."""
        other = System.__new__(System)
        other.__dict__.update(self.__dict__)
        other._hold(active)
        return other

    def without(self, cables: BoolArray) -> System:
        """The same system in which some cables, True in `cables` (m,), do not pull."""
        other = System.__new__(System)
        other.__dict__.update(self.__dict__)
        other.cables = replace(self.cables, EA=np.where(cables, 0.0, self.cables.EA))
        other.forces = (other.cables, *self.forces[1:])
        other._placed = (replace(self._placed[0], force=other.cables), *self._placed[1:])
        return other

    # Phases: between two jumps all forces are continuous in time, between two kinks smooth.

    def during(self, begin: float, end: float) -> System:
        """The same system, whose forces are asked at times strictly between `begin` and `end` only.

        A force that jumps at `begin` or `end` then shows the value it has inside the phase.
        """
        phase = System.__new__(System)
        phase.__dict__.update(self.__dict__)
        phase._phase = (math.nextafter(begin, math.inf), math.nextafter(end, -math.inf))
        return phase

    def inside(self, t: float) -> float:
        """`t`, or the nearest time inside the phase."""
        return min(max(t, self._phase[0]), self._phase[1])

    @property
    def jumps(self) -> list[float]:
        """Times at which a load jumps, a motion changes its velocity abruptly, or a restraint begins or ends."""
        of_all = [
            *(force.jumps for force in self.forces),
            *(times for r in self.restraints for times in (r.motion.jumps, r.changes)),
        ]
        return [t for times in of_all for t in times]

    @property
    def kinks(self) -> list[float]:
        """Times at which only the rate of a load or an acceleration jumps."""
        of_all = [*(force.kinks for force in self.forces), *(r.motion.kinks for r in self.restraints)]
        return [t for times in of_all for t in times]

    def phases(self, begin: float, end: float) -> Iterator[tuple[float, float, System]]:
        """Begin, end and system of each phase between jumps; the flight starts afresh at each."""
        for piece in pieces_of(begin, end, self.jumps):
            yield piece.begin, piece.end, self.during(piece.after, piece.before)

    def smooth_parts(self, begin: float, end: float) -> Iterator[tuple[float, System]]:
        """End and system of each part of a phase between kinks; a step ends at each."""
        low, high = self._phase
        for piece in pieces_of(begin, end, self.kinks):
            part = self.during(piece.after, piece.before)
            part._phase = max(part._phase[0], low), min(part._phase[1], high)
            yield piece.end, part

    def check_covers(self, begin: float, end: float) -> None:
        """Raise InputError where the table of a load or motion does not reach over the flight."""
        signals = [signal for f in self.forces if (signal := getattr(f, "signal", None)) is not None]
        for source in [*signals, *(r.motion for r in self.restraints)]:
            if not source.covers(begin, end):
                first, last = source.times[0], source.times[-1]
                raise InputError(
                    f"a table reaches from {first:g} to {last:g} s, but the flight lasts from {begin:g} to {end:g} s: "
                    "add rows, or end the flight earlier"
                )

    def drive_from(self, x: FloatArray) -> Drive:
        """The active restraints bound to the starting positions x (n, 3)."""
        return Drive.of(self.active, self.net, x)

    # Forces

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Sum of all forces on each node, (n, 3), N: p(t) − D v − S(x) x."""
        total = np.zeros_like(x)
        for placed, xe, ve in self._gathered(x, v):
            scatter_add(placed.force.force(self.inside(t), xe, ve), placed.nodes, total)
        return total

    def _gathered(self, x: FloatArray, v: FloatArray) -> Iterable[tuple[Placed, FloatArray, FloatArray]]:
        for placed in self._placed:
            local = np.empty((2, *placed.nodes.shape, 3))
            gather(x, placed.nodes, local[0])
            gather(v, placed.nodes, local[1])
            yield placed, local[0], local[1]

    def acceleration(
        self, t: float, x: FloatArray, v: FloatArray, a_d: FloatArray | None = None
    ) -> FloatArray:
        """f/M of free axes, (n, 3), m/s²; restrained axes take a_d (n, 3), zero by default."""
        f = self.force(t, x, v)
        a = np.divide(f, self.mass[:, None], out=np.zeros_like(f), where=self.mass[:, None] > 0)
        return np.where(self.restrained, 0.0 if a_d is None else a_d, a)

    def reactions(self, t: float, x: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Force that the restraints put on each node, (n, 3), N: M a − f, zero on free axes."""
        return np.where(self.restrained, self.mass[:, None] * a - self.force(t, x, v), 0.0)

    def tangent_blocks(self, t: float, x: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Symmetric parts of T = −∂f/∂x and D = −∂f/∂v as blocks (b, 3, 3) of `pattern`."""
        T = np.zeros((len(self.pattern.rows), 3, 3))
        D = np.zeros_like(T)
        for placed, xe, ve in self._gathered(x, v):
            if placed.blocks is not None:
                tangent = placed.force.tangent(self.inside(t), xe, ve)
                scatter_blocks(*tangent, placed.blocks, T, D)
        return T, D

    def tangent_product(
        self, t: float, x: FloatArray, v: FloatArray, dx: FloatArray, dv: FloatArray
    ) -> FloatArray:
        """(∂f/∂x) dx + (∂f/∂v) dv, (n, 3), with the whole, unsymmetric tangents of all forces."""
        total = np.zeros_like(x)
        for placed, xe, ve in self._gathered(x, v):
            elements, K, C = placed.force.tangent(self.inside(t), xe, ve)
            nodes = placed.nodes[elements]
            local = np.einsum("eiajb,ejb->eia", K, dx[nodes]) + np.einsum("eiajb,ejb->eia", C, dv[nodes])
            scatter_add(local, nodes, total)
        return total

    # Energies and momenta

    def account(self, t: float, x: FloatArray, v: FloatArray) -> tuple[float, float, float]:
        """Stored energy in J, dissipated power and external power of loads in W."""
        accounts = [placed.force.account(self.inside(t), xe, ve) for placed, xe, ve in self._gathered(x, v)]
        stored, dissipated, external = (sum(column) for column in zip(*accounts, strict=True))
        return stored, dissipated, external

    def external_wrench(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Force in N and torque about the origin in N m of all forces from outside but the restraints, (2, 3)."""
        total = np.zeros((2, 3))
        for placed, xe, ve in self._gathered(x, v):
            if placed.force.external:
                total += wrench_of(xe, placed.force.force(self.inside(t), xe, ve))
        return total

    def kinetic_energy(self, v: FloatArray) -> float:
        """½ v·M v, J."""
        return 0.5 * float(self.mass @ np.einsum("ni,ni->n", v, v))

    def elastic_energy(self, x: FloatArray) -> float:
        """Stored energy of all cables, J."""
        return self.cables.energy_and_peak(x)[0]

    def momentum(self, v: FloatArray) -> FloatArray:
        """Σ m v, (3,), N s."""
        return self.mass @ v

    def angular_momentum(self, x: FloatArray, v: FloatArray) -> FloatArray:
        """Σ x × m v about the origin, (3,), N m s."""
        return self.mass @ np.cross(x, v)

    # Cables; all elastic, without the dashpot's share

    @property
    def strength(self) -> FloatArray:
        """Breaking force of each cable, (m,), N; infinite where it is not known."""
        return self.cords.strength

    @property
    def toe_strain(self) -> FloatArray:
        """ε of each cable, (m,)."""
        return self.cords.toe_strain

    def strain(self, x: FloatArray) -> FloatArray:
        """E11 of each cable, (m,), Eq. (3)."""
        return self.cables.strain(x)

    def stress(self, x: FloatArray) -> FloatArray:
        """S11 of each cable, (m,), Pa, Eq. (4)."""
        modulus = self.cords.axial_stiffness / self.cords.area
        return modulus * self.cables.stress_ratio(self.strain(x))

    def tension(self, x: FloatArray) -> FloatArray:
        """Axial force N = S11 Ā l/L̄ of each cable, (m,), N."""
        E11 = self.strain(x)
        return (
            self.cords.axial_stiffness * self.cables.stress_ratio(E11) * np.sqrt(np.maximum(1 + 2 * E11, 0.0))
        )

    def peak_tension(self, x: FloatArray) -> float:
        """Largest tension of all cables, N."""
        return self.cables.energy_and_peak(x)[1]

    # The paper's matrices, see `matrices`

    def mass_matrix(self) -> sparse.csr_matrix:
        """M of Eq. (7) with the bullets, (3n, 3n)."""
        return sparse.diags_array(np.repeat(self.mass, 3)).tocsr()

    def secant_matrix(self, x: FloatArray) -> sparse.csr_matrix:
        """S(x) of Eqs. (5), (8), (3n, 3n)."""
        elements = matrices.secant(self.stress(x), self.cords.area, self.net.rest_length)
        return assembled(elements, self.net.cables, self.net.node_count)

    def tangent_matrix(self, x: FloatArray) -> sparse.csr_matrix:
        """T(x) of Eqs. (6), (8), (3n, 3n)."""
        xe = x[self.net.cables].reshape(-1, 6)
        E11 = matrices.green_lagrange_strain(xe, self.net.rest_length)
        laws = zip(E11, self.cords.toe_strain, self.cords.engineering, strict=True)
        slope = np.array([law_of(*law)[1] for law in laws]) * self.cords.axial_stiffness / self.cords.area
        elements = matrices.tangent(xe, self.stress(x), slope, self.cords.area, self.net.rest_length)
        return assembled(elements, self.net.cables, self.net.node_count)

    def damping_matrix(self) -> sparse.csr_matrix:
        """D = α M + β T(x̄) of Eq. (9), (3n, 3n); zero without Rayleigh damping."""
        if not isinstance(self.damping, Rayleigh):
            return sparse.csr_matrix((3 * self.net.node_count,) * 2)
        elements = matrices.reference_stiffness(
            self.net.spans, self.cords.axial_stiffness, self.net.rest_length
        )
        K0 = assembled(elements, self.net.cables, self.net.node_count)
        return self.damping.alpha * self.mass_matrix() + self.damping.beta * K0


def wrench_of(x: FloatArray, f: FloatArray) -> FloatArray:
    """Sum (3,) of forces f (..., 3) at places x (..., 3), and of their torques x × f about the origin, as (2, 3)."""
    xs, fs = x.reshape(-1, 3), f.reshape(-1, 3)
    moments = xs.T @ fs  # Σ xₐ f_b
    torque = (moments[1, 2] - moments[2, 1], moments[2, 0] - moments[0, 2], moments[0, 1] - moments[1, 0])
    return np.stack((fs.sum(axis=0), torque))


def _mass_of(net: CableNet, cords: Cords, masses: Mapping[str, float]) -> FloatArray:
    """Knots, ½ ρ̄L̄Ā from each cable by Eq. (7), and bullets, (n,), kg."""
    half = 0.5 * cords.linear_density * net.rest_length
    mass = np.zeros(net.node_count)
    np.add.at(mass, net.cables.ravel(), np.repeat(half, 2))
    for group, value in masses.items():
        if not (math.isfinite(value) and value >= 0):
            raise InputError(f"mass of group {group!r} is {value:g} kg: give a finite number, zero or more")
        mass[net.nodes_of(group)] += value
    return mass
