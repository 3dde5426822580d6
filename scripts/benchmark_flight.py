"""The reference flight that all methods fly, and what a flight is judged by.

A 5 m square net of 1 mm cord, drawn together to 0.4, its four 0.5 kg corners shot at 2.5 m/s and 45°; every
start is disturbed by 1e-10 m of its own seed. Symbols: n knots, m cables, k times, x, v (n, 3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from time import perf_counter

import numpy as np

import netdae as nd

SIDE, MODULUS, DENSITY, DIAMETER, BULLET = 5.0, 70e9, 1390.0, 1e-3, 0.5
DISTURBANCE = 1e-10  # m; the symmetric start is 20 % cheaper, and no real one is symmetric
QUARTERS = 4  # a flight is measured after each quarter of its end


@dataclass(frozen=True)
class Case:
    """A damping: the dashpot's viscosity time `tau` in s, or Rayleigh's `beta` in s."""

    name: str
    tau: float = 0.0
    beta: float = 0.0

    @property
    def damping(self) -> nd.Dashpot | nd.Rayleigh:
        """The same for netdae."""
        return nd.Rayleigh(beta=self.beta) if self.beta else nd.Dashpot(viscosity_time=self.tau)


CASES = {
    case.name: case
    for case in (
        Case("dashpot", tau=1e-5),
        Case("rayleigh-1e-5", beta=1e-5),
        Case("rayleigh-1e-4", beta=1e-4),
        Case("rayleigh-1e-3", beta=1e-3),
    )
}


@dataclass(frozen=True, eq=False)
class Flight:
    """One flight to fly: the net with its law, a start (x, v), and the end in s."""

    case: Case
    system: nd.System
    x: np.ndarray
    v: np.ndarray
    end: float

    @classmethod
    def of(
        cls,
        knots: int,
        case: Case,
        *,
        seed: int,
        end: float,
        toe: float = 0.0,
        scale: float = 0.4,
        state: tuple[np.ndarray, np.ndarray] | None = None,
    ) -> Flight:
        """The flight with `knots` knots a side, its start disturbed with that seed.

        The start is the reference flight's, drawn together by `scale`, or the `state` (x, v).
        """
        net = nd.CableNet.square(side=SIDE, cells=knots - 1)
        cord = nd.Material(youngs_modulus=MODULUS, density=DENSITY, diameter=DIAMETER, toe_strain=toe)
        system = nd.System(net, cord, masses={"corners": BULLET}, damping=case.damping)
        if state is None:
            _, start = nd.scaled(net, [scale, scale, 1.0])
            start = nd.ejected(net, start, "corners", speed=2.5, half_angle_deg=45.0)
            state = start.x, start.v
        x, v = state
        noise = DISTURBANCE * np.random.default_rng(seed).standard_normal(x.shape)
        return cls(case, system, x + noise, v, end)

    @property
    def times(self) -> np.ndarray:
        """The instants at which a flight is measured, (k,), s."""
        return self.end * np.arange(1, QUARTERS + 1) / QUARTERS

    def measures(self, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Bullets (12,), m, mouth area, m², and kinetic + elastic energy, J, in one row (14,)."""
        net = self.system.net
        if not (np.isfinite(x).all() and np.isfinite(v).all()):
            return np.full(14, np.nan)
        energy = self.system.kinetic_energy(v) + self.system.elastic_energy(x)
        area = nd.vector_area(x[nd.mouth_of(net, "border")])
        return np.array([*x[net.nodes_of("corners")].ravel(), area, energy])

    def frequency(self) -> float:
        """Bound on the largest frequency of the spread net with all cables taut, rad/s.

        Gershgorin's, of M⁻¹ K₀: of long lines of equal knots it is the frequency itself.
        """
        cords, net = self.system.cords, self.system.net
        stiffness = np.zeros((2, net.node_count))  # of the cables along x and along y
        along = np.argmax(np.abs(net.nodes[net.cables[:, 1]] - net.nodes[net.cables[:, 0]]), axis=1)
        for end in net.cables.T:
            np.add.at(stiffness, (along, end), cords.axial_stiffness / net.rest_length)
        return math.sqrt((2 * stiffness / self.system.mass).max())

    def stable_step(self) -> float:
        """Largest stable step of a Verlet whose damping takes the velocity half a step back, s."""
        omega = self.frequency()
        zeta = 0.5 * omega * (self.case.tau + self.case.beta)
        return 2 / omega * (math.sqrt(1 + zeta**2) - zeta)


class TimeUp(Exception):  # noqa: N818, it ends a run as StopIteration ends a loop
    """A run that went over its limit, or that at its pace would go far over it."""


class Clock:
    """Takes the wall time of one run and ends it by TimeUp when it is over its limit of seconds.

    HOPELESS: after a sixth of the limit a run ends whose pace so far would take it past twice the limit.
    """

    HOPELESS = 2.0
    FAIR_TRIAL = 1 / 6

    def __init__(self, limit: float, end: float) -> None:
        self._limit = limit
        self._end = end
        self._begin = perf_counter()
        self._seconds: float | None = None
        self.reached = 0.0

    def start(self) -> None:
        """Begin to count: what comes before is the building of models."""
        self._begin = perf_counter()

    def stop(self) -> None:
        """The flight has been flown."""
        self._seconds = self.seconds

    @property
    def seconds(self) -> float:
        """Wall seconds from start to stop, or up to now."""
        return perf_counter() - self._begin if self._seconds is None else self._seconds

    @property
    def projected(self) -> float:
        """Seconds for the whole flight at the pace so far."""
        return self.seconds * self._end / self.reached if self.reached > 0 else math.inf

    def check(self, t: float) -> None:
        """To be called now and then with the time of the flight; raises TimeUp."""
        self.reached = max(self.reached, t)
        seconds = self.seconds
        if seconds > self._limit or (
            seconds > self.FAIR_TRIAL * self._limit and self.projected > self.HOPELESS * self._limit
        ):
            raise TimeUp
