"""Packs: no cable is lengthened, no two knots meet, all fits the canister; against the geometry of the folds."""

from __future__ import annotations

import dataclasses
import itertools
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from numpy.random import default_rng
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist
from scipy.spatial.transform import Rotation

from netdae.core.errors import InputError
from netdae.initial.accordion import accordion, meander
from netdae.initial.canister import Canister, Plane, check_pack, stretch_of, taut_finding, together_finding
from netdae.initial.opening import crossings_of, opening_finding
from netdae.initial.star import star
from netdae.model.net import CableNet
from netdae.model.state import State

ROUND_OFF = 1e-12  # coordinates of metres, a few operations each

NETS = {
    "square": CableNet.square(side=5.0, cells=12),
    "square in pieces": CableNet.square(side=5.0, cells=6, subdivide=3),
    "rectangle": CableNet.rectangle(width=4.0, height=1.5, columns=11, rows=5),
    "hexagon": CableNet.hexagon(radius=3.0, rings=5),
    "hexagon in pieces": CableNet.hexagon(radius=3.0, rings=3, subdivide=2),
    "diamond": CableNet.diamond(side=5.0, cells=6),
    "radial": CableNet.radial(radius=3.0, rings=6, spokes=9),
    "radial of three spokes": CableNet.radial(radius=3.0, rings=5, spokes=3, subdivide=2),
}
WIDE = Canister(depth=0.4, side=20.0)


def with_other_lengths(net, low, high, seed=0):
    """The net with rest lengths that are random multiples, `low` to `high`, of the drawn ones."""
    factors = default_rng(seed).uniform(low, high, net.cable_count)
    return dataclasses.replace(net, rest_length=net.rest_length * factors)


def nearest(x):
    return cKDTree(x).query(x, k=2)[0][:, 1].min()


def assert_is_a_pack(net, start, canister, slack):
    stretch = stretch_of(net, start.x)
    assert stretch.max() <= 1 - slack + ROUND_OFF
    assert nearest(start.x) > 1e-5  # m, in packs of decimetres
    box = np.ptp(start.x, axis=0)
    assert box[2] <= canister.depth * (1 + 1e-9)
    if canister.side is not None:
        assert box[:2].max() <= canister.side * (1 + 1e-9)
    else:
        middle = start.x[net.nodes_of("corners"), :2].mean(axis=0)
        assert np.linalg.norm(start.x[:, :2] - middle, axis=1).max() <= canister.diameter / 2 * (1 + 1e-9)
    assert np.array_equal(start.v, np.zeros_like(start.x))


@pytest.mark.parametrize("name", NETS)
@pytest.mark.parametrize("lengths", [(1.0, 1.0), (0.7, 1.4)], ids=["as drawn", "other lengths"])
def test_no_cable_of_an_accordion_is_taut_and_no_knots_meet(name, lengths):
    net = with_other_lengths(NETS[name], *lengths)
    folds = [(1, 0), (0, 7), (4, 4), (9, 3), (2, 12)]
    for number, (some, slack) in enumerate(itertools.product(folds, (0.01, 0.2))):
        canister = dataclasses.replace(WIDE, depth=(0.4, 0.05)[number % 2])
        turned, start = accordion(net, canister, folds=some, slack=slack)
        assert_is_a_pack(turned, start, canister, slack)
        assert np.array_equal(turned.nodes, net.nodes)


@pytest.mark.parametrize("name", NETS)
@pytest.mark.parametrize("lengths", [(1.0, 1.0), (0.7, 1.4)], ids=["as drawn", "other lengths"])
def test_no_cable_of_a_star_is_taut_and_no_knots_meet(name, lengths):
    net = with_other_lengths(NETS[name], *lengths)
    for diameter, depth, slack in itertools.product((0.3, 1.1, 9.0), (0.05, 0.4, 3.0), (0.01, 0.2)):
        canister = Canister(depth=depth, diameter=diameter)
        assert_is_a_pack(*star(net, canister, slack=slack), canister, slack)


@pytest.mark.parametrize("name", NETS)
def test_a_star_brings_no_two_points_of_the_net_farther_apart(name):
    """Stronger than for cables: the bound in `stowing.star` holds for the whole map."""
    net = NETS[name]
    for diameter, pleats in ((0.5, None), (4.0, 5), (4.0, 9), (2.5, None)):
        _, start = star(net, Canister(depth=0.5, diameter=diameter), pleats=pleats, slack=0.05)
        assert (pdist(start.x) / pdist(net.nodes)).max() <= 0.95 + ROUND_OFF


def test_a_net_that_bulges_over_its_corners_is_folded_as_a_whole():
    """Middles of the sides 1.3 m from the centre, beside corners at 1 m along both axes."""
    round_about = [[1, 1], [0, 1.3], [-1, 1], [-1.3, 0], [-1, -1], [0, -1.3], [1, -1], [1.3, 0], [0, 0]]
    cables = [*([i, (i + 1) % 8] for i in range(8)), *([i, 8] for i in range(8))]
    net = CableNet(np.insert(np.array(round_about), 2, 0.0, axis=1), cables, {"corners": [0, 2, 4, 6]})
    canister = Canister(depth=0.2, diameter=0.3)
    assert_is_a_pack(*star(net, canister), canister, 0.01)


def test_a_star_has_its_corners_out_its_sides_in_and_keeps_azimuths():
    net = CableNet.square(side=4.0, cells=8)
    canister = Canister(depth=0.3, diameter=1.2)
    _, start = star(net, canister, pleats=5, slack=0.01)
    flat, rho = np.linalg.norm(net.nodes, axis=1), np.linalg.norm(start.x[:, :2], axis=1)
    inner = flat > 0
    turn = np.arctan2(net.nodes[inner, 1], net.nodes[inner, 0]) - np.arctan2(
        start.x[inner, 1], start.x[inner, 0]
    )
    assert np.abs(np.sin(turn)).max() < ROUND_OFF
    corners = net.nodes_of("corners")
    middles = np.flatnonzero(
        np.isclose(np.abs(net.nodes).sum(axis=1), 2) & (np.abs(net.nodes).max(axis=1) > 1.99)
    )
    # a = 1.98 m after slack, u = 0.6/1.98, H = 0.3 m, γ = 45°; A₁ by the module's formula
    a, u, h = 1.98, 0.6 / 1.98, 0.3 / 1.98
    amplitude = a * math.pi / 4 / 5 * (math.sqrt(1 - u**2 - h**2) - u)
    assert rho[corners] == pytest.approx(0.6, abs=ROUND_OFF)
    assert rho[middles] == pytest.approx(0.6 - amplitude, abs=ROUND_OFF)
    assert start.x[net.nodes_of("border"), 2] == pytest.approx(0.3, abs=ROUND_OFF)
    assert start.x[net.nodes_of("centre"), 2] == pytest.approx(0.0, abs=ROUND_OFF)


@pytest.mark.parametrize("name", NETS)
def test_the_axis_of_a_star_stands_on_the_middle_of_the_corners(name):
    net = NETS[name].with_nodes(NETS[name].nodes + np.array([0.3, -2.0, 0.7]))
    _, start = star(net, Canister(depth=0.3, diameter=0.9))
    corners = net.nodes_of("corners")
    middle = net.nodes[corners].mean(axis=0)
    assert start.x[corners].mean(axis=0) == pytest.approx(np.array([0, 0, 0.3]) + middle, abs=1e-9)
    reach = np.linalg.norm((start.x[corners] - middle)[:, :2], axis=1)
    assert reach == pytest.approx(reach[0], abs=1e-9)


@pytest.mark.parametrize("panels", [1, 2, 5, 6])
def test_a_folded_band_keeps_its_lengths(panels):
    """With no gap there is no tilt, and each layer is an isometry but at the corners of its turns."""
    rng = default_rng(panels)
    width, thickness = 0.7, 0.09
    length = panels * width + (panels - 1) * 2 * thickness
    for c in (0.0, 0.03, thickness):
        s = np.sort(rng.uniform(0, length, 20001))
        along, up = meander(s, np.full_like(s, c), width=width, gap=0.0, thickness=thickness, panels=panels)
        path = np.hypot(np.diff(along), np.diff(up))
        assert (path <= np.diff(s) + ROUND_OFF).all()
        # a chord over each of the 2 (panels − 1) corners is shorter by less than the mean step, 5e-5 · length
        assert path.sum() == pytest.approx(length, abs=2 * panels * 10 * length / 20000)


def test_layers_of_a_folded_band_keep_their_distance():
    """Layers h apart in the band, and panels h apart, never come nearer than h, nor at the nested turns."""
    width, gap, layers, panels = 0.5, 0.01, 4, 5
    thickness = (layers - 1) * gap
    length = panels * width + (panels - 1) * (gap + 2 * thickness)
    s, layer = np.meshgrid(np.linspace(0, length, 4001), np.arange(layers))
    along, up = meander(
        s.ravel(), gap * layer.ravel(), width=width, gap=gap, thickness=thickness, panels=panels
    )
    points = np.column_stack([along, up])
    step = length / 4000
    i, j = cKDTree(points).query_pairs(0.95 * gap, output_type="ndarray").T
    # all that is nearer belongs to one layer and is near on it too; √2 round a corner, gap round a fold
    assert (layer.ravel()[i] == layer.ravel()[j]).all()
    assert np.abs(s.ravel()[i] - s.ravel()[j]).max() <= math.sqrt(2) * gap + step


def test_an_accordion_is_as_large_as_its_panels():
    net = CableNet.square(side=5.0, cells=10, subdivide=25)  # knots every 2 cm
    gap, slack = 0.002, 0.01
    _, start = accordion(net, WIDE, folds=(4, 6), gap=gap, slack=slack)
    box = np.ptp(start.x, axis=0)
    band = 4 * gap + 0.1 * 5 * gap  # four gaps, and the tilt of five panels
    wide = (5.0 * (1 - slack) - 4 * gap) / 5
    high = (5.0 * (1 - slack) - 6 * (gap + 2 * band)) / 7 + 2 * band
    # drawn together a little more where cables cross folds, 2h in 2 cm at worst; knots need not stand at the turns
    assert box[0] == pytest.approx(wide, abs=0.005)
    assert box[1] == pytest.approx(high, abs=0.005)
    assert box[2] == pytest.approx(7 * band + 6 * gap + 0.1 * 7 * gap, abs=gap)


def test_cables_between_folds_keep_their_length_in_an_accordion():
    """The pack is folded, not shrunk: most cables along the folds are as long as slack lets them be."""
    net = CableNet.square(side=5.0, cells=20)
    _, start = accordion(net, WIDE, folds=(4, 0), slack=0.01)
    along_y = np.abs(net.spans[:, 1]) > 0
    assert np.allclose(stretch_of(net, start.x)[along_y], 0.99, atol=1e-3)
    assert np.median(stretch_of(net, start.x)[~along_y]) > 0.985


def test_pitch_is_the_largest_distance_of_folds():
    net = CableNet.rectangle(width=4.0, height=1.0, columns=8, rows=4)
    for pitch, folds in (((0.5, 9.0), (7, 0)), ((0.51, 0.4), (7, 2)), ((4.0, 0.25), (0, 3))):
        assert np.array_equal(accordion(net, WIDE, pitch=pitch)[1].x, accordion(net, WIDE, folds=folds)[1].x)


def test_rotation_turns_the_open_net_too_and_velocity_is_the_whole_nets():
    net = NETS["hexagon"]
    turn = Rotation.from_euler("xyz", [20.0, -30.0, 70.0], degrees=True)
    for fold in (
        lambda **keys: accordion(net, WIDE, folds=(3, 2), **keys),
        lambda **keys: star(net, Canister(depth=0.3, diameter=0.8), **keys),
    ):
        _, plain = fold()
        turned, start = fold(rotation_deg=(20.0, -30.0, 70.0), velocity=(1.0, 2.0, 3.0))
        assert np.allclose(start.x, turn.apply(plain.x), atol=ROUND_OFF)
        assert np.allclose(turned.nodes, turn.apply(np.array(net.nodes)), atol=ROUND_OFF)
        assert np.array_equal(turned.rest_length, net.rest_length)
        assert (start.v == [1.0, 2.0, 3.0]).all()


def test_a_net_in_any_plane_is_folded_in_its_plane():
    net = NETS["rectangle"]
    turn = Rotation.from_euler("xyz", [50.0, 20.0, 10.0], degrees=True)
    aside = net.with_nodes(np.array([3.0, -2.0, 1.0]) + turn.apply(np.array(net.nodes)))
    for fold in (
        lambda net: accordion(net, Canister(depth=0.2, side=9.0), folds=(3, 2)),
        lambda net: star(net, Canister(depth=0.2, diameter=0.5)),
    ):
        plain, pack = fold(net)[1].x, fold(aside)[1].x
        assert nearest(pack) > 1e-5
        assert stretch_of(aside, pack).max() <= 0.99 + ROUND_OFF
        # in the plane of the mesh the pack is as wide as that of the net in xy, or a little different where
        # its axes, x of space laid on the plane, cross the net askew
        assert np.ptp((pack @ turn.as_matrix())[:, 2]) == pytest.approx(np.ptp(plain[:, 2]), rel=0.2)
    assert Plane.of(net).axes == pytest.approx(np.eye(3))


def test_reported_sizes_are_enough_and_less_is_not():
    net = CableNet.square(side=5.0, cells=10)
    cases = [
        (lambda size: accordion(net, Canister(depth=0.3, side=size), folds=(5, 3)), "side"),
        (lambda size: accordion(net, Canister(depth=0.3, diameter=size), folds=(9, 0)), "diameter"),
        (lambda size: accordion(net, Canister(depth=size, side=5.0), folds=(9, 9), gap=0.004), "depth"),
        (
            lambda size: accordion(net, Canister(depth=size, side=5.0), folds=(9, 9), cord_diameter=0.01),
            "depth",
        ),
        (lambda size: star(net, Canister(depth=0.3, diameter=size), pleats=11), "diameter"),
        (lambda size: star(net, Canister(depth=0.3, side=size), pleats=11, cord_diameter=0.004), "side"),
        (lambda size: star(net, Canister(depth=0.3, side=size), cord_diameter=0.004), "side"),
    ]
    for fold, key in cases:
        with pytest.raises(InputError) as caught:
            fold(0.02)
        line = str(caught.value)
        assert "\n" not in line
        (reported,) = re.findall(rf"give a {key} of ([0-9.]+) m at least", line)
        fold(float(reported))
        with pytest.raises(InputError, match=rf"give a {key} of {reported} m at least"):
            fold(0.998 * float(reported))  # the size is reported in four digits


def test_a_round_canister_holds_the_accordion_that_it_is_reported_for():
    net = CableNet.square(side=5.0, cells=10)
    with pytest.raises(InputError, match="give a diameter") as caught:
        accordion(net, Canister(depth=0.3, diameter=0.1), folds=(7, 5))
    reported = float(re.findall(r"give a diameter of ([0-9.]+) m", str(caught.value))[0])
    x = accordion(net, Canister(depth=0.3, diameter=reported), folds=(7, 5))[1].x[:, :2]
    reach = np.linalg.norm(x - (x.min(axis=0) + x.max(axis=0)) / 2, axis=1).max()
    assert reported / 2 * 0.998 < reach <= reported / 2
    assert x.min(axis=0) == pytest.approx(-x.max(axis=0), abs=ROUND_OFF)  # in the middle of the canister


def test_a_star_takes_the_fewest_pleats_that_fit_and_more_are_narrower():
    net = CableNet.hexagon(radius=3.0, rings=6)
    canister = Canister(depth=0.3, diameter=0.3)
    sizes = []
    for pleats in (1, 3, 5, 7, 9, 11):
        try:
            fits = star(net, canister, pleats=pleats)[1].x
            break
        except InputError as error:
            sizes.append(float(re.findall(r"give a diameter of ([0-9.]+) m at least", str(error))[0]))
    assert np.array_equal(star(net, canister)[1].x, fits)
    assert sizes == sorted(sizes, reverse=True)
    assert 2 <= len(sizes) <= 5


def test_knots_share_a_place_only_when_asked():
    net = CableNet.square(side=4.0, cells=8)
    with pytest.raises(
        InputError, match=r"knots share a place with another, first nodes 0 and 72: .*coincide"
    ):
        accordion(net, WIDE, folds=(1, 0), gap=0.0)
    _, start = accordion(net, WIDE, folds=(1, 0), gap=0.0, coincide=True)
    assert nearest(start.x) == 0.0
    assert stretch_of(net, start.x).max() <= 0.99 + ROUND_OFF


def test_checks_name_the_worst_cable_with_strain_and_rest_length():
    net = NETS["square"]
    x = np.array(net.nodes)
    assert taut_finding(net, x) == ""  # straight, not taut
    x[0] -= [0.1, 0.0, 0.0]
    worst = int(np.flatnonzero((net.cables == [0, 13]).all(axis=1) | (net.cables == [13, 0]).all(axis=1))[0])
    rest = 5.0 / 12
    strain = ((rest + 0.1) ** 2 / rest**2 - 1) / 2
    words = (
        f"worst cable {worst} between nodes 0 and 13: strain {strain:.3g} over its rest length {rest:.6g} m"
    )
    with pytest.raises(InputError, match=re.escape(words)):
        check_pack(net, x, shape="pack", coincide=False)
    x = 0.5 * net.nodes
    x[7] = x[100]
    assert "first nodes 7 and 100" in together_finding(net, x)


@pytest.mark.parametrize("name", NETS)
def test_stars_and_single_accordions_open_without_passing_through_themselves(name):
    net = NETS[name]
    packs = [
        star(net, Canister(depth=0.3, diameter=0.6)),
        star(net, Canister(depth=0.3, diameter=2.9), rotation_deg=(10.0, 20.0, 30.0)),
        (net, State.at(0.3 * net.nodes)),
    ]
    if (
        name != "radial of three spokes"
    ):  # its longest cables reach straight over several panels, through others
        packs.append(accordion(net, WIDE, folds=(5, 0)))
        packs.append(accordion(net, WIDE, folds=(0, 4), rotation_deg=(10.0, 20.0, 30.0)))
    for turned, start in packs:
        assert opening_finding(turned, start) == ""


def test_a_double_accordion_is_warned_of():
    turned, start = accordion(CableNet.square(side=5.0, cells=12), WIDE, folds=(5, 5))
    assert re.fullmatch(
        r"the pack would pass through itself while opening: on straight lines to the open net \d+ pairs of cables "
        r"cross, first cables \d+ and \d+ at \d+ % of the way; contact of the net with itself is not modelled",
        opening_finding(turned, start),
    )


@pytest.mark.parametrize("way", [0.02, 0.3, 0.95])
def test_a_crossing_is_found_where_two_cables_meet(way):
    """A cable along y falls through one along x."""
    pack = np.array([[-1, 0, 0], [1, 0, 0], [0.3, -1, way], [0.3, 1, way]])
    flat = np.array([[-1, 0, 0], [1, 0, 0], [0.3, -1, way - 1], [0.3, 1, way - 1]])
    net = CableNet(flat, [[0, 1], [2, 3]])
    found = crossings_of(net, State.at(np.array([0, 0, 5.0]) + pack))  # both are seen about their own middle
    assert (found.pairs, found.tested, found.first) == (1, 2, (0, 1))
    assert found.way == pytest.approx(way, abs=1e-9)
    turned = crossings_of(CableNet(flat, [[1, 0], [2, 3]]), State.at(pack))  # V has the other sign
    assert turned.way == pytest.approx(way, abs=1e-9)
    beside = np.array([[0, 0, 0], [0, 0, 0], [1.0, 0, 0], [1.0, 0, 0]])
    assert crossings_of(CableNet(flat + beside, [[0, 1], [2, 3]]), State.at(pack + beside)).pairs == 0
    assert crossings_of(CableNet(flat, [[0, 1], [1, 2], [2, 3]]), State.at(pack)).pairs == 1


def test_the_first_crossing_of_a_pack_is_a_place_where_its_cables_meet():
    turned, start = accordion(CableNet.hexagon(radius=3.0, rings=4), WIDE, folds=(4, 5))
    found = crossings_of(turned, start)
    assert found.pairs > 0
    pack, flat = start.x - start.x.mean(axis=0), turned.nodes - turned.nodes.mean(axis=0)
    x = (1 - found.way) * pack + found.way * flat
    share = np.linspace(0, 1, 2001)[:, None]
    lines = [x[i] * (1 - share) + x[j] * share for i, j in turned.cables[list(found.first)]]
    gap = cKDTree(lines[0]).query(lines[1])[0].min()
    assert gap < 1e-3  # cables of 0.75 m, looked at 2001 times each


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Canister(depth=0.3), "give a diameter for a round one or a side for a square one"),
        (lambda: Canister(depth=0.3, side=1.0, diameter=1.0), "one of the two"),
        (lambda: Canister(depth=-0.3, side=1.0), "canister: depth is -0.3 m: give a length above zero"),
        (lambda: accordion(NETS["square"], WIDE), "give folds, their number along both directions, or pitch"),
        (lambda: accordion(NETS["square"], WIDE, folds=(0, 0)), "no folds in either direction"),
        (lambda: accordion(NETS["square"], WIDE, folds=(-1, 3)), "-1 folds along the first direction"),
        (lambda: accordion(NETS["square"], WIDE, pitch=(1e-9, 1)), "folds along the first direction: give 0 to"),
        (lambda: accordion(NETS["square"], Canister(depth=20, side=9), folds=(900, 0), gap=1e-2), "leave no panel of"),
        (lambda: accordion(NETS["square"], WIDE, folds=(3, 3), gap=1e-3, cord_diameter=2e-3), "less than the cord"),
        (
            lambda: accordion(NETS["square"], Canister(depth=9.0, side=9.0), folds=(1, 1), gap=0.45),
            "layers 0.45 m apart tighten cable 29, which is 0.417 m long",
        ),
        (lambda: accordion(NETS["square"], WIDE, folds=(3, 3), slack=0.6), "slack is 0.6"),
        (lambda: star(NETS["square"], WIDE, pleats=4), "pleats is 4: give an odd whole number"),
        (lambda: star(NETS["square"], WIDE, corners="all"), "are not the corners of a convex polygon"),
        (lambda: star(NETS["hexagon"], WIDE, corners="centre"), "has 1 nodes: a star needs three"),
        (lambda: star(NETS["square"], WIDE, corners="rim"), "no node group 'rim'"),
        (
            lambda: star(NETS["square"].with_nodes(NETS["square"].nodes * [1, 1, 0] + [0, 0, 1]
                         * np.arange(169)[:, None] ** 2 * 1e-4), WIDE),
            "off the plane of the net, but only a flat net can be folded",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_folded_is_one_clear_line(call, words):
    with pytest.raises(InputError) as caught:
        call()
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_net_of_many_cables_is_tested_in_part():
    net = CableNet.square(side=5.0, cells=30)  # 1860 cables
    turned, start = accordion(net, WIDE, folds=(5, 5))
    assert "of 1500 tested" in opening_finding(turned, start)


def test_pictures_show_all_shapes(tmp_path):
    script = Path(__file__).resolve().parent.parent / "scripts" / "stowed_pictures.py"
    environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    for folder, code in ((tmp_path / "new", 0), (script, 2)):
        done = subprocess.run(
            [sys.executable, str(script), str(folder)], capture_output=True, text=True, env=environment
        )
        assert (done.returncode, done.stdout, len(done.stderr.splitlines())) == (code, "", code // 2)
    for name in ("scaled", "accordion", "star"):
        pixels = matplotlib.image.imread(tmp_path / "new" / f"stowed_{name}.png")[..., :3]
        inked = (np.abs(pixels - 1.0) > 0.1).any(axis=-1)
        for half in np.split(inked, 2, axis=1):
            assert half.mean() > 0.03
            assert not half[[0, -1]].any()  # nothing is cut off
            assert not half[:, [0, -1]].any()
