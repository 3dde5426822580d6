"""The methods that fly the same law on netdae's own compiled kernels: netdae's, SciPy's, plain IDA's."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from benchmark_flight import Clock, Flight
from benchmark_others import NotAvailable, fly_exudyn, fly_mujoco
from benchmark_verlet import Flown, fly_verlet
from scipy import sparse
from scipy.integrate import solve_ivp
from sksundae.ida import IDA

import netdae as nd

PARTS = (0.8, 0.5, 0.25)
ALL = ("dashpot", "weak", "strong")
LOOKS = 10  # times a quarter at which netdae's methods are asked for a frame, and so the clock is looked at
MANY = 2000  # cables from which they are; on smaller nets they give four frames, as the others do
DENSE_LOOKS = 100  # the same for plain IDA, whose steps are slow


class Rung(NamedTuple):
    """Tolerances of an implicit or adaptive method: rtol, m and m/s."""

    rtol: float
    position: float
    velocity: float

    def __str__(self) -> str:
        """As tables show it."""
        return f"{self.rtol:.0e}, {self.velocity:.0e} m/s".replace("e-0", "e-")

    @property
    def weights(self) -> tuple[float, float]:
        """Absolute tolerances of x and v."""
        return self.position, self.velocity


STANDARD = Rung(1e-4, 1e-5, 3e-4)
# netdae's presets, and two between fast and standard: the velocities decide what a flight costs and what it keeps
RUNGS = tuple(
    Rung(*each)
    for each in (
        (1e-3, 1e-4, 1e-2),
        (1e-3, 1e-4, 1e-3),
        (1e-3, 1e-4, 3e-4),
        STANDARD,
        (1e-5, 1e-6, 1e-4),
    )
)


# netdae


def _fly_netdae(flight: Flight, options: nd.SolverOptions, clock: Clock) -> Flown:
    looks = LOOKS if flight.system.net.cable_count > MANY else 1
    times = np.linspace(0.0, flight.end, len(flight.times) * looks + 1)
    start = nd.State.at(flight.x, flight.v)
    positions, velocities = [], []
    clock.start()
    run = nd.integrate(flight.system, start, times, options=options)
    for k, state in enumerate(run):
        clock.check(state.t)
        if k and k % looks == 0:
            positions.append(state.x)
            velocities.append(state.v)
    clock.stop()
    statistics = dict(run.statistics)
    statistics.update(
        {f"{name}_seconds": value for name, value in statistics.pop("wall_seconds", {}).items()}
    )
    return positions, velocities, statistics


def fly_ida(flight: Flight, rung: Rung, clock: Clock) -> Flown:
    """Netdae's IDA with its condensed direct solve."""
    options = nd.SolverOptions(rtol=rung.rtol, atol_position=rung.position, atol_velocity=rung.velocity)
    return _fly_netdae(flight, options, clock)


def fly_explicit(flight: Flight, accuracy: str, clock: Clock) -> Flown:
    """Netdae's explicit method."""
    asked: dict[str, Any] = {"method": "explicit", "accuracy": accuracy}
    try:
        options = nd.SolverOptions(**asked)
    except TypeError:
        raise NotAvailable("this netdae has no explicit method") from None
    return _fly_netdae(flight, options, clock)


# The same equations for other integrators: y = (x, v) raveled


class Equations:
    """Rates, residual and sparse Jacobian of a flight from netdae's compiled kernels."""

    def __init__(self, flight: Flight, clock: Clock) -> None:
        self._system, self._clock = flight.system, clock
        self._mass = np.repeat(flight.system.mass, 3)
        self._place_entries(len(self._mass))

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        """ẏ = (v, f/M); looks at the clock."""
        self._clock.check(t)
        x, v = y.reshape(2, -1, 3)
        return np.concatenate((v.ravel(), self._system.force(t, x, v).ravel() / self._mass))

    def residual(self, t: float, y: np.ndarray, yp: np.ndarray, res: np.ndarray) -> None:
        """F₁ = ẋ − v, F₂ = M v̇ − f; without the clock: SuperLU_MT crashes where a callback raises."""
        (x, v), (dx, dv), F = y.reshape(2, -1, 3), yp.reshape(2, -1, 3), res.reshape(2, -1, 3)
        F[0] = dx - v
        F[1] = self._system.mass[:, None] * dv - self._system.force(t, x, v)

    def _place_entries(self, n: int) -> None:
        """Where all entries of ∂(ẋ − v, M v̇ − f)/∂y + c_j ∂/∂ẏ stand in CSC data, by column and then by row."""
        index = np.arange(n)
        places = [(index, index), (index, n + index), (n + index, n + index)]  # c_j I, −I, c_j M
        for shift in (0, n):  # −∂f/∂x, −∂f/∂v
            for force in self._system.forces:
                dof = (3 * force.nodes[:, :, None] + np.arange(3)).reshape(len(force.nodes), -1)
                row, column = np.broadcast_arrays(dof[:, :, None], dof[:, None, :])
                places.append((n + row, shift + column))
        keys = [column.astype(np.int64) * (2 * n) + row for row, column in places]
        present = np.unique(np.concatenate([key.ravel() for key in keys]))
        self._places = [np.searchsorted(present, key) for key in keys]
        indptr = np.searchsorted(present, 2 * n * np.arange(2 * n + 1))
        ones = np.ones(len(present))
        self.pattern = sparse.csc_matrix((ones, present % (2 * n), indptr), shape=(2 * n, 2 * n))

    def jacobian_data(self, t: float, y: np.ndarray, cj: float) -> np.ndarray:
        """CSC data of J in the order of `pattern`."""
        x, v = y.reshape(2, -1, 3)
        n, forces = len(self._mass), self._system.forces
        tangents = [force.tangent(t, x[force.nodes], v[force.nodes]) for force in forces]
        dx, dv = self._places[3 : 3 + len(forces)], self._places[3 + len(forces) :]
        places = [*self._places[:3]]
        places += [
            at[tangent.elements] for part in (dx, dv) for at, tangent in zip(part, tangents, strict=True)
        ]
        values = [np.full(n, cj), np.full(n, -1.0), cj * self._mass]
        values += [-tangent.dx for tangent in tangents] + [-tangent.dv for tangent in tangents]
        return np.bincount(_flat(places), _flat(values), self.pattern.nnz)

    def rates_jacobian(self, t: float, y: np.ndarray) -> sparse.csc_matrix:
        """∂ẏ/∂y = [[0, I], [−M⁻¹T, −M⁻¹D]]."""
        n = len(self._mass)
        scale = -1.0 / np.concatenate((np.ones(n), self._mass))
        data = self.jacobian_data(t, y, 0.0) * scale[self.pattern.indices]
        return sparse.csc_matrix((data, self.pattern.indices, self.pattern.indptr), shape=self.pattern.shape)


def _flat(arrays: list[np.ndarray]) -> np.ndarray:
    return np.concatenate([array.ravel() for array in arrays])


def _columns(rows: list[np.ndarray]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    parts = [row.reshape(2, -1, 3) for row in rows]
    return [part[0] for part in parts], [part[1] for part in parts]


def _weights(flight: Flight, position: float, velocity: float) -> np.ndarray:
    return np.repeat([position, velocity], flight.x.size)


def scipy_flyer(name: str) -> Callable[[Flight, float, Clock], Flown]:
    """One of `solve_ivp`'s methods; the implicit ones get the analytic sparse Jacobian."""

    def fly(flight: Flight, rung: Rung, clock: Clock) -> Flown:
        equations = Equations(flight, clock)
        implicit = {"jac": equations.rates_jacobian} if name in ("BDF", "Radau") else {}
        y0 = np.concatenate((flight.x.ravel(), flight.v.ravel()))
        clock.start()
        solution = solve_ivp(
            equations.rates,
            (0.0, flight.end),
            y0,
            method=name,
            t_eval=flight.times,
            rtol=rung.rtol,
            atol=_weights(flight, *rung.weights),
            **implicit,
        )
        clock.stop()
        if not solution.success:
            raise RuntimeError(solution.message)
        counts = {"residuals": solution.nfev, "setups": solution.njev, "factors": solution.nlu}
        return *_columns(list(solution.y.T)), counts

    return fly


def ida_flyer(linsolver: str) -> Callable[[Flight, float, Clock], Flown]:
    """IDA as scikit-sundae offers it: SuperLU_MT on the full system, or GMRES without a preconditioner."""

    def fly(flight: Flight, rung: Rung, clock: Clock) -> Flown:
        equations = Equations(flight, clock)
        counts = {"setups": 0}

        def jacobian(t: float, y: np.ndarray, yp: Any, res: Any, cj: float, data: np.ndarray) -> None:
            counts["setups"] += 1
            data[:] = equations.jacobian_data(t, y, cj)

        direct = {"sparsity": equations.pattern, "jacfn": jacobian} if linsolver == "sparse" else {}
        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore"
            )  # that the sparsity is ignored beside jacfn: the data go by its order
            ida = IDA(
                equations.residual,
                rtol=rung.rtol,
                atol=_weights(flight, *rung.weights),
                linsolver=linsolver,
                max_num_steps=10**9,
                **direct,
            )
        y0 = np.concatenate((flight.x.ravel(), flight.v.ravel()))
        rows = []
        clock.start()
        ida.init_step(0.0, y0, equations.rates(0.0, y0))
        for k in range(1, len(flight.times) * DENSE_LOOKS + 1):
            t = k / (len(flight.times) * DENSE_LOOKS) * flight.end
            result = ida.step(t, method="normal")
            if not result.success:
                raise RuntimeError(result.message)
            clock.check(t)
            if k % DENSE_LOOKS == 0:
                rows.append(result.y.copy())
        clock.stop()
        return *_columns(rows), {"residuals": result.nfev, **counts}

    return fly


@dataclass(frozen=True)
class Method:
    """A way to fly, with its ladder from loose to tight.

    ladder : values that `fly` takes: tolerances, part of the stable step, or preset
    own : netdae's, or the yardstick: it gets twice the limit, for its time is what is wanted
    dampings : with which it flies unless it is asked for by name: "dashpot", Rayleigh's "weak" and "strong"
    differs : in what, from the same law at the same net
    """

    name: str
    title: str
    ladder: tuple[Any, ...]
    fly: Callable[[Flight, Any, Clock], Flown]
    toe: float = 0.0
    own: bool = False
    dampings: tuple[str, ...] = ("dashpot",)
    differs: str = ""


METHODS = {
    method.name: method
    for method in (
        Method("verlet", "hand-written Verlet (frozen)", (0.5,), fly_verlet, own=True, dampings=ALL),
        Method("explicit", "netdae explicit", ("fast", "standard", "accurate"), fly_explicit, own=True, dampings=ALL),
        Method("ida", "netdae IDA, sharp", RUNGS, fly_ida, own=True, dampings=ALL),
        Method("ida-toe", "netdae IDA, toe 5e-5", RUNGS, fly_ida, toe=5e-5, own=True, dampings=ALL,
               differs="a smoothed law, judged by the sharp one"),
        Method("rk45", "SciPy RK45", RUNGS, scipy_flyer("RK45"), dampings=("dashpot", "weak")),
        Method("dop853", "SciPy DOP853", RUNGS, scipy_flyer("DOP853"), dampings=("dashpot", "weak")),
        Method("bdf", "SciPy BDF, sparse Jacobian", RUNGS, scipy_flyer("BDF"), dampings=("dashpot", "strong")),
        Method("radau", "SciPy Radau, sparse Jacobian", RUNGS, scipy_flyer("Radau"), dampings=("dashpot", "strong")),
        Method("ida-gmres", "IDA, plain GMRES", RUNGS, ida_flyer("gmres")),
        Method("ida-sparse", "IDA, SuperLU_MT, full system", RUNGS, ida_flyer("sparse")),
        Method("exudyn", "Exudyn, velocity Verlet", PARTS, fly_exudyn,
               differs="the same law, by a symbolic user function of its spring-dampers"),
        Method("mujoco", "MuJoCo, tendons that only pull", PARTS, fly_mujoco,
               differs="linear in the length, not in E11 (1.5 times the strain less force); "
               "its dashpot acts a hair before the cable is taut"),
    )
}  # fmt: skip
