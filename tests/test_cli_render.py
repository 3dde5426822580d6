"""`netdae render`: what it makes, and the one line where it cannot."""

from __future__ import annotations

import pytest
from conftest import CORD
from PIL import Image

from netdae.cli import main
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.output.vtk import VtuSeries
from netdae.system.damping import NoDamping
from netdae.system.system import System
from netdae.visual.rendering import movie_file

FRAMES = 5


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A run's folder: a net that is carried along."""
    place = tmp_path_factory.mktemp("run")
    net = CableNet.square(side=2.0, cells=3)
    series = VtuSeries(place / "series.pvd")
    series.begin(System(net, CORD, masses={"corners": 0.5}, damping=NoDamping()))
    for k in range(FRAMES):
        series(State.at(1.01 * net.nodes + [0, 0, 0.1 * k], t=0.25 * k))
    series.end()
    (place / "metrics.csv").write_text(
        "time,mouth_area\n" + "".join(f"{0.25 * k},{5 - abs(k - 3)}\n" for k in range(FRAMES))
    )
    return place


def reported(capsys, *arguments):
    code = main(["render", *map(str, arguments)])
    output = capsys.readouterr()
    return code, output.out, output.err


SMALL = ("--size", "200,160")


@pytest.mark.parametrize(
    ("options", "name", "line"),
    [
        ((*SMALL,), "picture.png", "frame 3, t = 0.75 s"),
        (("--frame", 0, *SMALL), "picture.png", "frame 0, t = 0 s"),
        (("--time", 0.3, *SMALL), "picture.png", "frame 1, t = 0.25 s"),
        (("--sheet", 2, *SMALL), "sheet.png", "2 frames, t = 0 to 1 s"),
        (("--frames", "0,3", "--view=1,-2,0.5", *SMALL), "sheet.png", "2 frames, t = 0 to 0.75 s"),
        (("--frames", "0:4:2", "--camera", "still", *SMALL), "sheet.png", "3 frames, t = 0 to 1 s"),
        (("--movie", "--frames", "0:2", *SMALL), "movie.gif", "3 frames, t = 0 to 0.5 s"),
        (("--html", "--rate", 5, "--fit", "net"), "flight.html", "5 frames, t = 0 to 1 s"),
    ],
)
def test_it_makes_what_is_asked_for_and_says_so(folder, capsys, monkeypatch, options, name, line):
    monkeypatch.setattr(movie_file, "find_spec", lambda name: None)  # so that a movie is a GIF everywhere
    assert reported(capsys, folder, *options) == (0, f"{folder / name}: {line}\n", "")
    assert (folder / name).stat().st_size > 1000
    (folder / name).unlink()


@pytest.mark.parametrize("name", ["m.gif", "f.html"])
def test_the_file_s_ending_tells_what_is_made(folder, tmp_path, capsys, name):
    size = SMALL if name == "m.gif" else ()
    assert reported(capsys, folder, "-o", tmp_path / name, "--frames", "1:3", *size)[0] == 0
    if name == "m.gif":
        assert Image.open(tmp_path / name).n_frames == 3
    else:
        assert (tmp_path / name).read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--frame", 5), "frame 5 is not in "),
        (("--frame", 1.5), 'Invalid value for --frame: "1.5", expected a whole number'),
        (("--time", 3), "time 3 s is not in "),
        (("--frames", "1,9"), "frame 9 is not in "),
        (("--frames", "1,a"), 'Invalid value for --frames: "1,a", expected numbers of frames as 0,10,20'),
        (("--frames", "4:1"), 'Invalid value for --frames: "4:1", expected from:to:step upwards'),
        (("--frames", "0:4:0"), "expected from:to:step upwards"),
        (("--sheet", 0), "a sheet of 0 frames is empty"),
        (("--sheet", 101), "a sheet of 101 frames is too large"),
        (("--size", "12"), 'Invalid value for --size: "12", expected width and height'),
        (("--size", "12,12"), "size 12,12 is out of range"),
        (("--view", "up"), "view 'up' is unknown"),
        (("--view=0,0,0",), "is no direction"),
        (("--view=1,a",), 'Invalid value for --view: "1,a", expected a vector towards the eye'),
        (("--camera", "fly"), 'Invalid value "fly" for --camera'),
        (("--peak", "-1"), "peak -1 N is no end for the colours"),
        (("--frame", 1, "--time", 1), "--frame and --time do not go together"),
        (("--frame", 1, "--frames", "1"), "--frame and --frames do not go together"),
        (("--sheet", 2, "--frames", "1"), "--sheet and --frames do not go together"),
        (("--movie", "--html"), "--movie and --html do not go together"),
        (("--movie", "--sheet", 3), "--sheet and --movie do not go together"),
        (("--rate", 5), "--rate is for movies and pages"),
        (("--movie", "--rate", 100), "a rate of 100 frames a second is out of range"),
        (("--html", "--size", "100,100"), "a page has no size"),
        (("-o", "p.jpg"), 'p.jpg: its ending ".jpg" is unknown: give .png, .mp4, .gif or .html'),
        (("-o", "p"), "p: its ending is missing"),
        (("--movie", "-o", "p.png"), "p.png: give a name that ends in .mp4 or .gif"),
        (("--frame", 1, "-o", "p.gif"), "p.gif: give a name that ends in .png"),
        (("two",), "two is too much: netdae render takes one folder at a time"),
    ],
)
def test_what_cannot_be_is_one_line(folder, tmp_path, monkeypatch, capsys, options, words):
    monkeypatch.chdir(tmp_path)
    code, out, error = reported(capsys, folder, *options)
    assert (code, out) == (2, "")
    assert words in error
    assert len(error.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_no_folder_and_folders_without_frames_are_one_line(tmp_path, capsys):
    assert reported(capsys) == (2, "", "FOLDER is missing: netdae render DIR. See netdae render --help\n")
    for place, words in ((tmp_path, "has no frames"), (tmp_path / "none", "is not a folder")):
        code, out, error = reported(capsys, place)
        assert (code, out) == (2, "")
        assert error == f"{place} {words}: give the output folder of netdae run, in which series.pvd is\n"
