"""The manual: `netdae manual` prints its pages, and they say all that there is, with links that lead somewhere."""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from importlib.util import find_spec
from pathlib import Path

import pytest

import netdae as nd
from netdae.cli import app, main
from netdae.output.metrics import COLUMNS
from netdae.scenario.schema import ScenarioData

PROJECT = Path(__file__).resolve().parent.parent
FOLDER = PROJECT / "netdae" / "manual"
PAGES = {file.stem: file.read_text(encoding="utf-8") for file in sorted(FOLDER.glob("*.md"))}
README = (PROJECT / "README.md").read_text(encoding="utf-8")
TEXTS = {PROJECT / "README.md": README, **{FOLDER / f"{name}.md": text for name, text in PAGES.items()}}


def without_code(text: str) -> str:
    return re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)


# The verb


def test_the_verb_lists_every_page_with_its_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["manual"]) == 0
    lines = [line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines()]
    assert [name for name, _ in lines] == list(PAGES)
    for name, sentence in lines:
        title, empty, first, end = PAGES[name].splitlines()[:4]
        assert title.startswith("# ")
        assert (empty, end) == ("", "")  # one sentence, alone on its line
        assert sentence == first
        assert re.fullmatch(r"[A-Z].*\w\.", sentence)


@pytest.mark.parametrize("name", list(PAGES))
def test_a_page_prints_as_it_is(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["manual", name]) == 0
    assert capsys.readouterr().out == PAGES[name]


@pytest.mark.parametrize(("asked", "near"), [("scenarios", "scenario"), ("Accuracy", "accuracy")])
def test_an_unknown_page_is_one_line(asked: str, near: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["manual", asked]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    (line,) = told.err.splitlines()
    assert f"{near!r}?" in line
    assert line.endswith(", ".join(PAGES))


def test_a_page_unlike_all_others_is_refused_without_a_guess(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["manual", "nonsense"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith(f"there is no page 'nonsense': the manual has {', '.join(PAGES)}")


def test_two_pages_are_too_many(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["manual", "model", "scenario"]) == 2
    assert "one page at a time" in capsys.readouterr().err


def test_the_pages_are_in_the_package() -> None:
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))
    assert "*.md" in project["tool"]["setuptools"]["package-data"]["netdae.manual"]
    assert (FOLDER / "__init__.py").is_file()


# The scenario page, against the schema

SECTIONS = {  # class in the schema: headings whose tables explain its keys
    "ScenarioData": ("Top level",),
    "MeshFile": ("[net] file",),
    **{
        kind.capitalize(): ("[net]", f'[net] kind = "{kind}"')
        for kind in ("square", "rectangle", "hexagon", "radial", "diamond")
    },
    "Cord": ("[[material]]",),
    "DashpotDamping": ("[damping]", '[damping] kind = "dashpot"'),
    "RayleighDamping": ("[damping]", '[damping] kind = "rayleigh"'),
    "WithoutDamping": ("[damping]",),
    "Mass": ("[[masses]]",),
    "Initial": ("[initial]",),
    "CanisterEntry": ("[initial.canister]",),
    "EjectionEntry": ("[[initial.ejection]]",),
    "SpreadEntry": ("[initial.ejection.spread]",),
    "Hold": ("[[restraints]]",),
    "OrbitEntry": ("[orbit]",),
    "UniformGravity": ("[[loads]]", '[[loads]] kind = "gravity"'),
    "NodalForce": ("[[loads]]", '[[loads]] kind = "nodal"'),
    "SpringEntry": ("[[loads]]", '[[loads]] kind = "spring"'),
    "DragEntry": ("[[loads]]", '[[loads]] kind = "drag"'),
    "SolarPressureEntry": ("[[loads]]", '[[loads]] kind = "solar_pressure"'),
    "AirEntry": ("[[loads]]", '[[loads]] kind = "air"'),
    "Body": ("[[loads.bodies]]",),
    "BodyInAir": ("[[loads.bodies]]",),
    "TetherEntry": ("[tether]",),
    "ChaserEntry": ("[tether.chaser]",),
    "WinchEntry": ("[[closing]]", '[[closing]] kind = "winch"'),
    "DrawcordEntry": ("[[closing]]", '[[closing]] kind = "drawcord"'),
    "PulleyEntry": ("[[pulleys]]", "[[pulleys]] rings"),
    "OwnCord": ("[[pulleys]]", "[[pulleys]] cables"),
    "TargetEntry": ("[target]", "Shapes", "Contact"),
    "TargetSpread": ("[target.spread]",),
    "PartEntry": ("[[target.parts]]", "Shapes", "Contact"),
    "ObstacleEntry": ("[[obstacles]]", "Shapes", "Contact"),
    "EventEntry": ("[[events]]",),
    "Solver": ("[solver]",),
    "Output": ("[output]",),
    "Metrics": ("[metrics]",),
    "TableFile": ("Table of a force, an acceleration or a wind",),
    "MotionFile": ("Table of a motion",),
    "PayoutFile": ("Table of a length paid out",),
    "DensityFile": ("Table of a density",),
}


def schema() -> dict[str, dict]:
    """Class to its part of the schema, of all classes that have keys."""
    root = ScenarioData.model_json_schema()
    return {
        "ScenarioData": root,
        **{name: part for name, part in root["$defs"].items() if "properties" in part},
    }


def rows(heading: str, first: str = "key") -> list[tuple[list[str], list[str]]]:
    """Names in the first cell of each row, and further cells, of the tables under a heading of the scenario page."""
    below = without_code(PAGES["scenario"]).partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
    tables = re.findall(rf"^\| {first} \|.*\n\| ---.*\n((?:\|.*\n)+)", below, flags=re.MULTILINE)
    cells = [re.split(r" *(?<!\\)\| *", line)[1:-1] for table in tables for line in table.splitlines()]
    return [(re.findall(r"`([^`]+)`", name), others) for name, *others in cells]


def test_the_scenario_page_has_the_sections_of_the_schema() -> None:
    assert {*schema()} == {*SECTIONS}
    headings = re.findall(r"^## (.*)$", PAGES["scenario"], flags=re.MULTILINE)
    named = {heading for headings in SECTIONS.values() for heading in headings}
    assert named <= {*headings}
    assert len({*headings}) == len(headings)
    unknown = {heading for heading in headings if rows(heading)} - named
    assert unknown == set()


@pytest.mark.parametrize("section", list(SECTIONS))
def test_every_key_stands_in_one_row_of_its_section(section: str) -> None:
    keys = schema()[section]["properties"]
    said = [name for heading in SECTIONS[section] for names, _ in rows(heading) for name in names]
    assert {key: said.count(key) for key in keys} == dict.fromkeys(keys, 1)


@pytest.mark.parametrize("heading", sorted({each for headings in SECTIONS.values() for each in headings}))
def test_every_row_is_a_key(heading: str) -> None:
    known = {
        key
        for section, headings in SECTIONS.items()
        if heading in headings
        for key in schema()[section]["properties"]
    }
    assert {name for names, _ in rows(heading) for name in names} - known == set()


@pytest.mark.parametrize("section", list(SECTIONS))
def test_defaults_are_those_of_the_schema(section: str) -> None:
    part = schema()[section]
    for names, (default, meaning) in (row for heading in SECTIONS[section] for row in rows(heading)):
        assert meaning
        if default == "as there":
            assert {*names} == {*schema()["Cord"]["properties"]} - {"cables", "prestress"}
            continue
        (key,) = names
        if key not in part["properties"]:
            continue  # of another kind of the same section
        alternative = section in ("MeshFile", *(name for name, of in SECTIONS.items() if "[net]" in of))
        if key in part.get("required", ()):
            assert default.startswith("required") or (alternative and default == "–"), key
            continue
        assert not default.startswith("required"), key
        told = part["properties"][key].get("default")
        if told not in (None, "") and not (isinstance(told, dict) or told == []):
            assert json.loads(default.strip("`")) == told, key


@pytest.mark.parametrize("key", ["figure", "action"])
def test_figures_and_actions_of_events_are_listed(key: str) -> None:
    enum = schema()["EventEntry"]["properties"][key]["enum"]
    assert [name for names, _ in rows("[[events]]", key) for name in names] == enum


@pytest.mark.parametrize("key", ["method", "accuracy"])
def test_choices_of_the_solver_are_listed(key: str) -> None:
    ((_, (_, meaning)),) = [row for row in rows("[solver]") if row[0] == [key]]
    assert re.findall(r'`"(\w+)"`', meaning) == schema()["Solver"]["properties"][key]["enum"]


# The summary page, against a run

STEMS = {  # told as `..._time`
    "largest_mouth_area": ("time", "distance"),
    "largest_corner_area": ("time",),
    "peak_tension": ("time", "cable"),
    "momentum_residual": ("share",),
    "angular_momentum_residual": ("share",),
    **dict.fromkeys(
        ("momentum", "angular_momentum", "external_impulse", "external_angular_impulse"), ("y", "z")
    ),
}


def explained(heading: str) -> set[str]:
    """What the summary page explains under a heading."""
    below = PAGES["summary"].partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
    told = {*re.findall(r"`([a-z_0-9]+)`", below)}
    return told | {f"{stem}_{ending}" for stem, endings in STEMS.items() for ending in endings}


def keys_of(told: object) -> set[str]:
    if isinstance(told, dict):
        return {*told} | {key for value in told.values() for key in keys_of(value)}
    return {key for value in told for key in keys_of(value)} if isinstance(told, list) else set()


def test_every_key_of_a_summary_is_explained(tmp_path: Path) -> None:
    scenario = re.findall(r"```toml\n(.*?)```", README, flags=re.DOTALL)[0]
    for key, value in (("cells", "4"), ("end", "0.05"), ("frames", "3")):
        scenario, count = re.subn(rf"^{key} = [^#\n]*", f"{key} = {value} ", scenario, flags=re.MULTILINE)
        assert count == 1
    file = tmp_path / "readme.toml"
    file.write_text(scenario, encoding="utf-8")
    assert main(["run", str(file), "-o", str(tmp_path / "out")]) == 0
    summary = json.loads((tmp_path / "out/summary.json").read_text(encoding="utf-8"))
    del summary["versions"], summary["solver"]["wall_seconds"], summary["solver"]["cheaper"]
    assert keys_of(summary) - explained("`summary.json`") == set()


def test_every_column_of_the_metrics_is_explained() -> None:
    assert {*COLUMNS} - explained("`metrics.csv`") == set()


# README and pages together


def test_the_readme_is_read_in_ten_minutes() -> None:
    assert len(README.splitlines()) <= 250


def test_the_readme_names_every_page() -> None:
    named = re.findall(r"^\| \[(\w+)\]\(netdae/manual/(\w+)\.md\) \|", README, flags=re.MULTILINE)
    assert sorted(named) == [(name, name) for name in PAGES]


def anchors_of(text: str) -> set[str]:
    """The anchors that a repository site gives to headings."""
    found: list[str] = []
    for heading in re.findall(r"^#+ (.*)$", without_code(text), flags=re.MULTILINE):
        slug = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        again = found.count(slug)
        found.append(f"{slug}-{again}" if again else slug)
    return {*found}


@pytest.mark.parametrize("file", list(TEXTS), ids=lambda file: file.stem)
def test_links_lead_somewhere(file: Path) -> None:
    for link in re.findall(r"\]\(([^)\s]+)\)", without_code(TEXTS[file])):
        path, _, anchor = link.partition("#")
        target = (file.parent / path).resolve() if path else file
        assert target.exists(), link
        if anchor:
            assert anchor in anchors_of(target.read_text(encoding="utf-8")), link


PLACEHOLDERS = {"N": "8", "S": "0", "P": "2", "T": "2.0", "M": "600e3", "K": "0"}


def netdae_lines(text: str) -> list[list[str]]:
    """All command lines `netdae ...`, with numbers for their placeholders and with what is optional."""
    inline = re.findall(r"(?<!`)`(netdae [^`]+)`", text)
    indented = re.findall(r"^    python3 scripts/in_venv\.py (netdae .*)$", text, flags=re.MULTILINE)
    lines = [shlex.split(re.sub(r"\[|\]|\.\.\.", "", line)) for line in (*inline, *indented)]
    return [[PLACEHOLDERS.get(word, word) for word in line[1:]] for line in lines]


@pytest.mark.parametrize("file", list(TEXTS), ids=lambda file: file.stem)
def test_command_lines_are_understood(file: Path) -> None:
    for line in netdae_lines(without_code(TEXTS[file])):
        if line == ["mesh"]:  # named, not called
            continue
        verb, *_ = app.parse_args(line, exit_on_error=False, print_error=False)
        assert verb.__module__.startswith("netdae.cli."), line


@pytest.mark.parametrize("file", list(TEXTS), ids=lambda file: file.stem)
def test_scripts_that_are_named_have_the_options(file: Path) -> None:
    text = " ".join(without_code(TEXTS[file]).split())
    for script, *words in (line.split() for line in re.findall(r"`python (scripts/[^`]+)`", text)):
        code = (PROJECT / script).read_text(encoding="utf-8")
        for word in words:
            if word.startswith("--"):
                assert f'"{word}"' in code, (script, word)
            elif "/" in word:
                assert (PROJECT / word).is_dir(), (script, word)


def test_pages_have_no_holes() -> None:
    for file, text in TEXTS.items():
        assert not re.search(r"^@?[A-Z_]{4,}@?$", text, flags=re.MULTILINE), file.name


def test_names_that_changed_are_there_now() -> None:
    assert nd.EventBook is nd.EventDetector  # type: ignore[attr-defined]
    assert type(nd.State.at([[0.0, 0.0, 0.0]]).balance).__name__ == "EnergyBalance"
    assert nd.DeploymentMetrics(log=None).mouth == "border"
    moved = re.findall(
        r"^\| `(netdae\.[\w.]+)` \| `(netdae\.[\w.]+)` \|", PAGES["changes"], flags=re.MULTILINE
    )
    assert len(moved) > 10
    for earlier, now in moved:
        assert find_spec(now) is not None, now
        assert earlier == "netdae.initial" or not (PROJECT / f"{earlier.replace('.', '/')}.py").exists(), (
            earlier
        )
    rooms = {path.parent.name for path in (PROJECT / "netdae").glob("*/__init__.py")} - {"manual"}
    assert {
        *re.findall(r"`netdae\.(\w+)`", PAGES["changes"].partition("Modules moved")[2].partition("These")[0])
    } == rooms
