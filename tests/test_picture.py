"""scripts/picture.py: a picture of a flight, or one line that says why there is none."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import matplotlib.image
import numpy as np
from conftest import reference_flight

from netdae.state import State
from netdae.vtk import VtuSeries

SCRIPT = Path(__file__).resolve().parent.parent / "scripts" / "picture.py"


def drawn(*arguments):
    environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    command = [sys.executable, str(SCRIPT), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=environment)


def test_panels_have_one_scale_and_the_widest_net_fills_its_own(tmp_path):
    system, start = reference_flight(4)
    series = VtuSeries(tmp_path / "series.pvd")
    series.begin(system)
    for t, factor in ((0.0, 1.0), (1.0, 2.5)):  # the second lies far aside and is stretched taut
        series(State.at(factor * start.x + [20.0 * t, 0.0, 5.0 * t], start.v, t=t))
    series.end()
    done = drawn(tmp_path, tmp_path / "p.png", "--frames", 2)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    pixels = matplotlib.image.imread(tmp_path / "p.png")[..., :3]
    inked = (np.abs(pixels - 1.0) > 0.1).any(axis=-1)[60:-60]  # between the time above and the scale below
    small, large = (np.ptp(np.flatnonzero(half.any(axis=0))) for half in np.split(inked, 2, axis=1))
    assert large > 0.85 * pixels.shape[1] / 2
    assert abs(large / small - 2.5) < 0.2  # the bullets' dots have one size


def test_folder_without_a_series_and_wrong_places_are_one_line(tmp_path):
    for folder, picture, words in (
        (tmp_path / "none", tmp_path / "p.png", "give the series.pvd of an output folder"),
        (tmp_path, tmp_path / "p.jpg", "give the name of a .png file"),
    ):
        done = drawn(folder, picture)
        assert (done.returncode, done.stdout) == (2, "")
        assert words in done.stderr
        assert len(done.stderr.splitlines()) == 1
