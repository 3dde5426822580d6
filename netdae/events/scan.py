"""Quantities that come and go within milliseconds, for many steps at once.

An event on a tension or on a cable going taut needs every internal step. Most steps are far from it: a scan of the
positions of a whole chunk of steps, in compiled code, leaves just those to look at in which it happens.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from netdae.core.arrays import BoolArray, FloatArray, IntArray
from netdae.events.event import QuantityName
from netdae.forces.cables import law_of, strain_of
from netdae.system.system import System


@dataclass(frozen=True, eq=False)
class Scan:
    """Cables whose largest strain or tension is found over the steps of a chunk.

    nodes : (m, 2); L : (m,), m, where s = 0
    share, drum : (m,), L̄ = L + share s with s the x of the node `drum` of a reel
    weight : (m,), N or 1, of g(E11)/E times the stretch; none, (0,), for the strain itself
    """

    nodes: IntArray
    L: FloatArray
    share: FloatArray
    drum: IntArray
    eps: FloatArray
    engineering: BoolArray
    weight: FloatArray

    @classmethod
    def of(cls, system: System, figure: QuantityName, tether: IntArray) -> Scan | None:
        """Scan of a figure of `quantities.MEASURES`; None for others, and where cords slide through rings."""
        if any(reel.rings is not None for reel in system.reels):
            return None
        EA, every = system.cords.axial_stiffness, np.arange(system.net.cable_count)
        match figure:
            case "tether_taut":
                cables, weight = tether, np.zeros(0)
            case "tether_tension":
                cables, weight = tether, EA[tether]
            case "all_slack":
                cables, weight = every, np.zeros(0)
            case "tension_over_strength":
                cables, weight = every, EA / system.strength
            case _:
                return None
        share, drum = np.zeros(len(every)), np.zeros(len(every), dtype=np.int64)
        for reel in system.reels:
            share[reel.cables], drum[reel.cables] = reel.share, reel.node
        law = system.cables
        return cls(
            nodes=law.nodes[cables],
            L=law.L[cables],
            share=share[cables],
            drum=drum[cables],
            eps=law.eps[cables],
            engineering=law.engineering[cables],
            weight=weight,
        )

    def largest(self, x: FloatArray) -> FloatArray:
        """The figure after each step, (r,), from positions x (r, n, 3)."""
        return _largest(x, self.nodes, self.L, self.share, self.drum, self.eps, self.engineering, self.weight)


@njit(cache=True)
def _largest(
    x: FloatArray,
    nodes: IntArray,
    L: FloatArray,
    share: FloatArray,
    drum: IntArray,
    eps: FloatArray,
    engineering: BoolArray,
    weight: FloatArray,
) -> FloatArray:
    found = np.full(len(x), -np.inf)
    for r in range(len(x)):
        for e in range(len(nodes)):
            i, j = nodes[e, 0], nodes[e, 1]
            now = L[e] + share[e] * x[r, drum[e], 0]
            value = strain_of(x[r, j, 0] - x[r, i, 0], x[r, j, 1] - x[r, i, 1], x[r, j, 2] - x[r, i, 2], now)
            if len(weight) > 0:
                g = law_of(value, eps[e], engineering[e])[0]
                value = weight[e] * g * np.sqrt(1.0 + 2.0 * value) if g > 0.0 else 0.0
            found[r] = max(found[r], value)
    return found
