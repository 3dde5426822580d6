"""The ranking of forces: each order of magnitude against another way to it, and what it says of a system."""

import math
from pathlib import Path

import numpy as np
import pytest
from conftest import SOFT, line, reference_flight
from numpy.random import default_rng
from scipy.integrate import solve_ivp

from netdae.core.errors import InputError
from netdae.forces import earth
from netdae.forces.air import AirDrag
from netdae.forces.drag import BodyDrag
from netdae.forces.free_molecular import FreeMolecularDrag
from netdae.forces.loads import Gravity, NodalLoad
from netdae.forces.orbit import Orbit
from netdae.forces.solar import BodySolarPressure, SolarPressure
from netdae.model.motions import FunctionMotion
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.signals import Pulse
from netdae.model.state import State
from netdae.scenario.reader import read_scenario
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping
from netdae.system.ranking import SIGNIFICANT, included_in, orbit_altitude, ranking_of
from netdae.system.scales import Fall, scales_of
from netdae.system.system import System

ALTITUDE = 600e3
A, N, V = earth.radius_of(ALTITUDE), earth.mean_motion(ALTITUDE), earth.circular_speed(ALTITUDE)
EXPLICIT = SolverOptions(method="explicit")
LOADS = {
    "orbit": Orbit(N),
    "drag": FreeMolecularDrag(density=1e-12, stream=[0, -7500.0, 0], drag_coefficient=2.0),
    "sunlight": SolarPressure(sun=[0, 0, 3.0], pressure=4e-6, coefficient=1.0),
    "air": AirDrag(density=1.0, normal_coefficient=1.0, wind=[3.0, 0, 0]),
    "gravity": Gravity([0, 0, -9.81]),
}
BODIES = {
    "drag": BodyDrag("corners", 2e-3, 1e-11, 2.2, wind=[0, -7750.0, 0]),
    "sunlight": BodySolarPressure("corners", 2e-3, [0, 0, 3.0], 4e-6, 1.2),
    "air": BodyDrag("corners", 1e-3, 1.2, 0.47, wind=[0, 5.0, 0]),
}
SCRIPTS = Path(__file__).parent.parent / "scripts"


def forces_of(ranking):
    return {force.name: force for force in ranking.forces}


def ranked(altitude=ALTITUDE, flight_time=1.6, **figures):
    system, start = reference_flight(20, seed=None)
    return ranking_of(system, start, flight_time=flight_time, altitude=altitude, **figures)


def square_with(*loads, restraints=(), side=2.0, velocity=(0.0, 0.0, 0.0)):
    net = CableNet.square(side=side, cells=4)
    system = System(net, SOFT, damping=NoDamping(), loads=loads, restraints=restraints)
    return system, State.at(net.nodes, np.broadcast_to(velocity, net.nodes.shape))


def differences(field, r, h=100.0):
    """Gradient (3, 3) of a field at r by central differences."""
    return np.array([(field(r + h * e) - field(r - h * e)) / (2 * h) for e in np.eye(3)]).T


# Scales


def test_scales_of_the_reference_net_are_those_by_hand():
    s = ranked().scales
    cords = 2 * 20 * 21 * 0.25  # m
    density = 1390 * math.pi / 4 * 1e-6
    assert s.cord_mass == pytest.approx(cords * density)
    assert s.mass == pytest.approx(cords * density + 4 * 0.5)
    assert s.size == pytest.approx(5 * math.sqrt(2))
    assert s.area == pytest.approx(cords * 1e-3)
    assert s.wave_speed == pytest.approx(math.sqrt(70e9 / 1390))
    assert s.impedance == pytest.approx(math.pi / 4 * 1e-6 * math.sqrt(70e9 * 1390))
    assert s.speed == pytest.approx(2.5 * math.sqrt(4 * (0.5 + 0.25 * density) / s.mass))
    assert s.jerk == pytest.approx(2.5)


def test_scales_do_not_depend_on_the_direction_of_flight():
    turned = [
        ranking_of(*reference_flight(6, seed=None, rotation_deg=angles), flight_time=2.0, altitude=ALTITUDE)
        for angles in ((0, 0, 0), (20, -50, 110))
    ]
    for one, other in zip(turned[0].forces, turned[1].forces, strict=True):
        assert other.newtons == pytest.approx(one.newtons, rel=1e-9, abs=0)
        assert other.displacement == pytest.approx(one.displacement, rel=1e-9, abs=0)


def test_tether_and_chaser_are_no_part_of_the_net():
    net = CableNet.square(side=2.0, cells=4)
    nodes = np.vstack((net.nodes, [[0, 0, -20.0], [0, 0, -40.0]]))
    cables = np.vstack((net.cables, [[12, 25], [25, 26]]))
    tied = CableNet(nodes, cables, {"tether": [25], "chaser": [26]}, {"tether": [40, 41]})
    v = np.zeros(nodes.shape)
    v[26] = 5.0
    system = System(tied, SOFT, damping=NoDamping(), masses={"chaser": 500.0})
    bare = System(net, SOFT, damping=NoDamping())
    with_tether = scales_of(system, State.at(nodes, v), 1.0)
    alone = scales_of(bare, State.at(net.nodes), 1.0)
    # the tether's half cable on the net's middle knot stays: 10 m of it
    assert with_tether.mass - alone.mass == pytest.approx(10 * SOFT.cross_section * 1000.0)
    assert (with_tether.size, with_tether.area) == pytest.approx((alone.size, alone.area))
    assert with_tether.speed == pytest.approx(alone.speed)


def test_bullets_held_by_a_canister_count_with_the_speed_of_their_release():
    held = Restraint("corners", until=0.1, release_velocity=(1.0, 2.0, 2.0))
    s = scales_of(*square_with(restraints=[held]), 1.0)
    assert s.jerk == pytest.approx(3.0)
    assert not s.held


def test_net_at_rest_crosses_its_size_and_is_not_jerked_by_its_fall():
    for loads in ((), (LOADS["gravity"],), (LOADS["gravity"], LOADS["air"])):
        system, start = square_with(*loads)
        s = scales_of(system, start, 4.0)
        assert s.speed == s.jerk == pytest.approx(2 * math.sqrt(2) / 4.0)
        ranking = ranking_of(system, start, flight_time=4.0)
        assert forces_of(ranking)["inertia"].newtons == pytest.approx(s.mass * s.speed**2 / s.size)


def hung(group, *, scale=1.0, loads=(), **until):
    """Fall of a 2 m net that is held at a group."""
    system, start = square_with(LOADS["gravity"], *loads, restraints=[Restraint(group, **until)])
    return scales_of(system, State.at(start.x * [scale, scale, 1.0]), 4.0)


def test_net_that_is_drawn_together_sags_by_the_triangle_of_its_cords():
    s, half = hung("corners", scale=0.6), math.sqrt(2)
    assert s.fall.sag == pytest.approx(0.8 * half)  # 3, 4, 5
    assert s.held
    assert s.speed == pytest.approx(math.sqrt(2 * 9.81 * 0.8 * half))
    assert s.jerk == pytest.approx(0.8 * s.speed)


def test_net_that_is_taut_sags_as_a_parabola_stretches():
    # chord L, tension T = m g L/8h; the strain of the arc by summing over it, (h/L) 0.04: to its square
    s = hung("corners")
    h, L, EA = s.fall.sag, s.size, float(SOFT.youngs_modulus * SOFT.cross_section)
    x = np.linspace(0, L, 2001)
    y = 4 * h * x * (L - x) / L**2
    strain = np.hypot(np.diff(x), np.diff(y)).sum() / L - 1
    assert strain == pytest.approx(s.mass * 9.81 * L / (8 * h) / EA, rel=0.03)


def test_net_that_hangs_from_one_side_falls_by_its_size():
    assert hung((0,)).fall.sag == pytest.approx(2 * math.sqrt(2))  # a corner
    assert math.sqrt(2) < hung("centre").fall.sag < 0.8 * 2 * math.sqrt(2)


def test_net_falls_freely_once_it_is_released():
    fall = hung("corners", until=1.5).fall
    assert (fall.held, fall.free) == (1.5, 2.5)
    assert not hung("corners", until=1.5).held
    assert fall.way(0.0) == pytest.approx(fall.sag + 0.5 * 9.81 * 2.5**2)
    event = hung("corners", until="some event").fall
    assert (event.held, event.free) == (4.0, 0.0)


@pytest.mark.parametrize("drag", [0.0, 1e-6, 0.05, 3.0])
def test_fall_in_air_is_that_of_its_equation(drag):
    fall = Fall(gravity=9.81, mass=1.3, held=0.0, free=2.0, sag=0.0)

    def rate(_, y):
        return [y[1], 9.81 - drag / 1.3 * y[1] ** 2]

    way, speed = solve_ivp(rate, (0, 2.0), [0, 0], rtol=1e-10, atol=1e-12).y[:, -1]
    assert fall.speed(drag) == pytest.approx(speed, rel=1e-6)
    assert fall.way(drag) == pytest.approx(way, rel=1e-6)
    arrived = Fall(gravity=9.81, mass=1.3, held=1e3, free=0.0, sag=way)  # v by the way, not by the time
    assert arrived.speed(drag) == pytest.approx(speed, rel=1e-6)
    assert arrived.way(drag) == pytest.approx(way)


# Each force by another way


def test_snap_of_the_reference_flight_is_strained_as_estimated():
    # 2 w/c is one of order, so a factor of 2; with 20 meshes a side the flight's peak strain is 6e-4 to 8e-4 and
    # the estimate 7e-4. Peaks last 0.05 ms: the balance sees them, frames do not
    system, start = reference_flight(10)
    flight = simulate(system, start, [0.0, 1.0], options=EXPLICIT)
    snap = forces_of(ranking_of(system, start, flight_time=1.0))["elastic tension at snap"]
    assert 0.5 < flight[-1].balance.peak_tension / snap.newtons < 2
    s = scales_of(system, start, 1.0)
    assert snap.newtons == pytest.approx(system.cords.axial_stiffness[0] * 2 * s.jerk / s.wave_speed)
    assert 6e-4 < 2 * s.jerk / s.wave_speed < 8e-4


def test_jerk_sends_a_wave_that_a_held_end_doubles():
    # a string of 100 cables drawn at 0.5 m/s: strain w/c behind the front, 2 w/c behind its return. SOFT has
    # c = 100 m/s; E11 is w/c + (w/c)²/2, and c grows with the strain: 2 %
    w, c, count = 0.5, 100.0, 100
    pull = FunctionMotion(lambda t: [w * t, 0, 0], lambda t: [w, 0, 0], lambda t: [0, 0, 0])
    net = line(count)
    system = System(
        net,
        SOFT,
        damping=Dashpot(viscosity_time=1e-4),
        restraints=[Restraint("last", motion=pull), Restraint("first")],
    )
    v = np.zeros_like(net.nodes)
    v[-1, 0] = w
    times = [0.0, 0.006, 0.014]  # the front is 40 cables from the held end, then 40 on its way back
    flight = simulate(system, State.at(net.nodes, v), times, options=EXPLICIT)
    strain = [system.strain(x) for x in flight.positions]
    assert strain[1][60:80].mean() == pytest.approx(w / c, rel=0.02)
    assert strain[1][:5].max() < 0.02 * w / c
    assert strain[2][:15].mean() == pytest.approx(2 * w / c, rel=0.02)


def test_gravity_gradient_is_the_difference_of_gravity_at_two_radii():
    # gravity less the turning of the frame: 3 n² D, and 3 n² D²/a less of it (both to 3 D/a)
    force, D = forces_of(ranked()), ranked().scales.reach
    mass = ranked().scales.mass

    def outward(r):
        return N**2 * r - earth.GRAVITATION / r**2

    far = 1e4  # m; at 7 m the second order drowns in round-off
    first = (outward(A + far) - outward(A - far)) / 2 / far * D
    second = -(outward(A + far) + outward(A - far)) / 2 / far**2 * D**2
    assert force["gravity gradient"].newtons == pytest.approx(mass * first, rel=1e-5)
    assert force["gravity beyond its gradient"].newtons == pytest.approx(mass * second, rel=1e-5, abs=0)


def test_coriolis_shifts_a_free_mass_as_the_closed_form_does():
    # shot outward with v, y = 2 v/n (cos n t − 1) (Clohessy and Wiltshire 1960): n v t² to (n t)²/12
    t = 20.0
    ranking = ranked(flight_time=t)
    exact = 2 * ranking.scales.speed / N * (1 - math.cos(N * t))
    assert forces_of(ranking)["Coriolis"].displacement == pytest.approx(exact, rel=1e-4)


def test_forces_of_the_orbit_are_those_that_the_system_has():
    # largest forces of the net's own load: moving along the track, and standing on end
    rng = default_rng(0)
    ranking = ranked()
    s = ranking.scales
    force = Orbit(N).on(None, None, np.array([s.mass]))
    across = [rng.standard_normal(3) for _ in range(2000)]
    units = [u / np.linalg.norm(u) for u in across]
    none = np.zeros((1, 1, 3))
    moving = max(np.linalg.norm(force.force(0, none, s.speed * u.reshape(1, 1, 3))) for u in units)
    standing = max(np.linalg.norm(force.force(0, s.reach * u.reshape(1, 1, 3), none)) for u in units)
    assert forces_of(ranking)["Coriolis"].newtons == pytest.approx(moving, rel=0.01)  # 2000 directions
    assert forces_of(ranking)["gravity gradient"].newtons == pytest.approx(standing, rel=0.01)


def test_differential_oblateness_is_the_largest_gradient_of_its_field():
    def oblate(r):  # Vallado 2013, section 8.7.1: the second zonal harmonic in Cartesian coordinates
        size, z = np.linalg.norm(r), r[2]
        factor = -1.5 * earth.J2 * earth.GRAVITATION * earth.RADIUS**2 / size**5
        return factor * r * (np.array([1.0, 1.0, 3.0]) - 5 * z**2 / size**2)

    latitudes = np.linspace(0, math.pi / 2, 91)
    at = [A * np.array([math.cos(b), 0, math.sin(b)]) for b in latitudes]
    largest = [np.linalg.norm(differences(oblate, r), 2) for r in at]
    s = ranked().scales
    J2 = forces_of(ranked())["differential J2"].newtons
    assert np.argmax(largest) == 90  # over the pole
    assert pytest.approx(s.mass * s.reach * largest[-1], rel=1e-5, abs=0) == J2
    assert pytest.approx(2 * s.mass * s.reach * largest[0], rel=1e-5, abs=0) == J2


def test_drag_is_the_momentum_that_molecules_leave_on_cylinders():
    # a beam of oxygen atoms on the cylinder, thrown back diffusely at 300 to 1000 K, by summing over its surface:
    # C_D 2.09 to 2.17, the typical 2.2 within 6 %
    angle = (np.arange(2000) + 0.5) / 2000 * math.pi - math.pi / 2
    width = math.pi / 2000 * 0.5e-3  # of a strip of a 1 mm cord, m
    rho, s = earth.density(ALTITUDE), ranked().scales
    length = s.area / 1e-3
    for temperature in (300.0, 1000.0):
        slow = math.sqrt(
            math.pi * 1.380649e-23 * temperature / (2 * 16 * 1.66054e-27)
        )  # m/s, mean along the normal
        caught = rho * V * np.cos(angle) * width * length  # kg/s
        push = float(np.sum(caught * (V + slow * np.cos(angle))))
        assert forces_of(ranked())["aerodynamic drag"].newtons == pytest.approx(push, rel=0.06, abs=0)


def test_sunlight_pushes_cylinders_between_black_and_dull_white():
    s, pushed = ranked().scales, forces_of(ranked())["solar pressure"].newtons
    black = 1360.8 / 299792458 * s.area
    assert black < pushed < (1 + math.pi / 6) * black


def test_lorentz_force_is_that_of_the_dipole_over_its_pole():
    moment = np.array([0, 0, 2.98059e-5 * 6371.2e3**3])  # μ₀/4π of the dipole's moment, T m³

    def field(r):
        u = r / np.linalg.norm(r)
        return (3 * (moment @ u) * u - moment) / np.linalg.norm(r) ** 3

    over_pole = field(np.array([0, 0, A]))
    assert forces_of(ranked())["Lorentz force"].newtons == 0
    charged = forces_of(ranked(charge=-1e-6))["Lorentz force"].newtons
    assert charged == pytest.approx(1e-6 * np.linalg.norm(np.cross([V, 0, 0], over_pole)), rel=1e-9, abs=0)
    s, live = ranked().scales, forces_of(ranked(current=2.0))["Lorentz force"]
    assert live.newtons == pytest.approx(
        2 * np.linalg.norm(np.cross([s.size, 0, 0], over_pole)), rel=1e-9, abs=0
    )
    assert live.displacement == pytest.approx(0.5 * live.newtons / s.cord_mass * 1.6**2)


def test_drop_without_air_is_moved_by_gravity_as_galilei_says_and_air_would_carry_its_weight():
    system, start = square_with(LOADS["gravity"])
    force = forces_of(ranking_of(system, start, flight_time=2.0))
    weight = 9.81 * system.mass.sum()
    assert force["uniform gravity"].newtons == pytest.approx(weight)
    assert force["uniform gravity"].displacement == pytest.approx(0.5 * 9.81 * 4)
    area = 20 * 2e-3  # 20 m of cord, 2 mm
    terminal = math.sqrt(2 * weight / (1.225 * 1.1 * area))
    # after 2 s it is within 3 % of its terminal velocity: tanh(g t/u) with u = 4.8 m/s
    assert force["air drag"].newtons == pytest.approx(weight, rel=0.03)
    assert not force["air drag"].included
    assert force["air drag"].displacement <= terminal * 2.0


def test_drop_in_air_is_no_faster_than_its_terminal_velocity():
    system, start = square_with(LOADS["gravity"], AirDrag(density=1.0, normal_coefficient=1.0))
    ranking = ranking_of(system, start, flight_time=60.0)
    weight, k = 9.81 * system.mass.sum(), 0.5 * 20 * 2e-3
    assert ranking.scales.fall.speed(k) == pytest.approx(math.sqrt(weight / k))
    force = forces_of(ranking)
    assert force["air drag"].newtons == pytest.approx(weight)
    assert force["uniform gravity"].displacement < 60 * math.sqrt(weight / k)


@pytest.mark.parametrize(("name", "end"), [("ground_drop", None), ("hanging_net", 0.5)])
def test_shipped_scenario_flies_as_estimated(name, end):
    # orders of magnitude: within a factor of 3
    simulation = read_scenario(SCRIPTS / f"{name}.toml").build()
    system, start = simulation.system, simulation.start
    times = np.linspace(0, 3.25 if end is None else end, 60)  # the drop meets the ground at 3.26 s
    flight = simulate(system, start, times, options=EXPLICIT)
    ranking = ranking_of(system, start, flight_time=float(times[-1]))
    mass = system.mass[:, None] / system.mass.sum()
    middle = [(mass * state.x).sum(axis=0)[2] for state in flight]
    fastest = max(np.linalg.norm((mass * state.v).sum(axis=0)) for state in flight)
    peak = max(state.balance.peak_tension for state in flight)  # each between two frames
    force, s = forces_of(ranking), ranking.scales
    for estimate, flown in (
        (force["elastic tension at snap"].newtons, peak),
        (force["uniform gravity"].displacement, middle[0] - min(middle)),
        (s.fall.speed(s.air), fastest),
    ):
        assert 1 / 3 < estimate / flown < 3


def test_net_that_is_held_moves_by_its_size_at_most():
    system, start = square_with(LOADS["gravity"], restraints=[Restraint("corners")])
    ranking = ranking_of(system, start, flight_time=10.0)
    assert max(force.displacement for force in ranking.forces) == ranking.scales.size


# What the ranking says


def test_rank_of_the_reference_net_at_600_km():
    assert [force.name for force in ranked().forces] == [
        "elastic tension at snap",
        "inertia",
        "Coriolis",
        "gravity gradient",
        "aerodynamic drag",
        "solar pressure",
        "differential J2",
        "gravity beyond its gradient",
        "Lorentz force",
    ]


def test_drag_outranks_the_gravity_gradient_in_low_orbit_and_sunlight_outranks_drag_in_high():
    names = [force.name for force in ranked(250e3).forces]
    assert names.index("aerodynamic drag") < names.index("gravity gradient")
    names = [force.name for force in ranked(900e3).forces]
    assert names.index("solar pressure") < names.index("aerodynamic drag")


def test_short_flight_needs_no_orbit_and_a_long_one_does():
    assert ranked(flight_time=1.6).missing == ()
    missing = ranked(flight_time=20.0).missing
    assert [force.name for force in missing] == ["Coriolis"]
    assert missing[0].remedy == "[orbit] altitude = 600000"
    assert ranked(flight_time=20.0).share(missing[0]) > SIGNIFICANT


@pytest.mark.parametrize("kind", LOADS)
def test_each_load_is_found_in_its_system(kind):
    system, _ = square_with(LOADS[kind])
    assert included_in(system) == {kind}


@pytest.mark.parametrize("kind", BODIES)
def test_load_on_bodies_alone_is_found_with_its_newtons_and_the_mass_that_it_moves(kind):
    system, start = square_with(BODIES[kind], velocity=(0, 2.0, 0))
    assert included_in(system) == {kind}
    force = forces_of(ranking_of(system, start, flight_time=2.0, altitude=250e3))
    reported = force[{"drag": "aerodynamic drag", "sunlight": "solar pressure", "air": "air drag"}[kind]]
    newtons = (
        4
        * {
            "drag": 0.5 * 1e-11 * 7750**2 * 2.2 * 2e-3,
            "sunlight": 4e-6 * 1.2 * 2e-3,
            "air": 0.5 * 1.2 * (5.0 + 2.0) ** 2 * 0.47 * 1e-3,
        }[kind]
    )
    corners = 4 * 0.5 * SOFT.cross_section * 1000.0  # kg, half of two cables of 0.5 m each
    assert reported.included
    assert reported.newtons == pytest.approx(newtons, rel=1e-9, abs=0)
    # four seconds' way through the air at most
    expected = min(0.5 * newtons / corners * 2.0**2, 7.0 * 2.0) if kind == "air" else newtons / corners * 2.0
    assert reported.displacement == pytest.approx(expected, rel=1e-9, abs=0)
    assert "on bodies, moves" in reported.formula
    left_out = force[f"{reported.name} of cords"]
    assert not left_out.included
    if kind != "air":  # which is not reported of a net without gravity and air
        bare, start = square_with(velocity=(0, 2.0, 0))
        alone = forces_of(ranking_of(bare, start, flight_time=2.0, altitude=250e3))[reported.name]
        assert left_out.newtons == alone.newtons


@pytest.mark.parametrize("kind", BODIES)
def test_cords_and_bodies_are_summed_and_the_faster_of_them_reported(kind):
    name = {"drag": "aerodynamic drag", "sunlight": "solar pressure", "air": "air drag"}[kind]

    def reported(*loads):
        system, start = square_with(*loads, velocity=(0, 2.0, 0))
        return forces_of(ranking_of(system, start, flight_time=1e-3, altitude=250e3))[name]

    both, cords, bodies = reported(LOADS[kind], BODIES[kind]), reported(LOADS[kind]), reported(BODIES[kind])
    assert both.newtons == pytest.approx(cords.newtons + bodies.newtons, rel=1e-9, abs=0)
    assert both.displacement == pytest.approx(max(cords.displacement, bodies.displacement), rel=1e-9, abs=0)
    assert "on cords and bodies" in both.formula


def test_load_on_a_chaser_is_none_on_the_net():
    net = CableNet.square(side=2.0, cells=4)
    nodes = np.vstack((net.nodes, [[0, 0, -20.0]]))
    tied = CableNet(nodes, np.vstack((net.cables, [[12, 25]])), {"chaser": [25]}, {"tether": [40]})
    drag = BodyDrag("chaser", 3.0, 1e-11, 2.2, wind=[0, -7750.0, 0])
    system = System(tied, SOFT, damping=NoDamping(), masses={"chaser": 500.0}, loads=[LOADS["drag"], drag])
    bare, start = square_with(LOADS["drag"])
    there = forces_of(ranking_of(system, State.at(nodes), flight_time=1.0, altitude=250e3))
    alone = forces_of(ranking_of(bare, start, flight_time=1.0, altitude=250e3))
    assert there["aerodynamic drag"].newtons == pytest.approx(alone["aerodynamic drag"].newtons)


def test_all_loads_are_reported_as_included():
    system, start = square_with(*LOADS.values())
    force = forces_of(ranking_of(system, start, flight_time=1.0, altitude=ALTITUDE))
    included = {name for name, each in force.items() if each.included}
    assert included == {*force} - {"differential J2", "gravity beyond its gradient", "Lorentz force"}


def test_forces_on_nodes_are_no_gravity():
    system, start = square_with(NodalLoad("all", [0, 0, 1.0]), NodalLoad("corners", [0, 0, 1.0]))
    assert included_in(system) == frozenset()
    assert scales_of(system, start, 1.0).fall.gravity == 0


def test_gravity_is_the_largest_during_the_flight():
    system, start = square_with(Gravity([0, 0, -1.0]), Gravity(Pulse([0, 0, -9.0], 0.5, 0.6)))
    assert scales_of(system, start, 1.0).fall.gravity == pytest.approx(10.0)
    assert scales_of(system, start, 0.4).fall.gravity == pytest.approx(1.0)


def test_loads_of_the_system_are_reported_by_their_own_figures():
    system, start = square_with(*LOADS.values(), velocity=(0, 0, 2.0))
    force = forces_of(ranking_of(system, start, flight_time=1e-3, altitude=ALTITUDE))
    area = 20 * 2e-3  # 20 m of cord, 2 mm
    assert force["aerodynamic drag"].newtons == pytest.approx(0.5 * 1e-12 * 7500**2 * 2.0 * area)
    assert force["solar pressure"].newtons == pytest.approx(4e-6 * area, rel=1e-9, abs=0)
    assert force["air drag"].newtons == pytest.approx(0.5 * 1.0 * (2.0 + 3.0) ** 2 * area)


def test_altitude_is_read_from_the_orbit_of_the_system():
    assert orbit_altitude(square_with(LOADS["orbit"])[0]) == pytest.approx(ALTITUDE)
    assert orbit_altitude(square_with()[0]) is None


@pytest.mark.parametrize(
    ("figures", "message"),
    [
        ({"flight_time": 0.0}, "flight time is 0 s: give a time above zero"),
        ({"flight_time": math.nan}, "flight time is nan s"),
        ({"altitude": 100e3}, "altitude is 100000 m: no orbit"),
        ({"charge": math.inf}, "charge is inf C"),
        ({"current": math.nan}, "current is nan A"),
    ],
)
def test_what_cannot_be_is_refused(figures, message):
    with pytest.raises(InputError, match=message):
        ranked(**figures)
