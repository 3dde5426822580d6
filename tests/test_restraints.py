"""Restrained and driven axes: exact motion, reactions, booked impulses, starts that contradict."""

import numpy as np
import pytest
from conftest import CORD, SOFT, line, random_net, random_velocities
from scipy.optimize import brentq

from netdae.core.errors import InputError
from netdae.forces.loads import Gravity
from netdae.model.motions import FunctionMotion, TableMotion
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.solvers.flight import simulate
from netdae.solvers.ida.stepper import IdaSolver
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping
from netdae.system.system import System

TIGHT = SolverOptions(rtol=1e-8, atol_position=1e-9, atol_velocity=1e-7)


def swing(amplitude=0.3, frequency=1.0):
    """0.3 m at 1 Hz along y that starts at rest: a (1 − cos ωt)."""
    w = 2 * np.pi * frequency
    return FunctionMotion(
        lambda t: [0.0, amplitude * (1 - np.cos(w * t)), 0.0],
        lambda t: [0.0, amplitude * w * np.sin(w * t), 0.0],
        lambda t: [0.0, amplitude * w**2 * np.cos(w * t), 0.0],
    )


def test_a_driven_node_does_not_drift(monkeypatch):
    """IDA's own unknowns, before the prescribed values are put in their place in a State."""
    motion, worst = swing(), [0.0]
    step = IdaSolver.step

    def watched(self, stop):
        steps = step(self, stop)
        worst[0] = max(worst[0], *(np.abs(s.y[0, 0] - motion.at(s.t)[0]).max() for s in steps))
        return steps

    monkeypatch.setattr(IdaSolver, "step", watched)
    system = System(
        line(4),
        SOFT,
        damping=Dashpot(viscosity_time=1e-3),
        loads=[Gravity([0, 0, -9.81])],
        restraints=[Restraint("first", motion=motion)],
    )
    flight = simulate(
        system, State.at(system.net.nodes), np.linspace(0, 3, 31), options=SolverOptions(accuracy="fast")
    )
    for frame in flight:
        u, du, ddu = motion.at(frame.t)
        exact = {"rtol": 1e-12, "atol": 1e-13}  # the ends of a phase are asked a hair inside
        np.testing.assert_allclose(frame.x[0], u, **exact)  # node 0 starts at the origin
        np.testing.assert_allclose(frame.v[0], du, **exact)
        np.testing.assert_allclose(frame.a[0], ddu, **exact)
    # a correction within the tolerance of 1e-4 m may be left out, but nothing adds up over three seconds
    assert worst[0] < 1e-4


def test_restrained_axes_leave_the_others_as_they_are():
    """A net in the plane z = 0 with its z axes held flies as it does free."""
    net = random_net(5)
    flat = CableNet(net.nodes * [1, 1, 0], net.cables, rest_length=net.rest_length)
    v = random_velocities(net) * [1, 1, 0]
    damping = Dashpot(viscosity_time=1e-4)
    free = System(flat, SOFT, damping=damping)
    held = System(flat, SOFT, damping=damping, restraints=[Restraint("all", axes="z")])
    one, other = (simulate(s, State.at(flat.nodes, v), [0, 0.05], options=TIGHT)[-1] for s in (free, held))
    np.testing.assert_allclose(one.x, other.x, rtol=0, atol=1e-6)
    assert not other.x[:, 2].any()


def hanging_strain(weight, EA):
    """N = EA E11 √(1 + 2 E11) = weight."""
    return brentq(lambda e: EA * e * np.sqrt(1 + 2 * e) - weight, 0, 1)


def test_the_reaction_of_a_hanging_mass_is_the_weight():
    g, bullet = 9.81, 0.1
    net = CableNet([[0, 0, 0], [0, 0, -2.0]], [[0, 1]], {"top": [0], "bob": [1]})
    system = System(
        net,
        SOFT,
        damping=NoDamping(),
        masses={"bob": bullet},
        loads=[Gravity([0, 0, -g])],
        restraints=[Restraint("top")],
    )
    EA = 1e7 * np.pi / 4 * 4e-6
    strain = hanging_strain(system.mass[1] * g, EA)
    x = net.nodes * np.sqrt(1 + 2 * strain)
    flight = simulate(system, State.at(x), [0.0, 0.5, 1.0])
    np.testing.assert_allclose(flight[-1].x, x, rtol=0, atol=1e-9)
    for frame in flight:
        R = system.reactions(frame.t, frame.x, frame.v, frame.a)
        np.testing.assert_allclose(R[0], [0, 0, system.mass.sum() * g], rtol=1e-8, atol=1e-12)
        assert not R[1].any()
        # gravity and reaction cancel in the impulse, a fixed node does no work
        np.testing.assert_allclose(frame.balance.external_impulse, 0.0, atol=1e-8)
        assert frame.balance.external_work == pytest.approx(0.0, abs=1e-8)


def test_reactions_take_the_prescribed_acceleration():
    """Two driven nodes with a taut cable: M a_d − f, written out."""
    motion = swing(0.1, 3.0)
    net = CableNet(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1], [1, 2]], {"held": [0, 1]}, rest_length=[0.9, 2.0]
    )
    system = System(
        net,
        SOFT,
        damping=NoDamping(),
        loads=[Gravity([0, 0, -9.81])],
        restraints=[Restraint("held", axes="yz", motion=motion), Restraint("held", axes="x")],
    )
    flight = simulate(system, State.at(net.nodes), [0.0, 0.1, 0.13])
    EA = 1e7 * np.pi / 4 * 4e-6
    pull = EA * 0.5 * (1 / 0.81 - 1) / 0.9  # S11 A/L̄ over the 1 m between the nodes
    for frame in flight:
        _, _, a = motion.at(frame.t)
        R = system.reactions(frame.t, frame.x, frame.v, frame.a)
        for node, along in ((0, -1), (1, 1)):
            expected = system.mass[node] * (np.add(a, [0, 0, 9.81])) + [along * pull, 0, 0]
            np.testing.assert_allclose(R[node], expected, rtol=1e-12)


def test_impulse_and_work_of_a_smooth_motion_close_the_balance():
    system = System(
        line(4),
        SOFT,
        damping=Dashpot(viscosity_time=1e-3),
        loads=[Gravity([0, 0, -9.81])],
        restraints=[Restraint("first", motion=swing(0.1, 2.0))],
    )
    start = State.at(system.net.nodes)
    scale = system.mass.sum() * 9.81  # N s in a second; J in a metre
    for rtol in (1e-4, 1e-7):
        options = SolverOptions(rtol=rtol, atol_position=0.1 * rtol, atol_velocity=10 * rtol)
        flight = simulate(system, start, [0.0, 1.0], options=options)
        last = flight[-1]
        impulse = np.array(last.balance.external_impulse) - system.momentum(last.v)
        energy = system.kinetic_energy(last.v) + system.elastic_energy(last.x)
        balance = energy + last.balance.dissipated_energy - last.balance.external_work
        # each step may err by rtol, and all of them the same way
        assert max(np.abs(impulse).max(), abs(balance)) < flight.statistics["steps"] * rtol * scale
        assert flight.statistics["steps"] < 2000


def test_a_jump_of_driven_velocity_books_its_impulse_and_work():
    """A node of 0.2 kg driven at 1 m/s, from 20 ms on at −2 m/s; its cable stays slack."""
    motion = TableMotion([0.0, 0.02, 0.1], [[0, 0, 0], [0.02, 0, 0], [-0.14, 0, 0]], interpolation="linear")
    net = CableNet([[0, 0, 0], [0, 1, 0]], [[0, 1]], {"one": [0]}, rest_length=[2.0])
    system = System(
        net, SOFT, damping=NoDamping(), masses={"one": 0.2}, restraints=[Restraint("one", motion=motion)]
    )
    v = np.array([[1.0, 0, 0], [0, 0, 0]])
    flight = simulate(system, State.at(net.nodes, v), [0.0, 0.01, 0.05])
    m = system.mass[0]
    assert flight.statistics["starts"] == 2
    np.testing.assert_allclose(flight[1].balance.external_impulse, 0.0, atol=1e-14)
    np.testing.assert_allclose(flight[2].balance.external_impulse, [-3 * m, 0, 0], rtol=1e-12)
    assert flight[2].balance.external_work == pytest.approx(0.5 * m * (4 - 1), rel=1e-12)
    np.testing.assert_allclose(flight[2].x[0], [0.02 - 2 * 0.03, 0, 0], rtol=1e-13)


def test_the_impulse_of_a_jump_is_reported_with_its_time():
    from netdae.solvers.driver import integrate

    motion = TableMotion([0.0, 0.02, 0.1], [[0, 0, 0], [0, 0, 0], [0, 0.08, 0]], interpolation="linear")
    net = CableNet([[0, 0, 0], [0, 1, 0]], [[0, 1]], {"one": [0]}, rest_length=[2.0])
    system = System(net, SOFT, damping=NoDamping(), restraints=[Restraint("one", motion=motion)])
    run = integrate(system, State.at(net.nodes), [0.0, 0.05])
    for _ in run:
        pass
    ((time, impulse),) = run.impulses
    assert time == 0.02
    np.testing.assert_allclose(impulse, [0, system.mass[0], 0], rtol=1e-12)


def test_the_energy_balance_holds_over_jumps_with_taut_cables():
    motion = TableMotion(
        [0.0, 0.05, 0.1, 0.2], [[0, 0, 0], [-0.1, 0, 0], [0, 0.1, 0], [0, 0.1, 0]], interpolation="linear"
    )
    system = System(
        line(4),
        SOFT,
        damping=Dashpot(viscosity_time=1e-3),
        masses={"last": 0.05},
        restraints=[Restraint("first", motion=motion)],
    )
    v = np.zeros((5, 3))
    v[0, 0] = -2.0
    start = State.at(system.net.nodes, v)
    flight = simulate(system, start, np.linspace(0, 0.2, 9), options=TIGHT)
    assert flight.statistics["starts"] == 3
    e0, p0 = system.kinetic_energy(v), system.momentum(v)
    largest = max(system.kinetic_energy(f.v) + system.elastic_energy(f.x) for f in flight)
    for f in flight:
        energy = system.kinetic_energy(f.v) + system.elastic_energy(f.x)
        balance = energy + f.balance.dissipated_energy - f.balance.external_work - e0
        assert abs(balance) < 1e-4 * largest  # rtol 1e-8 over some thousand steps with kinks
        np.testing.assert_allclose(
            system.momentum(f.v) - p0, f.balance.external_impulse, rtol=0, atol=1e-4 * np.abs(p0).max()
        )


def test_all_nodes_restrained_flies():
    system = System(line(2), SOFT, damping=NoDamping(), restraints=[Restraint("all", motion=swing())])
    flight = simulate(system, State.at(system.net.nodes), [0.0, 0.25])
    np.testing.assert_allclose(flight[-1].x[:, 1], 0.3, rtol=1e-12)


def test_a_node_without_mass_flies_when_it_is_restrained_and_not_when_it_is_free():
    net = CableNet([[0, 0, 0], [1, 0, 0], [5, 5, 5]], [[0, 1]], {"lone": [2]})
    with pytest.raises(InputError, match=r"node 2 is free but has no mass.*restrain"):
        System(net, CORD, damping=NoDamping())
    with pytest.raises(InputError, match="node 2 is free"):
        System(net, CORD, damping=NoDamping(), restraints=[Restraint("lone", axes="xy")])
    system = System(net, CORD, damping=NoDamping(), restraints=[Restraint("lone")])
    flight = simulate(system, State.at(net.nodes), [0.0, 0.01])
    np.testing.assert_array_equal(flight[-1].x[2], [5, 5, 5])


def moving(velocity):
    return FunctionMotion(lambda t: np.multiply(t, velocity), lambda t: velocity, lambda t: [0, 0, 0])


@pytest.mark.parametrize(
    ("restraint", "words"),
    [
        (
            Restraint("first", motion=moving([1.0, 0, 0])),
            "node 0 starts at .* but its motion begins at .*1.0.*start it",
        ),
        (
            Restraint(
                "first",
                motion=FunctionMotion(lambda t: [0.1, 0, 0], lambda t: [0, 0, 0], lambda t: [0, 0, 0]),
            ),
            "begins at .*0.1.* m from the starting place.*zero at t = 0",
        ),
        (
            Restraint("first", motion=TableMotion([0.1, 1.0], np.zeros((2, 3)))),
            r"from 0\.1 to 1 s.*from 0 to 0\.1 s",
        ),
        (
            Restraint("first", motion=TableMotion([0.0, 0.05], np.zeros((2, 3)))),
            r"from 0 to 0\.05 s.*from 0 to 0\.1 s",
        ),
    ],
    ids=["velocity", "place", "begins late", "ends early"],
)
def test_a_start_that_contradicts_a_restraint_says_what_to_change(restraint, words):
    system = System(line(2), SOFT, damping=NoDamping(), restraints=[restraint])
    with pytest.raises(InputError, match=words):
        simulate(system, State.at(system.net.nodes), [0.0, 0.1])


def test_a_fixed_node_that_starts_moving_is_refused():
    system = System(line(2), SOFT, damping=NoDamping(), restraints=[Restraint("first")])
    v = np.zeros((3, 3))
    v[0, 2] = 1e-3
    with pytest.raises(InputError, match=r"node 0 starts at \[0\.0, 0\.0, 0\.001\] m/s"):
        simulate(system, State.at(system.net.nodes, v), [0.0, 0.1])


def starting(motion, x=(0.0, 0.0, 0.0), v=(0.0, 0.0, 0.0), t=0.0, end=None):
    """Check the start of a cable of 2 m whose first node is driven along x and y."""
    net = CableNet(np.add([[0, 0, 0], [0, 0, 2.0]], x), [[0, 1]], {"end": [0]})
    system = System(net, SOFT, damping=NoDamping(), restraints=[Restraint("end", axes="xy", motion=motion)])
    system.drive_from(net.nodes).check_start(t, np.array([v, (0, 0, 0)], dtype=float), end)


def test_round_off_of_the_start_is_measured_by_the_net_and_the_clock():
    """Differences of places 1e5 m away, phases of 1e6 turns; what exceeds them a thousand times is refused."""
    far = FunctionMotion(lambda t: [1e5 + 1e-9 - 1e5, 0, 0], lambda t: [0, 0, 0], lambda t: [0, 0, 0])
    starting(far, x=(1e5, 0, 0))
    with pytest.raises(InputError, match="from the starting place"):
        starting(far)
    w, t = 2 * np.pi * 1000, 1000.0  # sin wt = 1e-10 or so, where it should be zero

    def shake(late):
        return FunctionMotion(
            lambda t: [0.01 * np.sin(w * (t - late)), 0, 0],
            lambda t: [0.01 * w * np.cos(w * (t - late)), 0, 0],
            lambda t: [-0.01 * w**2 * np.sin(w * (t - late)), 0, 0],
        )

    assert abs(shake(0.0).at(t)[0][0]) > 2e-12
    starting(shake(0.0), v=(0.01 * w, 0, 0), t=t)
    with pytest.raises(InputError, match="from the starting place"):
        starting(shake(1e-9), v=(0.01 * w, 0, 0), t=t)
    # the speed of a quarter of a turn earlier, off by the same phase
    swung = FunctionMotion(
        lambda t: [0.01 * (1 - np.cos(w * t)), 0, 0],
        lambda t: [0.01 * w * np.sin(w * t), 0, 0],
        lambda t: [0.01 * w**2 * np.cos(w * t), 0, 0],
    )
    assert abs(swung.at(t)[1][0]) > 1e-9
    starting(swung, t=t)
    with pytest.raises(InputError, match="start it at that velocity"):
        starting(swung, v=(1e-5, 0, 0), t=t)


def test_a_slow_start_that_contradicts_is_refused_as_a_fast_one():
    """1e-10 m/s against 1e-9 m/s is as wrong as metres a second."""
    slow = moving([1e-9, 0, 0])
    starting(slow, v=(1e-9, 0, 0))
    with pytest.raises(InputError, match="start it at that velocity"):
        starting(slow, v=(1e-10, 0, 0))


def test_a_motion_whose_derivatives_do_not_belong_together_is_refused_before_the_flight():
    def motion(factor):
        return FunctionMotion(
            lambda t: [0, 1 - np.cos(3 * t), np.exp(t)],  # z is free
            lambda t: [0, 3 * np.sin(3 * t), 0],
            lambda t: [0, factor * 9 * np.cos(3 * t), 0],
        )

    starting(motion(1.0), end=2.0)
    words = r"restraint on 'end': its acceleration is .* at t = .* s, but its velocity changes at the rate"
    with pytest.raises(InputError, match=words):
        starting(motion(0.5), end=2.0)


def test_wrong_restraints_are_reported():
    with pytest.raises(InputError, match="axes is 'xq'"):
        Restraint("first", axes="xq")
    with pytest.raises(InputError, match="node 0 is restrained in one of the axes yz by an earlier"):
        System(
            line(2),
            SOFT,
            damping=NoDamping(),
            restraints=[Restraint("first", axes="xy"), Restraint("all", axes="yz")],
        )
    empty = CableNet([[0, 0, 0], [1, 0, 0]], [[0, 1]], {"none": []})
    with pytest.raises(InputError, match="restraint on 'none': the group has no nodes"):
        System(empty, SOFT, damping=NoDamping(), restraints=[Restraint("none")])
    with pytest.raises(InputError, match="no node group 'nobody'"):
        System(line(2), SOFT, damping=NoDamping(), restraints=[Restraint("nobody")])


def test_a_flight_that_starts_late_is_driven_by_its_own_clock():
    """Displacements count from where the node starts; the motion must be zero there."""
    motion = FunctionMotion(
        lambda t: [0, 0, (t - 2.0) ** 2], lambda t: [0, 0, 2 * (t - 2.0)], lambda t: [0, 0, 2.0]
    )
    system = System(line(2), SOFT, damping=NoDamping(), restraints=[Restraint("first", motion=motion)])
    flight = simulate(system, State.at(system.net.nodes, t=2.0), [2.0, 2.1])
    np.testing.assert_allclose(flight[-1].x[0], [0, 0, 0.01], rtol=1e-12)
