"""Winches and drawcords on nets: what they add, how they close, what they cost in energy and accuracy."""

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import CORD
from flights import energy_of
from numpy.random import default_rng

from netdae.core.errors import InputError
from netdae.forces.brake import END_STOP
from netdae.forces.drawcord import DRAWCORD
from netdae.forces.loads import NodalLoad
from netdae.forces.rings import Rings
from netdae.model.material import Material
from netdae.model.mouth import mouth_of, vector_area
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.closing import (
    Drawcord,
    Haul,
    Winch,
    accuracy_reported,
    closing_tolerances,
    sharp_enough,
    tightened,
)
from netdae.system.closing_assembly import with_closings
from netdae.system.damping import Dashpot, NoDamping, Rayleigh
from netdae.system.system import System

LINE = Material(youngs_modulus=1e11, linear_density=1e-9, area=1e-6)
"""EA 100 kN, massless."""

TIGHT = SolverOptions(rtol=1e-7, atol_position=1e-9, atol_velocity=1e-7)

HAUL = Haul(speed=1.0, force=20.0, final_length=1.0)


def net_of(cells=4, side=2.0):
    return CableNet.square(side=side, cells=cells)


def at_rest(net, t=0.0):
    return State.at(net.nodes, np.zeros_like(net.nodes), t=t)


def system_of(closed, *, net=CORD, masses=None, damping=None, restraints=(), **more):
    return System(
        closed.net,
        {"all": net, **closed.materials},
        damping=damping or Dashpot(viscosity_time=1e-4),
        masses=masses or {},
        restraints=[*restraints, *closed.restraints],
        reels=closed.reels,
        forces=closed.forces,
        **more,
    )


# What is added to the net


def test_a_drawcord_runs_round_the_mouth_in_its_order():
    net = net_of()
    closed = with_closings(net, at_rest(net), [Drawcord(LINE, HAUL, group="border")])
    loop = mouth_of(net, "border")
    new = closed.net.cables[closed.net.cables_of("closing")]
    np.testing.assert_array_equal(new, np.stack((loop, np.roll(loop, -1)), axis=1))
    np.testing.assert_array_equal(closed.net.cables[: net.cable_count], net.cables)
    np.testing.assert_array_equal(closed.net.cables_of("closing_1"), closed.net.cables_of("closing"))
    assert closed.net.nodes_of("drums").tolist() == [net.node_count]
    assert closed.materials == {"closing_1": LINE}
    # as long as its way in x̄: 16 pieces of 0.5 m, each η²/2h longer by the size of the rings
    assert closed.net.rest_length[closed.net.cables_of("closing")].sum() == pytest.approx(
        16 * np.hypot(0.5, 1e-3)
    )
    system = system_of(closed)
    cord = next(force for force in system.forces if force.law is DRAWCORD)
    assert cord.parameters.segments == len(loop)  # as many as rings: closed
    np.testing.assert_array_equal(cord.nodes[0], [*loop, net.node_count])
    np.testing.assert_array_equal(mouth_of(closed.net, "border"), loop)
    stop = next(force for force in system.forces if force.law is END_STOP)
    np.testing.assert_allclose(stop.parameters.stiffness, 1e5 / 1.0)  # of what is left of the cord
    np.testing.assert_allclose(stop.parameters.place, 16 * np.hypot(0.5, 1e-3) - 1.0)
    assert system.spatial_mass[-1] == 0.0
    assert system.mass[-1] == pytest.approx(20.0 * 0.01)  # what 20 N bring to 1 m/s in 10 ms


def test_rings_of_a_group_are_ordered_along_the_loop_that_passes_them():
    net = net_of()
    cord = Drawcord(LINE, HAUL, group="corners", loop="border", length=9.0)
    closed = with_closings(net, at_rest(net), [cord])
    new = closed.net.cables_of("closing")
    loop = mouth_of(net, "border")
    corners = loop[np.isin(loop, net.nodes_of("corners"))]
    np.testing.assert_array_equal(closed.net.cables[new, 0], corners)
    np.testing.assert_allclose(closed.net.rest_length[new], 9.0 / 4, rtol=1e-12)


def test_a_list_of_rings_keeps_its_order_and_may_be_open():
    net = net_of()
    closed = with_closings(net, at_rest(net), [Drawcord(LINE, HAUL, nodes=(3, 1, 7, 20), closed=False)])
    np.testing.assert_array_equal(
        closed.net.cables[closed.net.cables_of("closing")], [[3, 1], [1, 7], [7, 20]]
    )


def test_winches_join_two_groups_by_pairs_with_a_drum_each():
    net = net_of()
    net = CableNet(net.nodes, net.cables, {**net.node_groups, "left": [0, 1, 2], "right": [22, 23, 24]})
    closed = with_closings(
        net,
        at_rest(net),
        [Winch("left", "right", LINE, HAUL)],
    )
    np.testing.assert_array_equal(closed.net.cables[-3:], [[0, 22], [1, 23], [2, 24]])
    assert len(closed.reels) == 3
    assert closed.net.nodes_of("drums").tolist() == [25, 26, 27]
    assert len(closed.start.x) == 28
    assert not closed.restraints  # they begin at once


def test_no_closing_leaves_the_net_as_it_is():
    net = net_of()
    closed = with_closings(net, at_rest(net), [])
    assert closed.net is net
    assert (closed.reels, closed.restraints, closed.forces, closed.materials) == ((), (), (), {})


# How it closes


def pair_net():
    nodes = np.array([[0.0, 0, 0], [3.0, 0, 0], [0, 1.0, 0], [3.0, 1.0, 0]])
    groups = {"a": [0], "b": [1], "ends": [0, 1], "rest": [2, 3]}
    return CableNet(nodes, [[2, 3]], groups)


def pair(haul, *, v=None, **more):
    """Two free masses of 1 and 2 kg that a winch draws together."""
    net = pair_net()
    closed = with_closings(net, at_rest(net), [Winch("a", "b", LINE, haul)])
    masses = {"a": 1.0, "b": 2.0, "rest": 1.0}
    return closed, system_of(closed, masses=masses, damping=Dashpot(viscosity_time=1e-3), **more)


def test_a_motor_at_its_full_force_draws_two_masses_together_as_one_degree_of_freedom():
    """Far below its speed the pull is constant, F γ(10) of the width of a tenth: (J + m₁m₂/(m₁ + m₂)) s̈ = F γ."""
    haul = Haul(speed=1e4, force=3.0, final_length=0.5, drum_inertia=0.5)
    closed, system = pair(haul)
    flight = simulate(system, closed.start, [0.0, 0.3, 0.6], options=TIGHT)
    pull = 3.0 * 10 / math.sqrt(101)
    a = pull / (0.5 + 2 / 3)
    for frame in (flight[1], flight[2]):
        # the cable stretches by 2e-5 m, with a transient of ms
        assert frame.x[4, 0] == pytest.approx(0.5 * a * frame.t**2, rel=1e-3)
        assert frame.v[0, 0] == pytest.approx(2 / 3 * a * frame.t, rel=1e-3)
        assert frame.balance.external_work == pytest.approx(pull * frame.x[4, 0], rel=1e-3)
        assert energy_of(system, frame) == pytest.approx(0.0, abs=1e-5)
    assert np.abs(system.momentum(flight[2].v)).max() < 1e-13


def test_a_winch_waits_keeps_its_speed_and_stops_at_its_final_length():
    haul = Haul(speed=0.5, force=50.0, final_length=2.0, begin=0.5, drum_inertia=0.1)
    closed, system = pair(haul)
    flight = simulate(system, closed.start, np.linspace(0, 4, 17), options=TIGHT)
    drum = np.array([[frame.x[4, 0], frame.v[4, 0]] for frame in flight])
    before, during = flight.times <= 0.5, (flight.times > 0.8) & (flight.times < 2.4)
    assert not drum[before].any()
    # the masses, once they move, pull no more: the drum runs at the speed, and cord slack by rebound does not matter
    np.testing.assert_allclose(drum[during, 1], 0.5, rtol=1e-3)
    np.testing.assert_allclose(np.diff(drum[during, 0]), 0.5 * 0.25, rtol=1e-3)
    # the stop is as stiff as the 2 m of cable that are left, 50 kN/m: the motor's 50 N press it by 1 mm, and it stays
    np.testing.assert_allclose(drum[-4:, 0], 1.0 + 50.0 / (1e5 / 2), atol=1e-5)
    assert np.abs(drum[-4:, 1]).max() < 1e-6
    assert energy_of(system, flight[-1]) == pytest.approx(0.0, abs=1e-4)
    assert flight[-1].balance.external_work > 0.05


@pytest.mark.parametrize("left", [0.6, 4.0])
def test_a_drum_that_lands_under_its_motor_goes_as_far_beyond_the_stop_as_its_docstring_says(left):
    """δ(t) of `reels.forces_of` with k of what is left, under a steady pull F γ(10), on a cable that hangs slack."""
    F, J, way, k = 30.0, 0.5, 2.0, 1e5 / left
    haul = Haul(speed=1e4, force=F, final_length=left, drum_inertia=J)
    net = pair_net()
    near = State.at(0.01 * net.nodes, np.zeros_like(net.nodes))  # the winch's ends: it is longer at any time
    closed = with_closings(net, near, [Winch("a", "b", LINE, haul, length=way + left)])
    system = system_of(closed, masses={"ends": 1.0, "rest": 1.0})
    pull = F * 10 / math.sqrt(101)
    theta, speed = math.sqrt(J / k), math.sqrt(2 * pull * way / J)
    lands = speed / (pull / J)
    u = np.array([0.5, 1.0, 1.5])  # at u = 2 it leaves the stop
    flight = simulate(system, closed.start, [0.0, *(lands + u * theta)], options=TIGHT)
    beyond = pull / k * (1 - (1 + u) * np.exp(-u)) + speed * theta * u * np.exp(-u)
    # rtol of 1e-7 on 2 m and the motor's force, which falls by 1e-5 of itself up to that speed
    np.testing.assert_allclose(flight.positions[1:, 4, 0] - way, beyond, rtol=2e-3)
    assert beyond.max() < pull / k + speed * theta / math.e < 0.05 * left


def test_a_load_over_the_motors_force_stalls_it_and_the_pawl_holds_but_for_its_creep():
    """F (γ(v/v₀) + P(u)) = R with R = 2F: the drum creeps back at u v₁ from P = 2 − 10/√101."""
    haul = Haul(speed=1.0, force=10.0, final_length=0.5)
    closed, system = pair(
        haul,
        restraints=[Restraint("a")],
        loads=[NodalLoad("b", [20.0, 0.0, 0.0])],
    )
    flight = simulate(system, closed.start, [0.0, 1.0, 2.0], options=TIGHT)
    P = 2 - 10 / math.sqrt(101)
    u = 0.5 * (P + math.sqrt(P * P + 4 * P))
    # after a millisecond of transients; the strain of 2e-4 lets cord out of the drum a little longer
    assert flight[2].v[4, 0] == pytest.approx(-0.01 * u, rel=2e-3)
    assert flight[2].balance.dissipated_energy > flight[1].balance.dissipated_energy


def test_a_drum_is_locked_by_hold():
    haul = Haul(speed=0.5, force=50.0, final_length=1.0, hold=1.0, drum_inertia=0.1)
    closed, system = pair(haul)
    flight = simulate(system, closed.start, [0.0, 1.0, 2.0], options=TIGHT)
    assert flight[2].x[4, 0] == flight[1].x[4, 0]
    assert flight[1].x[4, 0] == pytest.approx(0.5, rel=0.02)
    assert energy_of(system, flight[2]) == pytest.approx(0.0, abs=1e-4)


def closing_net(cells, rings, *, friction=0.0, speed=2.0, final=2.0):
    """A 5 m net, 3 % slack, a little bowed and at rest, with a cord through `rings` knots of its border; the loop, too.

    Where it lies as in x̄, every cable is at the kink between slack and taut, and each step meets it.
    """
    net = net_of(cells, 5.0)
    loop = mouth_of(net, "border")
    x = net.nodes * [0.97, 0.97, 1.0] + 1e-10 * default_rng(0).standard_normal(net.nodes.shape)
    x[:, 2] += 1e-3 * (x[:, 0] ** 2 + x[:, 1] ** 2)
    cord = Drawcord(
        CORD,
        Haul(speed=speed, force=50.0, final_length=final),
        nodes=tuple(loop[:: len(loop) // rings].tolist()),
        rings=Rings(friction=friction, fastened=False),
    )
    closed = with_closings(net, State.at(x, np.zeros_like(x)), [cord])
    system = system_of(closed, masses={"corners": 0.5}, damping=Dashpot(viscosity_time=1e-5))
    return loop, closed, system


def options_for(speed, **changes):
    rtol, position, velocity = closing_tolerances(speed)
    return SolverOptions(rtol=rtol, atol_position=position, atol_velocity=velocity, **changes)


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_a_drawcord_closes_the_mouth_keeps_momentum_and_balances_its_work(friction):
    loop, closed, system = closing_net(4, 16, friction=friction, speed=4.0, final=8.0)
    flight = simulate(system, closed.start, np.linspace(0, 3.5, 8), options=options_for(4.0))
    area = [vector_area(frame.x[loop]) for frame in flight]
    border = [np.linalg.norm(np.diff(frame.x[[*loop, loop[0]]], axis=0), axis=1).sum() for frame in flight]
    assert area[0] == pytest.approx(25.0 * 0.97**2, rel=1e-3)
    assert (np.diff(area[:6]) < 0).all()
    assert area[-1] < 2.0  # the corners, with what they have gained, draw 8 m of cord into a thin loop
    # the rings are all knots of the border: it is as long as the cord, but for the stop's way at the motor's force
    assert border[-1] < 8.05
    work = flight[-1].balance.external_work
    assert work > 2.0  # it brings the corners to 1 m/s and more
    for frame in flight:
        assert np.abs(system.momentum(frame.v)).max() < 1e-12
        # the integrator's own dissipation at these tolerances, 1 to 3 %
        assert energy_of(system, frame) == pytest.approx(energy_of(system, flight[0]), abs=0.05 * work)


def test_the_area_of_the_mouth_converges_with_the_tolerance_to_one_value():
    areas = []
    for factor in (1000.0, 1.0, 0.1):
        loop, closed, system = closing_net(5, 20, speed=4.0)
        rtol, position, velocity = closing_tolerances(4.0)
        options = SolverOptions(
            rtol=rtol * min(factor, 1.0), atol_position=position * factor, atol_velocity=velocity * factor
        )
        last = simulate(system, closed.start, [0.0, 1.5], options=options)[-1]
        areas.append(vector_area(last.x[loop]))
    coarse, ours, fine = areas
    assert ours == pytest.approx(fine, rel=0.005)  # 11.93 and 11.92 m²
    assert coarse > 1.1 * fine  # 13.6 m²: silently wrong


@pytest.mark.parametrize("rings", [8, 40, 80])
def test_eight_to_eighty_rings_draw_a_net_of_21_by_21_knots(rings):
    loop, closed, system = closing_net(20, rings, speed=4.0)
    flight = simulate(system, closed.start, [0.0, 0.3], options=options_for(4.0))
    assert vector_area(flight[1].x[loop]) < vector_area(flight[0].x[loop])
    # round-off of 441 knots
    assert np.abs(system.momentum(flight[1].v)).max() < 1e-12


def script(*arguments):
    file = Path(__file__).resolve().parent.parent / "scripts" / "closing_convergence.py"
    return subprocess.run(
        [sys.executable, str(file), *arguments], capture_output=True, text=True, check=False
    )


def test_the_script_that_closes_nets_finds_one_value_on_a_small_one():
    done = script("--quick")
    assert done.returncode == 0, done.stdout + done.stderr
    _, _, *rows, verdict = done.stdout.splitlines()
    assert [row.split()[:2] for row in rows] == [["20", "1"], ["20", "0.1"]]
    assert "come to one value" in verdict


def test_the_script_tells_a_cord_through_too_few_or_too_many_rings():
    for rings in ("2", "41"):
        done = script("--knots", "11", "--rings", rings)
        assert done.returncode == 2
        assert f"a cord through {rings} rings: the border has 40 knots" in done.stderr


# How sharply


def test_tolerances_follow_the_slowest_closing():
    assert closing_tolerances(1.0) == pytest.approx((1e-5, 1e-7, 1e-5), rel=1e-12)
    assert closing_tolerances(0.1) == pytest.approx((1e-5, 1e-8, 1e-6), rel=1e-12)
    slow = Drawcord(LINE, Haul(speed=0.1, force=1.0, final_length=1.0), group="border")
    quick = Winch("a", "b", LINE, HAUL)
    assert tightened(SolverOptions().tolerances, [quick, slow]) == pytest.approx((1e-5, 1e-8, 1e-6))
    assert tightened((1e-6, 1e-9, 1e-9), [quick]) == (1e-6, 1e-9, 1e-9)
    assert tightened((1e-3, 1e-4, 1e-2), []) == (1e-3, 1e-4, 1e-2)


def test_the_accuracy_of_a_closing_is_reported():
    quick = Winch("a", "b", LINE, HAUL)
    assert accuracy_reported((1e-4, 1e-5, 3e-4), []) is None
    assert accuracy_reported((1e-5, 1e-7, 1e-5), [quick]) == (
        "closing at 1 m/s is flown with rtol 1e-05, atol_position 1e-07 m, atol_velocity 1e-05 m/s, as it needs"
    )
    assert sharp_enough((1e-5, 1e-7, 1e-5), [quick])
    assert not sharp_enough((1e-4, 1e-7, 1e-5), [quick])
    reported = accuracy_reported((1e-3, 1e-4, 1e-2), [quick])
    assert reported.startswith("closing at 1 m/s is flown with rtol 0.001,")
    assert "but it needs rtol 1e-05, atol_position 1e-07 m, atol_velocity 1e-05 m/s" in reported


# What is reported


def reported(*closings, net=None, t=0.0):
    net = net or net_of()
    with pytest.raises(InputError) as error:
        with_closings(net, at_rest(net, t), closings)
    return str(error.value)


def test_what_cannot_be_strung_is_reported():
    net = net_of()
    assert "runs through 1 node" in reported(Drawcord(LINE, HAUL, nodes=(3,)))
    assert "runs through 0 nodes: give" in reported(Drawcord(LINE, HAUL, nodes=()))
    assert "runs through 1 node of 'centre'" in reported(Drawcord(LINE, HAUL, group="centre"))
    assert "node 99, but the net has 25 nodes" in reported(Drawcord(LINE, HAUL, nodes=(3, 99, 4)))
    assert "through node 3 twice" in reported(Drawcord(LINE, HAUL, nodes=(3, 4, 3)))
    assert "a closed cord runs through 2 nodes" in reported(Drawcord(LINE, HAUL, nodes=(3, 4)))
    assert "no node group 'rim'" in reported(Drawcord(LINE, HAUL, group="rim"))
    assert "node 12 of 'two' is not on the loop 'border'" in reported(
        Drawcord(LINE, HAUL, group="two", loop="border"),
        net=CableNet(net.nodes, net.cables, {**net.node_groups, "two": [0, 12]}),
    )
    assert "'corners' has 4 nodes and 'centre' has 1" in reported(Winch("corners", "centre", LINE, HAUL))
    assert "node 12 of 'centre' is its own partner" in reported(Winch("centre", "centre", LINE, HAUL))


def test_a_pair_that_is_joined_twice_is_reported_and_a_node_with_two_partners_is_not():
    assert "nodes 4 and 0 are joined twice" in reported(Winch((0, 4), (4, 0), LINE, HAUL))
    net = net_of()
    with_closings(net, at_rest(net), [Winch((0, 0), (4, 20), LINE, HAUL)])


def test_a_cord_that_pulls_at_the_start_with_more_than_its_motor_is_reported():
    net = net_of()
    # 8 m round: EA ½ ((8/7)² − 1) 8/7 of 100 kN
    assert (
        "is 7 m long, but its way at the start is 8.00002 m, on which it pulls with 1.75e+04 N"
        in reported(Drawcord(LINE, HAUL, group="border", length=7.0))
    )
    assert "from node 0 to 4 is 1.9 m long, but its way at the start is 2 m" in reported(
        Winch((0,), (4,), LINE, HAUL, length=1.9)
    )
    # stretched by 1e-4 it pulls with 10 N of the motor's 20 N
    with_closings(net, at_rest(net), [Winch((0,), (4,), LINE, HAUL, length=2 / 1.0001)])


def test_lengths_and_times_that_do_not_go_together_are_reported():
    long = Haul(speed=1.0, force=1.0, final_length=9.0)
    short = Haul(speed=1.0, force=1.0, final_length=0.05)
    assert "final_length is 9 m, but the cord is 8" in reported(Drawcord(LINE, long, group="border"))
    assert "under 1% of the cord's 8" in reported(Drawcord(LINE, short, group="border"))
    rings = Rings(size=0.1)
    assert "16 rings of 0.1 m side by side take 1.6 m" in reported(
        Drawcord(LINE, HAUL, group="border", rings=rings)
    )
    early = Haul(speed=1.0, force=1.0, final_length=1.0, begin=-1.0)
    assert "begin is -1 s, before the start of the flight at 0 s" in reported(
        Drawcord(LINE, early, group="border")
    )
    begun = Haul(speed=1.0, force=1.0, final_length=1.0, begin=1.0)
    assert "begin is 1 s, before the start of the flight at 2 s" in reported(
        Drawcord(LINE, begun, group="border"), t=2.0
    )
    net = net_of()
    taken = CableNet(net.nodes, net.cables, {**net.node_groups, "drums": [1]})
    assert "a node group 'drums' already" in reported(Drawcord(LINE, HAUL, group="border"), net=taken)


@pytest.mark.parametrize("name", ["speed", "force", "final_length", "drum_inertia"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.inf])
def test_numbers_out_of_range_are_reported(name, value):
    values = {"speed": 1.0, "force": 1.0, "final_length": 1.0, name: value}
    with pytest.raises(InputError, match=f"closing: {name} is {value:g}"):
        Haul(**values)


def test_contradictions_are_reported():
    with pytest.raises(InputError, match="begins at 2 s and is held from 1 s on"):
        Haul(speed=1.0, force=1.0, final_length=1.0, begin=2.0, hold=1.0)
    with pytest.raises(InputError, match="just one of a group and a list"):
        Drawcord(LINE, HAUL)
    with pytest.raises(InputError, match="just one of a group and a list"):
        Drawcord(LINE, HAUL, group="border", nodes=(1, 2, 3))
    with pytest.raises(InputError, match="length is 0 m"):
        Winch("a", "b", LINE, HAUL, length=0.0)
    with pytest.raises(InputError, match="speed is 0 m/s"):
        closing_tolerances(0.0)


def test_rayleigh_damping_that_would_hold_a_cord_is_refused():
    net = net_of()
    closed = with_closings(net, at_rest(net), [Drawcord(LINE, HAUL, group="border")])
    with pytest.raises(InputError, match="beta holds a cord through rings"):
        system_of(closed, damping=Rayleigh(beta=1e-3))
    system_of(closed, damping=Rayleigh(alpha=1e-3))
    system_of(closed, damping=NoDamping())
