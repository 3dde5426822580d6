"""Equilibrium and vibration against balances of force, flights, dense algebra and hand calculations."""

import numpy as np
import pytest
from conftest import CORD, SOFT, line, random_net
from numpy.random import default_rng
from scipy.linalg import eigh, eigvalsh

import netdae as nd
from netdae.forces.force import Account, Tangent
from netdae.solvers import statics

GRAVITY = nd.Gravity([0.0, 0.0, -9.81])
CORNERS = nd.Restraint("corners")
STILL = nd.NoDamping()


def hanging(cells, cord=CORD, **more):
    """Square net of 5 m, flat and unstressed, held by its corners."""
    net = nd.CableNet.square(side=5.0, cells=cells)
    return nd.System(net, cord, damping=STILL, loads=[GRAVITY], restraints=[CORNERS], **more)


def free_stiffness(system, x):
    free = np.flatnonzero(~system.restrained)
    return system.tangent_matrix(x).toarray()[np.ix_(free, free)]


def potential(system, x):
    """Elastic energy less the work of gravity, J."""
    return system.elastic_energy(x) + 9.81 * float(system.mass @ x[:, 2])


# Equilibrium


def test_hanging_net_of_441_knots_converges_from_flat_and_unstressed():
    system = hanging(20)
    rest = nd.equilibrium(system, system.net.nodes)
    f = system.force(0.0, rest.x, np.zeros_like(rest.x))
    # knots weigh 5 mN; positions of 5 m are round to 1e-15 m, which on EA/L = 220 kN/m is 2e-10 N a cable
    assert np.abs(f[~system.restrained]).max() < 2e-9
    assert rest.residual < 2e-9
    weight = 9.81 * system.mass.sum()
    np.testing.assert_allclose(rest.reactions.sum(axis=0), [0.0, 0.0, weight], atol=1e-8)
    turning = np.cross(rest.x, rest.reactions - 9.81 * system.mass[:, None] * [0, 0, 1]).sum(axis=0)
    np.testing.assert_allclose(turning, 0.0, atol=1e-7)
    assert not rest.mechanisms
    assert not rest.reactions[~system.restrained].any()
    assert np.array_equal(rest.x[system.restrained], system.net.nodes[system.restrained])
    mirrored = rest.x.reshape(21, 21, 3)[::-1, :, 2]
    np.testing.assert_allclose(rest.x.reshape(21, 21, 3)[:, :, 2], mirrored, atol=1e-6)


@pytest.mark.parametrize("law", ["st_venant_kirchhoff", "engineering"])
@pytest.mark.parametrize("toe_strain", [0.0, 1e-2])
def test_equilibrium_has_the_least_potential_energy(law, toe_strain):
    cord = nd.Material(youngs_modulus=1e7, density=1000.0, diameter=2e-3, law=law, toe_strain=toe_strain)
    net = random_net(seed=3)
    held = nd.Restraint("few")
    system = nd.System(net, cord, damping=STILL, loads=[GRAVITY], restraints=[held])
    rest = nd.equilibrium(system, net.nodes)
    least = potential(system, rest.x)
    rng = default_rng(0)
    for size in (1e-4, 1e-2, 1.0):
        for _ in range(20):
            u = size * rng.standard_normal(rest.x.shape) * ~system.restrained
            assert potential(system, rest.x + u) > least
    # half the cables are slack: both sides of Eq. (4) were met
    assert 0 < (system.tension(rest.x) > 0).sum() < net.cable_count


@pytest.mark.parametrize("name", ["flat", "crumpled", "packed", "one point", "far below"])
def test_where_the_net_rests_does_not_depend_on_the_start(name):
    system = hanging(8, masses={"centre": 0.05})
    corners, flat = system.restrained, system.net.nodes
    noise = default_rng(1).standard_normal(flat.shape)
    start = {
        "flat": flat,
        "crumpled": flat + 0.3 * noise,
        "packed": flat * 0.01,
        "one point": flat * 0.0,
        "far below": flat - np.array([0.0, 0.0, 50.0]),
    }[name]
    found = nd.equilibrium(system, np.where(corners, flat, start))
    expected = nd.equilibrium(system, flat + 0.1 * noise * ~corners)
    # where q is small: 1e-9 N over 0.1 N/m
    np.testing.assert_allclose(found.x, expected.x, atol=1e-7)


def test_load_steps_carry_a_packed_net_to_where_it_hangs():
    system = hanging(10)
    rest = nd.equilibrium(system, 0.01 * system.net.nodes)
    assert rest.load_steps > 3
    assert rest.residual < 2e-9
    assert not rest.mechanisms
    # the corners are 5 cm apart: the middle hangs below them by the cables on the way, 2.5 m and 2.5 m
    assert rest.x[:, 2].min() == pytest.approx(-5.0, abs=0.05)


def test_load_steps_lead_where_newton_leads_straight(monkeypatch):
    net = line(10, length=3.0)
    ends = [nd.Restraint("first"), nd.Restraint("last")]
    system = nd.System(net, SOFT, damping=STILL, loads=[GRAVITY], restraints=ends)
    straight = nd.equilibrium(system, net.nodes)
    assert straight.load_steps == 0
    monkeypatch.setattr(statics, "STRAIGHT_ITERATIONS", 0)
    stepped = nd.equilibrium(system, net.nodes)
    assert stepped.load_steps > 1
    np.testing.assert_allclose(stepped.x, straight.x, atol=1e-10)
    monkeypatch.setattr(statics, "STAGE_ITERATIONS", 0)
    with pytest.raises(
        nd.RunError, match=r"no equilibrium was found: a force of .* N along z is left on node"
    ):
        nd.equilibrium(system, net.nodes)


def test_a_damped_flight_comes_to_rest_in_the_equilibrium():
    net = nd.CableNet.square(side=1.0, cells=2)
    damping = nd.Rayleigh(alpha=8.0, beta=1e-3)  # 1/s: about critical for the slowest swing
    system = nd.System(
        net, SOFT, masses={"centre": 0.02}, damping=damping, loads=[GRAVITY], restraints=[CORNERS]
    )
    start = nd.State.at(net.nodes * [0.9, 0.9, 1.0])
    rest = nd.equilibrium(system, start)
    flight = nd.simulate(system, start, [0.0, 8.0])
    assert np.abs(flight[-1].v).max() < 1e-5
    # what is left after 8 s of a decay of 4 per second, and the flight's own tolerance of 1e-5 m
    np.testing.assert_allclose(flight.positions[-1], rest.x, atol=3e-5)
    assert np.abs(rest.x - start.x).max() > 0.05


def test_motions_and_loads_are_those_of_the_time_asked_for():
    net = line(1, length=2.0)
    pull = nd.FunctionMotion(lambda t: [0.1 * t, 0, 0], lambda t: [0.1, 0, 0], lambda t: [0, 0, 0])
    sides = [nd.Restraint("first"), nd.Restraint("last", "x", pull), nd.Restraint("last", "yz")]
    system = nd.System(net, SOFT, damping=STILL, restraints=sides)
    rest = nd.equilibrium(system, net.nodes, t=2.0)
    E11 = 0.5 * (1.1**2 - 1)
    N = 1e7 * np.pi * 1e-6 * E11 * 1.1
    np.testing.assert_allclose(rest.reactions, [[-N, 0, 0], [N, 0, 0]], rtol=1e-12)
    assert rest.state.t == 2.0

    load = nd.NodalLoad("last", nd.Function(lambda t: [t, 0.0, 0.0]))
    system = nd.System(net, SOFT, damping=STILL, loads=[load], restraints=[nd.Restraint("first")])
    start = nd.State.at(net.nodes, t=0.5)
    assert system.tension(nd.equilibrium(system, start).x)[0] == pytest.approx(0.5, rel=1e-9)
    assert system.tension(nd.equilibrium(system, start, t=3.0).x)[0] == pytest.approx(3.0, rel=1e-9)


def test_balanced_pulls_stretch_a_net_that_floats():
    net = line(4, length=2.0)
    pulls = [nd.NodalLoad("first", [0.0, -2.0, 0.0]), nd.NodalLoad("last", [0.0, 2.0, 0.0])]
    system = nd.System(net, SOFT, damping=STILL, loads=pulls)
    rest = nd.equilibrium(system, net.nodes + 0.01 * default_rng(0).standard_normal((5, 3)))
    np.testing.assert_allclose(system.tension(rest.x), 2.0, rtol=1e-9)  # has turned into their line
    assert [(m.nodes.tolist(), m.axes) for m in rest.mechanisms] == [([0, 1, 2, 3, 4], "xyz")]


class Ground:
    """Springs of k N/m to the places where the nodes are at first; the Newton matrix of a flight takes no part."""

    newton, jumps, kinks, external = "nothing", (), (), True

    def __init__(self, places, k):
        self.nodes, self.places, self.k = np.arange(len(places))[:, None], places[:, None], k

    def force(self, t, x, v):
        return self.k * (self.places - x)

    def tangent(self, t, x, v):
        K = np.tile(-self.k * np.eye(3)[None, :, None, :], (len(x), 1, 1, 1, 1))
        return Tangent.of_all(K, np.zeros_like(K))

    def account(self, t, x, v):
        return Account()


def test_a_net_rests_on_springs_whose_tangent_a_flight_leaves_out():
    net = nd.CableNet.square(side=2.0, cells=2)
    ground = Ground(np.array(net.nodes), 50.0)
    system = nd.System(net, SOFT, damping=STILL, loads=[GRAVITY], forces=[ground], masses={"all": 0.1})
    rest = nd.equilibrium(system, net.nodes)
    # knots sink each by its own weight, all but the same, so that no cable becomes taut enough to share it
    sunk = 9.81 * system.mass.sum() / 50.0
    assert net.nodes[:, 2].sum() - rest.x[:, 2].sum() == pytest.approx(sunk, rel=1e-9)
    assert rest.iterations < 20
    assert rest.load_steps == 0


# Mechanisms


def test_mechanisms_are_the_null_space_of_the_tangent():
    # a taut line between two anchors with a loose tail from its middle, whose last node may slide on a table
    x = [[0.0, 0, 0], [1, 0, 0], [0.5, 0, 0], [0.5, 0.4, 0], [0.5, 0.8, 0]]
    cables = [[0, 2], [2, 1], [2, 3], [3, 4]]
    net = nd.CableNet(x, cables, {"ground": [0, 1], "table": [4]}, rest_length=[0.45, 0.45, 0.6, 0.6])
    held = [nd.Restraint("ground"), nd.Restraint("table", "z")]
    system = nd.System(net, SOFT, damping=STILL, restraints=held)
    rest = nd.equilibrium(system, net.nodes)
    assert [(m.nodes.tolist(), m.axes) for m in rest.mechanisms] == [([3], "xyz"), ([4], "xy")]
    eigenvalues = eigvalsh(free_stiffness(system, rest.x))
    assert rest.zero_modes == (np.abs(eigenvalues) < 1e-9 * eigenvalues[-1]).sum() == 5
    found, _ = nd.frequencies(system, rest, count=6)
    assert np.array_equal(found[:5], np.zeros(5))
    assert found[5] > 0.1


def test_unloaded_slack_net_stays_where_it_is_and_says_that_nothing_holds_it():
    net = nd.CableNet.square(side=5.0, cells=4)
    system = nd.System(net, CORD, damping=STILL, restraints=[CORNERS])
    rest = nd.equilibrium(system, 0.5 * net.nodes)
    assert np.array_equal(rest.x, 0.5 * net.nodes)
    assert rest.iterations == 0
    assert rest.zero_modes == 3 * (25 - 4)
    assert np.array_equal(nd.frequencies(system, rest)[0], np.zeros(6))


@pytest.mark.parametrize(("axes", "along"), [("xy", "z"), (None, "z")])
def test_a_net_that_nothing_holds_against_its_weight_has_no_equilibrium(axes, along):
    net = nd.CableNet.square(side=1.0, cells=2)
    held = [] if axes is None else [nd.Restraint("corners", axes)]
    system = nd.System(net, CORD, damping=STILL, loads=[GRAVITY], restraints=held)
    with pytest.raises(
        nd.RunError, match=rf"a load of -\S+ N along {along} .* 9 connected nodes .* fall freely"
    ):
        nd.equilibrium(system, net.nodes)


def test_a_loose_part_that_falls_is_named():
    net = line(3, length=3.0)
    net = nd.CableNet(net.nodes, [[0, 1], [2, 3]], net.node_groups)
    system = nd.System(net, CORD, damping=STILL, loads=[GRAVITY], restraints=[nd.Restraint("first")])
    with pytest.raises(
        nd.RunError, match=r"2 connected nodes around node 2, none of which is restrained along z"
    ):
        nd.equilibrium(system, net.nodes)


def test_a_start_of_the_wrong_shape_or_with_nan_is_refused():
    system = hanging(2)
    with pytest.raises(nd.InputError, match=r"\(3, 3\): the net has 9 nodes"):
        nd.equilibrium(system, np.zeros((3, 3)))
    x = system.net.nodes.copy()
    x[4, 1] = np.nan
    with pytest.raises(nd.InputError, match="node 4 starts at"):
        nd.equilibrium(system, x)
    with pytest.raises(nd.InputError, match=r"\(2, 3\): the net has 9 nodes"):
        nd.frequencies(system, np.zeros((2, 3)))
    for count in (0, 16):
        with pytest.raises(nd.InputError, match=f"count is {count}: the net has 15 free axes"):
            nd.frequencies(system, system.net.nodes, count=count)


# Frequencies


@pytest.mark.parametrize("cells", [6, 16])  # by the dense and by the sparse solver
def test_frequencies_and_modes_solve_the_eigenproblem_of_the_paper(cells):
    system = hanging(cells)
    rest = nd.equilibrium(system, system.net.nodes)
    found, modes = nd.frequencies(system, rest, count=5)
    free = ~system.restrained.ravel()
    M = np.repeat(system.mass, 3)[free]
    squares = eigh(free_stiffness(system, rest.x), np.diag(M), eigvals_only=True, subset_by_index=[0, 4])
    # eigenvalues from 60 beside 1e9 1/s²: round-off of 1e-7 relative in the dense ones
    np.testing.assert_allclose(found, np.sqrt(squares) / (2 * np.pi), rtol=1e-6)
    phi = modes.reshape(5, -1)
    assert not phi[:, ~free].any()
    np.testing.assert_allclose(phi[:, free] * M @ phi[:, free].T, np.eye(5), atol=1e-9)
    T = system.tangent_matrix(rest.x)
    for f, mode in zip(found, phi, strict=True):
        inertia = (2 * np.pi * f) ** 2 * M * mode[free]
        scale = np.abs(inertia).max()
        np.testing.assert_allclose((T @ mode)[free], inertia, atol=1e-4 * scale)


def test_frequencies_of_a_large_net_that_is_mostly_loose_are_zero_soon():
    net = nd.CableNet.square(side=5.0, cells=8, subdivide=4)
    system = nd.System(net, CORD, damping=STILL, restraints=[CORNERS])
    # in y all cables are just at their rest length, without tension: hundreds of motions share 0 Hz
    rest = nd.equilibrium(system, net.nodes * [1.002, 1.0, 1.0])
    assert rest.zero_modes > 700
    found, modes = nd.frequencies(system, rest, count=20)
    assert np.array_equal(found, np.zeros(20))
    phi = modes.reshape(20, -1)
    np.testing.assert_allclose(phi * np.repeat(system.mass, 3) @ phi.T, np.eye(20), atol=1e-9)


@pytest.mark.parametrize("load", [200.0, 0.0])
def test_parts_without_load_do_not_keep_a_net_from_its_balance(load):
    # weightless knots and cables that just come taut: the energy is flat to the fourth order there
    net = nd.CableNet.diamond(side=5.0, cells=8)
    pull = nd.NodalLoad("centre", [3.0, 1.0, -load])
    system = nd.System(net, CORD, damping=STILL, loads=[pull], restraints=[CORNERS])
    rest = nd.equilibrium(system, net.nodes)
    np.testing.assert_allclose(rest.reactions.sum(axis=0), [-3.0, -1.0, load], atol=1e-7)
    assert rest.residual < 2e-9
    assert rest.mechanisms


class Repulsion:
    """Force k x on one node, away from the origin."""

    newton, jumps, kinks, external = "symmetric", (), (), True

    def __init__(self, node, k):
        self.nodes, self.k = np.array([[node]]), k

    def force(self, t, x, v):
        return self.k * x

    def tangent(self, t, x, v):
        return Tangent.of_all(self.k * np.eye(3).reshape(1, 1, 3, 1, 3), np.zeros((1, 1, 3, 1, 3)))

    def account(self, t, x, v):
        return Account()


def test_an_unstable_state_has_negative_frequencies():
    net = line(1, length=1.0)
    push = Repulsion(0, 3.0)
    system = nd.System(net, SOFT, damping=STILL, restraints=[nd.Restraint("last")], forces=[push])
    found, _ = nd.frequencies(system, 0.5 * net.nodes, count=3)  # slack, so the push is alone
    expected = -np.sqrt(3.0 / system.mass[0]) / (2 * np.pi)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_a_force_that_holds_the_net_is_part_of_the_balance():
    net = line(1, length=1.0)
    spring = Repulsion(0, -50.0)  # draws node 0 to the origin; the cable's weight hangs below
    system = nd.System(net, SOFT, damping=STILL, masses={"last": 0.5}, loads=[GRAVITY], forces=[spring])
    rest = nd.equilibrium(system, net.nodes + np.array([0.01, 0.0, 0.0]))
    weight = 9.81 * system.mass
    np.testing.assert_allclose(rest.x[0], [0.0, 0.0, -weight.sum() / 50.0], atol=1e-9)
    assert system.tension(rest.x)[0] == pytest.approx(weight[1], rel=1e-9)
