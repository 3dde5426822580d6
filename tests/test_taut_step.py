"""The explicit step moves only what a force may act on, and the flight is the same as if it moved everything.

A solver all of whose nodes are always active moves them in each step: it is what the others are compared with.
"""

from __future__ import annotations

import numpy as np
import pytest
from conftest import CORD
from test_explicit_chunks import solver_at

from netdae.forces.air import AirDrag
from netdae.forces.loads import Gravity, NodalLoad
from netdae.forces.orbit import Orbit
from netdae.forces.spring import Spring
from netdae.initial.scaled import ejected, scaled
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.signals import Table
from netdae.model.state import State
from netdae.solvers.explicit import kernel
from netdae.system.damping import Dashpot, NoDamping, Rayleigh
from netdae.system.system import System

CELLS = 11  # 144 knots, in five blocks
PUSH = Table([0.0, 1e-3, 1.0], [[0, 0, 0], [0, 0, 40.0], [0, 0, 40.0]])


def shot(**more):
    """A folded net shot by its corners; the first cables go taut after 0.1 s."""
    net, start = scaled(CableNet.square(side=5.0, cells=CELLS), (0.4, 0.4, 1.0))
    one = CableNet(net.nodes, net.cables, {**net.node_groups, "one": [70]}, rest_length=net.rest_length)
    start = ejected(one, start, "corners", speed=2.5, half_angle_deg=45.0)
    settings = {"masses": {"corners": 0.5}, "damping": Dashpot(viscosity_time=1e-5), **more}
    noise = 1e-10 * np.random.default_rng(0).standard_normal(start.x.shape)
    return System(one, CORD, **settings), State.at(start.x + noise, start.v)


def struck():
    """A slack net at rest, one knot of which leaves at 60 m/s and draws its neighbours taut one after another."""
    system, start = shot()
    v = np.zeros_like(start.v)
    v[70] = [0.0, 40.0, 45.0]
    return system, State.at(start.x, v)


CASES = {
    "shot": shot,
    "undamped": lambda: shot(damping=NoDamping()),
    "gravity": lambda: shot(loads=[Gravity([1.0, 0.0, -9.81])]),
    "orbit": lambda: shot(loads=[Orbit(0.01)]),
    "air": lambda: shot(loads=[AirDrag(density=1.2)]),
    "pushed": lambda: shot(loads=[NodalLoad("one", PUSH)]),
    "sprung": lambda: shot(loads=[Spring("one", stiffness=50.0)]),
    "held": lambda: shot(restraints=[Restraint("one", "xz")], loads=[Gravity([0.0, 0.0, -9.81])]),
    "struck": struck,
}


def both(monkeypatch, system, start):
    """A solver, and one that moves every node in each step."""
    quiet = solver_at(system, start, accuracy="standard")
    with monkeypatch.context() as patch:
        patch.setattr(kernel, "_nodes_of", lambda forces, entries, count: np.ones(count, dtype=np.bool_))
        return quiet, solver_at(system, start, accuracy="standard")


def active_share(solver):
    room = solver._kernel._room.values
    spans = range(room.counts[0])
    return sum(room.end[r] - room.begin[r] for r in spans) / len(room.moves)


@pytest.mark.parametrize("case", CASES)
def test_the_flight_is_that_in_which_every_node_is_moved(case, monkeypatch):
    system, start = CASES[case]()
    quiet, whole = both(monkeypatch, system, start)
    peak, t, least = 0.0, 0.0, 1.0
    while t < (0.3 if case != "struck" else 0.02):
        chunk, steps = quiet.step(100.0), whole.step(100.0)
        t = chunk[-1].t
        np.testing.assert_array_equal(chunk[-1].y, steps[-1].y)
        np.testing.assert_array_equal(chunk[-1].yp, steps[-1].yp)
        for part in ("dissipated_energy", "external_work", "external_impulse", "external_angular_impulse"):
            one, other = (sum(getattr(step.share, part) for step in each) for each in (chunk, steps))
            # sums of the same numbers in another order, of up to 10 J, N s and N m s
            np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-12)
        assert chunk[-1].share.peak_tension == steps[-1].share.peak_tension
        peak = max(peak, chunk[-1].share.peak_tension)
        least = min(least, active_share(quiet))
        assert active_share(whole) == 1.0
    assert peak > 1.0  # N: cables have snapped taut
    assert least <= 0.6  # part of the net drifts


def test_a_net_without_slack_moves_whole():
    net = CableNet.square(side=5.0, cells=CELLS)
    system = System(net, CORD, damping=Dashpot(viscosity_time=1e-5), masses={"all": 0.01})
    solver = solver_at(system, State.at(net.nodes * 1.0005))
    solver.step(100.0)
    assert active_share(solver) == 1.0


def test_rayleigh_damping_moves_all_nodes():
    system, start = shot(damping=Rayleigh(beta=1e-4))
    solver = solver_at(system, start)
    solver.step(100.0)
    assert active_share(solver) == 1.0


def test_a_look_is_made_early_where_a_knot_is_faster_than_the_look_foresaw(monkeypatch):
    """A knot of a resting net is pushed by 4e5 m/s²; within sixteen steps it leaves its margin many times over."""
    system, start = shot(loads=[NodalLoad("one", [0.0, 0.0, 400.0])])
    quiet, whole = both(monkeypatch, system, State.at(start.x, 1e-3 * start.v))
    for _ in range(2):
        chunk, steps = quiet.step(100.0), whole.step(100.0)
        np.testing.assert_array_equal(chunk[-1].y, steps[-1].y)
    assert np.count_nonzero(system.strain(chunk[-1].y[0]) > 0) > 0
