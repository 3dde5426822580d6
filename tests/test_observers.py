"""The table, the checkpoint, kept frames and the progress of a flight."""

from __future__ import annotations

import io
import logging
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from netdae.core.errors import InputError, RunError
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.state import EnergyBalance, State, Trajectory
from netdae.output.checkpoint import Checkpoint, read_checkpoint
from netdae.output.metrics import COLUMNS, DeploymentMetrics
from netdae.output.observers import MetricsCsv, Progress
from netdae.output.trajectory import Recorder
from netdae.solvers.flight import simulate
from netdae.system.damping import Dashpot
from netdae.system.system import System

SYSTEM = System(
    CableNet.square(side=5.0, cells=4),
    Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3),
    damping=Dashpot(viscosity_time=1e-5),
)


def state_at(t: float, seed: int = 0) -> State:
    rng = np.random.default_rng(seed)
    x, v, a = rng.normal(size=(3, 25, 3))
    return State(
        t, x, v, a, EnergyBalance(*rng.uniform(size=2).tolist(), tuple(rng.normal(size=3).tolist()), 40.0 * t)
    )


def test_the_table_holds_each_row_to_the_last_digit_as_soon_as_it_is_known(tmp_path: Path) -> None:
    path = tmp_path / "new" / "metrics.csv"
    metrics = DeploymentMetrics()
    table = MetricsCsv(path, metrics)
    observers = [table, metrics]  # in the worse order
    for observer in observers:
        observer.begin(SYSTEM)
    for k in range(5):
        for observer in observers:
            observer(state_at(0.1 * k, seed=k))
        lines = path.read_text().splitlines()
        assert lines[0] == ",".join(COLUMNS)
        rows = [tuple(map(float, line.split(","))) for line in lines[1:]]
        np.testing.assert_array_equal(rows, metrics.rows)  # nan of what the net has not is nan
    table.end()
    table.end()
    with pytest.raises(RuntimeError, match="before begin"):
        table(state_at(1.0))


def test_columns_without_a_mouth_are_nan_for_numpy_and_stay_in_place(tmp_path: Path) -> None:
    metrics = DeploymentMetrics(mouth=None)
    table = MetricsCsv(tmp_path / "metrics.csv", metrics)
    metrics.begin(SYSTEM)
    table.begin(SYSTEM)
    table(state_at(0.5))
    table.end()
    read = np.genfromtxt(tmp_path / "metrics.csv", delimiter=",", names=True)
    assert np.isnan(read["mouth_area"])
    assert read["time"] == 0.5
    assert read["max_tension"] >= 20.0


def test_a_table_goes_on_after_the_frames_that_were_yielded(tmp_path: Path) -> None:
    metrics = DeploymentMetrics()
    table = MetricsCsv(tmp_path / "metrics.csv", metrics)
    for observer in (metrics, table):
        observer.begin(SYSTEM)
    for k in range(6):
        for observer in (metrics, table):
            observer(state_at(0.1 * k, seed=k))
        if k == 3:
            whole = table.path.read_bytes()
    table.end()
    with table.path.open("a") as file:
        file.write("0.6,0.1,0")  # killed in the middle of a row
    rows = metrics.rows[:4]
    again = MetricsCsv(table.path, DeploymentMetrics())
    for _ in range(2):  # resumed, killed, resumed
        again.resume(SYSTEM, {"frames": 4})
        assert table.path.read_bytes() == whole
        np.testing.assert_array_equal(again.metrics.rows, rows)
    again.metrics.begin(SYSTEM)
    again(state_at(0.4))
    again.end()
    assert table.path.read_bytes().startswith(whole)
    assert len(table.path.read_text().splitlines()) == 6


def test_kept_frames_outlive_a_kill_and_go_on(tmp_path: Path) -> None:
    path = tmp_path / "trajectory.npz"
    killed = Recorder(path)
    killed.begin(SYSTEM)
    for k in range(5):
        killed(state_at(0.1 * k, seed=k))  # and no end
    assert not path.exists()
    for count, last in ((3, 0.9), (4, 1.0)):  # from the log, then from the file
        again = Recorder(path)
        again.resume(SYSTEM, {"frames": count})
        again(state_at(last, seed=9))
        again.end()
        assert [file.name for file in tmp_path.iterdir()] == ["trajectory.npz"]
    read = Trajectory.load(path)
    np.testing.assert_array_equal(read.times, [0.0, 0.1, 0.2, 0.9, 1.0])
    for frame, seed in ((2, 2), (3, 9)):
        assert np.array_equal(read[frame].v, state_at(read.times[frame], seed=seed).v)
        assert read[frame].balance == state_at(read.times[frame], seed=seed).balance
    with pytest.raises(InputError, match="holds 5 rows, expected 6 at least"):
        Recorder(path).resume(SYSTEM, {"frames": 6})


def test_a_summary_goes_on_from_the_internal_step_that_the_flight_does(tmp_path: Path) -> None:
    states = [state_at(0.1 * k, seed=k) for k in range(8)]
    whole = DeploymentMetrics()
    whole.begin(SYSTEM)
    killed = DeploymentMetrics(log=tmp_path / "steps.log")
    killed.begin(SYSTEM)
    for state in states:
        whole.watch(state)
    for state in states[:6]:
        killed.watch(state)
    killed(states[5])
    again = killed.kept_in(tmp_path / "steps.log")
    again.resume(SYSTEM, {"shown": np.array(4), **killed.memory()})
    for state in states[4:]:
        again.watch(state)
    assert again.summary() == whole.summary()
    np.testing.assert_array_equal(again.history, whole.history)
    np.testing.assert_array_equal(again.row_of(states[7]), whole.row_of(states[7]))
    again.end()
    with pytest.raises(InputError, match=r"steps\.log holds 8 rows, expected 9 at least"):
        killed.kept_in(tmp_path / "steps.log").resume(SYSTEM, {"shown": np.array(9), **killed.memory()})


def test_a_checkpoint_gives_the_last_state_back_to_the_last_digit(tmp_path: Path) -> None:
    checkpoint = Checkpoint(tmp_path / "new" / "checkpoint.npz")
    checkpoint.begin(SYSTEM)
    for t in (0.1, 1 / 3):
        state = state_at(t, seed=3)
        checkpoint(state)
        read = read_checkpoint(checkpoint.path)
        assert (read.t, read.balance) == (state.t, state.balance)
        for name in "xva":
            assert np.array_equal(getattr(read, name), getattr(state, name))
    assert [file.name for file in checkpoint.path.parent.iterdir()] == ["checkpoint.npz"]
    checkpoint.begin(SYSTEM)
    assert not checkpoint.path.exists()


def test_a_killed_run_leaves_a_whole_checkpoint_and_whole_rows(tmp_path: Path) -> None:
    rng = np.random.default_rng(12)
    for k, delay in enumerate(rng.uniform(0.005, 0.05, 8)):
        folder = tmp_path / str(k)
        pid = os.fork()
        if pid == 0:
            try:
                metrics = DeploymentMetrics()
                observers = [
                    metrics,
                    MetricsCsv(folder / "metrics.csv", metrics),
                    Checkpoint(folder / "c.npz"),
                ]
                for observer in observers:
                    observer.begin(SYSTEM)
                for i in range(10**6):
                    for observer in observers:
                        observer(state_at(float(i), seed=i % 3))
            finally:
                os._exit(1)
        while not (folder / "c.npz").exists():
            time.sleep(1e-3)
        time.sleep(delay)
        os.kill(pid, signal.SIGKILL)
        assert os.WTERMSIG(os.waitpid(pid, 0)[1]) == signal.SIGKILL
        text = (folder / "metrics.csv").read_text()
        assert text.endswith("\n")
        rows = [line.split(",") for line in text.splitlines()[1:]]
        assert {len(row) for row in rows} == {len(COLUMNS)}
        state = read_checkpoint(folder / "c.npz")
        assert len(rows) - 2 <= state.t <= len(rows) - 1  # the row of a frame comes before its checkpoint
        assert np.array_equal(state.x, state_at(0.0, seed=int(state.t) % 3).x)


def test_a_run_that_failed_leaves_its_frames_behind(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "new" / "trajectory.npz")
    recorder.begin(SYSTEM)
    recorder.end()  # failed before the first frame
    assert not recorder.path.exists()
    recorder(state_at(0.0, seed=1))
    recorder(state_at(0.5, seed=2))
    recorder.end()
    read = Trajectory.load(recorder.path)
    assert np.array_equal(read.times, [0.0, 0.5])
    assert np.array_equal(read[1].x, state_at(0.5, seed=2).x)
    assert read[1].balance == state_at(0.5, seed=2).balance


def fly(progress: Progress, times: np.ndarray) -> None:
    progress.begin(SYSTEM)
    try:
        for t in times:
            state = State(float(t), *np.zeros((3, 1, 3)))
            progress.watch(state)
            progress(state)
    finally:
        progress.end()


def test_a_terminal_shows_a_bar_with_time_and_gets_its_cursor_back() -> None:
    out = io.StringIO()
    progress = Progress(2.0, console=Console(file=out, force_terminal=True, width=100))
    fly(progress, np.linspace(0, 2, 41))
    last = out.getvalue().split("\r")[-1]
    assert "t = 2 s of 2 s" in last
    assert out.getvalue().count("\x1b[?25l") == out.getvalue().count("\x1b[?25h") == 1  # cursor hidden, shown
    progress.end()


def test_the_bar_is_taken_down_when_a_run_fails_early() -> None:
    out = io.StringIO()
    progress = Progress(2.0, console=Console(file=out, force_terminal=True, width=100))
    progress.begin(SYSTEM)
    progress.end()
    assert out.getvalue().count("\x1b[?25h") == 1
    Progress(1.0).end()  # never begun


def test_progress_of_a_flight_that_goes_on_is_of_what_is_left(caplog: pytest.LogCaptureFixture) -> None:
    progress = Progress(3.0, console=Console(file=io.StringIO()))
    with caplog.at_level(logging.INFO, logger="netdae.output.observers"):
        progress.resume(SYSTEM, {"t": np.array(2.0)})
        for t in np.linspace(2.1, 3.0, 10):
            progress.watch(State(float(t), *np.zeros((3, 1, 3))))
        progress.end()
    assert len(caplog.records) == 10


def test_elsewhere_progress_is_ten_log_lines_and_nothing_is_printed(
    caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    progress = Progress(3.0, console=Console(file=io.StringIO()), title="net")
    with caplog.at_level(logging.INFO, logger="netdae.output.observers"):
        fly(progress, np.linspace(1, 3, 1001))
    lines = [record.getMessage() for record in caplog.records]
    assert len(lines) == 10
    assert lines[4].startswith("net: t = 2 s of 3 s, ")
    assert lines[-1].startswith("net: t = 3 s of 3 s, 0.0 s left")
    assert capfd.readouterr() == ("", "")


def test_rich_is_imported_only_by_a_bar() -> None:
    code = "import sys, netdae.output.observers as o; o.Progress(1.0); assert 'rich' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_wrong_places_and_files_are_refused_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    for observer in (
        MetricsCsv(tmp_path / "file" / "m.csv", DeploymentMetrics()),
        Checkpoint(tmp_path / "file" / "c"),
    ):
        with pytest.raises(InputError, match=r"cannot be written: .*: choose another output folder"):
            observer.begin(SYSTEM)
    with pytest.raises(InputError, match="cannot be read: No such file"):
        read_checkpoint(tmp_path / "c.npz")
    np.savez(tmp_path / "other.npz", x=1.0)
    for name, content in (
        ("file", None),
        ("other.npz", None),
        ("cut.npz", b"PK\x03\x04"),
        ("empty.npz", b""),
    ):
        if content is not None:
            (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match="is not a checkpoint of netdae"):
            read_checkpoint(tmp_path / name)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a disk that is always full")
def test_a_full_disk_is_one_clear_error(tmp_path: Path) -> None:
    checkpoint = Checkpoint(tmp_path / "c.npz")
    (tmp_path / "c.npz.part").symlink_to("/dev/full")
    with pytest.raises(RunError, match=r"checkpoint at t = 0.5 s could not be written .* No space left"):
        checkpoint(state_at(0.5))


def test_the_number_of_frames_of_a_flight_changes_no_figure(tmp_path: Path) -> None:
    net = SYSTEM.net
    x = net.nodes * [0.9, 0.9, 1.0] + np.random.default_rng(1).normal(0, 1e-6, net.nodes.shape)
    start = State(0.0, x, 2.0 * net.nodes, np.zeros_like(x))
    summaries, frames = [], []
    for count in (2, 9):
        metrics = DeploymentMetrics()
        recorder = Recorder()
        table = MetricsCsv(tmp_path / "metrics.csv", metrics)
        flight = simulate(SYSTEM, start, np.linspace(0, 0.06, count), observers=[recorder, table, metrics])
        summaries.append(metrics.summary())
        frames.append(metrics.table()["max_tension"])
        assert len(recorder.states) == len(flight) == len(metrics.rows) == count
    assert summaries[0] == summaries[1]
    assert summaries[0]["peak_tension"] > 1.0  # it has come taut
    # the rows report the peaks between them: the largest of few rows is the largest of many
    assert frames[0].max() == frames[1].max() == pytest.approx(summaries[0]["peak_tension"], rel=1e-12)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the device that is always full is Linux's")
def test_a_full_disk_is_a_run_error_for_the_trajectory(tmp_path, monkeypatch):
    recorder = Recorder(tmp_path / "trajectory.npz")
    recorder(State.at(np.zeros((2, 3))))
    (tmp_path / "trajectory.npz.part").symlink_to("/dev/full")
    with pytest.raises(RunError, match=r"trajectory\.npz could not be written: No space left"):
        recorder.end()
