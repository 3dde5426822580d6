"""The accordion: the net folded to and fro in one or two directions of its plane.

Symbols: X, Y coordinates along the two directions in the open net, s the one that is being folded; n panels,
w their width, h the gap between them, u, c heights in a band of thickness H; all lengths in m.

**One fold after another.** The net is folded along x into a narrow strip of n₁ layers, and this strip, now a
band of thickness H, along y. A band turns round a fold as layers lie in a folded blanket: inner layers turn close
to the fold, outer ones go round them. A layer that lies u away from the inner face runs u past the fold, climbs
h + 2u, and comes back. With forward folds u = H − c and backward ones u = c, where c is the layer's height, the
middles of two neighbouring panels are w + h + 4u apart along the layer: P ± 2(H − 2c) with the period

    P = w + h + 2H,      middles  s_j = w/2 + jP − (−1)^j (H − 2c).

So forward and backward folds even out, and no layer creeps away from the others. A layer of given c is mapped
without change of length, and no two points of the band coincide: panel j lies between the heights j(H + h)
and j(H + h) + H, and the turns are nested in each other. With H = 0 this is the fold of a single sheet.

Each panel also rises by a tenth of the gap along s (`TILT`): knots of one row have an order in height, which lets
the pack open along straight lines without two of them meeting (see `initial.opening`).

**No cable is lengthened.** Along a layer the map is an isometry but for the tilt. A cable across a fold of the first
direction changes its layer by h, and its place along y by up to 2h at a turn of the band. The net is drawn together by
a factor q just below 1, found by iteration, until the ends of each cable, above all of the one that is shortest
relative to its drawn length, are no farther apart than (1 − slack) L̄.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.initial.canister import (
    SLACK,
    Canister,
    Plane,
    check_pack,
    check_slack_share,
    fitting,
    rounded_up,
    stretch_of,
)
from netdae.initial.scaled import placed
from netdae.model.net import CableNet
from netdae.model.state import State

TILT = 0.1
"""Rise of a panel from one end to the other, in gaps."""

WIDEST_GAP = 0.1
"""Largest gap chosen by default, as a share of the shortest cable."""

MOST_FOLDS = 1000
"""Most folds in one direction: more are a typing error."""


def accordion(
    net: CableNet,
    canister: Canister,
    *,
    folds: Sequence[int] | None = None,
    pitch: Sequence[float] | None = None,
    gap: float | None = None,
    cord_diameter: float = 0.0,
    slack: float = SLACK,
    coincide: bool = False,
    rotation_deg: ArrayLike = (0.0, 0.0, 0.0),
    velocity: ArrayLike = (0.0, 0.0, 0.0),
) -> tuple[CableNet, State]:
    """The flat net folded to and fro into a canister, rotated, moving as a whole; rotated net and initial state.

    folds : (2,), folds along the first and the second axis of the net's plane, x and y of a generated net;
        0 leaves a direction open; with an odd number both borders come to lie on one side of the pack
    pitch : (2,), m, the largest distance between folds along the open net instead; inf leaves a direction open
    gap : m, between layers; by default what the canister's depth leaves, a tenth of the shortest cable at most
    cord_diameter : m, the least gap that the cord allows
    slack : least slack of each cable, as a share of its rest length
    coincide : whether knots may share a place, for instance with gap = 0
    rotation_deg, velocity : as in `initial.scaled.scaled`; x̄ is rotated too

    Raises InputError where the pack does not fit, with the smallest size that does, and where a cable would be taut.
    """
    check_slack_share(slack)
    plane = Plane.of(net)
    flat = plane.flat(net.nodes)
    size = np.ptp(flat, axis=0)
    panels = _panels_of(size, folds, pitch)
    shape = f"accordion with {panels[0] - 1} and {panels[1] - 1} folds"
    h = _gap_of(net, panels, canister, gap, cord_diameter, shape)
    pack, factor = np.zeros((net.node_count, 3)), fitting(net) * (1 - slack)
    least = factor / 2
    while True:
        local = (flat - flat.min(axis=0)) * factor
        pack = _folded(local, size * factor, panels, h, shape)
        worst = float(stretch_of(net, pack).max())
        if worst <= 1 - slack:
            break
        factor *= 0.9999 * max((1 - slack) / worst, 0.9)
        if factor < least:
            e = int(np.argmax(stretch_of(net, pack)))
            raise InputError(
                f"{shape}: layers {h:.3g} m apart tighten cable {e}, which is {net.rest_length[e]:.3g} m long: "
                "give a smaller gap, or coarser cables"
            )
    _check_fits(pack, canister, shape)
    pack[:, :2] -= (pack[:, :2].min(axis=0) + pack[:, :2].max(axis=0)) / 2
    x = plane.solid(pack)
    check_pack(net, x, shape=shape, coincide=coincide)
    return placed(net, x, rotation_deg=rotation_deg, velocity=velocity)


def meander(
    s: FloatArray, c: FloatArray, *, width: float, gap: float, thickness: float, panels: int
) -> tuple[FloatArray, FloatArray]:
    """A band folded to and fro: place across, and height, of points s along it and c within its thickness, m."""
    w, h, H = width, gap, thickness
    period = w + h + 2 * H
    j = np.clip(np.floor((s - w / 2) / period + 0.5), 0, panels - 1)
    even = j % 2 == 0
    sign = np.where(even, 1.0, -1.0)
    shift = sign * (H - 2 * c) if panels > 1 else 0.0
    from_middle = s - (w / 2 + j * period - shift)
    ahead, behind = np.where(even, H - c, c), np.where(even, c, H - c)
    low = np.where(j == 0, -np.inf, -(w / 2 + behind))
    high = np.where(j == panels - 1, np.inf, w / 2 + ahead)
    along = np.clip(from_middle, low, high)
    climb = from_middle - along
    height = j * (H + h) + np.where(even, c, H - c) + climb
    return sign * along, height + (TILT * h * s / period if panels > 1 else 0.0)


def _folded(flat: FloatArray, size: FloatArray, panels: tuple[int, int], h: float, shape: str) -> FloatArray:
    """Pack (n, 3) of plane coordinates (n, 2) that start at zero, folded along the first, then the second."""
    pack = np.empty((len(flat), 3))
    height, H = np.zeros(len(flat)), 0.0
    for axis, (n, name) in enumerate(zip(panels, ("first", "second"), strict=True)):
        width = (size[axis] - (n - 1) * (h + 2 * H)) / n
        if not width > 0:
            raise InputError(
                f"{shape}: {n - 1} folds of a band {H:.3g} m thick leave no panel of {size[axis]:.3g} m along the "
                f"{name} direction: give fewer folds or a smaller gap"
            )
        pack[:, axis], height = meander(flat[:, axis], height, width=width, gap=h, thickness=H, panels=n)
        H = float(np.ptp(height))
        height -= height.min()
    pack[:, 2] = height
    return pack


def _panels_of(
    size: FloatArray, folds: Sequence[int] | None, pitch: Sequence[float] | None
) -> tuple[int, int]:
    if (folds is None) == (pitch is None):
        raise InputError(
            "accordion: give folds, their number along both directions, or pitch, one of the two"
        )
    counts = []
    for axis in range(2):
        if folds is not None:
            if isinstance(folds[axis], bool) or folds[axis] != int(folds[axis]):
                raise InputError(f"accordion: folds is {[*folds]}: give two whole numbers")
            count = int(folds[axis])
        else:
            assert pitch is not None
            if not pitch[axis] > 0:
                raise InputError(f"accordion: pitch is {[*pitch]} m: give two lengths above zero")
            # a pitch that divides the net must not leave a sliver by round-off
            exact = float(size[axis]) / pitch[axis] - 1e-9
            count = math.ceil(min(exact, 2.0 * MOST_FOLDS)) - 1 if exact > 1 else 0
        if not 0 <= count <= MOST_FOLDS:
            raise InputError(
                f"accordion: {count} folds along {'the first' if axis == 0 else 'the second'} direction: "
                f"give 0 to {MOST_FOLDS}"
            )
        counts.append(count + 1)
    if counts == [1, 1]:
        raise InputError("accordion: no folds in either direction: give one at least")
    return counts[0], counts[1]


def _gap_of(
    net: CableNet,
    panels: tuple[int, int],
    canister: Canister,
    gap: float | None,
    cord_diameter: float,
    shape: str,
) -> float:
    """Distance of layers, m, such that all fit into the depth."""
    for name, value in (("gap", gap), ("cord_diameter", cord_diameter)):
        if value is not None and not (math.isfinite(value) and value >= 0):
            raise InputError(f"accordion: {name} is {value:g} m: give a length, zero or more")
    first, second = panels
    strip = (first - 1) + TILT * (first if first > 1 else 0)
    # height of the pack in gaps
    layers = second * strip + (second - 1) + TILT * (second if second > 1 else 0)
    if gap is None:
        gap = max(min(canister.depth / layers, WIDEST_GAP * float(net.rest_length.min())), cord_diameter)
    elif gap < cord_diameter:
        raise InputError(
            f"{shape}: the gap is {gap:g} m, less than the cord's diameter {cord_diameter:g} m: "
            "give a gap that the cord fits in"
        )
    if gap * layers > canister.depth * (1 + 1e-9):
        raise InputError(
            f"{shape}: {first * second} layers {gap:.3g} m apart are {gap * layers:.4g} m high, but the "
            f"{canister.words}: give a depth of {rounded_up(gap * layers)} m at least, or fewer folds"
        )
    return gap


def _check_fits(pack: FloatArray, canister: Canister, shape: str) -> None:
    """Raise InputError with the smallest canister that holds the pack (n, 3)."""
    needed = canister.width_for(pack[:, :2])
    wide, high = np.ptp(pack[:, :2], axis=0)
    if needed > canister.width * (1 + 1e-9):
        key = "side" if canister.diameter is None else "diameter"
        longer = "first" if wide >= high else "second"
        raise InputError(
            f"{shape}: the pack is {wide:.4g} m by {high:.4g} m, but the {canister.words}: "
            f"give a {key} of {rounded_up(needed)} m at least, or more folds along the {longer} direction"
        )
