"""Reels: pay-out under a brake, with a heavy drum, driven, locked and at its stops, against closed forms."""

import numpy as np
import pytest
from conftest import SOFT, STIFF
from flights import energy_of
from scipy.integrate import solve_ivp

from netdae.core.errors import InputError, RunError
from netdae.forces.brake import BRAKE, END_STOP, Brake
from netdae.forces.cables import Cables
from netdae.forces.elements import ElementForce
from netdae.forces.loads import Gravity, NodalLoad
from netdae.forces.reel import REELED, Reeled
from netdae.model.material import Cords
from netdae.model.motions import FunctionMotion
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping
from netdae.system.reels import CREEP, Reel, forces_of, rest_lengths
from netdae.system.system import System

TIGHT = SolverOptions(rtol=1e-8, atol_position=1e-10, atol_velocity=1e-8)

ANCHOR, BOB, DRUM = 0, 1, 2


def net_of(length=1.0, direction=(1.0, 0.0, 0.0)):
    """One cable from an anchor at the origin to a bob; node 2 is its reel."""
    nodes = np.zeros((3, 3))
    nodes[BOB] = length * np.asarray(direction)
    return CableNet(
        nodes, [[ANCHOR, BOB]], {"anchor": [ANCHOR], "bob": [BOB], "drum": [DRUM]}, rest_length=[length]
    )


def system_of(net, reel, *, cord=STIFF, bob=1.0, anchor=0.0, damping=None, restraints=None, loads=()):
    return System(
        net,
        cord,
        damping=damping or NoDamping(),
        masses={"bob": bob, "anchor": anchor},
        restraints=[Restraint("anchor")] if restraints is None else restraints,
        loads=loads,
        reels=[reel],
    )


def start_of(net, strain=0.0, v=0.0):
    """The bob along its cable with a strain l/L̄ − 1, running out at v with the drum."""
    x, rates = net.nodes.copy(), np.zeros((3, 3))
    n = x[BOB] / np.linalg.norm(x[BOB])
    x[BOB] *= 1 + strain
    rates[BOB], rates[DRUM, 0] = v * n, v
    return State.at(x, rates)


def test_a_brake_stops_a_mass_with_a_constant_force():
    """(m + I) v̇ = −F_b: v falls linearly, and the whole way is (m + I) v²/(2 F_b)."""
    m, inertia, brake, v = 2.0, 0.5, 5.0, 3.0
    net = net_of()
    reel = Reel(DRUM, [0], inertia=inertia, brake_force=brake)
    system = system_of(net, reel, bob=m)
    tension = brake * m / (m + inertia)
    stop = v * (m + inertia) / brake
    times = [0.0, 0.5 * stop, stop + 0.5]
    flight = simulate(system, start_of(net, tension / 1e5, v), times, options=TIGHT)
    half, last = flight[1], flight[-1]
    # the friction's smoothing costs v₀²/(2v²) ~ 1e-7, the cable stretches with its length by 4e-5 of it
    assert half.v[DRUM, 0] == pytest.approx(v / 2, rel=1e-4)
    assert half.x[DRUM, 0] == pytest.approx(3 / 8 * v * stop, rel=1e-4)
    assert last.x[DRUM, 0] == pytest.approx((m + inertia) * v**2 / (2 * brake), rel=1e-4)
    # then it hangs in a slack or just taut cable; all energy went into the brake
    assert abs(last.v[DRUM, 0]) < CREEP
    assert last.balance.dissipated_energy == pytest.approx(0.5 * (m + inertia) * v**2, rel=1e-4)


def test_a_light_drum_stops_the_mass_alone():
    """Drum inertia → 0: the way is m v²/(2 F_b), with an error in proportion to the inertia."""
    m, brake, v = 2.0, 5.0, 3.0
    net, ways = net_of(), []
    for inertia in (0.02, 0.002):
        reel = Reel(DRUM, [0], inertia=inertia, brake_force=brake)
        system = system_of(
            net, reel, bob=m, damping=Dashpot(viscosity_time=1e-3)
        )  # rings no more once it rests
        start = start_of(net, brake * m / (m + inertia) / 1e5, v)
        ways.append(simulate(system, start, [0.0, 1.3], options=TIGHT)[-1].x[DRUM, 0])  # rests from 1.21 s on
    limit = m * v**2 / (2 * brake)
    assert ways[0] / limit - 1 == pytest.approx(0.01, abs=1e-4)  # I/m; as above
    assert ways[1] / limit - 1 == pytest.approx(0.001, abs=1e-4)


def test_a_held_drum_creeps_as_the_brake_says():
    """Below the brake force F_b a pull F gives ṡ = v₀ F/√(F_b² − F²)."""
    pull, brake = 3.0, 5.0
    net = net_of()
    system = system_of(
        net,
        Reel(DRUM, [0], inertia=0.1, brake_force=brake),
        loads=[NodalLoad("bob", [pull, 0, 0])],
        damping=Dashpot(viscosity_time=1e-3),
    )
    flight = simulate(system, start_of(net, pull / 1e5), [0.0, 1.0, 2.0], options=TIGHT)
    creep = CREEP * pull / np.sqrt(brake**2 - pull**2)
    assert flight[-1].x[DRUM, 0] - flight[1].x[DRUM, 0] == pytest.approx(creep, rel=1e-3)  # strain 3e-5


def test_a_heavy_drum_pays_out_with_the_sum_of_both_masses():
    """A constant pull F on the bob: one degree of freedom of the mass m + I, as in Atwood's machine."""
    m, inertia, pull = 1.0, 3.0, 2.0
    net = net_of()
    system = system_of(net, Reel(DRUM, [0], inertia=inertia), bob=m, loads=[NodalLoad("bob", [pull, 0, 0])])
    acceleration = pull / (m + inertia)
    start = start_of(net, inertia * acceleration / 1e5)
    flight = simulate(system, start, np.linspace(0, 2, 5), options=TIGHT)
    for frame in flight:
        way = 0.5 * acceleration * frame.t**2
        # the strain of 1.5e-5 stretches what is paid out, and the force on s is less than N by its square
        assert frame.x[DRUM, 0] == pytest.approx(way, rel=4e-5, abs=1e-9)
        assert frame.x[BOB, 0] - start.x[BOB, 0] == pytest.approx(way, rel=4e-5, abs=1e-9)
        assert energy_of(system, frame) == pytest.approx(energy_of(system, flight[0]), abs=1e-6)


def swing(amplitude, omega):
    """Winds s = a (1 − cos ω t) out and in, so that the cable is length + s."""
    return FunctionMotion(
        lambda t: [amplitude * (1 - np.cos(omega * t)), 0, 0],
        lambda t: [amplitude * omega * np.sin(omega * t), 0, 0],
        lambda t: [amplitude * omega**2 * np.cos(omega * t), 0, 0],
    )


def test_a_pendulum_on_a_driven_reel_swings_as_its_equation_says():
    """d(L² θ̇)/dt = −g L sin θ, so θ̈ + 2 (L̇/L) θ̇ + (g/L) sin θ = 0; the reel's work closes the balance."""
    g, length, amplitude, omega, angle = 9.81, 1.0, 0.15, 4.0, 0.5
    net = net_of(length, (np.sin(angle), 0.0, -np.cos(angle)))
    system = system_of(
        net,
        Reel(DRUM, [0]),
        restraints=[
            Restraint("anchor"),
            Restraint("drum", axes="x", motion=swing(amplitude, omega)),
        ],
        loads=[NodalLoad("bob", [0, 0, -g])],
    )
    times = np.linspace(0, 3, 13)
    tension = g * np.cos(angle) + amplitude * omega**2 * -1.0  # m (g cos θ − L̈) at the start, from rest
    flight = simulate(system, start_of(net, tension / 1e5), times, options=TIGHT)

    def rates(t, y):
        at, rate = length + amplitude * (1 - np.cos(omega * t)), amplitude * omega * np.sin(omega * t)
        return [y[1], -2 * rate / at * y[1] - g / at * np.sin(y[0])]

    truth = solve_ivp(rates, (0, 3), [angle, 0.0], t_eval=times, rtol=1e-10, atol=1e-12).y[0]
    swung = np.arctan2(flight.positions[:, BOB, 0], -flight.positions[:, BOB, 2])
    # the cable is longer by its strain of 1e-4, which slows the phase of 8 rad by half of that
    np.testing.assert_allclose(swung, truth, rtol=0, atol=4e-4)
    kept = [energy_of(system, frame) for frame in flight]
    works = [frame.balance.external_work for frame in flight]
    assert np.ptp(works) > 1.0  # the reel and the weight do work
    np.testing.assert_allclose(kept, kept[0], rtol=0, atol=1e-4)


def test_a_locked_reel_is_a_plain_cable():
    """Same flight of a bouncing pendulum, and the same forces at any s."""
    net = net_of(1.0, (0.6, 0.0, -0.8))
    damping = Dashpot(viscosity_time=1e-3)
    hold = [Restraint("anchor"), Restraint("drum")]
    gravity = [Gravity([0, 0, -9.81])]
    plain = System(net, SOFT, damping=damping, masses={"bob": 0.1}, restraints=hold, loads=gravity)
    hold = [Restraint("anchor"), Restraint("drum", axes="x")]
    reeled = system_of(
        net, Reel(DRUM, [0]), cord=SOFT, bob=0.1, damping=damping, restraints=hold, loads=gravity
    )
    start = State.at(net.nodes)
    one, other = (simulate(s, start, [0, 0.5], options=TIGHT)[-1] for s in (plain, reeled))
    np.testing.assert_allclose(one.x, other.x, rtol=0, atol=1e-6)  # rtol of the path of some metres

    rng = np.random.default_rng(3)
    L, s = np.array([0.8]), 0.3
    cords = np.array([30.0]), np.array([0.1]), np.array([False]), np.array([0.05])
    x, v = rng.standard_normal((2, 1, 3, 3))
    x[0, 1] = x[0, 0] + [0.9, 0.7, 0.1]
    v *= 0.1  # E11 = 0.17 stays above τ times its rate: not held at zero
    x[0, 2, 0], v[0, 2] = s, 0.0
    moving = ElementForce(REELED, np.array([[0, 1, 2]]), Reeled(L, np.ones(1), *cords))
    still = Cables(np.array([[0, 1]]), L + s, *cords).force
    np.testing.assert_allclose(
        moving.force(0.0, x, v)[:, :2], still.force(0.0, x[:, :2], v[:, :2]), rtol=1e-14
    )
    assert moving.account(0.0, x, v) == pytest.approx(still.account(0.0, x[:, :2], v[:, :2]), rel=1e-14)
    ours, theirs = (
        f.tangent(0.0, x[:, : f.nodes.shape[1]], v[:, : f.nodes.shape[1]]) for f in (moving, still)
    )
    np.testing.assert_allclose(ours.dx[:, :2, :, :2], theirs.dx, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(ours.dv[:, :2, :, :2], theirs.dv, rtol=1e-13, atol=1e-14)


def test_a_free_tether_keeps_energy_and_momentum_through_its_snaps():
    """Two free masses, a drum, a dashpot: whatever the tumbling, Σ m v and the sum of energies stay."""
    net = net_of(1.0)
    reel = Reel(DRUM, [0], inertia=0.05, brake_force=0.2)
    system = system_of(
        net, reel, cord=SOFT, bob=0.3, anchor=0.5, damping=Dashpot(viscosity_time=1e-3), restraints=[]
    )
    v = np.zeros((3, 3))
    v[BOB] = [1.0, 0.5, 0.0]
    start = State.at(net.nodes * 0.7, v)
    flight = simulate(system, start, np.linspace(0, 1.5, 16), options=TIGHT)
    kept = np.array([energy_of(system, frame) for frame in flight])
    assert flight[-1].balance.dissipated_energy > 0.02  # of 0.19 J
    assert flight[-1].x[DRUM, 0] > 0.1
    np.testing.assert_allclose(kept, kept[0], rtol=1e-5)  # Simpson's rule over the snap
    momentum = (
        0.3 + 0.5 * 1e3 * np.pi * 1e-6
    )  # bob and half of the cord, none of the drum, at (1, 0.5, 0) m/s
    for frame in flight:
        np.testing.assert_allclose(system.momentum(frame.v), [momentum, momentum / 2, 0], rtol=1e-12)
        turned = system.angular_momentum(frame.x, frame.v) - system.angular_momentum(start.x, start.v)
        np.testing.assert_allclose(turned, 0.0, rtol=0, atol=1e-7)  # rtol of 0.1 N m s, over 700 steps


@pytest.mark.parametrize("method", ["ida", "explicit", "bdf"])
def test_a_load_on_a_drum_works_but_is_no_impulse_on_the_net(method):
    """A drum has no place and no momentum; ida sums it compiled, bdf by the running balance."""
    net = net_of(1.0)
    system = system_of(
        net,
        Reel(DRUM, [0], inertia=0.5),
        cord=SOFT,
        restraints=[],
        anchor=0.5,
        loads=[NodalLoad("drum", [0.3, 0.0, 0.0]), NodalLoad("bob", [0.0, 0.2, 0.0])],
    )
    flight = simulate(system, State.at(net.nodes), [0.0, 0.1, 0.2], options=SolverOptions(method=method))
    balance = flight[-1].balance
    assert balance.external_work > 0
    # 0.2 N for 0.2 s, to round-off
    np.testing.assert_allclose(balance.external_impulse, [0.0, 0.04, 0.0], rtol=1e-9, atol=1e-12)
    gained = system.momentum(flight[-1].v)
    np.testing.assert_allclose(gained, [0.0, 0.04, 0.0], rtol=1e-6, atol=1e-9)  # the solvers' own


def test_an_empty_drum_lands_on_its_stop():
    """Critically damped by k and 2 √(k I), and never pulled: √(I/k) v/e beyond, and back at v/e²."""
    longest, inertia, v, k = 0.5, 0.4, 2.0, 1e7 * np.pi * 1e-6
    net = net_of()
    system = system_of(net, Reel(DRUM, [0], inertia=inertia, longest=longest), cord=SOFT)
    start = State.at(net.nodes * 0.5, [[0, 0, 0], [0, 0, 0], [v, 0, 0]])
    landing, time = longest / v, np.sqrt(inertia / k)
    flight = simulate(system, start, [0.0, landing + time, landing + 3 * time], options=TIGHT)
    assert flight[1].x[DRUM, 0] == pytest.approx(longest + v * time / np.e, rel=1e-5)
    assert flight[2].v[DRUM, 0] == pytest.approx(-v / np.e**2, rel=1e-5)
    kept = [energy_of(system, frame) for frame in flight]
    np.testing.assert_allclose(kept, kept[0], rtol=1e-5)  # Simpson's rule over the landing


def test_an_empty_drum_stops_the_bob():
    """Once the drum is empty the bob turns back, as on a plain cable."""
    net, longest = net_of(), 0.5
    reel = Reel(DRUM, [0], inertia=0.01, longest=longest)
    system = system_of(net, reel, cord=SOFT, bob=0.2, damping=Dashpot(viscosity_time=1e-2))
    flight = simulate(system, start_of(net, 0.0, 2.0), np.linspace(0, 0.5, 51), options=TIGHT)
    way = flight.positions[:, BOB, 0] - 1.0
    k = 31.4 / 2.5  # stop and paid-out cable, 1 and 1.5 m long, in series
    assert longest + 0.5 * 2.0 * np.sqrt(0.2 / k) < way.max() < longest + 2.0 * np.sqrt(0.2 / k)
    assert flight[-1].v[BOB, 0] < 0.0
    kept = np.array([energy_of(system, frame) for frame in flight])
    np.testing.assert_allclose(kept, kept[0], rtol=1e-5)


def test_a_driven_reel_that_winds_in_too_far_is_reported():
    cords = Reeled(np.array([1.0]), np.ones(1), np.ones(1), np.zeros(1), np.array([False]), np.zeros(1))
    force = ElementForce(REELED, np.array([[4, 5, 9]]), cords)
    net = CableNet(np.zeros((10, 3)), [[0, 1]], rest_length=[1.0])
    system = System(net, STIFF, damping=NoDamping(), masses={"all": 1.0}, forces=[force])
    x = np.zeros((10, 3))
    x[9, 0] = -1.01
    for ask in (system.account, system.powers):
        with pytest.raises(
            RunError, match=r"nodes 4 and 5 has the rest length -0.01 m, wound in by the reel at node 9"
        ):
            ask(0.5, x, x)


def test_a_free_reel_stops_at_a_tenth_of_its_cable():
    net = net_of()
    cords = Cords.of(net, STIFF)
    _, out = forces_of([Reel(DRUM, [0])], net, cords, np.zeros(1))
    _, wound_in = forces_of([Reel(DRUM, [0], share=-1.0, shortest=-2.0)], net, cords, np.zeros(1))
    assert out.law is END_STOP
    assert (out.parameters.place, out.parameters.side) == (pytest.approx([-0.9]), [-1.0])
    assert wound_in.parameters.place == pytest.approx([-2.0, 0.9])
    assert list(wound_in.parameters.side) == [-1.0, 1.0]


def test_rest_lengths_follow_the_reels():
    reels = [Reel(3, [0, 2], share=0.5), Reel(4, [1], share=-1.0)]
    x = np.zeros((5, 3))
    x[3, 0], x[4, 0] = 0.4, 0.1
    L = np.array([1.0, 2.0, 3.0, 4.0])
    np.testing.assert_allclose(rest_lengths(L, reels, x), [1.2, 1.9, 3.2, 4.0], rtol=1e-15)
    np.testing.assert_array_equal(L, [1.0, 2.0, 3.0, 4.0])


def test_a_ratchet_gives_way_by_creep_only():
    """Winding back: v₀ F/F_b, without the limit of dry friction."""
    numbers = Brake(np.array([2.0]), np.array([1e-3]), np.zeros(1), np.array([True]))
    brake = ElementForce(BRAKE, np.array([[0]]), numbers)
    v = np.zeros((1, 1, 3))
    v[0, 0, 0] = -1e-3 * 10.0 / 2.0
    assert brake.force(0.0, v, v)[0, 0, 0] == pytest.approx(10.0, rel=1e-14)


@pytest.mark.parametrize(
    ("make", "reported"),
    [
        (lambda: Reel(2, []), "it has no cables"),
        (lambda: Reel(2, [0], inertia=-1.0), "inertia is -1"),
        (lambda: Reel(2, [0], brake_force=np.nan), "brake_force is nan"),
        (lambda: Reel(2, [0], share=0.0), "share is 0"),
        (lambda: Reel(2, [0], creep_speed=0.0), "creep_speed is 0"),
        (lambda: Reel(2, [0], shortest=1.0, longest=1.0), "from 1 to 1 m"),
        (lambda: Reel(2, [0], ratchet=True), "ratchet without brake_force"),
    ],
)
def test_a_reel_that_cannot_be_is_refused(make, reported):
    with pytest.raises(InputError, match=reported):
        make()


@pytest.mark.parametrize(
    ("reels", "reported"),
    [
        ([Reel(7, [0])], "its node is 7, but the net has 3 nodes"),
        ([Reel(1, [0])], "cable 0 ends at its node 1"),
        ([Reel(2, [3])], "cable 3, but the net has 1 cables"),
        ([Reel(2, [0, 0])], "on a reel twice"),
        ([Reel(2, [0]), Reel(2, [0])], "on a reel twice"),
    ],
)
def test_reels_that_do_not_fit_the_net_are_refused(reels, reported):
    net = net_of()
    with pytest.raises(InputError, match=reported):
        forces_of(reels, net, Cords.of(net, STIFF), np.zeros(1))
