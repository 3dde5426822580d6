"""CVODE and SciPy in IDA's place: the same flight, frames, phases and balance."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import SOFT, line, random_velocities, reference_flight

from netdae.core.errors import InputError, RunError
from netdae.forces.loads import Gravity, NodalLoad
from netdae.model.motions import TableMotion
from netdae.model.restraints import Restraint
from netdae.model.signals import Pulse
from netdae.model.state import State
from netdae.solvers.flight import simulate
from netdae.solvers.options import METHODS, SolverOptions
from netdae.system.damping import Dashpot, NoDamping
from netdae.system.system import System

OTHERS = [method for method in METHODS if method not in ("ida", "explicit")]
TIGHT = {"rtol": 1e-8, "atol_position": 1e-10, "atol_velocity": 1e-8}


def loaded_string():
    net = line(3)
    motion = TableMotion([0.0, 0.02, 0.2], [[0, 0, 0], [0, 0, 0], [0, 0, 0.09]], interpolation="linear")
    loads = [Gravity([0, 0, -9.81]), NodalLoad("inner", Pulse([0.0, 0.05, 0.0], 0.013, 0.031))]
    damping = Dashpot(viscosity_time=1e-3)
    system = System(net, SOFT, damping=damping, loads=loads, restraints=[Restraint("first", "xyz", motion)])
    v = random_velocities(net, 3)
    v[0] = 0.0
    return system, State.at(net.nodes, v)


@pytest.mark.parametrize("method", OTHERS)
def test_flights_agree_with_ida(method):
    """With gravity, a pulse, and a driven node whose velocity jumps: four phases."""
    system, start = loaded_string()
    times = [0.0, 0.01, 0.025, 0.05]
    ida, other = (
        simulate(system, start, times, options=SolverOptions(method=name, **TIGHT))
        for name in ("ida", method)
    )
    assert other.statistics["starts"] == ida.statistics["starts"] == 4
    for one, two in zip(ida, other, strict=True):
        # tolerances of 1e-8, some of whose errors add up over a hundred steps
        np.testing.assert_allclose(two.x, one.x, rtol=0, atol=2e-6)
        np.testing.assert_allclose(two.v, one.v, rtol=0, atol=2e-4)
        np.testing.assert_allclose(
            two.balance.external_impulse, one.balance.external_impulse, rtol=0, atol=1e-5
        )
        assert two.balance.external_work == pytest.approx(one.balance.external_work, abs=1e-5)
    np.testing.assert_allclose(other[-1].v[0], [0, 0, 0.5], rtol=1e-12)


@pytest.mark.parametrize("method", OTHERS)
def test_frames_change_no_step(method):
    system, start = reference_flight(3)
    ends = [
        simulate(
            system, start, np.linspace(0, 0.4, count), options=SolverOptions(method=method, accuracy="fast")
        )
        for count in (2, 17)
    ]
    assert ends[0].statistics["steps"] == ends[1].statistics["steps"]
    np.testing.assert_array_equal(ends[0][-1].x, ends[1][-1].x)


@pytest.mark.parametrize("method", OTHERS)
def test_a_load_that_turns_nan_is_one_error(method, capfd):
    net = line(2)
    load = NodalLoad("last", lambda t: [0.0, 0.0, np.nan if t > 0.02 else 0.0])
    system = System(net, SOFT, damping=NoDamping(), loads=[load])
    with pytest.raises(RunError, match=r"failed at t = 0\.\d+ s"):
        simulate(system, State.at(net.nodes), [0.0, 0.1], options=SolverOptions(method=method))
    assert capfd.readouterr() == ("", "")


def test_options_that_a_method_does_not_have_are_refused():
    with pytest.raises(InputError, match="max_order says nothing to the method radau"):
        SolverOptions(method="radau", max_order=2)
