"""Forces from outside and user-defined ones in the explicit step: its order, and the balances."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import random_net, random_velocities
from flights import explicit_options

from netdae.forces.air import AirDrag
from netdae.forces.drag import BodyDrag
from netdae.forces.force import Account, Tangent
from netdae.forces.loads import Gravity
from netdae.forces.orbit import Orbit
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping
from netdae.system.system import System

CORD = Material(youngs_modulus=1e6, density=1000.0, diameter=2e-2)
SHARP = SolverOptions(rtol=1e-10, atol_position=1e-12, atol_velocity=1e-10)


def pair(**more):
    """Two masses of 1 kg on a cord of 20 m that stays slack."""
    net = CableNet([(0, 0, 0), (1, 0, 0)], [(0, 1)], rest_length=[20.0], node_groups={"a": [0], "b": [1]})
    return System(net, CORD, masses={"all": 1.0}, damping=NoDamping(), **more)


def orbiting(n, x0, v0, t):
    """Free flight by Clohessy and Wiltshire, (3,), m (their closed form, in the frame of `forces.orbit`)."""
    (x, y, z), (vx, vy, vz), s, c = x0, v0, np.sin(n * t), np.cos(n * t)
    return np.array(
        [
            (4 - 3 * c) * x + s / n * vx + 2 / n * (1 - c) * vy,
            6 * (s - n * t) * x + y - 2 / n * (1 - c) * vx + (4 * s - 3 * n * t) / n * vy,
            c * z + s / n * vz,
        ]
    )


def test_free_masses_in_orbit_follow_the_closed_form_with_the_square_of_the_step():
    n, end = 0.01, 50.0
    system = pair(loads=[Orbit(n)])
    v = np.array([[0.0, 0.01, 0.005], [0.0, 0.009, -0.002]])
    start = State.at(system.net.nodes, v)
    errors, steps = [], (6.4e-3, 3.2e-3, 1.6e-3)
    for h in steps:
        flight = simulate(system, start, [0.0, 0.37 * end, end], options=explicit_options(max_step=h))
        exact = [[orbiting(n, start.x[k], v[k], t) for k in (0, 1)] for t in flight.times]
        errors.append(np.abs(flight.positions - exact).max(axis=(1, 2))[1:])  # inside a chunk and at an end
    slopes = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert (slopes > 1.9).all()
    # of a way of 0.6 m: measured 4e-6; forces are held for 8 steps, and (8 n h)² is 3e-7
    assert errors[0][-1] < 1e-5


LOADS = {
    "orbit": [Orbit(0.3)],
    "air": [AirDrag(density=20.0, wind=lambda t: [3.0 * np.sin(5 * t), 1.0, 0.0])],
    "all": [Orbit(0.3), AirDrag(density=20.0), BodyDrag("few", 0.02, 20.0, 0.5), Gravity([0, 0, -9.81])],
}


def flown(loads, options, *, restraints=(), times=(0.0, 0.021, 0.05)):
    net = random_net(3)
    system = System(net, CORD, damping=Dashpot(viscosity_time=1e-3), loads=loads, restraints=restraints)
    start = State.at(net.nodes, random_velocities(net, 3) * ~system.restrained)
    return system, simulate(system, start, times, options=options)


@pytest.mark.parametrize("name", LOADS)
def test_nets_fly_and_balance_as_with_ida(name, monkeypatch):
    """Also where a frame lies inside a chunk, and where some axes are held."""
    monkeypatch.setattr("netdae.solvers.explicit.stepper.CHUNK", 128)
    monkeypatch.setattr("netdae.solvers.explicit.stepper.SPAN", np.inf)  # all chunks have so many steps
    held = [Restraint("one", "xz")]
    _, sharp = flown(LOADS[name], SHARP, restraints=held)
    errors = []
    for h in (2e-5, 1e-5):
        _, flight = flown(LOADS[name], explicit_options(max_step=h), restraints=held)
        errors.append(
            [
                np.abs(flight.positions - sharp.positions).max(),
                np.abs(flight.velocities - sharp.velocities).max(),
                np.abs(flight.dissipated_energy - sharp.dissipated_energy).max(),
                np.abs(flight.external_work - sharp.external_work).max(),
                np.abs(flight.external_impulse - sharp.external_impulse).max(),
                np.abs(flight.external_angular_impulse - sharp.external_angular_impulse).max(),
            ]
        )
    # of 0.2 m of way, 6 m/s, 2.7 J lost, 0.1 to 6 J of work, 7 N s and 3 N m s; measured up to 4e-6, 3e-4, 7e-4, 1e-4,
    # 2e-5 and 9e-6: the dashpot is of the first order in h
    assert (np.array(errors[0]) < [3e-5, 2e-3, 3e-3, 5e-4, 1e-4, 5e-5]).all()
    assert (
        np.array(errors[1]) < np.maximum(0.6 * np.array(errors[0]), 1e-6)
    ).all()  # some are as small as IDA's own


def test_momentum_and_angular_momentum_of_a_free_net_are_those_that_are_booked():
    system, flight = flown(LOADS["all"], explicit_options())
    first, last = flight[0], flight[-1]
    got = system.momentum(last.v) - system.momentum(first.v)
    turned = system.angular_momentum(last.x, last.v) - system.angular_momentum(first.x, first.v)
    assert np.abs(turned).max() > 1.0  # N m s
    # round-off of some thousand steps at 1e-16 of 20 N s
    np.testing.assert_allclose(last.balance.external_impulse, got, rtol=0, atol=1e-12)
    np.testing.assert_allclose(last.balance.external_angular_impulse, turned, rtol=0, atol=1e-12)


class Springs:
    """A user-defined force: springs k from nodes to the origin with dampers c, k = 1."""

    jumps, kinks, external = (), (), True

    def __init__(self, nodes, k, c, newton):
        self.nodes, self.k, self.c, self.newton = np.array(nodes)[:, None], k, c, newton

    def force(self, t, x, v):
        return -self.k * x - self.c * v

    def tangent(self, t, x, v):
        unit = np.broadcast_to(np.eye(3)[None, None, :, None, :], (len(x), 1, 3, 1, 3))
        return Tangent.of_all(-self.k * unit, -self.c * unit)

    def account(self, t, x, v):
        lost = self.c * np.vdot(v, v)
        return Account(0.5 * self.k * np.vdot(x, x), lost, 0.0)


@pytest.mark.parametrize(("k", "newton"), [(0.5, "nothing"), (5e4, "nothing"), (5e4, "symmetric")])
def test_a_user_defined_force_flies_whether_it_is_soft_or_stiff(k, newton):
    """m ẍ + c ẋ + k x = 0 as in textbooks; a stiff one bounds the step."""
    c, end = 0.1 * np.sqrt(k), 3.0 / np.sqrt(k)
    system = pair(forces=[Springs([1], k, c, newton)])
    start = State.at(system.net.nodes)
    m = system.mass[1]
    zeta = c / (2 * np.sqrt(k * m))
    omega = np.sqrt(k / m * (1 - zeta**2))
    decay = np.exp(-c * end / (2 * m))
    exact = decay * (np.cos(omega * end) + zeta / np.sqrt(1 - zeta**2) * np.sin(omega * end))
    errors = []
    for accuracy in ("standard", "accurate"):
        options = explicit_options(accuracy=accuracy, max_step=1e-3)
        flight = simulate(system, start, [0.0, end], options=options)
        errors.append(abs(flight[-1].x[1, 0] - exact))
        balance = flight[-1].balance
        # what the spring stores is energy of the system, and what its damper takes is lost
        first, last = (system.elastic_energy(state.x) for state in (flight[0], flight[-1]))
        gained = system.kinetic_energy(flight[-1].v) + last - first
        # leapfrog keeps an energy that differs from this one by (h ω)²/8 of it, on both ends
        h = end / flight.statistics["steps"]
        assert gained + balance.dissipated_energy == pytest.approx(0.0, abs=0.25 * h * h * k / m * first)
        assert last == pytest.approx(0.5 * k * exact**2, abs=1e-2 * k)
        assert balance.external_work == 0.0
        omega_h = h * np.sqrt(k / m)
        # leapfrog's phase errs by (ωh)²/24 of 3/√m rad, the damper taken ahead by as much again
        assert errors[-1] < 2 * omega_h**2 / 24 * 3 / np.sqrt(m)
    assert errors[0] < (5e-3 if k > 1 else 1e-7)


def test_a_driven_node_is_not_moved_and_its_reaction_answers():
    system, flight = flown([Orbit(0.3)], explicit_options(), restraints=[Restraint("one")])
    assert (flight.positions[:, 0] == flight.positions[0, 0]).all()
    first, last = flight[0], flight[-1]
    got = system.momentum(last.v) - system.momentum(first.v)
    # to round-off: momentum is the sum of forces by the trapezoidal rule, as reactions are
    np.testing.assert_allclose(last.balance.external_impulse, got, rtol=0, atol=1e-12 * np.abs(got).max())


class Wall(Springs):
    """A stiff spring that pushes where x is below zero, of which Newton's matrix takes its part."""

    def force(self, t, x, v):
        return np.where([True, False, False], -self.k * np.minimum(x, 0.0), 0.0)

    def tangent(self, t, x, v):
        return Tangent.of_all(
            *(np.where(x < 0, 1.0, 0.0)[0, 0, 0] * part for part in super().tangent(t, x, v)[1:])
        )


def test_a_wall_that_is_met_in_flight_throws_a_mass_back_with_its_speed():
    """The force is nothing until the mass is there, which is after many chunks, and soon stiff."""
    system = pair(forces=[Wall([1], 1e6, 0.0, "symmetric")])
    start = State.at(system.net.nodes, [[0, 0, 0], [-5.0, 0, 0]])
    flight = simulate(system, start, [0.0, 0.19, 0.4], options=explicit_options(max_step=1e-3))
    np.testing.assert_allclose(flight[1].v[1], [-5, 0, 0], rtol=1e-12, atol=0)
    # in half a period, 6 ms, of which a step is at first a sixth, and then 0.2/ω = 0.4 ms
    np.testing.assert_allclose(flight[2].v[1], [5, 0, 0], rtol=0.05, atol=0)
