"""Kicks: forces that the kernel of `explicit.verlet` does not know, given to the net between its chunks of steps.

Forces of an orbit, of thin air or of light change little while cables ring, so that they need not be asked at each
step. With M, their forces f and a chunk of the length H,

    v⁺ = v + H/2 M⁻¹ f(t, x, v),     the chunk from (x, v⁺) to (x′, v*),     v′ = v* + H/2 M⁻¹ f(t′, x′, v′),

of the second order in H and symplectic where f comes of a potential: the impulse method, or r-RESPA (H. Grubmüller et
al., Molecular Simulation 6, 1991; M. Tuckerman, B. J. Berne, G. J. Martyna, J. Chem. Phys. 97, 1992). f at the end
takes v* + H/2 M⁻¹ f(t, x, v) in the place of v′, which differs from it by the order of H².

Work is the change of kinetic energy in the kicks, exactly, beside what the forces lose and store, and impulse that of
momentum. H is `SHARES` over the rate of
the forces: with Gershgorin's bounds K of M⁻¹ ∂f/∂x and C of M⁻¹ ∂f/∂v that is max(√K, C). Forces of which Newton's
matrix takes a part may come and go as cables do: with them each step has its own kicks, which takes the time of tens of
steps. No step is longer than `STIFF` over the rate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from netdae._arrays import FloatArray
from netdae.forces.protocol import Force
from netdae.net_forces import NetForces
from netdae.options import Accuracy
from netdae.stepper import Share
from netdae.system import System

SHARES: dict[Accuracy, float] = {"fast": 0.05, "standard": 0.02, "accurate": 0.002}
"""Length of a chunk times the rate of the forces: of what they do, about a twelfth of its square goes wrong."""

STIFF = 0.2
"""Length of a step times the rate of the forces: h² K + 2 h C of cables is 3.6 at most, of these forces 0.4, of the 4
up to which the step is stable."""

RATES_HOLD = 50
"""Chunks after which the rate is looked at again."""

JUMP = 0.2
"""Change of the largest acceleration, as a share of it, after which the rate is looked at at once."""


class Given(NamedTuple):
    """What a kick gave: gain of velocity (n, 3), work in J, and impulse and its moment (2, 3) in N s and N m s."""

    gain: FloatArray
    work: float
    impulse: FloatArray


class Slow(NamedTuple):
    """What the kicks at both ends of a chunk of the length H in s gave.

    a : the forces' accelerations (n, 3) at both ends; lost : J, of the work, as dissipation
    stored : J, that the forces have taken up
    """

    H: float
    kicks: tuple[Given, Given]
    a: tuple[FloatArray, FloatArray]
    lost: float
    stored: float

    def missing(self, s: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """What x, v and a of the kernel lack at `s` after the begin of the chunk.

        A steady force that gives g₀ + g₁ in the time H has given, with r = s/H and the first kick g₀ at once,

            v: − g₀ + r (g₀ + g₁),        x: − ½ s (1 − r) (g₀ + g₁).
        """
        r, g0 = s / self.H, self.kicks[0].gain
        both = g0 + self.kicks[1].gain
        return -0.5 * s * (1 - r) * both, r * both - g0, (1 - r) * self.a[0] + r * self.a[1]

    def share(self, s: float) -> Share:
        """What the books have gained by then."""
        r = s / self.H
        work = self.kicks[0].work + self.kicks[1].work + self.lost + self.stored
        p = r * (self.kicks[0].impulse + self.kicks[1].impulse)
        return Share(r * self.lost, r * work, p[0], 0.0, p[1])


class Kicks:
    """Some forces of a system, without those on restrained axes, where reactions answer them.

    longest : s, of a chunk; stiffest : s, of a step
    """

    def __init__(self, forces: Sequence[Force], system: System, accuracy: Accuracy) -> None:
        self._forces = NetForces.of(forces, system.net.node_count)
        self._chunk_share = SHARES[accuracy]
        self._sudden = any(force.newton != "nothing" for force in forces)
        self._mass = system.mass[:, None]
        self._moving = ~system.restrained & (self._mass > 0)
        self._wrench = system.wrench
        self._a = np.zeros((system.net.node_count, 3))
        self._power = self._stored = 0.0
        self._look_in = 0
        self._first = Given(self._a, 0.0, np.zeros((2, 3)))
        self.longest = self.stiffest = math.inf

    def __bool__(self) -> bool:
        return bool(self._forces.placed)

    def start(self, t: float, x: FloatArray, v: FloatArray) -> FloatArray:
        """Look at the forces where a phase begins, x and v (n, 3); their accelerations (n, 3)."""
        self._look_in = 0
        self._look(t, x, v)
        return self._a

    def open(self, x: FloatArray, v: FloatArray, H: float) -> None:
        """The kick at the begin of a chunk of the length H, added to v."""
        self._first = self._give(x, v, 0.5 * H)

    def close(self, t: float, x: FloatArray, v: FloatArray, planned: float, H: float) -> Slow:
        """The kick at the end of a chunk, added to v, whose length has become H."""
        a, power, stored, rest = self._a, self._power, self._stored, H - 0.5 * planned
        self._look(t, x, v + rest * a)
        last = self._give(x, v, rest)
        lost = 0.5 * H * (power + self._power)
        return Slow(H, (self._first, last), (a, self._a), lost, self._stored - stored)

    def memory(self) -> dict[str, FloatArray]:
        """What the next kicks depend on."""
        numbers = (self._power, self._stored, self._look_in, self.longest, self.stiffest)
        return {"slow": self._a.copy(), "slow_numbers": np.array(numbers)}

    def restore(self, memory: Mapping[str, FloatArray]) -> None:
        """Go on as those that told this memory."""
        self._a = memory["slow"].copy()
        self._power, self._stored, look_in, self.longest, self.stiffest = memory["slow_numbers"].tolist()
        self._look_in = int(look_in)

    def _look(self, t: float, x: FloatArray, v: FloatArray) -> None:
        f, former = self._forces.force(t, x, v), self._a
        self._a = np.divide(f, self._mass, out=np.zeros_like(f), where=self._moving)
        if np.abs(self._a - former).max() > JUMP * np.abs(former).max():
            self._look_in = 0
        self._stored, self._power, _ = self._forces.account(t, x, v)
        if self._look_in == 0:
            self._look_in = RATES_HOLD
            rate = self._rate(t, x, v)
            self.longest, self.stiffest = (
                share / rate if rate > 0 else math.inf for share in (self._chunk_share, STIFF)
            )
            if self._sudden:
                self.longest = 0.0
        self._look_in -= 1

    def _give(self, x: FloatArray, v: FloatArray, duration: float) -> Given:
        gain = duration * self._a
        p = self._mass * gain
        work = float(np.vdot(p, v)) + 0.5 * float(np.vdot(p, gain))
        v += gain
        return Given(gain, work, self._wrench(x, p))

    def _rate(self, t: float, x: FloatArray, v: FloatArray) -> float:
        """max(√K, C), 1/s."""
        sums = np.zeros((2, *x.shape))
        for placed in self._forces.placed:
            nodes = placed.nodes
            elements, *slopes = placed.force.tangent(t, x[nodes], v[nodes])
            for total, slope in zip(sums, slopes, strict=True):
                np.add.at(total, nodes[elements], np.abs(slope).sum(axis=(3, 4)))
        K, C = np.divide(sums, self._mass, out=np.zeros_like(sums), where=self._moving).max(axis=(1, 2))
        return max(math.sqrt(K), float(C))
