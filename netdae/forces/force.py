"""What a force is: local to its elements, independent of the rest of the net.

Symbols: m elements of k nodes each; x, v gathered positions and velocities (m, k, 3); f forces on the nodes.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import InputError
from netdae.forces.law import NewtonPart


class Account(NamedTuple):
    """Energy and powers of a force at one instant.

    The stored energy depends on positions alone, and is added to the elastic energy of the cables; what changes with
    time is external power.
    """

    stored_energy: float = 0.0  # J
    dissipated_power: float = 0.0  # W, taken out of the motion
    external_power: float = 0.0  # W, put into the motion from outside


class Tangent(NamedTuple):
    """Derivatives of a force at the elements where they are not both zero: slack cables are left out.

    elements : (a,), which of the m elements
    dx, dv : ∂f/∂x in N/m and ∂f/∂v in N s/m, each (a, k, 3, k, 3)
    """

    elements: IntArray
    dx: FloatArray
    dv: FloatArray

    @classmethod
    def none(cls, k: int) -> Tangent:
        """Tangent of a force that depends on neither."""
        empty = np.zeros((0, k, 3, k, 3))
        return cls(np.zeros(0, dtype=np.int64), empty, empty)

    @classmethod
    def of_all(cls, dx: FloatArray, dv: FloatArray) -> Tangent:
        """Tangent with all elements, dx and dv (m, k, 3, k, 3)."""
        return cls(np.arange(len(dx)), dx, dv)

    def spread(self, m: int) -> tuple[FloatArray, FloatArray]:
        """dx and dv of all m elements, (m, k, 3, k, 3)."""
        K, C = np.zeros((2, m, *self.dx.shape[1:]))
        K[self.elements], C[self.elements] = self.dx, self.dv
        return K, C


class LinkedTangent(NamedTuple):
    """Derivatives of a force on one element of many nodes: blocks between some of them, and r dyads over all.

    ∂f/∂x is the sum of the blocks dx and of left ⊗ by_x, ∂f/∂v that of dv and of left ⊗ by_v. A matrix of k nodes
    that is full only because of its dyads is factored without them, see `linalg.condensed`.

    dx, dv : (p, 2, 3, 2, 3), N/m and N s/m, on the force's `links` (p, 2), all or none of them
    left, by_x, by_v : (r, k, 3)
    """

    dx: FloatArray
    dv: FloatArray
    left: FloatArray
    by_x: FloatArray
    by_v: FloatArray

    def whole(self, nodes: IntArray, links: IntArray) -> Tangent:
        """The same with one full block over the nodes (1, k) of the element: for checks and products."""
        k = nodes.shape[1]
        if not len(self.left):
            return Tangent.none(k)
        K = np.einsum("ria,rjb->iajb", self.left, self.by_x)
        C = np.einsum("ria,rjb->iajb", self.left, self.by_v)
        place = {int(node): i for i, node in enumerate(nodes[0])}
        for ends, dx, dv in zip(links, self.dx, self.dv, strict=True):
            at = [place[int(node)] for node in ends]
            both = np.ix_(at, range(3), at, range(3))
            K[both] += dx
            C[both] += dv
        return Tangent(np.zeros(1, dtype=np.int64), K[None], C[None])


class Force(Protocol):
    """Force between, or on, the nodes of m elements.

    nodes : (m, k), the nodes of each element
    newton : the part of its tangent that the Newton matrix takes, which is symmetric:
        "symmetric", where the unsymmetric part of a tangent is left out, "nothing" (loads), or "links" for a
        `LinkedForce`, which is taken as a whole
    jumps : times at which the force jumps; the flight restarts there
    kinks : times at which only its rate jumps; a step ends there
    external : True if it acts from outside and so changes the net's momentum
    """

    @property
    def nodes(self) -> IntArray: ...  # noqa: D102
    @property
    def newton(self) -> NewtonPart: ...  # noqa: D102
    @property
    def jumps(self) -> tuple[float, ...]: ...  # noqa: D102
    @property
    def kinks(self) -> tuple[float, ...]: ...  # noqa: D102
    @property
    def external(self) -> bool: ...  # noqa: D102

    def force(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Force on each node, (m, k, 3), N."""
        ...

    def tangent(self, t: float, x: FloatArray, v: FloatArray) -> Tangent:
        """∂f/∂x and ∂f/∂v."""
        ...

    def account(self, t: float, x: FloatArray, v: FloatArray) -> Account:
        """Stored energy, dissipated and external power of all elements together."""
        ...


MEMBERS = ("nodes", "newton", "jumps", "kinks", "external", "force", "tangent", "account")


def check_force(force: object) -> None:
    """Raise InputError for an object that lacks a part of the protocol."""
    if missing := [name for name in MEMBERS if not hasattr(force, name)]:
        raise InputError(
            f"{type(force).__name__} is no force: it lacks {', '.join(missing)}; see netdae.forces.force.Force"
        )


class LinkedForce(Force, Protocol):
    """Force on one element, m = 1, of many nodes that are coupled along links and by dyads; its newton is "links".

    links : (p, 2), nodes of the net that blocks couple
    """

    @property
    def links(self) -> IntArray: ...  # noqa: D102

    def newton_part(self, t: float, x: FloatArray, v: FloatArray) -> LinkedTangent:
        """∂f/∂x and ∂f/∂v as blocks and dyads; both empty where the force is zero."""
        ...
