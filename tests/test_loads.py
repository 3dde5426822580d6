"""Loads p(t): exact momentum, no restart at kinks, balance that closes."""

import numpy as np
import pytest
from conftest import CORD, SOFT, random_net, random_velocities, reference_flight

from netdae.core.errors import InputError
from netdae.forces.loads import Gravity, NodalLoad
from netdae.model.net import CableNet
from netdae.model.signals import Function, Pulse, Table
from netdae.model.state import State
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, Rayleigh
from netdae.system.system import System


def slack_square(loads):
    """Slack net at rest whose corners weigh 0.5 kg."""
    net = CableNet.square(side=5.0, cells=4)
    system = System(net, CORD, damping=Dashpot(viscosity_time=1e-5), masses={"corners": 0.5}, loads=loads)
    return system, State.at(net.nodes * [0.4, 0.4, 1.0])


@pytest.mark.parametrize("begin", [0.0, 0.0123456, 0.0333])
def test_a_pulse_of_a_tenth_of_a_millisecond_gives_its_exact_momentum(begin):
    pulse = Pulse([0.0, 300.0, 1000.0], begin, begin + 1e-4)
    system, start = slack_square([NodalLoad("corners", pulse)])
    flight = simulate(system, start, np.linspace(0.0, 0.1, 4))
    expected = 4 * 1e-4 * np.array([0.0, 300.0, 1000.0])
    np.testing.assert_allclose(system.momentum(flight[-1].v), expected, rtol=1e-12, atol=1e-16)
    np.testing.assert_allclose(flight[-1].balance.external_impulse, expected, rtol=1e-12, atol=1e-16)
    assert flight.statistics["starts"] == (2 if begin == 0.0 else 3)
    # each bullet, not only their sum: corners fly freely until a cable is taut
    corners = system.net.nodes_of("corners")
    np.testing.assert_allclose(
        system.mass[corners, None] * flight[-1].v[corners],
        np.tile(expected / 4, (4, 1)),
        rtol=1e-12,
        atol=1e-16,
    )


def test_a_pulse_on_a_net_with_taut_cables_gives_its_exact_momentum():
    net = random_net(0)
    pulse = Pulse([3.0, 0.0, -2.0], 0.0111, 0.0112)
    system = System(net, SOFT, damping=Dashpot(viscosity_time=1e-4), loads=[NodalLoad("few", pulse)])
    flight = simulate(system, State.at(net.nodes), [0.0, 0.007, 0.05])
    np.testing.assert_allclose(
        system.momentum(flight[-1].v), 3 * 1e-4 * np.array([3.0, 0.0, -2.0]), rtol=1e-12, atol=1e-15
    )


def test_a_jump_in_a_table_is_met_from_both_sides():
    """2 N until 20 ms, then −1 N: impulse 0.04 − 0.03 N s."""
    table = Table([0.0, 0.02, 0.02, 1.0], [[2, 0, 0], [2, 0, 0], [-1, 0, 0], [-1, 0, 0]])
    system, start = slack_square([NodalLoad("corners", table)])
    flight = simulate(system, start, [0.0, 0.05])
    assert system.momentum(flight[-1].v)[0] == pytest.approx(4 * (0.04 - 0.03), rel=1e-12)
    assert flight.statistics["starts"] == 2


def test_kinks_of_a_table_do_not_restart():
    """A 1 kHz table: each row ends a step, none restarts the formula."""
    times = np.linspace(0.0, 0.5, 501)
    values = np.sin(2 * np.pi * 5.0 * times[:, None] + [0.0, 1.0, 2.0])
    system, start = slack_square([NodalLoad("corners", Table(times, values))])
    flight = simulate(system, start, [0.0, 0.5])
    assert flight.statistics["starts"] == 1
    assert flight.statistics["steps"] < 3 * 500
    # momentum is the table's trapezoid sum; BDF takes velocities to a tolerance of 1e-3 m/s
    expected = 4 * np.trapezoid(values, times, axis=0)
    np.testing.assert_allclose(system.momentum(flight[-1].v), expected, rtol=0, atol=4 * 0.5 * 1e-3)
    # the balance integrates the load itself, linear between the ends of steps
    np.testing.assert_allclose(flight[-1].balance.external_impulse, expected, rtol=1e-10, atol=1e-13)


@pytest.mark.parametrize("kind", ["constant", "linear", "cubic", "function"])
def test_a_slack_net_falls_by_the_integral_of_g(kind):
    """x = x₀ + ∬ g; each component t ↦ a, a t and cubic in t, which a table of either kind can hold."""
    times = np.linspace(0.0, 0.2, 9)

    def g(t):
        if kind == "constant":
            return np.array([0.0, 1.0, -9.81])
        return np.array([3.0, 20.0 * t - 1.0, -9.81 + 5 * t])

    signals = {
        "constant": g(0.0),
        "function": g,
        "linear": Table(times, [g(t) for t in times]),
        "cubic": Table(times, [g(t) for t in times], "cubic"),
    }
    system, start = slack_square([Gravity(signals[kind])])
    flight = simulate(system, start, [0.0, 0.2], options=SolverOptions(accuracy="accurate"))
    t = 0.2
    v, x = (
        [3.0 * t, 10 * t**2 - t, -9.81 * t + 2.5 * t**2],
        [1.5 * t**2, 10 * t**3 / 3 - t**2 / 2, -9.81 * t**2 / 2 + 2.5 * t**3 / 3],
    )
    if kind == "constant":
        v, x = [0.0, t, -9.81 * t], [0.0, t**2 / 2, -9.81 * t**2 / 2]
    # velocity is a polynomial of degree 2, which BDF meets to its tolerance of 1e-5, and its own start-up
    np.testing.assert_allclose(flight[-1].v - start.v, np.tile(v, (25, 1)), rtol=0, atol=1e-4)
    np.testing.assert_allclose(flight[-1].x - start.x, np.tile(x, (25, 1)), rtol=0, atol=2e-5)
    assert flight.statistics["starts"] == 1


def test_books_of_constant_loads_close_exactly():
    """Work Σ p·Δx and impulse p t, whatever the cables do and however coarse the steps are."""
    net = random_net(1)
    g, p = np.array([0.3, -0.2, -9.81]), np.array([0.05, 0.0, 0.1])
    system = System(net, SOFT, damping=Dashpot(viscosity_time=1e-4), loads=[Gravity(g), NodalLoad("few", p)])
    start = State.at(net.nodes, random_velocities(net))
    flight = simulate(system, start, np.linspace(0.0, 0.2, 7), options=SolverOptions(accuracy="fast"))
    p0 = system.momentum(start.v)
    for frame in flight:
        moved = frame.x - start.x
        work = system.mass @ moved @ g + moved[[1, 4, 7]].sum(axis=0) @ p
        assert frame.balance.external_work == pytest.approx(work, rel=1e-11, abs=1e-15)
        impulse = (system.mass.sum() * g + 3 * p) * frame.t
        np.testing.assert_allclose(frame.balance.external_impulse, impulse, rtol=1e-11, atol=1e-15)
        np.testing.assert_allclose(system.momentum(frame.v) - p0, impulse, rtol=1e-11, atol=1e-13)


def residual(system, start, times, **options):
    """Energy that the balance misses at the end, and the largest kinetic + elastic energy, J."""
    flight = simulate(system, start, times, options=SolverOptions(**options))
    energy = np.array([system.kinetic_energy(f.v) + system.elastic_energy(f.x) for f in flight])
    missing = energy + flight.dissipated_energy - flight.external_work - energy[0]
    return missing[-1], energy.max()


@pytest.mark.parametrize("damping", [Dashpot(viscosity_time=1e-4), Rayleigh(alpha=2.0, beta=1e-4)])
def test_the_energy_balance_closes_with_the_tolerance(damping):
    net = random_net(1)
    loads = [
        Gravity(lambda t: [0.0, 0.0, -50.0 * np.sin(60 * t)]),
        NodalLoad("few", Pulse([1, 0, 0], 0.01, 0.03)),
    ]
    system = System(net, SOFT, damping=damping, loads=loads)
    start = State.at(net.nodes, random_velocities(net))
    shares = []
    for rtol in (1e-3, 1e-5, 1e-7):
        missing, largest = residual(
            system, start, [0.0, 0.1], rtol=rtol, atol_position=0.1 * rtol, atol_velocity=10 * rtol
        )
        shares.append(abs(missing) / largest)
    assert shares[1] < 1e-2
    assert shares[2] < 1e-4
    assert shares[2] < shares[1] < shares[0]


def test_mass_proportional_damping_takes_momentum_by_the_balance():
    """Ṗ = −α P: the momentum decays as exp(−α t), and the impulse in the balance is the loss."""
    system, _ = slack_square([])
    system = System(system.net, CORD, damping=Rayleigh(alpha=3.0), masses={"corners": 0.5})
    start = State.at(system.net.nodes * 0.5, np.tile([1.0, 0.0, 2.0], (25, 1)))
    flight = simulate(system, start, [0.0, 0.5], options=SolverOptions(accuracy="accurate"))
    before, after = system.momentum(start.v), system.momentum(flight[-1].v)
    np.testing.assert_allclose(after, np.exp(-1.5) * before, rtol=1e-4, atol=1e-15)
    # the balance takes the loss by Simpson's rule over BDF's own steps, right to its tolerance
    np.testing.assert_allclose(flight[-1].balance.external_impulse, after - before, rtol=1e-3, atol=1e-12)
    lost = system.kinetic_energy(start.v) - system.kinetic_energy(flight[-1].v)
    assert flight[-1].balance.dissipated_energy == pytest.approx(lost, rel=1e-3)


def test_a_table_that_does_not_cover_the_flight_is_refused():
    table = Table([0.0, 0.05], [[0, 0, 0], [1, 0, 0]])
    system, start = slack_square([NodalLoad("corners", table)])
    with pytest.raises(InputError, match=r"from 0 to 0\.05 s.*from 0 to 0\.1 s"):
        simulate(system, start, [0.0, 0.1])


def test_a_load_on_an_unknown_group_is_refused():
    with pytest.raises(InputError, match=r"'nobody'.*corners"):
        slack_square([NodalLoad("nobody", [1, 0, 0])])


def test_a_declared_jump_of_a_function_is_exact_and_an_undeclared_one_is_not():
    """Why jumps are declared: without it the same push comes out a step's length wrong."""
    push = lambda t: [300.0 if 0.0123 < t < 0.0124 else 0.0, 0.0, 0.0]  # noqa: E731
    momenta = []
    for signal in (Function(push, jumps=(0.0123, 0.0124)), Function(push)):
        system, start = slack_square([NodalLoad("corners", signal)])
        momenta.append(system.momentum(simulate(system, start, [0.0, 0.05])[-1].v)[0])
    assert momenta[0] == pytest.approx(4 * 300.0 * 1e-4, rel=1e-12)
    assert abs(momenta[1] / momenta[0] - 1) > 1e-3


def test_a_uniform_force_moves_a_taut_net_as_a_whole():
    """Gravity alone neither tightens nor turns a free net, in any state of its cables."""
    system, start = reference_flight(3)
    heavy = System(
        system.net,
        CORD,
        damping=Dashpot(viscosity_time=1e-5),
        masses={"corners": 0.5},
        loads=[Gravity([0, 0, -9.81])],
    )
    options = SolverOptions(rtol=1e-8, atol_position=1e-9, atol_velocity=1e-7)
    t = 0.5  # first snap of this net at 0.42 s
    free, falling = (simulate(s, start, [0.0, t], options=options)[-1] for s in (system, heavy))
    np.testing.assert_allclose(
        falling.x - free.x, np.tile([0, 0, -9.81 * t**2 / 2], (16, 1)), rtol=0, atol=1e-5
    )
