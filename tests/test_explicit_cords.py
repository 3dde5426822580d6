"""Cords through rings and winch motors flown by the explicit method: step by step, against theory, and against IDA."""

from __future__ import annotations

import math

import numpy as np
import pytest
from conftest import SOFT, STIFF, random_net, random_velocities
from flights import energy_of, explicit_options
from numpy.random import default_rng
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from test_closing import closing_net, options_for, pair
from test_drawcord import polygon, ringed, system_of, winding

from netdae.core.errors import RunError
from netdae.forces.drawcord import DRAWCORD, friction_rate
from netdae.forces.elements import ElementForce
from netdae.forces.loads import NodalLoad
from netdae.forces.motor import MOTOR, Motor
from netdae.forces.rings import Rings
from netdae.model.mouth import vector_area
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.solvers.explicit import stepper as explicit
from netdae.solvers.explicit.stepper import ExplicitSolver
from netdae.solvers.flight import simulate
from netdae.solvers.linalg.condensed import full_jacobian
from netdae.system.closing import Haul
from netdae.system.damping import Dashpot, NoDamping
from netdae.system.reels import Reel
from netdae.system.system import System

DRUM = 12


def strung(seed, *, closed=True, rings=None, motor=False, damping=None, inertia=0.05, share=-1.0):
    """The random net with a cord through five of its nodes, and its drum; with a motor, a heavy drum."""
    net = random_net(seed)
    through = np.array([0, 2, 5, 9, 3])
    ring = np.stack((through, np.roll(through, -1)), axis=1)[: 5 if closed else 4]
    x = np.concatenate((net.nodes, np.zeros((1, 3))))
    length = np.linalg.norm(x[ring[:, 1]] - x[ring[:, 0]], axis=1)
    m = net.cable_count
    whole = CableNet(
        x, np.concatenate((net.cables, ring)), rest_length=np.concatenate((net.rest_length, 0.97 * length))
    )
    reel = Reel(
        DRUM, np.arange(m, m + len(ring)), inertia=inertia, share=share, rings=rings or Rings(size=1e-2)
    )
    numbers = Motor(*np.array([[4.0], [0.5], [0.1], [0.05]]))
    motors = [ElementForce(MOTOR, np.array([[DRUM]]), numbers)] if motor else []
    return System(whole, SOFT, damping=damping or Dashpot(viscosity_time=2e-4), reels=[reel], forces=motors)


ROUGH = Rings(size=1e-2, friction=0.3, creep_speed=0.5, fastened=False)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("rings", [None, ROUGH], ids=["slides", "rubs"])
@pytest.mark.parametrize("motor", [False, True])
def test_each_step_is_the_velocity_verlet_with_the_forces_of_cord_and_motor(seed, rings, motor):
    """M a = f(x, v − h a/2) with the motor's share at the velocity after the kick, v + h a/2."""
    system = strung(seed, rings=rings, motor=motor)
    pull = next((force for force in system.forces if force.law is MOTOR), None)
    start = State.at(system.net.nodes, random_velocities(system.net, seed, 5.0) * system.in_space[:, None])
    h = 5e-5
    solver = ExplicitSolver(system, system.drive_from(start.x), explicit_options(max_step=h))
    solver.every_step = True
    a = system.acceleration(0.0, start.x, start.v)
    solver.enter(system, 0.0, np.stack((start.x, start.v)), np.stack((start.v, a)))
    reported = []
    while len(reported) < 600:
        reported += solver.step(1.0)
    for step in reported:
        (x, v), a = step.y, step.yp[1]
        before, after = v - 0.5 * h * a, v + 0.5 * h * a
        f = system.force(0.0, x, before)
        if pull is not None:
            of = [pull.force(0.0, x[pull.nodes], w[pull.nodes])[0, 0] for w in (before, after)]
            f[DRUM] += of[1] - of[0]
        # v − h a/2 is off by round-off of v, which stiff drums and friction make some thousand times larger
        np.testing.assert_allclose(
            system.mass[:, None] * a, f, rtol=0, atol=1e-10 * max(np.abs(f).max(), 1.0)
        )
    assert max(step.yp[1][DRUM, 0] for step in reported) > 0
    assert any(step.share.dissipated_energy > 0 for step in reported)


@pytest.mark.parametrize("k", [3, 8, 40])
def test_a_polygon_of_free_masses_is_drawn_in_as_its_radius_is(k):
    """As in test_drawcord; the error falls with the square of the step."""
    mass, radius, size, EA = 0.3, 2.0, 1e-2, 100.0
    net = ringed(polygon(k, radius))
    motion = winding(1.0)
    system = system_of(net, Rings(size=size), mass=mass, drum=motion)
    times = np.linspace(0, 2, 9)
    side, L0 = 2 * np.sin(np.pi / k), net.rest_length.sum()

    def rates(t, y):
        R, v = y
        h = np.hypot(side * R, size)
        stretch = k * h / (L0 - motion.at(t)[0][0])
        N = EA * max(0.5 * (stretch**2 - 1), 0.0) * stretch
        return [v, -N * side**2 * R / h / mass]

    truth = solve_ivp(rates, (0, 2), [radius, 0.0], t_eval=times, rtol=1e-11, atol=1e-13, max_step=1e-2)
    errors = []
    for h in (2e-3, 5e-4):
        options = explicit_options(max_step=h)
        flight = simulate(system, State.at(net.nodes, np.zeros_like(net.nodes)), times, options=options)
        R = np.linalg.norm(flight.positions[:, :k], axis=2)
        errors.append(np.abs(R.T - truth.y[0]).max())
        np.testing.assert_allclose(R, R[:, :1] * np.ones(k), rtol=0, atol=1e-9)
        balance = [energy_of(system, frame) - energy_of(system, flight[0]) for frame in flight]
        assert np.abs(balance).max() < 1e-5
        assert np.abs(system.momentum(flight[-1].v)).max() < 1e-12
    assert errors[1] < 2e-6
    assert errors[1] < 0.2 * errors[0]  # a sixteenth, but for where it goes taut


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_a_skew_cord_keeps_both_momenta_to_round_off_and_balances_the_energy(friction):
    """Free masses of different weights, thrown and drawn in by a free heavy drum: nothing is outside."""
    rng = default_rng(4)
    k = 7
    net = ringed(polygon(k, 1.0) + 0.2 * rng.standard_normal((k, 3)), extra={"odd": [1, 3, 5]}.items())
    system = system_of(
        net,
        Rings(size=5e-3, friction=friction),
        mass={"rings": 0.3, "odd": 0.5},
        inertia=2.0,
        damping=Dashpot(viscosity_time=1e-2),
    )
    v = rng.standard_normal(net.nodes.shape)
    v[k] = [1.5, 0.0, 0.0]
    start = State.at(net.nodes, v)
    residuals = []
    for h in (2e-4, 5e-5):
        flight = simulate(system, start, np.linspace(0, 0.6, 4), options=explicit_options(max_step=h))
        last = flight[-1]
        assert last.balance.dissipated_energy > 0.05
        residuals.append(abs(energy_of(system, last) - energy_of(system, flight[0])))
        np.testing.assert_allclose(system.momentum(last.v), system.momentum(start.v), rtol=0, atol=1e-12)
        before, after = (system.angular_momentum(s.x, s.v) for s in (start, last))
        np.testing.assert_allclose(after, before, rtol=0, atol=1e-12)
    assert residuals[1] < 2e-4  # of 7.9 J; of the first order in h where the dashpot sets in with a jump
    assert residuals[1] < 0.5 * residuals[0]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("damping", [NoDamping(), Dashpot(viscosity_time=2e-4)])
def test_the_step_is_below_the_true_limit_of_a_taut_net_with_a_cord(seed, closed, damping):
    """True limit: h² K + 2 h C ≤ 4 M as matrices, from dense eigenvalues with all taut; also wound in by a fifth."""
    system = strung(seed, closed=closed, damping=damping, inertia=1e-3)
    x = system.net.nodes.copy()
    x[:DRUM] *= 1.9
    zero = np.zeros_like(x)
    solver = ExplicitSolver(system, system.drive_from(x), explicit_options(accuracy="fast"))
    solver.enter(system, 0.0, np.stack((x, zero)), np.stack((zero, zero)))
    h = solver._stable / explicit.FRACTIONS["fast"]
    wound = x.copy()
    wound[DRUM, 0] = 0.2 * system.net.rest_length[system.reels[0].cables].sum()
    largest = []
    for place in (x, wound):
        assert (system.strain(place) > 0).all()
        n = place.size
        J = full_jacobian(system, 0.0, place, zero, 1.0).toarray()  # its lower half is T, M + D for c_j = 1
        M = system.mass_matrix().toarray()
        K, C = J[n:, :n], J[n:, n:] - M
        both = h**2 * K + 2 * h * C
        largest.append(eigh(0.5 * (both + both.T), M, eigvals_only=True)[-1])
    assert max(largest) <= 4.0
    # the bound lets the cord turn back at each ring, at the limit of strain
    assert max(largest) > 4.0 / 80


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("light", [None, 0, 4, 8], ids=["none", "first", "middle", "last"])
def test_the_rate_of_friction_is_above_its_largest_eigenvalue_and_not_far(seed, closed, light):
    """Of −∂f/∂ẋ over M, from the cord's own tangent, where rings creep, so that secant and slope are one."""
    rng = default_rng(seed)
    k = 9
    heavy = [] if light is None else [ring for ring in range(k) if ring != light]
    places = polygon(k, 1.0) + 0.6 * rng.standard_normal((k, 3))
    net = ringed(places, closed=closed, extra={"heavy": heavy}.items())
    rings = Rings(size=1e-3, friction=0.2, creep_speed=0.5, fastened=False)
    system = system_of(net, rings, mass={"rings": 0.01, "heavy": 1.0}, inertia=0.02)
    x, v = net.nodes * 1.01, 1e-3 * rng.standard_normal(net.nodes.shape)
    x[k], v[k, 1:] = 0.0, 0.0
    share = 1 / np.repeat(system.mass, 3)
    cord = next(force for force in system.forces if force.law is DRAWCORD)
    C = -cord.tangent(0.0, x[cord.nodes], v[cord.nodes]).dv.reshape(3 * k + 3, 3 * k + 3)
    root = np.sqrt(share)
    largest = np.linalg.eigvalsh(0.5 * root[:, None] * (C + C.T) * root)[-1]
    ends = cord.nodes[0]
    rate = friction_rate(cord.parameters, x[ends], v[ends], 1 / system.mass[ends])
    # G_j takes the larger of two tensions, which differ by e^{μφ}: its linear damping is that of their mean
    assert largest < 1.05 * rate
    assert largest > rate / 8


@pytest.mark.parametrize("creep", [1e-3, 1e-4])
def test_atwoods_machine_with_a_capstan_falls_or_creeps_as_it_should(creep):
    """a = g (m₂ − m₁ e^{μφ})/(m₂ + m₁ e^{μφ}) over a ring that turns the cord by φ = π; or N₁/N₀ = e^{μφγ}."""
    m1, m2, g, friction = 1.0, 3.0, 10.0, 0.2
    angle = np.pi - 2e-3  # smoothed by 1e-3 at 0 and at π
    ratio = np.exp(friction * angle)
    a = g * (m2 - m1 * ratio) / (m2 + m1 * ratio)
    places = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    groups = {"light": [0], "ring": [1], "heavy": [2]}
    net = ringed(places, closed=False, length=2.0, extra=groups.items())

    def machine(weight):
        return system_of(
            net,
            Rings(size=1e-4, friction=friction, creep_speed=creep),
            material=STIFF,
            mass={"light": m1, "heavy": m2},
            damping=Dashpot(viscosity_time=1e-3),
            restraints=[Restraint("ring"), Restraint("drum", axes="x")],
            loads=[NodalLoad("light", [0, 0, -m1 * g]), NodalLoad("heavy", [0, 0, -weight])],
        )

    x = net.nodes.copy()
    x[[0, 2], 2] -= 0.5 * (m1 * (g + a) + m2 * (g - a)) / 1e5
    v = np.zeros_like(x)
    v[0, 2], v[2, 2] = 0.2, -0.2  # it slides already
    flight = simulate(machine(m2 * g), State.at(x, v), [0.0, 0.2, 0.4], options=explicit_options())
    for frame in (flight[1], flight[2]):
        assert frame.v[0, 2] == pytest.approx(0.2 + a * frame.t, rel=1e-3)
    way, tensions = flight[-1].x[0, 2] - x[0, 2], (m1 * (g + a), m2 * (g - a))
    lost = flight[-1].balance.dissipated_energy
    assert lost == pytest.approx((tensions[1] - tensions[0]) * way, rel=2e-3)
    x[[0, 2], 2] = -1.0 - 1.25 * m1 * g / 1e5
    last = simulate(machine(1.5 * m1 * g), State.at(x), [0.0, 0.5], options=explicit_options())[-1]
    u = np.log(1.5) / (friction * angle)
    assert last.v[0, 2] == pytest.approx(creep * u / np.sqrt(1 - u**2), rel=1e-2)


def test_a_motor_at_its_full_force_draws_two_masses_together_as_one_degree_of_freedom():
    """Far below its speed the pull is constant, F γ(10) of the width of a tenth: (J + m₁m₂/(m₁ + m₂)) s̈ = F γ."""
    closed, system = pair(Haul(speed=1e4, force=3.0, final_length=0.5, drum_inertia=0.5))
    flight = simulate(system, closed.start, [0.0, 0.3, 0.6], options=explicit_options())
    pull = 3.0 * 10 / math.sqrt(101)
    a = pull / (0.5 + 2 / 3)
    for frame in (flight[1], flight[2]):
        assert frame.x[4, 0] == pytest.approx(0.5 * a * frame.t**2, rel=1e-3)
        assert frame.v[0, 0] == pytest.approx(2 / 3 * a * frame.t, rel=1e-3)
        assert frame.balance.external_work == pytest.approx(pull * frame.x[4, 0], rel=1e-3)
        assert energy_of(system, frame) == pytest.approx(0.0, abs=1e-4)
    assert np.abs(system.momentum(flight[2].v)).max() < 1e-12


def test_a_motor_far_too_stiff_for_the_step_keeps_its_speed_stops_and_stalls():
    """Its controller, F/(v₀ J) = 5e3 1/s and more, as a brake's, bounds no step."""
    haul = Haul(speed=0.1, force=50.0, final_length=2.0, begin=0.1, drum_inertia=1e-2)
    closed, system = pair(haul)
    flight = simulate(system, closed.start, np.linspace(0, 12, 25), options=explicit_options(accuracy="fast"))
    motor = next(force for force in system.forces if force.law is MOTOR)
    h = 12 / flight.statistics["steps"]
    strength, _, width, _ = motor.parameters
    assert h * strength[0] / (width[0] * 1e-2) > 10  # 2 is the limit of an explicit one
    drum = np.array([[frame.x[4, 0], frame.v[4, 0]] for frame in flight])
    during = (flight.times > 1.0) & (flight.times < 9.0)
    np.testing.assert_allclose(drum[during, 1], 0.1, rtol=1e-2)
    np.testing.assert_allclose(drum[-2:, 0], 1.0 + 50.0 / (1e5 / 2), atol=2e-5)
    assert np.abs(drum[-2:, 1]).max() < 1e-5


def test_a_load_over_the_motors_force_stalls_it_and_the_pawl_holds_but_for_its_creep():
    """F (γ(v/v₀) + P(u)) = R with R = 2F: the drum creeps back at u v₁ from P = 2 − 10/√101."""
    closed, system = pair(
        Haul(speed=1.0, force=10.0, final_length=0.5),
        restraints=[Restraint("a")],
        loads=[NodalLoad("b", [20.0, 0.0, 0.0])],
    )
    flight = simulate(system, closed.start, [0.0, 1.0, 2.0], options=explicit_options())
    P = 2 - 10 / math.sqrt(101)
    u = 0.5 * (P + math.sqrt(P * P + 4 * P))
    assert flight[2].v[4, 0] == pytest.approx(-0.01 * u, rel=2e-3)  # after a millisecond of transients
    assert flight[2].balance.dissipated_energy > flight[1].balance.dissipated_energy


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_a_net_is_closed_as_with_ida_and_its_balances_are_kept(friction):
    loop, closed, system = closing_net(4, 16, friction=friction, speed=4.0, final=8.0)
    times = np.linspace(0, 2.0, 5)
    ours = simulate(system, closed.start, times, options=explicit_options(accuracy="fast"))
    theirs = simulate(system, closed.start, times, options=options_for(4.0))
    areas = np.array([[vector_area(frame.x[loop]) for frame in flight] for flight in (ours, theirs)])
    np.testing.assert_allclose(
        areas[0], areas[1], rtol=0.02
    )  # 1 % between one run of IDA and another, 25 m² at first
    drum = system.reels[0].node
    np.testing.assert_allclose(ours.positions[:, drum, 0], theirs.positions[:, drum, 0], atol=5e-3)
    work = ours[-1].balance.external_work
    for frame in ours:
        assert np.abs(system.momentum(frame.v)).max() < 1e-12
        assert energy_of(system, frame) == pytest.approx(energy_of(system, ours[0]), abs=0.01 * work)


def test_a_cord_wound_in_whole_is_reported_with_its_time():
    net = ringed(polygon(4, 1.0))
    system = system_of(net, drum=winding(10.0))
    with pytest.raises(RunError, match=r"at t = 0\.8\d* s the cord through node 0 has the rest length"):
        simulate(system, State.at(net.nodes), [0.0, 2.0], options=explicit_options())
