"""Rayleigh damping flown by the explicit method: implicit, of the second order, and no bound on the step."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import CORD, SOFT, line, random_net, random_velocities, reference_flight
from flights import explicit_options
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from netdae.model.motions import FunctionMotion
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.solvers.explicit.rayleigh import ImplicitDamping, damp, drags_of
from netdae.solvers.explicit.stable_step import stable_step
from netdae.solvers.explicit.stepper import ExplicitSolver
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import NoDamping, Rayleigh
from netdae.system.system import System

STRONG = Rayleigh(alpha=2.0, beta=1e-2)


def drags_in(system):
    steady = [force for force in system.forces if force.law.steady]
    assert len(steady) == (system.damping.alpha > 0) + (system.damping.beta > 0)
    return drags_of(steady, 3 * system.net.node_count)


def turned(net, angles=(0.3, 0.5, 0.7)):
    nodes = net.nodes @ Rotation.from_euler("xyz", angles).as_matrix().T
    return CableNet(nodes, net.cables, net.node_groups, rest_length=net.rest_length)


NETS = {
    "square": CableNet.square(side=2.0, cells=4),
    "subdivided": CableNet.square(side=2.0, cells=3, subdivide=3),
    "turned": turned(CableNet.square(side=2.0, cells=4)),
    "hexagon": CableNet.hexagon(radius=1.0, rings=3),
    "radial": turned(CableNet.radial(radius=1.0, rings=3, spokes=7)),
    "diamond": CableNet.diamond(side=2.0, cells=3),
    "random": random_net(3),
    "straight": turned(line(5)),
}
HELD = {"free": "", "node held": "xyz", "axes held": "xz"}


@pytest.mark.parametrize("name", NETS)
@pytest.mark.parametrize("axes", HELD.values(), ids=list(HELD))
def test_velocities_solve_the_implicit_equation_in_any_net(name, axes):
    """(M + h/2 D) v = M w + h/2 f with the paper's D, dense; held axes move as they are reported."""
    net, rng, h = NETS[name], np.random.default_rng(1), 1e-2
    system = System(net, SOFT, damping=STRONG, masses={"all": 1e-3})
    mass = np.repeat(system.mass, 3)
    entry = np.array([3 * node + "xyz".index(axis) for node in (0, 3) for axis in axes], dtype=np.int64)
    implicit = ImplicitDamping(drags_in(system), mass, entry)
    w, f = rng.standard_normal((2, len(mass)))
    speed = rng.standard_normal(len(entry))
    v, viscous = np.empty((2, len(mass)))
    damp(w, mass, f, h, implicit.at(h), entry, speed, v, viscous)
    D, M = system.damping_matrix().toarray(), np.diag(mass)
    free = np.setdiff1d(np.arange(len(mass)), entry)
    A = (M + 0.5 * h * D)[free]
    right = (M @ w + 0.5 * h * f)[free] - A[:, entry] @ speed
    exact = np.zeros(len(mass))
    exact[free], exact[entry] = np.linalg.solve(A[:, free], right), speed
    assert (v[entry] == speed).all()
    np.testing.assert_allclose(v, exact, rtol=0, atol=1e-12)  # round-off times a condition of 1e3
    np.testing.assert_allclose(viscous, -D @ exact, rtol=0, atol=1e-10 * np.abs(viscous).max())
    # the damping of cables sums to no force, to round-off of the largest of them
    inner = viscous + 2.0 * mass * v
    assert np.abs(inner.reshape(-1, 3).sum(axis=0)).max() < 1e-13 * np.abs(viscous).sum()


@pytest.mark.parametrize("rotation_deg", [(0, 0, 0), (20, 30, 40)])
def test_the_factor_of_a_square_net_is_that_of_its_lines(rotation_deg):
    system, _ = reference_flight(20, damping=STRONG, rotation_deg=rotation_deg)
    drags = drags_in(system)
    factor = ImplicitDamping(drags, np.repeat(system.mass, 3), np.zeros(0, dtype=np.int64)).at(1e-5).factor
    lines, knots = 2 * 21, 21
    assert len(factor.inverse) == lines * knots
    assert len(factor.L) == lines * (knots - 1)


def leapfrog(system, x, v, h, steps):
    """x and v after each step of (M + h/2 D) w₊ = (M − h/2 D) w₋ + h f(x), dense, v = (w₋ + w₊)/2."""
    M, D = system.mass_matrix().toarray(), system.damping_matrix().toarray()
    A, B = M + 0.5 * h * D, M - 0.5 * h * D

    def f(x):
        return system.force(0.0, x, np.zeros_like(x)).ravel()

    w = np.linalg.solve(A, M @ v.ravel() + 0.5 * h * f(x))
    for _ in range(steps):
        x = x + h * w.reshape(-1, 3)
        after = np.linalg.solve(A, B @ w + h * f(x))
        yield x, 0.5 * (w + after).reshape(-1, 3)
        w = after


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("damping", [STRONG, Rayleigh(beta=1e-5), Rayleigh(alpha=20.0)])
def test_each_step_is_the_leapfrog_with_the_trapezoidal_rule_for_the_damping(seed, damping):
    net = random_net(seed)
    system = System(net, SOFT, damping=damping)
    start = State.at(net.nodes, random_velocities(net, seed, 10.0))
    h, steps = 2e-4, 300
    solver = ExplicitSolver(system, system.drive_from(start.x), explicit_options(max_step=h))
    solver.every_step = True
    a = system.acceleration(0.0, start.x, start.v)
    solver.enter(system, 0.0, np.stack((start.x, start.v)), np.stack((start.v, a)))
    reported, snaps, taut = [], 0, system.strain(start.x) > 0
    while len(reported) < steps:
        reported += solver.step(1.0)
    for step, (x, v) in zip(reported[:steps], leapfrog(system, start.x, start.v, h, steps), strict=True):
        taut, former = system.strain(x) > 0, taut
        snaps += np.count_nonzero(taut & ~former)
        # round-off of 300 steps, amplified by snaps: a step late would be 1e-5 m/s
        np.testing.assert_allclose(step.y[0], x, rtol=0, atol=1e-10)
        np.testing.assert_allclose(step.y[1], v, rtol=0, atol=1e-8)
    assert snaps >= 1


def taut_string(damping, **more):
    """Five masses on a string that stays taut, so that all is smooth, damped across and along."""
    net = line(4)
    system = System(net, SOFT, damping=damping, restraints=[Restraint("first"), Restraint("last", **more)])
    v = np.zeros((5, 3))
    v[1:4, 2], v[1:4, 0] = [0.5, -0.3, 0.2], [0.2, 0.1, -0.4]
    return system, State.at(net.nodes * 1.05, v)


@pytest.mark.parametrize("beta", [1e-5, 1e-3, 3e-2])  # of the stiffest mode ζ = 0.04, 4 and 120
def test_errors_and_energy_residual_fall_with_the_square_of_the_step(beta):
    system, start = taut_string(Rayleigh(alpha=5.0, beta=beta))
    free, end = ~system.restrained.all(axis=1), 0.02

    def rates(t, y):
        x, v = start.x.copy(), np.zeros_like(start.x)
        x[free], v[free] = y.reshape(2, -1, 3)
        return np.stack((v[free], system.acceleration(t, x, v)[free])).ravel()

    y0 = np.stack((start.x[free], start.v[free])).ravel()
    y = solve_ivp(rates, (0, end), y0, method="Radau", rtol=1e-11, atol=1e-13).y[:, -1].reshape(2, -1, 3)
    errors, steps = [], np.array([4e-5, 2e-5, 1e-5])
    for h in steps:
        flight = simulate(system, start, [0.0, end], options=explicit_options(max_step=h))
        first, last = (
            system.kinetic_energy(s.v) + system.elastic_energy(s.x) for s in (flight[0], flight[-1])
        )
        residual = last + flight[-1].balance.dissipated_energy - first
        errors.append([np.abs(flight[-1].x[free] - y[0]).max(), abs(residual)])
    slopes = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    np.testing.assert_allclose(slopes, 2.0, atol=0.25)
    assert errors[-1][1] < 1e-3 * first


@pytest.mark.parametrize("beta", [1e-2, 1.0])
def test_no_damping_is_too_strong_for_the_undamped_step(beta):
    """Of the stiffest mode ζ is 150 and more; the energy that the flight has not lost is in the balance."""
    system, start = reference_flight(6, damping=Rayleigh(beta=beta))
    undamped, _ = reference_flight(6, damping=NoDamping())
    assert stable_step(system, 1e-3) == stable_step(undamped, 1e-3)
    flight = simulate(system, start, np.linspace(0.0, 1.0, 21), options=explicit_options(accuracy="fast"))
    kept = np.array([system.kinetic_energy(s.v) + system.elastic_energy(s.x) for s in flight])
    booked = kept + flight.dissipated_energy - kept[0]
    assert (np.diff(kept) < 1e-3 * kept[0]).all()
    assert kept[-1] < 0.9 * kept[0]
    # 0.5 % are lost in the first half step, before there is any step
    assert np.abs(booked).max() < 0.01 * kept[0]


@pytest.mark.parametrize("net", ["square", "hexagon"])
def test_momentum_is_kept_to_round_off(net):
    system, start = reference_flight(8, damping=Rayleigh(beta=1e-3))
    if net == "hexagon":
        system = System(
            CableNet.hexagon(radius=3.0, rings=4), CORD, masses={"corners": 0.5}, damping=Rayleigh(beta=1e-3)
        )
        start = State.at(0.6 * system.net.nodes, random_velocities(system.net, 1))
    flight = simulate(system, start, [0.0, 1.0], options=explicit_options(accuracy="fast"))
    change = system.momentum(flight[-1].v) - system.momentum(start.v)
    whole = (system.mass * np.linalg.norm(start.v, axis=1)).sum()
    assert np.abs(change).max() < 1e-12 * whole
    assert flight[-1].balance.external_impulse == (0.0, 0.0, 0.0)


def test_impulse_and_moment_that_the_damping_of_masses_takes_are_booked_exactly():
    net = random_net(2)
    system = System(net, SOFT, damping=Rayleigh(alpha=20.0, beta=1e-3))
    start = State.at(net.nodes, random_velocities(net, 2, 3.0))
    flight = simulate(system, start, [0.0, 0.1], options=explicit_options(max_step=1e-4))
    first, last = flight[0], flight[-1]
    gained = system.momentum(last.v) - system.momentum(first.v)
    np.testing.assert_allclose(last.balance.external_impulse, gained, rtol=1e-11, atol=0)
    # uniformly braked, momentum falls as exp(−α t); of the order of (α h)² = 4e-6 the steps are off, the first most
    np.testing.assert_allclose(gained, np.expm1(-20.0 * 0.1) * system.momentum(first.v), rtol=1e-5)


def wave(t):
    w = 30.0
    return [0.02 * (1 - np.cos(w * t)), 0.02 * w * np.sin(w * t), 0.02 * w**2 * np.cos(w * t)]


def test_a_driven_node_shakes_an_overdamped_net_and_its_work_and_impulse_are_booked():
    motion = FunctionMotion(*(lambda t, k=k: [wave(t)[k], 0.0, 0.0] for k in range(3)))
    system, start = taut_string(Rayleigh(beta=3e-2), motion=motion)
    sharp = SolverOptions(rtol=1e-10, atol_position=1e-12, atol_velocity=1e-10)
    truth = simulate(system, start, [0.0, 0.1], options=sharp)[-1]
    errors, steps = [], [4e-5, 2e-5]
    for h in steps:
        flight = simulate(system, start, [0.0, 0.1], options=explicit_options(max_step=h))
        first, last, balance = flight[0], flight[-1], flight[-1].balance
        kept = [system.kinetic_energy(s.v) + system.elastic_energy(s.x) for s in (first, last)]
        gained = system.momentum(last.v) - system.momentum(first.v)
        errors.append(
            [
                np.abs(last.x - truth.x).max(),
                abs(kept[1] - kept[0] + balance.dissipated_energy - balance.external_work),
                np.abs(np.array(balance.external_impulse) - gained).max(),
            ]
        )
    # ways of 4 cm, 0.1 J, 0.01 N s
    assert (np.array(errors[1]) < [2e-7, 2e-5, 2e-6]).all(), errors


@pytest.mark.parametrize("beta", [1e-3, 1e-4])
@pytest.mark.parametrize(("accuracy", "millimetres"), [("fast", 4), ("standard", 3), ("accurate", 2)])
def test_the_reference_flight_is_that_of_tight_steps(beta, accuracy, millimetres):
    """Against a twentieth of the stable step; bullets, area of the corners and energy, as all methods are judged."""
    system, start = reference_flight(10, damping=Rayleigh(beta=beta))
    tight = explicit_options(accuracy="accurate", max_step=5e-6)
    truth, flown = (
        simulate(system, start, [0.0, 0.5, 1.0], options=options)
        for options in (tight, explicit_options(accuracy=accuracy))
    )
    corners = system.net.nodes_of("corners")
    for one, other in zip(flown, truth, strict=True):
        assert np.abs(one.x - other.x)[corners].max() < 1e-3 * millimetres
        energies = [system.kinetic_energy(s.v) + system.elastic_energy(s.x) for s in (one, other)]
        assert energies[0] == pytest.approx(energies[1], rel=0.01)
