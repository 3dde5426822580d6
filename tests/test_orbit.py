"""The frame of an orbit: closed forms, Kepler's motion in an inertial frame, tethers, and the balance."""

import numpy as np
import pytest
from conftest import CORD, SOFT, random_net, random_velocities
from scipy.integrate import solve_ivp

from netdae.core.errors import InputError
from netdae.forces.orbit import Orbit
from netdae.model.material import Cords
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.runs.verification.cases.clohessy_wiltshire import V0, X0, closed_form
from netdae.runs.verification.cases.libration import vertical_tether
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping
from netdae.system.system import System

MU, RADIUS = 3.986004418e14, 6.978137e6  # of the Earth, m³/s², and of an orbit at 600 km, m
N = np.sqrt(MU / RADIUS**3)  # 1.083e-3 rad/s


def two_free_masses(*loads):
    """Two nodes whose cable is far longer than their way."""
    net = CableNet(X0, [[0, 1]], rest_length=[1e5])
    return System(net, CORD, damping=NoDamping(), loads=loads), State.at(X0, V0)


def tidal_energy(mass, x, n):
    """Potential −Σ m n² (3x² − z²)/2, J."""
    return -0.5 * n**2 * mass @ (3.0 * x[:, 0] ** 2 - x[:, 2] ** 2)


def kepler(t, x0, v0):
    """Position (3,) at t in the orbit's frame of a free mass, by Kepler's motion in the inertial one."""

    def turn(angle):
        c, s = np.cos(angle), np.sin(angle)
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    out = np.array([RADIUS, 0.0, 0.0])
    r0, u0 = out + x0, v0 + np.cross([0.0, 0.0, N], out + x0)
    moved = solve_ivp(
        lambda _, y: [*y[3:], *(-MU * y[:3] / np.linalg.norm(y[:3]) ** 3)],
        (0.0, t),
        [*r0, *u0],
        method="DOP853",
        rtol=1e-13,
        atol=1e-9,
    )
    return turn(N * t).T @ moved.y[:3, -1] - out


def test_free_masses_fly_the_closed_form_in_solve_ivp():
    system, start = two_free_masses(Orbit(N))
    options = SolverOptions(method="dop853", rtol=1e-11, atol_position=1e-9, atol_velocity=1e-12)
    flight = simulate(system, start, [0.0, 3000.0, 5800.0], options=options)
    for state in flight:
        # 1e-11 of the 0.6 km in each of some hundred steps
        np.testing.assert_allclose(state.x, closed_form(N, state.t, X0, V0), rtol=0, atol=1e-6)


def test_the_frame_is_that_of_the_orbit_to_the_second_order_in_distance():
    """Against Kepler: x points outward, y along the track; what is left out grows as |r|²/a."""
    t, errors = 1500.0, []
    for scale in (1.0, 10.0):
        x0, v0 = scale * np.array([10.0, -20.0, 5.0]), scale * np.array([0.01, -0.02, 0.005])
        ours = closed_form(N, t, x0[None], v0[None])[0]
        errors.append(np.abs(ours - kepler(t, x0, v0)).max())
    assert errors[0] < 1e-3  # 40 m from the origin: 3/2 |r|²/a = 3e-4 m, times some
    assert errors[1] / errors[0] == pytest.approx(100.0, rel=0.1)  # 1e-6 m of round-off of 7e6 m in the first


def test_the_tension_of_a_vertical_tether_is_three_n_squared_m_l():
    system, start, tension = vertical_tether(1000.0, 5.0, 500.0, N)
    assert tension == pytest.approx(3 * N**2 * 5.0 * 1000.0, rel=0.15)  # 17.6 mN; the cord weighs 1.1 kg
    # E11 = 3e-7 from lengths of 1000 m: round-off 1e-16/3e-7, and as much of the force's sum
    assert system.tension(start.x)[0] == pytest.approx(tension, rel=1e-8)
    np.testing.assert_allclose(system.force(0.0, start.x, start.v), 0.0, atol=1e-8 * tension)
    # held so for a tenth of a revolution, tension to BDF's tolerance in length: EA/L 1e-6 m
    flight = simulate(system, start, [0.0, 580.0], options=SolverOptions(accuracy="accurate"))
    assert system.tension(flight[-1].x)[0] == pytest.approx(tension, abs=55.0 * 1e-6)


@pytest.mark.parametrize("damping", [NoDamping(), Dashpot(viscosity_time=1e-4)])
def test_kinetic_elastic_and_tidal_energy_keep_their_sum(damping):
    """n is 10 rad/s, so that the tide counts beside the cables; the remainder falls with the tolerance."""
    net, n = random_net(1), 10.0
    system = System(net, SOFT, damping=damping, loads=[Orbit(n)])
    start = State.at(net.nodes, random_velocities(net))

    def energy(state):
        own = system.kinetic_energy(state.v) + system.elastic_energy(state.x)
        return own, tidal_energy(system.mass, state.x, n)

    missing = []
    for rtol in (1e-3, 1e-5, 1e-7):
        options = SolverOptions(rtol=rtol, atol_position=0.1 * rtol, atol_velocity=10 * rtol)
        flight = simulate(system, start, [0.0, 0.1], options=options)
        (own0, tide0), (own, tide), balance = energy(start), energy(flight[-1]), flight[-1].balance
        missing.append(abs(own + tide + balance.dissipated_energy - own0 - tide0) / own0)
        assert abs(tide - tide0) > 0.02 * own0  # the tide has worked
        # Simpson's rule over a tidal power that is smooth along BDF's own way: far better than the way itself
        assert balance.external_work == pytest.approx(tide0 - tide, abs=max(1e-3 * rtol, 1e-9) * own0)
        impulse = system.momentum(flight[-1].v) - system.momentum(start.v)
        np.testing.assert_allclose(
            balance.external_impulse, impulse, rtol=0, atol=10 * rtol * system.mass.sum()
        )
    assert missing[2] < 1e-4
    assert missing[2] < missing[1] < missing[0]


def test_nodes_without_mass_feel_no_orbit():
    net = CableNet.square(side=1.0, cells=2)
    mass = np.ones(net.node_count)
    mass[[3, 7]] = 0.0
    force = Orbit(1e-3).on(net, Cords.of(net, CORD), mass)
    assert sorted({*range(net.node_count)} - {*force.nodes[:, 0].tolist()}) == [3, 7]


@pytest.mark.parametrize("n", [0.0, -1e-3, np.nan, np.inf])
def test_a_mean_motion_that_is_none_is_refused(n):
    with pytest.raises(InputError, match=r"mean_motion is .* above zero"):
        Orbit(n)
