"""Signals and motions that are linear in time within a part of a phase, as the compiled driver of IDA takes them."""

from __future__ import annotations

import numpy as np

from netdae._arrays import FloatArray
from netdae.forces.solar import Light
from netdae.motions import Fixed, Motion, Steady
from netdae.signals import Constant, Pulse, Signal, Table


def is_line(signal: Signal) -> bool:
    """Whether a signal is linear from kink to kink."""
    if isinstance(signal, Light):
        return isinstance(signal.sun, Constant | Pulse)  # of length one, and so no line between rows
    table = isinstance(signal, Table) and signal.interpolation == "linear"
    return table or isinstance(signal, Constant | Pulse)


def is_steady(motion: Motion) -> bool:
    """Whether a motion keeps its velocity."""
    return isinstance(motion, Fixed | Steady)


def line_of(signal: Signal, begin: float, end: float) -> tuple[FloatArray, FloatArray]:
    """Value (3,) at `begin` and rate (3,) of a signal that is linear from there to `end`."""
    start = signal(begin)
    if not isinstance(signal, Table):
        return start, np.zeros(3)
    end = min(end, float(signal.times[-1]))
    return start, (signal(end) - start) / (end - begin) if end > begin else np.zeros(3)
