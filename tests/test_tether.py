"""The tether: how it is laid and tied, and its flights with each way of paying out."""

import numpy as np
import pytest
from conftest import CORD, SOFT
from numpy.random import default_rng

from netdae.core.errors import InputError
from netdae.forces.loads import NodalLoad
from netdae.initial.scaled import ejected, scaled
from netdae.model.material import Material
from netdae.model.motions import Fixed, TableMotion
from netdae.model.mouth import mouth_of
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.model.tether import Chaser, Tether, own_nodes_of
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot
from netdae.system.system import System
from netdae.system.tether_assembly import with_tether

LINE = Material(youngs_modulus=1e9, density=1000.0, diameter=2e-3)
"""EA 3.1 kN, 3.1 g/m."""

AT = (0.1, 0.2, -3.0)


def net_and_start(seed=None):
    """A 1 m net drawn together to 0.3, its corners shot upward."""
    net, start = scaled(CableNet.square(side=1.0, cells=4), (0.3, 0.3, 1.0))
    return net, ejected(net, start, "corners", speed=1.0, half_angle_deg=30.0)


def tether(group="centre", **changes):
    values = {"elements": 6, "material": LINE, "chaser": Chaser(AT, mass=50.0), "slack": 0.05}
    return Tether(group, **{**values, **changes})


def tied(**changes):
    return with_tether(*net_and_start(), tether(**changes))


def system_of(tied, *, net=CORD, **more):
    return System(
        tied.net,
        {"all": net, **tied.materials},
        damping=Dashpot(viscosity_time=1e-3),
        masses={"corners": 0.1, **tied.masses},
        restraints=tied.restraints,
        reels=tied.reels,
        **more,
    )


def test_the_chain_runs_from_the_node_to_the_chaser():
    net, start = net_and_start()
    found = tied()
    centre, chaser = int(net.nodes_of("centre")[0]), int(found.net.nodes_of("chaser")[0])
    chain = found.net.cables[found.net.cables_of("tether")]
    assert len(chain) == 6
    assert (chain[0, 0], chain[-1, 1]) == (centre, chaser)
    np.testing.assert_array_equal(chain[1:, 0], chain[:-1, 1])
    np.testing.assert_array_equal(found.start.x[chaser], AT)
    way = np.linalg.norm(np.array(AT) - start.x[centre])
    assert found.length == pytest.approx(1.05 * way, rel=1e-14)
    np.testing.assert_allclose(found.net.rest_length[found.net.cables_of("tether")], found.length / 6)
    assert found.net.cable_groups.keys() - net.cable_groups.keys() == {"tether"}
    assert found.reels == ()
    assert found.masses == {"chaser": 50.0}


def test_the_net_itself_stays_as_it_is():
    plain, start = net_and_start()
    data = {"diameter": np.linspace(1e-3, 2e-3, plain.cable_count)}
    net = CableNet(plain.nodes, plain.cables, plain.node_groups, plain.cable_groups, plain.rest_length, data)
    found = with_tether(net, start, tether(payout="free", drum_inertia=1.0))
    n, m = net.node_count, net.cable_count
    np.testing.assert_array_equal(found.net.nodes[:n], net.nodes)
    np.testing.assert_array_equal(found.net.cables[:m], net.cables)
    np.testing.assert_array_equal(found.net.rest_length[:m], net.rest_length)
    np.testing.assert_array_equal(found.start.x[:n], start.x)
    np.testing.assert_array_equal(found.start.v[:n], start.v)
    np.testing.assert_array_equal(own_nodes_of(found.net), np.arange(n))
    np.testing.assert_array_equal(own_nodes_of(net), np.arange(n))
    np.testing.assert_array_equal(mouth_of(found.net, "border"), mouth_of(net, "border"))
    for name in net.node_groups.keys() - {"all"}:
        np.testing.assert_array_equal(found.net.nodes_of(name), net.nodes_of(name))
    np.testing.assert_array_equal(found.net.cable_data["diameter"][:m], data["diameter"])
    assert np.isnan(found.net.cable_data["diameter"][m:]).all()  # the tether's own material holds
    mass = system_of(found).mass
    own = System(net, CORD, damping=Dashpot(viscosity_time=0.0), masses={"corners": 0.1}).mass
    cord = 1000.0 * np.pi * 1e-6 * found.length
    assert mass.sum() == pytest.approx(own.sum() + cord + 50.0 + 1.0, rel=1e-12)  # and the drum


@pytest.mark.parametrize("bridle", [None, 0.5, 2.0])
@pytest.mark.parametrize("size", [{"slack": 0.0}, {"slack": 0.3}, {"length": 3.2}, {"length": 20.0}])
def test_nothing_is_taut_and_no_two_knots_coincide(bridle, size):
    found = tied(**{"slack": None, **size}, bridle=bridle, group="centre" if bridle is None else "corners")
    spans = found.start.x[found.net.cables[:, 1]] - found.start.x[found.net.cables[:, 0]]
    new = slice(net_and_start()[0].cable_count, None)
    strain = np.linalg.norm(spans[new], axis=1) / found.net.rest_length[new] - 1
    assert strain.max() < 1e-14  # where the slack is zero, the round-off of a length
    x = found.start.x[:-1] if found.reels else found.start.x
    apart = np.linalg.norm(x[:, None] - x[None], axis=2) + np.eye(len(x))
    assert apart.min() > 1e-2


def test_a_bridle_ties_each_node_by_a_leg_of_its_length():
    found = tied(group="corners", bridle=0.6)
    net, legs = found.net, found.net.cables_of("bridle")
    junction = net.cables[net.cables_of("tether")[0], 0]
    assert net.rest_length[legs].sum() == pytest.approx(4 * 0.6, rel=1e-14)
    ends = net.cables[legs]
    np.testing.assert_array_equal(
        np.intersect1d(ends[:, 0], net.nodes_of("corners")), net.nodes_of("corners")
    )
    assert np.count_nonzero(ends[:, 1] == junction) == 4
    # with a slack of 5 %, the junction is as far from the farthest corner as a leg of that slack reaches
    away = np.linalg.norm(found.start.x[net.nodes_of("corners")] - found.start.x[junction], axis=1)
    assert away.max() == pytest.approx(0.6 / 1.05, rel=1e-12)
    assert set(found.materials) == {"tether", "bridle"}


def test_the_tether_starts_with_the_chaser():
    found = tied(chaser=Chaser(AT, velocity=(0.1, 0.0, -0.2), mass=5.0))
    added = np.setdiff1d(np.arange(found.net.node_count), own_nodes_of(found.net))
    np.testing.assert_array_equal(found.start.v[added], np.broadcast_to([0.1, 0.0, -0.2], (6, 3)))


def test_mass_that_pay_out_leaves_behind_is_reported():
    assert tether().mass_left(100.0) == pytest.approx(1000 * np.pi * 1e-6 * 100, rel=1e-14)
    by_length = Material(youngs_modulus=1e9, linear_density=0.002, area=1e-6)
    assert tether(material=by_length).mass_left(50.0) == pytest.approx(0.1, rel=1e-14)


OPTIONS = SolverOptions(rtol=1e-5, atol_position=1e-7, atol_velocity=1e-5)
BRAKED = {"payout": "braked", "brake_force": 0.5, "drum_inertia": 0.05}
FREE = {"payout": "free", "drum_inertia": 0.05}


def flight_of(times, *, speed, running=False, loads=(), **changes):
    """A spread net of soft cord flies off its chaser at `speed` m/s; system and flight.

    running : tether and drum fly along from the start
    """
    net, start = scaled(CableNet.square(side=0.6, cells=2))
    values = {"material": SOFT, "elements": 3, "slack": 0.0, "chaser": Chaser((0.1, 0.2, -1.0), mass=2.0)}
    found = with_tether(net, start, tether(**{**values, **changes}))
    system = system_of(found, net=SOFT, loads=loads)
    v = found.start.v.copy()
    moving = own_nodes_of(found.net)
    if running:
        moving = np.union1d(moving, found.net.nodes_of("tether"))
        v[-1, 0] = speed
    n = found.start.x[net.nodes_of("centre")[0]] - found.start.x[found.net.nodes_of("chaser")[0]]
    v[moving] = speed * n / np.linalg.norm(n)
    # 1 um sideways, so that nothing is symmetric
    x = found.start.x + 1e-6 * default_rng(2).standard_normal(found.start.x.shape) * system.in_space[:, None]
    return system, simulate(system, State.at(x, v), times, options=OPTIONS)


def kept_in(system, flight):
    """What is kept, J, beside the kinetic energy of the start, (k,)."""
    energy = [system.kinetic_energy(f.v) + system.elastic_energy(f.x) for f in flight]
    return (energy + flight.dissipated_energy - flight.external_work - energy[0]) / energy[0]


def paid_out(flight):
    return flight.positions[:, -1, 0]


@pytest.mark.parametrize(
    "changes",
    [{}, {"group": "corners", "bridle": 0.6}, {**BRAKED, "brake_force": 0.1}, {**FREE, "longest": 1.1}],
    ids=["locked", "bridle", "braked", "free"],
)
def test_net_and_chaser_keep_momentum_and_energy(changes):
    """A net flies off a free chaser, over the snap of the tether."""
    system, flight = flight_of(np.linspace(0, 0.5, 6), speed=1.0, **changes)
    first, last = flight[0], flight[-1]
    np.testing.assert_allclose(system.momentum(last.v), system.momentum(first.v), rtol=0, atol=1e-12)
    turned = system.angular_momentum(last.x, last.v) - system.angular_momentum(first.x, first.v)
    np.testing.assert_allclose(turned, 0.0, rtol=0, atol=1e-4)  # rtol of 0.5 N m s, in a few hundred steps
    np.testing.assert_allclose(kept_in(system, flight), 0.0, atol=1e-3)  # the integrator's own share
    assert last.v[system.net.nodes_of("chaser"), 2] > 1e-2  # it was pulled along
    chain = system.net.cables_of("tether")
    if system.reels:
        assert paid_out(flight)[-1] > 0.01
        L = system.net.rest_length[chain].sum() + paid_out(flight)[-1]
        assert system.rest_length(last.x)[chain].sum() == pytest.approx(L, rel=1e-12)


def test_a_braked_tether_pulls_with_its_brake_force():
    """I s̈ = N − F_b, so that the impulse on the held chaser is −(F_b t + I Δṡ), and friction takes F_b s."""
    times, held = [0.0, 0.1, 0.4], Chaser((0.1, 0.2, -1.0), motion=Fixed())
    system, flight = flight_of(times, speed=2.0, running=True, chaser=held, **BRAKED)
    s, rate = paid_out(flight), flight.velocities[:, -1, 0]
    impulse = np.linalg.norm(flight.external_impulse[2] - flight.external_impulse[1])
    assert rate.min() > 0.5
    # N l/L̄ and N differ by the strain of 0.5 N over 31 N; the pull turns with the centre, which lags by 1 cm
    assert impulse == pytest.approx(0.5 * 0.3 + 0.05 * (rate[2] - rate[1]), rel=0.02)
    dissipated = flight.dissipated_energy[2] - flight.dissipated_energy[1]
    assert dissipated == pytest.approx(0.5 * (s[2] - s[1]), rel=0.05)  # the dashpot takes its share
    np.testing.assert_allclose(kept_in(system, flight), 0.0, atol=1e-3)


def test_a_free_tether_ends_where_its_drum_is_empty():
    system, flight = flight_of(np.linspace(0, 1.2, 25), speed=2.0, running=True, **FREE, longest=1.5)
    length = system.net.rest_length[system.net.cables_of("tether")].sum()
    k = 31.4 / (length / 3)  # of the stop
    inside = paid_out(flight) - (1.5 - length)
    assert inside.max() > 0.0
    # it takes the net's and the chaser's kinetic energy of less than 1 J at most; 0.5 k δ² = that
    assert inside.max() < np.sqrt(2 * system.kinetic_energy(flight[0].v) / k)
    np.testing.assert_allclose(kept_in(system, flight), 0.0, atol=1e-3)


def test_a_driven_tether_follows_its_table():
    table = TableMotion([0.0, 0.3, 0.6], np.outer([0.0, 0.1, -0.1], [1, 0, 0]))
    held = Chaser((0.1, 0.2, -1.0), motion=Fixed())
    loads = [NodalLoad("centre", [0, 0, 0.5])]
    system, flight = flight_of([0.0, 0.3, 0.6], speed=0.0, payout=table, chaser=held, loads=loads)
    chain = system.net.cables_of("tether")
    length = system.net.rest_length[chain].sum()
    for frame, paid in zip(flight, [0.0, 0.1, -0.1], strict=True):
        assert system.rest_length(frame.x)[chain].sum() == pytest.approx(length + paid, rel=1e-12)
    assert flight.external_work[-1] != 0.0
    energy = [system.kinetic_energy(f.v) + system.elastic_energy(f.x) for f in flight]
    kept = energy + flight.dissipated_energy - flight.external_work
    np.testing.assert_allclose(kept, kept[0], rtol=0, atol=1e-3 * max(energy))


def test_a_lock_holds_what_is_paid_out():
    """From 0.3 s on; the drum's stop is no impulse in space, its energy is booked as work from outside."""
    times = [0.0, 0.2, 0.3, 0.4, 0.5]
    system, flight = flight_of(times, speed=2.0, running=True, **BRAKED, lock=0.3)
    s = paid_out(flight)
    assert s[2] > s[1] > 0.0
    np.testing.assert_array_equal(s[2:], s[2])
    np.testing.assert_array_equal(flight.velocities[3:, -1, 0], 0.0)
    momenta = [system.momentum(frame.v) for frame in flight]
    np.testing.assert_allclose(momenta, [momenta[0]] * 5, rtol=0, atol=1e-12)
    np.testing.assert_allclose(flight.external_impulse, 0.0, atol=1e-12)
    np.testing.assert_allclose(kept_in(system, flight), 0.0, atol=1e-3)
    assert flight.external_work[-1] < 0.0


def test_a_lock_ends_a_driven_reel():
    table = TableMotion([0.0, 0.4], [[0, 0, 0], [0.2, 0, 0]], interpolation="linear")
    _, flight = flight_of(
        [0.0, 0.2, 0.3, 0.4],
        speed=0.0,
        payout=table,
        chaser=Chaser((0.1, 0.2, -1.0), motion=Fixed()),
        lock=0.3,
        drum_inertia=0.05,
    )
    np.testing.assert_allclose(paid_out(flight), [0.0, 0.1, 0.15, 0.15], rtol=0, atol=1e-12)


def test_an_empty_group_is_reported():
    net, start = net_and_start()
    bare = CableNet(net.nodes, net.cables, {"hook": []}, rest_length=net.rest_length)
    with pytest.raises(InputError, match="tether: the node group 'hook' is empty: name the node"):
        with_tether(bare, start, tether("hook"))


@pytest.mark.parametrize(
    ("changes", "reported"),
    [
        ({"group": "hook"}, "there is no node group 'hook'"),
        ({"slack": None, "length": 2.0}, "it is 2 m long, but the chaser stands 3.00832 m away"),
        ({"chaser": Chaser((0.0, 0.0, 0.0), mass=1.0)}, "the chaser stands where the tether begins"),
        ({"group": "corners"}, "has 4 nodes: give bridle"),
        ({"bridle": 1.0}, "has one node, which needs no bridle"),
        ({"group": "corners", "bridle": 0.1}, "bridle is 0.1 m, too short for its legs to meet"),
        ({"chaser": Chaser((0.3, 0.0, 0.0), mass=1.0), "elements": 4}, "lies on node"),
        ({**FREE, "longest": 2.0}, "longest is 2 m, less than its length at the start"),
        (
            {"payout": TableMotion([0.0, 1.0], [[0, 0, 0], [-0.6, 0, 0]])},
            "driven to -0.6 m at t = 1 s, and the last cable has 0.526456 m",
        ),
    ],
)
def test_a_tether_that_cannot_be_tied_is_refused(changes, reported):
    with pytest.raises(InputError, match=reported):
        tied(**changes)


@pytest.mark.parametrize(
    ("make", "reported"),
    [
        (lambda: tether(elements=0), "elements is 0"),
        (lambda: tether(length=3.0), "just one of length and slack"),
        (lambda: tether(slack=None), "just one of length and slack"),
        (lambda: tether(slack=-0.1), "slack is -0.1"),
        (lambda: tether(slack=None, length=0.0), "length is 0 m"),
        (lambda: tether(payout="loose"), "payout is 'loose': choose one of locked, free, braked"),
        (lambda: tether(payout="free"), "payout is free, which needs drum_inertia"),
        (lambda: tether(payout="braked", drum_inertia=1.0), "needs brake_force"),
        (lambda: tether(payout="free", drum_inertia=1.0, brake_force=1.0), "brake_force says nothing"),
        (lambda: tether(drum_inertia=1.0), "drum_inertia says nothing where payout is locked"),
        (lambda: tether(lock=1.0), "lock says nothing where payout is locked"),
        (
            lambda: tether(payout=TableMotion([0.0, 1.0], np.zeros((2, 3))), lock=0.5),
            "payout is driven, which needs drum_inertia",
        ),
        (lambda: Chaser(AT), "free but has no mass"),
        (lambda: Chaser((0.0, np.nan, 0.0), mass=1.0), "position of the chaser is"),
        (lambda: Chaser(AT, mass=-1.0), "mass of the chaser is -1 kg"),
        (lambda: Chaser(AT, velocity=(1.0, 0.0, 0.0), motion=Fixed()), "has a motion and the velocity"),
    ],
)
def test_a_tether_that_cannot_be_is_refused(make, reported):
    with pytest.raises(InputError, match=reported):
        make()


def test_groups_that_the_net_has_already_are_reported():
    net, start = net_and_start()
    named = CableNet(net.nodes, net.cables, {**net.node_groups, "chaser": [1]}, rest_length=net.rest_length)
    with pytest.raises(InputError, match="the net has a node group 'chaser' already"):
        with_tether(named, start, tether())
