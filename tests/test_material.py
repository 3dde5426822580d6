"""Materials and the cords of a net: stiffness and mass by hand, mesh data that override them, mistakes."""

import numpy as np
import pytest
import pyvista

from netdae.core.errors import InputError
from netdae.mesh.io import read_net
from netdae.model.material import Cords, Material
from netdae.model.net import CableNet
from netdae.system.damping import NoDamping
from netdae.system.system import System

NAN = np.nan
NODES, CABLES = [[0, 0, 0], [3.0, 0, 0], [3.0, 4.0, 0]], [[0, 1], [1, 2]]  # 3 m and 4 m
GIVEN = {
    "density": Material(youngs_modulus=2e9, density=1000.0, area=1e-6),
    "linear density": Material(youngs_modulus=2e9, linear_density=1e-3, area=1e-6),
}
"""One cord reported in two ways: EA 2 kN, 1 g/m."""

# data of the two cables, and from them axial stiffness in N and mass per length in g/m of either cord
OVERRIDDEN = {
    "nothing": ({}, [2e3, 2e3], [1.0, 1.0], [1.0, 1.0]),
    "NaN alone": ({"area": [NAN, NAN], "density": [NAN, NAN]}, [2e3, 2e3], [1.0, 1.0], [1.0, 1.0]),
    "area": ({"area": [3e-6, NAN]}, [6e3, 2e3], [3.0, 1.0], [1.0, 1.0]),
    "diameter": ({"diameter": [NAN, 4e-3]}, [2e3, 8e3 * np.pi], [1.0, 4 * np.pi], [1.0, 1.0]),
    "area before diameter": (
        {"diameter": [4e-3, 4e-3], "area": [NAN, 5e-6]},
        [8e3 * np.pi, 10e3],
        [4 * np.pi, 5.0],
        [1.0, 1.0],
    ),
    "youngs_modulus": ({"youngs_modulus": [7e9, NAN]}, [7e3, 2e3], [1.0, 1.0], [1.0, 1.0]),
    "density": ({"density": [NAN, 500.0]}, [2e3, 2e3], [1.0, 0.5], [1.0, 0.5]),
    "density and area": (
        {"density": [700.0, NAN], "area": [2e-6, 2e-6]},
        [4e3, 4e3],
        [1.4, 2.0],
        [1.4, 1.0],
    ),
}


@pytest.mark.parametrize("given", GIVEN)
@pytest.mark.parametrize("name", OVERRIDDEN)
def test_cable_data_override_the_material_cable_by_cable_but_not_its_linear_density(name, given):
    data, stiffness, by_density, by_length = OVERRIDDEN[name]
    net = CableNet(NODES, CABLES, cable_data=data)
    system = System(net, GIVEN[given], damping=NoDamping())
    grams = np.array(by_density if given == "density" else by_length)
    np.testing.assert_allclose(system.cords.axial_stiffness, stiffness, rtol=1e-14)
    np.testing.assert_allclose(system.cords.linear_density, 1e-3 * grams, rtol=1e-14)
    halves = 1e-3 * grams * [1.5, 2.0]
    np.testing.assert_allclose(system.mass, [halves[0], halves.sum(), halves[1]], rtol=1e-14)
    x = net.nodes * 1.01
    strain = 0.5 * (1.01**2 - 1)
    np.testing.assert_allclose(system.tension(x), np.array(stiffness) * strain * 1.01, rtol=1e-12)
    area = np.array(stiffness) / np.where(np.isnan(data.get("youngs_modulus", [NAN, NAN])), 2e9, 7e9)
    np.testing.assert_allclose(system.stress(x) * area, np.array(stiffness) * strain, rtol=1e-12)


@pytest.mark.parametrize("suffix", [".vtu", ".vtk"])
def test_cable_data_of_a_file_with_gaps_fly_as_reported(suffix, tmp_path):
    grid = pyvista.UnstructuredGrid([2, 0, 1, 2, 1, 2], [3, 3], np.array(NODES, dtype=float))
    grid.cell_data["rest_length"] = [NAN, 5.0]
    grid.cell_data["diameter"] = [4e-3, NAN]
    grid.cell_data["youngs_modulus"] = [NAN, 7e9]
    grid.save(tmp_path / f"net{suffix}")
    net = read_net(tmp_path / f"net{suffix}")
    np.testing.assert_array_equal(net.rest_length, [3.0, 5.0])
    system = System(net, GIVEN["density"], damping=NoDamping())
    np.testing.assert_allclose(system.cords.axial_stiffness, [8e3 * np.pi, 7e3], rtol=1e-14)
    np.testing.assert_allclose(system.mass.sum(), 1e-3 * (4 * np.pi * 3.0 + 5.0), rtol=1e-14)
    strain = system.strain(net.nodes)
    np.testing.assert_allclose(strain, [0.0, 0.5 * (16 / 25 - 1)], rtol=1e-14)


def test_a_later_group_overrides_with_its_own_way_to_tell_the_mass():
    net = CableNet(NODES, CABLES, cable_groups={"last": [1]}, cable_data={"area": [2e-6, 2e-6]})
    one, other = GIVEN["density"], GIVEN["linear density"]
    np.testing.assert_allclose(
        Cords.of(net, {"all": one, "last": other}).linear_density, [2e-3, 1e-3], rtol=1e-14
    )
    np.testing.assert_allclose(
        Cords.of(net, {"all": other, "last": one}).linear_density, [1e-3, 2e-3], rtol=1e-14
    )


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"youngs_modulus": "7"}, "youngs_modulus is '7': give a finite number above zero"),
        ({"youngs_modulus": None}, "youngs_modulus is None"),
        ({"density": [1.0]}, r"density is \[1.0\]"),
        ({"strength": -1.0}, "strength is -1: give"),
        ({"toe_strain": np.nan}, "toe_strain is nan: give a finite number zero or more"),
        ({"diameter": 1e200}, "cross-section comes out as inf m²"),
        ({"diameter": 1e-200}, "cross-section comes out as 0 m²"),
        ({"density": 1e-308}, "linear density comes out as .*e-315 kg/m"),
        ({"youngs_modulus": 1e308, "diameter": 1e3}, "axial stiffness comes out as inf N"),
    ],
)
def test_material_that_is_no_number_or_out_of_range_is_reported(changed, words):
    good = {"youngs_modulus": 70e9, "density": 1390.0, "diameter": 1e-3}
    with pytest.raises(InputError, match=f"^material: .*{words}") as caught:
        Material(**{**good, **changed})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({"diameter": [1.0, 1e200]}, "cable 1 has the axial stiffness inf N"),
        ({"density": [1e-308, NAN]}, "cable 0 has the linear density 1e-314 kg/m"),
    ],
)
def test_cable_data_out_of_range_are_reported_by_the_cable(data, words):
    with pytest.raises(InputError, match=words):
        Cords.of(CableNet(NODES, CABLES, cable_data=data), GIVEN["density"])


def test_numbers_of_numpy_are_numbers():
    cord = Material(youngs_modulus=np.float64(7e9), density=np.int64(1000), diameter=np.float32(0.5))
    assert cord.cross_section == pytest.approx(np.pi / 16, rel=1e-15)


def test_a_system_without_damping_says_how_to_ask_for_none():
    with pytest.raises(InputError, match=r"damping is None: give a Dashpot, Rayleigh, or NoDamping\(\)"):
        System(CableNet(NODES, CABLES), GIVEN["density"], damping=None)
