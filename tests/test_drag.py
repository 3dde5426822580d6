"""Drag in orbit and in air, and sunlight: closed forms, means over directions, balance."""

import numpy as np
import pytest
from conftest import CORD, SOFT, line, random_net, random_velocities

from netdae.core.errors import InputError
from netdae.forces.air import AirDrag
from netdae.forces.drag import BodyDrag
from netdae.forces.free_molecular import FreeMolecularDrag
from netdae.forces.loads import Gravity
from netdae.forces.orbit import Orbit
from netdae.forces.solar import BodySolarPressure, SolarPressure, sun_over_orbit
from netdae.model.material import Cords, Material
from netdae.model.net import CableNet
from netdae.model.signals import Pulse, Table
from netdae.model.state import State
from netdae.output.metrics import DeploymentMetrics
from netdae.runs.jacobian_check import compare_jacobian
from netdae.scenario.simulation import Simulation
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping
from netdae.system.system import System

RHO, CD, D = 2e-13, 2.2, 1e-3  # air at 600 km, kg/m³; thickness of CORD, m
V = 7558.0  # m/s at 600 km
STREAM = np.array([0.0, -V, 0.0])
P, CR = 4.54e-6, 1.3
LOADS = {
    "molecular": FreeMolecularDrag(RHO, STREAM, CD),
    "air": AirDrag(wind=[0.5, -3.0, 1.0]),
    "light": SolarPressure([0.5, -3.0, 1.0], P, CR),
}


def cable(d, rest_length=1.0):
    return CableNet([[0.0, 0.0, 0.0], d], [[0, 1]], {"ends": [0, 1]}, rest_length=[rest_length])


def push(load, d, *, rest_length=1.0, v=(0.0, 0.0, 0.0)):
    """Sum of a load (3,) on one cable whose ends are d (3,) apart and move at v."""
    x = np.array([[np.zeros(3), d]])
    net = cable([rest_length, 0.0, 0.0], rest_length)
    force = load.on(net, Cords.of(net, CORD), np.ones(2))
    return force.force(0.0, x, np.broadcast_to(np.asarray(v, dtype=float), x.shape)).sum(axis=(0, 1))


@pytest.mark.parametrize("angle_deg", [0.0, 20.0, 60.0, 90.0])
def test_molecular_drag_is_the_momentum_of_the_beam_on_the_projected_area(angle_deg):
    """½ ρ C_D V² D l sin θ along the stream, also on a cord that stands oblique in it."""
    angle = np.deg2rad(angle_deg)
    d = [0.0, np.cos(angle), np.sin(angle)]
    expected = 0.5 * RHO * CD * V**2 * D * np.sin(angle) * np.array([0.0, -1.0, 0.0])
    np.testing.assert_allclose(push(LOADS["molecular"], d), expected, rtol=1e-12, atol=1e-25)


@pytest.mark.parametrize("angle_deg", [0.0, 20.0, 60.0, 90.0])
def test_air_drag_follows_the_cross_flow_principle(angle_deg):
    """½ ρ D l (C_n sin² θ across the cord, π C_t cos² θ along it) times w²."""
    angle, w = np.deg2rad(angle_deg), 3.0
    along, across = (
        np.array([np.cos(angle), np.sin(angle), 0.0]),
        np.array([-np.sin(angle), np.cos(angle), 0.0]),
    )
    load = AirDrag(1.2, 1.1, 0.02, wind=[w, 0.0, 0.0])
    normal, tangential = 1.1 * np.sin(angle) ** 2, np.pi * 0.02 * np.cos(angle) ** 2
    expected = 0.5 * 1.2 * w**2 * D * (tangential * along - normal * across)
    np.testing.assert_allclose(push(load, along), expected, rtol=1e-12, atol=1e-18)


@pytest.mark.parametrize("angle_deg", [0.0, 20.0, 60.0, 90.0])
def test_sunlight_pushes_the_projected_area_away_from_the_sun(angle_deg):
    angle = np.deg2rad(angle_deg)
    load = SolarPressure([0.0, 0.0, 250.0], P, CR)  # of any length
    expected = P * CR * D * np.sin(angle) * np.array([0.0, 0.0, -1.0])
    np.testing.assert_allclose(
        push(load, [np.sin(angle), 0.0, np.cos(angle)]), expected, rtol=1e-12, atol=1e-22
    )


@pytest.mark.parametrize("name", LOADS)
def test_a_cable_whose_ends_meet_shows_the_mean_of_all_directions(name):
    """A cord in loops: the mean over the sphere of straight cords, by quadrature."""
    s, weight = np.polynomial.legendre.leggauss(400)
    mean = np.zeros(3)
    for cos, share in zip(s, weight / 2, strict=True):
        for phi in np.arange(8) * np.pi / 4:
            # about the axis of the stream, for which the integrand is smooth but at its poles
            axis = (
                np.array([0.5, -3.0, 1.0]) / np.linalg.norm([0.5, -3.0, 1.0])
                if name != "molecular"
                else STREAM / V
            )
            one = np.cross(axis, [1.0, 0.0, 0.0])
            one /= np.linalg.norm(one)
            sin = np.sqrt(1 - cos**2)
            d = cos * axis + sin * (np.cos(phi) * one + np.sin(phi) * np.cross(axis, one))
            mean += share / 8 * push(LOADS[name], d)
    # of |cos³| and of the root at the poles, 400 points miss 1e-6
    np.testing.assert_allclose(
        push(LOADS[name], np.zeros(3)), mean, rtol=1e-5, atol=1e-5 * np.abs(mean).max()
    )


@pytest.mark.parametrize("name", LOADS)
def test_a_cord_that_goes_slack_keeps_its_drag_at_first(name):
    """The force is continuous where the rest length is reached, from both sides."""
    n = np.array([0.6, 0.0, 0.8])
    slack, taut = (push(LOADS[name], (1 + e) * n) for e in (-1e-9, 1e-9))
    np.testing.assert_allclose(slack, taut, rtol=1e-8)


@pytest.mark.parametrize("name", LOADS)
def test_coincident_ends_and_still_air_give_no_nan(name):
    net = cable([1.0, 0.0, 0.0])
    force = LOADS[name].on(net, Cords.of(net, CORD), np.ones(2))
    still = STREAM if name == "molecular" else np.array([0.5, -3.0, 1.0])
    for d in (np.zeros(3), still / np.linalg.norm(still), np.array([0.0, 0.0, 1.0])):
        for v in (np.zeros(3), still):
            x, u = np.array([[np.zeros(3), d]]), np.broadcast_to(v, (1, 2, 3))
            with np.errstate(all="raise"):
                f, (_, K, C) = force.force(0.0, x, u), force.tangent(0.0, x, u)
            assert np.isfinite([*f.ravel(), *K.ravel(), *C.ravel()]).all()
            if name != "light" and (v == still).all():
                assert not f.any()
                assert not C.any()


@pytest.mark.parametrize("name", ["molecular", "air"])
def test_drag_never_drives_a_net_against_the_air(name):
    """(v − wind)·f ≤ 0 node by node, whatever the cables do."""
    net = random_net(2)
    load = {"molecular": FreeMolecularDrag(1.0, [0, 0, 0]), "air": AirDrag(tangential_coefficient=0.3)}[name]
    force = load.on(net, Cords.of(net, CORD), np.ones(net.node_count))
    for seed in range(5):
        v = random_velocities(net, seed)[force.nodes]
        assert (np.einsum("eka,eka->ek", force.force(0.0, net.nodes[force.nodes], v), v) < 0).all()


def test_a_cable_that_spins_about_its_middle_is_braked():
    """Each half meets its own wind: ½ ρ C_n D (L/2) (ΩL/2)² on either end."""
    net = cable([1.0, 0.0, 0.0])
    force = AirDrag(1.2, 1.1, 0.0).on(net, Cords.of(net, CORD), np.ones(2))
    f = force.force(0.0, net.nodes[None], np.array([[[0.0, -2.0, 0.0], [0.0, 2.0, 0.0]]]))
    np.testing.assert_allclose(f[0, 1], [0.0, -0.25 * 1.2 * 1.1 * D * 2.0**2, 0.0], rtol=1e-12)
    np.testing.assert_array_equal(f[0, 0], -f[0, 1])


G = 9.81


@pytest.mark.parametrize("body", ["cord across", "cord along", "spheres"])
@pytest.mark.parametrize("method", ["ida", "dop853"])
def test_what_falls_in_air_follows_the_hyperbolic_tangent_to_its_terminal_velocity(body, method):
    """v = u tanh(g t/u), u = √(2 m g/(ρ C_D A)), and z = −u²/g ln cosh(g t/u)."""
    rho, Cn, Ct = 1.2, 1.1, 0.015
    net = cable([0.0, 0.0, 1.0] if body == "cord along" else [1.0, 0.0, 0.0])
    mass = net.rest_length[0] * 1390.0 * np.pi / 4 * D**2
    if body == "spheres":
        drag, c, mass = BodyDrag("ends", 4e-4, rho, 0.47), 0.5 * rho * 0.47 * 2 * 4e-4, mass + 2 * 0.01
    else:
        drag, c = AirDrag(rho, Cn, Ct), 0.5 * rho * D * (Cn if body == "cord across" else np.pi * Ct)
    masses = {"ends": 0.01} if body == "spheres" else {}
    system = System(net, CORD, damping=NoDamping(), masses=masses, loads=[Gravity([0, 0, -G]), drag])
    u = np.sqrt(mass * G / c)
    times = np.linspace(0.0, 3 * u / G, 5)
    # the steps of dop853 are so long that Simpson's rule for the balance asks for shorter ones
    tight = {"rtol": 1e-7, "atol_position": 1e-6, "atol_velocity": 1e-6, "max_step": 0.1 * u / G}
    flight = simulate(system, State.at(net.nodes), times, options=SolverOptions(method=method, **tight))
    # 1e-7 of u, or of the way of 3 u²/g, in each step; a slack of the tolerance, 1e-6 m, shows 14 times as much
    # to the air as the same length of cord along the stream
    share = 1e-4 if body == "cord along" else 1e-5
    for state in flight:
        np.testing.assert_allclose(state.v[:, 2], -u * np.tanh(G * state.t / u), rtol=0, atol=share * u)
        fallen = u**2 / G * np.log(np.cosh(G * state.t / u))
        np.testing.assert_allclose(
            state.x[:, 2] - net.nodes[:, 2], -fallen, rtol=0, atol=share * 3 * u**2 / G
        )
    assert flight[-1].v[0, 2] == pytest.approx(-u, rel=0.01)
    impulse = system.momentum(flight[-1].v)
    np.testing.assert_allclose(flight[-1].balance.external_impulse, impulse, rtol=1e-5, atol=1e-9)
    energy = system.kinetic_energy(flight[-1].v)
    # the works of weight and of drag nearly cancel: each is six times what is left
    assert flight[-1].balance.external_work == pytest.approx(energy, rel=1e-4)
    assert flight[-1].balance.dissipated_energy == 0.0


def test_a_gust_takes_a_cord_along_from_its_first_instant_on():
    """1/(w − v) = 1/w + (c/m) (t − t₀): the wind sets in between two steps, and its work is external."""
    w, begin = 20.0, 0.0123
    net = cable([1.0, 0.0, 0.0])
    gust = Pulse([0.0, w, 0.0], begin, np.inf)
    system = System(net, CORD, damping=NoDamping(), loads=[AirDrag(1.2, 1.1, wind=gust)])
    options = SolverOptions(rtol=1e-7, atol_position=1e-7, atol_velocity=1e-7)
    flight = simulate(system, State.at(net.nodes), [0.0, 0.5], options=options)
    c = 0.5 * 1.2 * 1.1 * D
    v = w - 1 / (1 / w + c / system.mass.sum() * (0.5 - begin))
    np.testing.assert_allclose(flight[-1].v, [[0.0, v, 0.0]] * 2, rtol=0, atol=1e-5 * v)
    assert flight.statistics["starts"] == 2
    assert flight[-1].balance.external_work == pytest.approx(0.5 * system.mass.sum() * v**2, rel=1e-5)


def test_a_table_of_wind_that_does_not_cover_the_flight_is_refused():
    net = cable([1.0, 0.0, 0.0])
    wind = Table([0.0, 0.1], [[0, 1, 0], [0, 2, 0]])
    for load in (AirDrag(wind=wind), FreeMolecularDrag(RHO, wind), SolarPressure(wind, P)):
        system = System(net, CORD, damping=NoDamping(), loads=[load])
        with pytest.raises(InputError, match=r"from 0 to 0\.1 s.*from 0 to 1 s"):
            simulate(system, State.at(net.nodes), [0.0, 1.0])


STRONG = {
    "molecular": FreeMolecularDrag(1e-6, STREAM, CD),
    "air": AirDrag(tangential_coefficient=0.3, wind=[5.0, -30.0, 10.0]),
    "light": SolarPressure([0.5, -3.0, 1.0], 100.0, CR),
    "bodies": BodyDrag("few", 1e-2, 1.2, 0.5, wind=[10.0, 20.0, 30.0]),
}
"""Loads beside which the cables of a small soft net are not all."""


@pytest.mark.parametrize("name", STRONG)
def test_the_energy_books_of_a_net_in_a_stream_close_with_the_tolerance(name):
    net = random_net(1)
    system = System(net, SOFT, damping=Dashpot(viscosity_time=1e-4), loads=[STRONG[name]])
    start = State.at(net.nodes, random_velocities(net))
    missing = []
    for rtol in (1e-3, 1e-5, 1e-7):
        options = SolverOptions(rtol=rtol, atol_position=0.1 * rtol, atol_velocity=10 * rtol)
        flight = simulate(system, start, [0.0, 0.1], options=options)
        energy = [system.kinetic_energy(f.v) + system.elastic_energy(f.x) for f in flight]
        balance = flight[-1].balance
        assert abs(balance.external_work) > 0.01 * energy[0]
        missing.append(
            abs(energy[1] - energy[0] + balance.dissipated_energy - balance.external_work) / energy[0]
        )
        impulse = system.momentum(flight[-1].v) - system.momentum(start.v)
        # m v to the tolerance of v, in steps that err to both sides
        np.testing.assert_allclose(
            balance.external_impulse, impulse, rtol=10 * rtol, atol=10 * rtol * system.mass.sum()
        )
    assert missing[2] < 1e-4
    assert missing[2] < missing[1] < missing[0]


@pytest.mark.parametrize("name", STRONG)
def test_what_the_newton_matrix_leaves_out_changes_no_flight(name):
    """Against the true product J v, which has all tangents."""
    net = random_net(1)
    system = System(net, SOFT, damping=Dashpot(viscosity_time=1e-4), loads=[STRONG[name], Orbit(1.0)])
    start = State.at(net.nodes, random_velocities(net))
    tight = {"rtol": 1e-7, "atol_position": 1e-8, "atol_velocity": 1e-6}
    frozen, true = (
        simulate(system, start, [0.0, 0.05], options=SolverOptions(products=products, **tight))
        for products in ("frozen", "true")
    )
    # 1e-6 m/s a step, of some hundred, in a net that snaps
    np.testing.assert_allclose(frozen[-1].v, true[-1].v, rtol=0, atol=1e-3)
    assert frozen.statistics["newton_failures"] <= 0.05 * frozen.statistics["steps"]


def bullets_in_orbit(*loads):
    """A bullet of 0.5 kg at the frame's origin, and one that is pushed by nothing."""
    net = CableNet([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]], [[0, 1]], {"pushed": [0]}, rest_length=[1e4])
    light = Material(youngs_modulus=70e9, linear_density=1e-9, diameter=D)
    system = System(net, light, damping=NoDamping(), masses={"all": 0.5}, loads=loads)
    return system, State.at(net.nodes)


def test_drag_takes_the_speed_of_a_free_mass_in_orbit():
    """For short times Δv = −½ ρ V² C_D A t/m along the track; then lower, faster and ahead by closed form.

    With a constant a along y: x = 2a/n (t − sin(nt)/n), y = a (4/n² (1 − cos nt) − 3/2 t²).
    """
    rho, A, n = 1e-10, 1e-2, 1.083e-3
    system, start = bullets_in_orbit(Orbit(n), BodyDrag("pushed", A, rho, CD, wind=STREAM))
    a = -0.5 * rho * V**2 * CD * A / system.mass[0]
    times = [0.0, 10.0, 3000.0]
    options = SolverOptions(rtol=1e-8, atol_position=1e-6, atol_velocity=1e-9)
    flight = simulate(system, start, times, options=options)
    # n t = 0.01, of which the square is the tide's share; v/V changes the drag by 2e-8
    assert flight[1].v[0, 1] == pytest.approx(a * 10.0, rel=3e-4)
    t = times[2]
    x, y = 2 * a / n * (t - np.sin(n * t) / n), a * (4 / n**2 * (1 - np.cos(n * t)) - 1.5 * t**2)
    # at 3000 s v is 0.7 m/s: drag is changed by 2 v/V = 2e-4
    np.testing.assert_allclose(flight[2].x[0], [x, y, 0.0], rtol=5e-4, atol=1e-6)
    assert x < 0 < y


def test_a_body_in_sunlight_gets_its_momentum_and_none_in_shadow():
    lit = Pulse([3.0, 0.0, 4.0], 5.0, 17.0)
    system, start = bullets_in_orbit(BodySolarPressure("pushed", 0.1, lit, P, CR))
    flight = simulate(system, start, [0.0, 20.0])
    expected = P * CR * 0.1 * 12.0 * np.array([-0.6, 0.0, -0.8])
    np.testing.assert_allclose(system.mass[0] * flight[-1].v[0], expected, rtol=1e-9, atol=1e-18)
    np.testing.assert_allclose(flight[-1].balance.external_impulse, expected, rtol=1e-9, atol=1e-18)
    assert flight.statistics["starts"] == 3


def test_cables_are_lit_between_the_shadows_alone():
    system, start = bullets_in_orbit(SolarPressure(Pulse([0.0, 1.0, 0.0], 5.0, 17.0), P, CR))
    flight = simulate(system, start, [0.0, 20.0])
    length = 1.0 + np.pi / 4 * (1e4 - 1.0)
    assert system.momentum(flight[-1].v)[1] == pytest.approx(-P * CR * D * length * 12.0, rel=1e-6)


def test_the_sun_stands_still_beside_the_orbit_whose_frame_turns():
    n, t, sun = 1.083e-3, 1234.0, np.array([0.3, -0.5, 0.8])
    c, s = np.cos(n * t), np.sin(n * t)
    frame = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])  # its axes as columns, x and y at 0 s
    np.testing.assert_allclose(frame @ sun_over_orbit(sun, n)(t), sun, rtol=1e-12)
    np.testing.assert_allclose(sun_over_orbit(sun, n, since=t)(t), sun, rtol=1e-12)


def test_thickness_is_that_of_the_cross_section_or_as_reported():
    broad = FreeMolecularDrag(RHO, STREAM, diameter=3e-3)
    d = [0.0, 0.0, 1.0]
    np.testing.assert_allclose(push(broad, d), 3 * push(LOADS["molecular"], d), rtol=1e-12)


def test_drag_acts_on_the_cables_of_its_group_alone():
    net = line(4)
    net = CableNet(net.nodes, net.cables, cable_groups={"few": [1, 3]})
    cords = Cords.of(net, CORD)
    for load in (
        FreeMolecularDrag(RHO, STREAM, cables="few"),
        AirDrag(cables="few"),
        SolarPressure([1, 0, 0], P, cables="few"),
    ):
        np.testing.assert_array_equal(load.on(net, cords, np.ones(5)).nodes, [[1, 2], [3, 4]])
    with pytest.raises(InputError, match=r"no cable group 'many'.*few"):
        AirDrag(cables="many").on(net, cords, np.ones(5))


def test_bodies_without_mass_feel_nothing():
    net = line(4)
    mass = np.array([1.0, 0.0, 1.0, 0.0, 1.0])
    for load in (BodyDrag("inner", 1e-3, 1.0, 0.5), BodySolarPressure("inner", 1e-3, [1, 0, 0], P)):
        np.testing.assert_array_equal(load.on(net, Cords.of(net, CORD), mass).nodes, [[2]])


def test_the_jacobian_with_all_these_loads_is_that_of_the_differences():
    """Also where the flight starts: all cables at their rest length, some along the stream."""
    net = CableNet.square(side=1.0, cells=3)
    loads = [
        Orbit(0.1),
        FreeMolecularDrag(1e-9, STREAM),
        AirDrag(wind=[3.0, 0.0, 0.0]),
        SolarPressure([0.0, 1.0, 0.0], 1.0),
        BodyDrag("corners", 1e-2, 1.2, 0.5),
    ]
    system = System(net, SOFT, damping=Dashpot(viscosity_time=1e-5), loads=loads)
    start = State.at(net.nodes, np.broadcast_to([0.0, 0.0, 2.0], net.nodes.shape))
    times = np.linspace(0.0, 1.0, 2)
    simulation = Simulation(
        "", system, start, times, SolverOptions(), DeploymentMetrics(mouth=None, corners=None)
    )
    for comparison in compare_jacobian(simulation):
        assert comparison.agrees, comparison


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: FreeMolecularDrag(0.0, STREAM), r"density is 0: .* above zero"),
        (lambda: FreeMolecularDrag(RHO, STREAM, diameter=-1.0), r"diameter is -1: "),
        (lambda: AirDrag(density=np.nan), r"density is nan"),
        (lambda: AirDrag(tangential_coefficient=-0.1), r"tangential_coefficient is -0\.1: .* zero or more"),
        (lambda: BodyDrag("corners", 0.0, 1.0, 0.5), r"drag of 'corners': area is 0"),
        (lambda: SolarPressure([1, 0, 0], -P), r"pressure is -4\.54e-06"),
        (lambda: push(SolarPressure([0, 0, 0], P), [1, 0, 0]), r"sun is \[0, 0, 0\]: give the direction"),
    ],
)
def test_values_that_cannot_be_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
