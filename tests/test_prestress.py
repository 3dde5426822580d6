"""Prestress as an input: tensions in the mesh, the vibration of a string, and what is refused."""

import math

import numpy as np
import pytest
import pyvista

import netdae as nd
from netdae.core.errors import InputError, ScenarioError
from netdae.mesh.io import read_net
from netdae.system.prestressed import prestressed

EA = 2e3
LAWS = [(law, toe) for law in ("st_venant_kirchhoff", "engineering") for toe in (0.0, 1e-3, 0.5)]


def cord(law="st_venant_kirchhoff", toe=0.0, **more):
    return nd.Material(youngs_modulus=2e9, density=1000.0, area=EA / 2e9, law=law, toe_strain=toe, **more)


def stressed(T0, law="st_venant_kirchhoff", toe=0.0):
    """Three cables of 1, 2 and 3 m along x with the prestress T0."""
    net = nd.CableNet([[0, 0, 0], [1, 0, 0], [3, 0, 0], [6.0, 0, 0]], [[0, 1], [1, 2], [2, 3]])
    return nd.System(net, cord(law, toe, prestress=T0), damping=nd.NoDamping())


@pytest.mark.parametrize(("law", "toe"), LAWS)
@pytest.mark.parametrize("T0", [1e-9, 1e-3, 0.9, 1.1, 50.0, 2e3, 2e4])
def test_in_the_reference_a_cable_has_its_prestress(law, toe, T0):
    system = stressed(T0, law, toe)
    # a strain e of the law is round-off of the length over it: 1e-16 of E11 + 1/2, so e has 1e-16/e of itself
    strain = T0 / EA if toe == 0 else min(T0 / EA, math.sqrt(2 * toe * T0 / EA))
    np.testing.assert_allclose(system.tension(system.net.nodes), T0, rtol=1e-15 / strain + 1e-13)


@pytest.mark.parametrize("T0", [1e-3, 0.9, 50.0, 2e4])
def test_rest_lengths_are_those_by_hand(T0):
    span, f = np.array([1.0, 2.0, 3.0]), T0 / EA
    # N = EA (λ − 1); in a toe of 0.5, N = EA (λ − 1)²/1 up to EA/4
    np.testing.assert_allclose(stressed(T0, "engineering").net.rest_length, span / (1 + f), rtol=1e-14)
    e = math.sqrt(f) if f < 0.25 else f + 0.25
    np.testing.assert_allclose(stressed(T0, "engineering", 0.5).net.rest_length, span / (1 + e), rtol=1e-14)
    # N = EA (λ³ − λ)/2, by Cardano's formula, in its trigonometric form below λ = 2/√3
    c = 1.5 * math.sqrt(3) * 2 * f
    root = math.cosh(math.acosh(c) / 3) if c > 1 else math.cos(math.acos(c) / 3)
    np.testing.assert_allclose(stressed(T0).net.rest_length, span * math.sqrt(3) / (2 * root), rtol=1e-12)


def test_mass_is_that_of_the_rest_lengths():
    system = stressed(2e3, "engineering")
    assert system.mass.sum() == pytest.approx(1000.0 * EA / 2e9 * 6.0 / 2.0, rel=1e-14)


def test_a_system_made_of_a_prestressed_net_is_the_same():
    system = stressed(50.0)
    again = prestressed(system.net, system.cords)
    assert np.array_equal(again.rest_length, system.net.rest_length) or np.allclose(
        again.rest_length, system.net.rest_length, rtol=1e-15, atol=0
    )
    turned = system.net.with_nodes(
        system.net.nodes @ np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    )
    np.testing.assert_allclose(
        prestressed(turned, system.cords).rest_length, system.net.rest_length, rtol=1e-14
    )


def test_a_prestressed_string_vibrates_as_theory_says():
    """Fundamental ω of N masses m on a string of the tension T and pieces l: 2 √(T/(m l)) sin(π/(2N))."""
    pieces, T0, length = 20, 30.0, 2.0
    x = np.zeros((pieces + 1, 3))
    x[:, 0] = np.linspace(0.0, length, pieces + 1)
    net = nd.CableNet(x, [[k, k + 1] for k in range(pieces)], {"ends": [0, pieces]})
    system = nd.System(net, cord(prestress=T0), damping=nd.NoDamping(), restraints=[nd.Restraint("ends")])
    piece = length / pieces
    m = 1000.0 * EA / 2e9 * float(system.net.rest_length[0])
    omega = 2 * math.sqrt(T0 / (m * piece)) * math.sin(math.pi / (2 * pieces))
    found, _ = nd.frequencies(system, nd.State.at(net.nodes), count=2)
    # two polarisations; the eigenvalue solver's tolerance
    np.testing.assert_allclose(found, omega / (2 * math.pi), rtol=1e-9)


def test_a_prestressed_square_net_held_by_its_border_stays_at_rest():
    net = nd.CableNet.square(side=2.0, cells=4)
    system = nd.System(
        net, cord(prestress=5.0), damping=nd.Dashpot(viscosity_time=1e-4), restraints=[nd.Restraint("border")]
    )
    flight = nd.simulate(system, nd.State.at(net.nodes), [0.0, 0.1])
    np.testing.assert_allclose(flight[-1].x, net.nodes, atol=1e-12)
    assert system.tension(flight[-1].x) == pytest.approx(5.0, rel=1e-9)


# Data of a mesh


def test_data_of_the_mesh_override_the_material_cable_by_cable(tmp_path):
    points = np.array([[0, 0, 0], [3.0, 0, 0], [3.0, 4.0, 0]])
    grid = pyvista.UnstructuredGrid([2, 0, 1, 2, 1, 2], [3, 3], points)
    grid.cell_data["prestress"] = [7.0, math.nan]
    grid.save(tmp_path / "net.vtu")
    net = read_net(tmp_path / "net.vtu")
    for by_material, expected in ((0.0, [7.0, 0.0]), (3.0, [7.0, 3.0])):
        system = nd.System(net, cord(prestress=by_material), damping=nd.NoDamping())
        np.testing.assert_allclose(system.tension(net.nodes), expected, rtol=1e-12, atol=1e-9)
    nd.write_net(net, tmp_path / "again.vtu")
    np.testing.assert_array_equal(read_net(tmp_path / "again.vtu").cable_data["prestress"], [7.0, math.nan])


@pytest.mark.parametrize("value", [0.0, -1.0])
def test_data_may_be_zero_but_not_below(value):
    def net():
        return nd.CableNet([[0, 0, 0], [1.0, 0, 0]], [[0, 1]], cable_data={"prestress": [value]})

    if value == 0:
        assert not nd.System(net(), cord(prestress=5.0), damping=nd.NoDamping()).tension(net().nodes).any()
    else:
        with pytest.raises(InputError, match="cable 0 has prestress -1: give a finite number zero or more"):
            net()


def test_another_rest_length_is_a_clash():
    net = nd.CableNet([[0, 0, 0], [1.0, 0, 0]], [[0, 1]], rest_length=[0.9])
    with pytest.raises(
        InputError, match=r"cable 0 between nodes 0 and 1 has a prestress of 5 N and the rest length 0.9 m"
    ):
        nd.System(net, cord(prestress=5.0), damping=nd.NoDamping())
    # single precision is none, nor is the one that gives this tension
    rounded = nd.CableNet(net.nodes, net.cables, rest_length=[1.0 + 1e-7])
    assert nd.System(rounded, cord(prestress=5.0), damping=nd.NoDamping()).tension(
        net.nodes
    ) == pytest.approx(5.0)
    fitting = nd.CableNet(net.nodes, net.cables, rest_length=1.0 / np.array([1 + 5.0 / EA]))
    nd.System(fitting, cord("engineering", prestress=5.0), damping=nd.NoDamping())


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"prestress": -1.0}, "prestress is -1: give a finite number zero or more"),
        ({"prestress": math.nan}, "prestress is nan"),
        ({"prestress": 60.0, "strength": 50.0}, "prestress of 60 N, above its strength of 50 N: give less"),
        ({"prestress": 1e5}, "prestress of 100000 N, 50 times its axial stiffness: give less"),
    ],
)
def test_what_no_cable_bears_is_refused(more, words):
    with pytest.raises(InputError, match=words):
        nd.System(nd.CableNet.square(side=1.0, cells=1), cord(**more), damping=nd.NoDamping())


# The scenario

SCENARIO = """
[net]
kind = "square"
side = 2.0
cells = 3

[[material]]
youngs_modulus = 2e9
density = 1000
area = 1e-6
prestress = {}
{}

[damping]
kind = "none"

[[restraints]]
group = "border"

[initial]
rotation_deg = [10.0, 20.0, 30.0]
{}

[solver]
end = 0.01
"""


def built(tmp_path, T0=4.0, more="", initial=""):
    file = tmp_path / "flight.toml"
    file.write_text(SCENARIO.format(T0, more, initial), encoding="utf-8")
    return nd.read_scenario(file).build()


def test_a_scenario_starts_with_its_prestress_and_without_a_warning(tmp_path):
    simulation = built(tmp_path)
    np.testing.assert_allclose(simulation.system.tension(simulation.start.x), 4.0, rtol=1e-11)
    assert simulation.findings == ()


def test_cables_longer_than_in_the_mesh_are_still_warned_of(tmp_path):
    (finding,) = built(tmp_path, initial="scale = [1.1, 1.0, 1.0]").findings
    assert "12 of 24 cables are taut at the start" in finding


def test_a_scenario_is_refused_in_one_line(tmp_path):
    with pytest.raises(
        ScenarioError, match=r"\[\[material\]\]: cable 0 .* above its strength of 3 N: give less"
    ):
        built(tmp_path, more="strength = 3.0")
    with pytest.raises(ScenarioError, match="prestress is -1"):
        built(tmp_path, T0=-1.0)
