"""Error messages of IDA flights that cannot go on, for both drivers."""

from __future__ import annotations

from typing import Any

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.system.system import System

STUCK = 1000  # steps without progress in time before a run is given up
STANDS_STILL = -100  # the code of that; SUNDIALS' own are above
WOUND_IN = -101  # the code of a cord whose rest length is used up

_REASONS = {
    -3: "the error test failed again and again, down to the smallest step",
    -4: "Newton's iteration failed again and again, down to the smallest step",
    -22: "its start asks for steps too small to take: look for a force or an acceleration without bound",
    WOUND_IN: "a cord is wound in whole",
    STANDS_STILL: "the clock stands still: the steps have become too small",
}


def reason_of(code: int, otherwise: str = "") -> str:
    """What a code of SUNDIALS, or STANDS_STILL, means."""
    return _REASONS.get(code, otherwise or f"SUNDIALS gave up with code {code}")


def not_finite(t: float, place: Any) -> str:
    """The message for a residual that is not finite at place = (position or velocity, node, axis)."""
    part, node, axis = (int(each) for each in place)
    return (
        f"at t = {t:.9g} s the residual of the {_part(part)} of node {node} along {'xyz'[axis]} is not finite: "
        "look for a load or motion that returns NaN, or for nodes that have left every bound"
    )


def failure_of(system: System, t: float, reason: str, weighted: FloatArray, rtol: float) -> str:
    """The message for a run that failed, with the worst node of the last Newton correction.

    weighted : (2, n, 3), its size over the tolerances
    """
    part, node, axis = np.unravel_index(int(np.argmax(weighted)), weighted.shape)
    text = f"the run failed at t = {t:.9g} s: {reason}; worst is the {_part(int(part))} of node {node}"
    text += f" along {'xyz'[axis]}"
    cables = np.flatnonzero((system.net.cables == node).any(axis=1))
    if len(cables):
        text += f", where cables {', '.join(map(str, cables))} end"
    return f"{text}. Try a smaller max_step, another rtol than {rtol:g}, or more damping"


def _part(part: int) -> str:
    return ("position", "velocity")[part]
