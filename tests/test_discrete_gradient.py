"""The step of undamped nets: it keeps energy and both momenta, is of second order, and finds tensions inside steps."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import SOFT, line, random_net, random_velocities

from netdae.core.records import Record
from netdae.forces.elements import ElementForce
from netdae.forces.loads import Gravity, NodalLoad
from netdae.forces.loops import SUMS, loop_of
from netdae.forces.spring import Spring
from netdae.model.material import Material
from netdae.model.motions import FunctionMotion
from netdae.model.restraints import Restraint
from netdae.model.signals import Table
from netdae.model.state import State
from netdae.solvers.explicit.discrete_gradient import LONGEST
from netdae.solvers.explicit.stepper import ExplicitSolver
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping, Rayleigh
from netdae.system.system import System

LAWS = {
    "plain": {},
    "toe": {"toe_strain": 0.05},
    "engineering": {"law": "engineering"},
    "engineering toe": {"law": "engineering", "toe_strain": 0.05},
}


def cord(**more):
    return Material(youngs_modulus=1e7, density=1000.0, diameter=2e-3, **more)


def solver_at(system, start, **more):
    solver = ExplicitSolver(system, system.drive_from(start.x), SolverOptions(method="explicit", **more))
    a = system.acceleration(0.0, start.x, start.v)
    solver.enter(system, 0.0, np.stack((start.x, start.v)), np.stack((start.v, a)))
    solver.go_on(system)
    return solver


def energy_of(system, x, v):
    return system.kinetic_energy(v) + system.elastic_energy(x)


def mean_force(force: ElementForce, x, y, n):
    elements: Record = force.elements(force.nodes, np.ones(n, dtype=np.bool_))
    f, sums = np.zeros((n, 3)), np.zeros(SUMS)
    between = loop_of(force.law, "between").ctypes
    between(elements.address, *(each.ctypes.data for each in (x, y, f, sums)))
    return f, sums


@pytest.mark.parametrize("law", LAWS)
def test_mean_forces_of_cables_do_the_work_of_the_stored_energy(law):
    """Slack, in the toe and above it, from each to each; and near each other they are the force."""
    system = System(line(1), cord(**LAWS[law]), damping=NoDamping())
    rng = np.random.default_rng(3)
    force = system.cables.force
    for before in (0.9, 0.999, 1.0, 1.02, 1.04, 1.2):
        for after in (0.8, 1.0, 1.01, 1.03, 1.3):
            ends = rng.normal(size=(2, 3))
            ends *= (np.array([before, after]) / np.linalg.norm(ends, axis=1))[:, None]
            x, y = (np.stack((np.full(3, 0.1), 0.1 + end)) for end in ends)
            f, _ = mean_force(force, x, y, 2)
            gain = system.elastic_energy(x) - system.elastic_energy(y)
            assert np.vdot(f, y - x) == pytest.approx(gain, rel=1e-12, abs=1e-14)
            np.testing.assert_array_equal(f[0], -f[1])
            along = np.cross(f[0], ends.sum(axis=0))
            np.testing.assert_allclose(along, 0.0, atol=1e-13)  # of f of some newtons
        close = x.copy()
        close[1] *= 1 + 1e-9
        exact = force.force(0.0, x[None], np.zeros((1, 2, 3)))[0]
        for other in (x, close):
            np.testing.assert_allclose(mean_force(force, x, other, 2)[0], exact, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("rest", [0.0, 0.7])
@pytest.mark.parametrize("to", [None, "first"])
def test_mean_forces_of_springs_do_the_work_of_the_stored_energy(rest, to):
    net = line(2)
    spring = Spring("last", 30.0, to=to, anchor=None if to else [0.3, 0.2, 0.1], rest_length=rest)
    system = System(net, SOFT, damping=NoDamping(), forces=[])
    force = spring.on(net, system.cords, system.mass)
    rng = np.random.default_rng(1)
    for _ in range(20):
        x, y = rng.normal(size=(2, 3, 3))
        f, sums = mean_force(force, x, y, 3)
        zero = np.zeros((1, force.nodes.shape[1], 3))
        stored = [force.account(0.0, each[force.nodes], zero).stored_energy for each in (x, y)]
        assert np.vdot(f, y - x) == pytest.approx(stored[0] - stored[1], rel=1e-12, abs=1e-12)
        if to is None:  # the ground gives force and torque, at the mean place
            np.testing.assert_allclose(sums[3:6], f.sum(axis=0), rtol=1e-13)
            np.testing.assert_allclose(sums[6:9], np.cross(0.5 * (x + y), f).sum(axis=0), atol=1e-12)


@pytest.mark.parametrize("accuracy", ["fast", "standard", "accurate"])
@pytest.mark.parametrize("law", LAWS)
def test_an_undamped_free_net_keeps_energy_and_both_momenta(law, accuracy):
    net = random_net(4)
    system = System(net, cord(**LAWS[law]), damping=NoDamping())
    start = State.at(net.nodes, random_velocities(net, 4, 8.0))
    flight = simulate(
        system, start, [0.0, 0.5, 1.0], options=SolverOptions(method="explicit", accuracy=accuracy)
    )
    first, last = flight[0], flight[-1]
    assert flight.peak_tension.max() > 1.0
    # places are found to 1e-13 m: 1e-12 of the energy a step, at random, over some thousand steps
    assert energy_of(system, last.x, last.v) == pytest.approx(energy_of(system, first.x, first.v), rel=1e-9)
    p = system.mass[:, None] * first.v
    q = system.mass[:, None] * last.v
    np.testing.assert_allclose(q.sum(axis=0), p.sum(axis=0), atol=1e-12 * np.abs(p).sum())
    turns = [np.cross(s.x, system.mass[:, None] * s.v).sum(axis=0) for s in (first, last)]
    np.testing.assert_allclose(turns[1], turns[0], atol=1e-11 * np.abs(np.cross(first.x, p)).sum())


@pytest.mark.parametrize("accuracy", ["fast", "standard", "accurate"])
def test_a_taut_string_near_slack_keeps_its_energy(accuracy):
    """Verlet gains 80 % in 7000 steps at half of the bound, and 13 % at 0.15 of it."""
    net = line(10)
    stiff = Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)
    held = [Restraint("first"), Restraint("last")]
    system = System(net, stiff, damping=NoDamping(), restraints=held)
    x = net.nodes * 1.001
    x[5, 2] += 0.02
    solver = solver_at(system, State.at(x), accuracy=accuracy)
    start = energy_of(system, x, np.zeros_like(x))
    while solver.counts["steps"] < 60_000:
        solver.step(100.0)
    assert (system.strain(solver._places()[0]) < 0).any()
    # 5e-8 after 1e6 steps
    assert energy_of(system, *solver._places()) == pytest.approx(start, rel=1e-8)


def test_the_error_falls_with_the_square_of_the_step():
    """Of a taut string with a load that changes, gravity and a driven end, against IDA."""
    net = line(4)
    motion = FunctionMotion(
        lambda t: [0.0, 0.01 * (1 - math.cos(300 * t)), 0.0],
        lambda t: [0.0, 3 * math.sin(300 * t), 0.0],
        lambda t: [0.0, 900 * math.cos(300 * t), 0.0],
    )
    loads = [Gravity([0, 0, -9.81]), NodalLoad("inner", Table([0.0, 1.0], [[0, 0, 0], [0, 3.0, 1.0]]))]
    system = System(
        net,
        SOFT,
        damping=NoDamping(),
        loads=loads,
        restraints=[Restraint("first"), Restraint("last", "xyz", motion)],
    )
    v = np.zeros((5, 3))
    v[1:4, 2] = [0.5, -0.3, 0.2]
    start = State.at(net.nodes * 1.05, v)
    sharp = SolverOptions(rtol=1e-10, atol_position=1e-12, atol_velocity=1e-10)
    exact = simulate(system, start, [0.0, 0.02], options=sharp)[-1]
    steps, errors, balance = [4e-5, 2e-5, 1e-5], [], []
    before = energy_of(system, start.x, start.v)
    for h in steps:
        options = SolverOptions(method="explicit", max_step=h)
        flown = simulate(system, start, [0.0, 0.02], options=options)[-1]
        errors.append(np.abs(flown.x - exact.x).max())
        balance.append(
            abs(energy_of(system, flown.x, flown.v) - before - flown.balance.external_work) / before
        )
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope == pytest.approx(2.0, abs=0.1)
    assert balance[-1] < 1e-6  # the drive's work is of second order


def test_kicks_and_restraints_balance_to_round_off():
    """Work, impulse and angular impulse of loads, held axes and springs to the ground."""
    net = random_net(2)
    load = NodalLoad("few", Table([0.0, 1.0], [[1.0, 0, 2.0], [0.3, 0.2, 0]]))
    system = System(
        net,
        SOFT,
        damping=NoDamping(),
        loads=[load, Spring("one", 20.0, anchor=[0, 0, 1.0])],
        restraints=[Restraint("few", "x")],
    )
    start = State.at(net.nodes, random_velocities(net, 2, 5.0) * ~system.restrained)
    first, last = simulate(system, start, [0.0, 0.4], options=SolverOptions(method="explicit"))
    gained = energy_of(system, last.x, last.v) - energy_of(system, first.x, first.v)
    assert last.balance.external_work == pytest.approx(gained, rel=1e-9)
    p = [system.mass[:, None] * state.v for state in (first, last)]
    np.testing.assert_allclose(
        last.balance.external_impulse, (p[1] - p[0]).sum(axis=0), atol=1e-11 * np.abs(p).max()
    )
    turn = np.cross(last.x, p[1]).sum(axis=0) - np.cross(first.x, p[0]).sum(axis=0)
    np.testing.assert_allclose(last.balance.external_angular_impulse, turn, atol=1e-10)


@pytest.mark.parametrize("accuracy", ["fast", "standard", "accurate"])
def test_the_largest_tension_is_found_inside_a_step(accuracy):
    """A mass that runs into its cord, by energy: ½ m v² = ½ EA L E11², N = EA E11 √(1 + 2 E11)."""
    net = line(1)
    stiff = Material(youngs_modulus=70e9, linear_density=1e-9, diameter=1e-3)
    system = System(net, stiff, damping=NoDamping(), masses={"last": 1.0}, restraints=[Restraint("first")])
    EA = float(system.cables.EA[0])
    strain = math.sqrt(2.5**2 / EA)
    exact = EA * strain * math.sqrt(1 + 2 * strain)
    start = State.at(net.nodes * 0.99, np.array([[0, 0, 0], [2.5, 0, 0]]))
    seen = []

    class Watcher:
        def watch(self, state):
            seen.append(system.peak_tension(state.x))

        def __call__(self, state):
            pass

    options = SolverOptions(method="explicit", accuracy=accuracy)
    flight = simulate(system, start, [0.0, 0.1], options=options, observers=[Watcher()])
    assert flight.statistics["steps"] < 200
    assert flight.peak_tension.max() == pytest.approx(
        exact, rel=5e-3
    )  # of h ω = 1: the instants see 0.95 of it
    assert max(seen) == flight.peak_tension.max()


def test_a_step_whose_places_are_not_found_is_divided(monkeypatch):
    """At 3 of the stable step no fixed point attracts; energy is kept all the same."""
    from netdae.solvers.explicit import stepper

    monkeypatch.setattr(stepper, "LONGEST", 3.0)
    monkeypatch.setitem(stepper.FRACTIONS, "standard", 3.0)
    net = line(1)
    system = System(net, SOFT, damping=NoDamping(), masses={"last": 1.0}, restraints=[Restraint("first")])
    start = State.at(net.nodes * 1.05, np.array([[0, 0, 0], [0.1, 0.2, 0]]))
    solver = solver_at(system, start)
    divided = 0.0
    for _ in range(4):
        solver.step(1e6)
        divided += solver._kernel._between.values.passes[1]
    assert divided > 1
    assert energy_of(system, *solver._places()) == pytest.approx(
        energy_of(system, start.x, start.v), rel=1e-10
    )


@pytest.mark.parametrize(
    ("more", "lossless"),
    [
        ({"damping": NoDamping()}, True),
        ({"damping": NoDamping(), "loads": [Gravity([0, 0, -1.0])]}, True),
        ({"damping": Dashpot(viscosity_time=1e-6)}, False),
        ({"damping": Rayleigh(alpha=1.0)}, False),
    ],
)
def test_only_undamped_nets_take_it(more, lossless):
    net = line(3)
    solver = solver_at(System(net, SOFT, **more), State.at(net.nodes), accuracy="fast")
    assert solver._kernel.lossless == lossless
    assert solver._share == (LONGEST if lossless else 0.9)


def test_an_undamped_net_on_reels_is_noted():
    from test_explicit_chunks import with_reel

    system, start = with_reel()
    assert solver_at(system, start).note == ""
    system, start = with_reel(NoDamping())
    assert "no damping" in solver_at(system, start).note
    net = line(1)
    assert solver_at(System(net, SOFT, damping=NoDamping()), State.at(net.nodes)).note == ""


def test_the_script_that_measures_the_drift_measures_it():
    script = Path(__file__).parent.parent / "scripts" / "undamped_drift.py"
    done = subprocess.run(
        [sys.executable, script, "--steps", "4000"], capture_output=True, text=True, check=True
    )
    drift = {
        name: float(figures.split(": ")[1].split(",")[0])
        for name, _, figures in (line.partition(": ") for line in done.stdout.splitlines())
    }
    assert len(drift) == 8
    assert drift["net, discrete gradient at 0.5"] < 1e-9
    assert drift["string, discrete gradient at 0.5"] < 1e-8
    assert drift["string, Verlet at 0.5"] > 0.1
