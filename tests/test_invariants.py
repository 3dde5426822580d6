"""What the equations of motion keep: momenta, energy, symmetry, the choice of axes."""

import numpy as np
import pytest
from conftest import CORD, SOFT, random_net, random_velocities, reference_flight
from scipy.spatial.transform import Rotation

from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping, Rayleigh
from netdae.system.system import System

DAMPINGS = {"none": NoDamping(), "dashpot": Dashpot(viscosity_time=1e-4), "rayleigh": Rayleigh(beta=1e-4)}
TURN = [25.0, -40.0, 110.0]


def tight(rtol):
    return SolverOptions(rtol=rtol, atol_position=0.1 * rtol, atol_velocity=10 * rtol)


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("accuracy", ["fast", "standard"])
def test_momentum_of_a_free_net_is_kept(damping, accuracy):
    """To round-off, at any tolerance: it is a linear invariant of BDF and of each Newton correction."""
    net = random_net(0)
    system = System(net, SOFT, damping=DAMPINGS[damping], masses={"few": 0.3})
    v = random_velocities(net) + np.array([3.0, 0.0, -1.0])
    flight = simulate(
        system, State.at(net.nodes, v), np.linspace(0, 0.2, 5), options=SolverOptions(accuracy=accuracy)
    )
    scale = float(system.mass @ np.linalg.norm(v, axis=1))
    for frame in flight:
        np.testing.assert_allclose(system.momentum(frame.v), system.momentum(v), rtol=0, atol=1e-12 * scale)


def test_momentum_of_the_reference_flight_is_kept():
    system, start = reference_flight()
    last = simulate(system, start, [0.0, 0.5], options=SolverOptions(accuracy="fast"))[-1]
    # 0.5 kg bullets beside knots of a gram, thousands of stiff steps
    np.testing.assert_allclose(system.momentum(last.v), system.momentum(start.v), rtol=0, atol=1e-11)


def drifts(system, start, end, of):
    """Largest |of(t) − of(start)| at eleven times, at three tolerances."""
    times = np.linspace(0.0, end, 11)
    return [
        max(
            np.abs(of(frame) - of(start)).max()
            for frame in simulate(system, start, times, options=tight(rtol))
        )
        for rtol in (1e-4, 1e-6, 1e-8)
    ]


@pytest.mark.parametrize("damping", ["none", "dashpot"])
def test_angular_momentum_converges_with_rtol(damping):
    net = random_net(2)
    system = System(net, SOFT, damping=DAMPINGS[damping], masses={"few": 0.1})
    start = State.at(net.nodes, random_velocities(net))
    scale = float(system.mass @ (np.linalg.norm(start.x, axis=1) * np.linalg.norm(start.v, axis=1)))
    error = drifts(system, start, 0.1, lambda s: system.angular_momentum(s.x, s.v))
    # a global error of some hundred times rtol, which falls in proportion
    assert error[2] < 1e-5 * scale
    assert error[2] < 0.01 * error[0]
    assert error[1] < 0.2 * error[0]


def test_energy_of_an_undamped_net_converges_with_rtol():
    net = random_net(2)
    system = System(net, SOFT, damping=NoDamping(), masses={"few": 0.1})
    start = State.at(net.nodes, random_velocities(net))
    energy = lambda s: np.array([system.kinetic_energy(s.v) + system.elastic_energy(s.x)])  # noqa: E731
    error = drifts(system, start, 0.1, energy) / energy(start)
    assert error[2] < 1e-4
    assert error[2] < 0.01 * error[0]
    assert error[1] < 0.2 * error[0]


def turned_square(angle, rate):
    """A 2 m net, drawn together by a thousandth so that all is slack, turned about z from x̄ and turning on."""
    net = CableNet.square(side=2.0, cells=4)
    turn = Rotation.from_euler("z", angle)
    x = turn.apply(0.999 * net.nodes)
    return net, State.at(x, np.cross([0.0, 0.0, rate], x))


def power_on_rotation(net, beta, angle, rate):
    """Eq. (9) on a net turned by θ about z, x = s R x̄: n̄·(ω × s R L̄ n̄) = −s ω L̄ sin θ for cables in the
    plane, so P = β Σ (EĀ/L̄) (s ω L̄ sin θ)² = β EĀ (s ω sin θ)² Σ L̄."""
    EA = 70e9 * np.pi / 4 * 1e-6
    return beta * EA * (0.999 * rate * np.sin(angle)) ** 2 * net.rest_length.sum()


@pytest.mark.parametrize("angle", [0.0, 0.25, 0.5, np.pi / 2])
def test_eq_9_damps_a_rigid_rotation_by_the_sine_squared(angle):
    beta, rate = 1e-4, 0.7
    net, start = turned_square(angle, rate)
    system = System(net, CORD, damping=Rayleigh(beta=beta))
    _, power, _ = system.account(0.0, start.x, start.v)
    assert power == pytest.approx(power_on_rotation(net, beta, angle, rate), rel=1e-12, abs=1e-20)
    # and its torque, the whole of it about z, is what takes that power: P = −torque ω
    torque = np.cross(start.x, system.force(0.0, start.x, start.v)).sum(axis=0)
    np.testing.assert_allclose(torque, [0, 0, -power / rate], rtol=1e-12, atol=1e-12)


def test_a_flight_loses_that_energy_and_angular_momentum_at_half_a_radian():
    """Over so short a time that the rotation is still rigid: a ten-thousandth of the energy goes."""
    beta, rate, angle = 1e-9, 0.7, 0.5
    net, start = turned_square(angle, rate)
    system = System(net, CORD, damping=Rayleigh(beta=beta))
    power = power_on_rotation(net, beta, angle, rate)
    energy = system.kinetic_energy(start.v)
    span = 1e-4 * energy / power
    last = simulate(system, start, [0.0, span], options=tight(1e-9))[-1]
    assert last.balance.dissipated_energy == pytest.approx(1e-4 * energy, rel=1e-2)
    assert energy - system.kinetic_energy(last.v) == pytest.approx(1e-4 * energy, rel=1e-2)
    lost = system.angular_momentum(start.x, start.v) - system.angular_momentum(last.x, last.v)
    np.testing.assert_allclose(lost, [0, 0, 1e-4 * energy / rate], rtol=1e-2, atol=1e-12)
    np.testing.assert_allclose(system.momentum(last.v), 0.0, atol=1e-15)


def test_the_dashpot_leaves_a_rigid_rotation_alone():
    """Taut and turning, the stretch of each cable is constant."""
    net = random_net(4)
    system = System(net, SOFT, damping=Dashpot(viscosity_time=1e-2))
    x = Rotation.from_euler("xyz", [1.0, 2.0, 0.5]).apply(net.nodes.copy())
    v = np.cross([0.3, -2.0, 1.0], x) + np.array([5.0, 0.0, 1.0])
    assert (system.strain(x) > 0).sum() > 5
    assert abs(system.account(0.0, x, v)[1]) < 1e-15
    undamped = System(net, SOFT, damping=NoDamping())
    np.testing.assert_allclose(system.force(0.0, x, v), undamped.force(0.0, x, v), rtol=0, atol=1e-14)


@pytest.mark.parametrize("damping", [None, Rayleigh(beta=1e-4)], ids=["dashpot", "rayleigh"])
def test_the_symmetric_shot_stays_symmetric_until_its_first_snap(damping):
    system, start = reference_flight(seed=None, damping=damping)
    times = np.linspace(0.0, 0.14, 8)  # the corners' cables are taut at 0.148 s
    flight = simulate(system, start, times)
    nodes = np.round(system.net.nodes, 9)
    place = {tuple(xyz): k for k, xyz in enumerate(nodes.tolist())}
    for turn in (np.diag([-1.0, 1.0, 1.0]), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])):
        image = [place[tuple(xyz)] for xyz in (np.round(nodes @ turn.T, 9) + 0.0).tolist()]
        for frame in flight:
            np.testing.assert_allclose(frame.x[image], frame.x @ turn.T, rtol=0, atol=1e-9)
    assert not system.tension(flight[-1].x).any()
    later = simulate(system, start, [0.0, 0.16])[-1]
    assert system.tension(later.x).any() or later.balance.dissipated_energy > 0


@pytest.mark.parametrize("damping", [Dashpot(viscosity_time=1e-5), NoDamping()], ids=["dashpot", "none"])
def test_a_slack_net_flies_straight(damping):
    net = CableNet.square(side=2.0, cells=3)
    system = System(net, CORD, damping=damping, masses={"corners": 0.5})
    start = State.at(0.5 * net.nodes, 0.1 * random_velocities(net))
    flight = simulate(system, start, [0.0, 0.1, 0.3])
    for frame in flight:
        np.testing.assert_allclose(frame.x, start.x + frame.t * start.v, rtol=0, atol=1e-13)
        np.testing.assert_allclose(frame.v, start.v, rtol=0, atol=1e-13)
        assert frame.balance.dissipated_energy == 0.0
        np.testing.assert_allclose(frame.a, 0.0, atol=1e-12)


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("toe", [0.0, 1e-4])
def test_a_net_packed_into_one_point_unfolds_without_nan(damping, toe):
    net = CableNet.square(side=1.0, cells=3)
    cord = Material(youngs_modulus=1e7, density=1000.0, diameter=2e-3, toe_strain=toe)
    system = System(net, cord, damping=DAMPINGS[damping], masses={"corners": 0.1})
    v = np.zeros_like(net.nodes)
    v[net.nodes_of("corners")] = 2.0 * net.nodes[net.nodes_of("corners")] + [0, 0, 1.0]
    flight = simulate(system, State.at(np.zeros_like(net.nodes), v), np.linspace(0.0, 0.4, 5))
    assert np.isfinite(flight.positions).all()
    assert np.isfinite(flight.accelerations).all()
    assert flight.peak_tension.max() > 0
    np.testing.assert_allclose(system.momentum(flight[-1].v), system.momentum(v), rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "damping", [Rayleigh(beta=1e-4), Dashpot(viscosity_time=1e-5)], ids=["rayleigh", "dashpot"]
)
def test_turning_the_whole_scenario_turns_the_flight(damping):
    """By `initial.scaled`, which turns x̄ too, and the ejection's axis; over the first snaps, which last 2 ms."""
    turn = Rotation.from_euler("xyz", TURN, degrees=True)
    times, ends = [0.0, 0.14, 0.15], []
    for angles in ([0.0, 0.0, 0.0], TURN):
        system, start = reference_flight(seed=None, damping=damping, rotation_deg=angles)
        ends.append(simulate(system, start, times, options=tight(1e-11)))
    straight, turned = ends
    assert straight.dissipated_energy[-1] > 0.0
    for one, other, tolerance in zip(straight, turned, (1e-14, 1e-9, 1e-7), strict=True):
        # tolerances are by component, so that each choice of axes has its own error, some hundred times rtol,
        # and more from the first snap on
        np.testing.assert_allclose(turn.apply(one.x.copy()), other.x, rtol=0, atol=tolerance)


@pytest.mark.parametrize("damping", ["dashpot", "rayleigh"])
def test_turning_a_taut_net_turns_its_flight(damping):
    net = random_net(6)
    turn = Rotation.from_euler("xyz", TURN, degrees=True)
    v = random_velocities(net)
    ends = []
    for rotate in (Rotation.identity(), turn):
        system = System(net.with_nodes(rotate.apply(net.nodes.copy())), SOFT, damping=DAMPINGS[damping])
        start = State.at(rotate.apply(net.nodes.copy()), rotate.apply(v))
        ends.append(simulate(system, start, [0.0, 0.02], options=tight(1e-10))[-1])
    np.testing.assert_allclose(
        turn.apply(ends[0].x.copy()), ends[1].x, rtol=0, atol=1e-7
    )  # global error of 1e-10


def test_rayleigh_damping_by_a_net_that_is_not_turned_is_another_flight():
    """Why the start must turn x̄ with it: with the old x̄ Eq. (9) pulls along other directions."""
    net, start = turned_square(0.5, 0.7)
    turned = net.with_nodes(Rotation.from_euler("z", 0.5).apply(net.nodes.copy()))
    powers = [
        System(each, CORD, damping=Rayleigh(beta=1e-4)).account(0.0, start.x, start.v)[1]
        for each in (net, turned)
    ]
    assert powers[0] > 1.0
    assert powers[1] < 1e-12 * powers[0]
