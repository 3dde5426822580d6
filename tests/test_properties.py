"""What holds for all cables of a kind, at numbers that hypothesis draws: the same ones in each run."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import netdae as nd

G = 9.81
DRAWN = settings(deadline=None, derandomize=True, database=None, max_examples=40)
FLOWN = settings(DRAWN, max_examples=6)

laws = st.sampled_from(["st_venant_kirchhoff", "engineering"])
vectors = st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=3).map(np.array)


def over(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers spread evenly over the decades from low to high."""
    return st.floats(math.log(low), math.log(high)).map(math.exp)


@DRAWN
@given(law=laws, toe=st.sampled_from([0.0, 1e-4, 1e-2, 0.3]), share=over(1e-6, 5.0), length=over(1e-2, 1e2))
def test_a_cable_has_its_prestress_in_the_mesh(law, toe, share, length):
    cord = nd.Material(
        youngs_modulus=1e9, density=1000.0, area=1e-6, law=law, toe_strain=toe, prestress=1e3 * share
    )
    net = nd.CableNet([[0, 0, 0], [0, length, 0]], [[0, 1]])
    system = nd.System(net, cord, damping=nd.NoDamping())
    strain = min(share, math.sqrt(2 * toe * share)) if toe else share
    # round-off of E11 + 1/2 is 1e-16, and the tension has 1e-16 over the strain of itself
    assert system.tension(net.nodes)[0] == pytest.approx(1e3 * share, rel=4e-15 / strain + 1e-12)


@DRAWN
@given(spin=vectors, drift=vectors, seed=st.integers(0, 1000))
def test_a_spin_adds_its_angular_momentum_and_no_momentum(spin, drift, seed):
    rng = np.random.default_rng(seed)
    x, mass = rng.uniform(-3.0, 3.0, (8, 3)), rng.uniform(1e-3, 5.0, 8)
    start = nd.State.at(x, np.broadcast_to(drift, x.shape))
    turning = nd.spun(start, mass, spin)
    r = x - mass @ x / mass.sum()
    inertia = np.einsum("n,n,ij->ij", mass, (r**2).sum(axis=1), np.eye(3))
    inertia -= np.einsum("n,ni,nj->ij", mass, r, r)
    gained = turning.v - start.v
    # round-off of some hundred kg m²/s
    np.testing.assert_allclose(mass @ gained, 0.0, atol=1e-12)
    np.testing.assert_allclose(mass @ np.cross(x, gained), inertia @ np.deg2rad(spin), atol=1e-11)


def pendulum(EA: float, degrees: float, mass: float) -> tuple[nd.System, nd.State]:
    """A mass on a cord of 1 m, at rest with the tension that it has there."""
    theta = math.radians(degrees)
    along = np.array([math.sin(theta), 0.0, -math.cos(theta)])
    net = nd.CableNet(np.stack((0 * along, along)), [[0, 1]], {"top": [0], "bob": [1]})
    cord = nd.Material(youngs_modulus=1e6 * EA, density=0.0, area=1e-6)
    system = nd.System(
        net,
        cord,
        damping=nd.NoDamping(),
        masses={"bob": mass},
        loads=[nd.Gravity([0.0, 0.0, -G])],
        restraints=[nd.Restraint("top")],
    )
    stretch = 1.0 + mass * G * math.cos(theta) / EA  # to the first order in the strain
    return system, nd.State.at(net.nodes * stretch)


@FLOWN
@given(EA=over(1e4, 1e7), degrees=st.floats(10.0, 75.0), mass=st.floats(0.2, 3.0))
@pytest.mark.parametrize("method", ["ida", "explicit"])
def test_a_pendulum_pulls_with_three_cosines(method, EA, degrees, mass):
    """T = m g (3 cos θ − 2 cos θ₀), within 2 % of the largest and 1 % of the energy, which the presets promise."""
    system, start = pendulum(EA, degrees, mass)
    first, largest = math.cos(math.radians(degrees)), mass * G * (3 - 2 * math.cos(math.radians(degrees)))
    flight = nd.simulate(system, start, np.linspace(0.0, 0.8, 9), options=nd.SolverOptions(method))
    energies = []
    for state in flight:
        cosine = -state.x[1, 2] / np.linalg.norm(state.x[1])
        right = mass * G * (3 * cosine - 2 * first)
        assert system.tension(state.x)[0] == pytest.approx(right, abs=0.02 * largest)
        stored = system.kinetic_energy(state.v) + system.elastic_energy(state.x)
        energies.append(stored + mass * G * state.x[1, 2])
    assert np.ptp(energies) < 0.01 * mass * G * (1 - first)
