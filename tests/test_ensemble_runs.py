"""`netdae run --ensemble`: disturbed starts, figures over members, worker processes."""

import csv
import importlib.util
import io
import logging
import os
import signal
import subprocess
import sys
import time
from contextlib import closing

import numpy as np
import pytest
import tasks
from conftest import random_net
from folders import summary_of
from numpy.random import default_rng
from rich.console import Console
from shots import shot, write_shot

import netdae as nd
from netdae.cli import main
from netdae.cli.ensemble import MembersProgress, band_in_words
from netdae.core.compilation import reported_when_compiling
from netdae.core.errors import InputError, RunError
from netdae.output.metrics import CONTACT
from netdae.runs import workers
from netdae.runs.ensemble import Ensemble, bands_of, common_warnings, events_over, figures_over, statistics_of
from netdae.runs.ensemble_folder import EnsembleFolder, fly_member
from netdae.runs.workers import Outcome, outcomes_of, processes_for
from netdae.system.measurements import Cordage
from netdae.system.meeting import TargetColumns

# pulled taut after 0.05 s; what comes then depends on the start
SHOT = shot()
SLACK = shot(scale=0.4, end=0.02)

RUN_FILES = {"checkpoint.npz", "metrics.csv", "scenario.toml", "summary.json", "trajectory.npz"}


def table_of(folder):
    rows = list(csv.reader((folder / "metrics.csv").open()))
    return dict(zip(rows[0], np.array(rows[1:], dtype=float).T, strict=True))


def without_clock(summary):
    for name in ("processes", "wall_seconds"):
        summary.get("ensemble", {}).pop(name, None)
    summary["solver"].pop("wall_seconds", None)
    return summary


def quiet(message):
    """Tells nobody."""


def in_this_process(task, items, *, processes, hear):
    """`outcomes_of` without processes."""
    for number, item in enumerate(items):
        error = None
        try:
            task(item, lambda message, number=number: hear(number, message))
        except RunError as failure:
            error = str(failure)
        yield Outcome(number, error)


@pytest.fixture
def no_processes(monkeypatch):
    monkeypatch.setattr(workers, "outcomes_of", in_this_process)


def run(folder, *arguments, text=SHOT):
    """Exit code of a run into folder/out."""
    return main(["run", str(write_shot(folder, text)), "-o", str(folder / "out"), *map(str, arguments)])


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """Three members in two processes."""
    folder = tmp_path_factory.mktemp("flown")
    assert run(folder, "--ensemble", 3, "--perturb", 1e-6, "--seed", 7, "--processes", 2) == 0
    return folder / "out"


# Starts and statistics


def test_member_is_drawn_from_seed_and_number_and_restrained_axes_stay():
    net = random_net()
    start = nd.State.at(net.nodes, np.ones((net.node_count, 3)), t=0.5)
    restrained = np.zeros((net.node_count, 3), dtype=bool)
    restrained[3, 1] = restrained[5] = True
    disturbed = Ensemble(4, 1e-3, seed=9).start(2, start, restrained)
    noise = default_rng((9, 2)).standard_normal(start.x.shape)
    np.testing.assert_array_equal(disturbed.x, np.where(restrained, net.nodes, net.nodes + 1e-3 * noise))
    np.testing.assert_array_equal(disturbed.v, start.v)
    assert disturbed.t == 0.5
    np.testing.assert_array_equal(disturbed.x, Ensemble(50, 1e-3, seed=9).start(2, start, restrained).x)


def test_disturbances_are_normal_with_the_size_asked_for_and_of_their_own_for_each_member_and_seed():
    start = nd.State.at(np.zeros((1000, 3)))
    free = np.zeros((1000, 3), dtype=bool)
    x = [Ensemble(2, 1e-6, seed).start(k, start, free).x / 1e-6 for seed in (0, 1) for k in (0, 1)]
    for each in x:
        # of 3000 normal numbers the mean scatters by 0.018, the deviation by 0.013; five times that
        assert abs(each.mean()) < 0.09
        assert each.std() == pytest.approx(1, abs=0.065)
    correlations = np.corrcoef([each.ravel() for each in x])
    assert np.abs(correlations - np.eye(4)).max() < 0.09


def test_statistics_are_those_of_numpy():
    values = default_rng(3).normal(5.0, 2.0, 11)
    reported = statistics_of([*values, None, float("nan")])
    expected = (11, np.mean(values), np.std(values, ddof=1), np.min(values), np.max(values))
    # sums of eleven terms
    assert [reported[name] for name in ("n", "mean", "std", "min", "max")] == pytest.approx(
        expected, rel=1e-14
    )


def test_members_that_agree_have_no_band_and_few_members_no_deviation():
    assert statistics_of([0.1] * 3) == {"n": 3, "mean": 0.1, "std": 0.0, "min": 0.1, "max": 0.1}
    one = statistics_of([4.0])
    assert (one["n"], one["mean"], one["min"], one["max"]) == (1, 4.0, 4.0, 4.0)
    assert np.isnan(one["std"])
    assert statistics_of([None])["n"] == 0


def test_numbers_of_cables_are_counted_not_averaged_and_text_is_left_out():
    members = [
        {"peak": 1.0, "peak_cable": 3, "kind": "a", "open": True},
        {"peak": 3.0, "peak_cable": 1, "kind": "b", "open": True},
        {"peak": 2.0, "peak_cable": 3, "more": 4, "weak_cable": 5, "kind": "b", "open": False},
    ]
    assert figures_over(members) == {
        "peak": {"n": 3, "mean": 2.0, "std": 1.0, "min": 1.0, "max": 3.0},
        "peak_cable": {"n": 3, "members": {1: 1, 3: 2}},
        "weak_cable": {"n": 1, "members": {5: 1}},
        "more": pytest.approx({"n": 1, "mean": 4.0, "std": np.nan, "min": 4.0, "max": 4.0}, nan_ok=True),
    }


def test_bands_are_those_of_numpy_at_each_time():
    rng = default_rng(4)
    tables = [{"time": np.arange(5.0), "area": rng.random(5), "none": np.full(5, np.nan)} for _ in range(7)]
    bands = bands_of(tables)
    area = np.array([table["area"] for table in tables])
    assert [*bands][:5] == ["time", "area_mean", "area_std", "area_min", "area_max"]
    np.testing.assert_array_equal(bands["time"], np.arange(5.0))
    np.testing.assert_allclose(bands["area_mean"], area.mean(axis=0), rtol=1e-14)
    np.testing.assert_allclose(bands["area_std"], area.std(axis=0, ddof=1), rtol=1e-14)
    np.testing.assert_array_equal(bands["area_min"], area.min(axis=0))
    np.testing.assert_array_equal(bands["area_max"], area.max(axis=0))
    assert np.isnan(bands["none_mean"]).all()


def test_times_of_events_are_those_of_the_first_in_each_member_that_had_them():
    def record(name, time):
        return {
            "name": name,
            "figure": "distance",
            "value": 1.0,
            "action": "none",
            "time": time,
            "found": time,
        }

    members = [
        [record("far", 0.1), record("far", 0.9), record("wide", None)],
        [record("far", 0.3), record("wide", None)],
        [record("far", None), record("wide", None)],
    ]
    far, wide = events_over(members)
    assert {key: far[key] for key in ("name", "figure", "value", "action", "of")} == {
        "name": "far",
        "figure": "distance",
        "value": 1.0,
        "action": "none",
        "of": 3,
    }
    assert (far["time"]["n"], far["time"]["min"], far["time"]["max"]) == (2, 0.1, 0.3)
    assert far["time"]["mean"] == pytest.approx(0.2)
    assert far["time"]["std"] == pytest.approx(np.std([0.1, 0.3], ddof=1))
    assert wide["time"]["n"] == 0
    assert events_over([]) == []


@pytest.mark.parametrize(
    ("mean", "std", "words"),
    [
        (52.626, 2.21, "52.6 ± 2.2 N, 50.4 to 54.8 N"),
        (0.74, 8.7e-10, "0.740000 ± 8.7e-10 N, 0.740000 to 0.740000 N"),
        (1234.5, 310.0, "1234 ± 310 N, 924 to 1544 N"),
        (0.0, 0.02, "0.000 ± 0.020 N, -0.020 to 0.020 N"),
        (3.0, 0.0, "3 N"),
        (3.25, float("nan"), "3.25 N"),
    ],
)
def test_a_band_is_reported_to_two_digits_of_its_deviation(mean, std, words):
    of = {"n": 3, "mean": mean, "std": std, "min": mean - std, "max": mean + std}
    assert band_in_words(of, "N") == words


def test_warnings_that_differ_in_numbers_are_reported_once():
    reported = common_warnings({"a": ["2.5 m² at t = 1e-3 s", "slow"], "b": ["-3 m² at t = 0.1 s"], "c": []})
    assert reported == [
        "in 2 of 3 members, first a: 2.5 m² at t = 1e-3 s",
        "in 1 of 3 members, first a: slow",
    ]


# Runs


def test_each_member_has_its_run_folder_and_the_first_its_frames(flown):
    assert {path.name for path in flown.iterdir()} == {
        *("member_000", "member_001", "member_002", "metrics.csv", "scenario.toml", "summary.json")
    }
    for number in range(3):
        member = flown / f"member_{number:03d}"
        frames = {"frames", "series.pvd"} if number == 0 else set()
        assert {path.name for path in member.iterdir()} == RUN_FILES | frames
        assert summary_of(member)["status"] == "finished"
        assert summary_of(member)["member"] == {
            "number": number,
            "perturb": 1e-6,
            "seed": 7,
            "scatter": False,
        }
        assert len(nd.Trajectory.load(member)) == 5


def test_members_start_from_their_disturbed_starts(flown):
    simulation = nd.read_scenario(flown / "scenario.toml").build()
    for number in range(3):
        start = nd.Trajectory.load(flown / f"member_{number:03d}")[0]
        expected = Ensemble(3, 1e-6, 7).start(number, simulation.start, simulation.system.restrained)
        np.testing.assert_array_equal(start.x, expected.x)


def test_member_flown_again_alone_gives_the_identical_files(flown, tmp_path):
    scenario = nd.read_scenario(flown / "scenario.toml")
    folder = EnsembleFolder(tmp_path / "out", scenario, Ensemble(50, 1e-6, 7))
    for number in (0, 2):
        fly_member(folder.members[number], quiet)
        again, once = tmp_path / "out" / f"member_{number:03d}", flown / f"member_{number:03d}"
        files = {file.relative_to(once) for file in once.rglob("*") if file.is_file()}
        assert {file.relative_to(again) for file in again.rglob("*") if file.is_file()} == files
        for file in files:
            if file.name == "summary.json":
                assert without_clock(summary_of(again)) == without_clock(summary_of(once))
            elif file.name == "checkpoint.npz":
                with np.load(again / file) as here, np.load(once / file) as there:
                    assert here.files == there.files
                    for name in {*there.files} - {"flight.seconds", "flight.total_seconds"}:
                        np.testing.assert_array_equal(here[name], there[name])
            else:
                assert (again / file).read_bytes() == (once / file).read_bytes(), file


def test_number_of_processes_changes_no_figure_and_warm_kernels_are_not_compiled(flown, tmp_path, capsys):
    arguments = ("--ensemble", 3, "--perturb", 1e-6, "--seed", 7, "--processes", 1, "--all-frames")
    assert run(tmp_path, *arguments) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    assert "compiling" not in shown.out
    assert lines_with(shown.out, "ensemble: ") == 3
    out = tmp_path / "out"
    assert (out / "member_002" / "series.pvd").is_file()
    assert (out / "metrics.csv").read_bytes() == (flown / "metrics.csv").read_bytes()
    assert without_clock(summary_of(out)) == without_clock(summary_of(flown))


def lines_with(text, beginning):
    return sum(line.startswith(beginning) for line in text.splitlines())


def test_figures_are_those_of_the_members_files(flown):
    """Another computation, straight from what is on disk."""
    bands, tables = table_of(flown), [table_of(flown / f"member_{k:03d}") for k in range(3)]
    assert [*bands] == [
        "time",
        *(f"{name}_{part}" for name in [*tables[0]][1:] for part in ("mean", "std", "min", "max")),
    ]
    for name in [*tables[0]][1:]:
        rows = np.array([table[name] for table in tables])
        size = np.abs(rows).max()  # round-off of a mean is that of its terms
        np.testing.assert_allclose(bands[f"{name}_mean"], rows.mean(axis=0), rtol=0, atol=1e-15 * size)
        np.testing.assert_allclose(bands[f"{name}_std"], rows.std(axis=0, ddof=1), rtol=0, atol=1e-15 * size)
        np.testing.assert_array_equal(bands[f"{name}_min"], rows.min(axis=0))
        np.testing.assert_array_equal(bands[f"{name}_max"], rows.max(axis=0))
    summary, members = summary_of(flown), [summary_of(flown / f"member_{k:03d}") for k in range(3)]
    assert summary["ensemble"]["size"] == summary["ensemble"]["finished"] == 3
    assert [each["status"] for each in summary["members"]] == ["finished"] * 3
    assert {*summary["deployment"]} == {*members[0]["deployment"]}
    areas = [member["deployment"]["largest_mouth_area"] for member in members]
    assert len({*areas}) == 3
    reported = summary["deployment"]["largest_mouth_area"]
    assert reported["mean"] == pytest.approx(np.mean(areas), rel=1e-14)
    assert reported["std"] == pytest.approx(np.std(areas, ddof=1), rel=1e-9)  # of numbers close together
    assert (reported["n"], reported["min"], reported["max"]) == (3, min(areas), max(areas))
    steps = [member["solver"]["steps"] for member in members]
    assert summary["solver"]["steps"]["mean"] == pytest.approx(np.mean(steps))


@pytest.mark.usefixtures("no_processes")
def test_band_of_a_slack_net_is_of_the_size_of_the_disturbance(tmp_path):
    size = 1e-6
    assert run(tmp_path, "--ensemble", 6, "--perturb", size, text=SLACK) == 0
    out = tmp_path / "out"
    x = np.array([nd.Trajectory.load(out / f"member_{k:03d}").positions for k in range(6)])
    scatter = x.std(axis=0, ddof=1)  # (frames, n, 3): nothing pulls, so each node keeps its own
    # of 75 coordinates in 6 members: 375 free numbers, whose deviation scatters by 3.7 %; five times that
    np.testing.assert_allclose(np.sqrt((scatter**2).mean(axis=(1, 2))), size, rtol=0.19)
    system = nd.read_scenario(out / "scenario.toml").build().system
    share = system.mass / system.mass.sum()
    bands = table_of(out)
    for axis in "xyz":
        # the centre of mass scatters by size √Σ share², known from 6 members to 32 %
        band = bands[f"com_{axis}_std"] / (size * np.sqrt(share @ share))
        assert ((band > 0.2) & (band < 2.2)).all()
    assert bands["kinetic_energy_std"].max() < 1e-14 * bands["kinetic_energy_mean"].max()


@pytest.mark.usefixtures("no_processes")
def test_ensemble_without_disturbance_has_no_band(tmp_path):
    assert run(tmp_path, "--ensemble", 2, "--perturb", 0, text=SLACK) == 0
    bands = table_of(tmp_path / "out")
    for name, column in bands.items():
        if name.endswith("_std"):
            absent = name.removesuffix("_std") in {*Cordage._fields, *TargetColumns._fields, *CONTACT}
            np.testing.assert_array_equal(column, np.full(5, np.nan if absent else 0.0), err_msg=name)


SPREAD = SLACK.replace(
    "half_angle_deg = 60", "half_angle_deg = 60\nspread = { speed = 0.5, time = 0.004, seed = 7 }"
)
WITH_EVENTS = """
[[events]]
figure = "distance"
value = 0.01
name = "on_its_way"
[[events]]
figure = "distance"
value = 100.0
name = "far"
"""


def speeds_of(folder):
    """Of the bullets when all have left."""
    flight = nd.Trajectory.load(folder)
    net = nd.CableNet.square(side=1.0, cells=4)
    return np.linalg.norm(flight[-1].v[net.nodes_of("corners")], axis=1)


@pytest.mark.usefixtures("no_processes")
def test_members_draw_their_own_errors_where_they_are_scattered(tmp_path, capsys):
    """The net is slack to the end: nothing but the draws reports the members' bullets apart."""
    arguments = ("--ensemble", 3, "--perturb", 0)
    assert run(tmp_path / "alike", *arguments, text=SPREAD) == 0
    assert run(tmp_path / "apart", *arguments, "--scatter", text=SPREAD + WITH_EVENTS) == 0
    alike = [speeds_of(tmp_path / "alike" / "out" / f"member_{k:03d}") for k in range(3)]
    apart = [speeds_of(tmp_path / "apart" / "out" / f"member_{k:03d}") for k in range(3)]
    np.testing.assert_array_equal(alike[1], alike[0])
    np.testing.assert_allclose(apart[0], alike[0], rtol=1e-9)  # the first draws what the seed alone gives
    for k in range(3):
        expected = 5.0 + nd.Spread(speed=0.5, seed=7, member=k).drawn(4)[0]
        np.testing.assert_allclose(apart[k], expected, rtol=1e-4)  # no force but the solver's tolerance
    assert len({tuple(each.round(3)) for each in apart}) == 3
    summary = summary_of(tmp_path / "apart" / "out")
    assert summary["ensemble"]["scatter"]
    on_its_way, far = summary["events"]
    times = [
        next(each["time"] for each in summary_of(tmp_path / "apart" / "out" / f"member_{k:03d}")["events"])
        for k in range(3)
    ]
    assert on_its_way["time"] == pytest.approx(statistics_of(times))
    assert on_its_way["time"]["std"] > 1e-5
    assert (far["time"]["n"], far["of"]) == (0, 3)
    shown = capsys.readouterr().out
    assert "event on_its_way in 3 of 3 members, t = 0.0" in shown
    assert "event far did not happen in any member" in shown


@pytest.mark.usefixtures("no_processes")
def test_scattered_member_that_is_flown_on_keeps_its_own_errors(tmp_path):
    """Bullets that are held to the end of the run leave, when it is flown on, with what their member drew."""
    text = SPREAD.replace("time = 0.004, ", "").replace("end = 0.02", "end = 0.01")
    text = text.replace(
        "half_angle_deg = 60", "half_angle_deg = 60\nrelease_times = [0.012, 0.012, 0.012, 0.012]"
    )
    assert run(tmp_path, "--ensemble", 2, "--perturb", 0, "--scatter", text=text) == 0
    member = tmp_path / "out" / "member_001"
    assert not speeds_of(member).any()
    assert main(["run", "--resume", str(member), "--until", "0.02"]) == 0
    expected = 5.0 + nd.Spread(speed=0.5, seed=7, member=1).drawn(4)[0]
    np.testing.assert_allclose(speeds_of(member), expected, rtol=1e-4)


def failing(numbers):
    """`fly_member` that fails for the members with these numbers, at the third frame."""

    def task(member, report):
        def tell_or_fail(message):
            if member.number in numbers and message[1] > 0.5:
                raise RunError("the run failed at t = 0.05 s: a test")
            report(message)

        fly_member(member, tell_or_fail)

    return task


@pytest.fixture
def every_step_tells(monkeypatch):
    monkeypatch.setattr("netdae.runs.ensemble_folder._Teller._PAUSE", -1.0)


@pytest.mark.usefixtures("no_processes", "every_step_tells")
def test_failed_member_is_named_and_left_out_and_the_others_count(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("netdae.runs.ensemble_folder.fly_member", failing({1}))
    assert run(tmp_path, "--ensemble", 3, "--perturb", 1e-6) == 1
    out = tmp_path / "out"
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("1 of 3 members failed, member_001 first: the run failed at t = 0.05 s")
    summary = summary_of(out)
    assert summary["status"] == "failed: 1 of 3 members failed"
    assert summary["warnings"][0].startswith("member_001 failed and is left out: the run failed at t = 0.05")
    assert summary["members"][1]["status"].startswith("failed: the run failed at t = 0.05 s")
    areas = [summary_of(out / f"member_{k:03d}")["deployment"]["final_mouth_area"] for k in (0, 2)]
    assert summary["deployment"]["final_mouth_area"]["n"] == 2
    assert summary["deployment"]["final_mouth_area"]["mean"] == pytest.approx(np.mean(areas), rel=1e-14)
    assert len(table_of(out)["time"]) == 5
    assert len(nd.Trajectory.load(out / "member_001")) < 5


def test_bug_of_a_member_keeps_its_traceback_and_the_others_count(tmp_path, monkeypatch):
    """Also where the process ends badly after all files were written."""

    def outcomes(task, items, *, processes, hear):
        for outcome in in_this_process(task, items, processes=1, hear=hear):
            yield Outcome(1, "ZeroDivisionError: a bug", "where it was") if outcome.number == 1 else outcome

    monkeypatch.setattr(workers, "outcomes_of", outcomes)
    with pytest.raises(RuntimeError, match="a member met a bug:\nwhere it was"):
        run(tmp_path, "--ensemble", 3, text=SLACK)
    summary = summary_of(tmp_path / "out")
    assert summary["warnings"][0] == "member_001 failed and is left out: ZeroDivisionError: a bug"
    assert summary["members"][1]["status"] == "failed: ZeroDivisionError: a bug"
    assert summary["ensemble"]["finished"] == summary["deployment"]["final_distance"]["n"] == 2


@pytest.mark.usefixtures("no_processes", "every_step_tells")
def test_ensemble_of_which_all_fail_tells_so(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("netdae.runs.ensemble_folder.fly_member", failing({0, 1}))
    assert run(tmp_path, "--ensemble", 2) == 1
    assert capsys.readouterr().err.startswith("2 of 2 members failed, member_000 first: ")
    assert summary_of(tmp_path / "out")["deployment"] == {}
    assert table_of_header(tmp_path / "out") == ["time", "mouth_area_mean"]


def table_of_header(folder):
    (line,) = (folder / "metrics.csv").read_text().splitlines()
    return line.split(",")[:2]


@pytest.mark.usefixtures("every_step_tells")
def test_interrupted_ensemble_keeps_the_members_that_had_finished(tmp_path, capsys, monkeypatch):
    def stopped(task, items, *, processes, hear):
        yield from in_this_process(task, items[:2], processes=1, hear=hear)
        raise KeyboardInterrupt

    monkeypatch.setattr(workers, "outcomes_of", stopped)
    assert run(tmp_path, "--ensemble", 3, text=SLACK) == 130
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("interrupted when 2 of 3 members had finished; the figures over them are in")
    summary = summary_of(tmp_path / "out")
    assert summary["status"] == "interrupted"
    assert [each["status"] for each in summary["members"]] == ["finished", "finished", "not flown"]
    assert summary["deployment"]["final_distance"]["n"] == 2


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_at_a_terminal_stops_all_processes_in_one_line(tmp_path):
    """A terminal sends it to the whole group: to the workers too."""
    file, out = write_shot(tmp_path, SHOT.replace("end = 0.1", "end = 500")), tmp_path / "out"
    netdae = (sys.executable, "-c", "import sys; from netdae.cli import main; sys.exit(main())")
    process = subprocess.Popen(
        [*netdae, "run", str(file), "-o", str(out), "--ensemble", "2", "--processes", "1"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        deadline = time.monotonic() + 60
        while not (out / "member_000" / "checkpoint.npz").exists() and time.monotonic() < deadline:
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGINT)
        shown, error = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 130, shown + error
    assert len(error.splitlines()) == 1
    assert error.startswith("interrupted when 0 of 2 members had finished")
    assert [each["status"] for each in summary_of(out)["members"]] == ["interrupted", "not flown"]
    assert summary_of(out / "member_000")["status"] == "interrupted"
    assert len(nd.Trajectory.load(out / "member_000")) >= 1


# Folders and bad input


@pytest.mark.usefixtures("no_processes")
def test_overwrite_takes_away_what_netdae_wrote_and_nothing_else(tmp_path):
    assert run(tmp_path, "--ensemble", 4, "--all-frames", text=SLACK) == 0
    out = tmp_path / "out"
    (out / "notes.txt").write_text("mine")
    (out / "member_002" / "notes.txt").write_text("mine")
    (out / "member_ship").mkdir()
    (out / "member_ship" / "summary.json").write_text("mine")
    assert run(tmp_path, "--ensemble", 2, "--overwrite", text=SLACK) == 0
    assert sorted(path.name for path in out.iterdir()) == [
        *("member_000", "member_001", "member_002", "member_ship"),
        *("metrics.csv", "notes.txt", "scenario.toml", "summary.json"),
    ]
    assert {path.name for path in (out / "member_001").iterdir()} == RUN_FILES
    assert [path.name for path in (out / "member_002").iterdir()] == ["notes.txt"]
    assert run(tmp_path, "--overwrite", text=SLACK) == 0  # a single run in its place
    assert not (out / "member_000").exists()
    assert (out / "member_ship" / "summary.json").read_text() == "mine"
    assert "member" not in summary_of(out)
    assert run(tmp_path, "--ensemble", 2, "--overwrite", text=SLACK) == 0  # and an ensemble in the run's
    assert not (out / "frames").exists()
    assert not (out / "series.pvd").exists()


@pytest.mark.parametrize("left", [["summary.json"], ["member_003/frames/frame_000000.vtu"]])
def test_folder_with_a_former_ensemble_is_refused_and_kept(left, tmp_path, capsys):
    for name in left:
        file = tmp_path / "out" / name
        file.parent.mkdir(parents=True)
        file.write_text("old")
    for arguments in ([], ["--ensemble", "2"]):
        assert run(tmp_path, *arguments) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert f"this folder already holds an earlier run ({left[0]})" in line
        assert "--overwrite" in line
    assert [file.relative_to(tmp_path / "out").as_posix() for file in (tmp_path / "out").rglob("*.*")] == left


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--ensemble", "1"], "ensemble is 1: give 2 or more members"),
        (["--ensemble", "-3"], "ensemble is -3: give 2 or more members"),
        (["--ensemble", "many"], "many"),
        (["--ensemble", "2", "--perturb", "nan"], "perturb is nan m: give a finite number"),
        (["--ensemble", "2", "--perturb", "inf"], "perturb is inf m: give a finite number"),
        (["--ensemble", "2", "--perturb=-1e-9"], "perturb is -1e-09 m: give a finite number, zero or more"),
        (["--ensemble", "2", "--processes", "0"], "processes is 0: give 1 or more"),
        (["--ensemble", "2", "--seed=-1"], "seed is -1: give a whole number, zero or more"),
        (["--perturb", "1e-9"], "--perturb is for ensembles: give --ensemble N too"),
        (["--seed", "3"], "--seed is for ensembles"),
        (["--processes", "2"], "--processes is for ensembles"),
        (["--all-frames"], "--all-frames is for ensembles"),
        (["--scatter"], "--scatter is for ensembles"),
        (["--ensemble", "2", "--scatter"], "no [[initial.ejection]] has a spread above zero: add one"),
    ],
    ids=" ".join,
)
def test_bad_input_is_one_line_before_anything_is_written(arguments, words, tmp_path, capsys):
    assert run(tmp_path, *arguments) == 2
    shown = capsys.readouterr()
    (line,) = shown.err.splitlines()
    assert words in line
    assert shown.out == ""
    assert not (tmp_path / "out").exists()


def test_scenario_that_cannot_fly_is_reported_before_any_process_is_started(tmp_path, capsys):
    text = SHOT.replace('[[masses]]\ngroup = "corners"', '[[masses]]\ngroup = "korners"')
    assert run(tmp_path, "--ensemble", 2, text=text) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "korners" in line
    assert not (tmp_path / "out").exists()


# Workers


def test_what_goes_wrong_with_one_item_sinks_no_other(tmp_path, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "4")
    wishes = ["do", "fail", "do", "die", "bug", "do", "report"]
    items = [(str(tmp_path / f"{number}"), wish) for number, wish in enumerate(wishes)]
    heard = []
    outcomes = [*outcomes_of(tasks.mixed, items, processes=2, hear=lambda *reported: heard.append(reported))]
    reported = {outcome.number: outcome for outcome in outcomes}
    assert sorted(reported) == [*range(7)]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["0", "2", "5", "6"]
    assert [reported[number].error for number in (0, 2, 5, 6)] == [None] * 4
    assert (reported[1].error, reported[1].bug) == ("the run failed at t = 1 s", None)
    assert reported[3].error == "its process has died, exit code 3"
    assert reported[4].error == "ZeroDivisionError: a bug"
    assert "Traceback" in reported[4].bug
    assert heard == [(6, ("1", True))]  # one thread, deaf to Ctrl-C


def test_workers_stop_when_the_outcomes_are_closed(tmp_path):
    pids = set()

    def hear(number, pid):
        pids.add(pid)
        if len(pids) == 2:
            raise KeyboardInterrupt

    items = [(str(tmp_path / name), "wait") for name in "abc"]
    with (
        pytest.raises(KeyboardInterrupt),
        closing(outcomes_of(tasks.mixed, items, processes=2, hear=hear)) as outcomes,
    ):
        next(outcomes)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b"]  # c was never begun
    if os.name == "posix":
        for pid in pids:
            with pytest.raises(ProcessLookupError):
                os.kill(pid, 0)


def test_environment_and_signals_are_as_before_workers(tmp_path):
    before = dict(os.environ), signal.getsignal(signal.SIGINT)
    assert [*outcomes_of(tasks.mixed, [(str(tmp_path / "a"), "do")], processes=1, hear=quiet)] == [Outcome(0)]
    assert (dict(os.environ), signal.getsignal(signal.SIGINT)) == before


def test_processes_are_never_more_than_items_and_one_at_least():
    assert processes_for(3, 8) == 3
    assert processes_for(8, 3) == 3
    assert 1 <= processes_for(1000) <= os.cpu_count()
    with pytest.raises(InputError, match="processes is 0"):
        processes_for(3, 0)


# What is shown


def test_compilation_is_reported_once_and_only_where_the_disk_has_no_kernel(tmp_path, monkeypatch):
    file = tmp_path / "kernel.py"
    file.write_text(
        "from numba import njit\n@njit(cache=True)\ndef twice(x):\n    return 2 * x\n"
        "@njit(cache=True)\ndef again(x):\n    return twice(x)\n"
    )

    def times_reported():
        spec = importlib.util.spec_from_file_location("kernel", file)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        reported = []
        with reported_when_compiling(lambda: reported.append(1)):
            assert module.again(2) == 4
            assert module.twice(2.5) == 5.0
        return len(reported)

    assert [times_reported(), times_reported()] == [1, 0]


def test_bar_counts_members_and_lines_are_a_tenth_each(caplog):
    screen = io.StringIO()
    console = Console(file=screen, force_terminal=True, width=120)
    with MembersProgress(4, console=console) as progress:
        progress.hear(0, ("flown", 0.5))
        progress.end_of(Outcome(0))
        progress.end_of(Outcome(1))
    assert "2 of 4" in screen.getvalue()
    with caplog.at_level(logging.INFO, "netdae"), MembersProgress(100) as progress:
        progress.hear(0, ("compiling", "once"))
        progress.hear(1, ("compiling", "once"))
        for number in range(100):
            progress.end_of(Outcome(number))
    lines = [record.getMessage() for record in caplog.records]
    assert lines[0] == "once"
    assert len(lines) == 11
    assert lines[-1] == "ensemble: 100 of 100 members, 0.0 s left"


def test_members_without_frames_do_without_vtk():
    code = "import sys, netdae.runs.ensemble_folder; print(*sys.modules)"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert {name.split(".")[0] for name in shown.stdout.split()} & {"pyvista", "vtkmodules"} == set()
