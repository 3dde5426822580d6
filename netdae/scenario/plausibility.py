"""What in a simulation is far from what nets are made of and flown with, most often by a slip of the unit.

A flight of cords 1 m thick, since the diameter was meant in mm, runs without an error. Each bound below is one that
nets which were built or proposed keep with room to spare; beyond it stands a note, never an error.

Symbols: E Young's modulus, ρ̄ density, d diameter, L̄ rest length, c = √(E/ρ̄) wave speed, τ viscosity time, of each
cable; ζ = τ c/L̄ share of critical of its own axial mode, see `damping.Dashpot`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from netdae.core.arrays import BoolArray, FloatArray
from netdae.initial.ejection import Launch
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.model.tether import is_own_node, own_cables_of
from netdae.system.reels import reeled_cables
from netdae.system.scales import gravities_of
from netdae.system.system import System


class Usual(NamedTuple):
    """Between which values a figure of the cables is usual; `why` reports the reason, and the likely slip."""

    name: str
    unit: str
    low: float
    high: float
    why: str


DIAMETER = Usual("diameter", "m", 2e-5, 0.02, "from a single fibre to a rope of 20 mm; was it meant in mm?")
MODULUS = Usual(
    "youngs_modulus", "Pa", 1e6, 1e12, "from rubber to diamond; was it meant in GPa, MPa or N/mm²?"
)
DENSITY = Usual(
    "density", "kg/m³", 50.0, 25e3, "from foam to osmium; was it, or a linear_density, meant in g?"
)
WAVE_SPEED = Usual(
    "wave speed √(E/ρ̄)", "m/s", 10.0, 2e4, "from soft rubber to diamond; look at youngs_modulus and density"
)
SLENDERNESS = Usual(
    "length over diameter",
    "",
    20.0,
    math.inf,
    "below that a cord is a rod, whose bending the model leaves out",
)
STRENGTH = Usual(
    "strength over cross-section", "Pa", 1e6, 1e10, "the best fibres bear 6e9; was it meant in kN?"
)
DAMPING = Usual(
    "share of critical damping", "", 0.0, 100.0, "cords have 0.01 to 1; look at viscosity_time, zeta or beta"
)

LONGEST_NET, SMALLEST_NET = 500.0, 0.02
"""m: nets are 1 to 100 m wide, models of them for the laboratory a few cm."""

FASTEST_SHOT, SLOWEST_SHOT = 300.0, 0.01
"""m/s: nets are shot at 1 to 50 m/s; at 0.01 m/s a net of 1 m takes a minute and more to open."""

LARGEST_STRAIN = 0.1
"""Speed over wave speed, the strain of a snap: cords break at 0.02 to 0.05."""

HEAVIEST_BULLETS = 1000.0
"""Mass of all bullets over that of the cords; usual are 0.5 to 20."""

LARGEST_GRAVITY = 200.0
"""m/s²: twenty times that of the Earth; 9810 are mm/s²."""


def unusual_of(system: System, start: State, launch: Launch | None = None) -> tuple[str, ...]:
    """A line for each figure that lies outside its bounds: what was given, what is usual; none for a usual net."""
    of_net = (*_cables(system), *_size(system))
    shots: Iterator[str] = iter(())
    if launch is not None and len(launch.nodes):
        shots = _shots(system, start, launch, usual_net=not of_net)
    return (*of_net, *shots, *_gravity(system, start.t))


def _cables(system: System) -> Iterator[str]:
    net, cords = system.net, system.cords
    modulus, density = cords.axial_stiffness / cords.area, cords.linear_density / cords.area
    density = np.where(density > 0, density, np.nan)  # a massless cord has no speed of waves
    diameter, c = np.sqrt(4 * cords.area / np.pi), np.sqrt(modulus / density)
    given = [
        line
        for usual, values in ((DIAMETER, diameter), (MODULUS, modulus), (DENSITY, density))
        if (line := _outside(usual, values, net)) is not None
    ]
    if given:  # what is made of them is off for the same reason
        yield from given
        return
    tau = np.maximum(system.cables.tau, getattr(system.damping, "beta", 0.0))
    # on reels a cable may begin with next to no length
    slenderness = np.where(reeled_cables(system.reels, net.cable_count), np.nan, net.rest_length / diameter)
    known = np.where(np.isfinite(cords.strength), cords.strength / cords.area, np.nan)
    for usual, values in (
        (WAVE_SPEED, c),
        (SLENDERNESS, slenderness),
        (STRENGTH, known),
        (DAMPING, np.where(np.isnan(slenderness), np.nan, tau * c / net.rest_length)),
    ):
        line = _outside(usual, values, net)
        if line is not None:
            yield line


def _outside(usual: Usual, values: FloatArray, net: CableNet) -> str | None:
    """The line on a figure (m,) of the cables, at its worst; None where it is usual, or nan as it is not asked for."""
    wrong = (values < usual.low) | (values > usual.high)
    if not wrong.any():
        return None
    off = np.where(wrong, np.maximum(usual.low / values, values / usual.high), 0.0)
    value = float(values[np.argmax(off)])
    unit = f" {usual.unit}" if usual.unit else ""
    if usual.high == math.inf:
        bounds = f"above {usual.low:g}{unit}"
    elif usual.low == 0:
        bounds = f"below {usual.high:g}{unit}"
    else:
        bounds = f"{usual.low:g} to {usual.high:g}{unit}"
    return (
        f"{usual.name} is {value:.4g}{unit} of {_cables_in_words(wrong, net)}, usual is {bounds}: {usual.why}"
    )


def _cables_in_words(wrong: BoolArray, net: CableNet) -> str:
    count = int(np.count_nonzero(wrong))
    if count == net.cable_count:
        return "all cables"
    for name, cables in net.cable_groups.items():
        if len(cables) == count and wrong[cables].all():
            return f"the cables {name!r}"
    return f"{count} of {net.cable_count} cables, first cable {int(np.argmax(wrong))}"


def _size(system: System) -> Iterator[str]:
    nodes = system.net.nodes[is_own_node(system.net)]
    size = float(np.ptp(nodes, axis=0).max())
    if not SMALLEST_NET <= size <= LONGEST_NET:
        yield (
            f"the net is {size:.4g} m wide, usual is {SMALLEST_NET:g} to {LONGEST_NET:g} m: was the mesh, or its "
            "size, meant in mm?"
        )


def _shots(system: System, start: State, launch: Launch, *, usual_net: bool) -> Iterator[str]:
    """Bullets, by their speed beside that of the whole net; where the net is usual, beside its cords too."""
    net, cords = system.net, system.cords
    own = is_own_node(net)
    others = own.copy()
    others[launch.nodes] = False
    whole = start.v[others].mean(axis=0) if others.any() else np.zeros(3)
    speeds = np.linalg.norm(launch.velocities - whole, axis=1)
    fastest = float(speeds.max())
    if not SLOWEST_SHOT <= fastest <= FASTEST_SHOT:
        yield (
            f"the fastest bullet flies at {fastest:.4g} m/s, usual is {SLOWEST_SHOT:g} to {FASTEST_SHOT:g} m/s: was "
            "the speed meant in mm/s or km/h?"
        )
    if not usual_net:
        return
    cables = own_cables_of(net)
    cables = cables[cords.linear_density[cables] > 0]
    if not len(cables):  # nothing to compare with
        return
    c = float(np.sqrt(cords.axial_stiffness[cables] / cords.linear_density[cables]).min())
    if fastest <= FASTEST_SHOT and fastest > LARGEST_STRAIN * c:
        yield (
            f"the fastest bullet flies at {fastest:.4g} m/s, {fastest / c:.2g} of the wave speed {c:.4g} m/s of the "
            f"cords: a snap strains them by as much, usual is below {LARGEST_STRAIN:g}: look at youngs_modulus and "
            "speed"
        )
    half = 0.5 * cords.linear_density * net.rest_length
    knots = np.zeros(net.node_count)
    np.add.at(knots, net.cables.ravel(), np.repeat(half, 2))
    bullets = (system.mass - knots)[launch.nodes]
    knot = float(np.median(knots[own]))
    if bullets.min() < knot:
        node = int(launch.nodes[np.argmin(bullets)])
        yield (
            f"the bullet at node {node} has {bullets.min():.3g} kg, less than a knot with its half cables, "
            f"{knot:.3g} kg: it cannot draw the net out: was density or diameter too large, or mass too small?"
        )
    share = float(bullets.sum() / (cords.linear_density @ net.rest_length))
    if share > HEAVIEST_BULLETS:
        yield (
            f"the bullets have {bullets.sum():.4g} kg, {share:.3g} times the mass of all cords, usual is below "
            f"{HEAVIEST_BULLETS:g}: was their mass meant in g?"
        )


def _gravity(system: System, t: float) -> Iterator[str]:
    after = math.nextafter(t, math.inf)
    g = sum((g(after) for g in gravities_of(system) if g.covers(t, after)), np.zeros(3))
    largest = float(np.linalg.norm(g))
    if largest > LARGEST_GRAVITY:
        yield (
            f"gravity is {largest:.4g} m/s², usual is below {LARGEST_GRAVITY:g} m/s²: was it meant in mm/s²?"
        )
