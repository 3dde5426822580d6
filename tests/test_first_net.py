"""What a newcomer is told about a net of their own: the mouth, surfaces, and a size that does not fit."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from netdae.cli import main
from netdae.core.errors import ScenarioError
from netdae.mesh.io import describe
from netdae.scenario.nets import MOST_NODES
from netdae.scenario.reader import read_scenario

RING = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\ng rim\nl 1 2\nl 2 3\nl 3 4\nl 4 1\n"
SCENARIO = """\
[net]
file = "net.obj"
[[material]]
youngs_modulus = 1e9
density = 1140.0
diameter = 1e-3
[damping]
kind = "none"
[[masses]]
group = "rim"
mass = 0.2
[solver]
method = "explicit"
end = 0.001
[output]
frames = 2
"""


def write(folder, more=""):
    (folder / "net.obj").write_text(RING)
    (folder / "s.toml").write_text(SCENARIO + more)
    return folder / "s.toml"


def test_net_without_a_border_is_told_how_to_name_its_mouth(tmp_path, capsys):
    file = write(tmp_path)
    words = "the net has no group border, so that no mouth is measured: give the group of its closed loop by mouth in"
    assert main(["check", str(file)]) == 0
    assert f"{words} [metrics] (one of rim)" in capsys.readouterr().out
    assert main(["run", str(file), "-o", str(tmp_path / "out")]) == 0
    assert words in capsys.readouterr().out
    notes = json.loads((tmp_path / "out" / "summary.json").read_text())["notes"]
    assert sum(words in note for note in notes) == 1
    for mouth in ("rim", "none"):
        file = write(tmp_path, f'[metrics]\nmouth = "{mouth}"\n')
        assert not any(words in note for note in read_scenario(file).build().notes)


def test_surface_beside_lines_names_its_cure_and_keeps_its_groups(tmp_path):
    (tmp_path / "net.obj").write_text(f"{RING}v 2 0 0\nv 2 1 0\ng web\nf 2 5 6 3\n")
    found = describe(tmp_path / "net.obj")
    assert any("surface_edges = true in [net], --surface-edges" in finding for finding in found.findings)
    net = describe(tmp_path / "net.obj", surface_edges=True).net
    assert (net.cable_count, len(net.cable_groups["web"]), len(net.cable_groups["rim"])) == (7, 4, 4)
    # the edge of two groups is in both
    assert len({*net.cable_groups["web"].tolist()} & {*net.cable_groups["rim"].tolist()}) == 1


FAULT = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
from netdae.core.errors import ScenarioError
from netdae.scenario.reader import read_scenario
try:
    read_scenario(sys.argv[1]).build()
except ScenarioError as error:
    with open("/proc/self/status") as file:  # ru_maxrss begins with that of the process which started this one
        print(error, next(line.split()[1] for line in file if line.startswith("VmHWM")))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory")
def test_cells_that_fill_the_memory_are_refused_before_it_is_taken(tmp_path):
    text = SCENARIO.replace('file = "net.obj"', 'kind = "square"\nside = 3.0\ncells = {}')
    file = tmp_path / "s.toml"
    for cells, words in (
        (600, "361201 nodes, whose flight would take some 2.8 GiB"),
        (50_000, "2500100001 nodes"),
    ):
        file.write_text(text.format(cells).replace('"rim"', '"corners"'))
        done = subprocess.run([sys.executable, "-c", FAULT, file], capture_output=True, text=True)
        assert words in done.stdout, done.stderr
        assert int(re.search(r"(\d+)$", done.stdout.strip())[1]) < 1 << 20  # kB: 1 GiB
    assert MOST_NODES == 262144


def test_title_of_the_fault_reads_as_text(capsys):
    text = Path(__file__).parent / "faults" / "title_injection.toml"
    assert main(["check", str(text)]) == 0
    assert r"<!--<script> \x1b[31mred\x1b]0;pwned\x07" in capsys.readouterr().out
    with pytest.raises(ScenarioError, match=r"this is a device or a pipe"):
        read_scenario(text.with_name("table_dev_zero.toml")).build()
