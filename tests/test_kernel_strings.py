"""The flat arrays of cords through rings and of motors against the forces that they were made of."""

import numpy as np
import pytest
from numpy.random import default_rng

from netdae.forces.drawcord import SlidingCord
from netdae.forces.motor import Motor
from netdae.forces.rings import Cord
from netdae.kernels.strings import (
    add_motor_pulls,
    add_string_pulls,
    motor_slope,
    motors_of,
    string_room_of,
    string_tangents,
    strings_of,
    tangents_of,
    wound_in,
)

NODES = 9


def cords(stretch):
    """A closed cord with friction, an open one with a toe, and one of two rings: taut where stretch is above 1."""
    return [
        SlidingCord(
            np.array([[3, 0, 4, 1, 7]]), _cord(9.0 / stretch, tau=1e-2, friction=0.3, theta=0.5), True
        ),
        SlidingCord(np.array([[5, 2, 6, 8]]), _cord(4.0 / stretch, eps=0.3, engineering=True), False),
        SlidingCord(np.array([[1, 2, 7]]), _cord(1.5 / stretch, share=0.5, tau=1e-3), False),
    ]


def _cord(L, share=-1.0, eps=0.0, engineering=False, tau=0.0, friction=0.0, theta=1.0):
    return Cord(L, share, 50.0, eps, engineering, tau, 1e-2, friction, 0.2, theta)


def state(seed):
    rng = default_rng(seed)
    x, v = rng.uniform(-1, 1, (NODES, 3)), rng.standard_normal((NODES, 3))
    x[7:, 0] = rng.uniform(0.05, 0.2, 2)
    return x, v


def close(one, other):
    """But for round-off: what is compiled into another function may be compiled in another order."""
    np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-13 * max(np.abs(other).max(initial=0.0), 1e-9))


@pytest.mark.parametrize("stretch", [0.3, 1.4, 6.0])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_they_give_the_forces_powers_and_tangents_of_the_cords(seed, stretch):
    forces, (x, v) = cords(stretch), state(seed)
    strings = strings_of(forces)
    room, tangents = string_room_of(strings), tangents_of(strings)
    f = np.zeros(3 * NODES)
    tally = add_string_pulls(x.ravel(), v.ravel(), strings, f, room)
    string_tangents(x.ravel(), v.ravel(), strings, room, tangents)
    told, stored, dissipated = np.zeros((NODES, 3)), 0.0, 0.0
    for s, force in enumerate(forces):
        xe, ve = x[force.nodes], v[force.nodes]
        told[force.nodes[0]] += force.force(0.0, xe, ve)[0]
        account = force.account(0.0, xe, ve)
        stored, dissipated = stored + account.stored_energy, dissipated + account.dissipated_power
        pieces = slice(strings.first[s], strings.first[s + 1])
        close(room.tension[pieces], force.tensions(0.0, xe, ve))
        part = force.newton_part(0.0, xe, ve)
        assert tangents.rank[s] == len(part.left)
        if len(part.left):
            rows = slice(tangents.begin[s], tangents.begin[s] + part.left.size // 3)
            close(tangents.chain[pieces], part.dx)
            for mine, theirs in zip(
                (tangents.left, tangents.by_x, tangents.by_v), (part.left, part.by_x, part.by_v), strict=True
            ):
                close(mine[rows], theirs.reshape(-1, 3))
    np.testing.assert_allclose(f.reshape(-1, 3), told, rtol=1e-15, atol=1e-13)  # in another order
    assert tally.stored == pytest.approx(stored, rel=1e-14)
    assert tally.dissipated == pytest.approx(dissipated, rel=1e-14)
    taut = int((tangents.rank > 0).sum())
    assert taut == 3 if stretch > 2 else taut == 0 if stretch < 0.5 else True
    assert (taut > 0) == (tally.strain >= 0.0) == (tally.tension > 0.0)


def test_a_cord_that_is_wound_in_whole_is_told():
    strings, (x, _) = strings_of(cords(1.0)), state(0)
    assert wound_in(x.ravel(), strings) == -1
    x[8, 0] = 4.0
    assert wound_in(x.ravel(), strings) == 1
    x[8, 0] = np.nan
    assert wound_in(x.ravel(), strings) == 1


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_motors_pull_as_their_forces_do(seed):
    motor = Motor(
        np.array([[7], [2]]),
        np.array([5.0, 3.0]),
        np.array([0.1, -0.2]),
        np.array([0.02, 0.3]),
        np.array([0.05, 0.4]),
    )
    other = Motor(np.array([[8]]), *(np.array([each]) for each in (2.0, 0.5, 0.1, 0.1)))
    motors, (x, v) = motors_of([motor, other]), state(seed)
    v *= 0.3
    f, told = np.zeros(3 * NODES), np.zeros((NODES, 3))
    dissipated, external = add_motor_pulls(v.ravel(), motors, f)
    slopes, accounts = [], []
    for force in (motor, other):
        xe, ve = x[force.nodes], v[force.nodes]
        told[force.nodes[:, 0]] += force.force(0.0, xe, ve)[:, 0]
        accounts.append(force.account(0.0, xe, ve))
        slopes += force.tangent(0.0, xe, ve).dv[:, 0, 0, 0, 0].tolist()
    np.testing.assert_allclose(f.reshape(-1, 3), told, rtol=1e-15)
    assert dissipated == pytest.approx(sum(each.dissipated_power for each in accounts), rel=1e-14)
    assert external == pytest.approx(sum(each.external_power for each in accounts), rel=1e-14)
    assert [motor_slope(v.ravel(), motors, w) for w in range(3)] == pytest.approx(slopes, rel=1e-15)


def test_without_cords_and_motors_nothing_is_given():
    strings, motors, (x, v) = strings_of([]), motors_of([]), state(0)
    f = np.zeros(3 * NODES)
    room = string_room_of(strings)
    assert add_string_pulls(x.ravel(), v.ravel(), strings, f, room) == (0.0, 0.0, 0.0, -np.inf)
    string_tangents(x.ravel(), v.ravel(), strings, room, tangents_of(strings))
    assert add_motor_pulls(v.ravel(), motors, f) == (0.0, 0.0)
    assert not f.any()
