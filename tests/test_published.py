"""Results of other codes' verification manuals."""

import numpy as np
import pytest
from conftest import line
from scipy.optimize import brentq

import netdae as nd

INCH, POUND = 0.0254, 4.4482216152605  # m, N
PSI = POUND / INCH**2
SLUG_INCH = POUND / INCH  # lb s²/in in kg


def extrapolated(coarse, fine):
    """Limit of a quantity whose error falls by four at each halving."""
    return (4 * np.asarray(fine) - np.asarray(coarse)) / 3


def string_frequencies(cables, density):
    """VM53 of the ANSYS verification manual: a string of 100 in drawn to 500 lb; first three frequencies, Hz."""
    length, modulus, area, tension = 100 * INCH, 30e6 * PSI, 0.00306796 * INCH**2, 500 * POUND

    def excess(L):  # N = S11 A l/L with S11 = E E11
        return modulus * 0.5 * ((length / L) ** 2 - 1) * area * length / L - tension

    rest = brentq(excess, 0.99 * length, length, xtol=1e-15, rtol=1e-15)
    net = line(cables, length=length)
    net = nd.CableNet(net.nodes, net.cables, net.node_groups, rest_length=np.full(cables, rest / cables))
    cord = nd.Material(youngs_modulus=modulus, density=density * length / rest, area=area)
    ends = [nd.Restraint("first"), nd.Restraint("last"), nd.Restraint("inner", "z")]
    system = nd.System(net, cord, damping=nd.NoDamping(), restraints=ends)
    np.testing.assert_allclose(system.tension(net.nodes), tension, rtol=1e-10)
    return nd.frequencies(system, nd.equilibrium(system, net.nodes), count=3)[0], length / rest


def test_ansys_vm53_string_under_tension():
    # Ansys Mechanical APDL Verification Manual, VM53, "Vibration of a String Under Tension".
    # Its elements have the mass ρAl of the drawn string, ours ρ̄ĀL̄: so ρ̄ = ρ l/L̄ for the same string
    density = 0.00073 * SLUG_INCH / INCH**3
    coarse, fine = (string_frequencies(cables, density)[0] for cables in (20, 40))
    # extrapolation leaves x⁴/120 with x = nπ/80, below 2e-6; the manual has five digits
    np.testing.assert_allclose(extrapolated(coarse, fine), [74.708, 149.42, 224.12], rtol=1e-4)


def test_density_of_vm53_belongs_to_the_drawn_string():
    # with ρ taken for ρ̄ the same string is lighter by L̄/l and higher by the root of it, 2.7e-3
    density = 0.00073 * SLUG_INCH / INCH**3
    kept, stretch = string_frequencies(20, density)
    lighter, _ = string_frequencies(20, density / stretch)
    np.testing.assert_allclose(lighter / kept, stretch**0.5, rtol=1e-9)
    assert stretch**0.5 - 1 == pytest.approx(2.7e-3, rel=0.02)


def heavy_cable_sag(cables, law, stretch):
    """SSNL114 of code_aster, V6.02.114: a cable as long as its span, cold or hot; lowest point, m."""
    net = line(cables, length=325.0)
    net = nd.CableNet(net.nodes, net.cables, net.node_groups, rest_length=stretch * net.rest_length)
    cord = nd.Material(youngs_modulus=5.70e10, density=2844.23, area=2.2783e-4, law=law)
    ends = [nd.Restraint("first"), nd.Restraint("last")]
    gravity = nd.Gravity([0.0, 0.0, -9.81])
    system = nd.System(net, cord, damping=nd.NoDamping(), loads=[gravity], restraints=ends)
    return nd.equilibrium(system, net.nodes).x[cables // 2, 2]


@pytest.mark.parametrize(("stretch", "reference"), [(1.0, -6.352), (1 + 2.3e-5 * 39.26, -8.195)])
def test_code_aster_ssnl114_heavy_cable(stretch, reference):
    # the reference is a solution of the catenary with N = EA (l/L̄ − 1), told to be good to 1e-3 m
    sag = extrapolated(*(heavy_cable_sag(N, "engineering", stretch) for N in (40, 80)))
    assert sag == pytest.approx(reference, abs=1e-3)
    # Eq. (4) is stiffer by 1.5 times the strain of 1e-3; the sag of a flat cable goes as its cube root, so 5e-4
    sag = extrapolated(*(heavy_cable_sag(N, "st_venant_kirchhoff", stretch) for N in (40, 80)))
    assert sag == pytest.approx(reference, rel=1e-3)
    assert abs(sag) < abs(reference)
