"""Taut cables without damping under IDA: pendulums, turning rings and hanging chains, by both of its drivers.

Each instance has the right tensions and the right energy beside it, from theory. Before the rules of `ida.taut` they
were wrong by up to 150 %, most without a warning. Bounds are what the presets promise: 2 % of the largest tension at
standard and 1 % at accurate, 1 and 0.5 % of the energy, for hanging chains 2.5 % of the swing's.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

from netdae.forces.loads import Gravity
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.solvers import driver as integration
from netdae.solvers.driver import integrate
from netdae.solvers.ida.taut import Damped, damped_of, has_turned, is_undamped
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping, Rayleigh
from netdae.system.system import System

G = 9.81
BOUNDS = {"standard": (0.02, 0.01), "accurate": (0.01, 0.005)}
DRIVERS = {
    "compiled": ("netdae.solvers.ida.native", "ida_stepper"),
    "python": ("netdae.solvers.ida.stepper", "IdaSolver"),
}


@pytest.fixture(params=DRIVERS)
def driver(request, monkeypatch):
    monkeypatch.setitem(integration._STEPPERS, "ida", DRIVERS[request.param])
    return request.param


def cord(EA, linear_density=1e-9):
    return Material(youngs_modulus=1e6 * EA, linear_density=linear_density, area=1e-6)


def stretched(EA, L, T):
    """Length of a cable under a tension, by Eqs. (3) and (4)."""
    return brentq(lambda now: 0.5 * EA * ((now / L) ** 2 - 1) * now / L - T, L, 2 * L, xtol=1e-15)


def flown(system, start, times, **options):
    """States, and the largest tension of all internal steps."""
    peaks = []
    states = list(
        integrate(
            system,
            start,
            times,
            options=SolverOptions(**options),
            watch=[lambda state: peaks.append(state.balance.peak_tension)],
        )
    )
    return states, max(peaks)


def energy(system, state):
    """Kinetic and elastic energy, that in the field of gravity where a node is held, and what dashpots took, J."""
    total = system.kinetic_energy(state.v) + system.elastic_energy(state.x) + state.balance.dissipated_energy
    return total + (G * float(system.mass @ state.x[:, 2]) if system.restraints else 0.0)


def hung(n, EA, linear_density, tau=0.0):
    """A chain of 1 m in n links that hangs at rest: the system, its places, and the tensions of its links."""
    nodes = np.zeros((n + 1, 3))
    nodes[:, 2] = -np.arange(n + 1) / n
    links = np.stack((np.arange(n), np.arange(n) + 1), axis=1)
    net = CableNet(nodes, links, {"top": np.array([0])})
    system = System(
        net,
        cord(EA, linear_density),
        damping=Dashpot(viscosity_time=tau) if tau else NoDamping(),
        loads=[Gravity([0.0, 0.0, -G])],
        restraints=[Restraint("top")],
    )
    T = G * (system.mass.sum() - np.cumsum(system.mass)[:-1])
    x = np.zeros_like(nodes)
    x[1:, 2] = -np.cumsum([stretched(EA, 1 / n, each) for each in T])
    return system, x, T


@pytest.mark.parametrize("EA", [1e4, 1e7])
@pytest.mark.parametrize("accuracy", BOUNDS)
def test_a_pendulum_pulls_with_three_cosines(accuracy, EA, driver):
    """1 m and 1 kg from 60°: T = m g (3 cos θ − 2 cos 60°), 4.9 to 19.6 N, and constant energy."""
    theta, mass = np.pi / 3, 1.0
    place = np.array([np.sin(theta), 0.0, -np.cos(theta)])
    net = CableNet(
        np.stack((0 * place, place)), np.array([[0, 1]]), {"top": np.array([0]), "bob": np.array([1])}
    )
    system = System(
        net,
        cord(EA),
        masses={"bob": mass},
        damping=NoDamping(),
        loads=[Gravity([0.0, 0.0, -G])],
        restraints=[Restraint("top")],
    )
    start = State.at(net.nodes * stretched(EA, 1.0, mass * G * np.cos(theta)))
    states, peak = flown(system, start, np.linspace(0.0, 4.0, 97), accuracy=accuracy)
    in_tension, in_energy = BOUNDS[accuracy]
    for state in states:
        cosine = -state.x[1, 2] / np.linalg.norm(state.x[1])
        right = mass * G * (3 * cosine - 1)
        assert system.tension(state.x)[0] == pytest.approx(right, abs=in_tension * 2 * mass * G)
        assert abs(energy(system, state) - energy(system, states[0])) < in_energy * 0.5 * mass * G
    assert peak == pytest.approx(2 * mass * G, rel=in_tension)


def test_a_coarse_flight_of_undamped_cables_warns():
    system, x, _ = hung(10, 1e6, 0.1)
    warned = {}
    for accuracy in ("fast", "standard"):
        flight = integrate(system, State.at(x), [0.0, 1.0], options=SolverOptions(accuracy=accuracy))
        list(flight)
        warned[accuracy] = flight.warnings
    assert warned["standard"] == ()
    (warning,) = warned["fast"]
    assert 'accuracy = "accurate"' in warning
    assert "[damping]" in warning


@pytest.mark.parametrize("accuracy", BOUNDS)
def test_a_ring_of_masses_turns_at_its_tension(accuracy, driver):
    """12 masses at a strain of 1e-3: each is held by 2 T sin 15° = m ω² r."""
    n, EA, mass, strain = 12, 1e4, 0.1, 1e-3
    angle = 2 * np.pi * np.arange(n) / n
    nodes = np.stack((np.cos(angle), np.sin(angle), 0 * angle), axis=1)
    sides = np.stack((np.arange(n), np.roll(np.arange(n), -1)), axis=1)
    net = CableNet(nodes, sides, {"all": np.arange(n)})
    system = System(net, cord(EA), masses={"all": mass}, damping=NoDamping())
    stretch = np.sqrt(1 + 2 * strain)
    T = EA * strain * stretch
    omega = np.sqrt(2 * T * np.sin(np.pi / n) / (mass * stretch))
    x = stretch * nodes
    start = State.at(x, omega * np.stack((-x[:, 1], x[:, 0], 0 * angle), axis=1))
    states, peak = flown(system, start, np.linspace(0.0, 2.0, 41), accuracy=accuracy)
    in_tension, in_energy = BOUNDS[accuracy]
    for state in states:
        np.testing.assert_allclose(system.tension(state.x), T, rtol=in_tension)
        assert energy(system, state) == pytest.approx(energy(system, states[0]), rel=in_energy)
    assert peak == pytest.approx(T, rel=in_tension)


@pytest.mark.parametrize("accuracy", BOUNDS)
def test_a_chain_at_rest_comes_to_rest(accuracy, driver):
    """50 links, their nodes misplaced by 1e-6 m: half of a link's stretch. The waves of it die out in the formula."""
    system, x, T = hung(50, 1e4, 0.1)
    moved = x + 1e-6 * np.random.default_rng(0).standard_normal(x.shape)
    moved[0] = x[0]
    states, _ = flown(system, State.at(moved), np.linspace(0.0, 3.0, 31), accuracy=accuracy)
    assert max(np.abs(state.x - x).max() for state in states) < 2e-4  # the misplaced chain swings by as much
    for state in states[15:]:
        np.testing.assert_allclose(system.tension(state.x), T, rtol=0, atol=BOUNDS[accuracy][0] * T.max())
    gained = [energy(system, state) - energy(system, states[0]) for state in states]
    assert max(gained) < 1e-7  # of 3e-5 J in the waves


@pytest.mark.parametrize("tau", [0.0, 1e-4])
@pytest.mark.parametrize("mode", [1, 2, 3])
@pytest.mark.parametrize("accuracy", BOUNDS)
def test_a_hanging_chain_swings_in_its_modes(accuracy, mode, tau):
    """ω = (j/2)√(g/L) with the zeros j of J₀; the energy of the swing stays, and its tension hardly rises."""
    system, x, T = hung(50, 1e4, 0.1, tau)
    q = T / -np.diff(x[:, 2])
    K = np.diag(np.append(q[1:], 0.0) + q) - np.diag(q[1:], 1) - np.diag(q[1:], -1)
    root = np.sqrt(system.mass[1:])
    squares, shapes = np.linalg.eigh(K / np.outer(root, root))
    omega, shape = np.sqrt(squares[mode - 1]), shapes[:, mode - 1] / root
    # links of 1/50 m and half a link's mass at the end shift a mode by h/L and less
    assert omega == pytest.approx(0.5 * (2.4048, 5.5201, 8.6537)[mode - 1] * np.sqrt(G), rel=0.01)
    amplitude = 0.02
    v = np.zeros_like(x)
    v[1:, 0] = amplitude * omega * shape / np.abs(shape).max()
    times = np.linspace(0.0, 4 * np.pi / omega, 41)
    states, peak = flown(system, State.at(x, v), times, accuracy=accuracy)
    swing = system.kinetic_energy(v)
    for state in states:
        assert abs(energy(system, state) - energy(system, states[0])) < 0.025 * swing
    # link by link T = Σ m (g + v²/r), with 1/r the slope of the mode: the swing's share is of second order in it
    rise = (1.0 + 4.0 * amplitude**2 * omega**2 / G) * (1 + BOUNDS[accuracy][0])
    assert T.max() * (1 - BOUNDS[accuracy][0]) < peak < T.max() * rise


def test_steps_decide_whether_cables_are_undamped():
    kappa, tau = np.array([1e8]), np.array([1e-5])
    level = lambda before, h: is_undamped(before, h, kappa, tau)  # noqa: E731
    assert [level(0, h) for h in (1e-6, 1e-5, 5e-5, 1e-2)] == [0, 0, 1, 2]
    assert [level(1, h) for h in (1e-6, 1e-5, 2e-5)] == [0, 0, 1]  # once so, for a while
    assert level(2, 5e-4) == 2
    assert level(0, 5e-4) == 1
    assert is_undamped(0, 1.0, np.zeros(1), np.zeros(1)) == 0
    assert is_undamped(0, 1e-3, np.array([1e2]), np.zeros(1)) == 0  # resolved


def test_the_stiffest_cable_and_the_least_damped_decide():
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [3, 0, 0]])
    net = CableNet(nodes, np.array([[0, 1], [1, 2]]), {"all": np.arange(3)}, rest_length=np.array([1.0, 2.0]))
    cords = Material(youngs_modulus=1e10, linear_density=1e-9, area=1e-6)
    made = lambda damping: System(net, cords, masses={"all": 0.5}, damping=damping)  # noqa: E731
    # EA 1e4 N, 0.5 kg at both ends: κ = 4 EA/L; ζ gives the longer cable a longer τ
    for damping, tau in (
        (NoDamping(), 0.0),
        (Dashpot(viscosity_time=1e-3), 1e-3),
        (Rayleigh(beta=2e-3), 2e-3),
    ):
        found = damped_of(made(damping), nodes)
        np.testing.assert_allclose(found, Damped(np.array([4e4]), np.array([tau])), rtol=1e-8)
    held = System(net, cords, masses={"all": 0.5}, damping=NoDamping(), restraints=[Restraint("all")])
    np.testing.assert_array_equal(damped_of(held, nodes), [[0.0], [0.0]])


def test_a_cable_turns_by_what_is_across_it():
    """κ |δd⊥|/(l c_j²) against 0.02: 1e6/1e6 times the angle."""
    then = np.array([0.0, 0, 0, 2.0, 0, 0])
    turned = lambda move: has_turned(  # noqa: E731
        then + np.array([0, 0, 0, *move]), then, np.array([[0, 3]]), np.array([0]), 1, np.array([1e6]), 1e3
    )
    assert not turned([0.5, 0.0, 0.0])
    assert not turned([0.0, 0.039, 0.0])
    assert turned([0.0, 0.0, 0.041])
