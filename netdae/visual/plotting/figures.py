"""Which figures there are, and which panels and curves each has for given runs; nothing is drawn here."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from typing import NamedTuple

import numpy as np

from netdae.core.errors import InputError
from netdae.visual.plotting.runs import Curve, FlownRun

OVERVIEW = "overview"
"""Name of the sheet with the panels of all figures."""


class Quantity(NamedTuple):
    """A column, its name in a legend beside others, and its name on an axis of its own."""

    column: str
    short: str
    long: str


class Panel(NamedTuple):
    """Quantities on one axis; several runs have a panel for each quantity instead.

    least_span : smallest span of the axis, in its unit, so that round-off stays a flat line
    same_scale : whether panels for each quantity have one scale, as the components of a vector
    alone : whether it is for a single run only, which shows a quantity again at its own scale
    height : relative to that of other panels
    """

    label: str
    unit: str
    quantities: tuple[Quantity, ...]
    least_span: float = 1e-9
    same_scale: bool = False
    alone: bool = False
    height: float = 1.0
    in_overview: bool = True

    @property
    def axis_label(self) -> str:
        """Name and unit."""
        return f"{self.label}, {self.unit}"


class Design(NamedTuple):
    """A figure: its heading above several runs, and its panels."""

    heading: str
    panels: tuple[Panel, ...]


def _vector(column: str, long: str) -> tuple[Quantity, ...]:
    return tuple(Quantity(f"{column}_{axis}", axis, f"{long} {axis}") for axis in "xyz")


def _single(column: str, label: str) -> tuple[Quantity, ...]:
    return (Quantity(column, label, label),)


SHARE_OF_STRENGTH = "tension_share"
"""Column that is computed here: the largest tension over the lowest strength."""

TETHER_TENSION = "tether_tension"
"""Column that has the tether's strength for a level line."""

PENETRATION = "penetration"
"""Column that is computed here: how deep the net is in a body."""

_LESS = "_less_impulse"
_IMPULSES = {"momentum": "external_impulse", "angular_momentum": "external_angular_impulse"}

DESIGNS = {
    "area": Design(
        "Areas",
        (
            Panel(
                "area",
                "m²",
                (
                    Quantity("mouth_area", "mouth", "mouth area"),
                    Quantity("corner_area", "corners", "corner area"),
                ),
            ),
        ),
    ),
    "distance": Design("Distance", (Panel("distance flown", "m", _single("distance", "distance flown")),)),
    "energy": Design(
        "Energies",
        (
            Panel(
                "energy",
                "J",
                (
                    Quantity("kinetic_energy", "kinetic", "kinetic energy"),
                    Quantity("elastic_energy", "elastic", "elastic energy"),
                    Quantity("dissipated_energy", "dissipated", "dissipated energy"),
                    Quantity("external_work", "external work", "external work"),
                ),
                least_span=1e-15,
                height=1.5,
            ),
            Panel(
                "elastic energy",
                "J",
                _single("elastic_energy", "elastic energy"),
                least_span=1e-15,
                alone=True,
            ),
            Panel("energy residual", "J", _single("energy_residual", "energy residual"), least_span=1e-15),
        ),
    ),
    "tension": Design(
        "Tensions",
        (
            Panel("largest tension", "N", _single("max_tension", "largest tension"), height=1.5),
            Panel(
                "tension / strength", "1", _single(SHARE_OF_STRENGTH, "tension / strength"), in_overview=False
            ),
        ),
    ),
    "momentum": Design(
        "Momenta",
        (
            Panel("momentum", "kg m/s", _vector("momentum", "momentum"), same_scale=True),
            Panel(
                "angular momentum",
                "kg m²/s",
                _vector("angular_momentum", "angular momentum"),
                same_scale=True,
            ),
            Panel(
                "momentum − impulse",
                "kg m/s",
                _vector(f"momentum{_LESS}", "momentum − impulse"),
                same_scale=True,
                in_overview=False,
            ),
            Panel(
                "ang. mom. − impulse",
                "kg m²/s",
                _vector(f"angular_momentum{_LESS}", "ang. mom. − impulse"),
                same_scale=True,
                in_overview=False,
            ),
        ),
    ),
    "taut": Design("Taut cables", (Panel("taut fraction", "1", _single("taut_fraction", "taut fraction")),)),
    "tether": Design(
        "Tether",
        (
            Panel("length paid out", "m", _single("paid_out", "length paid out")),
            Panel("tether tension", "N", _single(TETHER_TENSION, "tether tension")),
            Panel("distance to chaser", "m", _single("chaser_distance", "distance to chaser")),
        ),
    ),
    "contact": Design(
        "Contact",
        (
            Panel("contact force", "N", _single("contact_force", "contact force")),
            Panel("normal impulse", "N s", _single("normal_impulse", "normal impulse"), in_overview=False),
            Panel("gap", "m", _single("contact_gap", "gap")),
            Panel("penetration", "m", _single(PENETRATION, "penetration"), in_overview=False),
            Panel(
                "contact energy",
                "J",
                (
                    Quantity("contact_energy", "stored", "energy stored in contact"),
                    Quantity("contact_dissipated", "dissipated", "energy dissipated in contact"),
                    Quantity("friction_dissipated", "by friction", "energy dissipated by friction"),
                ),
                least_span=1e-15,
                in_overview=False,
            ),
        ),
    ),
    "target": Design(
        "Target",
        (
            Panel("target", "m", _vector("target", "target"), same_scale=True),
            Panel("target velocity", "m/s", _vector("target_velocity", "target velocity"), same_scale=True),
            Panel(
                "target spin",
                "rad/s",
                _vector("target_spin", "target spin"),
                same_scale=True,
                in_overview=False,
            ),
            Panel(
                "force on target",
                "N",
                _vector("target_force", "force on target"),
                same_scale=True,
                in_overview=False,
            ),
        ),
    ),
    "closing": Design(
        "Closing cords",
        (
            Panel("length of closing", "m", _single("closing_length", "length of closing")),
            Panel("closing tension", "N", _single("closing_tension", "closing tension")),
        ),
    ),
}
"""Figures by name, without the overview. Add a new column of metrics.csv here."""

NAMES = (OVERVIEW, *DESIGNS)
"""Names that can be requested."""


def heading_of(name: str) -> str:
    """Heading of a figure of several runs."""
    return "Overview" if name == OVERVIEW else DESIGNS[name].heading


def check_name(name: str) -> None:
    """Raise InputError, with the nearest name, for a name that no figure has."""
    if name not in NAMES:
        near = get_close_matches(name, NAMES, n=1, cutoff=0.4)
        hint = f"did you mean {near[0]}? Choose" if near else "choose"
        raise InputError(f"there is no figure {name!r}: {hint} one of {', '.join(NAMES)}")


def curve_of(run: FlownRun, column: str) -> Curve | None:
    """Curve of a column of metrics.csv or of a computed one; None where the run has no finite value of it."""
    curve = _curve_of(run, column)
    if curve is None or not _is_finite(curve):
        return None
    return curve


def panels_of(name: str, runs: Sequence[FlownRun]) -> list[Panel]:
    """The panels of a figure for these runs, each with the quantities that a run has; none where no run has any."""
    designs = DESIGNS.values() if name == OVERVIEW else [DESIGNS[name]]
    panels = [panel for design in designs for panel in design.panels if name != OVERVIEW or panel.in_overview]
    return [shown for panel in panels for shown in _shown(panel, runs)]


def _shown(panel: Panel, runs: Sequence[FlownRun]) -> Iterator[Panel]:
    had = tuple(each for each in panel.quantities if any(curve_of(run, each.column) for run in runs))
    if not had or (panel.alone and len(runs) > 1) or not _has_news(had[0], runs):
        return
    if len(runs) == 1 and len(had) > 1:
        yield panel._replace(quantities=had)
        return
    for quantity in had:
        yield panel._replace(
            quantities=(quantity,), label=quantity.long, height=1.0 if len(had) > 1 else panel.height
        )


def _has_news(quantity: Quantity, runs: Sequence[FlownRun]) -> bool:
    """False for a momentum less impulses that no run has: it is the momentum."""
    if _LESS not in quantity.column:
        return True
    impulse = _IMPULSES[quantity.column.split(_LESS)[0]]
    vectors = [run.curves.get(f"{impulse}_{axis}") for run in runs for axis in "xyz"]
    return any(vector is not None and vector.values.any() for vector in vectors)


def _curve_of(run: FlownRun, column: str) -> Curve | None:
    if column == SHARE_OF_STRENGTH:
        tension = run.curves.get("max_tension")
        if tension is None or not run.strengths:
            return None
        lowest = min(each.force for each in run.strengths)
        return Curve(*(None if part is None else part / lowest for part in tension))  # type: ignore[arg-type]
    if column == PENETRATION:
        gap = run.curves.get("contact_gap")
        return None if gap is None else Curve(np.maximum(-gap.values, 0.0))
    if _LESS in column:
        vector, axis = column.split(_LESS)
        whole, impulse = run.curves.get(f"{vector}{axis}"), run.curves.get(f"{_IMPULSES[vector]}{axis}")
        if whole is None or impulse is None:
            return None
        return Curve(whole.values - impulse.values)  # the band of a difference is not in the table
    return run.curves.get(column)


def _is_finite(curve: Curve) -> bool:
    return bool(np.isfinite(curve.values).any())
