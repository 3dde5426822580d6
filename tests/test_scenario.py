"""Scenario files: what is written in them is what flies."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from test_bad_input import MISTAKES, SCENARIO

import netdae as nd
from netdae.scenario.schema import ScenarioData
from netdae.scenario.table_files import read_table

ROOT = Path(__file__).parent.parent

FREE = """\
[net]
kind = "square"
side = 1.0
cells = 2
[[material]]
youngs_modulus = 1e9
density = 1000
diameter = 1e-3
[damping]
kind = "none"
{}
[solver]
end = 0.002
accuracy = "accurate"
"""


# the design's complete example
COMPLETE = """\
title = "5 m net, corner shot"
[net]
file = "../meshes/square_5m.vtu"
[[material]]
cables = "all"
youngs_modulus = 70e9
density = 1390.0
diameter = 1.0e-3
toe_strain = 0.0
law = "st_venant_kirchhoff"
strength = 500.0
[damping]
kind = "dashpot"
viscosity_time = 1e-5
[[masses]]
group = "corners"
mass = 0.5
[[restraints]]
group = "centre"
axes = "xyz"
motion = "fixed"
[initial]
shape = "scaled"
scale = [0.4, 0.4, 1.0]
rotation_deg = [0.0, 0.0, 0.0]
velocity = [0.0, 0.0, 0.0]
[[initial.ejection]]
group = "corners"
speed = 2.5
half_angle_deg = 45.0
axis = [0.0, 0.0, 1.0]
[[loads]]
kind = "gravity"
g = [0.0, 0.0, -9.81]
[solver]
method = "ida"
end = 1.0
accuracy = "standard"
[output]
frames = 51
[metrics]
mouth = "border"
"""


def built(folder, text):
    file = folder / "scenario.toml"
    file.write_text(text, encoding="utf-8")
    return nd.read_scenario(file).build()


def last_of(simulation):
    *_, last = simulation.integrate()
    return last


def test_scenario_builds_what_the_python_interface_builds(tmp_path):
    simulation = built(tmp_path, SCENARIO)
    net = nd.CableNet.square(side=1.0, cells=2)
    cord = nd.Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)
    system = nd.System(
        net,
        cord,
        masses={"corners": 0.1},
        damping=nd.Dashpot(viscosity_time=1e-5),
        restraints=[nd.Restraint("centre")],
        loads=[nd.Gravity([0, 0, -9.81])],
    )
    turned, start = nd.scaled(net, [0.4, 0.4, 1.0])
    start = nd.ejected(turned, start, "corners", speed=2.0, half_angle_deg=45.0)
    np.testing.assert_array_equal(simulation.system.mass, system.mass)
    np.testing.assert_array_equal(simulation.start.x, start.x)
    np.testing.assert_array_equal(simulation.start.v, start.v)
    ours = last_of(simulation)
    theirs = nd.simulate(system, start, simulation.times)[-1]
    np.testing.assert_array_equal(ours.x, theirs.x)  # the same numbers in the same order


def test_complete_example_of_the_design_is_ready_to_fly(tmp_path):
    simulation = built(tmp_path, COMPLETE.replace("..", ROOT.as_posix()))
    assert simulation.system.net.node_count == 21 * 21
    assert simulation.title == "5 m net, corner shot"


def test_defaults_are_those_that_the_schema_tells(tmp_path):
    simulation = built(tmp_path, FREE.replace('accuracy = "accurate"\n', "").format(""))
    assert len(simulation.times) == 51
    assert simulation.options == nd.SolverOptions()
    assert simulation.metrics.mouth == "border"
    assert simulation.title == "scenario"


def test_whole_numbers_are_numbers_and_overrides_reach_the_solver(tmp_path):
    text = FREE.format("").replace(
        '"accurate"', '"fast"\nrtol = 1e-6\natol_velocity = 1\nmax_order = 2\nmax_step = 1'
    )
    options = built(tmp_path, text.replace("side = 1.0", "side = 1")).options
    assert options.tolerances == (1e-6, 1e-4, 1.0)
    assert (options.max_order, options.max_step) == (2, 1.0)


def test_later_material_overrides_an_earlier_one(tmp_path):
    cord = (
        '[[material]]\ncables = "{}"\nyoungs_modulus = 1e9\ndensity = 1000\ndiameter = 1e-3\nstrength = {}\n'
    )
    first, rest = FREE.split("[[material]]")
    rest = rest[rest.index("[damping]") :]
    text = first + cord.format("border", 1) + cord.format("all", 2) + cord.format("border", 3) + rest
    system = built(tmp_path, text.format("")).system
    border = system.net.cables_of("border")
    assert set(system.strength[border]) == {3.0}
    assert set(np.delete(system.strength, border)) == {2.0}


def test_masses_of_several_entries_add_up(tmp_path):
    bare = built(tmp_path, FREE.format("")).system
    entry = '[[masses]]\ngroup = "{}"\nmass = {}\n'
    text = FREE.format(entry.format("corners", 1) + entry.format("border", 2) + entry.format("corners", 4))
    more = built(tmp_path, text).system.mass - bare.mass
    expected = np.zeros(9)
    expected[bare.net.nodes_of("border")] += 2
    expected[bare.net.nodes_of("corners")] += 5
    np.testing.assert_allclose(more, expected, rtol=1e-12)


def test_ejection_leaves_at_its_angle_and_speed(tmp_path):
    start = built(tmp_path, SCENARIO.replace("half_angle_deg = 45", "half_angle_deg = 30")).start
    v = start.v[[0, 2, 6, 8]]
    np.testing.assert_allclose(v[:, 2], 2 * np.cos(np.pi / 6))
    np.testing.assert_allclose(np.linalg.norm(v, axis=1), 2.0)
    np.testing.assert_allclose(v[:, :2], np.sin(np.pi / 6) * np.sqrt(2) * np.sign(start.x[[0, 2, 6, 8], :2]))


def test_turning_the_whole_scenario_turns_the_flight(tmp_path):
    text = SCENARIO.replace("end = 0.001", "end = 0.02").replace("viscosity_time = 1e-5", "beta = 1e-4")
    text = text.replace("dashpot", "rayleigh")
    plain = last_of(built(tmp_path, text))
    # turned by 90 degrees about y: x to -z, z to x
    text = text.replace("[initial]", "[initial]\nrotation_deg = [0, 90, 0]").replace(
        "0, 0, -9.81", "-9.81, 0, 0"
    )
    turned = last_of(built(tmp_path, text.replace("= 45", "= 45\naxis = [1, 0, 0]")))
    expected = np.column_stack([plain.x[:, 2], plain.x[:, 1], -plain.x[:, 0]])
    np.testing.assert_allclose(turned.x, expected, atol=1e-12)  # round-off: no knot has snapped yet
    assert np.abs(plain.x - built(tmp_path, SCENARIO).start.x).max() > 0.01


def test_pulse_gives_its_exact_momentum(tmp_path):
    pulse = '[[loads]]\nkind = "nodal"\ngroup = "all"\nforce = [3, 0, -1]\nbegin = 0.001\nend = 0.0011'
    simulation = built(tmp_path, FREE.format(pulse))
    momentum = simulation.system.momentum(last_of(simulation).v)
    np.testing.assert_allclose(momentum, 9 * 1e-4 * np.array([3, 0, -1]), rtol=1e-9, atol=1e-15)


def test_force_without_an_end_acts_from_its_begin_on(tmp_path):
    pulse = '[[loads]]\nkind = "gravity"\ng = [0, 0, -2]\nbegin = 0.0015'
    last = last_of(built(tmp_path, FREE.format(pulse)))
    np.testing.assert_allclose(last.v[:, 2], -2 * 0.0005, rtol=1e-9)


def test_table_of_forces_gives_the_area_under_it(tmp_path):
    (tmp_path / "push.csv").write_text("t,x,y,z\n0,0,0,0\n1e-3,4,0,0\n2e-3,0,0,2\n")
    load = '[[loads]]\nkind = "nodal"\ngroup = "all"\nforce = { file = "push.csv" }'
    simulation = built(tmp_path, FREE.format(load))
    momentum = simulation.system.momentum(last_of(simulation).v)
    # the steps end at the rows; between them the BDF formulas are right within the tolerances
    np.testing.assert_allclose(momentum, 9 * np.array([4e-3, 0, 1e-3]), rtol=1e-4, atol=1e-8)


def test_table_of_gravity_is_met(tmp_path):
    (tmp_path / "g.csv").write_text("t,x,y,z\n0,0,0,-2\n1,0,0,-2\n")
    load = '[[loads]]\nkind = "gravity"\ng = { file = "g.csv", interpolation = "cubic" }'
    last = last_of(built(tmp_path, FREE.format(load)))
    np.testing.assert_allclose(last.x[:, 2], -0.5 * 2 * 0.002**2, rtol=1e-4)


@pytest.mark.parametrize(
    ("header", "row", "interpolation", "speed"),
    [
        ("t,x,y,z", "0,0,0", "linear", 0.5),
        ("t,x,y,z,vx,vy,vz", "0,0,0,0.25,0,0", "cubic", 0.25),
        ("t,x,y,z", "0,0,0", "cubic", 0),
    ],
)
def test_driven_nodes_start_at_the_velocity_of_their_table(header, row, interpolation, speed, tmp_path):
    more = "" if "vx" not in header else ",0,0,0"
    (tmp_path / "m.csv").write_text(f"{header}\n0,{row}\n2e-3,1e-3,0,0{more}\n")
    hold = (
        '[[restraints]]\ngroup = "corners"\naxes = "xy"\n'
        f'motion = {{ file = "m.csv", interpolation = "{interpolation}" }}'
    )
    simulation = built(tmp_path, FREE.format(hold))
    corners = simulation.system.net.nodes_of("corners")
    np.testing.assert_allclose(simulation.start.v[corners], np.tile([speed, 0, 0], (4, 1)), atol=1e-9)
    last = last_of(simulation)
    np.testing.assert_allclose(
        (last.x - simulation.start.x)[corners], np.tile([1e-3, 0, 0], (4, 1)), atol=1e-14
    )


def test_files_are_found_beside_the_scenario(tmp_path, monkeypatch):
    folder = tmp_path / "study"
    folder.mkdir()
    nd.write_net(nd.CableNet.square(side=1.0, cells=2), folder / "net.vtu")
    text = FREE.format("").replace('kind = "square"\nside = 1.0\ncells = 2', 'file = "net.vtu"')
    (folder / "s.toml").write_text(text)
    monkeypatch.chdir(tmp_path)
    assert nd.read_scenario("study/s.toml").build().system.net.node_count == 9


def test_net_without_border_and_corners_has_no_mouth(tmp_path):
    nd.write_net(nd.CableNet([[0, 0, 0], [1, 0, 0]], [[0, 1]]), tmp_path / "net.vtu")
    text = FREE.format("").replace('kind = "square"\nside = 1.0\ncells = 2', 'file = "net.vtu"')
    metrics = built(tmp_path, text).metrics
    assert (metrics.mouth, metrics.corners) == (None, None)


def test_mouth_can_be_left_out(tmp_path):
    metrics = built(tmp_path, FREE.format("") + '[metrics]\nmouth = "none"\ncorners = "none"\n').metrics
    assert (metrics.mouth, metrics.corners) == (None, None)


def test_findings_in_a_mesh_are_handed_on(tmp_path):
    nodes = [[0, 0, 0], [1, 0, 0], [1, 0, 0], [2, 0, 0]]
    nd.write_net(nd.CableNet(nodes, [[0, 1], [2, 3]]), tmp_path / "net.vtu")
    text = FREE.format("").replace('kind = "square"\nside = 1.0\ncells = 2', 'file = "net.vtu"')
    (finding,) = built(tmp_path, text).findings
    assert "net.vtu" in finding
    assert "at the place of another" in finding


def test_table_is_read_as_spreadsheets_write_it(tmp_path):
    (tmp_path / "m.csv").write_bytes(b"\xef\xbb\xbft, x\r\n0, 1.5\r\n\r\n1e0,-2\r\n,\r\n")
    table = read_table(tmp_path / "m.csv", ("t", "x"))
    np.testing.assert_array_equal(table["t"], [0, 1])
    np.testing.assert_array_equal(table["x"], [1.5, -2])


def keys_of(definition, schema):
    """All keys that a part of the schema describes, with their descriptions."""
    for name, value in definition.get("properties", {}).items():
        section = schema["$defs"].get(value.get("$ref", "").removeprefix("#/$defs/"), {})
        yield name, value.get("description") or section.get("description")
    for part in definition.get("$defs", {}).values():
        yield from keys_of(part, schema)


def test_schema_describes_every_key():
    schema = ScenarioData.model_json_schema()
    keys = list(keys_of(schema, schema))
    assert len(keys) > 60
    assert [name for name, description in keys if not description] == []
    json.dumps(schema)


def test_schema_knows_every_section_of_the_design():
    sections = {
        "title",
        "net",
        "material",
        "damping",
        "masses",
        "restraints",
        "initial",
        "loads",
        "orbit",
        "tether",
        "events",
        "closing",
        "pulleys",
        "target",
        "obstacles",
        "solver",
        "output",
    }
    assert {*ScenarioData.model_fields} == sections | {"metrics"}


def test_every_mistake_is_about_the_scenario_that_is_right_without_it(tmp_path):
    built(tmp_path, SCENARIO)
    assert all(old in SCENARIO and old != new for old, new, _ in MISTAKES.values())


@pytest.mark.parametrize("script", sorted((ROOT / "scripts").glob("*.toml")), ids=lambda path: path.stem)
def test_shipped_scenario_is_ready_to_fly(script):
    simulation = nd.read_scenario(script).build()
    assert simulation.title == re.search('title = "(.*)"', script.read_text())[1]
    crossing = [f for f in simulation.findings if "pass through itself while opening" in f]
    # an accordion in two directions does; the scenario says so
    assert list(simulation.findings) == crossing
    assert bool(crossing) == (script.stem == "accordion_shot")
