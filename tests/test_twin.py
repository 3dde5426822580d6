"""A twin flight: what a nanometre at the start makes of each figure."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from test_symmetry import WITH, written

import netdae as nd
from netdae.cli import main
from netdae.core.errors import RunError
from netdae.initial.disturbed import disturbed
from netdae.runs.twin import SEED, TWIN, in_words, twin_of
from netdae.solvers.flight import simulate


def summary_in(folder):
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def test_a_twin_is_the_flight_from_a_start_a_nanometre_away(tmp_path, capsys):
    file, out = written(tmp_path, WITH), tmp_path / "out"
    assert main(["run", str(file), "-o", str(out), "--twin"]) == 0
    told = capsys.readouterr().out
    summary = summary_in(out)
    simulation = nd.read_scenario(file).build()
    start = disturbed(simulation.start, TWIN, SEED, simulation.system.restrained)
    assert np.abs(start.x - simulation.start.x).max() < 5e-9
    flight = simulate(
        simulation.system,
        start,
        simulation.times,
        options=simulation.options,
        observers=[simulation.metrics],
    )
    figures, twin = simulation.metrics.summary(), summary["twin"]
    for name in ("largest_mouth_area", "peak_tension", "final_kinetic_energy", "largest_energy"):
        assert twin["deployment"][name] == abs(figures[name] - summary["deployment"][name])
    assert not any(name.endswith("_cable") for name in twin["deployment"])
    apart = np.linalg.norm(flight[-1].x - nd.Trajectory.load(out)[-1].x, axis=1)
    assert twin["knots"] == apart.max()
    corners = simulation.system.net.nodes_of("corners")
    assert twin["bullets"] == apart[corners].max() > 0
    # both flights begin with the same momentum, but the z axis of the middle is held: along x and y it is round-off
    assert twin["momentum"] < 1e-6
    share = 100 * twin["deployment"]["largest_mouth_area"] / summary["deployment"]["largest_mouth_area"]
    assert f"the twin, from a start 1e-09 m away: largest mouth area ± {share:.2g} %" in told
    assert summary.keys() - summary_without_twin(tmp_path).keys() == {"twin"}


def summary_without_twin(tmp_path):
    assert main(["run", str(tmp_path / "small.toml"), "-o", str(tmp_path / "plain")]) == 0
    return summary_in(tmp_path / "plain")


@pytest.mark.parametrize("others", [["--ensemble", "2"], ["--resume", "out"]])
def test_a_twin_goes_alone(others, tmp_path, capsys):
    scenario = [] if "--resume" in others else [str(written(tmp_path, WITH))]
    assert main(["run", *scenario, "--twin", *others]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--twin does not go with" in line


def test_a_twin_that_fails_is_reported(tmp_path, monkeypatch):
    simulation = nd.read_scenario(written(tmp_path, WITH)).build()

    def fails(self, watch=(), *, resume=None):
        raise RunError("the run failed at t = 0.1 s")
        yield

    monkeypatch.setattr(type(simulation), "integrate", fails)
    twin = twin_of(replace(simulation), {"deployment": {}, "tether": {}}, simulation.start)
    assert twin["status"] == "failed: the run failed at t = 0.1 s"
    assert in_words({"twin": twin, "deployment": {}}).endswith(twin["status"])
