"""Forces of an orbit act in each step: a long tether at rest along the radius keeps its tension."""

import numpy as np
import pytest

import netdae as nd
from netdae.forces import earth

n = earth.mean_motion(600e3)
CHASER, BODY, LENGTH = 400.0, 20.0, 1000.0  # kg, kg, m
TENSION = 3 * n * n * CHASER * BODY / (CHASER + BODY) * LENGTH  # of masses at rest, by Clohessy and Wiltshire


def tether(EA):
    """Both masses on one cable along x, stretched by its tension; the cord has 1 g."""
    nodes = np.array([[0.0, 0.0, 0.0], [LENGTH, 0.0, 0.0]])
    nodes[:, 0] -= LENGTH * BODY / (CHASER + BODY)
    net = nd.CableNet(nodes, [[0, 1]], {"chaser": [0], "body": [1]}, rest_length=[LENGTH])
    cord = nd.Material(youngs_modulus=EA / 1e-6, density=1.0, area=1e-6)
    masses = {"chaser": CHASER, "body": BODY}
    system = nd.System(net, cord, masses=masses, damping=nd.NoDamping(), loads=[nd.Orbit(n)])
    return system, nd.State.at(nodes * (1 + TENSION / EA))


@pytest.mark.parametrize("accuracy", ["fast", "standard", "accurate"])
@pytest.mark.parametrize("method", ["ida", "explicit"])
@pytest.mark.parametrize("EA", [1e4, 1e5, 1e6])
def test_tension_is_that_of_the_gravity_gradient(EA, method, accuracy):
    """Given as impulses some seconds apart the forces rang the tether: −70 to +54 % at EA = 1e5 N."""
    assert pytest.approx(0.0670, abs=5e-5) == TENSION
    system, start = tether(EA)
    options = nd.SolverOptions(method, accuracy=accuracy)
    flight = nd.simulate(system, start, np.linspace(0.0, 200.0, 201), options=options)
    # 1e-4: the start leaves out the stretch by the strain itself, 7e-6, and the cord's gram, 2e-5 of the masses
    np.testing.assert_allclose([system.tension(state.x)[0] for state in flight], TENSION, rtol=1e-4)
