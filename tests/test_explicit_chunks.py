"""Chunks of explicit steps: each step is the velocity Verlet's, can be reported, and continued bit for bit."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from conftest import SOFT, random_net, random_velocities, reference_flight

from netdae.forces.elements import ElementForce
from netdae.forces.loads import Gravity, NodalLoad
from netdae.forces.motor import MOTOR, Motor
from netdae.forces.orbit import Orbit
from netdae.forces.rings import Rings
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.signals import Table
from netdae.model.state import State
from netdae.solvers.explicit.stepper import ExplicitSolver
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping, Rayleigh
from netdae.system.reels import Reel
from netdae.system.system import System

TABLE = Table([0.0, 0.02, 0.4], [[0, 0, 0], [0.3, 0.2, 0], [0.1, 0, 0.1]])


def net_in_flight(seed=5, speed=10.0, **more):
    """A net whose cables go slack and taut at some metres a second."""
    net = random_net(seed)
    settings = {"damping": Dashpot(viscosity_time=2e-4), **more}
    system = System(net, SOFT, **settings)
    return system, State.at(net.nodes, random_velocities(net, seed, speed) * ~system.restrained)


def with_reel(damping=None):
    """A tether of two cables between two bodies, of which one is paid out under a brake."""
    nodes = np.array([[0, 0, 0], [0.5, 0, 0], [1.0, 0, 0], [0, 0, 0]], dtype=float)
    net = CableNet(nodes, [[0, 1], [1, 2]], {"ends": [0, 2]}, rest_length=[0.5, 0.5])
    reel = Reel(3, [0], inertia=0.05, brake_force=0.3, longest=4.0)
    system = System(
        net,
        SOFT,
        masses={"ends": 0.2},
        damping=damping or Dashpot(viscosity_time=2e-4),
        reels=[reel],
    )
    v = np.zeros((4, 3))
    v[2] = [4.0, 0.3, 0.0]
    return system, State.at(nodes * 0.9, v)


def with_cord():
    """A cord with friction through the corners of a net, wound in by a motor."""
    net = CableNet.square(side=1.0, cells=2)
    corners = np.array([0, 2, 8, 6])
    nodes = np.vstack((net.nodes, np.zeros(3)))
    cables = np.vstack((net.cables, np.stack((corners, np.roll(corners, -1)), axis=1)))
    length = np.linalg.norm(nodes[cables[:, 1]] - nodes[cables[:, 0]], axis=1)
    strung = CableNet(nodes, cables, {"knots": np.arange(9)}, rest_length=length)
    rings = Rings(friction=0.2, fastened=False)
    reel = Reel(
        9, np.arange(len(net.cables), len(cables)), inertia=0.02, share=-1.0, rings=rings, longest=2.0
    )
    motor = ElementForce(MOTOR, np.array([[9]]), Motor(*np.array([[3.0], [2.0], [0.1], [0.02]])))
    system = System(
        strung,
        SOFT,
        masses={"knots": 0.01},
        damping=Dashpot(viscosity_time=2e-4),
        reels=[reel],
        forces=[motor],
    )
    return system, State.at(nodes * 0.95)


def solver_at(system, start, **more):
    options = SolverOptions(method="explicit", **more)
    solver = ExplicitSolver(system, system.drive_from(start.x), options)
    a = system.acceleration(0.0, start.x, start.v)
    enter(solver, system, 0.0, start.x, start.v, a)
    return solver


def enter(solver, system, t, x, v, a):
    solver.enter(system, t, np.stack((x, v)), np.stack((v, a)))
    solver.go_on(system)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("damping", [Dashpot(viscosity_time=1e-9), Dashpot(viscosity_time=2e-4)])
def test_each_step_is_that_of_the_velocity_verlet_over_all_cables(seed, damping):
    """Cables that were far from taut pull from the very step on in which they are so."""
    system, start = net_in_flight(seed, damping=damping)
    h, steps = 2e-4, 400
    solver = solver_at(system, start, max_step=h)
    solver.every_step = True
    reported = []
    while len(reported) < steps:
        reported += solver.step(steps * h)
    x, v, a = start.x.copy(), start.v.copy(), system.acceleration(0.0, start.x, start.v)
    taut, snaps = system.strain(x) > 0, 0
    for step in reported:
        v += 0.5 * h * a
        x += h * v
        a = system.acceleration(0.0, x, v)
        v += 0.5 * h * a
        now = system.strain(x) > 0
        taut, snaps = now, snaps + np.count_nonzero(now & ~taut)
        # round-off of 400 steps, amplified by snaps: measured 1e-12; a step late would be 1e-5 m/s
        np.testing.assert_allclose(step.y[0], x, rtol=0, atol=1e-10)
        np.testing.assert_allclose(step.y[1], v, rtol=0, atol=1e-8)
        np.testing.assert_allclose(step.yp[1], a, rtol=0, atol=1e-8 * np.abs(a).max())
    assert snaps >= 5


def with_toe():
    net = random_net(5)
    cord = Material(youngs_modulus=1e7, density=1000.0, diameter=2e-3, toe_strain=0.1, law="engineering")
    system = System(net, cord, damping=Dashpot(zeta=0.1))
    return system, State.at(net.nodes, random_velocities(net, 5, 3.0))


CASES = {
    "plain": lambda: reference_flight(6),
    "toe": with_toe,
    "loads": lambda: net_in_flight(loads=[Gravity([0, 0, -9.81]), NodalLoad("few", TABLE)]),
    "held": lambda: net_in_flight(restraints=[Restraint("few", "xz")], loads=[Orbit(0.5)]),
    "undamped": lambda: reference_flight(6, damping=NoDamping()),
    "undamped and held": lambda: net_in_flight(
        damping=NoDamping(), restraints=[Restraint("few", "xz")], loads=[Orbit(0.5), NodalLoad("few", TABLE)]
    ),
    "orbit": lambda: net_in_flight(loads=[Orbit(0.5)]),
    "rayleigh": lambda: net_in_flight(
        damping=Rayleigh(alpha=2.0, beta=1e-3), restraints=[Restraint("few", "xz")]
    ),
    "reel": with_reel,
    "cord": with_cord,
}


@pytest.mark.parametrize("case", CASES)
def test_a_solver_goes_on_bit_for_bit_from_the_memory_of_another(case):
    system, start = CASES[case]()
    end = 1000.0
    first = solver_at(system, start, accuracy="accurate")
    last = start
    for _ in range(3 if case == "reel" else 4):  # while it pays out
        *_, last = first.step(end)
    memory = {name: array.copy() for name, array in first.memory().items()}
    options = SolverOptions(method="explicit", accuracy="accurate")
    second = ExplicitSolver(system, system.drive_from(start.x), options)
    enter(second, system, last.t, last.y[0], last.y[1], last.yp[1])
    second.restore(memory)
    assert last.t < end
    for _ in range(40):
        both = zip(first.step(end), second.step(end), strict=True)
        for last, other in both:
            assert last.t == other.t
            np.testing.assert_array_equal(last.y, other.y)
            np.testing.assert_array_equal(last.yp, other.yp)
            assert tuple(map(repr, last.share)) == tuple(map(repr, other.share))
    for t in (last.t, np.nextafter(last.t, 0.0), 0.5 * (last.t + first._chunk.t)):
        np.testing.assert_array_equal(first.output(t).y, second.output(t).y)


@pytest.mark.parametrize("case", CASES)
def test_a_flight_of_which_each_step_is_reported_is_the_same_flight(case):
    system, start = CASES[case]()
    # at "fast", 0.9 of the linear bound, a cable at its kink may gain energy from step to step
    quiet, reported = (solver_at(system, start, accuracy="standard") for _ in range(2))
    reported.every_step = True
    for _ in range(6):
        chunk, steps = quiet.step(1000.0), reported.step(1000.0)
        np.testing.assert_array_equal(chunk[-1].y, steps[-1].y)
        np.testing.assert_array_equal(chunk[-1].yp, steps[-1].yp)
        # sums of the same numbers in another order
        for part in range(3):
            sums = [sum(np.asarray(step.share[part]) for step in reported) for reported in (chunk, steps)]
            np.testing.assert_allclose(*sums, rtol=1e-9, atol=1e-12)
        assert max(step.share.peak_tension for step in chunk) == max(
            step.share.peak_tension for step in steps
        )
        for step in steps[:: max(1, len(steps) // 5)]:
            # output re-flies the chunk: the same numbers but for the interpolation's round-off
            np.testing.assert_allclose(reported.output(step.t).y, step.y, rtol=1e-11, atol=1e-13)
        for former, step in pairwise(steps[-3:]):
            # what the balance gains in a step it gains in proportion
            inner = reported.output(0.25 * former.t + 0.75 * step.t)
            for part in range(3):
                np.testing.assert_allclose(inner.share[part], 0.75 * step.share[part], rtol=1e-6, atol=1e-12)
