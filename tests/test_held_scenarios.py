"""The shipped scenarios of a net that is held, and of one that is towed: at their ends they are as statics report."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np

import netdae as nd
from netdae.core.arrays import FloatArray
from netdae.model.state import State
from netdae.solvers.statics import equilibrium
from netdae.system.system import System

SCRIPTS = Path(__file__).resolve().parent.parent / "scripts"


@functools.cache
def flown(name: str) -> tuple[System, list[State]]:
    """The scenario as it ships: its system, and the States of its frames."""
    simulation = nd.read_scenario(SCRIPTS / f"{name}.toml").build()
    return simulation.system, list(simulation.integrate())


def pull_of(system: System, state: State) -> FloatArray:
    """Force of all restraints on the net, (3,), N."""
    return system.reactions(state.t, state.x, state.v, state.a).sum(axis=0)


def test_the_hanging_net_comes_to_rest_where_statics_find_it() -> None:
    system, states = flown("hanging_net")
    last = states[-1]
    at_rest = equilibrium(system, last)
    assert not at_rest.mechanisms  # every cord is taut
    # alpha = 3/s leaves exp(-1.5 * 6) = 0.01 % of a swing of 0.1 m; measured: 1e-7 m
    np.testing.assert_allclose(last.x, at_rest.x, rtol=0, atol=2e-4)
    np.testing.assert_allclose(last.v, 0.0, atol=5e-4)
    # it sags as the picture shows: by more than half of the way between two corners, 1.6 m
    assert np.ptp(last.x[:, 2]) > 0.8


def test_the_corners_of_the_hanging_net_carry_its_weight() -> None:
    system, states = flown("hanging_net")
    weight = 9.81 * system.mass.sum()
    # what is left of the swing accelerates it by 1e-3 m/s² at most
    np.testing.assert_allclose(pull_of(system, states[-1]), [0.0, 0.0, weight], rtol=0, atol=1e-4 * weight)


def test_the_towed_net_follows_at_the_speed_of_its_corners() -> None:
    _, states = flown("towed_net")
    last = states[-1]
    assert last.t == 3.0
    # single knots still swing from the push; measured: 0.08 m/s
    np.testing.assert_allclose(last.v - [0.0, 0.0, 5.0], 0.0, atol=0.2)


def test_the_towed_net_is_pulled_with_the_drag_of_its_cords() -> None:
    """½ ρ C_n d Σ l |v_n| v_n with C_n = 1.1, across each cord as it lies; friction along them adds some percent."""
    system, states = flown("towed_net")
    last = states[-1]
    first, second = system.net.cables.T
    along = last.x[second] - last.x[first]
    length = np.linalg.norm(along, axis=1)
    along /= length[:, None]
    v = (last.v[first] + last.v[second]) / 2
    across = v - np.einsum("mi,mi->m", v, along)[:, None] * along
    drag = 0.5 * 1.2 * 1.1 * 1e-3 * (length * np.linalg.norm(across, axis=1)) @ across
    pull = pull_of(system, last)
    assert 1.0 < pull[2] / drag[2] < 1.05  # measured: 1.025
    # in the last half second, when nothing pushes, it stays; measured: 0.2 % of 1.34 N
    late = [pull_of(system, state)[2] for state in states if state.t >= 2.5]
    np.testing.assert_allclose(late, pull[2], rtol=0.02)
