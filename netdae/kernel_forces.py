"""Forces of a system as arrays for the kernel of `verlet`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from netdae.errors import InputError
from netdae.forces.cables import Cables
from netdae.forces.loads import UniformLoad
from netdae.forces.rayleigh import MassDamping, StiffnessDamping
from netdae.signals import Signal
from netdae.system import System
from netdae.verlet import Cords, Drags, Pushes


class KernelForces(NamedTuple):
    """Forces of a system: cords, drags and pushes as the kernel takes them.

    cables : the force that the cords are made of
    signals : of the pushes, in the order of their numbers there
    """

    cables: Cables
    cords: Cords
    drags: Drags
    pushes: Pushes
    signals: list[Signal]

    @classmethod
    def of(cls, system: System) -> KernelForces:
        """The forces of a system; raises InputError for a force that the kernel does not know."""
        drags = Drags(np.zeros((0, 2), dtype=np.int64), np.zeros((0, 6)), np.zeros(0))
        node, weight, signal = [], [], []
        signals: list[Signal] = []
        for force in system.forces:
            if isinstance(force, Cables):
                cables = force
            elif isinstance(force, StiffnessDamping):
                upper = force.viscosity[:, *np.triu_indices(3)]
                drags = drags._replace(ends=3 * force.nodes, viscosity=np.ascontiguousarray(upper))
            elif isinstance(force, MassDamping):
                drags = drags._replace(alpha=np.repeat(force.viscosity, 3))
            elif isinstance(force, UniformLoad):
                node.append(3 * force.nodes[:, 0])
                weight.append(force.weight)
                signal.append(np.full(len(force.nodes), len(signals)))
                signals.append(force.signal)
            else:
                raise InputError(
                    f"the explicit method does not know the force {type(force).__name__}: fly it with method = 'ida'"
                )
        L = cables.L
        plain = not ((cables.eps > 0).any() or cables.engineering.any())
        cords = Cords(
            3 * cables.nodes,
            L**2,
            cables.EA / (2 * L**3),
            cables.tau * cables.EA / L**3,
            cables.EA,
            cables.eps,
            cables.engineering,
            cables.tau,
            plain,
        )
        empty = [np.zeros(0, dtype=np.int64)]
        pushes = Pushes(
            np.concatenate(node or empty),
            np.concatenate(weight or [np.zeros(0)]),
            np.concatenate(signal or empty),
        )
        return cls(cables, cords, drags, pushes, signals)
