"""Generated nets against formulas of plane geometry and graphs."""

import math

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from netdae.core.errors import InputError
from netdae.model import patterns
from netdae.model.net import CableNet

SQRT2, SQRT3 = math.sqrt(2), math.sqrt(3)


def polygon_area(sides, radius):
    return sides / 2 * radius**2 * math.sin(2 * math.pi / sides)


# by formula: nodes, meshes, total length, enclosed area, border cables, corners, centre nodes
CASES = {
    "square": (patterns.square, {"side": 5.0, "cells": 20}, 441, 400, 2 * 21 * 5.0, 25.0, 80, 4, 1),
    "square_odd": (patterns.square, {"side": 3.0, "cells": 3}, 16, 9, 24.0, 9.0, 12, 4, 4),
    "square_one": (patterns.square, {"side": 2.0, "cells": 1}, 4, 1, 8.0, 4.0, 4, 4, 4),
    "rectangle": (
        patterns.rectangle,
        {"width": 4.0, "height": 1.5, "columns": 5, "rows": 2},
        18, 10, 3 * 4.0 + 6 * 1.5, 6.0, 14, 4, 2,
    ),
    "hexagon": (
        patterns.hexagon,
        {"radius": 2.0, "rings": 4},
        3 * 4 * 5 + 1, 6 * 4**2, (9 * 16 + 12) * 0.5, 1.5 * SQRT3 * 4, 24, 6, 1,
    ),
    "hexagon_one": (patterns.hexagon, {"radius": 1.0, "rings": 1}, 7, 6, 12.0, 1.5 * SQRT3, 6, 6, 1),
    "radial": (
        patterns.radial,
        {"radius": 3.0, "rings": 4, "spokes": 7},
        29, 28, 7 * 3.0 + 7 * 2 * math.sin(math.pi / 7) * 3.0 * 5 / 2, polygon_area(7, 3.0), 7, 7, 1,
    ),
    "radial_least": (
        patterns.radial,
        {"radius": 1.0, "rings": 1, "spokes": 3},
        4, 3, 3 + 3 * SQRT3, polygon_area(3, 1.0), 3, 3, 1,
    ),
    "diamond": (
        patterns.diamond,
        {"side": 5.0, "cells": 6},
        7**2 + 6**2, 2 * 6 * 7, 4 * 5.0 + 2 * SQRT2 * 6 * 5.0, 25.0, 24, 4, 1,
    ),
    "diamond_one": (patterns.diamond, {"side": 1.0, "cells": 1}, 5, 4, 4 + 2 * SQRT2, 1.0, 4, 4, 1),
}  # fmt: skip


@pytest.fixture(params=CASES)
def case(request):
    return CASES[request.param]


def lengths(pattern):
    return np.linalg.norm(pattern.nodes[pattern.cables[:, 1]] - pattern.nodes[pattern.cables[:, 0]], axis=1)


def enclosed_area(points):
    following = np.roll(points, -1, axis=0)
    return 0.5 * np.sum(points[:, 0] * following[:, 1] - points[:, 1] * following[:, 0])


def test_nodes_and_cables_obey_euler(case):
    make, arguments, nodes, meshes, *_ = case
    pattern = make(**arguments)
    assert len(pattern.nodes) == nodes
    # Euler's formula of a connected plane graph, the outer face not counted
    assert len(pattern.nodes) - len(pattern.cables) + meshes == 1


@pytest.mark.parametrize("pieces", [1, 2, 5])
def test_total_length_is_that_of_the_formula_however_subdivided(case, pieces):
    make, arguments, nodes, _, total, *_ = case
    whole, cut = make(**arguments), make(**arguments, subdivide=pieces)
    # sums of at most some thousand rounded lengths
    assert lengths(cut).sum() == pytest.approx(total, rel=1e-12)
    assert len(cut.cables) == pieces * len(whole.cables)
    assert len(cut.nodes) == nodes + (pieces - 1) * len(whole.cables)
    np.testing.assert_allclose(lengths(cut), np.repeat(lengths(whole), pieces) / pieces, rtol=1e-12)


@pytest.mark.parametrize("pieces", [1, 3])
def test_border_is_one_loop_anticlockwise_around_the_right_area(case, pieces):
    make, arguments, _, _, _, area, edge, *_ = case
    pattern = make(**arguments, subdivide=pieces)
    loop = pattern.cables[pattern.cable_groups["border"]]
    assert len(loop) == edge * pieces
    np.testing.assert_array_equal(loop[:, 1], np.roll(loop[:, 0], -1))
    assert len(np.unique(loop[:, 0])) == len(loop)
    np.testing.assert_array_equal(np.unique(loop), pattern.node_groups["border"])
    assert enclosed_area(pattern.nodes[loop[:, 0]]) == pytest.approx(area, rel=1e-12)


@pytest.mark.parametrize("pieces", [1, 4])
def test_net_is_one_piece_without_coincident_nodes_or_double_cables(case, pieces):
    make, arguments, *_ = case
    pattern = make(**arguments, subdivide=pieces)
    count = len(pattern.nodes)
    graph = coo_array((np.ones(len(pattern.cables)), pattern.cables.T), shape=(count, count))
    assert connected_components(graph, directed=False)[0] == 1
    gap = lengths(make(**arguments)).min() / pieces / 100
    assert len(np.unique(np.round(pattern.nodes / gap), axis=0)) == count
    assert len(np.unique(np.sort(pattern.cables, axis=1), axis=0)) == len(pattern.cables)
    assert np.all(pattern.nodes[:, 2] == 0)


@pytest.mark.parametrize("pieces", [1, 3])
def test_groups_hold_what_their_names_say(case, pieces):
    make, arguments, nodes, *_, corners, centres = case
    pattern = make(**arguments, subdivide=pieces)
    radius = np.linalg.norm(pattern.nodes, axis=1)
    assert len(pattern.node_groups["corners"]) == corners
    np.testing.assert_allclose(radius[pattern.node_groups["corners"]], radius.max(), rtol=1e-12)
    assert np.isin(pattern.node_groups["corners"], pattern.node_groups["border"]).all()
    area = enclosed_area(pattern.nodes[pattern.node_groups["corners"]])
    assert area == pytest.approx(case[5], rel=1e-12)  # in this order, so they go round anticlockwise
    assert len(pattern.node_groups["centre"]) == centres
    np.testing.assert_allclose(
        radius[pattern.node_groups["centre"]], radius[:nodes].min(), atol=1e-12 * radius.max()
    )
    both = np.concatenate([pattern.cable_groups["border"], pattern.cable_groups["inner"]])
    np.testing.assert_array_equal(np.sort(both), np.arange(len(pattern.cables)))


@pytest.mark.parametrize(
    ("make", "arguments"),
    [
        (CableNet.square, {"side": 5.0, "cells": 4}),
        (CableNet.rectangle, {"width": 2.0, "height": 1.0, "columns": 3, "rows": 2}),
        (CableNet.hexagon, {"radius": 1.0, "rings": 2}),
        (CableNet.radial, {"radius": 1.0, "rings": 2, "spokes": 5}),
        (CableNet.diamond, {"side": 1.0, "cells": 3}),
    ],
)
def test_net_is_made_of_the_pattern(make, arguments):
    net = make(**arguments, subdivide=2)
    assert set(net.node_groups) == {"all", "border", "corners", "centre"}
    assert set(net.cable_groups) == {"all", "border", "inner"}


def test_square_net_is_its_own_mirror_image_to_the_last_bit():
    nodes = patterns.square(side=5.0, cells=7, subdivide=3).nodes
    for turned in (nodes * [-1, 1, 1], nodes[:, [1, 0, 2]]):
        a, b = (np.unique(points + 0.0, axis=0) for points in (nodes, turned))
        # knots within a cable are weighted means, one rounding apart
        np.testing.assert_allclose(
            a[np.lexsort(a.T.round(9))], b[np.lexsort(b.T.round(9))], rtol=0, atol=1e-15
        )


@pytest.mark.parametrize(
    ("make", "arguments", "words"),
    [
        (patterns.square, {"side": 5.0, "cells": 0}, "cells is 0"),
        (patterns.square, {"side": 0.0, "cells": 2}, "side is 0, give a length"),
        (patterns.square, {"side": -1.0, "cells": 2}, "side is -1, give a length"),
        (patterns.square, {"side": math.nan, "cells": 2}, "side is nan"),
        (patterns.square, {"side": math.inf, "cells": 2}, "side is inf"),
        (patterns.square, {"side": "5", "cells": 2}, "side is '5'"),
        (patterns.square, {"side": 5.0, "cells": 2.5}, "cells is 2.5"),
        (patterns.square, {"side": 5.0, "cells": True}, "cells is True"),
        (patterns.square, {"side": 5.0, "cells": 2, "subdivide": 0}, "subdivide is 0"),
        (patterns.square, {"side": 5.0, "cells": 100_000}, "coarser"),
        (patterns.rectangle, {"width": 1.0, "height": 0, "columns": 1, "rows": 1}, "height is 0"),
        (patterns.rectangle, {"width": 1.0, "height": 1.0, "columns": 1, "rows": -2}, "rows is -2"),
        (patterns.hexagon, {"radius": 1.0, "rings": 0}, "rings is 0"),
        (patterns.radial, {"radius": 1.0, "rings": 1, "spokes": 2}, "at least 3"),
        (patterns.diamond, {"side": 1.0, "cells": "4"}, "cells is '4'"),
    ],
)
def test_bad_argument_is_one_clear_line(make, arguments, words):
    with pytest.raises(InputError, match=words) as caught:
        make(**arguments)
    assert "\n" not in str(caught.value)
