"""What a scenario makes of its sections together: thickness of cords in a pack, times, actions of events."""

import tomllib

import numpy as np
import pytest

from netdae.core.errors import ScenarioError
from netdae.scenario.build import Build
from netdae.scenario.schema import ScenarioData

SCENARIO = """
[net]
kind = "square"
side = 2.0
cells = 6
[[material]]
youngs_modulus = 70e9
density = 1390.0
diameter = 1e-3
[damping]
kind = "dashpot"
viscosity_time = 1e-5
[[masses]]
group = "corners"
mass = 0.1
{}
[solver]
begin = 2.0
end = 3.0
method = "explicit"
"""

TETHER = """
[tether]
group = "centre"
elements = 3
length = 1.0
chaser = { position = [0.0, 0.0, -0.9], mass = 50.0 }
youngs_modulus = 1e9
density = 1000.0
diameter = 1e-3
payout = "braked"
brake_force = 0.2
drum_inertia = 0.02
"""


def built(tmp_path, sections):
    data = ScenarioData.model_validate(tomllib.loads(SCENARIO.format(sections)))
    return Build(tmp_path / "given.toml", "given", data).simulation()


@pytest.mark.parametrize(
    ("initial", "words"),
    [
        # 28 m of 1 mm cord are 22 cm³; these canisters have 5 cm³, and layers of less than the cord's thickness
        ('shape = "star"\ncanister = { side = 0.005, depth = 0.2 }', "side"),
        ('shape = "accordion"\ncanister = { side = 0.5, depth = 1e-5 }\nfolds = [3, 5]', "depth"),
    ],
)
def test_a_pack_has_room_for_its_cords_though_the_scenario_tells_no_thickness(tmp_path, initial, words):
    with pytest.raises(ScenarioError, match=words) as caught:
        built(tmp_path, f"[initial]\n{initial}")
    assert "[initial]" in str(caught.value)


@pytest.mark.parametrize(
    ("sections", "words"),
    [
        ('[[restraints]]\ngroup = "centre"\nuntil = 1.0', r"\[\[restraints\]\] 1: .* 1 s, before the flight"),
        (f"{TETHER}lock = 1.5", r"\[tether\]: .*1.5 s, before the flight begins at 2 s"),
        (f"{TETHER}begin = 2.5\nlock = 2.4", "locked at 2.4 s: lock it later"),
        (f"{TETHER}begin = 'alarm'", r"\[tether\]: .*no event 'alarm'"),
    ],
)
def test_times_that_cannot_be_are_refused(tmp_path, sections, words):
    with pytest.raises(ScenarioError, match=words):
        built(tmp_path, sections)


@pytest.mark.parametrize(
    "sections",
    [
        '[[restraints]]\ngroup = "centre"\nuntil = 9.0',
        f"{TETHER}lock = 9.0",
        '[[initial.ejection]]\ngroup = "corners"\nspeed = 1.0\nhalf_angle_deg = 30.0\nrelease_times = [0, 9, 0, 0]',
    ],
)
def test_times_after_the_flight_are_warned_of(tmp_path, sections):
    (finding,) = built(tmp_path, sections).findings
    assert "after the end of the flight at 3 s" in finding


WINCH = """
[[closing]]
kind = "winch"
first = [0, 6]
second = [48, 42]
speed = 1.0
force = 20.0
final_length = 0.5
youngs_modulus = 1e9
density = 1000.0
diameter = 1e-3
"""
"""Two winches, each with a drum of its own."""
OTHER = WINCH.replace("[0, 6]", "[1, 5]").replace("[48, 42]", "[43, 47]")

AFTER = ", after the end of the flight at 3 s"


@pytest.mark.parametrize(
    ("sections", "given"),
    [
        (f"{WINCH}begin = 2.5\n{OTHER}begin = 9.0", "[[closing]] 2: begin is 9 s"),
        (f"{WINCH}begin = 9.0", "[[closing]] 1: begin is 9 s"),
        (f"{WINCH}begin = 2.5\nhold = 8.0", "[[closing]] 1: hold is 8 s"),
        (f"{TETHER}begin = 9.0", "[tether]: begin is 9 s"),
        (f"{TETHER}lock = 9.0", "[tether]: lock is 9 s"),
        (
            '[[restraints]]\ngroup = "corners"\n[[restraints]]\ngroup = "centre"\nbegin = 9.0',
            "[[restraints]] 2: begin is 9 s",
        ),
        ('[[restraints]]\ngroup = "centre"\nuntil = 9.0', "[[restraints]] 1: until is 9 s"),
        (
            '[[initial.ejection]]\ngroup = "corners"\nspeed = 1.0\nhalf_angle_deg = 30.0\nrelease_times = [0, 9, 0, 0]',
            "[initial]: the bullet at node 6 is let go at 11 s",
        ),
    ],
)
def test_a_time_after_the_flight_is_reported_once_by_section_number_and_key(tmp_path, sections, given):
    # nobody who reads it knows the numbers of drums
    (finding,) = built(tmp_path, sections).findings
    assert finding == f"{given}{AFTER}"


def test_a_table_that_drives_a_reel_beyond_the_flight_s_end_is_reported_by_its_lock(tmp_path):
    (tmp_path / "paid.csv").write_text("t,paid_out\n2.0,0.0\n3.0,0.1\n")
    driven = TETHER.replace('payout = "braked"\nbrake_force = 0.2', 'payout = { file = "paid.csv" }')
    (finding,) = built(tmp_path, f"{driven}lock = 9.0").findings
    assert finding == f"[tether]: lock is 9 s{AFTER}"


def test_a_closing_that_waits_for_no_event_is_reported_by_its_number(tmp_path):
    with pytest.raises(ScenarioError, match=r"\[\[closing\]\] 2: .*no event 'alarm'"):
        built(tmp_path, f"{WINCH}{OTHER}begin = 'alarm'")


def test_a_motor_that_can_break_its_cord_is_noted_by_its_number_and_is_no_error(tmp_path):
    (note,) = built(tmp_path, f"{WINCH}strength = 20.0\n{OTHER}strength = 19.0").notes
    assert note == (
        "[[closing]] 2: force is 20 N, more than the cord's strength, 19 N: the motor can break it; give less force, "
        "or a stronger cord"
    )
    assert built(tmp_path, WINCH).notes == ()


def test_a_tether_is_let_go_at_its_time_and_locked_at_its_event(tmp_path):
    sections = (
        f"{TETHER}begin = 2.4\n[initial]\nvelocity = [0.0, 0.0, 2.0]\n[[events]]\nfigure = 'distance'\n"
        "value = 1.0\naction = 'lock_tether'"
    )
    simulation = built(tmp_path, sections)
    flight = simulation.integrate()
    drum = simulation.system.reels[0].node
    paid = {state.t: state.x[drum, 0] for state in flight}
    assert all(s == 0.0 for t, s in paid.items() if t <= 2.4)
    assert flight.fired.keys() == {"distance_1"}
    locked = [s for t, s in paid.items() if t >= flight.fired["distance_1"]]
    assert locked
    assert locked[0] > 1e-3  # it was paid out before
    np.testing.assert_allclose(locked, locked[0], rtol=0, atol=1e-12)


def test_one_event_has_an_action_that_is_done_once(tmp_path):
    event = "[[events]]\nfigure = 'distance'\nvalue = {}\naction = 'lock_tether'\n"
    with pytest.raises(ScenarioError, match=r"\[\[events\]\] 2: .*lock_tether already"):
        built(tmp_path, TETHER + event.format(1.0) + event.format(2.0))
