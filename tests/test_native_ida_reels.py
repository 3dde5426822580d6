"""What acts beside cables and loads in the compiled driver of IDA, from reels to light: kernels, and in flight."""

import re

import numpy as np
import pytest
from conftest import SOFT, random_net, random_velocities
from numba import njit
from numpy.random import default_rng

from netdae.core.errors import RunError
from netdae.core.records import load
from netdae.forces.air import AirDrag
from netdae.forces.drag import BodyDrag
from netdae.forces.elements import ElementForce
from netdae.forces.free_molecular import FreeMolecularDrag
from netdae.forces.loads import Gravity, NodalLoad
from netdae.forces.motor import MOTOR, Motor
from netdae.forces.orbit import Orbit
from netdae.forces.rings import Rings
from netdae.forces.solar import SolarPressure
from netdae.model.material import Material
from netdae.model.motions import Steady
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.signals import Table
from netdae.model.state import State
from netdae.solvers import driver as integration
from netdae.solvers.flight import simulate
from netdae.solvers.ida import dyads as ida_dyads
from netdae.solvers.ida import memory as ida_memory
from netdae.solvers.ida import native as native_ida
from netdae.solvers.ida.dyads import Dyads
from netdae.solvers.ida.kernel import RATES, Net, rates, residual
from netdae.solvers.ida.layout import record_at
from netdae.solvers.ida.native import NativeIda, ida_stepper
from netdae.solvers.ida.newton import Matrix, assemble, factor, solve
from netdae.solvers.linalg.block_ldl import Ldl
from netdae.solvers.linalg.condensed import CondensedSolver
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping, Rayleigh
from netdae.system.reels import Reel
from netdae.system.system import System

TOE = Material(youngs_modulus=1e7, density=1000.0, diameter=2e-3, toe_strain=0.02)
SPRING = Material(youngs_modulus=1e7, density=1000.0, diameter=2e-3, law="engineering", toe_strain=0.01)
TIGHT = SolverOptions(rtol=1e-10, atol_position=1e-11, atol_velocity=1e-9)
ORBIT = Orbit(mean_motion=0.3)  # of a revolution in 20 s: its forces are large
RINGS, DRUMS = [0, 2, 5, 9, 3], [12, 13, 14]


def wound_net(closed):
    """The random net, a cord of pieces through five of its nodes, two single cables, and three drums behind them."""
    net = random_net(3)
    ring = np.stack((RINGS, np.roll(RINGS, -1)), axis=1)[: 5 if closed else 4]
    single = np.array([[1, 7], [7, 10]])
    new = np.concatenate((ring, single))
    x = np.concatenate((net.nodes, np.zeros((3, 3))))
    length = np.linalg.norm(x[new[:, 1]] - x[new[:, 0]], axis=1)
    groups = {"few": [1, 4, 7], "one": [0], "drums": DRUMS, "first": DRUMS[:1], "last": DRUMS[2:]}
    return CableNet(
        x,
        np.concatenate((net.cables, new)),
        groups,
        rest_length=np.concatenate((net.rest_length, 0.97 * length)),
    )


def wound(
    cord,
    damping,
    *,
    closed=False,
    rings=None,
    second=None,
    motor=False,
    loads=(),
    restraints=(),
    slack=1.0,
):
    """A drum with the cord through `rings`, if any, and two with a cable, or one with both as the cord `second`."""
    net = wound_net(closed)
    m = net.cable_count
    length = net.rest_length.copy()
    length[30:] *= slack
    net = CableNet(net.nodes, net.cables, net.node_groups, rest_length=length)
    braked = {"brake_force": 2.0, "creep_speed": 0.1, "viscosity": 0.1, "ratchet": True}
    reels, masses = [], {"few": 0.2, "drums": 0.05}
    if rings:
        reels = [Reel(DRUMS[0], np.arange(30, m - 2), inertia=0.05, share=-1.0, rings=rings)]
    if second:
        reels += [Reel(DRUMS[1], [m - 2, m - 1], inertia=0.05, share=-0.5, rings=second, **braked)]
    else:
        reels += [
            Reel(DRUMS[1], [m - 2], inertia=0.05, **braked),
            Reel(DRUMS[2], [m - 1], inertia=0.05, share=-1.0, longest=0.02),
        ]
    forces = []
    if motor:
        numbers = np.array([[4, 9], [0.5, 1], [0.1, 0.2], [0.05, 0.1]], dtype=float)
        forces = [ElementForce(MOTOR, np.array([[12], [14]]), Motor(*numbers))]
    more = {"loads": loads, "restraints": restraints, "reels": reels, "forces": forces}
    return System(net, cord, damping=damping, masses=masses, **more)


ROUGH = Rings(size=1e-2, friction=0.3, creep_speed=0.5, fastened=False)
SMOOTH = Rings(size=1e-2)
DASHPOT, GROUND = Dashpot(viscosity_time=1e-4), Gravity([0.0, 0.0, -9.81])
KNOWN = {
    "slides": lambda **k: wound(SOFT, NoDamping(), rings=SMOOTH, loads=[ORBIT], **k),
    "rubs": lambda **k: wound(TOE, DASHPOT, closed=True, rings=ROUGH, motor=True, loads=[GROUND], **k),
    "held": lambda **k: wound(
        SPRING, DASHPOT, rings=ROUGH, motor=True, restraints=[Restraint("few", axes="xz"), LOCK], **k
    ),
    "driven": lambda **k: wound(
        SOFT,
        DASHPOT,
        closed=True,
        rings=SMOOTH,
        restraints=[DRIVE],
        loads=[NodalLoad("few", [0.3, 0.0, 0.1])],
        **k,
    ),
    "dragged": lambda **k: wound(TOE, Rayleigh(alpha=2.0), rings=SMOOTH, loads=[ORBIT], motor=True, **k),
}
WIND = Table([0.0, 0.5, 1.0], [[0, 0, 0], [9, 3, 0], [1, 0, 5]])
KNOWN |= {
    "blown": lambda **k: wound(
        SOFT,
        DASHPOT,
        rings=SMOOTH,
        loads=[
            AirDrag(wind=WIND),
            AirDrag(wind=[3.0, 0.0, 1.0], diameter=0.1, tangential_coefficient=0.3),
            BodyDrag("few", 0.1, 1.2, 0.5, wind=WIND),
            ORBIT,
            ORBIT,
        ],
        **k,
    ),
    "lit": lambda **k: wound(
        SOFT,
        DASHPOT,
        closed=True,
        loads=[
            FreeMolecularDrag(density=1e-3, stream=[0.0, -70.0, 0.0]),
            SolarPressure(sun=[0.6, 0.0, 0.8], pressure=20.0),
        ],
        **k,
    ),
}
KNOWN |= {
    "two cords": lambda **k: wound(SOFT, DASHPOT, closed=True, rings=ROUGH, second=SMOOTH, motor=True, **k),
    "whole": lambda **k: wound(SOFT, Rayleigh(alpha=2.0, beta=1e-3), motor=True, restraints=[LOCK], **k),
}
LOCK = Restraint("last", axes="x")
DRIVE = Restraint("first", axes="x", motion=Steady((0.4, 0.0, 0.0)))


@njit
def _residual(address, t, y, yp, F):
    return residual(t, y, yp, load(record_at(address).net, Net), F)


@njit
def _rates(address, t, y, out):
    return rates(t, y, load(record_at(address).net, Net), out)


@njit
def _setup(address, t, y, cj):
    u = record_at(address)
    matrix, ldl = load(u.matrix, Matrix), load(u.ldl, Ldl)
    assemble(t, y, cj, load(u.net, Net), matrix, ldl)
    return factor(cj, matrix, ldl, load(u.dyads, Dyads))


@njit
def _solve(address, r, cj, now, z):
    u = record_at(address)
    solve(r, cj, now, load(u.net, Net), load(u.matrix, Matrix), load(u.ldl, Ldl), load(u.dyads, Dyads), z)


def compiled_of(system, x):
    solver = ida_stepper(system, system.drive_from(x), SolverOptions())
    assert isinstance(solver, NativeIda)
    solver._record.go_on(system.during(0.0, 0.4), 0.0)
    return solver


def states(system):
    """Random states near the start, whose drums are a little wound in and turn."""
    rng = default_rng(5)
    for _ in range(4):
        x = system.net.nodes + 0.1 * rng.standard_normal(system.net.nodes.shape)
        v = rng.standard_normal(x.shape)
        x[DRUMS] = rng.uniform(-0.02, 0.05, (3, 3))
        v[DRUMS] *= 0.2
        yield x, v, rng


CASES = [(name, slack) for name in KNOWN for slack in (1.0, 1.02, 2.0)]


@pytest.mark.parametrize(("name", "slack"), CASES)
def test_residual_and_rates_are_those_of_the_forces(name, slack):
    system = KNOWN[name](slack=slack)
    solver = compiled_of(system, system.net.nodes)
    size = 6 * system.net.node_count
    for x, v, rng in states(system):
        t, yp = 0.3, rng.standard_normal(size)
        y, F, out = np.stack((x, v)).ravel(), np.empty(size), np.empty(RATES)
        assert _residual(solver._record.address, t, y, yp, F) == -1
        f = system.force(t, x, v)
        free = ~system.restrained
        dx, dv = yp.reshape(2, -1, 3)
        F1, F2 = F.reshape(2, -1, 3)
        np.testing.assert_allclose(F1[free], (dx - v)[free], rtol=1e-14)
        np.testing.assert_allclose(F2[free], (system.mass[:, None] * dv - f)[free], rtol=1e-12, atol=1e-10)
        drive = system.drive_from(system.net.nodes)
        x_d, v_d, a_d = drive.at(t)
        np.testing.assert_allclose(F1[~free], (x - x_d)[~free], atol=1e-15)
        np.testing.assert_allclose(F2[~free], (v - v_d)[~free], atol=1e-15)
        tension = _rates(solver._record.address, t, y, out)
        _, dissipated, external = system.account(t, x, v)
        reactions = system.reactions(t, x, v, a_d)
        wrench = system.external_wrench(t, x, v) + system.wrench(x, reactions)
        scale = np.abs(f).max()
        assert out[0] == pytest.approx(dissipated, rel=1e-12, abs=1e-12 * scale)
        assert out[1] == pytest.approx(external + np.vdot(reactions, v_d), rel=1e-12, abs=1e-12 * scale)
        np.testing.assert_allclose(out[2:].reshape(2, 3), wrench, rtol=1e-12, atol=1e-12 * scale)
        assert tension == pytest.approx(system.peak_tension(x), rel=1e-12)


@pytest.mark.parametrize(("name", "slack"), CASES)
@pytest.mark.parametrize("cj", [30.0, 3e3])
def test_the_newton_matrix_is_that_of_the_condensed_solver(name, slack, cj):
    """On restrained axes the compiled one takes residuals for zero, as Newton's iteration there makes them."""
    system = KNOWN[name](slack=slack)
    solver, ours = compiled_of(system, system.net.nodes), CondensedSolver(system)
    size, held = 6 * system.net.node_count, system.restrained
    for x, v, rng in states(system):
        y = np.stack((x, v))
        assert _setup(solver._record.address, 0.3, y.ravel(), cj) == -1
        ours.setup(system.during(0.0, 0.4), 0.3, x, v, cj)
        for now in (cj, 1.2 * cj):
            r = rng.standard_normal(y.shape)
            r[:, held] = 0.0
            z, reported = np.empty(size), np.empty(y.shape)
            _solve(solver._record.address, r.ravel(), cj, now, z)
            ours.solve(r[0], r[1], now, reported[0], reported[1])
            # another order of elimination: K's condition number is up to 1e6
            for part, expected in zip(z.reshape(y.shape), reported, strict=True):
                np.testing.assert_allclose(part, expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max())


def driven_by(monkeypatch, driver):
    where = {
        "compiled": ("netdae.solvers.ida.native", "ida_stepper"),
        "python": ("netdae.solvers.ida.stepper", "IdaSolver"),
    }
    monkeypatch.setitem(integration._STEPPERS, "ida", where[driver])


def start_of(system):
    """The start of the random net, as its restraints want it, with the free drums turning."""
    v = random_velocities(system.net)
    v[DRUMS] = [[0.1, 0, 0], [0.2, 0, 0], [-0.1, 0, 0]]
    for restraint in system.restraints:
        nodes, axes = restraint.nodes_of(system.net), restraint.axis_indices
        v[np.ix_(nodes, axes)] = restraint.motion.at(0.0)[1][axes]
    return State.at(system.net.nodes, v)


@pytest.mark.parametrize("name", KNOWN)
def test_it_flies_as_the_driver_from_python(name, monkeypatch):
    """At tight tolerance and before chaos: the global error of both is up to ten thousand times 1e-11 m."""
    system, flights = KNOWN[name](), []
    for driver in ("compiled", "python"):
        driven_by(monkeypatch, driver)
        flights.append(simulate(system, start_of(system), np.linspace(0.0, 0.03, 4), options=TIGHT))
        assert flights[-1].statistics["driver"] == driver
    for one, other in zip(*flights, strict=True):
        np.testing.assert_allclose(one.x, other.x, rtol=0, atol=1e-7)
        np.testing.assert_allclose(one.v, other.v, rtol=0, atol=1e-5)
        for field in ("dissipated_energy", "external_work", "external_impulse", "external_angular_impulse"):
            of_one, of_other = (np.array(getattr(state.balance, field)) for state in (one, other))
            np.testing.assert_allclose(of_one, of_other, rtol=0, atol=2e-6, err_msg=field)
    moved = np.abs(flights[0][-1].x[DRUMS, 0] - system.net.nodes[DRUMS, 0])
    assert (moved > 1e-4).sum() >= 2
    peaks = [flight.peak_tension.max() for flight in flights]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-3)


@pytest.mark.parametrize("name", KNOWN)
def test_with_ida_s_own_settings_it_makes_the_same_steps(name, monkeypatch, without_rules_for_taut_cables):
    monkeypatch.setattr(ida_memory, "KEPT_STEPS", (1.0, 2.0))
    monkeypatch.setattr(ida_memory, "KEPT_CJ", 0.25)
    monkeypatch.setattr(ida_memory, "KEPT_CJ_WHOLE", 0.25)
    monkeypatch.setattr(ida_memory, "NEWTON_TOLERANCE", 0.33)
    system, counts, last = KNOWN[name](), [], []
    for driver in ("compiled", "python"):
        driven_by(monkeypatch, driver)
        flight = simulate(system, start_of(system), [0.0, 0.01])
        counts.append({key: flight.statistics[key] for key in ("steps", "residuals", "setups", "solves")})
        last.append(flight[-1].x)
    assert counts[0] == counts[1]
    assert counts[0]["steps"] > 15
    np.testing.assert_allclose(*last, rtol=0, atol=1e-8)  # of round-off that snaps have amplified


@pytest.mark.parametrize("name", KNOWN)
def test_its_books_are_those_of_the_ledger(name, monkeypatch):
    """Frames and steps with the shares that it reports, and without, so that the running balance integrates itself."""
    driven_by(monkeypatch, "compiled")
    system, times = KNOWN[name](), np.linspace(0.0, 0.02, 20)
    monkeypatch.setattr(native_ida, "CHUNK", 1)
    flights = [simulate(system, start_of(system), times)]
    step, output = NativeIda.step, NativeIda.output
    monkeypatch.setattr(NativeIda, "step", lambda self, t: [s._replace(share=None) for s in step(self, t)])
    monkeypatch.setattr(NativeIda, "output", lambda self, t: output(self, t)._replace(share=None))
    flights.append(simulate(system, start_of(system), times))
    for one, other in zip(*flights, strict=True):
        np.testing.assert_array_equal(one.x, other.x)
        for field in ("dissipated_energy", "external_work", "external_impulse", "external_angular_impulse"):
            of_one, of_other = (np.array(getattr(state.balance, field)) for state in (one, other))
            # the same sums in another order
            np.testing.assert_allclose(of_one, of_other, rtol=1e-9, atol=1e-11, err_msg=field)
        assert one.balance.peak_tension == pytest.approx(other.balance.peak_tension, rel=1e-12)


def pulled(rings, **more):
    """A heavy drum that turns at 1 m/s and winds 0.5 m of cord, or of a cable, in, between places that are nearly one.

    It has no stop, and the cord is slack to its end: it would hold any drum else, since its strain has no bound.
    """
    nodes = np.array([[0.0, 0, 0], [0.2, 0.1, 0], [0.5, 0, 0], [0, 0, 0]])
    cables = [[0, 1], [1, 2]] if rings else [[0, 2]]
    net = CableNet(nodes, cables, {"knots": [0, 1, 2], "drum": [3]})
    places = 1e-5 * nodes
    reel = Reel(3, np.arange(len(cables)), inertia=1e6, share=-1.0, rings=rings, **more)
    system = System(
        net,
        SOFT,
        damping=Dashpot(viscosity_time=1e-3),
        masses={"knots": 0.1},
        reels=[reel],
        restraints=[Restraint("knots")],
    )
    force = system.forces[-1]
    system.forces = tuple(each for each in system.forces if each is not force)  # the stop
    v = np.zeros((4, 3))
    v[3, 0] = 1.0
    return system, State.at(places, v)


@pytest.mark.parametrize("rings", [None, Rings(size=1e-3)], ids=["cable", "cord"])
def test_a_cord_that_is_wound_in_whole_is_reported_in_the_same_words(rings, monkeypatch):
    reported = []
    for driver in ("compiled", "python"):
        driven_by(monkeypatch, driver)
        system, start = pulled(rings)
        system._net_forces = type(system._net_forces).of(system.forces, system.in_space)
        with pytest.raises(RunError, match=r"wound in by the reel at node 3: stop the reel before") as caught:
            simulate(system, start, [0.0, 1.0])
        reported.append(str(caught.value))
    # up to its time and length, which lie in the step that each driver made
    words = [re.sub(r"(t =|length) \S+", "", text) for text in reported]
    assert words[0] == words[1]


def test_a_reel_is_held_let_go_and_held_again(monkeypatch):
    """Phases of a flight make drivers of their own; figures agree as far as tight tolerances let them."""
    holds = [Restraint("first", axes="x", until=0.004), Restraint("first", axes="x", begin=0.012)]
    flights = []
    for driver in ("compiled", "python"):
        driven_by(monkeypatch, driver)
        system = wound(SOFT, DASHPOT, rings=ROUGH, restraints=holds, loads=[ORBIT])
        flights.append(simulate(system, start_of(system), np.linspace(0.0, 0.02, 6), options=TIGHT))
    one, other = flights
    np.testing.assert_allclose(one.positions, other.positions, rtol=0, atol=1e-7)
    np.testing.assert_allclose(one.external_work, other.external_work, rtol=0, atol=1e-6)
    s = one.positions[:, DRUMS[0], 0]
    assert s[0] == s[1]
    assert abs(s[3] - s[1]) > 1e-5
    assert s[-1] == s[-2]


@pytest.mark.parametrize(
    ("damping", "slack"), [(NoDamping(), 2.0), (Rayleigh(alpha=2.0), 2.0), (NoDamping(), 1.0)]
)
def test_cords_that_nothing_holds_are_reported(damping, slack):
    """A drum without inertia: its row of the whole matrix is zero on a slack cord, a taut one has dyads alone there."""
    system = wound(SOFT, damping, rings=SMOOTH, loads=[ORBIT], slack=slack)
    solver = compiled_of(system, system.net.nodes)
    solver._record._net.values.mass[DRUMS[0]] = 0.0
    start = start_of(system)
    a = system.acceleration(0.0, start.x, start.v)
    solver.enter(system, 0.0, np.stack((start.x, start.v)), np.stack((start.v, a)))
    with pytest.raises(RunError, match=r"t = 0 s: the Newton matrix is singular at node 12"):
        solver.step(0.1)


@pytest.mark.parametrize("r", [1, 2, 7])
def test_small_dense_systems_are_solved_and_singular_ones_reported(r):
    rng, swaps = default_rng(r), np.zeros(9, dtype=np.int64)
    W, b = np.zeros((9, 9)), np.zeros(9)
    W[:r, :r], b[:r] = rng.standard_normal((r, r)), rng.standard_normal(r)
    W[0, 0] *= 1e-9  # asks for pivots
    reported = np.linalg.solve(W[:r, :r], b[:r])
    assert ida_dyads._factor(W, swaps, r)
    ida_dyads._substitute(W, swaps, b, r)
    np.testing.assert_allclose(b[:r], reported, rtol=1e-10)
    assert not b[r:].any()
    assert not ida_dyads._factor(np.zeros((9, 9)), swaps, r)
