"""Phases of a flight: the pieces of time between its breaks, in which all forces are smooth.

Two breaks that differ by round-off only, for instance 0.3 and 0.1 + 0.2, are one: the flight is split once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

SAME = 16  # units in the last place within which two breaks are one


class Piece(NamedTuple):
    """Flown from `begin` to `end`; its forces are evaluated strictly between `after` and `before`."""

    begin: float
    end: float
    after: float
    before: float


def pieces_of(begin: float, end: float, breaks: Sequence[float]) -> list[Piece]:
    """Pieces of the time from `begin` to `end`, in order, split at the breaks inside."""
    near = SAME * math.ulp(max(abs(begin), abs(end)))
    clusters = [[begin]]
    for t in sorted({float(t) for t in breaks if begin - near <= t <= end + near}):
        if t - clusters[-1][-1] <= near:
            clusters[-1].append(t)
        else:
            clusters.append([t])
    if len(clusters) > 1 and end - clusters[-1][-1] <= near:
        clusters[-1].append(end)
    else:
        clusters.append([end])
    cuts = [begin, *(cluster[0] for cluster in clusters[1:-1]), end]
    return [
        Piece(cuts[k], cuts[k + 1], max(clusters[k]), min(clusters[k + 1])) for k in range(len(clusters) - 1)
    ]
