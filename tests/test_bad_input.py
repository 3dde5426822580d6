"""Each mistake of a user gets one clear line on stderr that names the thing, and exit code 2."""

import json
import os
import shlex
import subprocess
import sys

import pytest

from netdae.cli import main
from netdae.core.errors import InputError
from netdae.scenario.table_files import read_table

SCENARIO = """\
title = "small"
[net]
kind = "square"
side = 1.0
cells = 2
[[material]]
youngs_modulus = 70e9
density = 1390
diameter = 1e-3
[damping]
kind = "dashpot"
viscosity_time = 1e-5
[[masses]]
group = "corners"
mass = 0.1
[[restraints]]
group = "centre"
axes = "xyz"
motion = "fixed"
[initial]
scale = [0.4, 0.4, 1.0]
[[initial.ejection]]
group = "corners"
speed = 2.0
half_angle_deg = 45
[[loads]]
kind = "gravity"
g = [0, 0, -9.81]
[solver]
end = 0.001
[output]
frames = 2
"""

# what is replaced in SCENARIO, by what, and words of the message
MISTAKES = {
    "unknown key": ("side = 1.0", "sidee = 1.0", ["[net] sidee is an unknown key", "did you mean side?"]),
    "unknown key of a load": ("g = [0", "gg = 1\ng = [0", ["[[loads]] 1 gg", "did you mean g?"]),
    "unknown key of an ejection": ("speed =", "sped =", ["[[initial.ejection]] 1 sped", "speed"]),
    "unknown key at the top": ("title", "titel", ["titel is an unknown key before", "did you mean title"]),
    "unknown section": ("[output]", "[ouput]", ["[ouput] is an unknown section", "did you mean output"]),
    "section that there is not": (
        "[output]",
        '[sail]\nkind = "box"\n[output]',
        ["[sail] is an unknown section"],
    ),
    "list of sections that there is not": (
        "[output]",
        "[[contacts]]\n[output]",
        ["[[contacts]] is an unknown section"],
    ),
    "missing key": ("side = 1.0", "", ["[net] side is missing", "m"]),
    "missing key of a mass": ("mass = 0.1", "", ["[[masses]] 1 mass is missing", "kg"]),
    "missing end": ("end = 0.001", "", ["[solver] end is missing"]),
    "no damping": ('[damping]\nkind = "dashpot"\nviscosity_time = 1e-5', "", ["[damping] is missing"]),
    "no material": (
        SCENARIO[SCENARIO.index("[[mat") : SCENARIO.index("[damping")],
        "",
        ["[[material]] is missing"],
    ),
    "no kind": ('kind = "square"', "", ["[net] kind is missing", "square"]),
    "no kind of damping": ('kind = "dashpot"', "", ["[damping] kind is missing", "rayleigh"]),
    "wrong kind of damping": (
        'kind = "dashpot"',
        'kind = "raleigh"',
        ["[damping] kind", "did you mean rayleigh?"],
    ),
    "wrong kind of net": ('kind = "square"', "kind = 4", ["[net] kind is 4", "hexagon"]),
    "text for a number": ("side = 1.0", 'side = "5"', ['[net] side is the text "5", expected a number']),
    "true for a number": ("side = 1.0", "side = true", ["[net] side is true, expected a number"]),
    "number for text": ('group = "centre"', "group = 3", ["[[restraints]] 1 group is 3, expected text"]),
    "fraction for a count": ("cells = 2", "cells = 2.0", ["[net] cells is 2.0, expected a whole number"]),
    "infinite number": ("side = 1.0", "side = inf", ["[net] side is inf, expected a finite number"]),
    "number that is none": (
        "mass = 0.1",
        "mass = nan",
        ["[[masses]] 1 mass is nan, expected a finite number"],
    ),
    "number beyond floats": ("side = 1.0", "side = 1" + 400 * "0", ["[net] side", "double precision"]),
    "count beyond memory": ("cells = 2", "cells = 1" + 30 * "0", ["[net]", "nodes"]),
    "infinite component": ("-9.81]", "-inf]", ["[[loads]] 1 g, number 3, is -inf, expected a finite number"]),
    "text in a vector": ("[0.4, 0.4", '["0.4", 0.4', ['[initial] scale, number 1, is the text "0.4"']),
    "short vector": ("[0, 0, -9.81]", "[0, -9.81]", ["[[loads]] 1 g is [0, -9.81], expected three numbers"]),
    "long vector": (
        "[0, 0, -9.81]",
        "[0, 0, -9.81, 2]",
        ["[[loads]] 1 g is [0, 0, -9.81, 2], expected three"],
    ),
    "number for a vector": ("[0, 0, -9.81]", "9.81", ["[[loads]] 1 g is 9.81, expected three numbers"]),
    "text for a vector": ("[0, 0, -9.81]", '"down"', ['[[loads]] 1 g is the text "down"', "three numbers"]),
    "single for double brackets": (
        "[[masses]]",
        "[masses]",
        ["[[masses]] is a single table, expected double brackets: write [[masses]]"],
    ),
    "double for single brackets": (
        "[solver]",
        "[[solver]]",
        ["[solver] is a list of tables", "write [solver]"],
    ),
    "section in a section": (
        "[output]\nframes = 2",
        "[solver.output]",
        ["[solver] output is an unknown key"],
    ),
    "number for the net": (SCENARIO[: SCENARIO.index("[[mat")], "net = 3\n", ["[net] is 3", "write [net]"]),
    "negative modulus": (
        "= 70e9",
        "= -70e9",
        ["[[material]] 1 youngs_modulus is -70000000000.0", "0.001 or more"],
    ),
    "two diameters": ("diameter = 1e-3", "diameter = 1e-3\narea = 1e-6", ["[[material]] 1: both", "area"]),
    "no density": ("density = 1390", "", ["[[material]] 1: neither of density and linear_density"]),
    "density that leaves no mass": (
        "density = 1390",
        "density = 1e-308",
        ["[[material]] 1 density is 1e-308, expected 0, or 1e-09 or more"],
    ),
    "diameter in no unit": (
        "diameter = 1e-3",
        "diameter = 1e200",
        ["[[material]] 1 diameter is 1e+200, expected 1000 or less"],
    ),
    "side in no unit": ("side = 1.0", "side = 1e200", ["[net] side is 1e+200, expected 1e+06 or less"]),
    "speed in no unit": (
        "speed = 2.0",
        "speed = 1e300",
        ["[[initial.ejection]] 1 speed is 1e+300, expected 1e+06 or less"],
    ),
    "mass in no unit": (
        "mass = 0.1",
        "mass = 1e300",
        ["[[masses]] 1 mass is 1e+300, expected 1e+09 or less"],
    ),
    "scale in no unit": (
        "[0.4, 0.4",
        "[1e200, 0.4",
        ["[initial] scale, number 1, is 1e+200, expected 1000 or less"],
    ),
    "gravity in no unit": (
        "-9.81]",
        "-1e300]",
        ["[[loads]] 1 g, number 3, is -1e+300, expected -1e+06 or more"],
    ),
    "force in no unit": (
        'kind = "gravity"\ng =',
        'kind = "nodal"\ngroup = "all"\nforce = [1e300, 0, 0]\n#',
        ["[[loads]] 1 force, number 1, is 1e+300, expected 1e+12 or less"],
    ),
    "end in no unit": ("end = 0.001", "end = 1e300", ["[solver] end is 1e+300, expected 1e+09 or less"]),
    "flight of no length": (
        "end = 0.001",
        "end = 1e-300",
        ["[solver]: the flight lasts 1e-300 s", "1e-09 s after"],
    ),
    "frames that times cannot distinguish": (
        "end = 0.001\n[output]\nframes = 2",
        "begin = 1e8\nend = 100000000.001\n[output]\nframes = 1000000",
        ["[solver]: the flight lasts 0.001", "fewer frames"],
    ),
    "tolerance below all digits": (
        "end = 0.001",
        "end = 0.001\natol_position = 1e-300",
        ["[solver] atol_position is 1e-300, expected 1e-15 or more"],
    ),
    "step below all digits": (
        "end = 0.001",
        "end = 0.001\nmax_step = 1e-300",
        ["[solver] max_step is 1e-300, expected 1e-12 or more"],
    ),
    "pulse of no length": (
        "g = [",
        "begin = 0\nend = 1e-300\ng = [",
        ["[[loads]] 1: it lasts 1e-300 s", "1e-09 s"],
    ),
    "net drawn into a point": (
        "[0.4, 0.4, 1.0]",
        "[0, 0, 1]",
        ["[initial]: scale is [0.0, 0.0, 1.0]", "into one point"],
    ),
    "pattern and file": (
        'kind = "square"',
        'file = "net.vtu"\nkind = "square"',
        ["[net] has kind and file", "not both"],
    ),
    "rayleigh that damps nothing": (
        'kind = "dashpot"\nviscosity_time = 1e-5',
        'kind = "rayleigh"',
        ['[damping]: nothing is damped: give alpha or beta above zero, or kind = "none"'],
    ),
    "unknown law": ("density =", 'law = "hooke"\ndensity =', ["[[material]] 1 law", "engineering"]),
    "both measures of a dashpot": (
        "viscosity_time =",
        "zeta = 1\nviscosity_time =",
        ["[damping]: give just one"],
    ),
    "unknown node group": (
        'group = "corners"\nmass',
        'group = "corner"\nmass',
        ["[[masses]] 1", "'corner'", "did you mean 'corners'?"],
    ),
    "unknown group of an ejection": (
        'group = "corners"\nspeed',
        'group = "rim"\nspeed',
        ["[[initial.ejection]] 1", "'rim'"],
    ),
    "unknown cable group": (
        "youngs_modulus",
        'cables = "edge"\nyoungs_modulus',
        ["[[material]] 1", "'edge'", "border"],
    ),
    "cables without material": (
        "youngs_modulus",
        'cables = "border"\nyoungs_modulus',
        ["[[material]]: 4 of 12 cables have no material", "missing of inner"],
    ),
    "unknown axes": ('axes = "xyz"', 'axes = "xw"', ["[[restraints]] 1", "'xw'"]),
    "unknown motion": ('motion = "fixed"', 'motion = "fix"', ["[[restraints]] 1 motion", "fixed"]),
    "axis restrained twice": (
        "[initial]",
        '[[restraints]]\ngroup = "all"\naxes = "z"\n[initial]',
        ["[[restraints]] 2: ", "'all'", "node 4"],
    ),
    "fixed node that starts in motion": (
        "[initial]",
        "[initial]\nvelocity = [1, 0, 0]",
        ["[[restraints]] 1: ", "'centre'", "node 4", "1.0"],
    ),
    "no end after the begin": ("end = 0.001", "begin = 1\nend = 1", ["[solver]", "end is 1 s"]),
    "unknown accuracy": ("end = 0.001", 'end = 1\naccuracy = "fine"', ["[solver] accuracy", "standard"]),
    "unknown method": ("end = 0.001", 'end = 1\nmethod = "rk4"', ["[solver] method", "'ida'"]),
    "order too high": (
        "end = 0.001",
        "end = 1\nmax_order = 6",
        ["[solver] max_order is 6, expected 5 or less"],
    ),
    "no frames": ("frames = 2", "frames = 0", ["[output] frames is 0, expected 2 or more"]),
    "one frame": ("frames = 2", "frames = 1", ["[output] frames is 1, expected 2 or more"]),
    "pulse that ends before it begins": ("g = [", "begin = 2\nend = 1\ng = [", ["[[loads]] 1", "2 to 1 s"]),
    "mouth that is no loop": (
        "[output]",
        '[metrics]\nmouth = "all"\n[output]',
        ["[metrics]", "'all'", "loop"],
    ),
    "unknown mouth": ("[output]", '[metrics]\nmouth = "hole"\n[output]', ["[metrics]", "'hole'", "border"]),
    "unknown corners": ("[output]", '[metrics]\ncorners = "edge"\n[output]', ["[metrics]", "'edge'"]),
    "not TOML": ("side = 1.0", "side 1.0", ["not TOML", "line 4, column 6"]),
    "cut off": ("frames = 2\n", "frames = ", ["not TOML", "line 32, column 10"]),
    "key twice": ("side = 1.0", "side = 1.0\nside = 2.0", ["not TOML", "line 5"]),
}


def failure_of(arguments, capsys):
    """The one line on stderr of a command that a mistake stops."""
    assert main([str(argument) for argument in arguments]) == 2
    shown = capsys.readouterr()
    assert shown.err.endswith("\n")
    assert len(shown.err.splitlines()) == 1
    return shown.err


def scenario(folder, old="", new="", more=""):
    assert old in SCENARIO
    file = folder / "small.toml"
    file.write_text(SCENARIO.replace(old, new, 1) + more if old else SCENARIO + more, encoding="utf-8")
    return file


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_in_a_scenario_is_reported_by_section_and_key(mistake, tmp_path, capsys):
    old, new, words = MISTAKES[mistake]
    line = failure_of(["run", scenario(tmp_path, old, new), "-o", tmp_path / "out"], capsys)
    for word in words:
        assert word in line
    assert not (tmp_path / "out").exists()


def net_of(text):
    return ('kind = "square"\nside = 1.0\ncells = 2', text)


MSH = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n$EndNodes\n$Elements\n{}\n$EndElements\n"
SPAN = "2\n1 0 0 0\n2 1 0 0"
MESHES = {
    "malformed": ("this is no mesh", ["net.msh", "no MSH file"]),
    "empty": ("", ["net.msh", "empty"]),
    "without lines": (MSH.format(SPAN, "1\n1 15 2 0 1 1"), ["net.msh", "no lines", "each cable is a line"]),
    "surface": (MSH.format("3\n1 0 0 0\n2 1 0 0\n3 0 1 0", "1\n1 2 2 0 1 1 2 3"), ["net.msh", "surface"]),
    "cable to itself": (MSH.format(SPAN, "2\n1 1 2 0 1 1 2\n2 1 2 0 1 1 1"), ["net.msh", "itself"]),
    "zero rest length": (MSH.format("2\n1 0 0 0\n2 0 0 0", "1\n1 1 2 0 1 1 2"), ["net.msh", "rest length 0"]),
    "coordinate that is no number": (
        MSH.format("2\n1 0 0 0\n2 nan 0 0", "1\n1 1 2 0 1 1 2"),
        ["net.msh", "nan"],
    ),
}


@pytest.mark.parametrize("mesh", MESHES)
def test_mesh_that_is_no_net_is_reported_by_its_name(mesh, tmp_path, capsys):
    text, words = MESHES[mesh]
    (tmp_path / "net.msh").write_text(text)
    line = failure_of(["check", scenario(tmp_path, *net_of('file = "net.msh"'))], capsys)
    for word in words:
        assert word in line


def test_missing_mesh_is_reported(tmp_path, capsys):
    line = failure_of(["run", scenario(tmp_path, *net_of('file = "no.msh"'))], capsys)
    assert "small.toml: [net] file: " in line
    assert str(tmp_path / "no.msh") in line
    assert "no such file" in line


TABLES = {
    "missing": (None, ["m.csv", "cannot be read"]),
    "empty": ("", ["m.csv", "empty"]),
    "header": ("time,x,y,z\n0,0,0,0\n1,1,0,0\n", ["m.csv", "'time,x,y,z'", "t,x,y,z"]),
    "no number": ("t,x,y,z\n0,0,0,0\n1,a,0,0\n", ["m.csv", "line 3", "x is 'a'"]),
    "infinite": ("t,x,y,z\n0,0,0,0\n1,0,inf,0\n", ["m.csv", "line 3", "y is 'inf'"]),
    "field missing": ("t,x,y,z\n0,0,0,0\n\n1,0,0\n", ["m.csv", "line 4", "3 fields"]),
    "one row": ("t,x,y,z\n0,0,0,0\n", ["m.csv", "two rows"]),
    "falling times": ("t,x,y,z\n0,0,0,0\n1,0,0,0\n0.5,0,0,0\n", ["m.csv", "do not rise"]),
    "too short for the flight": (
        "t,x,y,z\n0,0,0,0\n1e-4,0,0,0\n",
        ["m.csv: the table reaches from 0 to 0.0001 s"],
    ),
    "binary": (b"\xff\xfe\x00", ["m.csv", "not a CSV table"]),
    "begins elsewhere": ("t,x,y,z\n0,1,0,0\n1,1,0,0\n", ["'centre'", "begins at [1.0, 0.0, 0.0] m"]),
}


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("use", ["motion", "load"])
def test_table_that_cannot_be_used_is_reported_by_file_and_line(use, table, tmp_path, capsys):
    text, words = TABLES[table]
    if use == "load" and table == "begins elsewhere":
        return
    if text is not None:
        (tmp_path / "m.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    old, new = (
        ('"fixed"', '{ file = "m.csv" }') if use == "motion" else ("[0, 0, -9.81]", '{ file = "m.csv" }')
    )
    line = failure_of(["run", scenario(tmp_path, old, new), "-o", tmp_path / "out"], capsys)
    for word in words:
        assert word in line
    assert ("[[restraints]] 1: " if use == "motion" else "[[loads]] 1: ") in line
    assert not (tmp_path / "out").exists()


def test_begin_of_a_load_with_a_table_is_reported(tmp_path, capsys):
    file = scenario(tmp_path, "g = [0, 0, -9.81]", 'begin = 1\ng = { file = "m.csv" }')
    assert "[[loads]] 1: begin does not go with a table" in failure_of(["check", file], capsys)


def test_scenario_that_is_not_there_or_not_text_is_reported(tmp_path, capsys):
    assert "no.toml" in failure_of(["run", tmp_path / "no.toml"], capsys)
    assert "directory" in failure_of(["run", tmp_path], capsys)
    (tmp_path / "latin.toml").write_bytes('title = "Fläche"\n'.encode("latin-1"))
    assert "line 1 is not UTF-8" in failure_of(["run", tmp_path / "latin.toml"], capsys)


def test_scenario_with_the_mark_of_some_editors_is_read(tmp_path, capsys):
    file = scenario(tmp_path)
    file.write_bytes(b"\xef\xbb\xbf" + file.read_bytes())
    assert main(["check", str(file)]) == 0


def test_output_folder_that_is_a_file_or_lies_below_one_is_reported(tmp_path, capsys):
    file = scenario(tmp_path)
    (tmp_path / "taken").write_text("mine")
    assert "this is a file" in failure_of(["run", file, "-o", tmp_path / "taken"], capsys)
    assert "cannot be written" in failure_of(["run", file, "-o", tmp_path / "taken" / "out"], capsys)
    assert (tmp_path / "taken").read_text() == "mine"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_output_folder_without_permission_is_reported(tmp_path, capsys):
    file = scenario(tmp_path)
    (tmp_path / "closed").mkdir(mode=0o500)
    assert "cannot be written" in failure_of(["run", file, "-o", tmp_path / "closed" / "out"], capsys)


def test_former_run_is_kept_unless_overwriting_is_asked_for(tmp_path, capsys):
    file, out = scenario(tmp_path), tmp_path / "out"
    out.mkdir()
    (out / "notes.txt").write_text("mine")
    assert main(["run", str(file), "-o", str(out)]) == 0
    before = {path: path.read_bytes() for path in sorted(out.rglob("*")) if path.is_file()}
    assert len(before) > 6
    capsys.readouterr()
    line = failure_of(["run", file, "-o", out], capsys)
    assert "this folder already holds an earlier run" in line
    assert "--overwrite" in line
    assert {path: path.read_bytes() for path in sorted(out.rglob("*")) if path.is_file()} == before
    (out / "frames" / "frame_000077.vtu").write_bytes(b"of a longer run")
    (out / "frames" / "mine.vtu").write_bytes(b"mine")
    assert main(["run", str(file), "-o", str(out), "--overwrite"]) == 0
    assert (out / "notes.txt").read_text() == "mine"
    assert sorted(path.name for path in (out / "frames").iterdir()) == [
        "frame_000000.vtu",
        "frame_000001.vtu",
        "mine.vtu",
    ]


def test_overwriting_in_the_folder_of_the_scenario_spares_the_scenario(tmp_path):
    file = scenario(tmp_path).rename(tmp_path / "scenario.toml")
    for _ in range(2):
        assert main(["run", str(file), "-o", str(tmp_path), "--overwrite"]) == 0
    assert file.read_text() == SCENARIO


def test_scenario_that_no_run_left_is_spared(tmp_path, capsys):
    (tmp_path / "scenario.toml").write_text("# mine")
    line = failure_of(["run", scenario(tmp_path), "-o", tmp_path, "--overwrite"], capsys)
    assert "scenario.toml" in line
    assert (tmp_path / "scenario.toml").read_text() == "# mine"


def test_former_summary_is_gone_while_the_new_run_is_under_way(tmp_path, monkeypatch):
    file, out = scenario(tmp_path), tmp_path / "out"
    assert main(["run", str(file), "-o", str(out)]) == 0
    seen = []
    monkeypatch.setattr(
        "netdae.runs.folder.LastStep.__call__", lambda self, state: seen.append(sorted(os.listdir(out)))
    )
    assert main(["run", str(file), "-o", str(out), "--overwrite"]) == 0
    assert len(seen) == 2
    assert not [names for names in seen if "summary.json" in names or "trajectory.npz" in names]


@pytest.mark.parametrize("use", ["mesh", "table"])
def test_overwriting_spares_what_the_scenario_reads(use, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["run", str(scenario(tmp_path)), "-o", str(out)]) == 0
    if use == "mesh":
        read = out / "frames" / "frame_000001.vtu"
        file = scenario(tmp_path, *net_of('file = "out/frames/frame_000001.vtu"'))
    else:
        read = out / "metrics.csv"
        read.write_text("t,x,y,z\n0,0,0,0\n1,0,0,0\n")
        file = scenario(tmp_path, "[0, 0, -9.81]", '{ file = "out/metrics.csv" }')
    capsys.readouterr()
    before = read.read_bytes()
    line = failure_of(["run", file, "-o", out, "--overwrite"], capsys)
    assert f"{read}: --overwrite would delete this file" in line
    assert read.read_bytes() == before


COPIED = """\
# the net, file = "no.vtu"
title = 'file = "a.vtu"'
[net]
file = 'net.vtu'   # relative to this file
[[material]]
youngs_modulus = 70e9
density = 1390
diameter = 1e-3
[damping]
kind = "none"
[[restraints]]
group = "centre"
motion = {interpolation="linear",file="more/m.csv"}
[[loads]]
kind = "gravity"
g = { file = "more/g \\u00b2.csv" }
[solver]
end = 0.001
[output]
frames = 2
"""


def test_copy_of_a_scenario_in_its_output_folder_flies_again(tmp_path, monkeypatch):
    (tmp_path / "more").mkdir()
    assert main(["mesh", "square", "--side", "1", "--cells", "2", "-o", str(tmp_path / "net.vtu")]) == 0
    for name in ("m.csv", "g ².csv"):
        (tmp_path / "more" / name).write_text("t,x,y,z\n0,0,0,0\n1,0,0,0\n")
    (tmp_path / "s.toml").write_text(COPIED)
    monkeypatch.chdir(tmp_path)
    assert main(["run", "s.toml", "-o", "a/out"]) == 0
    copy = tmp_path / "a" / "out" / "scenario.toml"
    lines = zip(COPIED.splitlines(), copy.read_text(encoding="utf-8").splitlines(), strict=True)
    changed = [(old, new) for old, new in lines if old != new]
    assert [old[:6] for old, _ in changed] == ["file =", "motion", "g = { "]
    assert changed[0][1] == f'file = "{tmp_path.as_posix()}/net.vtu"   # relative to this file'
    assert main(["run", str(copy), "-o", str(tmp_path / "again")]) == 0
    assert (tmp_path / "again" / "scenario.toml").read_bytes() == copy.read_bytes()


def test_copy_of_a_scenario_that_is_written_oddly_says_where_its_files_are(tmp_path):
    text = SCENARIO.replace("[0, 0, -9.81]", '{ file = """g.csv""" }')
    (tmp_path / "g.csv").write_text("t,x,y,z\n0,0,0,0\n1,0,0,0\n")
    (tmp_path / "s.toml").write_text(text)
    assert main(["run", str(tmp_path / "s.toml"), "-o", str(tmp_path / "out")]) == 0
    copy = (tmp_path / "out" / "scenario.toml").read_text()
    assert copy == f"# names of files are relative to {tmp_path.as_posix()}\n{text}"


def test_bad_scenario_leaves_a_former_run_as_it_was(tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["run", str(scenario(tmp_path)), "-o", str(out)]) == 0
    capsys.readouterr()
    failure_of(["run", scenario(tmp_path, "cells = 2", "cells = 0"), "-o", out, "--overwrite"], capsys)
    assert (out / "summary.json").exists()


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["fly"], "fly"),
        (["run"], "SCENARIO is missing: netdae run SCENARIO.toml. See netdae run --help"),
        (["run", "a.toml", "--overwrit"], "--overwrit"),
        (["run", "a.toml", "b.toml"], "b.toml is too much: netdae run takes one scenario at a time"),
        (["info", "a.vtu", "b.vtu"], "b.vtu is too much: netdae info takes one mesh at a time"),
        (
            ["run", "a.toml", "-o", ""],
            'Invalid value for -o: "" is empty, expected a name, or . for this folder',
        ),
        (
            ["run", "a.toml", "--ensemble", "2.5"],
            'Invalid value for --ensemble: "2.5", expected a whole number',
        ),
        (["info"], "MESH is missing: netdae info MESH."),
        (["run", "a.toml", "-o"], "-o"),
        (["--bogus"], "--bogus"),
        (["mesh", "square", "--side", "wide", "--cells", "2", "-o", "x.vtu"], '"wide", expected a number'),
        (
            ["mesh", "square", "--side", "1", "--cells", "4.9", "-o", "x.vtu"],
            '"4.9", expected a whole number',
        ),
        (["mesh", "square", "--side", "1", "-o", "x.vtu"], "cells"),
        (["info", "no.vtu"], "no.vtu"),
    ],
)
def test_mistake_on_the_command_line_is_one_line(arguments, word, capsys):
    assert word in failure_of(arguments, capsys)


def test_process_says_its_line_and_exits_with_2(tmp_path):
    file = scenario(tmp_path, "side = 1.0", 'side = "5"')
    for arguments in (["run", str(file)], ["run", "--bogus"]):
        done = subprocess.run(
            [sys.executable, "-c", "import sys; from netdae.cli import main; sys.exit(main())", *arguments],
            capture_output=True,
            text=True,
            cwd=tmp_path,
        )
        assert done.returncode == 2
        assert len(done.stderr.splitlines()) == 1
        assert done.stdout == ""


NETDAE = (sys.executable, "-c", "import sys; from netdae.cli import main; sys.exit(main())")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a device of Linux")
def test_output_that_is_full_is_one_line_after_the_run(tmp_path):
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [*NETDAE, "run", str(scenario(tmp_path)), "-o", str(tmp_path / "out")],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
        )
    assert done.returncode == 1
    assert (
        done.stderr
        == "what is printed cannot be written: No space left on device: make room, or print elsewhere\n"
    )
    assert (tmp_path / "out" / "summary.json").exists()


@pytest.mark.skipif(os.name != "posix", reason="a shell of POSIX")
@pytest.mark.parametrize("end", [">&-", "| true"])
def test_output_that_is_closed_ends_no_run(end, tmp_path):
    command = f"{shlex.join([*NETDAE, 'run', str(scenario(tmp_path)), '-o', str(tmp_path / 'out')])} {end}"
    done = subprocess.run(["sh", "-c", command], stderr=subprocess.PIPE, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert '"finished"' in (tmp_path / "out" / "summary.json").read_text()


@pytest.mark.parametrize("encoding", ["ascii", "cp1252"])
def test_signs_that_the_output_cannot_take_are_replaced(encoding, tmp_path):
    file = scenario(tmp_path, 'title = "small"', 'title = "a net of 1 m² with Δ"')
    environment = {**os.environ, "PYTHONIOENCODING": encoding}
    done = subprocess.run([*NETDAE, "check", str(file)], capture_output=True, env=environment)
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.decode(encoding).startswith("a net of 1 m")
    done = subprocess.run([*NETDAE, "schema"], capture_output=True, env=environment)
    assert (
        "kg/m³"
        in json.loads(done.stdout.decode("utf-8"))["$defs"]["Cord"]["properties"]["density"]["description"]
    )


@pytest.mark.skipif(os.name != "posix", reason="there are no devices among the files")
@pytest.mark.parametrize(
    ("name", "words"),
    [("pipe", "a device or a pipe"), ("n" * 300, "File name too long"), ("a\\u0000b", "the name has a NUL")],
)
@pytest.mark.parametrize("use", ["table", "mesh", "scenario"])
def test_names_that_are_no_files_are_one_line(use, name, words, tmp_path, capsys):
    for suffix in ("", ".vtu"):
        os.mkfifo(tmp_path / f"pipe{suffix}")
    if use == "scenario":
        file = tmp_path / name.replace("\\u0000", "\0")
    elif use == "mesh":
        file = scenario(tmp_path, *net_of(f'file = "{name}.vtu"'))
    else:
        file = scenario(tmp_path, "[0, 0, -9.81]", f'{{ file = "{name}" }}')
    line = failure_of(["check", file], capsys)
    assert words in line
    assert "\0" not in line


@pytest.mark.skipif(os.name != "posix", reason="there are no devices among the files")
def test_a_table_that_is_a_device_is_refused_before_it_is_read():
    with pytest.raises(InputError, match="this is a device or a pipe: give the name of a file"):
        read_table("/dev/zero", ["t", "x"])


def test_signs_that_a_terminal_obeys_are_printed_as_text(tmp_path, capsys):
    title = r'title = "<!-- \u001b[31mred\u001b]0;pwned\u0007 \u202e"'
    file = scenario(tmp_path, 'title = "small"', title)
    for verb in (["check", file], ["run", file, "-o", tmp_path / "out"]):
        assert main([*map(str, verb)]) == 0
        told = capsys.readouterr().out
        assert r"<!-- \x1b[31mred\x1b]0;pwned\x07 \u202e" in told
        assert not {"\x1b", "\x07", "\u202e"} & {*told}
    file = scenario(tmp_path, '"free"' if '"free"' in SCENARIO else '"centre"', r'"\u001b[31m"')
    assert r"\x1b[31m" in failure_of(["check", file], capsys)
