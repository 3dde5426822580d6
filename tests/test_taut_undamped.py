"""Taut cables without damping under IDA: pendulums, turning rings and hanging chains, by both of its drivers.

Each instance has the right tensions and the right energy beside it, from theory. Before the rules of `ida.taut` they
were wrong by up to 150 %, most without a warning. Bounds are what the presets promise: 2 % of the largest tension at
standard and 1 % at accurate, 1 and 0.5 % of the energy, for hanging chains 2.5 % of the swing's.
"""

import numpy as np
import pytest

from netdae.forces.loads import Gravity
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.runs.verification.case import Setting
from netdae.runs.verification.cases import hanging_chain, whirling_ring
from netdae.runs.verification.cases.hanging_chain import energy, hung, stretched
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
    whirling_ring.fly(Setting("ida", accuracy=accuracy)).require()


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
    """The energy of the swing stays, and its tension hardly rises."""
    hanging_chain.swing(Setting("ida", 50, accuracy), mode, tau).require()


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
