"""The verb plot: what it writes and prints, and the one line for each mistake."""

from __future__ import annotations

import subprocess
import sys

import pytest
from test_plots import write_folder

from netdae.cli import main


@pytest.fixture
def reported(capsys):
    """Runs the verb; exit code, stdout, stderr."""

    def report(*arguments):
        code = main(["plot", *map(str, arguments)])
        return code, *capsys.readouterr()

    return report


def test_pictures_of_both_kinds_are_written_and_named(tmp_path, reported):
    write_folder(tmp_path / "a")
    code, out, err = reported(tmp_path / "a", "--only", "taut", "--only", "distance")
    assert (code, err) == (0, "")
    assert out == f"4 pictures in {tmp_path / 'a' / 'plots'}: distance, taut\n"
    found = sorted(file.name for file in (tmp_path / "a" / "plots").iterdir())
    assert found == ["distance.png", "distance.svg", "taut.png", "taut.svg"]


def test_several_folders_one_format_and_an_output_folder(tmp_path, reported):
    for name in "ab":
        write_folder(tmp_path / name)
    code, out, _ = reported(
        tmp_path / "a", tmp_path / "b", "-o", tmp_path / "o", "--format", "svg", "--only", "area"
    )
    assert (code, out) == (0, f"1 picture in {tmp_path / 'o'}: area\n")
    assert [file.name for file in (tmp_path / "o").iterdir()] == ["area.svg"]


def test_mistakes_are_one_line_and_exit_code_2(tmp_path, reported):
    run, bare, empty = tmp_path / "run", tmp_path / "bare", tmp_path / "empty"
    write_folder(run)
    write_folder(bare)
    (bare / "metrics.csv").unlink()
    empty.mkdir()
    blocked = tmp_path / "file"
    blocked.write_text("")
    for arguments, words in (
        ([], "DIR is missing"),
        ([tmp_path / "none"], "there is no such folder"),
        ([blocked], "is a file: give the output folder"),
        ([empty], "is not the output folder of a run"),
        ([bare], "has no metrics.csv"),
        ([run, empty], f"{empty} is not the output folder"),
        ([run, "--only", "enrgy"], "did you mean energy?"),
        ([run, "--only", "???"], "overview, area, distance"),
        ([run, "--format", "pdf"], "pdf"),
        ([run, "-o", blocked], "pictures cannot be written there"),
        ([run, "-o", blocked / "below"], "pictures cannot be written there"),
        ([run, "-o", ""], "empty"),
    ):
        code, out, err = reported(*arguments)
        assert (code, out) == (2, "")
        assert words in err
        assert len(err.splitlines()) == 1
    assert not (run / "plots").exists()


def test_help_needs_no_heavy_library():
    code = "import sys\nfrom netdae.cli import main\nmain(['plot', '--help'])\nprint(*sys.modules, file=sys.stderr)"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "--only" in shown.stdout
    loaded = {name.split(".")[0] for name in shown.stderr.split()}
    assert loaded.isdisjoint({"numpy", "scipy", "numba", "pyvista", "meshio", "sksundae", "matplotlib"})
