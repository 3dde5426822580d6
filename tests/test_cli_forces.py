"""The verb forces: what it prints, what it takes, what it returns."""

import re
from pathlib import Path

import pytest
from shots import shot, write_shot

import netdae as nd
from netdae.cli import main
from netdae.cli.forces import _altitude_of
from netdae.forces.earth import circular_speed, density, mean_motion
from netdae.forces.orbit import Orbit
from netdae.scenario.schema import ScenarioData

SCRIPTS = Path(__file__).parent.parent / "scripts"

SHOT = shot(viscosity_time=None, accuracy=None, frames=None)
IN_ORBIT = SHOT + "[orbit]\naltitude = 400e3\n"
ON_GROUND = SHOT + '[[loads]]\nkind = "gravity"\ng = [0.0, 0.0, -9.81]\n'


@pytest.fixture
def reported(tmp_path, capsys):
    """Runs the verb on a scenario's text; exit code, lines of stdout, stderr."""

    def report(text, *options):
        code = main(["forces", str(write_shot(tmp_path, text)), *options])
        out, err = capsys.readouterr()
        return code, out.splitlines(), err

    return report


def rows_of(lines):
    """Name to (newtons, displacement, included) of the table."""
    pattern = re.compile(r" +(\d+)  (\S.*?)  +(\S+e\S+) +(\S+e\S+) +\S+ %  (yes|no)$")
    found = [match.groups() for line in lines if (match := pattern.match(line))]
    assert [int(rank) for rank, *_ in found] == [*range(1, len(found) + 1)]
    return {name: (float(newtons), float(moves), word == "yes") for _, name, newtons, moves, word in found}


def test_forces_are_reported_in_rank_order_with_formula_and_source(reported):
    code, lines, err = reported(SHOT)
    assert (code, err) == (0, "")
    assert lines[0] == "small shot"
    rows = rows_of(lines)
    assert len(rows) == 9
    moves = [moved for _, moved, _ in rows.values()]
    assert moves == sorted(moves, reverse=True)
    assert [name for name, row in rows.items() if row[2]] == ["elastic tension at snap", "inertia"]
    formula = lines.index("   3  2 m n v, moves ½ (F/m) t²")
    assert lines[formula + 1].strip().startswith("Clohessy and Wiltshire 1960")
    assert max(map(len, lines)) <= 140  # nothing is cut or wrapped, also where it is piped


def test_scenario_without_an_orbit_is_ranked_at_600_km_and_reported_so(reported):
    _, lines, _ = reported(SHOT)
    assert "orbit    600 km, taken, as the scenario has no [orbit]: give --altitude for another" in lines
    assert lines[-1] == "verdict      the scenario has every force that is significant"


def test_scenario_on_the_ground_is_ranked_without_an_orbit(reported):
    code, lines, _ = reported(ON_GROUND)
    assert code == 0
    assert {*rows_of(lines)} == {"elastic tension at snap", "inertia", "uniform gravity", "air drag"}
    assert any(line.startswith("orbit    none, the scenario has gravity or air") for line in lines)
    _, lines, _ = reported(ON_GROUND, "--altitude", "500e3")
    assert {"uniform gravity", "Coriolis"} <= {*rows_of(lines)}


def test_altitude_and_flight_time_can_be_reported(reported):
    _, lines, _ = reported(SHOT, "--altitude", "300e3", "--flight-time", "30")
    assert "orbit    300 km, by --altitude" in lines
    assert any(line.startswith("flight   t = 30 s at v = ") for line in lines)
    low, high = (rows_of(reported(SHOT, "--altitude", each)[1]) for each in ("300e3", "900e3"))
    assert low["aerodynamic drag"][0] > 1000 * high["aerodynamic drag"][0]


def test_missing_force_that_matters_is_warned_of_with_its_remedy(reported):
    code, lines, _ = reported(SHOT, "--flight-time", "30")
    assert code == 0
    warned = [line for line in lines if line.startswith("warning ")]
    assert any(
        re.match(
            r"warning +Coriolis moves the net by \S+ m, \S+ % of its size, .* add \[orbit\] altitude", line
        )
        for line in warned
    )
    assert not any(line.startswith("verdict") for line in lines)


def test_conducting_net_feels_the_field(reported):
    assert rows_of(reported(SHOT)[1])["Lorentz force"][0] == 0
    _, lines, _ = reported(SHOT, "--current", "1", "--flight-time", "10")
    assert rows_of(lines)["Lorentz force"][0] > 1e-5
    assert any("Lorentz force moves the net" in line and "no model of it" in line for line in lines)


@pytest.mark.skipif("orbit" not in ScenarioData.model_fields, reason="scenarios have no [orbit] yet")
def test_orbit_of_the_scenario_is_taken(reported):
    _, lines, _ = reported(IN_ORBIT)
    assert "orbit    400 km, by [orbit]" in lines
    assert rows_of(lines)["Coriolis"][2]
    assert rows_of(lines)["gravity gradient"][2]


def test_altitude_is_that_of_the_option_then_of_the_orbit_then_usual_unless_on_the_ground():
    net = nd.CableNet.square(side=1.0, cells=2)
    cord = nd.Material(youngs_modulus=1e9, density=1e3, diameter=1e-3)

    def altitude(*loads, given=None):
        system = nd.System(net, cord, damping=nd.NoDamping(), loads=loads)
        return _altitude_of(system, given)[0]

    orbit, gravity = Orbit(mean_motion(700e3)), nd.Gravity([0, 0, -9.81])
    assert altitude(orbit, gravity) == pytest.approx(700e3)
    assert altitude(orbit, given=300e3) == 300e3
    assert altitude(gravity) is None
    assert altitude() == 600e3


def test_drag_of_bodies_alone_is_in_the_scenario(reported):
    drag = '[[loads]]\nkind = "drag"\ncables = "none"\nbodies = [{ group = "corners", diameter = 0.05 }]\n'
    text = SHOT + "[orbit]\naltitude = 250e3\n" + drag
    _, lines, _ = reported(text, "--flight-time", "60")
    newtons, _, included = rows_of(lines)["aerodynamic drag"]
    assert included
    area = 4 * 3.141593 * 0.05**2 / 4  # m², of the four corners; C_D 2.2, ρ and V of netdae.forces.earth
    assert newtons == pytest.approx(0.5 * density(250e3) * circular_speed(250e3) ** 2 * 2.2 * area, rel=0.05)
    warned = [line for line in lines if line.startswith("warning ") and "drag" in line]
    assert len(warned) == 1  # of the cords', which the scenario leaves out
    assert re.match(r'warning +aerodynamic drag of cords .* add cables = "all" in \[\[loads', warned[0])


def test_formula_of_air_reads_as_one(reported):
    _, lines, _ = reported(ON_GROUND)
    assert any(re.match(r" +\d  ½ ρ v² C_n A, C_n = 1\.1 at sea level, moves ", line) for line in lines)
    _, lines, _ = reported(ON_GROUND + '[[loads]]\nkind = "air"\n')
    expected = (
        "½ ρ v² C_n A, with C_n, ρ and wind of the scenario, on cords, moves ½ (F/m_c) t², the path at most"
    )
    assert any(re.fullmatch(rf" +\d  {re.escape(expected)}", line) for line in lines)


def test_fall_is_reported_where_there_is_gravity(reported):
    _, lines, _ = reported(ON_GROUND)
    assert "fall     g = 9.81 m/s², free for 0.1 s; 0.981 m/s at most" in lines
    assert not any(line.startswith("fall") for line in reported(SHOT)[1])


@pytest.mark.parametrize("file", sorted(SCRIPTS.glob("*.toml")), ids=lambda path: path.stem)
def test_every_scenario_of_the_scripts_can_be_ranked(file, capsys):
    assert main(["forces", str(file)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert rows_of(lines)
    assert max(map(len, lines)) <= 140
    assert not any("C_n A C_n" in line for line in lines)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--altitude", "100e3"], "altitude is 100000 m: no orbit lasts under 120000 m"),
        (["--altitude", "-5"], "altitude is -5 m"),
        (["--altitude", "high"], 'Invalid value for --altitude: "high", expected a number'),
        (["--flight-time", "0"], "flight time is 0 s: give a time above zero"),
        (["--flight-time", "nan"], "flight time is nan s"),
        (["--charge", "inf"], "charge is inf C"),
        (["more.toml"], "more.toml is too much: netdae forces takes one scenario at a time"),
    ],
)
def test_mistakes_are_one_line_and_exit_code_2(reported, options, message):
    code, lines, err = reported(SHOT, *options)
    assert code == 2
    assert lines == []
    assert message in err
    assert err.count("\n") == 1


def test_missing_scenario_is_asked_for(capsys):
    assert main(["forces"]) == 2
    assert "SCENARIO is missing: netdae forces SCENARIO.toml" in capsys.readouterr().err
