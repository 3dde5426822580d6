"""Runs that are killed, stopped or extended, and gone on with: nothing lost, nothing doubled, nothing else."""

import contextlib
import os
import shutil
import signal
import time
import zipfile

import numpy as np
import pytest
from folders import summary_of
from shots import shot, write_shot

import netdae as nd
from netdae.cli import main
from netdae.output.checkpoint import Checkpoint, read_checkpoint, read_kept
from netdae.output.observers import MetricsCsv
from netdae.output.pvd import read_series
from netdae.output.trajectory import Recorder
from netdae.output.vtk import VtuSeries
from netdae.runs.ensemble import Ensemble
from netdae.runs.ensemble_folder import Member, fly_member
from netdae.runs.resume import times_to

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes of POSIX")

# A pulse begins between frames and ends at one, so that phases are cut both ways; the centre is held.
HELD_CENTRE = '[[restraints]]\ngroup = "centre"\naxes = "xy"\n'
PULSE = '[[loads]]\nkind = "gravity"\ng = [3.0, 0.0, -9.81]\nbegin = 0.033\nend = 0.05\n'
SHOT = shot(title="shot", youngs_modulus="1e8", sections=HELD_CENTRE + PULSE, method="explicit", frames=9)


def run(*arguments):
    assert main(["run", *map(str, arguments)]) == 0


def flown(folder, text=SHOT):
    folder.mkdir(exist_ok=True)
    run(write_shot(folder, text), "-o", folder / "out")
    return folder / "out"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Output folder of the shot, never stopped."""
    return flown(tmp_path_factory.mktemp("whole"))


@pytest.fixture
def copied(whole, tmp_path):
    """A copy of it that a test may spoil."""
    return shutil.copytree(whole, tmp_path / "out")


def child(action):
    """Process number of a fork that does the action and ends."""
    pid = os.fork()
    if pid == 0:
        code = 1
        try:
            sink = os.open(os.devnull, os.O_WRONLY)
            os.dup2(sink, 1)
            os.dup2(sink, 2)
            code = action() or 0
        finally:
            os._exit(code)
    return pid


def killed(action):
    """Do an action that kills its own process, in one."""
    status = os.waitpid(child(action), 0)[1]
    assert os.WIFSIGNALED(status)
    assert os.WTERMSIG(status) == signal.SIGKILL


def die():
    os.kill(os.getpid(), signal.SIGKILL)


def dies(observer, frame, *, when):
    """Make the process die before or after what an observer class does at the frame of that number."""
    call, seen = observer.__call__, [0]

    def deadly(self, state):
        seen[0] += 1
        if seen[0] == frame and when == "before":
            die()
        call(self, state)
        if seen[0] == frame and when == "after":
            die()

    observer.__call__ = deadly


def files_of(folder):
    return sorted(str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file())


def assert_same_bits(folder, expected):
    assert files_of(folder) == files_of(expected)
    for name in files_of(expected):
        if name.endswith((".vtu", ".csv", ".pvd", ".toml")):
            assert (folder / name).read_bytes() == (expected / name).read_bytes(), name
    with np.load(folder / "trajectory.npz") as here, np.load(expected / "trajectory.npz") as there:
        assert here.files == there.files
        for name in there.files:
            np.testing.assert_array_equal(here[name], there[name])
    summary, other = summary_of(folder), summary_of(expected)
    for key in ("deployment", "status", "impulses", "events", "warnings", "restraints"):
        assert summary[key] == other[key]
    assert summary["solver"]["steps"] == other["solver"]["steps"]
    steps, others = (read_kept(each / "checkpoint.npz").history for each in (folder, expected))
    np.testing.assert_array_equal(steps, others)


@pytest.mark.parametrize("frame", [1, 4, 5, 9])
@pytest.mark.parametrize("when", ["before", "after"])
@pytest.mark.parametrize("observer", [MetricsCsv, VtuSeries, Recorder, Checkpoint])
def test_run_that_is_killed_between_two_files_of_a_frame_is_gone_on_with_bit_for_bit(
    observer, when, frame, whole, tmp_path
):
    out = tmp_path / "out"

    def fly_and_die():
        dies(observer, frame, when=when)
        return main(["run", str(write_shot(tmp_path, SHOT)), "-o", str(out)])

    killed(fly_and_die)
    if frame == 1 and (observer, when) != (Checkpoint, "after"):
        assert main(["run", "--resume", str(out)]) == 2  # there is nothing yet
        return
    run("--resume", out)
    assert_same_bits(out, whole)
    (resume,) = summary_of(out)["resumes"]
    done = frame if (observer, when) == (Checkpoint, "after") else frame - 1
    assert resume == {"time": nd.Trajectory.load(whole).times[done - 1], "end": 0.1}


LONG = SHOT.replace("cells = 4", "cells = 8").replace("frames = 9", "frames = 121")


def test_run_that_is_killed_again_and_again_is_gone_on_with_bit_for_bit(tmp_path):
    """By SIGKILL at random moments, each time further on; the restart of a resumed run is killed too."""
    expected = flown(tmp_path, LONG)
    rng = np.random.default_rng(7)
    out = tmp_path / "stopped"
    file = str(tmp_path / "shot.toml")
    kills = 0
    for count in np.sort(rng.integers(1, 115, 8)):
        resume = (out / "checkpoint.npz").exists()
        arguments = ["--resume", str(out)] if resume else [file, "-o", str(out)]
        pid = child(lambda arguments=arguments: main(["run", *arguments]))
        deadline = time.monotonic() + 30
        while (
            not (out / "frames" / f"frame_{count:06d}.vtu").exists() or not (out / "checkpoint.npz").exists()
        ):
            assert time.monotonic() < deadline
            time.sleep(1e-3)
        time.sleep(rng.uniform(0, 0.01))
        os.kill(pid, signal.SIGKILL)
        kills += os.WIFSIGNALED(os.waitpid(pid, 0)[1])
    assert kills >= 6
    run("--resume", out)
    assert_same_bits(out, expected)
    assert len(summary_of(out)["resumes"]) >= kills


# Free: reactions are known to the integrator's accuracy only, and so is their impulse.
FREE = SHOT.replace("fast", "accurate").replace('"explicit"', '"{}"').replace(HELD_CENTRE, "")


@pytest.mark.parametrize("method", ["ida", "cvode_bdf", "radau"])
def test_bullets_area_energy_and_momentum_survive_a_kill_with_other_methods(method, tmp_path):
    text = FREE.format(method)
    if method == "radau":
        text = text.replace("end = 0.1", "end = 0.05").replace("cells = 4", "cells = 2")
    expected = flown(tmp_path, text)
    out = tmp_path / "stopped"
    for k, frame in enumerate((4, 2)):  # in the first flight, and in the second one after that
        arguments = ["--resume", str(out)] if k else [str(tmp_path / "shot.toml"), "-o", str(out)]

        def fly_and_die(arguments=arguments, frame=frame):
            dies(Checkpoint, frame, when="after")
            return main(["run", *arguments])

        killed(fly_and_die)
    run("--resume", out)
    here, there = nd.Trajectory.load(out), nd.Trajectory.load(expected)
    np.testing.assert_array_equal(here.times, there.times)
    simulation = nd.read_scenario(tmp_path / "shot.toml").build()
    bullets = simulation.system.net.nodes_of("corners")
    distance = np.linalg.norm((here.positions - there.positions)[:, bullets], axis=2)
    assert distance.max() < 1e-3
    rows, others = (
        np.genfromtxt(folder / "metrics.csv", delimiter=",", names=True) for folder in (out, expected)
    )
    np.testing.assert_allclose(rows["mouth_area"], others["mouth_area"], atol=0.01)  # 1 % of the net's 1 m²
    energy = others["kinetic_energy"][0]
    for name in ("kinetic_energy", "elastic_energy", "dissipated_energy", "external_work", "energy_residual"):
        np.testing.assert_allclose(rows[name], others[name], atol=0.005 * energy)
    scale = simulation.system.mass @ np.linalg.norm(simulation.start.v, axis=1)
    impulse = here.external_impulse - here.external_impulse[0]
    for axis, name in enumerate("xyz"):
        momentum = rows[f"momentum_{name}"]
        np.testing.assert_allclose(momentum - momentum[0], impulse[:, axis], atol=1e-9 * scale)


WATCHED = SHOT.replace(
    "[solver]",
    """\
[[events]]
name = "open"
figure = "largest_mouth_area"
action = "next_phase"
[[events]]
name = "far"
figure = "distance"
value = 0.18
action = "stop"
[solver]""",
)


@pytest.fixture(scope="module")
def watched(tmp_path_factory):
    """Output folder of the shot with two events, of which one stops it between frames."""
    return flown(tmp_path_factory.mktemp("watched"), WATCHED)


@pytest.mark.parametrize("frame", [3, 5, 7, 8])
def test_events_happen_once_in_a_run_that_is_killed(frame, watched, tmp_path):
    out = tmp_path / "out"

    def fly_and_die():
        dies(Checkpoint, frame, when="after")
        return main(["run", str(write_shot(tmp_path, WATCHED)), "-o", str(out)])

    killed(fly_and_die)
    run("--resume", out)
    assert_same_bits(out, watched)
    events = summary_of(out)["events"]
    assert [event["name"] for event in events] == ["open", "far"]
    assert events == summary_of(watched)["events"]
    times = nd.Trajectory.load(out).times
    assert len(times) == 8  # the last of the event that stops the flight
    assert times[-1] == events[-1]["found"] < 0.0875


def test_run_that_is_killed_after_its_last_frame_flies_no_further_than_the_event_that_stopped_it(tmp_path):
    """IDA starts afresh, so that it would find the event at another instant."""
    text = WATCHED.replace('"explicit"', '"ida"')
    expected, out = flown(tmp_path, text), tmp_path / "stopped"

    def fly_and_die():
        dies(Checkpoint, 8, when="after")
        return main(["run", str(tmp_path / "shot.toml"), "-o", str(out)])

    killed(fly_and_die)
    run("--resume", out)
    assert_same_bits(out, expected)


def test_run_that_an_event_has_stopped_is_not_flown_on(watched, capsys):
    for arguments, message in [
        ((), "this run has finished"),
        (("--until", 1), "an event has stopped this run"),
    ]:
        assert message in refused(capsys, "--resume", watched, *arguments)


# Stops that Python sees


def stop_at(monkeypatch, frame, error):
    write_frame = VtuSeries.__call__

    def stop(self, state):
        if self.frame_count == frame - 1:
            raise error
        write_frame(self, state)

    with monkeypatch.context() as patch:
        patch.setattr(VtuSeries, "__call__", stop)
        yield


@pytest.mark.parametrize(
    ("error", "code", "status"),
    [(KeyboardInterrupt(), 130, "interrupted"), (nd.RunError("no more"), 1, "failed: no more")],
)
def test_interrupted_and_failed_runs_are_gone_on_with_bit_for_bit(
    error, code, status, whole, tmp_path, monkeypatch, capsys
):
    out = tmp_path / "out"
    for _ in stop_at(monkeypatch, 6, error):
        assert main(["run", str(write_shot(tmp_path, SHOT)), "-o", str(out)]) == code
    assert summary_of(out)["status"] == status
    assert not {name for name in files_of(out) if name.endswith(".log")}
    for _ in stop_at(monkeypatch, 8, error):
        assert main(["run", "--resume", str(out)]) == code
    assert "the 7 frames up to then are in" in capsys.readouterr().err
    run("--resume", out)
    assert_same_bits(out, whole)
    assert "9 frames in" in capsys.readouterr().out


def test_run_that_was_killed_while_it_wrote_its_last_files_is_finished(whole, tmp_path):
    out = tmp_path / "out"

    def fly_and_die():
        Recorder.end = lambda self: die()
        return main(["run", str(write_shot(tmp_path, SHOT)), "-o", str(out)])

    killed(fly_and_die)
    assert "trajectory.npz" not in files_of(out)
    run("--resume", out)
    assert_same_bits(out, whole)


# Further on


def test_finished_run_is_flown_on_with_frames_at_its_spacing(whole, copied):
    run("--resume", copied, "--until", "0.13")
    run("--resume", copied, "--until", "0.15")
    here, there = nd.Trajectory.load(copied), nd.Trajectory.load(whole)
    spacing = 0.1 / 8
    np.testing.assert_allclose(here.times, [*(spacing * np.arange(11)), 0.13, 11 * spacing, 0.15], atol=1e-15)
    for name in ("times", "positions", "velocities", "accelerations", "peak_tension"):
        np.testing.assert_array_equal(getattr(here, name)[:9], getattr(there, name))
    summary = summary_of(copied)
    assert summary["status"] == "finished"
    assert (
        summary["solver"]["end"] == summary["solver"]["reached"] == summary["deployment"]["end_time"] == 0.15
    )
    assert summary["solver"]["steps"] > summary_of(whole)["solver"]["steps"]
    assert summary["resumes"] == [{"time": 0.1, "end": 0.13}, {"time": 0.13, "end": 0.15}]
    assert [t for t, _ in read_series(copied / "series.pvd")] == here.times.tolist()
    assert (copied / "scenario.toml").read_text(encoding="utf-8") == SHOT


def test_flight_that_is_flown_on_is_the_longer_flight(copied, tmp_path):
    """Bit for bit but for the stop at the former end, which shortens one chunk of steps."""
    run("--resume", copied, "--until", "0.2")
    longer = SHOT.replace("end = 0.1\nacc", "end = 0.2\nacc").replace("frames = 9", "frames = 17")
    expected = flown(tmp_path / "longer", longer)
    here, there = (
        np.genfromtxt(folder / "metrics.csv", delimiter=",", names=True) for folder in (copied, expected)
    )
    np.testing.assert_allclose(here["time"], there["time"], atol=1e-15)
    for name in ("mouth_area", "distance", "kinetic_energy", "dissipated_energy"):
        # the flight is chaotic; one step of another length is a disturbance of round-off times its growth
        np.testing.assert_allclose(here[name], there[name], rtol=0.01, atol=0.01)


def test_killed_run_that_is_flown_on_keeps_its_new_end(copied, tmp_path):
    shutil.copytree(copied, tmp_path / "never killed")
    run("--resume", tmp_path / "never killed", "--until", "0.15")

    def fly_and_die():
        dies(VtuSeries, 1, when="before")  # before the first new checkpoint
        return main(["run", "--resume", str(copied), "--until", "0.15"])

    killed(fly_and_die)
    run("--resume", copied)
    assert_same_bits(copied, tmp_path / "never killed")
    assert summary_of(copied)["resumes"] == [{"time": 0.1, "end": 0.15}] * 2


def test_stopped_run_may_end_sooner_and_then_later(whole, tmp_path, monkeypatch):
    out = tmp_path / "out"
    for _ in stop_at(monkeypatch, 4, KeyboardInterrupt()):
        main(["run", str(write_shot(tmp_path, SHOT)), "-o", str(out)])
    run("--resume", out, "--until", "0.075")
    assert len(nd.Trajectory.load(out)) == 7
    run("--resume", out, "--until", "0.1")
    here, there = nd.Trajectory.load(out), nd.Trajectory.load(whole)
    np.testing.assert_allclose(here.times, there.times, atol=1e-15)  # 0.075 is not 6/8 of 0.1 to the last bit
    # the phase that ends sooner has other steps
    np.testing.assert_array_equal(here.positions[:5], there.positions[:5])


def test_frames_of_a_longer_flight_keep_their_spacing_and_end_at_the_end():
    times = np.linspace(1.0, 2.0, 5)
    np.testing.assert_array_equal(times_to(2.0, times, 1.0), times)
    np.testing.assert_array_equal(times_to(3.0, times, 2.0), np.linspace(1.0, 3.0, 9))
    np.testing.assert_array_equal(times_to(1.6, times, 1.25), [1.0, 1.25, 1.5, 1.6])
    for near in (2.25 - 1e-12, 2.25 + 1e-12):
        np.testing.assert_array_equal(times_to(2.5, times, near), [1.0, 1.25, 1.5, 1.75, 2.0, 2.5])
    np.testing.assert_array_equal(
        times_to(2.25 + 1e-12, times, 2.0), [1.0, 1.25, 1.5, 1.75, 2.0, 2.25 + 1e-12]
    )


def test_tables_that_end_before_the_new_end_are_named(tmp_path, capsys):
    (tmp_path / "g.csv").write_text("t,x,y,z\n0,0,0,0\n0.12,0,0,1\n")
    table = SHOT.replace("g = [3.0, 0.0, -9.81]\nbegin = 0.033\nend = 0.05", 'g = { file = "g.csv" }')
    out = flown(tmp_path, table)
    capsys.readouterr()
    assert main(["run", "--resume", str(out), "--until", "0.2"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "the table reaches from 0 to 0.12 s, but the flight lasts from 0 to 0.2 s" in line
    run("--resume", out, "--until", "0.12")
    (tmp_path / "g.csv").write_text("t,x,y,z\n0,0,0,0\n0.12,0,0,2\n1,0,0,0\n")
    capsys.readouterr()
    assert main(["run", "--resume", str(out), "--until", "0.2"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "g.csv, which " in line
    assert "has changed since the checkpoint at t = 0.12 s was written" in line
    (tmp_path / "g.csv").unlink()
    assert main(["run", "--resume", str(out), "--until", "0.2"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "cannot be read: No such file" in line


def test_scenario_that_lies_in_its_own_output_folder_is_gone_on_with(tmp_path, capsys):
    out = tmp_path / "out"
    out.mkdir()
    (out / "g.csv").write_text("t,x,y,z\n0,0,0,0\n1,0,0,1\n")
    file = out / "scenario.toml"
    file.write_text(
        SHOT.replace("g = [3.0, 0.0, -9.81]\nbegin = 0.033\nend = 0.05", 'g = { file = "g.csv" }')
    )
    run(file, "-o", out)
    run("--resume", out, "--until", "0.11")
    assert summary_of(out)["solver"]["reached"] == 0.11


# Files that are not as they were left


def refused(capsys, *arguments):
    capsys.readouterr()
    assert main(["run", *map(str, arguments)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    return line


def test_checkpoint_cut_short_anywhere_is_one_line(copied, capsys):
    checkpoint = copied / "checkpoint.npz"
    data = checkpoint.read_bytes()
    for size in [*range(0, len(data), len(data) // 60), *range(len(data) - 30, len(data))]:
        checkpoint.write_bytes(data[:size])
        line = refused(capsys, "--resume", copied, "--until", 1)
        assert "checkpoint.npz is not a checkpoint of netdae, or cut short" in line
    assert read_series(copied / "series.pvd")  # nothing was touched
    checkpoint.write_bytes(data)
    run("--resume", copied, "--until", "0.11")


def test_checkpoint_with_a_changed_byte_is_refused_or_as_it_was(copied):
    """A byte of an array breaks its checksum; one that zip does not look at changes nothing."""
    checkpoint = copied / "checkpoint.npz"
    data = checkpoint.read_bytes()
    sound = read_kept(checkpoint)
    rng = np.random.default_rng(3)
    for place in rng.integers(len(data), size=150):
        checkpoint.write_bytes(data[:place] + bytes([data[place] ^ 0x10]) + data[place + 1 :])
        with contextlib.suppress(nd.InputError):
            kept = read_kept(checkpoint)
            np.testing.assert_array_equal(kept.state.x, sound.state.x)
            assert kept.memory.notes == sound.memory.notes


def test_changed_scenario_is_refused(copied, capsys):
    with (copied / "scenario.toml").open("a") as file:
        file.write("# a note\n")
    line = refused(capsys, "--resume", copied, "--until", 1)
    assert "scenario.toml has changed since the checkpoint at t = 0.1 s was written: put it back" in line


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda out: (out / "metrics.csv").unlink(), "metrics.csv cannot be gone on from: No such file"),
        (lambda out: shorten(out / "metrics.csv", 5), "metrics.csv has 4 rows, expected 9 at least"),
        (lambda out: (out / "metrics.csv").write_text("a,b\n" * 12), "its first line is not that of a run"),
        (lambda out: (out / "trajectory.npz").unlink(), "trajectory.npz is not there"),
        (
            lambda out: (out / "trajectory.npz").write_bytes(b"PK"),
            "is not a trajectory of netdae, or damaged",
        ),
        (lambda out: (out / "series.pvd").unlink(), "series.pvd cannot be read"),
        (lambda out: (out / "frames" / "frame_000003.vtu").unlink(), "frame_000003.vtu is missing"),
        (lambda out: (out / "scenario.toml").unlink(), "scenario.toml: the scenario cannot be read"),
        (lambda out: without(out / "checkpoint.npz", "history.npy"), "steps.log cannot be gone on from"),
        (lambda out: without(out / "checkpoint.npz", "notes.npy"), "holds a State alone"),
        (lambda out: without(out / "checkpoint.npz", "v.npy"), "cut short: v is not in it"),
    ],
)
def test_folder_of_which_a_file_is_gone_or_spoilt_is_one_line(spoil, message, copied, capsys):
    spoil(copied)
    checkpoint, summary = ((copied / name).read_bytes() for name in ("checkpoint.npz", "summary.json"))
    for _ in range(2):
        assert message in refused(capsys, "--resume", copied, "--until", 1)
        assert (copied / "checkpoint.npz").read_bytes() == checkpoint
        assert (copied / "summary.json").read_bytes() == summary


def shorten(path, lines):
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:lines]))


def without(path, name):
    with zipfile.ZipFile(path) as source:
        parts = {each: source.read(each) for each in source.namelist() if each != name}
    with zipfile.ZipFile(path, "w") as target:
        for each, data in parts.items():
            target.writestr(each, data)


def test_checkpoint_of_another_version_is_refused(copied, capsys, monkeypatch):
    monkeypatch.setattr("netdae.__version__", "9.0")
    assert "its checkpoint is of netdae 0.1.0, this is 9.0" in refused(
        capsys, "--resume", copied, "--until", 1
    )
    monkeypatch.undo()
    monkeypatch.setattr("netdae.output.checkpoint.FORMAT", 2)
    assert "has the format 1 of another netdae, expected 2" in refused(
        capsys, "--resume", copied, "--until", 1
    )


def test_wrong_folders_and_arguments_are_one_line(whole, tmp_path, capsys):
    file = write_shot(tmp_path, SHOT)
    empty = tmp_path / "empty"
    empty.mkdir()
    unbegun = tmp_path / "unbegun"
    unbegun.mkdir()
    (unbegun / "metrics.csv").write_text("")
    (tmp_path / "many" / "member_000").mkdir(parents=True)
    for arguments, message in [
        (["--resume", whole], "this run has finished, at t = 0.1 s: give --until a later time to fly on"),
        (["--resume", whole, "--until", 0.1], "--until is 0.1 s, but "),
        (["--resume", whole, "--until", 0.05], "has come to t = 0.1 s: give a later time"),
        (["--resume", whole, "--until", "inf"], "--until is inf: give a time in s"),
        (["--resume", whole, "--until", "1e9"], "takes 8e+10 frames 0.0125 s apart: give a time that takes"),
        (["--resume", whole, "--until", "nan"], "--until is nan: give a time in s"),
        (["--resume", whole, "--until", "soon"], '"soon"'),
        (["--resume", tmp_path / "none"], "none is not there: give the output folder of a run"),
        (["--resume", file], "shot.toml is a file, not a folder: give the output folder of a run"),
        (["--resume", ""], "is empty, expected a name"),
        (["--resume", empty], "this is not the folder of a run"),
        (
            ["--resume", unbegun],
            "there is no checkpoint.npz, since its run was stopped before the first frame",
        ),
        (["--resume", tmp_path / "many"], "an ensemble is in this folder: resume one of its members"),
        ([file, "--resume", whole], "shot.toml does not go with --resume"),
        (["--resume", whole, "-o", empty], "--output does not go with --resume"),
        (["--resume", whole, "--overwrite"], "--overwrite does not go with --resume"),
        (["--resume", whole, "--ensemble", 3], "--ensemble does not go with --resume"),
        (["--resume", whole, "--all-frames"], "--all-frames does not go with --resume"),
        ([file, "--until", 3], "--until is for a run that is resumed: give --resume DIR too"),
        (["--until", 3], "--until is for a run that is resumed: give --resume DIR too"),
    ]:
        assert message in refused(capsys, *arguments)


# Several at once, many frames, ensembles


def test_two_runs_never_write_into_one_folder_and_a_dead_one_locks_nothing(copied, tmp_path, capsys):
    def fly_and_wait():
        VtuSeries.end = lambda self: time.sleep(60)
        return main(["run", "--resume", str(copied), "--until", "0.11"])

    pid = child(fly_and_wait)
    try:
        deadline = time.monotonic() + 30
        while read_checkpoint(copied / "checkpoint.npz").t < 0.11:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        for arguments in (["--resume", copied], [write_shot(tmp_path, SHOT), "-o", copied, "--overwrite"]):
            line = refused(capsys, *arguments)
            assert f"another run (process {pid}) is writing into this folder" in line
    finally:
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
    run("--resume", copied)
    assert summary_of(copied)["solver"]["reached"] == 0.11
    assert "run.lock" not in files_of(copied)


def test_frames_after_the_checkpoint_are_taken_away(whole, copied):
    system = nd.read_scenario(whole / "scenario.toml").build().system
    (copied / "frames" / "frame_000009.vtu.part").write_bytes(b"<VTKFile")
    (copied / "frames" / "notes.txt").write_text("mine")
    for _ in range(2):
        VtuSeries(copied / "series.pvd").resume(system, {"frames": np.array(3)})
        kept = [f"frame_{number:06d}.vtu" for number in range(3)]
        assert sorted(file.name for file in (copied / "frames").iterdir()) == [*kept, "notes.txt"]
        assert read_series(copied / "series.pvd") == [
            (t, copied / file.relative_to(whole)) for t, file in read_series(whole / "series.pvd")[:3]
        ]


def test_frames_that_the_series_does_not_name_yet_are_kept(whole, tmp_path):
    """As of the thousandth frame on: here the .pvd is written when the series has grown by half."""
    out = tmp_path / "out"

    def fly_and_die():
        import netdae.output.pvd

        netdae.output.pvd._EVERY_FRAME_UP_TO = 2
        dies(Checkpoint, 6, when="after")
        return main(["run", str(write_shot(tmp_path, SHOT)), "-o", str(out)])

    killed(fly_and_die)
    assert len(read_series(out / "series.pvd")) < 6
    run("--resume", out)
    assert_same_bits(out, whole)


def test_member_of_an_ensemble_is_gone_on_with_from_its_own_start(tmp_path):
    reported = nd.read_scenario(write_shot(tmp_path, SHOT))
    stopped, expected = (
        Member(reported, Ensemble(2, 1e-3, 5), 1, tmp_path / name, False) for name in ("stopped", "expected")
    )

    def fly_and_die():
        dies(Checkpoint, 5, when="after")
        fly_member(stopped, lambda message: None)

    killed(fly_and_die)
    fly_member(expected, lambda message: None)
    run("--resume", stopped.folder / stopped.name)
    assert_same_bits(stopped.folder / stopped.name, expected.folder / expected.name)
    chosen = {"perturb": 1e-3, "seed": 5, "scatter": False}
    assert summary_of(stopped.folder / stopped.name)["member"] == {"number": 1, **chosen}


def test_a_state_alone_is_no_run(tmp_path):
    checkpoint = Checkpoint(tmp_path / "c.npz")
    state = nd.State.at(np.zeros((2, 3)))
    checkpoint(state)
    assert read_checkpoint(checkpoint.path).t == 0.0
    with pytest.raises(nd.InputError, match="holds a State alone, nothing to go on from"):
        read_kept(checkpoint.path)
