"""Measures of a deployment: a row of metrics.csv per frame, and the histories that its summary stands on."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import njit

from netdae._arrays import BoolArray, FloatArray, IntArray
from netdae.errors import InputError
from netdae.figures import HISTORY, figures_of
from netdae.forces.cables import law_of, own_strain_of, strain_of
from netdae.mouth import corners_of, mouth_of, vector_area
from netdae.state import State

if TYPE_CHECKING:
    from netdae.net import CableNet
    from netdae.system import System

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
)
"""Columns of metrics.csv, SI units."""


class DeploymentMetrics:
    """Observer that measures a flight: a row per frame, and a summary of all internal steps.

    mouth : name of the group whose closed loop is the net's mouth, see `mouth.mouth_of`; None for a net
        without one
    corners : name of the node group of the corners, see `mouth.corners_of`; None for none. A net without a
        mouth, without the default group or with fewer than three corners has no corner area.

    The columns of a row:

    mouth_area, corner_area : vector areas, m²; nan where there is none
    distance : of the centre of mass from its start along the initial momentum, m; the straight distance
        where the start has no momentum
    energy_residual : (kinetic + elastic + dissipated − external work) − its start, J
    max_tension : the largest at internal steps since the row before, N; without the dashpot's share
    taut_fraction : share of the cables that are taut
    """

    def __init__(self, *, mouth: str | None = "border", corners: str | None = "corners") -> None:
        self.mouth = mouth
        self.corners = corners
        self.rows: list[tuple[float, ...]] = []
        self._history = array("d")

    def begin(self, system: System) -> None:
        """Find the loops; raises InputError if the mouth is not one closed loop, and says how to do without."""
        net = system.net
        self._system = system
        self._loop = self._mouth_loop_of(net)
        self._corner_loop = self._corner_loop_of(net)
        self._share_of_mass = system.mass / system.mass.sum()
        self._has_strength = bool(np.isfinite(system.strength).any())
        self._has_toe = bool((system.toe_strain > 0).any())
        cables = system.cables
        self._cords = (
            system.mass,
            cables.nodes,
            cables.L,
            cables.EA,
            cables.eps,
            cables.engineering,
            system.strength,
        )
        self._started = False
        self.rows = []
        self._history = array("d")

    def __call__(self, state: State) -> None:
        """Add the row of a frame."""
        self.rows.append(self.row_of(state))

    def watch(self, state: State) -> None:
        """Take an internal step into the summary."""
        if not self._started:
            self._start(state)
        x, books = state.x, state.books
        measured = _measured(x, state.v, *self._cords)
        self._history.extend(
            (
                state.t,
                _area_of(x, self._loop),
                _area_of(x, self._corner_loop),
                self._distance_to(self._share_of_mass @ x),
                books.dissipated_energy,
                books.external_work,
                *measured,
            )
        )

    def row_of(self, state: State) -> tuple[float, ...]:
        """Row of `COLUMNS` for a State of the flight; the first State seen is the start."""
        if not self._started:
            self._start(state)
        system, x, v, books = self._system, state.x, state.v, state.books
        kinetic, elastic = system.kinetic_energy(v), system.elastic_energy(x)
        com = self._share_of_mass @ x
        total = kinetic + elastic + books.dissipated_energy - books.external_work
        row = (
            state.t,
            _area_of(x, self._loop),
            _area_of(x, self._corner_loop),
            self._distance_to(com),
            *com,
            kinetic,
            elastic,
            books.dissipated_energy,
            books.external_work,
            total - self._start_total,
            *system.momentum(v),
            *system.angular_momentum(x, v),
            books.peak_tension,
            np.count_nonzero(system.strain(x) > 0) / system.net.cable_count,
        )
        return tuple(map(float, row))

    def table(self) -> dict[str, FloatArray]:
        """The rows so far as column name to (k,)."""
        columns = np.array(self.rows, dtype=np.float64).reshape(len(self.rows), len(COLUMNS))
        return dict(zip(COLUMNS, columns.T.copy(), strict=True))

    def summary(self) -> dict[str, Any]:
        """Figures of the flight from all internal steps, SI units, and `warnings`, a list of sentences.

        The number of frames changes none of them. Figures that a net does not have (of mouth, corners,
        strength, toe) are left out. largest_..., peak_... and final_... are values at internal steps; their
        times and distances follow in keys of their own.
        tension_quantile_99_9 : N, the largest tension of the net stays below it for 99.9 % of the time
        tension_over_strength : the same of the largest ratio of tension to strength
        energy_residual_share, energy_rise_share : of largest_energy, the largest kinetic + elastic energy
        """
        if not self._history:
            raise RuntimeError("no internal step was watched: give the metrics to simulate() as an observer")
        columns = np.array(self._history).reshape(-1, len(HISTORY)).T
        return figures_of(
            dict(zip(HISTORY, columns, strict=True)),
            mouth=self._loop is not None,
            corners=self._corner_loop is not None,
            strength=self._has_strength,
            toe=self._has_toe,
        )

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

    def _start(self, state: State) -> None:
        system, x, v, books = self._system, state.x, state.v, state.books
        momentum = system.momentum(v)
        size = np.linalg.norm(momentum)
        # what is left of moments that cancel is round-off and has no direction
        moving = size > 1e-9 * (system.mass @ np.linalg.norm(v, axis=1))
        self._direction = momentum / size if moving else None
        self._start_com = self._share_of_mass @ x
        energy = system.kinetic_energy(v) + system.elastic_energy(x)
        self._start_total = energy + books.dissipated_energy - books.external_work
        self._started = True

    def _distance_to(self, com: FloatArray) -> float:
        way = com - self._start_com
        if self._direction is None:
            return float(np.sqrt(way @ way))
        return float(way @ self._direction)


@njit(cache=True)
def _measured(
    x: FloatArray,
    v: FloatArray,
    mass: FloatArray,
    nodes: IntArray,
    L: FloatArray,
    EA: FloatArray,
    eps: FloatArray,
    engineering: BoolArray,
    strength: FloatArray,
) -> tuple[float, float, float, float, float, float, float, float, float, float]:
    """What `HISTORY` names from kinetic_energy on, in one pass: System's own methods take five times as long."""
    kinetic = elastic = 0.0
    for i in range(len(mass)):
        kinetic += 0.5 * mass[i] * (v[i, 0] * v[i, 0] + v[i, 1] * v[i, 1] + v[i, 2] * v[i, 2])
    tension = load = multiple = 0.0
    strain = -np.inf
    tension_cable = load_cable = taut_count = toe_count = 0
    for e in range(len(L)):
        i, j = nodes[e]
        E11 = strain_of(x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2], L[e])
        strain = max(strain, E11)
        if E11 <= 0.0:
            continue
        g, _, _, energy = law_of(E11, eps[e], engineering[e])
        elastic += EA[e] * L[e] * energy
        N = EA[e] * g * np.sqrt(1.0 + 2.0 * E11)
        if tension < N:
            tension, tension_cable = N, e
        if load * strength[e] < N:  # never for an infinite strength
            load, load_cable = N / strength[e], e
        if eps[e] > 0.0:
            taut_count += 1
            own = own_strain_of(E11, engineering[e])
            toe_count += eps[e] > own
            multiple = max(multiple, own / eps[e])
    return (
        kinetic,
        elastic,
        tension,
        float(tension_cable),
        load,
        float(load_cable),
        strain,
        multiple,
        float(taut_count),
        float(toe_count),
    )


def _area_of(x: FloatArray, loop: IntArray | None) -> float:
    return np.nan if loop is None else vector_area(x.take(loop, axis=0))
