"""Measurements of a deployment: a row of metrics.csv per frame, and the histories behind its summary."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from netdae.core.arrays import FloatArray, IntArray
from netdae.core.errors import InputError
from netdae.model.mouth import corners_of, mouth_of, vector_area
from netdae.model.state import State
from netdae.output.histories import FINER, HISTORY, contact_figures, figures_of, tether_figures
from netdae.output.step_log import StepLog
from netdae.system.measurements import Cordage, Measurements
from netdae.system.meeting import NO_TARGET, Contacts, Meeting, TargetColumns
from netdae.system.target_state import target_at

if TYPE_CHECKING:
    from netdae.model.net import CableNet
    from netdae.system.system import System

CONTACT = (
    "contact_gap",
    "contacts",
    "contact_force",
    "contact_energy",
    "contact_dissipated",
    "friction_dissipated",
    "normal_impulse",
)
"""Columns of contact with target and obstacles; see `DeploymentMetrics`."""

COLUMNS = (
    "time",
    "mouth_area",
    "corner_area",
    "distance",
    "com_x",
    "com_y",
    "com_z",
    "kinetic_energy",
    "elastic_energy",
    "dissipated_energy",
    "external_work",
    "energy_residual",
    "momentum_x",
    "momentum_y",
    "momentum_z",
    "angular_momentum_x",
    "angular_momentum_y",
    "angular_momentum_z",
    "max_tension",
    "taut_fraction",
    "external_impulse_x",
    "external_impulse_y",
    "external_impulse_z",
    "external_angular_impulse_x",
    "external_angular_impulse_y",
    "external_angular_impulse_z",
    *Cordage._fields,
    *TargetColumns._fields,
    *CONTACT,
)
"""Columns of metrics.csv, SI units."""


class DeploymentMetrics:
    """Observer that measures a flight: a row per frame, and a summary of all internal steps.

    mouth : name of the group whose closed loop is the net's mouth, see `mouth.mouth_of`; None for a net
        without one
    corners : name of the node group of the corners, see `mouth.corners_of`; None for none. A net without a
        mouth, without the default group or with fewer than three corners has no corner area.
    contact_sums : whether contact is summed over time, see below; not with `explicit`, whose steps last longer than a
        touch where they are reported
    log : file for a row of `output.histories.HISTORY` per internal step, so that these need no memory and survive a
        kill; in memory by default

    The columns of a row:

    mouth_area, corner_area : vector areas, m²; nan where there is none
    distance : of the centre of mass from its start along the initial momentum, m; the straight distance
        where the start has no momentum
    energy_residual : (kinetic + elastic + dissipated − external work) − its start, J
    max_tension : the largest at internal steps since the previous row, N; without the dashpot's share
    taut_fraction : share of the cables that are taut
    external_impulse, external_angular_impulse : from outside since the start, N s and N m s; momentum and angular
            momentum, of all nodes and about the origin, change by exactly these
    paid_out, ..., closing_tension : see `system.measurements.Cordage`; nan where there are none
    target_x, ..., target_force_z : see `system.meeting.TargetColumns`; nan where there is none
    contact_gap, contacts, contact_force, contact_energy : see `system.meeting.Contacts`, m, 1, N and J; nan where there
        is neither target nor obstacle
    contact_dissipated, friction_dissipated : J, since the start, the second a share of the first; and normal_impulse,
        N s: sums by the trapezoidal rule over internal steps; nan without `contact_sums`

    Centre of mass and distance are those of the net's own nodes, without tether and chaser.
    """

    def __init__(
        self,
        *,
        mouth: str | None = "border",
        corners: str | None = "corners",
        contact_sums: bool = True,
        log: str | os.PathLike[str] | None = None,
    ) -> None:
        self.mouth = mouth
        self.corners = corners
        self.contact_sums = contact_sums
        self.rows: list[tuple[float, ...]] = []
        self._history = StepLog(len(HISTORY), log)

    def kept_in(self, log: str | os.PathLike[str]) -> DeploymentMetrics:
        """The same measurements of another flight, with a log in that file."""
        return DeploymentMetrics(
            mouth=self.mouth, corners=self.corners, contact_sums=self.contact_sums, log=log
        )

    def begin(self, system: System) -> None:
        """Find the loops; raises InputError if the mouth is not one closed loop, and says how to do without."""
        self._look_at(system)
        self._started = False
        self.rows = []
        self._history.clear()

    def resume(self, system: System, memory: Mapping[str, Any]) -> None:
        """Go on with the log, up to the internal step where the flight is resumed, and with the start in `memory`.

        The rows of the frames are those that `rows` has. Raises InputError where the log ends too early.
        """
        self._look_at(system)
        self._start_com, self._start_total = memory["start_com"], float(memory["start_total"])
        self._start_momenta = memory["start_momenta"]
        direction = memory["direction"]
        self._direction = direction if len(direction) else None
        self._started = True
        self._history.reopen()
        self._history.keep(int(memory["shown"]))
        self._sums = memory["contact_sums"]
        self._rates = float(memory["contact_time"]), memory["contact_rates"]

    def memory(self) -> dict[str, FloatArray]:
        """What `resume` needs besides the log."""
        direction = np.zeros(0) if self._direction is None else self._direction
        return {
            "start_com": self._start_com,
            "direction": direction,
            "start_total": np.array(self._start_total),
            "start_momenta": self._start_momenta,
            "contact_sums": self._sums,
            "contact_time": np.array(self._rates[0]),
            "contact_rates": self._rates[1],
        }

    @property
    def history(self) -> FloatArray:
        """The histories so far, (k, 27): rows at internal steps, columns as `output.histories.HISTORY` names them."""
        return self._history.rows()

    def _look_at(self, system: System) -> None:
        net = system.net
        self._system = system
        self._loop = self._mouth_loop_of(net)
        self._corner_loop = self._corner_loop_of(net)
        self._measurements = Measurements.of(system)
        meeting = Meeting(system)
        self._meeting = meeting if meeting.bodies else None
        self._sums = np.full(3, 0.0 if self.contact_sums else math.nan)
        self._rates = math.nan, np.zeros(3)
        self._has_strength = bool(np.isfinite(system.strength).any())
        self._has_toe = bool((system.toe_strain > 0).any())

    def __call__(self, state: State) -> None:
        """Add the row of a frame, and bring the log up to it."""
        self.rows.append(self.row_of(state))
        self._history.flush()

    def end(self) -> None:
        """Close the log; the summary is still available."""
        self._history.close()

    def forget(self) -> None:
        """Remove the log."""
        self._history.remove()

    def watch(self, state: State) -> None:
        """Include an internal step in the summary."""
        if not self._started:
            self._start(state)
        self._system.take(state)
        x, balance = state.x, state.balance
        met = self._met(state)
        # index 2 is what contact stores
        measured = self._measurements.measure(
            x, state.v, t=state.t, contact_energy=None if self._meeting is None else met[2]
        )
        momentum, turn = self._momentum_errors(state)
        self._history.append(
            (
                state.t,
                _area_of(x, self._loop),
                _area_of(x, self._corner_loop),
                self._distance_to(self._measurements.centre_of(x)),
                balance.dissipated_energy,
                balance.external_work,
                momentum,
                turn,
                *met,
                *measured,
            )
        )

    def row_of(self, state: State) -> tuple[float, ...]:
        """Row of `COLUMNS` for a State of the flight; the first State seen is the start."""
        if not self._started:
            self._start(state)
        system, x, v, balance = self._system, state.x, state.v, state.balance
        system.take(state)
        kinetic, elastic = system.kinetic_energy(v), system.elastic_energy(x)
        com = self._measurements.centre_of(x)
        total = kinetic + elastic + balance.dissipated_energy - balance.external_work
        row = (
            state.t,
            _area_of(x, self._loop),
            _area_of(x, self._corner_loop),
            self._distance_to(com),
            *com,
            kinetic,
            elastic,
            balance.dissipated_energy,
            balance.external_work,
            total - self._start_total,
            *system.momentum(v),
            *system.angular_momentum(x, v),
            balance.peak_tension,
            np.count_nonzero(system.strain(x) > 0) / system.net.cable_count,
            *balance.external_impulse,
            *balance.external_angular_impulse,
            *self._measurements.cordage_at(x),
            *NO_TARGET,
            *[math.nan] * len(CONTACT),
        )
        if self._meeting is not None:
            met = self._meeting.at(state)
            now = self._sums + self._share(state.t, met)
            of_target = self._meeting.columns(state)
            of_contact = (met.gap, met.touching, met.normal, met.stored, *now)
            row = (*row[: -len(of_target) - len(CONTACT)], *of_target, *of_contact)
        return tuple(map(float, row))

    def table(self) -> dict[str, FloatArray]:
        """The rows so far as column name to (k,)."""
        columns = np.array(self.rows, dtype=np.float64).reshape(len(self.rows), len(COLUMNS))
        return dict(zip(COLUMNS, columns.T.copy(), strict=True))

    def summary(self, *, finer: str = FINER) -> dict[str, Any]:
        """Figures of the flight from all internal steps, SI units, and `warnings`, a list of sentences.

        The number of frames changes none of them. Figures that a net does not have (of mouth, corners,
        strength, toe) are left out. largest_..., peak_... and final_... are values at internal steps; their
        times and distances follow in keys of their own.
        tension_quantile_99_9 : N, the largest tension of the net stays below it for 99.9 % of the time
        tension_over_strength : the same for the largest ratio of tension to strength
        energy_residual_share, energy_rise_share : of largest_energy, the largest kinetic + elastic energy
        momentum_residual, angular_momentum_residual : N s and N m s, largest errors of their balances, and ..._share
            of the largest Σ m |v| and Σ m |x × v|
        finer : what a warning tells to set for a finer integration
        """
        return figures_of(
            self._histories(),
            finer=finer,
            mouth=self._loop is not None,
            corners=self._corner_loop is not None,
            strength=self._has_strength,
            toe=self._has_toe,
        )

    def tether_summary(self, last: State) -> dict[str, Any]:
        """Figures of the tether from all internal steps, of which `last` is the last; {} where there is none.

        paid_out, mass_left : m by the reel, and kg, see `tether_assembly`; left out where there is no reel
        length, final_distance : m, rest length, and from the net's centre of mass to the chaser
        peak_tension, ... : as in `summary`, of the tether's cables alone, against their lowest strength
        """
        tether = self._measurements.tether
        if not tether.any():
            return {}
        strength = float(self._system.strength[tether].min())
        return {
            **self._measurements.tether_at(last.x),
            **tether_figures(self._histories(), strength=strength),
        }

    def target_summary(self, last: State) -> dict[str, Any]:
        """Figures of the target at the last internal step; {} where there is none.

        final_position, final_velocity : (3,), m and m/s, of its centre of mass
        final_spin_deg_s : (3,), degrees/s, about the axes of its frame
        """
        if self._system.body is None:
            return {}
        target = target_at(self._system, last)
        return {
            "final_position": target.centre.tolist(),
            "final_velocity": target.velocity.tolist(),
            "final_spin_deg_s": np.degrees(target.spin).tolist(),
        }

    def contact_summary(self) -> dict[str, Any]:
        """Figures of contact with target and obstacles from all internal steps; {} where there are none of these."""
        return {} if self._meeting is None else contact_figures(self._histories())

    def _histories(self) -> dict[str, FloatArray]:
        if not len(self._history):
            raise RuntimeError("no internal step was watched: give the metrics to simulate() as an observer")
        return dict(zip(HISTORY, np.array(self.history).T, strict=True))

    def _mouth_loop_of(self, net: CableNet) -> IntArray | None:
        if self.mouth is None:
            return None
        try:
            return mouth_of(net, self.mouth)
        except InputError as error:
            raise InputError(
                f'{error}; a net without a mouth has mouth = "none" in [metrics], mouth=None in Python'
            ) from error

    def _corner_loop_of(self, net: CableNet) -> IntArray | None:
        if self._loop is None or self.corners is None:
            return None
        if self.corners == "corners" and self.corners not in net.node_groups:
            return None
        if len(net.nodes_of(self.corners)) < 3:
            return None
        return corners_of(net, self._loop, self.corners)

    def _met(self, state: State) -> tuple[float, ...]:
        """Contact at an internal step, as the history has it, with sums up to it."""
        if self._meeting is None:
            return (math.nan,) * 6
        met = self._meeting.at(state)
        self._sums = self._sums + self._share(state.t, met)
        self._rates = state.t, _rates_of(met)
        return (met.gap, met.normal, met.stored, *self._sums.tolist())

    def _share(self, t: float, met: Contacts) -> FloatArray:
        """What the sums have gained since: dissipated energy, friction's share, normal impulse, (3,)."""
        since, rates = self._rates
        return np.zeros(3) if math.isnan(since) else 0.5 * (t - since) * (rates + _rates_of(met))

    def _start(self, state: State) -> None:
        system, x, v, balance = self._system, state.x, state.v, state.balance
        system.take(state)
        self._direction = self._measurements.direction_of(v)
        self._start_com = self._measurements.centre_of(x)
        self._start_momenta = self._momenta_less_impulses(state)
        energy = system.kinetic_energy(v) + system.elastic_energy(x)
        self._start_total = energy + balance.dissipated_energy - balance.external_work
        self._started = True

    def _momenta_less_impulses(self, state: State) -> FloatArray:
        """Momentum and angular momentum less external impulses, (2, 3): what the flight conserves."""
        system, balance = self._system, state.balance
        momenta = np.stack((system.momentum(state.v), system.angular_momentum(state.x, state.v)))
        return momenta - np.stack((balance.external_impulse, balance.external_angular_impulse))

    def _momentum_errors(self, state: State) -> tuple[float, float]:
        """Residuals of momentum in N s and of angular momentum in N m s."""
        errors = self._momenta_less_impulses(state) - self._start_momenta
        return float(np.linalg.norm(errors[0])), float(np.linalg.norm(errors[1]))

    def _distance_to(self, com: FloatArray) -> float:
        way = com - self._start_com
        if self._direction is None:
            return float(np.sqrt(way @ way))
        return float(way @ self._direction)


def _rates_of(met: Contacts) -> FloatArray:
    return np.array((met.dissipated, met.friction, met.normal))


def _area_of(x: FloatArray, loop: IntArray | None) -> float:
    return np.nan if loop is None else vector_area(x.take(loop, axis=0))
