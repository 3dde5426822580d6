"""The sections [target], [[target.parts]] and [[obstacles]]: what they make, and what is given where they are wrong."""

import tomllib
from contextlib import contextmanager

import numpy as np
import pytest
from pydantic import Field, ValidationError

from netdae.core.errors import InputError
from netdae.model.material import Cords, Material
from netdae.model.net import CableNet
from netdae.model.presets import PRESETS, preset_of
from netdae.model.shapes.part import Part, surface_of
from netdae.model.shapes.solids import Box, Plane, Sphere
from netdae.model.target import Obstacle, Target
from netdae.scenario.obstacles import ObstacleEntry, obstacles_of
from netdae.scenario.problems import bare, first_problem, section_in_words
from netdae.scenario.section import Section
from netdae.scenario.target import TargetEntry, target_of
from netdae.system.overlap import Knots, gaps, nearest, placed

PANEL = """\
[target]
mass = 100.0
friction = 0.1
[[target.parts]]
kind = "box"
size = [1.0, 1.0, 1.0]
[[target.parts]]
kind = "box"
size = [3.0, 1.0, 0.1]
position = [2.0, 0.0, 0.0]
attitude_deg = [90.0, 0.0, 0.0]
stiffness = 1e4
rounding = 0.01
"""


class Scenario(Section):
    """A scenario with nothing but these sections."""

    target: TargetEntry | None = None
    obstacles: list[ObstacleEntry] = Field([])


@contextmanager
def section(name, number=None, *, key=""):
    try:
        yield
    except InputError as error:
        raise InputError(f"{section_in_words(name, number)}: {bare(error)}") from error


def made(text, folder=None, size=5.0):
    data = tomllib.loads(text)
    try:
        entries = Scenario.model_validate(data)
    except ValidationError as error:
        raise InputError(first_problem(error, data)) from error
    return target_of(entries.target, folder, size, section), obstacles_of(
        entries.obstacles, folder, size, section
    )


def given(text, **options):
    with pytest.raises(InputError) as error:
        made(text, **options)
    assert "\n" not in str(error.value)
    return str(error.value)


def test_a_target_is_as_its_section_says():
    target, _ = made("""\
[target]
kind = "cylinder"
radius = 0.5
length = 2.0
motion = "free"
mass = 500.0
position = [0.0, 0.0, 3.0]
attitude_deg = [0.0, 90.0, 0.0]
velocity = [0.1, 0.0, -0.2]
spin_deg_s = [0.0, 0.0, 90.0]
friction = 0.2
exponent = 1.5
""")
    assert target.body is not None
    np.testing.assert_allclose(target.spin, [0.0, 0.0, np.pi / 2])
    # about the axis ½ m r², across it m (3 r² + l²)/12, about the cylinder's own axes
    np.testing.assert_allclose(target.body.inertia, [500 * 4.75 / 12, 500 * 4.75 / 12, 62.5])
    # its axis z points along x
    np.testing.assert_allclose(placed(target).axes @ [0, 0, 1], [1, 0, 0], atol=1e-15)
    assert (target.contact.friction, target.contact.exponent, target.contact.stiffness) == (0.2, 1.5, None)


def test_turns_are_those_of_the_net():
    target, _ = made('[target]\nkind = "sphere"\nradius = 1.0\nmass = 1.0\nattitude_deg = [90.0, 90.0, 0.0]')
    # x about the fixed x, then about the fixed y: y to z, then z to x
    np.testing.assert_allclose(placed(target).axes @ [0, 1, 0], [1, 0, 0], atol=1e-15)


def test_parts_have_contacts_of_their_own_where_they_say_so():
    target, _ = made(PANEL)
    assert [type(part.shape) for part in target.parts] == [Box, Box]
    assert target.contact_of(0).friction == target.contact_of(1).friction == 0.1
    assert (target.contact_of(0).stiffness, target.contact_of(1).stiffness) == (None, 1e4)
    assert target.parts[1].shape.rounding == 0.01
    # 100 kg over 1 + 0.3 m³
    np.testing.assert_allclose(target.centre, [2.0 * 0.3 / 1.3, 0.0, 0.0], atol=1e-15)
    weighed, _ = made(PANEL.replace("mass = 100.0\n", "").replace("kind =", "density = 10.0\nkind ="))
    assert weighed.body.mass == pytest.approx(13.0)


def test_inertia_is_given_by_its_moments_or_its_rows():
    head = '[target]\nkind = "sphere"\nradius = 1.0\nmass = 10.0\ncentre = [0.1, 0.0, 0.0]\n'
    moments, _ = made(head + "inertia = [3.0, 4.0, 5]")
    rows, _ = made(head + "inertia = [[3.0, 0.5, 0.0], [0.5, 4, 0.0], [0.0, 0.0, 5.0]]")
    np.testing.assert_array_equal(moments.body.inertia, [3.0, 4.0, 5.0])
    np.testing.assert_allclose(rows.body.tensor, [[3, 0.5, 0], [0.5, 4, 0], [0, 0, 5]], atol=1e-14)
    np.testing.assert_array_equal(rows.body.centre, [0.1, 0.0, 0.0])


def test_an_obstacle_is_fixed_where_it_is_put():
    _, (floor,) = made('[[obstacles]]\nkind = "plane"\nposition = [0.0, 0.0, -2.0]\nfriction = 0.5')
    assert isinstance(floor, Obstacle)
    assert isinstance(floor.part.shape, Plane)
    assert floor.contact.friction == 0.5


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_is_a_body(name):
    target, _ = made(f'[target]\npreset = "{name}"\nmotion = "free"')
    assert target.body.mass == preset_of(name).body.mass


def test_presets_have_their_published_sizes():
    def size(name):
        return np.ptp(surface_of(preset_of(name).parts).points, axis=0)

    np.testing.assert_allclose(size("cubesat_2u"), [0.1, 0.1, 0.227])
    np.testing.assert_allclose(size("zenit_stage")[2], 11.0)
    np.testing.assert_allclose(size("envisat")[:2], [26.0, 5.0])
    # the published inertia of Envisat beside that of its sizes: a body of 7490 kg and a panel of 338 kg
    body, _, panel = preset_of("envisat").parts
    across = 7490 * (10.5**2 + 2.75**2) / 12 + 7490 * body.position[0] ** 2
    across += 338 * 14**2 / 12 + 338 * panel.position[0] ** 2
    assert across == pytest.approx(preset_of("envisat").body.tensor[2, 2], rel=0.15)


def test_the_start_of_a_target_is_scattered():
    text = (
        SPHERE
        + "spread = { position = 0.1, velocity = 0.2, spin_deg_s = 3.0, attitude_deg = 5.0, member = %d }"
    )
    drawn = [made(text % member)[0] for member in range(200)]
    for name, deviation in (("position", 0.1), ("velocity", 0.2), ("spin", np.radians(3.0))):
        values = np.array([getattr(target, name) for target in drawn])
        # 600 draws: the standard error of a deviation is 3 %
        assert values.std() == pytest.approx(deviation, rel=0.1)
    assert len({tuple(target.attitude) for target in drawn}) == 200
    again = made(text % 7)[0]
    np.testing.assert_array_equal(again.position, drawn[7].position)


SPHERE = '[target]\nkind = "sphere"\nradius = 1.0\nmass = 10.0\n'
BOX = '[target]\nkind = "box"\nsize = [1.0, 1.0, 1.0]\nmass = 10.0\n'

WRONG = {
    "mass zero": (SPHERE.replace("mass = 10.0", "mass = 0"), "[target] mass is 0, expected a number above 0"),
    "no mass": (SPHERE.replace("mass = 10.0\n", ""), "it is free but has no mass"),
    "triangle inequality": (SPHERE + "inertia = [1.0, 1.0, 3.0]", "largest moment exceeds the sum"),
    "inertia not symmetric": (
        SPHERE + "inertia = [[1.0, 0.1, 0], [0.2, 1, 0], [0, 0, 1]]",
        "[target]: inertia is not symmetric: I_xy is 0.1 and I_yx is 0.2",
    ),
    "inertia of four": (SPHERE + "inertia = [1.0, 2.0, 3.0, 4.0]", "three principal moments, or three rows"),
    "negative friction": (SPHERE + "friction = -0.1", "[target] friction is -0.1, expected 0 or more"),
    "negative stiffness": (
        SPHERE + "stiffness = -1.0",
        "[target] stiffness is -1.0, expected a number above 0",
    ),
    "exponent": (SPHERE + "exponent = 2.0", "[target]: exponent is 2: give 1 or 1.5"),
    "rounding": (BOX + "rounding = 0.6", "[target]: box: rounding is 0.6 m, larger than the part"),
    "no parts": ("[target]\nparts = []", "[target]: it has no parts: give [[target.parts]]"),
    "no shape": ("[target]\nmass = 1.0", "it has no shape: give just one of kind, file, preset"),
    "two shapes": (SPHERE + 'preset = "envisat"', "kind and preset are given: give just one"),
    "unknown preset": ('[target]\npreset = "envisatt"', "did you mean envisat?"),
    "unknown kind": ('[target]\nkind = "spere"', "did you mean sphere?"),
    "size of another kind": (
        SPHERE + "length = 1.0",
        'length is no key of kind = "sphere", which has radius',
    ),
    "size that lacks": ('[target]\nkind = "capsule"\nradius = 1.0', "length is missing"),
    "part without a shape": (
        "[target]\n[[target.parts]]\nradius = 1.0",
        "[[target.parts]] 1: neither kind nor",
    ),
    "unknown key of a part": (
        PANEL + "frictoin = 1.0",
        "[[target.parts]] 2 frictoin is an unknown key: did you",
    ),
    "rounding of a part": (
        PANEL.replace("rounding = 0.01", "rounding = 0.2"),
        "[[target.parts]] 2: box: rounding",
    ),
    "mass twice": (PANEL + "mass = 3.0", "given for the target and for part 2"),
    "free plane": ('[target]\nkind = "plane"\nmass = 1.0', "no finite mass"),
    "fixed with a spin": (
        SPHERE + 'motion = "fixed"\nspin_deg_s = [0.0, 0.0, 1.0]',
        "fixed but has a velocity",
    ),
    "obstacle": (
        '[[obstacles]]\nkind = "box"\nsize = [1.0, -1.0, 1.0]',
        "[[obstacles]] 1: box: size along y is -1 m",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_one_line(name):
    text, words = WRONG[name]
    assert words in given(text)


def stl(tmp_path, points, triangles):
    lines = ["solid a"]
    for triangle in triangles:
        corners = "".join(f"vertex {x} {y} {z}\n" for x, y, z in points[list(triangle)])
        lines.append(f"facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet")
    (tmp_path / "body.stl").write_text("\n".join([*lines, "endsolid a\n"]))


def test_files_are_read_and_what_is_wrong_with_them_is_one_line(tmp_path):
    pytest.importorskip("trimesh")
    points, triangles = Box([1.0, 1.0, 1.0]).surface()
    text = '[target]\nfile = "body.stl"\nmass = 10.0\ncells = 16\n'
    stl(tmp_path, points, triangles)
    target, _ = made(text + "scale = 2.0", folder=tmp_path)
    assert target.body.inertia[0] == pytest.approx(10 * 8 / 12)
    stl(tmp_path, points, triangles[1:])
    assert "body.stl: the surface is open" in given(text, folder=tmp_path)
    stl(tmp_path, 1000 * points, triangles)
    assert "give scale = 0.001" in given(text, folder=tmp_path)
    assert "this is the format of a net" in given(text.replace(".stl", ".vtu"), folder=tmp_path)
    assert "nowhere.stl" in given(text.replace("body", "nowhere"), folder=tmp_path)


# Overlap at the start

RADIUS = 1e-3  # of the cords


def knots_of(net):
    cord = Material(youngs_modulus=1e9, density=1390.0, diameter=2 * RADIUS)
    return Knots.of(net, Cords.of(net, cord), np.ones(net.node_count, dtype=bool))


def test_the_nearest_point_of_a_net_is_found_on_a_cable():
    net = CableNet.square(side=1.0, cells=1)
    x = net.nodes + np.array([0.0, 0.0, 0.3])
    # the sphere is beside the middle of the side at y = 0.5
    target = Target((Part(Sphere(0.1)),), motion="fixed", position=(0.07, 0.6, 0.3))
    found = nearest(placed(target), x, knots_of(net))
    assert found.distance == pytest.approx(-RADIUS, abs=1e-6)
    np.testing.assert_allclose(found.point, [0.07, 0.5, 0.3], atol=1e-3)
    assert found.node == -1
    assert {tuple(x[node]) for node in net.cables[found.cable]} == {(-0.5, 0.5, 0.3), (0.5, 0.5, 0.3)}


def test_the_nearest_point_agrees_with_a_dense_search():
    rng = np.random.default_rng(3)
    net = CableNet.square(side=2.0, cells=4)
    body = Target(
        (Part(Box([0.3, 0.5, 0.7])), Part(Sphere(0.2), (0.3, 0.4, 0.0))),
        motion="fixed",
        position=(0.2, 0.1, 0.5),
        attitude=rng.normal(size=4),
    )
    s = np.linspace(0.0, 1.0, 2001)[:, None]
    for _ in range(5):
        x = net.nodes + rng.normal(size=net.nodes.shape) * 0.3
        found = nearest(placed(body), x, knots_of(net))
        points = np.concatenate([(1 - s) * x[i] + s * x[j] for i, j in net.cables])
        dense = gaps(placed(body), points).min()
        assert found.distance == pytest.approx(
            dense - RADIUS, abs=3e-3
        )  # its points are a 512th of a cable apart
        inside = np.count_nonzero(gaps(placed(body), x) < RADIUS)
        for i, j in net.cables:
            inside += gaps(placed(body), (1 - s) * x[i] + s * x[j]).min() < RADIUS
        assert found.inside == inside
