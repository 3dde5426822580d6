"""The map of the package: its force in ten minutes is written and flown as it stands, and its files are there."""

import re
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.random import default_rng

import netdae.forces
from netdae.forces.law import LAWS

PACKAGE = Path(netdae.__file__).parent
MAP = (PACKAGE / "README.md").read_text(encoding="utf-8")
MODULE, FLIGHT = re.findall(r"```python\n(.*?)```", MAP, flags=re.DOTALL)


@pytest.fixture
def flown(tmp_path, monkeypatch, capsys):
    """Names of the flight of the map, and what it printed, with the module at its place in `netdae.forces`."""
    (tmp_path / "hold.py").write_text(MODULE, encoding="utf-8")
    monkeypatch.setattr(netdae.forces, "__path__", [*netdae.forces.__path__, str(tmp_path)])
    file = tmp_path / "flight.py"
    file.write_text(FLIGHT, encoding="utf-8")
    names = runpy.run_path(str(file))
    yield names, capsys.readouterr().out.splitlines()
    LAWS.pop(names["Hold"])
    sys.modules.pop("netdae.forces.hold")


def test_a_force_added_by_the_map_flies_by_both_methods(flown):
    names, lines = flown
    ends, swings = zip(*(map(float, line.split()[1:]) for line in lines), strict=True)
    assert [line.split()[0] for line in lines] == ["ida", "explicit"]
    assert abs(ends[0] - 0.2) > 0.01  # the hold has moved the middle knot, by some centimetres
    assert ends[0] == pytest.approx(ends[1], abs=1e-4)  # accurate: 1e-5 m differ in half a second
    stored = names["system"].elastic_energy(names["start"].x)
    assert stored == pytest.approx(0.25 * 50.0 * 0.2**4, rel=1e-12)  # no cable is taut at the start
    assert max(swings) < 1e-2 * stored  # what the summary warns of; these flights lose a quarter of that


def test_its_tangent_is_the_derivative_of_its_force(flown):
    hold = flown[0]["hold"]
    x, h = default_rng(3).standard_normal((1, 1, 3)), 1e-6
    v = np.zeros_like(x)
    K = hold.tangent(0.0, x, v).dx.reshape(3, 3)
    for b in range(3):
        step = np.zeros_like(x)
        step[0, 0, b] = h
        slope = (hold.force(0.0, x + step, v) - hold.force(0.0, x - step, v)).ravel() / (2 * h)
        # differences of a cubic err by k h² = 1e-10 and by the round-off of f/h, 1e-16 · 500/1e-6 = 5e-8
        np.testing.assert_allclose(K[:, b], slope, rtol=1e-8, atol=1e-7)


def test_files_and_rooms_that_the_map_names_are_there():
    rooms = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").is_file()}
    assert set(re.findall(r"^\| `(\w+)/` \|", MAP, flags=re.MULTILINE)) == rooms
    named = set(re.findall(r"`((?:\w+/)+\w+\.py)`", MAP)) - {"netdae/forces/hold.py"}
    places = (PACKAGE, PACKAGE.parent)
    assert {name for name in named if not any((place / name).is_file() for place in places)} == set()
    assert len(named) > 20
