"""The verbs run, check and schema: what they leave behind, say and return."""

import csv
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import numpy as np
import pytest
from folders import summary_of
from shots import shot, write_shot

import netdae as nd
from netdae.cli import main
from netdae.forces.cables import CABLE
from netdae.forces.elements import ElementForce
from netdae.output.checkpoint import read_checkpoint
from netdae.output.pvd import read_series
from netdae.output.vtk import VtuSeries, read_frame
from netdae.runs.jacobian_check import _colours_of, compare_jacobian, stiffest_frequency
from netdae.scenario.reader import Simulation

ROOT = Path(__file__).parent.parent
NETDAE = (sys.executable, "-c", "import sys; from netdae.cli import main; sys.exit(main())")
SCRIPTS = sorted((ROOT / "scripts").glob("*.toml"))

SHOT = shot(strength=100)


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    folder = tmp_path_factory.mktemp("flown")
    assert main(["run", str(write_shot(folder, SHOT)), "-o", str(folder / "out")]) == 0
    return folder / "out"


def test_folder_holds_what_the_contract_says(flown):
    assert sorted(path.name for path in flown.iterdir()) == [
        "checkpoint.npz",
        "frames",
        "metrics.csv",
        "scenario.toml",
        "series.pvd",
        "summary.json",
        "trajectory.npz",
    ]
    assert (flown / "scenario.toml").read_text(encoding="utf-8") == SHOT
    times = np.linspace(0, 0.1, 5)
    series = read_series(flown / "series.pvd")
    np.testing.assert_array_equal([t for t, _ in series], times)
    trajectory = nd.Trajectory.load(flown)
    np.testing.assert_array_equal(trajectory.times, times)
    np.testing.assert_array_equal(trajectory[-1].x, read_checkpoint(flown / "checkpoint.npz").x)
    np.testing.assert_array_equal(trajectory[-1].x, read_frame(series[-1][1]).points)
    rows = list(csv.DictReader((flown / "metrics.csv").open()))
    np.testing.assert_array_equal([float(row["time"]) for row in rows], times)


def test_summary_tells_solver_deployment_warnings_and_versions(flown):
    summary = summary_of(flown)
    assert summary["title"] == "small shot"
    assert summary["status"] == "finished"
    assert summary["solver"]["reached"] == summary["solver"]["end"] == 0.1
    assert summary["solver"]["steps"] > 10
    assert summary["deployment"]["peak_tension"] > 0
    assert isinstance(summary["warnings"], list)
    assert {*summary["versions"]} >= {"netdae", "python", "numpy", "scipy", "scikit-sundae", "sundials"}
    # the cords' mass by hand: 40 cables of 0.25 m, and four bullets
    cord = 1390 * np.pi * 1e-6 / 4 * 40 * 0.25
    assert summary["net"]["mass"] == pytest.approx(cord + 0.2, rel=1e-12)
    assert summary["net"]["cable_mass"] == pytest.approx(cord, rel=1e-12)


TETHER = """
[tether]
group = "centre"
elements = 3
slack = 0.02
youngs_modulus = 1e9
density = 1000
diameter = 2e-3
strength = 400
payout = "braked"
brake_force = 1.0
drum_inertia = 0.05
lock = "far"
chaser = { position = [0.0, 0.0, -1.0], mass = 40.0 }
[[events]]
figure = "chaser_distance"
value = 1.7
name = "far"
"""


def test_a_tethered_run_tells_what_its_reel_paid_out_and_how_its_tether_pulled(tmp_path):
    forward = SHOT.replace("end = 0.1", "end = 0.3").replace("half_angle_deg = 60", "half_angle_deg = 30")
    file = write_shot(tmp_path, forward + TETHER)
    assert main(["run", str(file), "-o", str(tmp_path / "out")]) == 0
    summary = summary_of(tmp_path / "out")
    rows = [
        {name: float(value) for name, value in row.items()}
        for row in csv.DictReader((tmp_path / "out" / "metrics.csv").open())
    ]
    # 40 cables of 0.25 m and four bullets; 1.02 m; the chaser
    cord = 1390 * np.pi * 1e-6 / 4 * 40 * 0.25
    line = 1000 * np.pi * 1e-6
    masses = [summary["net"][name] for name in ("mass", "cable_mass", "tether_mass", "chaser_mass")]
    assert masses == pytest.approx([cord + 0.2, cord, 1.02 * line, 40.0], rel=1e-12)
    trajectory = nd.Trajectory.load(tmp_path / "out")
    system = nd.read_scenario(file).build().system
    net = system.net
    reel, chain = net.nodes_of("reel")[0], net.cables_of("tether")
    for row, state in zip(rows, trajectory, strict=True):
        assert row["paid_out"] == state.x[reel, 0]
        assert row["tether_tension"] == pytest.approx(system.tension(state.x)[chain].max(), rel=1e-12)
    paid_out = rows[-1]["paid_out"]
    assert paid_out > 0.01
    (event,) = summary["events"]
    assert event["found"] < 0.2
    assert rows[2]["paid_out"] < paid_out  # at 0.15 s
    assert event["paid_out"] == rows[3]["paid_out"] == pytest.approx(paid_out, rel=1e-15)  # locked since
    tether = summary["tether"]
    assert tether["paid_out"] == paid_out
    assert tether["length"] == pytest.approx(1.02 + paid_out, rel=1e-12)
    assert tether["mass_left"] == pytest.approx(line * paid_out, rel=1e-12)
    assert tether["final_distance"] == rows[-1]["chaser_distance"]
    assert tether["peak_tension"] >= max(row["tether_tension"] for row in rows) > 20.0
    assert tether["peak_tension_over_strength"] == pytest.approx(tether["peak_tension"] / 400, rel=1e-12)
    assert 0 < tether["peak_tension_time"] < 0.3
    assert tether["peak_tension"] <= summary["deployment"]["peak_tension"]


def test_a_net_without_a_tether_has_an_empty_section_of_it(flown):
    summary = summary_of(flown)
    assert summary["tether"] == {}
    assert not {"tether_mass", "chaser_mass"} & summary["net"].keys()
    (row, *_) = csv.DictReader((flown / "metrics.csv").open())
    assert row["paid_out"] == row["tether_tension"] == row["chaser_distance"] == "nan"


def test_number_of_frames_changes_no_figure(flown, tmp_path):
    assert (
        main(["run", str(write_shot(tmp_path, SHOT.replace("= 5\n", "= 23\n"))), "-o", str(tmp_path / "out")])
        == 0
    )
    few, many = summary_of(flown), summary_of(tmp_path / "out")
    assert len(read_series(tmp_path / "out" / "series.pvd")) == 23
    for summary in (few, many):
        del summary["solver"]["wall_seconds"]
    assert few == many


def test_run_says_a_few_quiet_lines_away_from_a_terminal(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["run", str(write_shot(tmp_path, SHOT))]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    assert len(shown.out.splitlines()) <= 20
    assert "\x1b" not in shown.out
    assert str(Path("shot_out") / "series.pvd") in shown.out
    assert "largest mouth area" in shown.out
    assert "peak tension" in shown.out
    assert (tmp_path / "shot_out" / "series.pvd").exists()


def test_warnings_are_said_and_kept(tmp_path, capsys):
    file = write_shot(tmp_path, SHOT.replace("strength = 100", "strength = 0.001"))
    assert main(["run", str(file), "-o", str(tmp_path / "out")]) == 0
    (warning,) = [each for each in summary_of(tmp_path / "out")["warnings"] if "strength" in each]
    assert f"warning: {warning}\n" in capsys.readouterr().out


# A force that no number can hold two moments after it sets in: the run fails under way
BLOW = "t,x,y,z\n0,0,0,0\n0.06,0,0,0\n0.06,1e200,0,0\n1,1e200,0,0\n"
DOOMED = SHOT.replace(
    "[solver]", '[[loads]]\nkind = "nodal"\ngroup = "corners"\nforce = { file = "blow.csv" }\n[solver]'
)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_run_that_fails_keeps_what_was_computed_and_exits_with_1(tmp_path, capsys):
    out = tmp_path / "out"
    (tmp_path / "blow.csv").write_text(BLOW)
    assert main(["run", str(write_shot(tmp_path, DOOMED)), "-o", str(out)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "at t = 0.06" in line
    assert "the 3 frames up to then are in" in line
    assert str(out) in line
    assert len(read_series(out / "series.pvd")) == 3
    assert len(nd.Trajectory.load(out)) == 3
    summary = summary_of(out)
    assert summary["status"].startswith("failed: ")
    assert summary["solver"]["reached"] == pytest.approx(0.06)
    assert summary["deployment"]["end_time"] == pytest.approx(0.06)


def stopped_at_third_frame(monkeypatch, error):
    write_frame = VtuSeries.__call__

    def stop(self, state):
        if self.frame_count == 2:
            raise error
        write_frame(self, state)

    monkeypatch.setattr(VtuSeries, "__call__", stop)


def test_interrupted_run_keeps_what_was_computed_and_exits_with_130(tmp_path, capsys, monkeypatch):
    stopped_at_third_frame(monkeypatch, KeyboardInterrupt)
    assert main(["run", str(write_shot(tmp_path, SHOT)), "-o", str(tmp_path / "out")]) == 130
    (line,) = capsys.readouterr().err.splitlines()
    assert re.match(r"interrupted at t = 0\.0\d+ s; the 2 frames", line)
    assert summary_of(tmp_path / "out")["status"] == "interrupted"
    assert len(nd.Trajectory.load(tmp_path / "out")) == 2


def test_bug_keeps_its_traceback_and_the_run_what_was_computed(tmp_path, monkeypatch):
    stopped_at_third_frame(monkeypatch, ZeroDivisionError("a bug"))
    with pytest.raises(ZeroDivisionError, match="a bug"):
        main(["run", str(write_shot(tmp_path, SHOT)), "-o", str(tmp_path / "out")])
    assert summary_of(tmp_path / "out")["status"] == "failed: ZeroDivisionError: a bug"
    assert len(nd.Trajectory.load(tmp_path / "out")) == 2


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_and_sigterm_in_a_process_are_one_line(tmp_path, stop):
    out = tmp_path / "out"
    file = write_shot(tmp_path, SHOT.replace("end = 0.1", "end = 50"))
    process = subprocess.Popen(
        [*NETDAE, "run", str(file), "-o", str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        deadline = time.monotonic() + 30
        while not (out / "frames" / "frame_000000.vtu").exists() and time.monotonic() < deadline:
            time.sleep(0.02)
        time.sleep(0.1)
        process.send_signal(stop)
        _, error = process.communicate(timeout=30)
    finally:
        process.kill()
    assert process.returncode == 130
    assert len(error.splitlines()) == 1
    assert error.startswith("interrupted at t = ")
    assert summary_of(out)["status"] == "interrupted"
    assert len(nd.Trajectory.load(out)) >= 1


HELD = SHOT[: SHOT.index("[initial]")] + "{}" + SHOT[SHOT.index("[solver]") :]


@pytest.mark.parametrize("limits", ["", "begin = 0.05\nend = 0.1\n"])  # the end of the flight
def test_reaction_of_a_net_that_is_held_whole_is_its_weight(limits, tmp_path):
    load = f'[[loads]]\nkind = "gravity"\ng = [0, 0, -9.81]\n{limits}'
    text = HELD.format(f'[[restraints]]\ngroup = "all"\n{load}')
    assert main(["run", str(write_shot(tmp_path, text)), "-o", str(tmp_path / "out")]) == 0
    summary = summary_of(tmp_path / "out")
    (held,) = summary["restraints"]
    assert (held["group"], held["axes"]) == ("all", "xyz")
    np.testing.assert_allclose(held["final_reaction"], [0, 0, 9.81 * summary["net"]["mass"]], atol=1e-12)


def test_jump_of_a_driven_velocity_is_reported_with_its_impulse(tmp_path):
    (tmp_path / "m.csv").write_text("t,x,y,z\n0,0,0,0\n0.05,0,0,0\n0.1,0,0,0.05\n")
    motion = 'motion = { file = "m.csv", interpolation = "linear" }'
    text = HELD.format(f'[[restraints]]\ngroup = "all"\n{motion}\n')
    assert main(["run", str(write_shot(tmp_path, text)), "-o", str(tmp_path / "out")]) == 0
    summary = summary_of(tmp_path / "out")
    (jump,) = summary["impulses"]
    assert jump["time"] == 0.05
    np.testing.assert_allclose(jump["impulse"], [0, 0, summary["net"]["mass"] * 1.0], rtol=1e-12)


def brief(text):
    """A scenario that ends 0.02 s after its begin."""
    before, solver = text.split("[solver]\n")
    begin = tomllib.loads(text)["solver"].get("begin", 0.0)
    shortened, count = re.subn(r"(?m)^end = .*$", f"end = {begin + 0.02}", solver, count=1)
    assert count == 1
    return f"{before}[solver]\n{shortened}"


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_shipped_scenario_flies(script, tmp_path, capsys):
    text = script.read_text(encoding="utf-8").replace("../meshes", (ROOT / "meshes").as_posix())
    text = brief(text)
    text = re.sub(r"(?m)^frames = \d+", "frames = 3", text)
    file = tmp_path / script.name
    file.write_text(text, encoding="utf-8")
    for table in (ROOT / "scripts").glob("*.csv"):
        shutil.copy(table, tmp_path)
    assert main(["run", str(file), "-o", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().err == ""
    assert summary_of(tmp_path / "out")["status"] == "finished"
    assert len(read_series(tmp_path / "out" / "series.pvd")) == 3
    assert main(["check", str(file)]) == 0


def test_check_tells_the_net_and_writes_nothing(tmp_path, capsys):
    file = write_shot(tmp_path, SHOT)
    assert main(["check", str(file)]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"nodes +25\n", shown)
    assert re.search(r"cables +40\n", shown)
    assert re.search(r"mass +0\.21", shown)
    assert re.search(r"stiffest frequency +\d", shown)
    errors = [float(each) for each in re.findall(r"largest error (\S+),", shown)]
    assert len(errors) == 4
    assert max(errors) < 1e-5
    for taut, slack in list(re.findall(r"(\d+) cables taut, (\d+) slack", shown))[1:]:
        assert min(int(taut), int(slack)) >= 8
    assert list(tmp_path.iterdir()) == [file]


def test_the_mass_that_check_tells_is_that_of_cords_and_bullets_without_drums(capsys):
    file = ROOT / "scripts" / "closing_winches.toml"
    (drums,) = {entry["drum_inertia"] for entry in tomllib.loads(file.read_text())["closing"]}
    assert drums > 0.01
    (bullets,) = (entry["mass"] for entry in tomllib.loads(file.read_text())["masses"])
    assert main(["check", str(file)]) == 0
    mass, cords = re.search(r"mass +(\S+) kg, of which cables (\S+) kg", capsys.readouterr().out).groups()
    assert float(mass) == pytest.approx(float(cords) + 4 * bullets, rel=1e-5)  # six digits are reported


def without_geometric_stiffness(K, C):
    q = 1e-3 * np.abs(K).max()
    K[:, 0, :, 1] -= q * np.eye(3)


def with_viscosity_of_wrong_sign(K, C):
    C *= -1


def with_one_wrong_entry(K, C):
    K[-1, 1, 2, 0, 2] += 1e-3 * np.abs(K).max()


@pytest.mark.parametrize(
    "spoil", [without_geometric_stiffness, with_viscosity_of_wrong_sign, with_one_wrong_entry]
)
def test_check_finds_a_wrong_tangent_and_exits_with_1(spoil, tmp_path, capsys, monkeypatch):
    right = ElementForce.tangent

    def wrong(self, t, x, v):
        tangent = right(self, t, x, v)
        if self.law is CABLE and len(tangent.elements):  # there is none where all cables are slack
            spoil(tangent.dx, tangent.dv)
        return tangent

    monkeypatch.setattr(ElementForce, "tangent", wrong)
    assert main(["check", str(write_shot(tmp_path, SHOT))]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "the Jacobian disagrees" in line
    assert re.search(r"F₂ of node \d+ along [xyz] with respect to [xv] along [xyz] of node \d+", line)


AT_REST = SHOT.replace("scale = [0.8, 0.8, 1.0]\n", "")
"""The shot from the reference shape, where every cable is at its rest length: at the kink of Eq. (4)."""

DASHPOT = 'kind = "dashpot"\nviscosity_time = 1e-4'


@pytest.mark.parametrize(
    ("old", "new", "left_out"),
    [
        ("", "", 40),
        ("[initial]", "[initial]\nrotation_deg = [10.0, 20.0, 30.0]", 40),
        ("[initial]", "[initial]\nscale = [1.0, 1.01, 1.0]", 20),
        ("cells = 4", "cells = 4\nsubdivide = 3", 120),
        ('"square"\nside = 1.0\ncells = 4', '"radial"\nradius = 1.0\nrings = 3\nspokes = 8', 48),
        (DASHPOT, 'kind = "dashpot"\nzeta = 0.1', 40),
        (DASHPOT, 'kind = "dashpot"\nviscosity_time = 1.0', 40),
        (DASHPOT, 'kind = "rayleigh"\nbeta = 1e-4', 40),
        (DASHPOT, 'kind = "none"', 40),
        ("[damping]", "toe_strain = 1e-3\n[damping]", 40),
        ("[damping]", 'law = "engineering"\n[damping]', 40),
        ("[initial]", "[initial]\nscale = [1.01, 1.01, 1.0]", 0),
    ],
    ids=[
        "plain",
        "rotated",
        "stretched along y",
        "subdivided",
        "radial",
        "zeta",
        "thick dashpot",
        "rayleigh",
        "undamped",
        "toe",
        "engineering",
        "taut",
    ],
)
def test_check_of_a_net_that_starts_at_a_kink_says_what_it_leaves_out(old, new, left_out, tmp_path, capsys):
    assert main(["check", str(write_shot(tmp_path, AT_REST.replace(old, new)))]) == 0
    start, *states = re.findall(r"Jacobian, .*", capsys.readouterr().out)
    assert start.endswith(f" slack, {left_out} at a kink left out" if left_out else " slack")
    assert not any("kink" in state for state in states)


@pytest.mark.parametrize(
    ("law", "stretch"),
    [("st_venant_kirchhoff", np.sqrt(1.2)), ("engineering", 1.1)],  # E11 = 0.1, λ − 1 = 0.1
)
def test_check_leaves_out_cables_at_the_end_of_their_toe_by_the_law_s_own_strain(
    law, stretch, tmp_path, capsys
):
    toe = f'toe_strain = 0.1\nlaw = "{law}"\n[damping]'
    text = AT_REST.replace("[damping]", toe).replace(
        "[initial]", f"[initial]\nscale = [{stretch}, 1.05, 1.0]"
    )
    assert main(["check", str(write_shot(tmp_path, text))]) == 0
    assert "40 cables taut, 0 slack, 20 at a kink left out" in capsys.readouterr().out


def test_check_leaves_out_cables_whose_dashpot_is_just_held_at_zero():
    """S11 = E (E11 + τ Ė11): a cable of 1 m, 1 % long, whose ends approach at just this rate."""
    net = nd.CableNet([[0, 0, 0], [1.01, 0, 0], [2.02, 0, 0]], [[0, 1], [1, 2]], rest_length=[1.0, 1.0])
    system = nd.System(
        net, nd.Material(youngs_modulus=1e9, density=1e3, area=1e-6), damping=nd.Dashpot(viscosity_time=1e-3)
    )
    v = np.zeros((3, 3))
    v[0, 0] = 0.5 * (1.01**2 - 1) / 1e-3 / 1.01
    simulation = Simulation("", system, nd.State.at(net.nodes, v), np.array([0.0, 1.0]), None, None)
    (start,) = compare_jacobian(simulation, states=0)
    assert (start.taut, start.at_kinks) == (2, 1)
    assert start.agrees


@pytest.mark.parametrize("where", ["at the start", "at other states"])
def test_check_finds_a_wrong_tangent_beside_cables_at_a_kink(where, tmp_path, monkeypatch):
    """At the start by the cables that are not at a kink, and else by the states that follow."""
    right = ElementForce.tangent

    def wrong(self, t, x, v):
        tangent = right(self, t, x, v)
        if self.law is CABLE and len(tangent.elements):
            with_one_wrong_entry(tangent.dx, tangent.dv)
        return tangent

    monkeypatch.setattr(ElementForce, "tangent", wrong)
    stretch = "[initial]\nscale = [1.01, 1.0, 1.0]" if where == "at the start" else "[initial]"
    simulation = nd.read_scenario(write_shot(tmp_path, AT_REST.replace("[initial]", stretch))).build()
    start, *others = compare_jacobian(simulation)
    assert start.at_kinks == (20 if where == "at the start" else 40)
    assert start.agrees == (where != "at the start")
    assert not any(each.agrees for each in others)


CORD_AT_REST = """[[closing]]
kind = "drawcord"
rings = "border"
speed = 3.0
force = 20.0
final_length = 0.5
friction = 0.1
begin = 0.0
youngs_modulus = 1e9
density = 1140.0
diameter = 1.5e-3
"""


@pytest.mark.parametrize("right", [True, False])
def test_check_of_a_cord_that_starts_at_a_kink_finds_what_is_wrong_and_nothing_else(
    right, tmp_path, monkeypatch
):
    """The flat net's drawcord is as long as its way: every move across lengthens the way, and its dashpot pulls."""
    simulation = nd.read_scenario(write_shot(tmp_path, AT_REST + CORD_AT_REST)).build()
    if not right:
        newton_part = ElementForce.newton_part

        def wrong(self, t, x, v):
            tangent = newton_part(self, t, x, v)
            if self.newton == "links" and len(tangent.by_x):
                tangent.by_x[0, 0, 0] *= 1.01
            return tangent

        monkeypatch.setattr(ElementForce, "newton_part", wrong)
    start, *others = compare_jacobian(simulation, states=2)
    assert start.agrees
    assert [each.agrees for each in others] == [right, right]


def test_directions_of_the_check_meet_each_row_once(tmp_path):
    system = nd.read_scenario(write_shot(tmp_path, SHOT)).build().system
    colours = _colours_of(system)
    near = np.eye(system.net.node_count, dtype=bool)
    near[tuple(system.net.cables.T)] = near[tuple(system.net.cables.T[::-1])] = True
    for row in near:
        assert len({*colours[row]}) == row.sum()


@pytest.mark.parametrize("held", [False, True])
def test_stiffest_frequency_of_one_cable_is_that_of_its_two_masses(held):
    net = nd.CableNet([[0, 0, 0], [0.6, 0.8, 0]], [[0, 1]], {"end": [0]})
    cord = nd.Material(youngs_modulus=1e9, density=1000.0, area=1e-6)
    restraints = [nd.Restraint("end")] if held else []
    system = nd.System(net, cord, damping=nd.NoDamping(), restraints=restraints)
    # k = 1000 N/m between two masses of 0.5 g, or one of them and a wall
    expected = np.sqrt(1000 * (2000 if held else 4000)) / (2 * np.pi)
    assert stiffest_frequency(system) == pytest.approx(expected, rel=1e-9)


def test_stiffest_frequency_of_a_large_net_is_that_of_all_its_modes():
    system = nd.System(
        nd.CableNet.square(side=1.0, cells=6),
        nd.Material(youngs_modulus=1e9, density=1000.0, area=1e-6),
        masses={"corners": 0.1},
        damping=nd.Rayleigh(beta=1.0),
    )
    K, weight = system.damping_matrix().toarray(), np.sqrt(np.repeat(system.mass, 3))
    expected = np.sqrt(np.linalg.eigvalsh(K / np.outer(weight, weight))[-1]) / (2 * np.pi)
    assert stiffest_frequency(system) == pytest.approx(expected, rel=1e-5)


def test_stiffest_frequency_of_masses_near_the_smallest_number_is_a_number():
    """Its square would overflow: 4 EA / (L m) with m of 1e-306 kg and EA of 1 kN."""
    net = nd.CableNet([[0, 0, 0], [1.0, 0, 0]], [[0, 1]])
    for nodes in (net, nd.CableNet(np.zeros((2, 3)), net.cables, rest_length=[1.0])):
        cord = nd.Material(youngs_modulus=1e6, area=1e-3, linear_density=1e-306)
        frequency = stiffest_frequency(nd.System(nodes, cord, damping=nd.NoDamping()))
        assert frequency == pytest.approx(np.sqrt(1e3) / np.sqrt(1e-306) / np.pi, rel=1e-9)


def test_schema_is_json_that_knows_the_keys(capsys):
    assert main(["schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert {"net", "material", "damping", "solver"} == {*schema["required"]}
    assert "J. " not in schema["title"]
    assert schema["$defs"]["Mass"]["properties"]["mass"]["description"].endswith("kg.")


def test_help_and_version_are_reported(capsys):
    for arguments in (["--help"], ["run", "--help"], ["check", "--help"], []):
        assert main(arguments) == 0
        assert "Usage: netdae" in capsys.readouterr().out
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == nd.__version__


@pytest.mark.skipif(os.name != "posix", reason="pipes of POSIX")
def test_reader_that_leaves_early_is_no_error():
    process = subprocess.Popen(
        [*NETDAE, "schema"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    process.stdout.close()
    error = process.stderr.read()
    process.stderr.close()
    assert process.wait() == 0
    assert error == b""
