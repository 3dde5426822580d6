"""Massless cables between nodes that have masses: motion against theory, what is refused, and every verb."""

import math
import warnings

import numpy as np
import pytest
import pyvista

import netdae as nd
from netdae.cli import main
from netdae.core.errors import InputError
from netdae.mesh.io import read_net

EA, M, G = 50.0, 0.5, 9.81
LINE = nd.CableNet([[0, 0, 0], [0, 0, -1.0]], [[0, 1]], {"top": [0], "bob": [1]})


def cord(**mass):
    return nd.Material(youngs_modulus=2e9, area=EA / 2e9, law="engineering", **(mass or {"density": 0.0}))


@pytest.mark.parametrize("method", ["ida", "explicit"])
@pytest.mark.parametrize("mass", [{"density": 0.0}, {"linear_density": 0.0}])
def test_a_bob_on_a_massless_cable_bounces_as_a_spring(method, mass):
    system = nd.System(
        LINE,
        cord(**mass),
        damping=nd.NoDamping(),
        masses={"bob": M},
        loads=[nd.Gravity([0, 0, -G])],
        restraints=[nd.Restraint("top")],
    )
    np.testing.assert_array_equal(system.mass, [0.0, M])
    omega = math.sqrt(EA / M)  # EA over 1 m
    times = np.linspace(0.0, 2 * math.pi / omega, 9)
    options = nd.SolverOptions(method, accuracy="accurate", max_step=5e-3)
    flight = nd.simulate(system, nd.State.at(LINE.nodes), times, options=options)
    drop = M * G / EA
    exact = -1.0 - drop * (1 - np.cos(omega * times))
    # Verlet lags by (ωh)²/24 = 1e-4 of 2π; the rest are the tolerances of IDA
    np.testing.assert_allclose(flight.positions[:, 1, 2], exact, atol=2e-3 * drop)


def test_mesh_data_may_be_massless(tmp_path):
    grid = pyvista.UnstructuredGrid(
        [2, 0, 1, 2, 1, 2], [3, 3], np.array([[0, 0, 0], [1.0, 0, 0], [2.0, 0, 0]])
    )
    grid.cell_data["density"] = [0.0, math.nan]
    grid.save(tmp_path / "net.vtu")
    net = read_net(tmp_path / "net.vtu")
    system = nd.System(net, cord(density=1000.0), damping=nd.NoDamping(), restraints=[nd.Restraint((0,))])
    np.testing.assert_allclose(system.mass, [0.0, 0.5e3 * EA / 2e9, 0.5e3 * EA / 2e9], rtol=1e-14)


def test_a_free_node_without_mass_is_refused_with_the_reason():
    with pytest.raises(
        InputError, match="node 1 is free but has no mass: its cables have none and no bullet"
    ):
        nd.System(LINE, cord(), damping=nd.NoDamping(), restraints=[nd.Restraint("top")])


def test_a_share_of_critical_damping_is_refused():
    with pytest.raises(InputError, match="cable 0 has no mass, so no share of critical damping is known"):
        nd.System(LINE, cord(), damping=nd.Dashpot(zeta=0.1), masses={"all": 1.0})
    nd.System(LINE, cord(), damping=nd.Dashpot(zeta=0.0), masses={"all": 1.0})


SCENARIO = """
[net]
kind = "square"
side = 1.0
cells = 2

[[material]]
youngs_modulus = 1e9
density = {}
diameter = 1e-3

[damping]
kind = "dashpot"
viscosity_time = 1e-4

[[masses]]
group = "all"
mass = 0.01

[[masses]]
group = "corners"
mass = 0.2

[initial]
scale = [0.5, 0.5, 1.0]

[[initial.ejection]]
group = "corners"
speed = 2.0
half_angle_deg = 45.0

[[loads]]
kind = "air"

[solver]
end = 0.05

[output]
frames = 3
"""


@pytest.mark.parametrize("verb", ["check", "forces", "run"])
def test_each_verb_takes_massless_cables(verb, tmp_path, capsys):
    file = tmp_path / "flight.toml"
    file.write_text(SCENARIO.format(0), encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)  # of numpy, about divisions by zero
        assert main([verb, str(file), *(["-o", str(tmp_path / "out")] if verb == "run" else [])]) == 0
    told = capsys.readouterr()
    for word in ("nan", "inf ", "usual is"):
        assert word not in told.out + told.err


def test_a_density_between_zero_and_the_least_is_refused(tmp_path, capsys):
    file = tmp_path / "flight.toml"
    file.write_text(SCENARIO.format(1e-12), encoding="utf-8")
    assert main(["check", str(file)]) == 2
    assert "density is 1e-12, expected 0, or 1e-09 or more" in capsys.readouterr().err
