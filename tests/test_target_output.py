"""What a run writes of its target: the series of its surface, its columns and its figures; and events at it."""

import json

import numpy as np
import pytest
import pyvista as pv
from scipy.spatial.transform import Rotation

from netdae.core.errors import InputError
from netdae.model.presets import preset_of
from netdae.output.pvd import read_series
from netdae.runs.folder import RunFolder, fly
from netdae.runs.resume import read_stopped_run
from netdae.scenario.reader import read_scenario

SCENARIO = """\
title = "a target that drifts and turns"
[net]
kind = "square"
side = 1.0
cells = 2
[[material]]
youngs_modulus = 1e9
density = 1390
diameter = 1e-3
[damping]
kind = "none"
[initial]
scale = [0.5, 0.5, 1.0]
[metrics]
mouth = "none"
[target]
preset = "envisat"
motion = "moving"
position = [0.0, 0.0, 5.0]
attitude_deg = [0.0, 0.0, 30.0]
velocity = [0.0, 0.0, -2.0]
spin_deg_s = [0.0, 0.0, 90.0]
[solver]
end = 0.5
[output]
frames = 6
"""


def flown(folder, text=SCENARIO, **options):
    file = folder / "target.toml"
    file.write_text(text)
    scenario = read_scenario(file)
    fly(scenario.build(), RunFolder(folder / "out", scenario, **options))
    return folder / "out"


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    return flown(tmp_path_factory.mktemp("target"))


def surface_at(t):
    """Points of the body at t: it turns about z of space and drifts along it."""
    points = np.concatenate([part.surface().points for part in preset_of("envisat").parts])
    place = np.array([0.0, 0.0, 5.0 - 2.0 * t])
    return place + Rotation.from_euler("z", 30 + 90 * t, degrees=True).apply(points)


def test_the_surface_moves_with_the_target(out):
    series = read_series(out / "target.pvd")
    assert [t for t, _ in series] == pytest.approx(np.linspace(0.0, 0.5, 6))
    for t, file in series:
        surface = pv.read(file)
        # single precision of the files
        np.testing.assert_allclose(surface.points, surface_at(t), atol=2e-5)
        rate = (surface_at(t + 1e-6) - surface_at(t - 1e-6)) / 2e-6
        np.testing.assert_allclose(surface.point_data["velocity"], rate, atol=1e-6)
        assert surface.field_data["TimeValue"] == t
    assert sorted({*surface.cell_data["part"]}) == [0, 1, 2]


def test_the_net_has_its_own_points_alone(out):
    frame = pv.read(read_series(out / "series.pvd")[-1][1])
    assert frame.n_points == 9


def test_columns_and_summary_have_the_target(out):
    table = np.genfromtxt(out / "metrics.csv", delimiter=",", names=True)
    t = table["time"]
    np.testing.assert_allclose(table["target_z"], 5.0 - 2.0 * t, atol=1e-12)
    np.testing.assert_allclose(table["target_velocity_z"], -2.0, atol=1e-12)
    np.testing.assert_allclose(table["target_spin_z"], np.pi / 2, rtol=1e-12)
    # half of the body's height and of a cord, to the net in the plane z = 0
    np.testing.assert_allclose(table["contact_gap"], 5.0 - 2.0 * t - 1.375 - 5e-4, atol=1e-9)
    told = json.loads((out / "summary.json").read_text())["target"]
    np.testing.assert_allclose(told["final_position"], [0.0, 0.0, 4.0], atol=1e-12)
    np.testing.assert_allclose(told["final_spin_deg_s"], [0.0, 0.0, 90.0], atol=1e-12)
    told = json.loads((out / "summary.json").read_text())["contact"]
    assert told["least_gap"] == pytest.approx(2.6245)
    assert told["least_gap_time"] == 0.5
    assert "first_contact" not in told


def test_a_run_is_resumed_with_its_target(out, tmp_path):
    folder = flown(tmp_path, SCENARIO.replace("end = 0.5", "end = 0.3").replace("frames = 6", "frames = 4"))
    stopped = read_stopped_run(folder, until=0.5)
    fly(stopped.build(), stopped.folder)
    here, whole = (read_series(each / "target.pvd") for each in (folder, out))
    assert len(here) == len(whole)
    for (t, file), (other, expected) in zip(here, whole, strict=True):
        assert t == pytest.approx(other)
        np.testing.assert_allclose(pv.read(file).points, pv.read(expected).points, atol=2e-5)


BALL = """\
[[events]]
figure = "first_contact"
[[events]]
figure = "contacts"
value = 0.0
[[events]]
figure = "target_distance"
value = 1.0
[target]
kind = "sphere"
radius = 0.5
motion = "fixed"
position = [0.0, 0.0, 2.0]
"""


def test_a_net_that_is_caught_tells_what_contact_does(tmp_path):
    """A net thrown at a free ball: what it loses the ball has, and forces, sums and energies go together."""
    head, _, tail = SCENARIO.partition("[target]")
    text = head.replace("scale =", "velocity = [0.0, 0.0, 5.0]\nscale =") + BALL.replace(
        'motion = "fixed"', "mass = 0.02\nslip_speed = 0.1\nstiffness = 2e3"
    )
    text += "[solver]" + tail.partition("[solver]")[2].replace(
        "end = 0.5", 'end = 0.35\nmethod = "ida"\naccuracy = "accurate"'
    )
    text = text.replace("frames = 6", "frames = 41")
    out = flown(tmp_path, text)
    told = json.loads((out / "summary.json").read_text())
    table = np.genfromtxt(out / "metrics.csv", delimiter=",", names=True)
    start, end = table[0], table[-1]
    assert start["momentum_z"] == pytest.approx(end["momentum_z"], rel=1e-6)
    gained = 0.02 * end["target_velocity_z"]
    assert gained > 0.01 * start["momentum_z"]
    # nearly all touches are about the pole; the trapezoidal rule over IDA's steps
    assert told["contact"]["normal_impulse"] == pytest.approx(gained, rel=0.05)
    assert told["contact"]["normal_impulse"] == pytest.approx(end["normal_impulse"])
    assert 0 < told["contact"]["friction_dissipated"] < told["contact"]["contact_dissipated"]
    # nothing else dissipates: the balance has it by Simpson's rule
    assert told["contact"]["contact_dissipated"] == pytest.approx(end["dissipated_energy"], rel=0.02)
    touching = table["contacts"] > 0
    assert touching.any()
    assert (table["contact_gap"][touching] < 0).all()
    assert (table["contact_force"][touching] > 0).all()
    assert (table["contact_force"][~touching] == 0).all()
    k = int(np.argmax(table["contact_force"]))
    frame, body = (pv.read(read_series(out / name)[k][1]) for name in ("series.pvd", "target.pvd"))
    force = np.array([table[f"target_force_{axis}"][k] for axis in "xyz"])
    np.testing.assert_allclose(-frame.point_data["contact_force"].sum(axis=0), force, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(body.cell_data["contact_force"][0], force, rtol=1e-6, atol=1e-9)
    assert frame.point_data["contact_gap"].min() >= table["contact_gap"][k] - 1e-6  # cables may be deeper


@pytest.mark.parametrize(("method", "error"), [("ida", 2e-5), ("explicit", 1e-7)])
def test_events_find_the_first_contact(tmp_path, method, error):
    """IDA's polynomial of the step in which the sphere is met knows its push before it: a fifth of 0.1 ms."""
    head, _, tail = SCENARIO.partition("[target]")
    text = head.replace("scale =", "velocity = [0.0, 0.0, 5.0]\nscale =") + BALL
    text += "[solver]" + tail.partition("[solver]")[2].replace(
        "end = 0.5", f'end = 0.31\nmethod = "{method}"\nmax_step = 1e-4'
    )
    out = flown(tmp_path, text)
    told = json.loads((out / "summary.json").read_text())
    times = {event["figure"]: event["time"] for event in told["events"]}
    # the middle knot, with half the diameter of its cords, comes to the pole of the sphere
    first = (2.0 - 0.5 - 5e-4) / 5.0
    assert times["first_contact"] == pytest.approx(first, abs=error)
    assert times["contacts"] == pytest.approx(first, abs=error)
    assert times["target_distance"] == pytest.approx(0.2, abs=1e-7)
    assert first - 1e-9 < told["contact"]["first_contact"] <= 0.31  # the internal step after it


def test_events_at_a_target_need_one(tmp_path):
    text = SCENARIO.partition("[target]")[0] + BALL.partition("[target]")[0] + "[solver]\nend = 0.01\n"
    with pytest.raises(InputError, match=r"\[\[events\]\] 1: .*needs something to touch"):
        flown(tmp_path, text)


def test_a_former_series_is_replaced(tmp_path):
    folder = flown(tmp_path)
    assert (folder / "target.pvd").exists()
    flown(tmp_path, SCENARIO.partition("[target]")[0] + "[solver]\nend = 0.01\n", overwrite=True)
    assert not (folder / "target.pvd").exists()
    assert not list((folder / "frames").glob("target_*"))
