"""Other codes on the same net: MuJoCo and Exudyn, where they are installed (`pip install netdae[benchmark]`).

Both take explicit steps on one thread, at a quarter of the stable step of a Verlet; the building of their models is
not counted. MuJoCo's cables are springs that only pull, k (l − L), which differ from Eq. (4) in force by 1.5 times the
strain; Exudyn's have the law of Eq. (4). What is compared is what a chaotic flight keeps: bullets, mouth and energy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from time import perf_counter
from typing import NamedTuple

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.initial.scaled import ejected, scaled
from netdae.model.material import Material
from netdae.model.mouth import mouth_of, vector_area
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.runs.verification.peer_models import NotAvailable, PeerFlight, fly_exudyn, fly_mujoco
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot
from netdae.system.system import System

TAU, PART = 1e-5, 0.25  # viscosity time of the dashpot, s; part of the stable step
ABOUT_PEERS = (
    "A 5 m net of 1 mm cord with a dashpot of 1e-5 s, drawn together to 0.4, shot by its corners of 0.5 kg at 2.5 m/s "
    "and 45 degrees. Differences are from netdae by IDA, accurate: the largest of a bullet's place at the end, mouth "
    "area, and kinetic and elastic energy. MuJoCo (tendons whose actuators only pull, semi-implicit Euler) and Exudyn "
    "(springs with a user's law, velocity Verlet) take a quarter of the stable step of a Verlet, on one thread; "
    "seconds are those of the steps alone, without building a model and, of netdae, without compiling."
)


class PeerRow(NamedTuple):
    """A code's flight beside netdae's, or why there is none."""

    words: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Net:
    """The net that all codes fly, its start, and the end, s."""

    system: System
    start: State
    end: float

    @classmethod
    def of(cls, cells: int, end: float) -> Net:
        """The reference flight with that many meshes a side; the start is disturbed by 1e-10 m."""
        net, start = scaled(CableNet.square(side=5.0, cells=cells), (0.4, 0.4, 1.0))
        start = ejected(net, start, "corners", speed=2.5, half_angle_deg=45.0)
        cord = Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)
        system = System(net, cord, masses={"corners": 0.5}, damping=Dashpot(viscosity_time=TAU))
        x = start.x + 1e-10 * np.random.default_rng(0).standard_normal(start.x.shape)
        return cls(system, State.at(x, start.v), end)

    def stable_step(self) -> float:
        """Largest stable step of a Verlet whose damping takes the velocity half a step back, s.

        The frequency is Gershgorin's bound on M⁻¹ K₀ of the spread net.
        """
        net, cords, mass = self.system.net, self.system.cords, self.system.mass
        stiffness = np.zeros((2, net.node_count))  # of the cables along x and along y
        along = np.argmax(np.abs(net.nodes[net.cables[:, 1]] - net.nodes[net.cables[:, 0]]), axis=1)
        for side in net.cables.T:
            np.add.at(stiffness, (along, side), cords.axial_stiffness / net.rest_length)
        omega = math.sqrt(float((2 * stiffness / mass).max()))
        zeta = 0.5 * omega * TAU
        return 2 / omega * (math.sqrt(1 + zeta**2) - zeta)

    def figures(self, x: FloatArray, v: FloatArray) -> tuple[FloatArray, float, float]:
        """Bullets (4, 3), m, mouth area, m², and kinetic and elastic energy, J."""
        net = self.system.net
        area = float(np.linalg.norm(vector_area(x[mouth_of(net, "border")])))
        energy = self.system.kinetic_energy(v) + self.system.elastic_energy(x)
        return x[net.nodes_of("corners")], area, float(energy)


class _Watch:
    """Takes the seconds of the steps."""

    def __init__(self) -> None:
        self._begin = self.seconds = 0.0

    def start(self) -> None:
        self._begin = perf_counter()

    def check(self, t: float) -> None:
        """Nothing ends these flights."""

    def stop(self) -> None:
        self.seconds = perf_counter() - self._begin


def peers_flown(*, quick: bool) -> tuple[PeerRow, ...]:
    """A row each for netdae's methods, MuJoCo and Exudyn; one line for a code that is not installed."""
    net = Net.of(*((6, 0.3) if quick else (10, 0.5)))
    rows, reference = [], None
    for method in ("ida", "explicit"):
        options = SolverOptions("ida" if method == "ida" else "explicit", accuracy="accurate")
        simulate(net.system, net.start, [0.0, 1e-4], options=options)  # compiles
        began = perf_counter()
        flight = simulate(net.system, net.start, [0.0, net.end], options=options)
        seconds = perf_counter() - began
        figures = net.figures(flight[-1].x, flight[-1].v)
        reference = reference or figures
        rows.append(
            _row(f"netdae {method}", "accurate", figures, reference, flight.statistics["steps"], seconds)
        )
    assert reference is not None
    flight_of_peers = PeerFlight(
        net.system, net.start.x, net.start.v, (net.end,), PART * net.stable_step(), tau=TAU
    )
    for name, fly in (("MuJoCo", fly_mujoco), ("Exudyn", fly_exudyn)):
        watch = _Watch()
        try:
            positions, velocities, counts = fly(flight_of_peers, watch)
        except NotAvailable as reason:
            words = f"{reason}: pip install netdae[benchmark]"
            rows.append(PeerRow((name, words, *["not flown"] * 5)))
            continue
        figures = net.figures(positions[-1], velocities[-1])
        settings = f"steps of {flight_of_peers.step:.2g} s"
        rows.append(_row(name, settings, figures, reference, counts["steps"], watch.seconds))
    return tuple(rows)


def _row(
    name: str,
    settings: str,
    figures: tuple[FloatArray, float, float],
    reference: tuple[FloatArray, float, float],
    steps: int,
    seconds: float,
) -> PeerRow:
    bullets = 1e3 * float(np.linalg.norm(figures[0] - reference[0], axis=1).max())
    mouth, energy = (100 * abs(figures[k] / reference[k] - 1) for k in (1, 2))  # type: ignore[operator]
    return PeerRow(
        (name, settings, f"{bullets:.2g}", f"{mouth:.2g}", f"{energy:.2g}", f"{steps}", f"{seconds:.2f}")
    )
