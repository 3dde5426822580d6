"""The script that runs commands in the project's own environment: repairs, refusals, exit codes; no network."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parent.parent / "scripts" / "in_venv.py"
PYPROJECT = '[project]\nname = "netdae"\n[project.optional-dependencies]\ntest = ["pytest"]\n'

pytestmark = pytest.mark.skipif(os.name != "posix", reason="the stand-ins are scripts of a shell")


class Stage:
    """A project folder with the script in it; pip and venv are stand-ins that leave the files of the true ones."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.folder = folder
        self.made: list[bool] = []
        self.installed: list[str] = []
        self.pip_fails = ""
        (folder / "scripts").mkdir(parents=True)
        shutil.copy(SCRIPT, folder / "scripts")
        (folder / "pyproject.toml").write_text(PYPROJECT)
        self.script = self._loaded()
        self._run = subprocess.run
        monkeypatch.setattr(subprocess, "run", self._stand_in)
        monkeypatch.setattr("venv.create", self._create)
        monkeypatch.setattr(signal, "signal", lambda *arguments: None)  # of the tests' own process

    def _loaded(self):
        spec = spec_from_file_location("in_venv", self.folder / "scripts" / "in_venv.py")
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    def moved(self, folder: Path) -> None:
        self.folder.rename(folder)
        self.folder = folder
        self.script = self._loaded()

    def _create(self, home, *, with_pip, clear=False) -> None:
        assert with_pip
        if clear and Path(home).exists():
            shutil.rmtree(home)
        self.made.append(clear)
        self.executable("python", "exit 0")

    def _stand_in(self, command, **options):
        if command[1:3] != ["-m", "pip"]:
            return self._run(command, **options)
        if not Path(command[0]).exists():
            raise FileNotFoundError(command[0])
        if "install" not in command:
            return self._run(command, **options)
        if self.pip_fails:
            raise subprocess.CalledProcessError(1, command, stderr=self.pip_fails)
        self.installed.append(command[-1])
        # as pip writes commands: with the folder of the environment in them
        self.executable("netdae", f'[ -e {self.folder}/.venv/bin/python ] && exit "${{1:-0}}"')
        return subprocess.CompletedProcess(command, 0)

    def executable(self, name: str, body: str) -> None:
        file = self.folder / ".venv" / "bin" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"#!/bin/sh\n{body}\n")
        file.chmod(0o755)

    def marks(self) -> list[str]:
        return sorted(each.name for each in (self.folder / ".venv").glob("netdae-installed-*"))


@pytest.fixture
def stage(tmp_path, monkeypatch):
    return Stage(tmp_path / "project", monkeypatch)


def one_line(capsys) -> str:
    (line,) = [each for each in capsys.readouterr().err.splitlines() if "installing into" not in each]
    return line


def test_environment_is_made_once_and_the_exit_code_is_the_commands(stage):
    assert stage.script.main(["netdae", "3"]) == 3
    assert stage.script.main(["netdae"]) == 0
    assert len(stage.made) == len(stage.installed) == 1
    assert stage.script.main(["--extra", "test", "netdae"]) == 0
    assert stage.installed[1] == f"{stage.folder}[test]"
    assert len(stage.made) == 1
    assert stage.marks() == ["netdae-installed-plain", "netdae-installed-test"]


def test_newer_pyproject_is_installed_into_the_same_environment(stage):
    stage.script.main(["netdae"])
    later = time.time() + 5
    os.utime(stage.folder / "pyproject.toml", (later, later))
    assert stage.script.main(["netdae"]) == 0
    assert (len(stage.made), len(stage.installed)) == (1, 2)


def test_environment_left_without_pip_is_made_anew(stage):
    stage.executable("python", "exit 1")  # as a first installation that was interrupted leaves it
    (stage.folder / ".venv" / "rest").write_text("")
    assert stage.script.main(["netdae"]) == 0
    assert len(stage.made) == 1
    assert not (stage.folder / ".venv" / "rest").exists()


def test_moved_project_gets_an_environment_anew(stage, tmp_path):
    stage.script.main(["netdae"])
    stage.moved(tmp_path / "elsewhere")
    assert stage.script.main(["netdae"]) == 0
    assert len(stage.made) == len(stage.installed) == 2


def test_failing_pip_is_one_line_and_leaves_no_mark(stage, capsys):
    stage.pip_fails = "WARNING: retrying\nERROR: No matching distribution found for numpy\n\n"
    assert stage.script.main(["netdae"]) == 1
    assert "No matching distribution found for numpy" in one_line(capsys)
    assert stage.marks() == []
    stage.pip_fails = ""
    assert stage.script.main(["netdae"]) == 0


def test_unknown_extra_is_one_line_and_changes_nothing(stage, capsys):
    assert stage.script.main(["--extra", "nosuch", "netdae"]) == 2
    assert one_line(capsys) == "netdae: there is no --extra nosuch: give one of test"
    assert not (stage.folder / ".venv").exists()


def test_unknown_command_is_one_line(stage, capsys):
    assert stage.script.main(["netdea"]) == 2
    assert "no command 'netdea'" in one_line(capsys)


def test_interrupted_installation_is_one_line(stage, capsys, monkeypatch):
    def interrupt(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr("venv.create", interrupt)
    assert stage.script.main(["netdae"]) == 130
    assert "interrupted" in one_line(capsys)


def test_ctrl_c_is_left_to_the_command_and_its_exit_code_handed_on(stage):
    stage.script.main(["netdae"])
    # takes half a second to tidy up, longer than Python would wait for it, then says 130 as netdae does
    stage.executable(
        "netdae", "trap 'sleep 0.5; echo tidy; exit 130' INT\necho ready\nwhile :; do sleep 0.05; done"
    )
    process = subprocess.Popen(
        [sys.executable, str(stage.folder / "scripts" / "in_venv.py"), "netdae"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        assert process.stdout.readline() == "ready\n"
        os.killpg(process.pid, signal.SIGINT)  # a terminal sends it to all processes in front
        shown, error = process.communicate(timeout=20)
    finally:
        process.kill()
    assert (process.returncode, shown, error) == (130, "tidy\n", "")


def test_command_ended_by_a_signal_gives_the_code_of_shells(stage):
    stage.script.main(["netdae"])
    stage.executable("netdae", "kill -TERM $$")
    assert stage.script.main(["netdae"]) == 143
