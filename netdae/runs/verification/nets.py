"""Nets that several cases share."""

from __future__ import annotations

import numpy as np

from netdae.model.net import CableNet

G = 9.81  # m/s²


def line(count: int, *, length: float = 1.0) -> CableNet:
    """Straight string of `count` cables along x from the origin; node groups "first", "last", "inner"."""
    nodes = np.zeros((count + 1, 3))
    nodes[:, 0] = np.linspace(0.0, length, count + 1)
    cables = np.stack((np.arange(count), np.arange(1, count + 1)), axis=1)
    return CableNet(
        nodes, cables, {"first": np.array([0]), "last": np.array([count]), "inner": np.arange(1, count)}
    )
