"""Figures of a flight from its history: what the summary reports, and what it warns of.

A history is a value at each internal step of the integrator, (k,), and taken as linear between the steps.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.system.measurements import MEASURE_NAMES

HISTORY = (
    "time",
    "mouth_area",
    "corner_area",
    "distance",
    "dissipated_energy",
    "external_work",
    "momentum_residual",
    "angular_momentum_residual",
    "contact_gap",
    "contact_force",
    "contact_energy",
    "contact_dissipated",
    "friction_dissipated",
    "normal_impulse",
    *MEASURE_NAMES,
)
"""Names of the histories, in SI units; see `system.measurements.MEASURE_NAMES`.

contact_... to normal_impulse are as the columns of `metrics.DeploymentMetrics`. ..._residual of a momentum is the size
of the difference between its change and the external impulse.
"""

CONTACT_SUMS = ("contact_dissipated", "friction_dissipated", "normal_impulse")
"""Histories that are sums over time."""

LARGE_STRAIN = 0.5
"""E11 over which a summary warns: cords break at 0.02 to 0.1, and by a force of 1e6 N methods differ by 5 %."""

FINER = 'a finer accuracy, or where that is "accurate" finer tolerances or a smaller max_step'


def figures_of(
    h: Mapping[str, FloatArray],
    *,
    mouth: bool = True,
    corners: bool = True,
    strength: bool = True,
    toe: bool = True,
    finer: str = FINER,
) -> dict[str, Any]:
    """Figures of the histories h, by the names of `HISTORY`, and `warnings`, a list of sentences.

    mouth, corners, strength, toe : False where the net has none, so that its figures are left out
    finer : what a warning tells to set for a finer integration
    """
    figures: dict[str, Any] = {"end_time": float(h["time"][-1])}
    warnings: list[str] = []
    if mouth:
        figures |= _mouth_figures(h, warnings)
    if corners:
        figures |= _corner_figures(h)
    figures["final_distance"] = float(h["distance"][-1])
    figures |= _tension_figures(h)
    if strength:
        figures |= _strength_figures(h, warnings)
    figures["peak_strain"] = peak = max(0.0, float(h["strain"].max()))
    if peak > LARGE_STRAIN:
        warnings.append(
            f"the peak strain is {peak:.3g}, a stretch to {math.sqrt(1 + 2 * peak):.3g} times the length: unless cords "
            "are of rubber, check the units of loads, masses and youngs_modulus; where cables stretch so fast methods "
            'differ by several per cent: fly it with method = "ida" and "explicit", and compare'
        )
    if toe:
        figures |= _toe_figures(h, warnings)
    figures |= _energy_figures(h, warnings, finer)
    figures |= _momentum_figures(h)
    figures["warnings"] = warnings
    return figures


def tether_figures(h: Mapping[str, FloatArray], *, strength: float) -> dict[str, Any]:
    """Tension of the tether in the histories h, N; against its strength in N unless that is infinite.

    Names and meanings are those of the figures of all cables, see `metrics.DeploymentMetrics.summary`.
    """
    tension = h["tether_tension"]
    k = int(tension.argmax())
    figures = {"peak_tension": float(tension[k]), "peak_tension_time": float(h["time"][k])}
    if np.isfinite(strength):
        figures["tension_over_strength"] = time_quantile(h["time"], tension, 0.999) / strength
        figures["peak_tension_over_strength"] = float(tension[k]) / strength
    return figures


def contact_figures(h: Mapping[str, FloatArray]) -> dict[str, Any]:
    """Figures of contact of the histories h; names and meanings as in `manual/summary.md`."""
    gap, force = h["contact_gap"], h["contact_force"]
    k, j = int(gap.argmin()), int(force.argmax())
    touching = np.flatnonzero(gap < 0.0)
    first = {"first_contact": float(h["time"][touching[0]])} if len(touching) else {}
    return {
        **first,
        "least_gap": float(gap[k]),
        "least_gap_time": float(h["time"][k]),
        "peak_contact_force": float(force[j]),
        "peak_contact_force_time": float(h["time"][j]),
        "final_contact_energy": float(h["contact_energy"][-1]),
        **{name: float(h[name][-1]) for name in CONTACT_SUMS if not math.isnan(h[name][-1])},
    }


def time_below(times: FloatArray, values: FloatArray, level: float, *, strictly: bool = False) -> float:
    """Time for which a history, linear between its steps, is at or below a level (strictly: below it), s."""
    dt = np.diff(times)
    low, high = np.minimum(values[:-1], values[1:]), np.maximum(values[:-1], values[1:])
    flat = low == high
    share = np.clip((level - low) / np.where(flat, 1.0, high - low), 0.0, 1.0)
    share[flat] = low[flat] < level if strictly else low[flat] <= level
    return float(dt @ share)


def time_quantile(times: FloatArray, values: FloatArray, share: float) -> float:
    """Level that a history, linear between its steps, does not pass for `share` of its time."""
    target = share * float(times[-1] - times[0])
    levels = np.unique(values)
    if target <= 0.0:
        return float(levels[0] if times[-1] > times[0] else levels[-1])
    under, reached = -1, len(levels) - 1  # time_below(levels[reached]) >= target
    while reached - under > 1:
        middle = (under + reached) // 2
        if time_below(times, values, levels[middle]) >= target:
            reached = middle
        else:
            under = middle
    high = float(levels[reached])
    before = time_below(times, values, high, strictly=True)
    if reached == 0 or before <= target:
        return high
    low = float(levels[reached - 1])
    start = time_below(times, values, low)
    return low + (high - low) * (target - start) / (before - start)


def _mouth_figures(h: Mapping[str, FloatArray], warnings: list[str]) -> dict[str, Any]:
    times, areas = h["time"], h["mouth_area"]
    k = int(areas.argmax())
    largest = float(areas[k])
    opens = largest - float(areas.min()) > 1e-9 * largest  # a net at rest opens by round-off
    if opens and k == len(areas) - 1:
        warnings.append(
            f"the mouth is largest at the end of the flight, {largest:.4g} m² at t = {times[k]:.4g} s: "
            "it may open further: set a later end, unless an event stops the flight there"
        )
    over = float(times[-1] - times[0]) - time_below(times, areas, 0.8 * largest)
    return {
        "largest_mouth_area": largest,
        "largest_mouth_area_time": float(times[k]),
        "largest_mouth_area_distance": float(h["distance"][k]),
        "time_over_80_percent_of_mouth_area": over if largest > 0 else 0.0,
        "final_mouth_area": float(areas[-1]),
    }


def _corner_figures(h: Mapping[str, FloatArray]) -> dict[str, Any]:
    k = int(h["corner_area"].argmax())
    return {
        "largest_corner_area": float(h["corner_area"][k]),
        "largest_corner_area_time": float(h["time"][k]),
        "final_corner_area": float(h["corner_area"][-1]),
    }


def _tension_figures(h: Mapping[str, FloatArray]) -> dict[str, Any]:
    k = int(h["tension"].argmax())
    return {
        "peak_tension": float(h["tension"][k]),
        "peak_tension_time": float(h["time"][k]),
        "peak_tension_cable": int(h["tension_cable"][k]),
        "tension_quantile_99_9": time_quantile(h["time"], h["tension"], 0.999),
    }


def _strength_figures(h: Mapping[str, FloatArray], warnings: list[str]) -> dict[str, Any]:
    k = int(h["load"].argmax())
    peak, cable = float(h["load"][k]), int(h["load_cable"][k])
    quantile = time_quantile(h["time"], h["load"], 0.999)
    if quantile > 1:
        warnings.append(
            f"the tension passes the strength: it is over {quantile:.3g} times as large for 0.1 % of the time "
            f"and {peak:.3g} times at its peak, in cable {cable} at t = {h['time'][k]:.4g} s"
        )
    return {"tension_over_strength": quantile, "peak_tension_over_strength": peak, "weakest_cable": cable}


def _toe_figures(h: Mapping[str, FloatArray], warnings: list[str]) -> dict[str, Any]:
    taut, toe = (float(np.trapezoid(h[name], h["time"])) for name in ("taut_count", "toe_count"))
    share = toe / taut if taut > 0 else 0.0
    multiple = max(0.0, float(h["toe_multiple"].max()))
    if share > 0.5:
        warnings.append(
            f"taut cables spend {100 * share:.0f} % of their time in the toe of their law, the peak strain "
            f"is {multiple:.3g} toe strains: the toe softens the net: lower toe_strain if it is to smooth only"
        )
    return {"peak_strain_over_toe_strain": multiple, "toe_share_of_taut_time": share}


def _energy_figures(h: Mapping[str, FloatArray], warnings: list[str], finer: str) -> dict[str, Any]:
    energy = h["kinetic_energy"] + h["elastic_energy"]
    less_work = energy - h["external_work"]
    rise = less_work - np.minimum.accumulate(less_work)  # a passive net never gains any
    residual = less_work + h["dissipated_energy"]
    residual = residual - residual[0]
    largest = float(energy.max())
    scale = largest if largest > 0 else 1.0
    k, j = int(np.abs(residual).argmax()), int(rise.argmax())
    residual_share, rise_share = float(residual[k]) / scale, float(rise[j]) / scale
    if abs(residual_share) > 0.01:
        warnings.append(
            f"the energy residual reaches {100 * residual_share:.2g} % of the largest kinetic + elastic "
            f"energy at t = {h['time'][k]:.4g} s, more than 1 %: set {finer} to keep it better"
        )
    if rise_share > 0.001:
        warnings.append(
            f"kinetic + elastic energy less the external work rises {100 * rise_share:.2g} % of the largest "
            f"until t = {h['time'][j]:.4g} s, more than 0.1 %: set {finer}, which it needs"
        )
    return {
        "final_kinetic_energy": float(h["kinetic_energy"][-1]),
        "final_elastic_energy": float(h["elastic_energy"][-1]),
        "final_dissipated_energy": float(h["dissipated_energy"][-1]),
        "final_external_work": float(h["external_work"][-1]),
        "largest_energy": largest,
        "energy_residual_share": residual_share,
        "energy_rise_share": rise_share,
    }


def _momentum_figures(h: Mapping[str, FloatArray]) -> dict[str, Any]:
    """Largest errors of the balances, N s and N m s, and their shares of the largest Σ m |v| and Σ m |x × v|."""
    figures: dict[str, Any] = {}
    for name, scale in (("momentum", "speed_moment"), ("angular_momentum", "turn_moment")):
        worst, largest = float(h[f"{name}_residual"].max()), float(h[scale].max())
        figures[f"{name}_residual"] = worst
        figures[f"{name}_residual_share"] = worst / largest if largest > 0 else 0.0
    return figures
