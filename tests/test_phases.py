"""Where a flight is cut, and that breaks but round-off apart cut it once."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import SOFT, line

from netdae.core.errors import InputError
from netdae.forces.loads import NodalLoad
from netdae.model.motions import TableMotion
from netdae.model.phases import Piece, pieces_of
from netdae.model.restraints import Restraint
from netdae.model.signals import Pulse
from netdae.model.state import State
from netdae.solvers.flight import simulate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import NoDamping
from netdae.system.system import System

ULP = np.spacing(1.0)
METHODS = [SolverOptions(accuracy="accurate"), SolverOptions(method="explicit", accuracy="accurate")]


def test_pieces_lie_between_the_breaks():
    assert pieces_of(0.0, 1.0, []) == [Piece(0.0, 1.0, 0.0, 1.0)]
    assert pieces_of(0.0, 1.0, [0.5, 2.0, -1.0, 0.25, 0.5]) == [
        Piece(0.0, 0.25, 0.0, 0.25),
        Piece(0.25, 0.5, 0.25, 0.5),
        Piece(0.5, 1.0, 0.5, 1.0),
    ]


def test_breaks_that_are_round_off_apart_are_one():
    first, last = 0.3, 0.1 + 0.2
    assert first != last
    assert pieces_of(0.0, 1.0, [last, first]) == [Piece(0.0, first, 0.0, first), Piece(first, 1.0, last, 1.0)]
    assert pieces_of(0.0, 1.0, [ULP, 1.0 - ULP]) == [Piece(0.0, 1.0, ULP, 1.0 - ULP)]


@pytest.mark.parametrize("options", METHODS, ids=lambda o: o.method)
def test_loads_that_follow_each_other_by_round_off_give_their_momentum(options):
    loads = [
        NodalLoad("last", Pulse([1.0, 0.0, 0.0], 0.1, 0.3)),
        NodalLoad("last", Pulse([0.0, 2.0, 0.0], 0.1 + 0.2, 0.4)),
    ]
    assert 0.3 != 0.1 + 0.2
    system = System(line(4), SOFT, damping=NoDamping(), loads=loads)
    flight = simulate(system, State.at(system.net.nodes), [0.0, 0.5], options=options)
    # the impulse is a sum of constant forces over steps: exact to round-off
    np.testing.assert_allclose(system.momentum(flight[-1].v), [0.2, 0.2, 0.0], rtol=0, atol=1e-12)
    assert flight.statistics["starts"] == 4


def test_a_flight_of_nothing_but_round_off_is_refused():
    system = System(line(2), SOFT, damping=NoDamping())
    with pytest.raises(InputError, match="do not rise"):
        simulate(system, State.at(system.net.nodes, t=1.0), [1.0, 1.0 + 2 * ULP])


@pytest.mark.parametrize("options", METHODS, ids=lambda o: o.method)
def test_books_hold_where_the_acceleration_of_a_driven_node_jumps(options):
    """u̇ = v t/T, then v, then back to rest: ü is a step at each row of a table with velocities."""
    v, T = 0.6, 0.1
    motion = TableMotion(
        [0.0, T, 2 * T, 3 * T],
        [[0, 0, 0], [v * T / 2, 0, 0], [1.5 * v * T, 0, 0], [2 * v * T, 0, 0]],
        velocities=[[0, 0, 0], [v, 0, 0], [v, 0, 0], [0, 0, 0]],
    )
    net = line(1)
    system = System(
        net, SOFT, damping=NoDamping(), masses={"last": 0.2}, restraints=[Restraint("last", "xyz", motion)]
    )
    loose = net.nodes * [[0.5], [0.5]]  # the cable stays slack until 0.5 m: the driven mass is alone
    flight = simulate(system, State.at(loose), [0.0, T / 2, T, 1.5 * T, 2 * T, 3 * T], options=options)
    m = system.mass[1]
    for frame in flight:
        speed = frame.v[1, 0]
        # ü is constant between rows, so Simpson's rule is exact; the trapezoidal rule of the explicit method too
        np.testing.assert_allclose(frame.balance.external_impulse, [m * speed, 0, 0], rtol=0, atol=1e-9)
        # inside a step of the explicit method the balance is linear: h² (m ü²)/8 = 2e-6 J for h = 1.5 ms
        assert frame.balance.external_work == pytest.approx(m * speed**2 / 2, abs=3e-6)
    assert flight[2].v[1, 0] == pytest.approx(v, rel=1e-12)
    assert flight.statistics["starts"] == 1
