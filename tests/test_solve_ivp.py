"""Flights against SciPy's integrators on the paper's equations, written out here in plain NumPy."""

import numpy as np
import pytest
from numpy.random import default_rng
from scipy.integrate import solve_ivp

from netdae.forces.loads import Gravity
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping, Rayleigh
from netdae.system.system import System

E, RHO, DIAMETER = 1e7, 1000.0, 2e-3  # a rubber cord: the waves of a 1 m net take 10 ms
AREA = np.pi / 4 * DIAMETER**2
BULLET = 0.02


def equations(net, *, tau=0.0, alpha=0.0, beta=0.0, eps=0.0, g=0.0, held=()):
    """ẏ of y = (x, v) by Eqs. (3) to (10), cable by cable; `held` nodes stand still."""
    i, j = net.cables.T
    L, n = net.rest_length, net.node_count
    mass = np.zeros(n)
    np.add.at(mass, i, 0.5 * RHO * AREA * L)  # Eq. (7)
    np.add.at(mass, j, 0.5 * RHO * AREA * L)
    mass[net.nodes_of("corners")] += BULLET
    direction = net.nodes[j] - net.nodes[i]
    direction = direction / np.linalg.norm(direction, axis=1)[:, None]
    free = np.ones((n, 1))
    free[list(held)] = 0.0

    def rates(t, y):
        x, v = y.reshape(2, n, 3)
        d, w = x[j] - x[i], v[j] - v[i]
        E11 = 0.5 * (np.sum(d * d, axis=1) - L**2) / L**2  # Eq. (3)
        rate = np.sum(d * w, axis=1) / L**2
        if eps:
            stress = np.where(E11 < eps, E * E11**2 / (2 * eps), E * (E11 - eps / 2))
            slope = np.where(E11 < eps, E * E11 / eps, E)
        else:
            stress, slope = E * E11, np.full_like(E11, E)
        S11 = np.where(E11 >= 0, np.maximum(stress + tau * slope * rate, 0.0), 0.0)  # Eq. (4) and the dashpot
        pull = (S11 * AREA / L)[:, None] * d  # Eq. (5)
        pull += (beta * E * AREA / L * np.sum(direction * w, axis=1))[:, None] * direction  # Eq. (9)
        force = -alpha * mass[:, None] * v
        force[:, 2] -= g * mass
        np.add.at(force, i, pull)
        np.add.at(force, j, -pull)
        return np.concatenate(((v * free).ravel(), (force / mass[:, None] * free).ravel()))  # Eq. (10)

    return rates


def three_by_three(seed, *, damping, toe=0.0, loads=(), held=()):
    """1 m net of 3 × 3 nodes with bullets, 5 % slack, each node at some 2 m/s in a random direction."""
    square = CableNet.square(side=1.0, cells=2)
    net = CableNet(square.nodes, square.cables, {"corners": square.nodes_of("corners"), "held": list(held)})
    cord = Material(youngs_modulus=E, density=RHO, diameter=DIAMETER, toe_strain=toe)
    system = System(
        net,
        cord,
        damping=damping,
        masses={"corners": BULLET},
        loads=loads,
        restraints=[Restraint("held")] if held else [],
    )
    v = 2.0 * default_rng(seed).standard_normal(net.nodes.shape)
    v[list(held)] = 0.0
    return system, State.at(0.95 * net.nodes, v)


def tight(rtol):
    """Absolute tolerances follow rtol: positions are some 0.1 m, velocities some 10 m/s."""
    return SolverOptions(rtol=rtol, atol_position=0.1 * rtol, atol_velocity=10 * rtol)


def reference(rates, start, end, method="DOP853", rtol=1e-10, **more):
    y0 = np.concatenate((start.x.ravel(), start.v.ravel()))
    return solve_ivp(rates, (0.0, end), y0, method=method, rtol=rtol, atol=1e-2 * rtol, **more)


def switches(net, solution, end):
    """How often a cable goes taut or slack, from a dense solution on 5 µs."""
    times = np.linspace(0.0, end, int(end / 5e-6) + 1)
    x = solution.sol(times)[: 3 * net.node_count].T.reshape(len(times), -1, 3)
    length = np.linalg.norm(x[:, net.cables[:, 1]] - x[:, net.cables[:, 0]], axis=2)
    return int(np.sum(np.diff(length >= net.rest_length, axis=0)))


CASES = {
    "undamped": ({"damping": NoDamping()}, {}),
    "dashpot": ({"damping": Dashpot(viscosity_time=1e-4)}, {"tau": 1e-4}),
    "rayleigh, toe": (
        {"damping": Rayleigh(alpha=1.0, beta=1e-4), "toe": 0.01},
        {"alpha": 1.0, "beta": 1e-4, "eps": 0.01},
    ),
    "hanging": (
        {"damping": Dashpot(viscosity_time=1e-4), "loads": [Gravity([0, 0, -9.81])], "held": [0, 2]},
        {"tau": 1e-4, "g": 9.81, "held": [0, 2]},
    ),
}  # fmt: skip


@pytest.mark.parametrize("method", ["DOP853", "Radau"])
@pytest.mark.parametrize("name", CASES)
def test_flights_agree_with_scipy(name, method):
    build, physics = CASES[name]
    end = 0.06 if method == "DOP853" else 0.03  # Radau takes 1 s for the latter
    system, start = three_by_three(3, **build)
    solution = reference(equations(system.net, **physics), start, end, method, dense_output=True)
    assert switches(system.net, solution, end) >= (5 if method == "DOP853" else 2)
    flight = simulate(system, start, [0.0, 0.5 * end, end], options=tight(1e-10))
    for frame in flight:
        x = solution.sol(frame.t)[: start.x.size].reshape(start.x.shape)
        size = np.abs(x).max()
        np.testing.assert_allclose(frame.x, x, rtol=0, atol=1e-6 * size)


@pytest.mark.parametrize("seed", [0, 1])
def test_the_error_falls_with_rtol(seed):
    """Log-log slope between 0.7 and 1.3, without reversal, over six decades of rtol."""
    end = 0.1
    system, start = three_by_three(seed, damping=NoDamping())
    solution = reference(equations(system.net), start, end, rtol=1e-12, dense_output=True)
    assert switches(system.net, solution, end) >= 5
    x = solution.y[: start.x.size, -1].reshape(start.x.shape)
    exponents = np.arange(-9.0, -3.0)
    errors = [
        np.abs(simulate(system, start, [0.0, end], options=tight(10.0**k))[-1].x - x).max() for k in exponents
    ]
    assert (np.diff(errors) > 0).all()
    slope = np.polyfit(exponents, np.log10(errors), 1)[0]
    assert 0.7 < slope < 1.3
