"""The cord through rings: against a reduction to one degree of freedom, Atwood's machine with a capstan, and reels."""

import numpy as np
import pytest
from conftest import STIFF
from flights import energy_of
from numpy.random import default_rng

from netdae.core.errors import InputError, RunError
from netdae.forces.drawcord import drawcord, tensions_of
from netdae.forces.elements import ElementForce
from netdae.forces.loads import NodalLoad
from netdae.forces.loops import TENSION
from netdae.forces.motor import MOTOR, Motor
from netdae.forces.reel import REELED, Reeled
from netdae.forces.rings import Cord, Rings
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.runs.verification.cases import drawn_polygon
from netdae.runs.verification.cases.drawn_polygon import polygon, winding
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping
from netdae.system.net_forces import NetForces
from netdae.system.reels import Reel
from netdae.system.system import System

SOFT = Material(youngs_modulus=1e8, linear_density=1e-9, area=1e-6)
"""EA 100 N, massless."""

TIGHT = SolverOptions(rtol=1e-8, atol_position=1e-10, atol_velocity=1e-8)


def cord(L=1.0, share=-1.0, EA=50.0, eps=0.0, engineering=False, tau=0.0, size=1e-3, friction=0.0, theta=1.0):
    return Cord(L, share, EA, eps, engineering, tau, size, friction, 0.5, theta)


def ringed(places, *, closed=True, length=None, extra=()):
    """A net of one cord through `places` (k, 3), whose reel is its last node, the length as it lies by default."""
    k = len(places)
    cables = np.stack((np.arange(k), np.roll(np.arange(k), -1)), axis=1)[: k if closed else -1]
    h = np.linalg.norm(places[cables[:, 1]] - places[cables[:, 0]], axis=1)
    L = h if length is None else h * length / h.sum()
    nodes = np.concatenate((places, np.zeros((1, 3))))
    return CableNet(nodes, cables, {"rings": np.arange(k), "drum": [k], **dict(extra)}, rest_length=L)


def system_of(net, rings=None, *, material=SOFT, mass=1.0, damping=None, inertia=None, drum=None, **more):
    k = net.node_count - 1
    inertia = inertia or (1.0 if drum is None else 0.0)
    reel = Reel(k, np.arange(net.cable_count), inertia=inertia, share=-1.0, rings=rings or Rings(size=1e-3))
    held = [] if drum is None else [Restraint("drum", axes="x", motion=drum)]
    masses = {"rings": mass} if np.isscalar(mass) else mass
    return System(
        net,
        material,
        damping=damping or NoDamping(),
        masses=masses,
        reels=[reel],
        restraints=[*held, *more.pop("restraints", [])],
        **more,
    )


@pytest.mark.parametrize("setting", drawn_polygon.CASE.settings, ids=lambda setting: setting.label)
def test_a_polygon_of_free_masses_is_drawn_in_as_its_radius_is(setting):
    drawn_polygon.fly(setting).require()


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_a_skew_cord_keeps_both_momenta_and_balances_the_energy(friction):
    """Free masses of different weights, thrown and drawn in by a free heavy drum: nothing is outside."""
    rng = default_rng(4)
    k = 7
    net = ringed(polygon(k, 1.0) + 0.2 * rng.standard_normal((k, 3)), extra={"odd": [1, 3, 5]}.items())
    system = system_of(
        net,
        Rings(size=5e-3, friction=friction),
        mass={"rings": 0.3, "odd": 0.5},
        inertia=2.0,
        damping=Dashpot(viscosity_time=1e-2),
    )
    v = rng.standard_normal(net.nodes.shape)
    v[k] = [1.5, 0.0, 0.0]
    start = State.at(net.nodes, v)
    flight = simulate(system, start, np.linspace(0, 0.6, 4), options=TIGHT)
    last = flight[-1]
    assert last.balance.dissipated_energy > 0.05
    # 7.9 J; Simpson's rule over the steps in which the dashpot sets in with a jump
    assert energy_of(system, last) == pytest.approx(energy_of(system, flight[0]), abs=5e-5)
    size = np.abs(system.momentum(start.v)).max()
    np.testing.assert_allclose(
        system.momentum(last.v), system.momentum(start.v), rtol=0, atol=1e-13 * max(size, 1)
    )
    # the forces have no moment, to round-off, see below; BDF keeps linear invariants alone: within its tolerance
    before, after = (system.angular_momentum(s.x, s.v) for s in (start, last))
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-6)


@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize("closed", [True, False])
def test_forces_on_rings_have_no_resultant_and_no_moment(closed, friction):
    rng = default_rng(5)
    x, v = rng.standard_normal((2, 1, 31, 3))
    x[0, -1, 0] = 0.1
    force = drawcord(np.arange(31)[None], cord(L=20.0, friction=friction, tau=0.01), closed=closed)
    f = force.force(0.0, x, v)
    assert np.abs(f).max() > 10.0
    rings = f[0, :-1]
    assert np.abs(rings.sum(axis=0)).max() < 1e-12 * np.abs(rings).sum()
    assert np.abs(np.cross(x[0, :-1], rings).sum(axis=0)).max() < 1e-12 * np.abs(rings).sum()


def test_a_cord_between_two_rings_is_a_reeled_cable():
    """The ring's size apart, which is a millionth here."""
    rng = default_rng(6)
    x, v = rng.standard_normal((2, 1, 3, 3))
    x[0, 2, 0] = 0.2
    L = 0.9 * np.linalg.norm(x[0, 1] - x[0, 0]) + 0.2
    alone = cord(L=L, eps=0.05, tau=0.05, size=1e-6, friction=0.3)
    one = drawcord(np.arange(3)[None], alone, closed=False)
    single = [np.array([value]) for value in (L, -1.0, 50.0, 0.05, False, 0.05)]
    other = ElementForce(REELED, np.arange(3)[None], Reeled(*single))
    np.testing.assert_allclose(one.force(0.0, x, v), other.force(0.0, x, v), rtol=1e-9)
    for a, b in zip(one.tangent(0.0, x, v)[1:], other.tangent(0.0, x, v)[1:], strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-9 * np.abs(b).max())
    assert one.account(0.0, x, v) == pytest.approx(other.account(0.0, x, v), rel=1e-9)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_coincident_rings_give_numbers_and_touch_at_their_size(friction):
    rng = default_rng(7)
    x, v = rng.standard_normal((2, 1, 9, 3))
    x[0, 3] = x[0, 4] = x[0, 2]
    x[0, -1, 0] = 0.0
    force = drawcord(np.arange(9)[None], cord(L=5.0, size=0.01, friction=friction), closed=True)
    with np.errstate(all="raise"):
        assert np.isfinite(force.force(0.0, x, v)).all()
        K, C = force.tangent(0.0, x, v).spread(1)
    assert np.isfinite(K).all()
    assert np.isfinite(C).all()
    packed = np.zeros((1, 9, 3))
    for L, taut in ((0.081, False), (0.079, True)):  # eight rings of 1 cm
        force = drawcord(np.arange(9)[None], cord(L=L, size=0.01, friction=friction), closed=True)
        assert (force.account(0.0, packed, v).stored_energy > 0) == taut
        assert not force.force(0.0, packed, v)[0, :-1].any()


@pytest.mark.parametrize("friction", [0.1, 0.5])
def test_tensions_fall_from_ring_to_ring_by_the_capstan_rule(friction):
    """On a regular polygon wound in fast at its begin, each ring turns the cord by 2π/k: N falls by e^{−μ 2π/k}."""
    k = 12
    x = np.concatenate((polygon(k, 1.0), np.zeros((1, 3))))[None]
    v = np.zeros_like(x)
    v[0, -1, 0] = 1e6  # far over the creep speed also at the last ring
    L = 0.9 * 2 * k * np.sin(np.pi / k)
    one, both = (
        drawcord(np.arange(k + 1)[None], cord(L=L, friction=friction, theta=theta), closed=True)
        for theta in (1.0, 0.5)
    )
    # angles are smoothed by 1e-3 of them
    step = np.exp(-friction * (2 * np.pi / k - 1e-3))
    N = tensions_of(one, x, v)
    np.testing.assert_allclose(N[1:] / N[:-1], step, rtol=1e-6)
    mean = tensions_of(drawcord(np.arange(k + 1)[None], cord(L=L), closed=True), x, v)
    assert N.mean() == pytest.approx(mean[0], rel=1e-12)
    # wound in at both ends, the cord's middle stands still at the ring opposite
    N = tensions_of(both, x, v)
    np.testing.assert_allclose(N, N[::-1], rtol=1e-9)
    np.testing.assert_allclose(N[1:6] / N[:5], step, rtol=1e-6)
    assert N[5] == pytest.approx(N[6], rel=1e-9)


def test_atwoods_machine_with_a_capstan_falls_as_it_should():
    """a = g (m₂ − m₁ e^{μφ})/(m₂ + m₁ e^{μφ}) over a ring that turns the cord by φ = π."""
    m1, m2, g, friction = 1.0, 3.0, 10.0, 0.2
    places = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    ratio = np.exp(friction * (np.pi - 2e-3))  # smoothed by 1e-3 at 0 and at π
    a = g * (m2 - m1 * ratio) / (m2 + m1 * ratio)
    N = 0.5 * (m1 * (g + a) + m2 * (g - a))
    net = ringed(places, closed=False, length=2.0, extra={"light": [0], "ring": [1], "heavy": [2]}.items())
    system = system_of(
        net,
        Rings(size=1e-6, friction=friction, creep_speed=1e-3),
        material=STIFF,
        mass={"light": m1, "heavy": m2},
        damping=Dashpot(viscosity_time=1e-3),
        restraints=[Restraint("ring"), Restraint("drum", axes="x")],
        loads=[NodalLoad("light", [0, 0, -m1 * g]), NodalLoad("heavy", [0, 0, -m2 * g])],
    )
    x = net.nodes.copy()
    x[[0, 2], 2] -= N / 1e5
    v = np.zeros_like(x)
    v[0, 2], v[2, 2] = 0.2, -0.2  # it slides already
    flight = simulate(system, State.at(x, v), [0.0, 0.2, 0.4], options=TIGHT)
    for frame in (flight[1], flight[2]):
        # the strain at the start is that of the mean tension; the creep speed is 5e-3 of the slowest sliding,
        # friction 1e-5 short; segments of different tension stretch alike: 1e-4 of a second length
        assert frame.v[0, 2] == pytest.approx(0.2 + a * frame.t, rel=1e-3)
    lost = flight[-1].balance.dissipated_energy
    way = flight[-1].x[0, 2] - x[0, 2]
    tensions = m1 * (g + a), m2 * (g - a)
    assert lost == pytest.approx((tensions[1] - tensions[0]) * way, rel=2e-3)
    # and against a weight less than e^{μφ} times heavier it stays, but for the creep
    held = system_of(
        net,
        Rings(size=1e-6, friction=friction, creep_speed=1e-3),
        material=STIFF,
        mass={"light": m1, "heavy": m2},
        damping=Dashpot(viscosity_time=1e-3),
        restraints=[Restraint("ring"), Restraint("drum", axes="x")],
        loads=[NodalLoad("light", [0, 0, -m1 * g]), NodalLoad("heavy", [0, 0, -1.5 * m1 * g])],
    )
    x[[0, 2], 2] = -1.0 - 1.25 * m1 * g / 1e5
    last = simulate(held, State.at(x, np.zeros_like(x)), [0.0, 1.0], options=TIGHT)[-1]
    u = np.log(1.5) / (friction * (np.pi - 2e-3))
    assert last.v[0, 2] == pytest.approx(1e-3 * u / np.sqrt(1 - u**2), rel=1e-2)


def steps_of(friction, products, seed):
    rng = default_rng(seed)
    k = 10
    net = ringed(polygon(k, 1.0) + 0.1 * rng.standard_normal((k, 3)))
    system = system_of(
        net,
        Rings(size=1e-3, friction=friction, fastened=False),
        mass=0.1,
        material=Material(youngs_modulus=1e9, linear_density=1e-9, area=1e-6, toe_strain=1e-3),
        drum=winding(1.0),
        damping=Dashpot(viscosity_time=1e-3),
    )
    flight = simulate(
        system,
        State.at(net.nodes, np.zeros_like(net.nodes)),
        [0.0, 2.5],
        options=SolverOptions(products=products),
    )
    return flight.statistics["steps"]


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_newton_has_the_whole_tangent_of_a_cord(friction):
    """Frozen products need as many steps as the true Jacobian, by chance and over three starts.

    With a toe: a frozen matrix does not see the cord go taut, which without a toe costs a fifth more steps.
    """
    frozen, true = (
        sum(steps_of(friction, products, seed) for seed in range(3)) for products in ("frozen", "true")
    )
    assert true > 300
    assert frozen < 1.15 * true


def test_strain_tension_and_energy_of_a_cord_are_those_of_its_whole_length():
    rng = default_rng(8)
    k = 9
    places = polygon(k, 1.0) + 0.3 * rng.standard_normal((k, 3))
    net = ringed(places)
    system = system_of(net, Rings(size=1e-4), mass=0.1)
    x = net.nodes * 1.05 + 0.02 * rng.standard_normal(net.nodes.shape)
    x[k] = [0.1, 0.0, 0.0]
    ends = x[net.cables]
    h = np.hypot(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), 1e-4)
    E11 = 0.5 * ((h.sum() / (net.rest_length.sum() - 0.1)) ** 2 - 1)
    assert E11 > 0.02
    np.testing.assert_allclose(system.strain(x), E11, rtol=1e-12)
    np.testing.assert_allclose(system.tension(x), 100.0 * E11 * np.sqrt(1 + 2 * E11), rtol=1e-12)
    stored = 0.5 * 100.0 * (net.rest_length.sum() - 0.1) * E11**2
    assert system.elastic_energy(x) == pytest.approx(stored, rel=1e-12)
    assert system.account(0.0, x, np.zeros_like(x))[0] == pytest.approx(stored, rel=1e-12)


def test_a_cord_wound_in_whole_is_reported():
    net = CableNet(np.zeros((8, 3)), [[0, 1]], rest_length=[1.0])
    force = drawcord(np.array([[3, 5, 6, 7]]), cord(L=1.5), closed=True)
    system = System(net, SOFT, damping=NoDamping(), masses={"all": 1.0}, forces=[force])
    x = np.zeros((8, 3))
    x[7, 0] = 2.0
    for ask in (system.account, system.powers):
        with pytest.raises(
            RunError, match=r"at t = 2\.5 s the cord through node 3 has the rest length -0\.5 m.*node 7"
        ):
            ask(2.5, x, np.zeros_like(x))
    local = x[force.nodes]
    assert np.isfinite(force.force(2.5, local, np.zeros_like(local))).all()  # Newton's iteration may try it
    x[7, 0] = np.nan
    with pytest.raises(RunError, match=r"the cord through node 3 has the rest length nan m"):
        system.account(2.5, x, np.zeros_like(x))


@pytest.mark.parametrize("stretch", [0.3, 1.4, 6.0])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_cords_and_motors_that_share_nodes_add_up_in_a_net(seed, stretch):
    """A closed cord with friction, an open one with a toe, one of two rings: taut where stretch is above 1."""
    reported = (
        ([3, 0, 4, 1, 7], cord(9.0 / stretch, tau=1e-2, friction=0.3, theta=0.5), True),
        ([5, 2, 6, 8], cord(4.0 / stretch, eps=0.3, engineering=True), False),
        ([1, 2, 7], cord(1.5 / stretch, share=0.5, tau=1e-3), False),
    )
    cords = [drawcord(np.array([nodes]), numbers, closed=closed) for nodes, numbers, closed in reported]
    two = Motor(*np.array([[5.0, 3.0], [0.1, -0.2], [0.02, 0.3], [0.05, 0.4]]))
    one = Motor(*np.array([[2.0], [0.5], [0.1], [0.1]]))
    motors = [ElementForce(MOTOR, *each) for each in ((np.array([[7], [2]]), two), (np.array([[8]]), one))]
    rng, drums = default_rng(seed), np.arange(9) >= 7
    x, v = rng.uniform(-1, 1, (9, 3)), 0.3 * rng.standard_normal((9, 3))
    x[drums, 0] = rng.uniform(0.05, 0.2, 2)
    whole, f, sums, taut = NetForces.of([*cords, *motors], ~drums), np.zeros((9, 3)), np.zeros(3), 0
    for force in (*cords, *motors):
        local = x[force.nodes], v[force.nodes]
        np.add.at(f, force.nodes, force.force(0.0, *local))
        sums += force.account(0.0, *local)
    for force in cords:
        local = x[force.nodes], v[force.nodes]
        acts = bool(force.account(0.0, *local).stored_energy > 0)
        numbers = force.parameters
        rank = numbers.segments + 1 if numbers.friction > 0 else 2
        assert len(force.newton_part(0.0, *local).left) == acts * rank
        taut += acts
    np.testing.assert_allclose(whole.force(0.0, x, v), f, rtol=1e-15, atol=1e-13)  # in another order
    powers = whole.powers(0.0, x, v)
    assert powers[:3] == pytest.approx(sums, rel=1e-14)
    assert not powers.wrench.any()
    assert (taut > 0) == (whole.table.sums(0.0, x, v)[TENSION] > 0.0)
    assert taut == 3 if stretch > 2 else taut == 0 if stretch < 0.5 else True


@pytest.mark.parametrize(
    ("values", "reported"),
    [
        ({"size": 0.0}, "size is 0"),
        ({"friction": -0.1}, "friction is -0.1"),
        ({"creep_speed": np.nan}, "creep_speed is nan"),
    ],
)
def test_rings_out_of_range_are_reported(values, reported):
    with pytest.raises(InputError, match=reported):
        Rings(**values)
