"""Restraints that begin and end during a flight, events that end a stage, and flights that go on from a memory."""

from typing import NamedTuple

import numpy as np
import pytest

from netdae.core.errors import InputError
from netdae.forces.loads import Gravity, NodalLoad
from netdae.model.material import Material
from netdae.model.motions import TableMotion
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.solvers.driver import integrate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping
from netdae.system.system import System

CORD = Material(youngs_modulus=1e6, density=1000.0, diameter=2e-3)
METHODS = ["ida", "explicit", "cvode_bdf", "dop853"]
SHARP = {"rtol": 1e-9, "atol_position": 1e-11, "atol_velocity": 1e-10}


def options(method, **more):
    return SolverOptions(method, **(more if method == "explicit" else {**SHARP, **more}))


def pair(**more):
    """Two masses of 1 kg, a metre apart, on a cord of 2 m that stays slack."""
    net = CableNet([(0, 0, 0), (1, 0, 0)], [(0, 1)], rest_length=[2.0], node_groups={"a": [0], "b": [1]})
    return System(net, CORD, masses={"all": 1.0}, damping=NoDamping(), **more)


class Alarm(NamedTuple):
    name: str
    action: str


class Noted(NamedTuple):
    t: float
    state: State
    events: tuple[Alarm, ...]


class AtTime:
    """EventSearch of one event at a given time: what a clock would find."""

    needs_every_step = False

    def __init__(self, t, action="none", name="alarm"):
        self.t, self.action, self.name, self.fired = t, action, name, False

    def begin(self, start):
        assert start.t < self.t

    def first(self, last, step, state_at):
        if self.fired or not last.t < self.t <= step.t:
            return None
        return Noted(self.t, state_at(self.t), (Alarm(self.name, self.action),))

    def note(self, firing):
        self.fired = True

    def memory(self):
        return {"fired": np.array(self.fired)}

    def restore(self, memory):
        self.fired = bool(memory["fired"])


@pytest.mark.parametrize("method", METHODS)
def test_a_released_bullet_flies_from_its_time_on(method):
    hold = Restraint("b", until=0.25, release_velocity=(0.0, 3.0, 0.0))
    system = pair(restraints=[hold], loads=[NodalLoad("a", (0.5, 0.0, 0.0))])
    times = np.linspace(0, 0.6, 13)
    flight = integrate(system, State.at(system.net.nodes), times, options=options(method))
    states = list(flight)
    m = system.mass[0]
    for state in states:
        free = max(0.0, state.t - 0.25)
        # closed forms; the explicit method is exact for them, the others within their tolerance
        np.testing.assert_allclose(state.x[1], [1, 3 * free, 0], atol=1e-8)
        np.testing.assert_allclose(state.x[0], [0.25 / m * state.t**2, 0, 0], atol=1e-8)
    balance = states[-1].balance
    np.testing.assert_allclose(flight.impulses[0][1], [0, 3 * m, 0], rtol=1e-12)
    assert flight.impulses[0][0] == 0.25
    np.testing.assert_allclose(balance.external_impulse, system.momentum(states[-1].v), rtol=0, atol=1e-8)
    np.testing.assert_allclose(
        balance.external_angular_impulse,
        system.angular_momentum(states[-1].x, states[-1].v),
        rtol=0,
        atol=1e-8,
    )
    assert balance.external_work == pytest.approx(system.kinetic_energy(states[-1].v), rel=1e-7)


@pytest.mark.parametrize("method", METHODS)
def test_a_restraint_that_begins_stops_a_node_where_it_is(method):
    system = pair(restraints=[Restraint("b", begin=0.3)])
    start = State.at(system.net.nodes, [(0, 0, 0), (0, 1.5, 0)])
    flight = integrate(system, start, [0, 0.3, 0.7], options=options(method))
    _, middle, last = flight
    np.testing.assert_allclose(middle.x[1], [1, 0.45, 0], atol=1e-8)
    np.testing.assert_allclose(last.x[1], [1, 0.45, 0], atol=1e-8)
    assert (last.v[1] == 0).all()
    m = system.mass[1]
    np.testing.assert_allclose(last.balance.external_impulse, [0, -1.5 * m, 0], atol=1e-8)
    assert last.balance.external_work == pytest.approx(-0.5 * m * 1.5**2, rel=1e-7)


def test_a_motion_that_begins_late_counts_from_where_it_takes_the_node():
    motion = TableMotion(np.array([0.0, 1.0]), np.array([(0.0, 0, 0), (2.0, 0, 0)]), interpolation="linear")
    system = pair(restraints=[Restraint("b", motion=motion, begin=0.4)])
    *_, last = integrate(system, State.at(system.net.nodes), [0, 0.9], options=options("ida"))
    np.testing.assert_allclose(last.x[1], [1 + 2 * 0.5, 0, 0], atol=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_a_restraint_ends_at_an_event(method):
    hold = Restraint("b", until="alarm", release_velocity=(1.0, 0.0, 0.0))
    system = pair(restraints=[hold])
    flight = integrate(
        system, State.at(system.net.nodes), [0, 0.2, 0.5], options=options(method), events=AtTime(0.317)
    )
    *_, last = flight
    assert flight.fired == {"alarm": 0.317}
    np.testing.assert_allclose(last.x[1], [1 + 0.5 - 0.317, 0, 0], atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_an_event_that_stops_ends_the_flight_with_a_frame(method):
    system = pair()
    start = State.at(system.net.nodes, [(0, 0, 0), (0, 1, 0)])
    states = list(
        integrate(system, start, np.linspace(0, 1, 5), options=options(method), events=AtTime(0.6, "stop"))
    )
    assert [s.t for s in states] == [0, 0.25, 0.5, 0.6]
    np.testing.assert_allclose(states[-1].x[1], [1, 0.6, 0], atol=1e-9)


def test_an_event_without_consequence_changes_no_bit_of_a_flight():
    system, start, times = shot()
    for method in ("ida", "explicit"):
        plain = list(integrate(system, start, times, options=SolverOptions(method)))
        noted = list(integrate(system, start, times, options=SolverOptions(method), events=AtTime(0.0123)))
        for one, other in zip(plain, noted, strict=True):
            np.testing.assert_array_equal(one.x, other.x)
            assert one.balance == other.balance


def shot():
    """A small net shot by its corners, one of which is held back for 4 ms, in gravity that sets in late."""
    net = CableNet.square(side=1.0, cells=3)
    held = int(net.nodes_of("corners")[2])
    from netdae.initial.scaled import ejected, scaled

    net, start = scaled(net, (0.8, 0.8, 1.0))
    start = ejected(net, start, "corners", speed=6.0, half_angle_deg=50.0)
    v = start.v.copy()
    released = tuple(v[held].tolist())
    v[held] = 0
    system = System(
        net,
        Material(youngs_modulus=5e9, density=1390.0, diameter=1e-3),
        masses={"corners": 0.1},
        damping=Dashpot(viscosity_time=1e-5),
        loads=[Gravity((0.0, 0.0, -9.81))],
        restraints=[Restraint((held,), until=0.004, release_velocity=released)],
    )
    return system, State.at(start.x, v), np.linspace(0, 0.06, 16)


class Steps:
    def __init__(self):
        self.seen = []

    def __call__(self, state):
        self.seen.append((state.t, state.x.copy(), state.balance))


@pytest.mark.parametrize("frames", [1, 2, 5, 15, 16])
def test_an_explicit_flight_goes_on_bit_for_bit(frames):
    system, start, times = shot()
    whole_steps, parts = Steps(), Steps()
    flight = integrate(system, start, times, options=SolverOptions("explicit"), watch=[whole_steps])
    whole = list(flight)
    broken = integrate(system, start, times, options=SolverOptions("explicit"), watch=[parts])
    got = [next(broken) for _ in range(frames)]
    memory = {name: array.copy() for name, array in broken.memory().items()}
    parts.seen = [each for each in parts.seen if each[0] <= memory["t"]]
    rest = integrate(system, start, times, options=SolverOptions("explicit"), watch=[parts], resume=memory)
    got += list(rest)
    assert [s.t for s in got] == [s.t for s in whole]
    for one, other in zip(whole, got, strict=True):
        np.testing.assert_array_equal(one.x, other.x)
        np.testing.assert_array_equal(one.v, other.v)
        assert one.balance == other.balance
    assert [each[0] for each in parts.seen] == [each[0] for each in whole_steps.seen]
    for one, other in zip(whole_steps.seen, parts.seen, strict=True):
        np.testing.assert_array_equal(one[1], other[1])
        assert one[2] == other[2]
    assert rest.statistics["steps"] == flight.statistics["steps"]
    assert len(rest.impulses) == len(flight.impulses)


@pytest.mark.parametrize("frames", [1, 2, 9, 16])
def test_an_ida_flight_goes_on_within_its_tolerance(frames):
    system, start, times = shot()
    # so tight, and over before chaos, that a fresh start shows by no more than the tolerance lets it
    tight = SolverOptions(rtol=1e-8, atol_position=1e-10, atol_velocity=1e-8)
    short = times[times <= 0.0201]
    short = np.linspace(0, 0.02, 16)
    whole = list(integrate(system, start, short, options=tight))
    broken = integrate(system, start, short, options=tight)
    got = [next(broken) for _ in range(frames)]
    got += list(integrate(system, start, short, options=tight, resume=broken.memory()))
    assert [s.t for s in got] == [s.t for s in whole]
    for one, other in zip(whole, got, strict=True):
        np.testing.assert_allclose(one.x, other.x, rtol=0, atol=1e-6)
        change = system.momentum(other.v) - system.momentum(start.v)
        np.testing.assert_allclose(change, other.balance.external_impulse, rtol=0, atol=1e-7)


def test_a_memory_holds_the_events():
    system, start, times = shot()
    alarm = AtTime(0.013)
    broken = integrate(system, start, times, options=SolverOptions("explicit"), events=alarm)
    for state in broken:
        if state.t > 0.03:
            break
    fresh = AtTime(0.013)
    rest = integrate(
        system, start, times, options=SolverOptions("explicit"), events=fresh, resume=broken.memory()
    )
    assert fresh.fired
    list(rest)
    assert rest.fired == {"alarm": 0.013}


def test_a_memory_of_another_net_is_refused():
    system, start, times = shot()
    broken = integrate(system, start, times)
    next(broken)
    other = pair()
    with pytest.raises(InputError, match="16 nodes"):
        integrate(other, State.at(other.net.nodes), times, resume=broken.memory())


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"begin": 0.5, "until": 0.5}, "let it end later"),
        ({"begin": float("nan")}, "not a number"),
        ({"axes": "xq"}, "give some of x, y, z"),
    ],
)
def test_a_restraint_says_what_is_wrong(wrong, words):
    with pytest.raises(InputError, match=words):
        Restraint("b", **wrong)
