"""Spin at the start: momenta, the motion of a spinning ring, bullets and what is refused."""

import math

import numpy as np
import pytest

import netdae as nd
from netdae.core.errors import InputError, ScenarioError

SPIN = [40.0, -70.0, 110.0]  # degrees/s


def test_a_spin_leaves_momentum_and_adds_inertia_times_spin():
    rng = np.random.default_rng(5)
    x, v, m = rng.normal(size=(9, 3)), rng.normal(size=(9, 3)), rng.uniform(0.1, 2.0, 9)
    start = nd.State.at(x, v, t=3.0)
    turning = nd.spun(start, m, SPIN)
    assert turning.t == 3.0
    assert np.array_equal(turning.x, x)
    np.testing.assert_allclose(m @ turning.v, m @ v, atol=1e-13)
    r = x - m @ x / m.sum()
    inertia = np.einsum("n,n,ij->ij", m, (r**2).sum(axis=1), np.eye(3)) - np.einsum("n,ni,nj->ij", m, r, r)
    gained = m @ np.cross(x, turning.v - v)
    np.testing.assert_allclose(gained, inertia @ np.deg2rad(SPIN), atol=1e-12)


@pytest.mark.parametrize(
    ("mass", "spin", "words"),
    [
        (np.ones(3), SPIN, r"mass has the shape \(3,\): give one number for each of 4 nodes"),
        (np.ones(4), [1.0, 2.0], r"spin_deg_s is \[1.0, 2.0\]: give three finite numbers"),
        (np.ones(4), [1.0, 2.0, math.nan], r"spin_deg_s is \[1.0, 2.0, nan\]: give three finite numbers"),
        (np.zeros(4), SPIN, "no node has a mass"),
    ],
)
def test_what_cannot_spin_is_refused(mass, spin, words):
    with pytest.raises(InputError, match=f"^spin: {words}"):
        nd.spun(nd.State.at(np.eye(4, 3)), mass, spin)


@pytest.mark.parametrize("method", ["ida", "explicit"])
def test_a_ring_of_masses_keeps_turning_at_its_hoop_tension(method):
    """n masses m at the corners of a polygon of radius R hold N = m R ω²/(2 sin(π/n)) in each side."""
    n, R, m, omega = 6, 1.0, 0.2, math.radians(180.0)
    angles = 2 * math.pi * np.arange(n) / n
    x = R * np.stack((np.cos(angles), np.sin(angles), 0 * angles), axis=1)
    hoop = m * R * omega**2 / (2 * math.sin(math.pi / n))
    net = nd.CableNet(x, [[k, (k + 1) % n] for k in range(n)])
    cord = nd.Material(youngs_modulus=1e8, density=0.0, area=1e-6, prestress=hoop)
    system = nd.System(net, cord, damping=nd.NoDamping(), masses={"all": m})
    start = nd.spun(nd.State.at(x), system.mass, [0, 0, math.degrees(omega)])
    options = nd.SolverOptions(method, accuracy="accurate", max_step=1e-3)
    flight = nd.simulate(system, start, [0.0, 0.25, 0.5], options=options)
    quarter = np.stack((-x[:, 1], x[:, 0], x[:, 2]), axis=1)
    np.testing.assert_allclose(flight[-1].x, quarter, atol=1e-4)  # of arcs of 1.6 m
    np.testing.assert_allclose(system.tension(flight[-1].x), hoop, rtol=2e-2)


SCENARIO = """
[net]
file = "net.vtu"

[[material]]
youngs_modulus = 1e9
density = 1000
diameter = 1e-3

[damping]
kind = "dashpot"
viscosity_time = 1e-4

[[masses]]
group = "corners"
mass = 0.2

[[masses]]
group = "one"
mass = 0.3

[initial]
scale = [0.5, 0.3, 1.0]
rotation_deg = [20.0, 30.0, 40.0]
velocity = [0.1, 0.2, 0.3]
spin_deg_s = [40.0, -70.0, 110.0]

{}

[solver]
end = 0.05
"""

SHOT = """[[initial.ejection]]
group = "corners"
speed = 2.0
half_angle_deg = 45.0
"""


def built(tmp_path, more=""):
    net = nd.CableNet.square(side=2.0, cells=2)
    groups = {**net.node_groups, "one": [0]}  # beside the middle
    nd.write_net(nd.CableNet(net.nodes, net.cables, groups), tmp_path / "net.vtu", overwrite=True)
    file = tmp_path / "flight.toml"
    file.write_text(SCENARIO.format(more), encoding="utf-8")
    return nd.read_scenario(file).build()


def test_a_scenario_spins_about_its_centre_of_mass_bullets_included(tmp_path):
    simulation = built(tmp_path)
    m, start = simulation.system.mass, simulation.start
    centre = m @ start.x / m.sum()
    exact = np.array([0.1, 0.2, 0.3]) + np.cross(np.deg2rad(SPIN), start.x - centre)
    np.testing.assert_allclose(start.v, exact, atol=1e-14)
    np.testing.assert_allclose(
        simulation.system.momentum(start.v), m.sum() * np.array([0.1, 0.2, 0.3]), rtol=1e-13
    )


def test_bullets_are_shot_from_the_spinning_net(tmp_path):
    still, shot = built(tmp_path), built(tmp_path, SHOT)
    corners = shot.system.net.nodes_of("corners")
    gained = shot.start.v - still.start.v
    np.testing.assert_allclose(np.linalg.norm(gained[corners], axis=1), 2.0, rtol=1e-12)
    others = np.setdiff1d(np.arange(9), corners)
    assert not gained[others].any()


def test_bullets_that_are_held_do_not_spin(tmp_path):
    with pytest.raises(
        ScenarioError, match=r"\[initial\]: spin_deg_s is .* holds the bullet at node .* for 0.01 s"
    ):
        built(tmp_path, f"{SHOT}release_times = [0.0, 0.01, 0.0, 0.0]\n")
