"""Commands and examples of README and manual, and every script, run: small, but as they stand."""

from __future__ import annotations

import json
import re
import runpy
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from netdae.cli import main
from netdae.mesh.io import read_net
from netdae.scenario.build import Build
from netdae.scenario.schema import ScenarioData
from netdae.solvers.options import PRESETS

PROJECT = Path(__file__).resolve().parent.parent
README = (PROJECT / "README.md").read_text(encoding="utf-8")
PAGES = {
    file.stem: file.read_text(encoding="utf-8") for file in sorted((PROJECT / "netdae/manual").glob("*.md"))
}
SCRIPTS = PROJECT / "scripts"


def blocks(language: str, text: str = README) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", text, flags=re.DOTALL)


def test_every_block_is_run_by_a_test_below() -> None:
    def counted(text: str) -> dict[str, int]:
        languages = re.findall(r"^```(\w+)$", text, flags=re.MULTILINE)
        assert text.count("```") == 2 * len(languages)
        return {language: languages.count(language) for language in languages}

    assert counted(README) == {"toml": 1, "python": 1}
    assert {name: found for name, text in PAGES.items() if (found := counted(text))} == {
        "scenario": {"python": 1, "toml": 4},
        "python": {"python": 2},
    }


def commands() -> list[list[str]]:
    return [shlex.split(line) for line in re.findall(r"^    (python3 .*)$", README, flags=re.MULTILINE)]


def shortened(scenario: str, **replaced: str) -> str:
    """The scenario with the values of some keys replaced."""
    for key, value in replaced.items():
        scenario, count = re.subn(rf"^{key} = [^#\n]*", f"{key} = {value} ", scenario, flags=re.MULTILINE)
        assert count == 1, f"{key} stands {count} times"
    return scenario


def run_script(name: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(SCRIPTS / name), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=PROJECT)


def test_the_first_two_commands_are_the_flight_and_the_tests() -> None:
    flight, tests = commands()
    assert flight[:4] == ["python3", "scripts/in_venv.py", "netdae", "run"]
    assert (PROJECT / flight[4]).is_file()
    assert tests == ["python3", "scripts/in_venv.py", "--extra", "test", "pytest"]
    assert "scripts/in_venv.py --extra test pytest" in (PROJECT / ".ci/run").read_text()


def test_the_scenario_of_the_readme_flies(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = blocks("toml")[0]
    file = tmp_path / "readme.toml"
    file.write_text(shortened(text, cells="4", end="0.05", frames="3"), encoding="utf-8")
    assert main(["run", str(file), "-o", str(tmp_path / "out")]) == 0, capsys.readouterr().err
    summary = json.loads((tmp_path / "out/summary.json").read_text(encoding="utf-8"))
    assert summary["status"] == "finished"
    written = {path.name for path in (tmp_path / "out").iterdir()}
    expected = {
        "series.pvd",
        "frames",
        "metrics.csv",
        "summary.json",
        "trajectory.npz",
        "checkpoint.npz",
        "scenario.toml",
    }
    assert written == expected


def test_the_scenario_of_the_readme_is_the_shipped_one() -> None:
    shipped_text = (SCRIPTS / "corner_shot.toml").read_text(encoding="utf-8")
    told, shipped = (
        ScenarioData.model_validate(tomllib.loads(text)) for text in (blocks("toml")[0], shipped_text)
    )
    for section in ("material", "damping", "masses", "initial", "loads", "solver", "output"):
        assert getattr(told, section) == getattr(shipped, section), section


def test_the_scenario_of_the_manual_is_that_of_the_readme() -> None:
    assert blocks("toml", PAGES["scenario"])[1] == blocks("toml")[0]


def test_the_mission_of_the_manual_flies() -> None:
    _, scenario, mission, closing = (tomllib.loads(text) for text in blocks("toml", PAGES["scenario"]))
    net = {**scenario["net"], "cells": 6}
    small = {**scenario, **mission, "net": net, "solver": {"end": 0.01}, "output": {"frames": 3}}
    small["initial"] = {**mission["initial"], "folds": [2, 2], "canister": {"side": 3.0, "depth": 0.3}}
    simulation = Build(PROJECT / "mission.toml", "mission", ScenarioData.model_validate(small)).simulation()
    states = list(simulation.integrate())
    assert states[-1].t == 0.01
    closed = ScenarioData.model_validate({**scenario, **closing})
    assert len(Build(PROJECT / "closing.toml", "closing", closed).simulation().system.reels) == 5
    assert sorted(simulation.launch.held.times.tolist()) == [0.002, 0.004]
    assert [event.name for event in simulation.events.events] == ["far", "largest_mouth_area"]


def test_the_net_from_gmsh_flies(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (script,) = blocks("python", PAGES["scenario"])
    section, scenario, *_ = blocks("toml", PAGES["scenario"])
    (tmp_path / "net.py").write_text(script, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "net.py"], capture_output=True, text=True, check=False, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    net = read_net(tmp_path / "net.msh")
    assert (net.node_count, net.cable_count) == (7 + 12 * 3, 12 * 4)
    assert {name: len(nodes) for name, nodes in net.node_groups.items()}["corners"] == 6
    assert {name: len(cables) for name, cables in net.cable_groups.items()} == {
        "all": 48,
        "border": 24,
        "inner": 24,
    }
    _, after = scenario.split("[[material]]", maxsplit=1)
    file = tmp_path / "own.toml"
    file.write_text(section + "\n[[material]]" + shortened(after, end="0.05", frames="3"), encoding="utf-8")
    assert main(["info", str(tmp_path / "net.msh")]) == 0
    assert main(["check", str(file)]) == 0
    assert main(["run", str(file), "-o", str(tmp_path / "out")]) == 0, capsys.readouterr().err
    summary = json.loads((tmp_path / "out/summary.json").read_text(encoding="utf-8"))
    assert summary["status"] == "finished"
    # the mouth starts at 0.16 of the hexagon's area, and opens
    hexagon = 1.5 * np.sqrt(3.0) * 2.5**2
    assert 0.16 * hexagon < summary["deployment"]["final_mouth_area"] < 0.2 * hexagon


def test_the_python_example_flies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    (text,) = blocks("python")
    assert len(text.strip().splitlines()) <= 15
    small = text.replace("cells=20", "cells=4").replace(
        "np.linspace(0.0, 1.0, 51)", "np.linspace(0.0, 0.05, 3)"
    )
    assert small != text
    file = tmp_path / "example.py"
    file.write_text(small + "".join(blocks("python", PAGES["python"])), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names = runpy.run_path(str(file))
    area, steps = capsys.readouterr().out.split()
    # the net starts as a 2 m square, whose mouth opens at first
    assert 4.0 <= float(area) < 5.0
    assert int(steps) > 5
    assert len(names["flight"]) == 3
    assert (tmp_path / "out/python/series.pvd").is_file()
    nd = names["nd"]
    node = np.array([[12]])
    compiled = nd.ElementForce(names["BUNGEE"], node, names["Bungees"](np.array([20.0])))
    start = nd.State.at(names["start"].x + np.array([0.0, 0.0, 0.1]))
    ends = []
    for force in (names["Bungee"](node), compiled):
        system = nd.System(names["net"], names["cord"], damping=nd.NoDamping(), forces=[force])
        flight = nd.simulate(system, start, [0.0, 0.02])
        energy = [system.kinetic_energy(each.v) + system.elastic_energy(each.x) for each in flight]
        assert energy[1] == pytest.approx(energy[0], rel=2e-2)  # IDA's own error with one light knot: 0.5 %
        assert system.kinetic_energy(flight[1].v) > 0.1 * energy[0]
        ends.append(flight[1].x)
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-9)  # one force, written twice


def test_the_verbs_of_the_table_are_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    listed = [
        shlex.split(line.replace("[", "").replace("]", ""))
        for line in re.findall(r"^\| `netdae (.*?)`", README, flags=re.M)
    ]
    verbs = [line[0] for line in listed]
    assert {*verbs} == {
        "run",
        "render",
        "plot",
        "forces",
        "check",
        "verify",
        "mesh",
        "info",
        "schema",
        "manual",
    }
    assert "--ensemble" in listed[1]
    assert "--resume" in listed[2]
    net = tmp_path / "net.vtu"
    mesh = [word if word != "net.vtu" else str(net) for word in listed[verbs.index("mesh")]]
    assert main(mesh) == 0
    assert main(["info", str(net)]) == 0
    assert "441" in capsys.readouterr().out
    assert main(["schema"]) == 0
    json.loads(capsys.readouterr().out)


def test_accuracy_script_prints_a_line_for_each_preset() -> None:
    done = run_script("accuracy.py", "--cells", 3, "--end", 0.02, "--sharp", 2, "--runs", 1, "--rtol", 1e-6)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()[2:]
    rows = {line[:19].strip(): [float(word) for word in line[19:].split()] for line in lines}
    presets = [f"{method}, {accuracy}" for method in ("ida", "explicit") for accuracy in PRESETS]
    assert list(rows) == ["sharp", *presets]
    # the first hundredths of a second are not chaotic: even the loosest preset keeps bullets within 1 mm
    assert all(values[0] < 1.0 for values in rows.values())
    # sharper presets take more steps
    for method in ("ida", "explicit"):
        steps = [rows[f"{method}, {accuracy}"][4] for accuracy in PRESETS]
        assert steps == sorted(steps)
        assert steps[0] < steps[-1]


def test_the_manual_has_what_each_preset_keeps() -> None:
    for method in ("ida", "explicit"):
        for accuracy in PRESETS:
            row = rf"^\| {method} \| {accuracy} \|( [\d.−]+ \|){{6}}$"
            assert re.search(row, PAGES["accuracy"], flags=re.MULTILINE), f"{method}, {accuracy}"


def test_venv_script_says_how_it_is_called() -> None:
    done = run_script("in_venv.py")
    assert done.returncode == 2
    assert "python3 scripts/in_venv.py netdae run" in done.stderr


def test_every_script_is_run_by_a_test() -> None:
    named = "".join(path.read_text(encoding="utf-8") for path in (PROJECT / "tests").glob("test_*.py"))
    run = [script for script in SCRIPTS.glob("*.py") if script.name in named]
    imported = "".join(script.read_text(encoding="utf-8") for script in SCRIPTS.glob("benchmark*.py"))
    for script in SCRIPTS.glob("*.py"):  # the scenarios are flown by test_cli, all that are there
        part_of_benchmark = re.search(rf"^\s*(from|import) {script.stem}\b", imported, flags=re.MULTILINE)
        assert script in run or part_of_benchmark, f"no test runs {script.name}"
