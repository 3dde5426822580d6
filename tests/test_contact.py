"""Contact with rigid bodies against closed forms: rebound, strike, creep, capstan; and what a capture keeps.

A cord that ends at a knot touches with its end where that is deeper than ε = 1 mm: balls here are stiffer than that.
"""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import netdae as nd

LIGHT = nd.Material(youngs_modulus=1e6, density=1e-6, diameter=1e-3)
TOUCH = 5e-4  # m, radius of that cord
TIGHT = {"rtol": 1e-8, "atol_position": 1e-9, "atol_velocity": 1e-8}
FINE = {"explicit": {"max_step": 2e-7}, "ida": TIGHT, "dop853": TIGHT}


def ball(x, v, *, mass=1.0, **more):
    """A ball on a long slack cord without mass, and its start."""
    net = nd.CableNet(
        np.array([x, [30.0, 0.0, 30.0]]), np.array([[0, 1]]), {"ball": [0]}, rest_length=np.array([90.0])
    )
    held = [nd.Restraint((1,))]
    system = nd.System(net, LIGHT, masses={"ball": mass}, damping=nd.NoDamping(), restraints=held, **more)
    return system, nd.State.at(net.nodes, [v, np.zeros(3)])


@pytest.mark.parametrize("method", FINE)
def test_a_ball_rebounds_as_hunt_and_crossley_say(method):
    """With a = 1.5 λ: −a v′ − ln(1 − a v′) = a v − ln(1 + a v), and δⁿ⁺¹ = (n+1) m/(k a²) (a v − ln(1 + a v))."""
    n, k, lam, v = 1.5, 1e8, 0.2, 1.0
    a = 1.5 * lam
    came = a * v - np.log(1 + a * v)
    left = brentq(lambda w: -a * w - np.log(1 - a * w) - came, 0.1, v)
    deepest = ((n + 1) / (k * a**2) * came) ** (1 / (n + 1))
    floor = nd.Obstacle(nd.Part(nd.Plane()), nd.Contact(k, n, lam, 0.0))
    system, start = ball([0.0, 0.0, TOUCH], [0.0, 0.0, -v], obstacles=[floor])
    flight = nd.simulate(
        system, start, np.linspace(0, 4e-3, 2001), options=nd.SolverOptions(method, **FINE[method])
    )
    end = flight[-1]
    assert left == pytest.approx(0.83287, abs=1e-5)
    assert end.v[0, 2] == pytest.approx(left, abs=1e-5)
    assert TOUCH - flight.positions[:, 0, 2].min() == pytest.approx(deepest, rel=1e-3)
    # what the floor gave, and what was lost; of SciPy's methods it is summed over their long steps
    near = 2e-4 if method == "dop853" else 2e-5
    assert end.balance.external_impulse[2] == pytest.approx(1.0 + left, abs=near)
    assert end.balance.dissipated_energy == pytest.approx(0.5 * (1 - left**2), abs=near)


@pytest.mark.parametrize("method", ["explicit", "ida"])
def test_an_off_centre_strike_turns_a_free_body(method):
    """J = (1 + e) v m_eff with 1/m_eff = 1/m + 1/M + (r × n)·I⁻¹(r × n), without friction."""
    half, side, mass, v = 0.5, 0.3, 20.0, 1.0
    inertia = np.array([3.0, 4.0, 5.0])
    target = nd.Target(
        (nd.Part(nd.Box([2 * half] * 3)),),
        nd.RigidBody(mass, inertia),
        contact=nd.Contact(1e7, dissipation=0.0, friction=0.0),
    )
    system, start = ball([side, -0.1, half + TOUCH], [0.0, 0.0, -v], target=target)
    flight = nd.simulate(
        system, start, np.linspace(0, 3e-3, 5), options=nd.SolverOptions(method, **FINE[method])
    )
    arm = np.cross([side, -0.1, half], [0, 0, 1.0])
    J = 2.0 * v / (1.0 + 1.0 / mass + arm @ (arm / inertia))
    end, body = flight[-1], system.body
    assert end.v[0, 2] == pytest.approx(J - v, rel=1e-3)
    assert end.v[body.place, 2] == pytest.approx(-J / mass, rel=1e-3)
    spin = end.v[body.spin] / np.sqrt(inertia / mass)
    np.testing.assert_allclose(spin, -J * arm / inertia, rtol=0, atol=1e-3 * np.abs(J * arm / inertia).max())
    system.take(end)
    moment = [system.angular_momentum(state.x, state.v) for state in (system.whole(start), end)]
    np.testing.assert_allclose(moment[1], moment[0], rtol=0, atol=1e-9)


@pytest.mark.parametrize("method", ["explicit", "ida"])
@pytest.mark.parametrize("share", [0.5, 0.9])
def test_a_ball_creeps_on_an_incline_below_the_angle_of_friction(method, share):
    """v = v_s t/√(μ² − t²) with t = tan α = share · μ."""
    mu, slow, g = 0.3, 0.01, 9.81
    t = share * mu
    down = np.array([np.sin(np.arctan(t)), 0.0, -np.cos(np.arctan(t))])
    floor = nd.Obstacle(nd.Part(nd.Plane()), nd.Contact(1e6, friction=mu, slip_speed=slow))
    system, start = ball(
        [0.0, 0.0, TOUCH - 9.6e-6], [0.0, 0.0, 0.0], obstacles=[floor], loads=[nd.Gravity(g * down)]
    )
    options = {"explicit": {}, "ida": {"accuracy": "accurate"}}[method]
    flight = nd.simulate(system, start, np.linspace(0, 1.0, 3), options=nd.SolverOptions(method, **options))
    assert flight[-1].v[0, 0] == pytest.approx(slow * t / np.sqrt(mu**2 - t**2), rel=1e-3)


@pytest.mark.parametrize(("method", "of_angular"), [("explicit", 1e-11), ("ida", 3e-4)])
def test_a_capture_keeps_momentum_and_closes_its_energy(method, of_angular):
    """A small net thrown at a free box that tumbles."""
    net = nd.CableNet.square(side=2.5, cells=5)
    cord = nd.Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)
    part = nd.Part(nd.Box([0.8, 1.0, 1.2], rounding=0.02), attitude=(0.9, 0.1, 0.3, -0.2))
    target = nd.Target(
        (part,), nd.RigidBody.of_parts([part], mass=50.0), position=(0, 0, 1.0), spin=(0.2, -0.3, 0.5)
    )
    system = nd.System(
        net, cord, masses={"corners": 0.3}, damping=nd.Dashpot(viscosity_time=1e-5), target=target
    )
    v = np.zeros_like(net.nodes)
    corners = net.nodes_of("corners")
    v[corners] = [0.0, 0.0, 2.5] + 0.4 * net.nodes[corners]
    seen = []
    watch = Watch(system, seen)
    flight = nd.simulate(
        system,
        nd.State.at(0.9 * net.nodes, v),
        np.linspace(0.0, 0.8, 41),
        observers=[watch],
        options=nd.SolverOptions(method),
    )
    p, L, energy = (np.array(each) for each in zip(*seen, strict=True))
    thrown = system.momentum(flight[0].v)[2]
    assert flight[-1].v[system.body.place, 2] > 0.01  # it was hit
    assert np.abs(p - p[0]).max() < 1e-12 * thrown
    assert np.abs(L - L[0]).max() < of_angular * np.linalg.norm(L[0])
    kinetic = system.kinetic_energy(flight[0].v)
    assert np.abs(energy - energy[0]).max() < 0.01 * kinetic
    assert deepest(system, flight) < 1e-3


class Watch:
    """Momentum, angular momentum, and energy with what was lost, at each step."""

    def __init__(self, system, seen):
        self._system, self._seen = system, seen

    def watch(self, state):
        s, b = self._system, state.balance
        energy = s.kinetic_energy(state.v) + s.elastic_energy(state.x) + b.dissipated_energy
        self._seen.append(
            (s.momentum(state.v), s.angular_momentum(state.x, state.v), energy - b.external_work)
        )

    def __call__(self, state):
        """Nothing at frames."""


def deepest(system, flight):
    """Depth of the box in the whole cables at the frames, m, by brute force at 21 points of each."""
    part, body, cables = system.body.target.principal_parts[0], system.body, system.net.cables
    most = 0.0
    for state in flight:
        turn = Rotation.from_quat(state.attitude, scalar_first=True).inv()
        for s in np.linspace(0, 1, 21):
            p = (1 - s) * state.x[cables[:, 0]] + s * state.x[cables[:, 1]] - state.x[body.place]
            q = (turn.apply(p) - part.position) @ part.axes
            core = part.shape.core()
            beyond = np.maximum(np.abs(q) - core.numbers, 0.0)
            inside = np.minimum((np.abs(q) - core.numbers).max(axis=1), 0.0)
            most = max(most, float((core.offset + TOUCH - np.linalg.norm(beyond, axis=1) - inside).max()))
    return most


def test_a_capture_resumes_bit_for_bit():
    net = nd.CableNet.square(side=1.0, cells=3)
    cord = nd.Material(youngs_modulus=1e9, density=1390.0, diameter=1e-3)
    part = nd.Part(nd.Box([0.4, 0.3, 0.2]))
    target = nd.Target((part,), nd.RigidBody.of_parts([part], mass=2.0), spin=(0.5, 1.0, -0.4))
    system = nd.System(net, cord, masses={"corners": 0.05}, damping=nd.NoDamping(), target=target)
    start = nd.State.at(net.nodes + np.array([0, 0, 0.3]), np.full_like(net.nodes, [0.0, 0.1, -1.0]))
    times, options = np.linspace(0.0, 0.5, 6), nd.SolverOptions("explicit")
    run = nd.integrate(system, start, times, options=options)
    for _ in range(4):
        next(run)
    memory = {name: np.array(value) for name, value in run.memory().items()}
    rest = list(run)
    again = list(nd.integrate(system, start, times, options=options, resume=memory))
    assert np.abs(rest[-1].v[system.body.place]).max() > 1e-3
    for one, other in zip(rest, again, strict=True):
        for name in ("x", "v", "a", "attitude"):
            assert np.array_equal(getattr(one, name), getattr(other, name)), name


def test_a_cord_around_a_cylinder_holds_as_a_capstan():
    """Over half a turn the tensions of a cord that slides are as e^(μπ); 16 cables."""
    mu, radius, pieces = 0.3, 0.5, 16
    angle = np.linspace(0.0, np.pi, pieces + 1)
    r = (radius + TOUCH) / np.cos(0.5 * np.pi / pieces)  # the middles of its cables touch
    arc = r * np.column_stack((np.cos(angle), np.sin(angle), 0.0 * angle))
    tail = np.linspace(0.0, 1.0, 5)[1:, None] * [0.0, -1.0, 0.0]
    nodes = np.concatenate((arc[:1] + tail[::-1], arc, arc[-1:] + tail))
    cables = np.column_stack((np.arange(len(nodes) - 1), np.arange(1, len(nodes))))
    net = nd.CableNet(nodes, cables, {"first": [0], "last": [len(nodes) - 1]})
    drum = nd.Part(nd.Cylinder(radius, 1.0))
    slow = 1e-4
    floor = nd.Obstacle(drum, nd.Contact(1e7, friction=mu, dissipation=1.0, slip_speed=slow))
    cord = nd.Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)
    pulled, held = 100.0, 100.0 / np.exp(mu * np.pi)
    # pulled at 200 slip speeds, against a constant force
    system = nd.System(
        net,
        cord,
        masses={"all": 0.01},
        damping=nd.Dashpot(viscosity_time=1e-4),
        obstacles=[floor],
        restraints=[nd.Restraint("last", motion=nd.Steady((0.0, -200 * slow, 0.0)))],
        loads=[nd.NodalLoad("first", (0.0, -held, 0.0))],
    )
    v = np.zeros_like(nodes)
    v[-1, 1] = -200 * slow
    flight = nd.simulate(
        system, nd.State.at(nodes, v), np.linspace(0.0, 0.8, 201), options=nd.SolverOptions("ida")
    )
    tension = np.array([system.tension(x) for x in flight.positions[150:]]).mean(axis=0)
    assert tension[0] == pytest.approx(held, rel=0.02)
    assert tension[-1] / tension[0] == pytest.approx(np.exp(mu * np.pi), rel=0.02)
    assert pulled == pytest.approx(held * np.exp(mu * np.pi))


@pytest.mark.parametrize("method", ["explicit", "ida"])
def test_a_net_that_falls_as_a_whole_meets_the_floor(method):
    """No two of its knots move relative to each other before; on an elastic floor without friction it rebounds."""
    net = nd.CableNet.square(side=1.0, cells=4)
    cord = nd.Material(youngs_modulus=1e9, density=1000.0, diameter=1e-3)
    floor = nd.Obstacle(nd.Part(nd.Plane()), nd.Contact(1e4, dissipation=0.0, friction=0.0))
    system = nd.System(net, cord, damping=nd.NoDamping(), masses={"all": 0.01}, obstacles=[floor])
    start = nd.State.at(0.9 * net.nodes + [0.0, 0.0, 0.1], np.tile([0.0, 0.0, -2.0], (25, 1)))
    options = nd.SolverOptions(method, accuracy="accurate", max_step=1e-4)
    last = nd.simulate(system, start, [0.0, 0.1], options=options)[-1]
    assert (
        last.x[:25, 2] > 0.05
    ).all()  # all of it has turned round: unhindered it would be 0.1 m below the floor
    # knots and cords do not turn round at once, so that the net swings a little; a share of (ω h)² of the energy is the
    # integrator's, with 1e4 N/m on 10 g 1e3/s, in steps of 0.1 ms or less
    energy = system.kinetic_energy(last.v) + system.elastic_energy(last.x)
    assert energy == pytest.approx(system.kinetic_energy(start.v), rel=1e-2)
