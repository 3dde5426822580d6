"""Exactly symmetric starts are found, and those that only look so are not; a disturbance cures them."""

from __future__ import annotations

import json

import numpy as np
import pytest
import shots

import netdae as nd
from netdae.cli import main
from netdae.forces.loads import Gravity, NodalLoad
from netdae.initial.disturbed import disturbed
from netdae.initial.scaled import ejected, scaled
from netdae.model.motions import TableMotion
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.system.symmetry import symmetry_of

CORD = nd.Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)
NETS = {
    "square": nd.CableNet.square(side=1.0, cells=4),
    "rectangle": nd.CableNet.rectangle(width=2.0, height=1.0, columns=4, rows=2),
    "hexagon": nd.CableNet.hexagon(radius=1.0, rings=3),
    "radial": nd.CableNet.radial(radius=1.0, rings=3, spokes=7),
}


def shot(net, *, speed=2.0, turned=(0.0, 0.0, 0.0), **more):
    net, start = scaled(net, (0.5, 0.5, 1.0), rotation_deg=turned)
    axis = {"axis": tuple(nd_axis(turned))}
    group = "corners" if "corners" in net.node_groups else "border"
    start = ejected(net, start, group, speed=speed, half_angle_deg=45.0, **axis)
    masses = more.pop("masses", {group: 0.1})
    return nd.System(net, CORD, masses=masses, damping=nd.Dashpot(viscosity_time=1e-5), **more), start


def nd_axis(turned):
    """The z axis of the mesh, turned as its nodes are."""
    net, _ = scaled(nd.CableNet([[0, 0, 0], [0, 0, 1.0]], [[0, 1]]), (1.0, 1.0, 1.0), rotation_deg=turned)
    return net.nodes[1] - net.nodes[0]


@pytest.mark.parametrize("turned", [(0.0, 0.0, 0.0), (17.0, -40.0, 65.0)])
@pytest.mark.parametrize("name", NETS)
def test_a_regular_net_that_is_shot_by_its_corners_is_symmetric_however_it_is_turned(name, turned):
    system, start = shot(NETS[name], turned=turned)
    assert symmetry_of(system, start, 1.0) is not None


def corner_of(net, number=0):
    return int(net.nodes_of("corners")[number])


SQUARE = NETS["square"]
MOVES = TableMotion(np.array([0.0, 1.0]), np.array([(0.0, 0, 0), (0.3, 0.1, 0.2)]), interpolation="linear")
ALONG = TableMotion(np.array([0.0, 1.0]), np.array([(0.0, 0, 0), (0.0, 0.0, 0.2)]), interpolation="linear")
KEPT = {
    "gravity along the axis": {"loads": [Gravity((0.0, 0.0, -9.81))]},
    "gravity along a side": {"loads": [Gravity((3.0, 0.0, -9.81))]},
    "a pull in the middle": {"loads": [NodalLoad("centre", (0.0, 0.0, 5.0))]},
    "a held corner": {"restraints": [Restraint((corner_of(SQUARE),))]},
    "a middle moved along the axis": {"restraints": [Restraint("centre", motion=ALONG)]},
    "all corners released at once": {"restraints": [Restraint("corners", until=0.1)]},
}
BROKEN = {
    "gravity askew": {"loads": [Gravity((3.0, 1.0, -9.81))]},
    "a pull askew": {"loads": [NodalLoad("centre", (2.0, 1.0, 5.0))]},
    "a pull askew that comes later": {"loads": [NodalLoad("centre", lambda t: (2.0 * t, 1.0 * t, 5.0))]},
    "a held corner and a border node": {"restraints": [Restraint((corner_of(SQUARE),)), Restraint((1,))]},
    "a middle moved askew": {"restraints": [Restraint("centre", motion=MOVES)]},
    "corners released one after the other": {
        "restraints": [Restraint((corner_of(SQUARE, k),), until=0.1 * (k + 1)) for k in range(4)]
    },
    "an axis that is held": {"restraints": [Restraint((6,), axes="x")]},
}


@pytest.mark.parametrize("what", KEPT)
def test_what_acts_alike_on_both_sides_keeps_a_symmetry(what):
    system, start = shot(SQUARE, **KEPT[what])
    assert symmetry_of(system, start, 1.0) == "a mirror plane"


@pytest.mark.parametrize("what", BROKEN)
def test_what_acts_on_one_side_only_ends_it(what):
    system, start = shot(SQUARE, **BROKEN[what])
    assert symmetry_of(system, start, 1.0) is None


def test_masses_speeds_and_stiffer_cords_count():
    odd = np.flatnonzero((np.sort(SQUARE.cables, axis=1) == [0, 1]).all(axis=1))  # from a corner along a side
    net = nd.CableNet(
        SQUARE.nodes, SQUARE.cables, {**SQUARE.node_groups, "odd": [1]}, {**SQUARE.cable_groups, "odd": odd}
    )
    system, start = shot(net, masses={"corners": 0.1, "odd": 1e-6})
    assert symmetry_of(system, start, 1.0) is None
    system, start = shot(net)
    v = start.v.copy()
    v[1, 2] += 1e-9
    assert symmetry_of(system, State.at(start.x, v), 1.0) is None
    stiff = nd.Material(youngs_modulus=71e9, density=1390.0, diameter=1e-3)
    system = nd.System(
        net, {"all": CORD, "odd": stiff}, masses={"corners": 0.1}, damping=nd.Dashpot(viscosity_time=1e-5)
    )
    assert symmetry_of(system, start, 1.0) is None


def test_a_nanometre_ends_it():
    system, start = shot(SQUARE)
    assert symmetry_of(system, disturbed(start, 1e-9, 0, system.restrained), 1.0) is None


def test_a_turned_net_without_mirrors_is_symmetric_by_turns():
    """Velocities along the border: a whirl has no mirror across the net, but the one in its plane and all turns."""
    net = NETS["hexagon"]
    system = nd.System(net, CORD, damping=nd.NoDamping(), masses={"corners": 0.1})
    v = np.cross([0.0, 0.0, 1.0], net.nodes) + np.array([0.0, 0.0, 1.0])
    assert symmetry_of(system, State.at(0.8 * net.nodes, v), 1.0) == "a turn by 60° about its middle"


def test_chains_are_left_alone():
    net = nd.CableNet([[0, 0, 0], [0, 0, -1.0], [0, 0, -2.0]], [[0, 1], [1, 2]], {"top": [0]})
    system = nd.System(net, CORD, damping=nd.NoDamping(), restraints=[Restraint("top")])
    assert symmetry_of(system, State.at(net.nodes), 1.0) is None


SCENARIO = shots.shot(
    title="small",
    youngs_modulus="70e9",
    viscosity_time="1e-5",
    mass=0.1,
    scale=0.5,
    speed=2.0,
    half_angle_deg=90.0,
    sections='[[restraints]]\ngroup = "centre"\naxes = "z"\n',
    method="explicit",
    end=0.3,
    accuracy=None,
    frames=3,
)
WITH = SCENARIO.replace("[initial]\n", "[initial]\ndisturbance = 1e-6\ndisturbance_seed = 5\n")


def written(folder, text):
    file = folder / "small.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_run_warns_of_it_and_names_the_key_that_cures_it(tmp_path, capsys):
    for text, count in ((SCENARIO, 1), (WITH, 0)):
        assert main(["run", str(written(tmp_path, text)), "-o", str(tmp_path / "out"), "--overwrite"]) == 0
        warnings = json.loads((tmp_path / "out/summary.json").read_text(encoding="utf-8"))["warnings"]
        assert len([each for each in warnings if "exactly symmetric" in each]) == count
        assert capsys.readouterr().out.count("set disturbance = 1e-6 (m) in [initial]") == count


def test_a_disturbance_moves_free_coordinates_by_its_deviation(tmp_path):
    plain, moved = (nd.read_scenario(written(tmp_path, text)).build() for text in (SCENARIO, WITH))
    d = moved.start.x - plain.start.x
    held = plain.system.restrained
    assert (d[held] == 0).all()
    # a standard deviation of 74 numbers is within a third of its value, four times its own
    assert d[~held].std() == pytest.approx(1e-6, rel=0.33)
    np.testing.assert_array_equal(moved.start.v, plain.start.v)
    np.testing.assert_array_equal(moved.system.net.nodes, plain.system.net.nodes)
    other = nd.read_scenario(written(tmp_path, WITH.replace("seed = 5", "seed = 6"))).build()
    assert (other.start.x != moved.start.x)[~held].all()
