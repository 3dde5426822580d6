"""Springs between nodes and to the ground: closed forms by every method, and scenarios."""

from __future__ import annotations

import numpy as np
import pytest
from shots import shot

import netdae as nd
from netdae.cli import main

K, C, M = 40.0, 1.5, 0.6  # N/m, N s/m, kg
METHODS = ["ida", "explicit", "rk45", "cvode_bdf"]


def bodies(**more):
    """Two bodies of M on a cord that stays slack."""
    nodes, groups = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], {"a": [0], "b": [1], "both": [0, 1]}
    net = nd.CableNet(nodes, [[0, 1]], groups, rest_length=[50.0])
    cord = nd.Material(youngs_modulus=1e6, density=1e-3, diameter=1e-3)
    return nd.System(net, cord, masses={"both": M}, damping=nd.NoDamping(), **more)


def damped(t, x0, k, c, m):
    """m ẍ + c ẋ + k x = 0 from rest at x0."""
    decay, omega = 0.5 * c / m, np.sqrt(k / m - 0.25 * (c / m) ** 2)
    return x0 * np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))


def options(method):
    if method == "explicit":
        return nd.SolverOptions(method, max_step=1e-4)
    return nd.SolverOptions(method, rtol=1e-8, atol_position=1e-9, atol_velocity=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_a_body_on_a_spring_to_the_ground_swings_as_in_textbooks(method):
    """Held at its place without rest length, from where it is pushed aside along all axes."""
    system = bodies(loads=[nd.Spring("b", K, viscosity=C)])
    aside = np.array([0.1, -0.2, 0.3])
    start = nd.State.at(system.net.nodes + np.array([np.zeros(3), aside]))
    times = np.linspace(0.0, 1.0, 5)
    metrics = nd.DeploymentMetrics(mouth=None)
    flight = nd.simulate(system, start, times, options=options(method), observers=[metrics])
    m = system.mass[1]
    exact = system.net.nodes[1] + damped(times[:, None], aside, K, C, m)
    # leapfrog: the damper half a step late, c h/2m = 1e-4 of it; others by their tolerance over some hundred steps
    np.testing.assert_allclose(
        flight.positions[:, 1], exact, rtol=0, atol=1e-4 if method == "explicit" else 1e-6
    )
    stored = 0.5 * K * aside @ aside
    assert flight[-1].balance.dissipated_energy > 0.5 * stored
    assert flight[-1].balance.external_work == 0.0  # the ground does not move
    assert np.abs(metrics.table()["energy_residual"]).max() < 1e-3 * stored
    assert abs(metrics.summary()["momentum_residual"]) < 1e-3 * M * 2.0  # what the ground gives is booked


@pytest.mark.parametrize("method", METHODS)
def test_two_bodies_on_a_spring_swing_about_their_middle_and_keep_both_momenta(method):
    """x = L + a cos ωt of the distance with the reduced mass; turned, so that no axis is special."""
    system = bodies(loads=[nd.Spring("a", K, to="b", rest_length=0.8)])
    Q = np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))[0]
    start = nd.State.at(system.net.nodes @ Q.T, np.tile([0.3, 0.1, -0.2], (2, 1)))
    times = np.linspace(0.0, 1.0, 5)
    flight = nd.simulate(system, start, times, options=options(method))
    distance = np.linalg.norm(flight.positions[:, 1] - flight.positions[:, 0], axis=1)
    omega = np.sqrt(2 * K / system.mass[0])
    np.testing.assert_allclose(distance, 0.8 + 0.2 * np.cos(omega * times), rtol=0, atol=2e-6)
    last = flight[-1]
    np.testing.assert_allclose(system.momentum(last.v), system.momentum(start.v), rtol=0, atol=1e-9)
    turned = [system.angular_momentum(each.x, each.v) for each in (start, last)]
    np.testing.assert_allclose(turned[1], turned[0], rtol=0, atol=1e-7)  # of 0.2 N m s


def held(method="ida", more=""):
    """Text of a shot whose centre is held softly; `more` keys of the spring."""
    spring = f'[[loads]]\nkind = "spring"\ngroup = "centre"\nstiffness = 50.0\nviscosity = 0.2\n{more}\n'
    return shot(
        title="soft hold",
        youngs_modulus="1e8",
        speed=2.0,
        sections=spring,
        method=method,
        end=0.2,
        accuracy=None,
        frames=3,
    )


@pytest.mark.parametrize("method", ["ida", "explicit"])
def test_a_scenario_holds_the_centre_softly_and_is_checked_and_resumed(method, tmp_path, capsys):
    file = tmp_path / "hold.toml"
    file.write_text(held(method), encoding="utf-8")
    assert main(["check", str(file)]) == 0, capsys.readouterr()
    assert main(["run", str(file), "-o", str(tmp_path / "out")]) == 0
    system = nd.read_scenario(file).build().system
    flight = nd.Trajectory.load(tmp_path / "out")
    centre = system.net.nodes_of("centre")[0]
    way = np.linalg.norm(flight.positions[:, centre] - flight.positions[0, centre], axis=1)
    assert 0.0 < way[-1] < 0.2  # free, the centre of mass goes 0.16 m and the centre after it
    total = flight.positions[-1] - flight.positions[0]
    assert np.linalg.norm(total, axis=1).max() > way[-1]


@pytest.mark.parametrize(
    ("more", "reported"),
    [
        ('to = "corners"', "the group 'corners' has 4 nodes: name one of a single node"),
        ('to = "centre"', "is in 'centre' and in 'centre': join two nodes"),
        (
            'to = "corners"\nanchor = [0.0, 0.0, 0.0]',
            "both of to and anchor are given: leave one of them out",
        ),
        ('to = "nobody"', "nobody"),
        ("rest_length = -1.0", "rest_length"),
    ],
)
def test_a_spring_that_cannot_be_is_refused_in_one_line(more, reported, tmp_path, capsys):
    file = tmp_path / "hold.toml"
    file.write_text(held(more=more), encoding="utf-8")
    assert main(["run", str(file), "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert reported in error
    assert error.count("\n") == 1


def test_springs_are_ranked_beside_other_forces(tmp_path, capsys):
    file = tmp_path / "hold.toml"
    file.write_text(held(), encoding="utf-8")
    assert main(["forces", str(file)]) == 0
    assert "springs" in capsys.readouterr().out


def test_springs_on_all_nodes_beside_a_closing_are_refused(tmp_path, capsys):
    """Its drums would be held too."""
    text = held().replace('group = "centre"', 'group = "all"', 1)
    closing = """
[[closing]]
kind = "winch"
first = [0]
second = [4]
speed = 1.0
force = 10.0
final_length = 0.5
begin = 0.01
youngs_modulus = 1e9
density = 1140.0
diameter = 1.5e-3
"""
    file = tmp_path / "hold.toml"
    file.write_text(text + closing, encoding="utf-8")
    assert main(["check", str(file)]) == 2
    assert "group 'all' has the tether, the chaser and all drums in it too" in capsys.readouterr().err
