"""Bullets leave with their errors and at their times, and the net's centre of mass follows from their momentum."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import CORD
from numpy.random import default_rng

from netdae.core.errors import InputError
from netdae.initial.accordion import accordion
from netdae.initial.canister import Canister
from netdae.initial.ejection import Ejection, Launch, Spread, check_bullets, fired, launch_of, velocity_after
from netdae.initial.scaled import ejected, scaled
from netdae.model.net import CableNet
from netdae.solvers.driver import integrate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot
from netdae.system.system import System

NET, START = scaled(CableNet.square(side=2.0, cells=4), (0.5, 0.5, 1.0), velocity=(0.1, 0.0, 0.2))
CORNERS = NET.nodes_of("corners")
AXIS = np.array([0.0, 0.0, 1.0])
ROUND_OFF = 1e-12  # m/s, of speeds of metres a second


def shot(**keys):
    """Velocities (4, 3) of the corners beside that of the net, and their times."""
    launch = launch_of(NET, START, Ejection("corners", **{"speed": 3.0, "half_angle_deg": 30.0, **keys}))
    assert np.array_equal(launch.nodes, CORNERS)
    return launch.velocities - START.v[CORNERS], launch.times


def test_without_errors_all_is_as_the_half_angle_and_speed_say():
    v, times = shot()
    assert np.linalg.norm(v, axis=1) == pytest.approx(3.0, abs=ROUND_OFF)
    assert v @ AXIS == pytest.approx(3.0 * np.cos(np.pi / 6), abs=ROUND_OFF)
    outward = NET.nodes[CORNERS] / np.linalg.norm(NET.nodes[CORNERS], axis=1)[:, None]
    assert np.einsum("ij,ij->i", v, outward) == pytest.approx(1.5, abs=ROUND_OFF)
    assert (times == 0).all()
    state = ejected(NET, START, "corners", speed=3.0, half_angle_deg=30.0)
    assert np.array_equal(state.v[CORNERS], v + START.v[CORNERS])


def test_listed_errors_change_each_bullet_alone():
    speeds, angles, turns = [0.1, 0.0, -0.3, 0.0], [0.0, 2.0, 0.0, -5.0], [0.0, 0.0, 7.0, -3.0]
    v, times = shot(
        speed_errors=speeds,
        angle_errors_deg=angles,
        azimuth_errors_deg=turns,
        release_times=[0, 0.1, 0, 0.02],
    )
    plain, _ = shot()
    assert np.linalg.norm(v, axis=1) == pytest.approx(3.0 + np.array(speeds), abs=ROUND_OFF)
    angle = np.rad2deg(np.arccos(v @ AXIS / np.linalg.norm(v, axis=1)))
    assert angle == pytest.approx(30.0 + np.array(angles), abs=1e-9)
    azimuth = [np.rad2deg(np.arctan2(u[:, 1], u[:, 0])) for u in (v, plain)]
    assert azimuth[0] - azimuth[1] == pytest.approx(turns, abs=1e-9)
    assert np.array_equal(times, [0, 0.1, 0, 0.02])


def test_errors_turn_with_the_axis():
    """The same shot about another axis: all angles are measured from it."""
    turn = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # z → x
    other = NET.with_nodes(NET.nodes @ turn.T)
    keys = {"speed": 3.0, "half_angle_deg": 30.0, "azimuth_errors_deg": [1.0, 2.0, 3.0, 4.0]}
    still = scaled(NET, (0.5, 0.5, 1.0))[1]
    moved = type(still).at(still.x @ turn.T)
    plain = launch_of(NET, still, Ejection("corners", **keys)).velocities
    turned = launch_of(other, moved, Ejection("corners", axis=turn @ AXIS, **keys)).velocities
    assert turned == pytest.approx(plain @ turn.T, abs=ROUND_OFF)


def test_spreads_have_their_deviations_and_streams_of_their_own():
    count = 40_000
    spread = Spread(speed=0.2, angle_deg=3.0, azimuth_deg=2.0, time=0.05, seed=4)
    drawn = spread.drawn(count)
    # standard errors: σ/√(2n) of a deviation, σ/√n of a mean; five of them
    for values, sigma in zip(drawn[:3], (0.2, 3.0, 2.0), strict=True):
        assert values.std() == pytest.approx(sigma, rel=5 / np.sqrt(2 * count))
        assert abs(values.mean()) < 5 * sigma / np.sqrt(count)
    assert drawn[3].min() >= 0  # |N(0, σ)|: its mean square is σ²
    assert np.sqrt(np.mean(drawn[3] ** 2)) == pytest.approx(0.05, rel=5 / np.sqrt(2 * count))
    assert abs(np.corrcoef(drawn)[np.triu_indices(4, 1)]).max() < 5 / np.sqrt(count)
    alone = Spread(angle_deg=3.0, seed=4).drawn(count)
    assert np.array_equal(alone[1], drawn[1])
    assert not alone[0].any()
    assert not np.array_equal(Spread(angle_deg=3.0, seed=5).drawn(count)[1], drawn[1])


def test_each_member_draws_its_own_and_the_first_what_the_seed_alone_gives():
    drawn = [np.array(Spread(speed=0.2, time=0.1, seed=4, member=k).drawn(5)) for k in range(3)]
    assert np.array_equal(drawn[0], Spread(speed=0.2, time=0.1, seed=4).drawn(5))
    assert np.array_equal(drawn[2], Spread(speed=0.2, time=0.1, seed=4, member=2).drawn(5))
    assert not (drawn[0][0] == drawn[1][0]).any()
    assert not (drawn[1][0] == drawn[2][0]).any()
    streams = np.random.default_rng(4).spawn(4)  # as they were drawn before members were
    assert np.array_equal(drawn[0][0], 0.2 * streams[0].standard_normal(5))


def test_drawn_errors_add_to_listed_ones():
    spread = Spread(speed=0.2, seed=1)
    speed = np.linalg.norm(shot(spread=spread, speed_errors=[0.5, 0, 0, 0])[0], axis=1)
    assert speed == pytest.approx(3.0 + np.array([0.5, 0, 0, 0]) + spread.drawn(4)[0], abs=ROUND_OFF)


def test_held_bullets_stay_with_the_canister():
    late = Ejection("corners", 3.0, 30.0, release_times=[0, 0.1, 0, 0.02])
    state, launch = fired(NET, START, [late])
    held = launch.held
    assert np.array_equal(held.nodes, CORNERS[[1, 3]])
    assert np.array_equal(held.times, [0.1, 0.02])
    assert np.array_equal(state.v[held.nodes], START.v[held.nodes])
    assert np.array_equal(state.v[CORNERS[[0, 2]]], launch.velocities[[0, 2]])
    others = np.setdiff1d(np.arange(NET.node_count), CORNERS)
    assert np.array_equal(state.v[others], START.v[others])
    assert np.array_equal(state.x, START.x)
    assert not launch.velocities.flags.writeable


def test_shots_of_several_ejections_add_up():
    both = [Ejection("corners", 2.0, 0.0), Ejection("corners", 1.0, 90.0)]
    state, launch = fired(NET, START, both)
    alone = [launch_of(NET, START, one).velocities - START.v[CORNERS] for one in both]
    assert launch.velocities == pytest.approx(START.v[CORNERS] + alone[0] + alone[1], abs=ROUND_OFF)
    assert np.array_equal(state.v[CORNERS], launch.velocities)
    with pytest.raises(InputError, match=r"node 0 is released at 0.5 s, but at 0 s by an ejection before"):
        fired(NET, START, [both[0], Ejection("corners", 1.0, 90.0, release_times=[0.5, 0, 0, 0])])
    state, launch = fired(NET, START, [])
    assert len(launch.nodes) == len(Launch.none().nodes) == 0
    assert np.array_equal(state.v, START.v)


def test_corners_of_a_folded_net_fly_where_they_stand_in_the_open_net():
    """An odd number of folds brings all corners to one side of the pack."""
    net, start = accordion(CableNet.square(side=4.0, cells=8), Canister(depth=0.3, side=3.0), folds=(3, 3))
    corners = net.nodes_of("corners")
    launch = launch_of(net, start, Ejection("corners", 2.0, 90.0, outward="net"))
    assert launch.velocities == pytest.approx(net.nodes[corners] / np.sqrt(2), abs=ROUND_OFF)
    seen = launch_of(net, start, Ejection("corners", 2.0, 90.0)).velocities
    assert np.abs(seen - launch.velocities).max() > 1.0


@pytest.mark.parametrize("velocity", [(0.0, 0.0, 0.0), (0.4, -0.2, 0.3)])
def test_centre_of_mass_of_a_free_net_moves_as_the_formula_says(velocity):
    """v_com = Σ m v cos θ / Σ m, against the momentum of the flight while the net opens and snaps."""
    net, start = scaled(CableNet.square(side=2.0, cells=4), (0.9, 0.9, 1.0), velocity=velocity)
    errors = default_rng(3).normal(size=(2, 4)) * [[0.1], [4.0]]
    one = Ejection("corners", 5.0, 50.0, speed_errors=errors[0], angle_errors_deg=errors[1])
    state, launch = fired(net, start, [one])
    system = System(net, CORD, masses={"corners": 0.3}, damping=Dashpot(viscosity_time=1e-5))
    v = velocity_after(system.mass, start, launch)
    m = system.mass[net.nodes_of("corners")]
    along = (m * (5.0 + errors[0]) * np.cos(np.deg2rad(50.0 + errors[1]))).sum() / system.mass.sum()
    assert v[2] == pytest.approx(along + velocity[2], abs=ROUND_OFF)
    times = np.linspace(0, 0.06, 4)  # the corners snap at 37 ms, (2 − 1.8)/√2 m at 3.8 m/s outward
    tensions = []
    for flown in integrate(system, state, times, options=SolverOptions(accuracy="fast")):
        moved = system.mass @ (flown.x - start.x) / system.mass.sum()
        assert moved == pytest.approx(v * flown.t, abs=1e-9)
        assert system.momentum(flown.v) == pytest.approx(system.mass.sum() * v, abs=1e-9)
        tensions.append(system.peak_tension(flown.x))
    assert max(tensions) > 1.0  # N: the formula outlives the snap
    held = fired(net, start, [Ejection("corners", 5.0, 50.0, release_times=[0, 0, 0, 1.0])])[1]
    plain = fired(net, start, [Ejection("corners", 5.0, 50.0)])[1]
    assert np.array_equal(velocity_after(system.mass, start, held), velocity_after(system.mass, start, plain))


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"axis": (0, 0, 0)}, "axis is [0.0, 0.0, 0.0]: give a direction"),
        ({"axis": (1, 1, 0)}, "stands on the axis and has no outward direction"),
        (
            {"speed_errors": [0.0, 0.0]},
            "speed_errors: 2 given for 4 bullets: give one number for each",
        ),
        ({"release_times": [0, 0, np.nan, 0]}, "release_times: nan given for bullet 3: give a finite number"),
        ({"release_times": [0, 0, -0.1, 0]}, "node 20 gets a release time of -0.1 s, before the begin"),
        ({"speed_errors": [0, -4.0, 0, 0]}, "node 4 gets a speed of -1 m/s, below zero: give smaller errors"),
        ({"group": "rim"}, "no node group 'rim'"),
        ({"group": "empty"}, "the group has no nodes: name another one"),
    ],
)
def test_what_cannot_be_shot_is_one_clear_line(keys, words):
    net = CableNet(NET.nodes, NET.cables, {**NET.node_groups, "empty": []})
    flat = scaled(net, (0.5, 0.5, 1.0))[1]
    if keys.get("axis") == (1, 1, 0):
        flat.x[CORNERS, 2] = 0.0
    with pytest.raises(InputError) as caught:
        launch_of(net, flat, Ejection(**{"group": "corners", "speed": 3.0, "half_angle_deg": 30.0, **keys}))
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_bullets_without_mass_are_refused():
    one = Ejection("corners", 3.0, 30.0)
    added = np.zeros(NET.node_count)
    with pytest.raises(
        InputError, match=r"'corners': its 4 nodes have no mass beside the cables.*\[\[masses\]\]"
    ):
        check_bullets(NET, one, added)
    added[CORNERS[:3]] = 0.5
    with pytest.raises(InputError, match=rf"node {CORNERS[3]} has no mass"):
        check_bullets(NET, one, added)
    added[CORNERS[3]] = 0.5
    check_bullets(NET, one, added)


@pytest.mark.parametrize("keys", [{"speed": -1.0}, {"time": np.inf}, {"seed": -1}, {"seed": 1.5}])
def test_spreads_that_are_none_are_refused(keys):
    with pytest.raises(InputError, match=f"spread: {next(iter(keys))} is .*: give a"):
        Spread(**keys)
