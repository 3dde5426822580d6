"""[orbit] and the kinds drag, solar_pressure and air of [[loads]]: what is written flies, mistakes get one line."""

import numpy as np
import pytest

import netdae as nd
from netdae.core.errors import ScenarioError
from netdae.forces import earth
from netdae.forces.air import AirDrag, AirOnCables
from netdae.forces.drag import BODY_DRAG, DragOnBodies
from netdae.forces.free_molecular import FreeMolecularDrag, MolecularDrag
from netdae.forces.loads import UniformLoad
from netdae.forces.orbit import Orbit, OrbitForce
from netdae.forces.solar import LightOnCables, SolarPressure, sun_over_orbit
from netdae.model.signals import Function, Pulse

SCENARIO = """\
[net]
kind = "square"
side = 1.0
cells = 2
[[material]]
youngs_modulus = 1e9
density = 1000
diameter = 2e-3
[damping]
kind = "none"
[[masses]]
group = "corners"
mass = 0.1
[initial]
scale = [0.5, 0.5, 1.0]
{}
[solver]
begin = 2.0
end = 2.5
[output]
frames = 2
"""

ORBIT = "[orbit]\naltitude = 600e3\n"
NAMES = {
    OrbitForce: "orbit",
    MolecularDrag: "drag",
    LightOnCables: "light",
    AirOnCables: "air",
    DragOnBodies: "drag of bodies",
    UniformLoad: "light on bodies",
}


def built(folder, sections):
    file = folder / "scenario.toml"
    file.write_text(SCENARIO.format(sections), encoding="utf-8")
    return nd.read_scenario(file).build()


def forces_of(folder, sections):
    forces = built(folder, sections).system.forces
    return {NAMES[f.law.parameters]: f for f in forces if f.law.parameters in NAMES}


def test_an_orbit_is_reported_by_its_altitude_or_by_its_mean_motion(tmp_path):
    n = earth.mean_motion(600e3)
    for text in (ORBIT, f"[orbit]\nmean_motion = {n!r}\n"):
        forces = forces_of(tmp_path, text)
        assert list(forces) == ["orbit"]
        assert forces["orbit"].parameters.mean_motion == pytest.approx(n, rel=1e-15)


def test_drag_takes_air_and_stream_from_the_orbit(tmp_path):
    forces = forces_of(
        tmp_path, f'{ORBIT}[[loads]]\nkind = "drag"\nbodies = [{{group = "corners", diameter = 0.05}}]'
    )
    drag, bodies = forces["drag"], forces["drag of bodies"]
    np.testing.assert_allclose(drag.parameters.weight, 0.25 * earth.density(600e3) * 2.2 * 2e-3, rtol=1e-12)
    np.testing.assert_allclose(
        bodies.parameters.weight, 0.5 * earth.density(600e3) * 2.2 * np.pi / 4 * 0.05**2, rtol=1e-12
    )
    for force in (drag, bodies):
        np.testing.assert_allclose(force.signal(0.0), [0.0, -earth.circular_speed(600e3), 0.0], rtol=1e-12)
    assert len(drag.nodes) == 12
    assert len(bodies.nodes) == 4


def test_drag_takes_its_density_from_a_table_at_the_altitude_of_the_orbit(tmp_path):
    (tmp_path / "air.csv").write_text("altitude,density\n500e3,1e-12\n700e3,1e-14\n", encoding="utf-8")
    given = '[[loads]]\nkind = "drag"\ndensity = { file = "air.csv" }'
    drag = forces_of(tmp_path, ORBIT + given)["drag"]
    # exponential between the rows: their geometric mean half-way
    np.testing.assert_allclose(drag.parameters.weight, 0.25 * 1e-13 * 2.2 * 2e-3, rtol=1e-12)
    for text, words in (
        (given, "the altitude for the density table is missing"),
        (
            ORBIT.replace("600e3", "900e3") + given,
            "air.csv: altitude is 900000 m, but the density table goes",
        ),
    ):
        with pytest.raises(ScenarioError, match=words):
            built(tmp_path, text)


def test_drag_takes_what_it_is_reported_before_what_the_orbit_tells(tmp_path):
    given = 'density = 1e-11\nstream = [0, -7000, 100]\ndrag_coefficient = 2.6\ncables = "border"\ndiameter = 0.003'
    for orbit in ("", ORBIT):
        drag = forces_of(tmp_path, f'{orbit}[[loads]]\nkind = "drag"\n{given}')["drag"]
        np.testing.assert_allclose(drag.parameters.weight, 0.25 * 1e-11 * 2.6 * 3e-3, rtol=1e-12)
        np.testing.assert_array_equal(drag.signal(0.0), [0, -7000, 100])
        assert len(drag.nodes) == 8


def test_sunlight_turns_with_the_frame_and_is_cut_by_shadow(tmp_path):
    bodies = 'bodies = [{group = "corners", area = 0.1}]'
    text = f'[[loads]]\nkind = "solar_pressure"\nsun = [2, 0, 0]\nbegin = 2.1\nend = 2.3\n{bodies}'
    forces = forces_of(tmp_path, ORBIT + text)
    light, bodies = forces["light"], forces["light on bodies"]
    np.testing.assert_allclose(light.parameters.weight, 0.5 * earth.SOLAR_PRESSURE * 1.3 * 2e-3, rtol=1e-12)
    np.testing.assert_allclose(bodies.parameters.weight, earth.SOLAR_PRESSURE * 1.3 * 0.1, rtol=1e-12)
    angle = earth.mean_motion(600e3) * 0.2  # since the start at 2 s
    for force in (light, bodies):
        assert force.jumps == (2.1, 2.3)
        np.testing.assert_array_equal(force.signal(2.05), 0.0)
        np.testing.assert_allclose(force.signal(2.2), [-np.cos(angle), np.sin(angle), 0.0], rtol=1e-12)


def test_sunlight_without_an_orbit_stands_still(tmp_path):
    light = forces_of(
        tmp_path, '[[loads]]\nkind = "solar_pressure"\nsun = [0, 0, 5]\npressure = 1e-5\ncoefficient = 1.0'
    )
    np.testing.assert_array_equal(light["light"].signal(2.4), [0, 0, -1])
    np.testing.assert_allclose(light["light"].parameters.weight, 0.5 * 1e-5 * 2e-3, rtol=1e-12)


def test_air_has_a_wind_and_bodies_of_their_own_shape(tmp_path):
    (tmp_path / "wind.csv").write_text("t,x,y,z\n0,1,0,0\n5,2,0,0\n")
    bodies = 'bodies = [{group = "corners", area = 0.01, drag_coefficient = 1.2}, {group = "centre", diameter = 0.1}]'
    text = f'[[loads]]\nkind = "air"\nwind = {{file = "wind.csv"}}\ncables = "inner"\n{bodies}'
    forces = forces_of(tmp_path, text)
    air = forces["air"].parameters
    np.testing.assert_allclose(air.across, 0.25 * 1.225 * 1.1 * 2e-3, rtol=1e-12)
    np.testing.assert_allclose(air.along, 0.25 * 1.225 * np.pi * 0.01 * 2e-3, rtol=1e-12)
    np.testing.assert_allclose(forces["air"].signal(2.5), [1.5, 0, 0], rtol=1e-12)
    all_forces = built(tmp_path, text).system.forces
    weights = [f.parameters.weight[0] for f in all_forces if f.law is BODY_DRAG]
    sphere = 0.5 * 1.225 * 0.47 * np.pi / 4 * 0.1**2
    np.testing.assert_allclose(weights, [0.5 * 1.225 * 1.2 * 0.01, sphere], rtol=1e-12)


def test_bodies_alone_may_be_in_the_air(tmp_path):
    bodies = 'bodies = [{group = "corners", area = 0.01}]'
    text = f'[[loads]]\nkind = "air"\ncables = "none"\nwind = [3, 0, 0]\nend = 2.2\n{bodies}'
    forces = forces_of(tmp_path, text)
    assert list(forces) == ["drag of bodies"]
    assert forces["drag of bodies"].jumps == (2.0, 2.2)


def test_a_scenario_with_all_of_them_flies_as_the_python_interface_does(tmp_path):
    air = '[[loads]]\nkind = "air"\nwind = [1, 2, 3]\n'
    light = '[[loads]]\nkind = "solar_pressure"\nsun = [0, 0, 1]\nend = 2.2\n'
    simulation = built(tmp_path, f'{ORBIT}[[loads]]\nkind = "drag"\n{light}{air}')
    *_, last = simulation.integrate()
    net = nd.CableNet.square(side=1.0, cells=2)
    n, shine = earth.mean_motion(600e3), Pulse([1, 1, 1], 2.0, np.inf)
    sun = Function(
        lambda t: shine(t) * sun_over_orbit([0, 0, 1], n, since=2.0)(t) * (t < 2.2), jumps=(2.0, 2.2)
    )
    system = nd.System(
        net,
        nd.Material(youngs_modulus=1e9, density=1000.0, diameter=2e-3),
        masses={"corners": 0.1},
        damping=nd.NoDamping(),
        loads=[
            Orbit(n),
            FreeMolecularDrag(earth.density(600e3), [0, -earth.circular_speed(600e3), 0]),
            SolarPressure(sun, earth.SOLAR_PRESSURE),
            AirDrag(wind=[1, 2, 3]),
        ],
    )
    start = nd.State.at(net.nodes * [0.5, 0.5, 1.0], t=2.0)
    flight = nd.simulate(system, start, [2.0, 2.5], options=simulation.options)
    np.testing.assert_array_equal(last.x, flight[-1].x)
    np.testing.assert_array_equal(last.v, flight[-1].v)
    assert (np.abs(last.v).max(axis=0) > 0.01).all()  # the wind has moved it


LOW = "expected 120e3 to 1e9, in m above the Earth: lower down the air ends an orbit"
MISTAKES = {
    "under 120 km": ("[orbit]\naltitude = 119e3", ["[orbit] altitude is 119000.0", LOW]),
    "altitude in km": ("[orbit]\naltitude = 600", ["[orbit] altitude is 600", LOW]),
    "negative altitude": ("[orbit]\naltitude = -600e3", ["[orbit] altitude is -600000.0", LOW]),
    "altitude in quotes": ('[orbit]\naltitude = "600e3"', ["[orbit] altitude", "a number"]),
    "altitude not a number": ("[orbit]\naltitude = nan", ["[orbit] altitude"]),
    "no mean motion": ("[orbit]\nmean_motion = 0", ["[orbit] mean_motion is 0", "above 0"]),
    "mean motion of a low orbit": ("[orbit]\nmean_motion = 1.3e-3", ["[orbit]: mean_motion is 0.0013", "120000 m"]),
    "neither": ("[orbit]", ["[orbit]: neither of altitude and mean_motion"]),
    "both": ("[orbit]\naltitude = 6e5\nmean_motion = 1e-3", ["[orbit]: both of altitude and mean_motion"]),
    "no density": ('[[loads]]\nkind = "drag"\nstream = [0, -7e3, 0]', ["[[loads]] 1: density is missing", "[orbit]"]),
    "no stream": ('[[loads]]\nkind = "drag"\ndensity = 1e-12', ["[[loads]] 1: stream is missing", "[orbit]"]),
    "no sun": ('[[loads]]\nkind = "solar_pressure"', ["[[loads]] 1 sun is missing"]),
    "sun of no direction": ('[[loads]]\nkind = "solar_pressure"\nsun = [0, 0, 0]', ["sun is [0, 0, 0]"]),
    "shadow before light": (
        '[[loads]]\nkind = "solar_pressure"\nsun = [0, 0, 1]\nbegin = 3\nend = 2',
        ["[[loads]] 1: it lasts from 3 to 2 s"],
    ),
    "unknown kind": ('[[loads]]\nkind = "aire"', ["kind is", "drag, solar_pressure, air", "did you mean air"]),
    "unknown cables": ('[[loads]]\nkind = "air"\ncables = "rim"', ["[[loads]] 1: there is no cable group 'rim'"]),
    "unknown bodies": (
        '[[loads]]\nkind = "air"\nbodies = [{group = "bullets", area = 1e-3}]',
        ["[[loads]] 1: there is no node group 'bullets'", "corners"],
    ),
    "bodies without area": (
        '[[loads]]\nkind = "air"\nbodies = [{group = "corners"}]',
        ["[[loads]] 1: neither of area and diameter is given for 'corners'"],
    ),
    "unknown key of a body": (
        '[[loads]]\nkind = "air"\nbodies = [{group = "corners", aera = 1e-3}]',
        ["[[loads]] 1 bodies, number 1, aera is an unknown key", "did you mean area"],
    ),
    "a begin without wind": ('[[loads]]\nkind = "air"\nbegin = 0.5', ["begin is that of a wind", "give wind"]),
    "a diameter of no cables": (
        '[[loads]]\nkind = "air"\ncables = "none"\ndiameter = 1e-3\nbodies = [{group = "corners", area = 1e-3}]',
        ["diameter is that of cables"],
    ),
    "nothing in the air": ('[[loads]]\nkind = "air"\ncables = "none"', ["[[loads]] 1: it acts on nothing"]),
    "no air": ('[[loads]]\nkind = "air"\ndensity = 0', ["[[loads]] 1 density is 0, expected"]),
    "wind by half": ('[[loads]]\nkind = "air"\nwind = [1, 2]', ["[[loads]] 1 wind", "three numbers"]),
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_gets_one_line_that_names_the_place(tmp_path, name):
    text, words = MISTAKES[name]
    with pytest.raises(ScenarioError) as caught:
        built(tmp_path, text)
    message = str(caught.value)
    assert "\n" not in message
    for word in words:
        assert word in message, message
