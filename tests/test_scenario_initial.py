"""The section [initial]: from its keys to a start, and one clear line for what is wrong."""

from __future__ import annotations

import re
import tomllib
from contextlib import contextmanager

import numpy as np
import pytest
from pydantic import ValidationError

from netdae.core.errors import InputError
from netdae.initial.accordion import accordion
from netdae.initial.canister import Canister
from netdae.initial.scaled import ejected, scaled
from netdae.initial.star import star
from netdae.model.net import CableNet
from netdae.scenario.initial import Initial, start_of
from netdae.scenario.problems import first_problem

NET = CableNet.square(side=5.0, cells=10)
MASSES = {"corners": 0.5}
SHOT = '[[ejection]]\ngroup = "corners"\nspeed = 2.5\nhalf_angle_deg = 45\n'


@contextmanager
def section(name, number=None):
    """Like a scenario's: errors are given by section and number."""
    try:
        yield
    except InputError as error:
        raise InputError(f"[{name}] {'' if number is None else number + 1}: {error}") from error


def begun(text, net=NET, masses=MASSES):
    return start_of(Initial.model_validate(tomllib.loads(text)), net, masses, section)


def line_of(text):
    """The one line that a scenario with this [initial] is refused with."""
    data = tomllib.loads(text)
    try:
        start_of(Initial.model_validate(data), NET, MASSES, section)
    except ValidationError as error:
        # the place as it is in the whole scenario
        errors = [{**one, "loc": ("initial", *one["loc"])} for one in error.errors()]
        whole = type("Whole", (), {"errors": lambda self: errors})()
        return first_problem(whole, {"initial": data})
    except InputError as error:
        return str(error)
    raise AssertionError("nothing was refused")


def test_scaled_starts_are_as_before():
    found = begun(f"scale = [0.4, 0.4, 1.0]\nrotation_deg = [10, 20, 30]\nvelocity = [0, 0, 1]\n{SHOT}")
    net, start = scaled(NET, (0.4, 0.4, 1.0), rotation_deg=(10, 20, 30), velocity=(0, 0, 1))
    assert np.array_equal(found.net.nodes, net.nodes)
    assert np.array_equal(found.state.x, start.x)
    shot = ejected(net, start, "corners", speed=2.5, half_angle_deg=45)
    assert np.array_equal(found.state.v, shot.v)
    assert found.findings == ()
    assert np.array_equal(found.launch.nodes, net.nodes_of("corners"))
    still = begun("")
    assert np.array_equal(still.state.x, NET.nodes)
    assert len(still.launch.nodes) == 0


def test_an_accordion_is_made_of_its_keys():
    found = begun(
        'shape = "accordion"\ncanister = { side = 1.1, depth = 0.3 }\nfolds = [4, 6]\ngap = 0.002\n'
        f"slack = 0.05\nrotation_deg = [0, 90, 0]\n{SHOT}"
    )
    net, start = accordion(
        NET, Canister(0.3, side=1.1), folds=(4, 6), gap=0.002, slack=0.05, rotation_deg=(0, 90, 0)
    )
    assert np.array_equal(found.net.nodes, net.nodes)
    assert np.array_equal(found.state.x, start.x)
    assert re.match(r"\[initial\]: the pack would pass through itself", found.findings[0])
    # to where the corners stand in the open net, here turned to z = −x̄; the axis stays
    open_net = net.nodes[net.nodes_of("corners")] * [1, 1, 0]
    across = found.launch.velocities[:, :2]
    assert across == pytest.approx(2.5 / np.sqrt(2) * np.sign(open_net[:, :2]) * [0, 1], abs=1e-9)
    by_pitch = begun('shape = "accordion"\ncanister = { side = 5, depth = 0.3 }\npitch = [1.0, 5.0]\n')
    assert np.array_equal(by_pitch.state.x, accordion(NET, Canister(0.3, side=5), folds=(4, 0))[1].x)
    assert by_pitch.findings == ()


def test_a_star_is_made_of_its_keys_and_its_bullets_fly_outward():
    found = begun(
        f'shape = "star"\ncanister = {{ diameter = 0.5, depth = 0.3 }}\ncord_diameter = 0.001\n{SHOT}'
    )
    net, start = star(NET, Canister(0.3, diameter=0.5), cord_diameter=0.001)
    assert np.array_equal(found.state.x, start.x)
    corners = net.nodes_of("corners")
    outward = net.nodes[corners] / np.linalg.norm(net.nodes[corners], axis=1)[:, None]
    assert found.launch.velocities == pytest.approx(
        2.5 * (np.array([0, 0, 1]) + outward) / np.sqrt(2), abs=1e-12
    )
    assert found.findings == ()


def test_errors_and_release_times_reach_the_bullets():
    found = begun(
        f"scale = [0.5, 0.5, 1.0]\nvelocity = [0, 0, 1]\n{SHOT}speed_errors = [0, 0.1, 0, 0]\n"
        "release_times = [0, 0, 0.25, 0]\nspread = { angle_deg = 1.0, seed = 3 }\n"
    )
    v = found.launch.velocities - [0, 0, 1]
    assert np.linalg.norm(v, axis=1) == pytest.approx([2.5, 2.6, 2.5, 2.5], abs=1e-12)
    assert np.array_equal(found.launch.times, [0, 0, 0.25, 0])
    assert np.array_equal(found.state.v[found.launch.nodes[2]], [0, 0, 1])
    angle = np.rad2deg(np.arccos(v[:, 2] / np.linalg.norm(v, axis=1)))
    assert 0 < np.abs(angle - 45).max() < 5


def test_a_stretched_or_collapsed_scaled_start_is_reported():
    (taut,) = begun("scale = [1.1, 1.0, 1.0]").findings
    # E11 = (1.1² − 1)/2
    assert "110 of 220 cables are taut at the start" in taut
    assert "strain 0.105 over its rest length 0.5 m" in taut
    (together,) = begun("scale = [0.0, 0.5, 1.0]").findings
    assert "121 knots share a place with another, first nodes 0 and 11" in together
    assert begun("scale = [-0.5, -0.5, 1.0]").findings == ()  # turned by 180°: all stays in one plane


FOLDED = 'shape = "accordion"\nfolds = [4, 4]\n'


@pytest.mark.parametrize(
    ("text", "line"),
    {
        "unknown shape": ('shape = "ball"', '[initial] shape is the text "ball", expected'),
        "key of another shape": (
            "folds = [1, 1]",
            '[initial] : folds is a key of shape = "accordion", but shape is "scaled"',
        ),
        "scale of a folded net": (
            f"{FOLDED}scale = [1, 1, 1]",
            '[initial] : scale is a key of shape = "scaled"',
        ),
        "no canister": (FOLDED, '[initial] : canister is missing: shape = "accordion" needs its size'),
        "canister without a width": (
            f"{FOLDED}canister = {{ depth = 1 }}",
            "[initial] : canister: give a diameter",
        ),
        "canister without a depth": (
            f"{FOLDED}canister = {{ side = 1 }}",
            "[initial] canister depth is missing: Depth",
        ),
        "canister as a number": (
            f"{FOLDED}canister = 1",
            "[initial] canister is 1, expected a table in braces",
        ),
        "negative canister": (
            f"{FOLDED}canister = {{ side = -1, depth = 1 }}",
            "[initial] canister.side is -1, expected 1e-06 or more",
        ),
        "one fold": (
            'shape = "accordion"\nfolds = [1]',
            "[initial] folds is [1], expected two numbers in brackets",
        ),
        "folds as a number": (
            'shape = "accordion"\nfolds = 3',
            "[initial] folds is 3, expected two numbers in brackets",
        ),
        "half a fold": (
            'shape = "accordion"\nfolds = [1, 0.5]',
            "[initial] folds, number 2, is 0.5, expected a whole number",
        ),
        "small canister": (
            f"{FOLDED}canister = {{ side = 0.3, depth = 1 }}",
            "[initial] : accordion with 4 and 4 folds: the pack is",
        ),
        "even pleats": (
            'shape = "star"\npleats = 4\ncanister = { side = 1, depth = 1 }',
            "[initial] : star: pleats is 4: give an odd",
        ),
        "corners of no net": (
            'shape = "star"\ncorners = "corner"\ncanister = { side = 1, depth = 1 }',
            "[initial] : there is no node group 'corner': did you mean 'corners'?",
        ),
        "scale to a point": (
            "scale = [0, 0, 1]",
            "[initial] : scale is [0.0, 0.0, 1.0], which draws the whole net into one point",
        ),
        "errors as a number": (
            f"{SHOT}speed_errors = 1",
            "[[initial.ejection]] 1 speed_errors is 1, expected numbers in brackets, one per node",
        ),
        "error that is no number": (
            f'{SHOT}speed_errors = [1, "a"]',
            '[[initial.ejection]] 1 speed_errors, number 2, is the text "a", expected a number',
        ),
        "too few errors": (
            f"{SHOT}speed_errors = [1]",
            "[initial.ejection] 1: ejection of 'corners': speed_errors: 1 given for 4 bullets",
        ),
        "release before the begin": (
            f"{SHOT}release_times = [0, 0, 0, -1]",
            "[[initial.ejection]] 1 release_times, number 4, is -1, expected 0 or more",
        ),
        "unknown key of a spread": (
            f"{SHOT}spread = {{ sped = 1 }}",
            "[[initial.ejection]] 1 spread sped is an unknown key: did you mean speed?",
        ),
        "negative spread": (
            f"{SHOT}spread = {{ speed = -1 }}",
            "[[initial.ejection]] 1 spread.speed is -1, expected 0 or more",
        ),
        "unknown group": (
            SHOT.replace("corners", "rim"),
            "[initial.ejection] 1: there is no node group 'rim'",
        ),
        "bullets without mass": (
            SHOT.replace("corners", "centre"),
            "[initial.ejection] 1: ejection of 'centre': node 60 has no mass",
        ),
    }.values(),
)
def test_mistakes_are_one_clear_line(text, line):
    found = line_of(text)
    assert found.startswith(line)
    assert "\n" not in found
