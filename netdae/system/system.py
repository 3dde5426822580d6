"""The net in motion: M ẍ + D ẋ + S(x) x = p(t), Eq. (10), gathered from local forces.

Symbols: n nodes, x, v, a (n, 3); M lumped masses (n,); f sum of all forces (n, 3); T = −∂f/∂x, D = −∂f/∂v.
Nodes of reels are not points in space: they have inertia but neither weight nor momentum.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from copy import copy
from dataclasses import replace

import numpy as np
from scipy import sparse

from netdae.core.arrays import BoolArray, FloatArray, frozen_floats
from netdae.core.records import Record
from netdae.forces.cables import Cables
from netdae.forces.force import Force, check_force
from netdae.forces.loads import Load
from netdae.model.material import Cords, Material
from netdae.model.net import CableNet
from netdae.model.phases import pieces_of
from netdae.model.restraints import Drive, Restraint, mask_of
from netdae.model.signals import check_covers
from netdae.model.state import State
from netdae.model.target import Obstacle, Target
from netdae.system import matrices
from netdae.system.assembly import BlockPattern
from netdae.system.contact_assembly import contacts_of
from netdae.system.damping import Damping, Rayleigh, check_damping
from netdae.system.masses import check_free_nodes, lumped_masses
from netdae.system.net_forces import NetForces, Powers, stores_energy, wrench_of
from netdae.system.prestressed import prestressed
from netdae.system.reels import (
    Reel,
    check_reels,
    forces_of,
    nodes_of_reels,
    reeled_cables,
    restraints_of,
    slid_lengths,
)
from netdae.system.target_nodes import TargetNodes, seen_by


class System:
    """A net of cords with masses, damping, loads and restraints.

    net : topology and reference x̄
    cord : a Material, or cable group to Material, where later ones override; a prestress determines rest lengths
    masses : node group to the mass in kg that each of its nodes carries besides its cables
    damping : Dashpot, Rayleigh or NoDamping; there is no default
    loads, restraints : what acts on the net from outside
    reels : drums at nodes of their own that pay out or wind in cables
    target : a rigid body that the net meets; it adds two nodes to `net`, see `target_nodes`
    obstacles : parts that are fixed in space
    forces : user-defined forces, see `forces.force`

    Raises InputError for what cannot be simulated: unknown groups, a free node without mass.
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
        reels: Iterable[Reel] = (),
        target: Target | None = None,
        obstacles: Iterable[Obstacle] = (),
        forces: Iterable[Force] = (),
    ) -> None:
        self.body = None if target is None else TargetNodes.of(target, net)
        self.reels = tuple(reels)
        net = prestressed(net, Cords.of(net, cord))
        own_mass = lumped_masses(net, Cords.of(net, cord), masses or {}, self.reels)
        if self.body is not None:
            net = self.body.grown(net)
        self.net = net
        self.cords = Cords.of(net, cord)
        check_reels(self.reels, net)
        of_target = () if self.body is None else self.body.restraints()
        self.restraints = (*restraints, *restraints_of(self.reels), *of_target)
        for restraint in self.restraints:
            mask_of((restraint,), net)
        self._hold(tuple(r for r in self.restraints if r.begin == -math.inf))
        self.mass = frozen_floats(own_mass if self.body is None else np.append(own_mass, self.body.mass))
        check_free_nodes(self.mass, net, self.restraints)
        self.in_space = ~nodes_of_reels(self.reels, net.node_count)
        of_net = self.in_space.copy()
        if self.body is not None:
            self.in_space[self.body.spin] = False
            of_net[[self.body.place, self.body.spin]] = False
        self.spatial_mass = frozen_floats(np.where(self.in_space, self.mass, 0.0))
        check_damping(damping, slides=any(reel.rings is not None for reel in self.reels))
        self.damping = damping
        tau = frozen_floats(damping.viscosity_times(net, self.cords))
        self.cables = Cables(
            net.cables,
            net.rest_length,
            np.where(reeled_cables(self.reels, net.cable_count), 0.0, self.cords.axial_stiffness),
            self.cords.toe_strain,
            self.cords.engineering,
            tau,
        )
        self.obstacles = tuple(obstacles)
        contacts, self._kept = contacts_of(net, self.cords, self.mass, of_net, self.body, self.obstacles)
        own = tuple(forces)
        for force in own:
            check_force(force)
        self.forces: tuple[Force, ...] = (
            self.cables.force,
            *forces_of(self.reels, net, self.cords, tau),
            *damping.forces(net, self.cords, frozen_floats(np.where(of_net, self.mass, 0.0))),
            *(() if self.body is None else self.body.forces()),
            *(load.on(net, self.cords, self.spatial_mass) for load in loads),
            *own,
            *contacts,
        )
        self._net_forces = NetForces.of(self.forces, self.in_space)
        self._phase = (-math.inf, math.inf)

    def _hold(self, active: tuple[Restraint, ...]) -> None:
        self.active = active
        self.restrained = mask_of(active, self.net)

    def holding(self, active: tuple[Restraint, ...]) -> System:
        """The same system with only the restraints in `active` holding."""
        other = copy(self)
        other._hold(active)
        return other

    def seen_by(self, pose: Record | None, *, way: int = 0) -> System:
        """The same system as compiled methods see it: contact has a memory of its own, and the pose of its target.

        way : for explicit steps, see `target_nodes.seen_by`
        """
        other = copy(self)
        other.forces = seen_by(self.forces, pose, way)
        return other

    def whole(self, start: State) -> State:
        """A start with that of the target, for one of the net alone."""
        return start if self.body is None else self.body.whole(start)

    def take(self, state: State) -> None:
        """Let forces and energies see the target's attitude at this state, whose places do not tell it."""
        if self.body is not None:
            self.body.take(state)

    def without(self, cables: BoolArray) -> System:
        """The same system in which some cables, True in `cables` (m,), do not pull."""
        other = copy(self)
        other.cables = replace(self.cables, EA=np.where(cables, 0.0, self.cables.EA))
        other.forces = (other.cables.force, *self.forces[1:])
        other._net_forces = NetForces.of(other.forces, self.in_space)
        return other

    @property
    def pattern(self) -> BlockPattern:
        """The blocks that forces couple."""
        return self._net_forces.pattern

    # Phases: between two jumps all forces are continuous in time, between two kinks smooth.

    def during(self, begin: float, end: float) -> System:
        """The same system, whose forces are evaluated at times strictly between `begin` and `end` only.

        A force that jumps at `begin` or `end` then shows the value it has inside the phase.
        """
        phase = copy(self)
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
        """Start, end and system of each phase between jumps; the flight restarts at each."""
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
        """Raise InputError where the table of a load or motion does not cover the flight."""
        signals = [signal for f in self.forces if (signal := getattr(f, "signal", None)) is not None]
        for source in [*signals, *(r.motion for r in self.restraints)]:
            check_covers(source, begin, end)

    def drive_from(self, x: FloatArray) -> Drive:
        """The active restraints bound to the starting positions x (n, 3)."""
        return Drive.of(self.active, self.net, x)

    # Forces

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Sum of all forces on each node, (n, 3), N: p(t) − D v − S(x) x."""
        return self._net_forces.force(self.inside(t), x, v)

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
        return self._net_forces.tangent_blocks(self.inside(t), x, v)

    def tangent_product(
        self, t: float, x: FloatArray, v: FloatArray, dx: FloatArray, dv: FloatArray
    ) -> FloatArray:
        """(∂f/∂x) dx + (∂f/∂v) dv, (n, 3), with the whole, unsymmetric tangents of all forces."""
        return self._net_forces.tangent_product(self.inside(t), x, v, dx, dv)

    # Energies and momenta

    def powers(self, t: float, x: FloatArray, v: FloatArray) -> Powers:
        """Energy, powers and external wrench of all forces; raises RunError where a reel has used up a cable."""
        self._net_forces.table.check_rests(t, x)
        return self._net_forces.powers(self.inside(t), x, v)

    def account(self, t: float, x: FloatArray, v: FloatArray) -> tuple[float, float, float]:
        """Stored energy in J, dissipated power and external power of loads in W."""
        return self.powers(t, x, v)[:3]

    def external_wrench(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Force in N and torque about the origin in N m of external forces but restraints, none on reels, (2, 3)."""
        return self.powers(t, x, v).wrench

    def rest_lengths_on_reels(self, x: FloatArray, *, t: float = 0.0) -> FloatArray:
        """Rest lengths (m,) of cables and whole cords that reels wind in, m; raises RunError where one is used up."""
        return self._net_forces.table.rest_lengths(t, x)

    def wrench(self, x: FloatArray, f: FloatArray) -> FloatArray:
        """Sum of forces, or impulses, f (n, 3) and of their moments about the origin, (2, 3), without the reels'."""
        return wrench_of(x, f if not self.reels else np.where(self.in_space[:, None], f, 0.0))

    def kinetic_energy(self, v: FloatArray) -> float:
        """½ v·M v, J, including that of drums."""
        return 0.5 * float(self.mass @ np.einsum("ni,ni->n", v, v))

    def elastic_energy(self, x: FloatArray, *, t: float = 0.0) -> float:
        """Energy that all forces store, J; t in s is for messages."""
        self._net_forces.table.check_rests(t, x)
        return self._net_forces.stored(self.inside(t), x)

    @property
    def stores_elsewhere(self) -> bool:
        """Whether forces besides the cables may store energy: reels, springs, and those written in Python."""
        return any(stores_energy(force) for force in self.forces[1:])

    def momentum(self, v: FloatArray) -> FloatArray:
        """Σ m v, (3,), N s."""
        return self.spatial_mass @ v

    def angular_momentum(self, x: FloatArray, v: FloatArray) -> FloatArray:
        """Σ x × m v about the origin, and that of the target's spin, (3,), N m s."""
        total = self.spatial_mass @ np.cross(x, v)
        return total if self.body is None else total + self.body.spin_momentum(x, v)

    # Cables; all elastic, without the dashpot's share

    @property
    def strength(self) -> FloatArray:
        """Breaking force of each cable, (m,), N; infinite where it is not known."""
        return self.cords.strength

    @property
    def toe_strain(self) -> FloatArray:
        """ε of each cable, (m,)."""
        return self.cords.toe_strain

    def rest_length(self, x: FloatArray) -> FloatArray:
        """L̄ of each cable, (m,), m: including what the reels have paid out at x (n, 3)."""
        return slid_lengths(self.cables.L, self.reels, self.net, x) if self.reels else self.cables.L

    def cables_at(self, x: FloatArray) -> Cables:
        """All cables with their rest lengths at x, also those on reels."""
        if not self.reels:
            return self.cables
        reeled = reeled_cables(self.reels, len(self.cables.L))
        EA = np.where(reeled, self.cords.axial_stiffness, self.cables.EA)
        return replace(self.cables, L=self.rest_length(x), EA=EA)

    def strain(self, x: FloatArray) -> FloatArray:
        """E11 of each cable, (m,), Eq. (3)."""
        return self.cables_at(x).strain(x)

    def stress(self, x: FloatArray) -> FloatArray:
        """S11 of each cable, (m,), Pa, Eq. (4)."""
        modulus = self.cords.axial_stiffness / self.cords.area
        return modulus * self.cables.stress_ratio(self.strain(x))

    def tension(self, x: FloatArray) -> FloatArray:
        """Axial force N = S11 Ā l/L̄ of each cable, (m,), N."""
        E11 = self.strain(x)
        stretch = np.sqrt(np.maximum(1 + 2 * E11, 0.0))
        return self.cords.axial_stiffness * self.cables.stress_ratio(E11) * stretch

    def peak_tension(self, x: FloatArray) -> float:
        """Largest tension of all cables, N."""
        return self.cables_at(x).energy_and_peak(x)[1]

    def mass_matrix(self) -> sparse.csr_matrix:
        """M of Eq. (7) with the bullets, (3n, 3n); this and the next are the paper's matrices, see `matrices`."""
        return sparse.diags_array(np.repeat(self.mass, 3)).tocsr()

    def secant_matrix(self, x: FloatArray) -> sparse.csr_matrix:
        """S(x) of Eqs. (5), (8), (3n, 3n)."""
        return matrices.secant_of(self.net, self.cords, self.rest_length(x), x)

    def tangent_matrix(self, x: FloatArray) -> sparse.csr_matrix:
        """T(x) of Eqs. (6), (8), (3n, 3n)."""
        return matrices.tangent_of(self.net, self.cords, self.rest_length(x), x)

    def damping_matrix(self) -> sparse.csr_matrix:
        """D = α M + β T(x̄) of Eq. (9), (3n, 3n); zero without Rayleigh damping."""
        if not isinstance(self.damping, Rayleigh):
            return sparse.csr_matrix((3 * self.net.node_count,) * 2)
        K0 = matrices.reference_stiffness_of(self.net, self.cords)
        return self.damping.alpha * self.mass_matrix() + self.damping.beta * K0
