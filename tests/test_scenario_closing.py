"""The sections [[closing]] of a scenario: what they make, and what is given where they are wrong."""

import tomllib

import numpy as np
import pytest
from pydantic import ValidationError

from netdae.core.errors import InputError
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.scenario.closing import ClosingEntry, closing_of, closing_options
from netdae.scenario.problems import bare, first_problem
from netdae.scenario.reader import read_scenario
from netdae.scenario.section import Section
from netdae.scenario.solver import Solver
from netdae.solvers.options import SolverOptions
from netdae.system.closing import Drawcord, Winch
from netdae.system.closing_assembly import with_closings

CORD = """
youngs_modulus = 60e9
density = 1400.0
diameter = 2e-3
"""
DRAWCORD = f"""\
[[closing]]
kind = "drawcord"
rings = "border"
speed = 0.5
force = 40.0
final_length = 1.0
begin = "mouth_area_max"
friction = 0.1{CORD}"""
WINCH = f"""\
[[closing]]
kind = "winch"
first = "left"
second = "right"
speed = 2.0
force = 40.0
final_length = 0.5
begin = 1.5
hold = 3.0{CORD}"""

BEGIN = 1.0


class Scenario(Section):
    """A scenario with nothing but these sections."""

    closing: list[ClosingEntry]


def net_of():
    net = CableNet.square(side=2.0, cells=2)
    return CableNet(net.nodes, net.cables, {**net.node_groups, "left": [0, 1], "right": [7, 8]})


def closings_from(text):
    data = tomllib.loads(text)
    try:
        entries = Scenario.model_validate(data).closing
    except ValidationError as error:
        raise InputError(first_problem(error, data)) from error
    return [closing_of(entry, net_of(), BEGIN) for entry in entries]


def given(text):
    with pytest.raises(InputError) as error:
        closings_from(text)
    return bare(error.value)


def test_the_sections_make_the_closings_that_they_tell():
    cord, winch = closings_from(DRAWCORD + WINCH)
    assert isinstance(cord, Drawcord)
    assert isinstance(winch, Winch)
    assert (cord.group, cord.nodes, cord.closed, cord.length) == ("border", None, True, None)
    assert (cord.haul.speed, cord.haul.force, cord.haul.final_length) == (0.5, 40.0, 1.0)
    assert (cord.haul.begin, cord.haul.hold) == ("mouth_area_max", None)
    assert (cord.rings.friction, cord.rings.size, cord.rings.fastened) == (0.1, 1e-3, False)
    assert cord.rings.creep_speed == pytest.approx(0.005)
    assert cord.material.cross_section == pytest.approx(np.pi * 1e-6)
    assert (winch.first, winch.second, winch.haul.begin, winch.haul.hold) == ("left", "right", 1.5, 3.0)
    net = net_of()
    closed = with_closings(net, State.at(net.nodes, np.zeros_like(net.nodes), t=BEGIN), [cord, winch])
    assert closed.net.node_count == net.node_count + 3  # drums of the cord and of two winches
    assert {name: len(closed.net.cables_of(name)) for name in ("closing", "closing_1", "closing_2")} == {
        "closing": 10,
        "closing_1": 8,
        "closing_2": 2,
    }
    # the drums are held until the event and until the time, and those of the winches from 3 s on
    assert [r.until for r in closed.restraints] == ["mouth_area_max", 1.5, np.inf, 1.5, np.inf]


def test_rings_may_be_a_list_and_the_cord_open():
    text = DRAWCORD.replace('"border"', "[2, 0, 6]\nclosed = false")
    (cord,) = closings_from(text)
    assert cord.nodes == (2, 0, 6)
    assert not cord.closed
    assert cord.rings.fastened


FLIGHT = f"""
[net]
kind = "square"
side = 2.0
cells = 2
[[material]]{CORD}
[damping]
kind = "dashpot"
viscosity_time = 1e-5
[initial]
velocity = [0.0, 0.0, 1.0]
[[events]]
figure = "distance"
value = 0.015
action = "start_closing"
name = "there"
[solver]
method = "explicit"
end = 0.03
[output]
frames = 4
"""


def test_an_event_starts_a_closing_that_has_no_begin(tmp_path):
    file = tmp_path / "scenario.toml"
    file.write_text(FLIGHT + DRAWCORD.replace('begin = "mouth_area_max"\n', ""), encoding="utf-8")
    flight = read_scenario(file).build().integrate()
    states = list(flight)
    assert flight.fired["there"] == pytest.approx(0.015, abs=1e-9)  # at 1 m/s
    # frames at 0, 0.01, 0.02 and 0.03 s: the drum, which is the last node, winds in from the event on
    wound_in = [state.x[-1, 0] for state in states]
    assert wound_in[:2] == [0.0, 0.0]
    assert 0.0 < wound_in[2] < wound_in[3]


def test_an_event_that_starts_no_closing_is_refused(tmp_path):
    file = tmp_path / "scenario.toml"
    file.write_text(FLIGHT + DRAWCORD.replace('"mouth_area_max"', "0.02"), encoding="utf-8")
    with pytest.raises(
        InputError, match=r"start_closing needs what closes it: add \[\[closing\]\] without begin"
    ):
        read_scenario(file).build()


def test_tolerances_are_those_of_the_slowest_closing_unless_they_are_given():
    closings = closings_from(DRAWCORD + WINCH)
    solver = Solver(end=2.0)
    own = closing_options(SolverOptions(), solver, closings)
    assert own.tolerances == pytest.approx((1e-5, 5e-8, 5e-6))
    given = Solver(end=2.0, atol_velocity=1e-3)
    kept = closing_options(SolverOptions(atol_velocity=1e-3), given, closings)
    assert kept.tolerances == pytest.approx((1e-5, 5e-8, 1e-3))
    fine = SolverOptions(accuracy="accurate")
    assert closing_options(fine, solver, closings).tolerances == pytest.approx((1e-5, 5e-8, 5e-6))
    assert closing_options(SolverOptions(), solver, []) == SolverOptions()


@pytest.mark.parametrize(
    ("was", "now", "found"),
    [
        ('"border"', "[3]", "the cord runs through 1 node: give two or more rings"),
        ('"border"', '"centre"', "the cord runs through 1 node of 'centre'"),
        ('"border"', "[3, 9, 1]", "the cord runs through node 9, but the net has 9 nodes"),
        ('"border"', f"[3, {2**63}, 1]", f"the cord runs through node {2**63}, but the net has 9 nodes"),
        ('"border"', "[3, -9, 1]", "[[closing]] 1 rings, number 2, is -9, expected 0 or more"),
        ('"border"', '"boarder"', "there is no node group 'boarder': did you mean 'border'?"),
        ('"border"', "3", "[[closing]] 1 rings is 3, expected text in quotes"),
        ("speed = 0.5", "speed = 0.0", "[[closing]] 1 speed is 0.0, expected a number above 0"),
        ("speed = 0.5", "speed = -1.0", "[[closing]] 1 speed is -1.0, expected a number above 0"),
        ("speed = 0.5\n", "", "[[closing]] 1 speed is missing: Speed at which the motor winds in, m/s"),
        ('"mouth_area_max"', "0.5", "begin is 0.5 s, before the start of the flight at 1 s"),
        (
            "final_length = 1.0",
            "final_length = 9.0",
            "final_length is 9 m, but the cord is 8 m long before: give less",
        ),
        ('"drawcord"', '"drawstring"', 'kind is the text "drawstring", expected one of winch, drawcord'),
        ("friction", "fricton", "[[closing]] 1 fricton is an unknown key: did you mean friction?"),
        ("diameter = 2e-3", "", "neither of diameter and area is given"),
        ('rings = "border"', 'rings = "border"\nclosed = false\nfastened = false', "would slip out"),
    ],
)
def test_what_is_wrong_with_a_drawcord_is_reported_in_one_line(was, now, found):
    line = given(DRAWCORD.replace(was, now, 1))
    assert found in line
    assert "\n" not in line


@pytest.mark.parametrize(
    ("was", "now", "found"),
    [
        ('"right"', '"border"', "'left' has 2 nodes and 'border' has 8"),
        ('"right"', '"rigt"', "there is no node group 'rigt': did you mean 'right'?"),
        ('second = "right"', "", "[[closing]] 1 second is missing"),
        (
            "hold = 3.0",
            "hold = 1.5",
            "begins at 1.5 s and is held from 1.5 s on",
        ),
        (
            "final_length = 0.5",
            "final_length = 0.1",
            "final_length is 0.1 m, under 10% of the cord's 2.23607 m",
        ),
    ],
)
def test_what_is_wrong_with_a_winch_is_reported_in_one_line(was, now, found):
    line = given(WINCH.replace(was, now, 1))
    assert found in line
    assert "\n" not in line
