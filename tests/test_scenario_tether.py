"""The section [tether] of a scenario: what it makes, and what is given where it is wrong."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from netdae.core.errors import InputError
from netdae.model.motions import Fixed, TableMotion
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.scenario.problems import first_problem
from netdae.scenario.section import Section
from netdae.scenario.solver import Solver
from netdae.scenario.tether import TetherEntry, tether_of
from netdae.system.tether_assembly import with_tether

TETHER = """\
[tether]
group = "corners"
elements = 10
slack = 0.02
bridle = 1.5
chaser = { position = [0.0, 0.0, -5.0], velocity = [0.0, 0.1, 0.0], mass = 400.0 }
youngs_modulus = 60e9
density = 1400.0
diameter = 2e-3
"""
SOLVER = Solver(begin=1.0, end=3.0)


class Scenario(Section):
    """A scenario with nothing but the section."""

    tether: TetherEntry


def tether_from(text, folder=Path()):
    data = tomllib.loads(text)
    try:
        entry = Scenario.model_validate(data).tether
    except ValidationError as error:
        raise InputError(first_problem(error, data)) from error
    return tether_of(entry, folder, SOLVER)


def test_the_section_makes_the_tether_that_it_tells():
    tether = tether_from(TETHER)
    assert (tether.group, tether.elements, tether.slack, tether.bridle) == ("corners", 10, 0.02, 1.5)
    assert tether.payout == "locked"
    assert tether.chaser.position == (0.0, 0.0, -5.0)
    assert tether.chaser.velocity == (0.0, 0.1, 0.0)
    assert tether.chaser.mass == 400.0
    assert tether.chaser.motion is None
    assert tether.material.youngs_modulus == 60e9
    assert tether.material.cross_section == pytest.approx(np.pi * 1e-6, rel=1e-15)
    net = CableNet.square(side=2.0, cells=2)
    assert with_tether(net, State.at(net.nodes), tether).net.node_count > net.node_count + 10


def test_a_braked_reel_with_its_lock():
    reel = 'payout = "braked"\nbrake_force = 5.0\ndrum_inertia = 0.2\nratchet = true\nlongest = 30.0\n'
    tether = tether_from(TETHER + reel + 'lock = "tether_taut"\n')
    assert (tether.payout, tether.brake_force, tether.drum_inertia) == ("braked", 5.0, 0.2)
    assert (tether.ratchet, tether.longest, tether.lock) == (True, 30.0, "tether_taut")
    assert tether_from(TETHER + reel + "lock = 2.5\n").lock == 2.5


def test_tables_drive_the_chaser_and_the_reel(tmp_path):
    (tmp_path / "chaser.csv").write_text("t,x,y,z\n0,0,0,0\n1,0,0,0\n3,0,0,-0.2\n")
    (tmp_path / "reel.csv").write_text("t,paid_out\n1,0\n2,0.5\n3,2\n")
    (tmp_path / "rate.csv").write_text("t,paid_out,rate\n1,0,0.5\n2,0.5,0.5\n3,1,0.5\n")
    driven = TETHER.replace("velocity = [0.0, 0.1, 0.0], mass = 400.0", 'motion = { file = "chaser.csv" }')
    tether = tether_from(driven + 'payout = { file = "reel.csv", interpolation = "linear" }\n', tmp_path)
    assert isinstance(tether.payout, TableMotion)
    np.testing.assert_allclose(tether.payout.at(2.5), [[1.25, 0, 0], [1.5, 0, 0], [0, 0, 0]], rtol=1e-14)
    np.testing.assert_allclose(tether.chaser.motion.at(3.0)[0], [0, 0, -0.2], rtol=1e-14)
    tether = tether_from(TETHER + 'payout = { file = "rate.csv" }\n', tmp_path)
    np.testing.assert_allclose(tether.payout.at(1.7)[:2], [[0.35, 0, 0], [0.5, 0, 0]], rtol=1e-13)
    net = CableNet.square(side=2.0, cells=2)
    assert with_tether(net, State.at(net.nodes, t=1.0), tether).start.v[-1, 0] == pytest.approx(0.5)


def test_a_fixed_chaser_needs_no_mass():
    text = TETHER.replace("velocity = [0.0, 0.1, 0.0], mass = 400.0", 'motion = "fixed"')
    assert tether_from(text).chaser.motion == Fixed()


@pytest.mark.parametrize(
    ("old", "new", "given"),
    [
        ('group = "corners"\n', "", "[tether] group is missing"),
        ("elements = 10", "elements = 0", "[tether] elements is 0, expected 1 or more"),
        ("elements = 10", "element = 10", "[tether] element is an unknown key: did you mean elements?"),
        ("slack = 0.02", "slack = -0.1", "[tether] slack is -0.1, expected 0 or more"),
        ("slack = 0.02", "", "just one of length and slack"),
        ("position = [0.0, 0.0, -5.0], ", "", "[tether] chaser position is missing"),
        ("mass = 400.0", "mass = -1.0", "[tether] chaser.mass is -1.0, expected 0 or more"),
        (", mass = 400.0", "", "the chaser is free but has no mass"),
        (
            "mass = 400.0",
            'motion = "still"',
            "[tether] chaser.motion is the text \"still\", expected 'free' or 'fixed'",
        ),
        ("density = 1400.0\n", "", "neither of density and linear_density is given"),
        ("\nslack", '\npayout = "brake"\nslack', "'locked', 'free' or 'braked': did you mean braked?"),
        ("\nslack", "\npayout = 3\nslack", "[tether] payout is 3, expected 'locked', 'free' or 'braked'"),
        ("\nslack", '\npayout = "free"\nslack', "payout is free, which needs drum_inertia"),
        ("\nslack", "\nlock = true\nslack", "[tether] lock is true, expected a number"),
        ("\nslack", '\nlock = ""\nslack', '[tether] lock is the text "", expected a name'),
        (
            "\nslack",
            '\npayout = { fil = "x" }\nslack',
            "[tether] payout fil is an unknown key: did you mean file?",
        ),
        ("\nslack", '\npayout = { file = "none.csv" }\nslack', "none.csv: the table cannot be read"),
    ],
)
def test_what_is_wrong_is_reported_in_one_line(old, new, given):
    assert old in TETHER
    with pytest.raises(InputError) as error:
        tether_from(TETHER.replace(old, new))
    assert given in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("rows", "given"),
    [
        ("t,x,y,z\n1,0,0,0\n3,1,0,0\n", "the header is 't,x,y,z', expected t,paid_out or t,paid_out,rate"),
        (
            "t,paid_out\n1,0.5\n3,1\n",
            "reel.csv: 0.5 m are paid out at the start, t = 1 s: let paid_out begin at zero",
        ),
        ("t,paid_out\n1,0\n2,1\n", "reel.csv: the table reaches from 1 to 2 s"),
        ("t,paid_out\n1,0\n1,1\n3,2\n", "reel.csv: it jumps at its first or last row"),
    ],
)
def test_a_table_of_pay_out_that_is_wrong_is_reported(rows, given, tmp_path):
    (tmp_path / "reel.csv").write_text(rows)
    with pytest.raises(InputError) as error:
        tether_from(TETHER + 'payout = { file = "reel.csv" }\n', tmp_path)
    assert given in str(error.value)
