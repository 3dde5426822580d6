"""Slips of the unit are reported, one line each; nets as they are built and flown are not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from folders import summary_of
from shots import shot, write_shot

import netdae as nd
from netdae.cli import main
from netdae.scenario.plausibility import unusual_of

SCRIPTS = Path(__file__).parent.parent / "scripts"

SHOT = shot(
    title="shot",
    side=2.0,
    youngs_modulus="2e9",
    density=1140.0,
    strength=300.0,
    viscosity_time="1e-5",
    scale=0.4,
    half_angle_deg=45,
    sections='[[loads]]\nkind = "gravity"\ng = [0.0, 0.0, -9.81]\n',
    method="explicit",
    end=0.01,
    accuracy=None,
    frames=3,
)


def notes_of(folder, *edits):
    text = SHOT
    for old, new in edits:
        assert old in text
        text = text.replace(old, new)
    return nd.read_scenario(write_shot(folder, text)).build().notes


@pytest.mark.parametrize("path", sorted(SCRIPTS.glob("*.toml")), ids=lambda path: path.stem)
def test_shipped_scenarios_are_usual(path):
    simulation = nd.read_scenario(path).build()
    assert unusual_of(simulation.system, simulation.start, simulation.launch) == ()


def test_a_usual_net_has_no_notes(tmp_path):
    assert notes_of(tmp_path) == ()


DIAMETER, MODULUS, DENSITY = "diameter = 1e-3", "youngs_modulus = 2e9", "density = 1140.0"


@pytest.mark.parametrize(
    ("edits", "words"),
    [
        ([(DIAMETER, "diameter = 1.0")], "diameter is 1 m of all cables, usual is 2e-05 to 0.02 m: "),
        ([(DIAMETER, "diameter = 1e-6")], "diameter is 1e-06 m of all cables"),
        ([(DIAMETER, "area = 0.785")], "diameter is 0.9997 m"),  # mm² for m²
        (
            [(MODULUS, "youngs_modulus = 70")],
            "youngs_modulus is 70 Pa of all cables, usual is 1e+06 to 1e+12 Pa",
        ),
        ([(MODULUS, "youngs_modulus = 7e13")], "youngs_modulus is 7e+13 Pa"),
        ([(DENSITY, "density = 1.14")], "density is 1.14 kg/m³ of all cables, usual is 50 to 25000 kg/m³"),
        ([(DENSITY, "linear_density = 0.9")], "density is 1.146e+06 kg/m³"),  # g/m for kg/m
        (
            [(MODULUS, "youngs_modulus = 9e11"), (DENSITY, "density = 60")],
            "wave speed √(E/ρ̄) is 1.225e+05 m/s",  # √(9e11/60)
        ),
        ([(DIAMETER, "diameter = 0.015"), ("cells = 4", "cells = 10"), ("mass = 0.05", "mass = 5")], ""),
        ([("strength = 300.0", "strength = 0.3")], "strength over cross-section is 3.82e+05 Pa"),  # kN for N
        # ζ = τ c/L̄ = 0.1 · √(2e9/1140)/0.5
        (
            [("viscosity_time = 1e-5", "viscosity_time = 0.1")],
            "share of critical damping is 264.9 of all cables",
        ),
        (
            [('"dashpot"\nviscosity_time = 1e-5', '"rayleigh"\nbeta = 0.1')],
            "share of critical damping is 264.9",
        ),
        ([("side = 2.0", "side = 2000.0")], "the net is 2000 m wide, usual is 0.02 to 500 m"),
        (
            [("speed = 5.0", "speed = 5000.0")],
            "the fastest bullet flies at 5000 m/s, usual is 0.01 to 300 m/s",
        ),
        ([("speed = 5.0", "speed = 0.001")], "the fastest bullet flies at 0.001 m/s"),
        (
            [(MODULUS, "youngs_modulus = 2e6")],  # c = √(2e6/1140) = 41.9 m/s
            "the fastest bullet flies at 5 m/s, 0.12 of the wave speed 41.89 m/s",
        ),
        # three half cables of λ = 1140 π/4 1e-6 kg/m, as most knots of so small a net have them
        (
            [("mass = 0.05", "mass = 1e-5")],
            "has 1e-05 kg, less than a knot with its half cables, 0.000672 kg",
        ),
        ([("mass = 0.05", "mass = 50.0")], "the bullets have 200 kg, 1.12e+04 times the mass"),  # 20 m of λ
        ([("-9.81", "-9810.0")], "gravity is 9810 m/s², usual is below 200 m/s²"),
    ],
    ids=lambda value: value[0][1].split("\n")[0] if isinstance(value, list) else "",
)
def test_a_slip_of_the_unit_is_one_note_with_what_is_given_and_what_is_usual(edits, words, tmp_path):
    if not words:
        words = "length over diameter is 13.33 of all cables, usual is above 20"  # 0.2/0.015
    notes = notes_of(tmp_path, *edits)
    (note,) = notes
    assert words in note
    assert "\n" not in note
    assert ": " in note  # the reason, or the next step


def test_cables_are_named_by_their_group_or_by_the_first(tmp_path):
    extra = (
        '[[material]]\ncables = "border"\nyoungs_modulus = 2e9\ndensity = 1140.0\ndiameter = 0.03\n[damping]'
    )
    (note,) = notes_of(tmp_path, ("[damping]", extra))
    assert note.startswith("diameter is 0.03 m of the cables 'border', usual is")
    net = nd.CableNet.square(side=2.0, cells=4)
    thick = np.full(net.cable_count, 1e-3)
    thick[[3, 7]] = 0.5, 2.0
    system = nd.System(
        replace(net, cable_data={"diameter": thick}),
        nd.Material(youngs_modulus=2e9, density=1140.0, diameter=1e-3),
        damping=nd.NoDamping(),
    )
    (line,) = unusual_of(system, nd.State.at(net.nodes))
    assert line.startswith("diameter is 2 m of 2 of 40 cables, first cable 3, ")


def test_the_speed_of_the_whole_net_is_not_a_shot(tmp_path):
    assert (
        notes_of(tmp_path, ("scale = [0.4, 0.4, 1.0]", "scale = [0.4, 0.4, 1.0]\nvelocity = [0, 0, 900.0]"))
        == ()
    )


def test_check_and_run_tell_what_is_unusual(tmp_path, capsys):
    notes = notes_of(tmp_path, (DIAMETER, "diameter = 0.03"), ("mass = 0.05", "mass = 5"))
    assert len(notes) == 1
    assert main(["check", str(tmp_path / "shot.toml")]) == 0
    assert f"note                {notes[0]}" in capsys.readouterr().out
    assert main(["run", str(tmp_path / "shot.toml"), "-o", str(tmp_path / "out")]) == 0
    assert f"note: {notes[0]}" in capsys.readouterr().out
    assert summary_of(tmp_path / "out")["notes"] == [*notes]
