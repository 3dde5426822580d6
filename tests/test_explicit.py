"""The explicit method: what it converges to, when it is stable, and that it keeps what IDA keeps."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import SOFT, line, random_net, random_velocities, reference_flight
from scipy.linalg import eigh

from netdae.core.errors import InputError, RunError
from netdae.forces.loads import Gravity, NodalLoad
from netdae.model.material import Material
from netdae.model.motions import FunctionMotion, TableMotion
from netdae.model.restraints import Restraint
from netdae.model.signals import Pulse, Table
from netdae.model.state import State
from netdae.solvers.explicit import stepper as explicit
from netdae.solvers.explicit.stable_step import cheaper_method
from netdae.solvers.explicit.stepper import CHUNK, ExplicitSolver
from netdae.solvers.flight import simulate
from netdae.solvers.linalg.condensed import full_jacobian
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping, Rayleigh
from netdae.system.system import System

EXPLICIT = SolverOptions(method="explicit")
SHARP = SolverOptions(rtol=1e-10, atol_position=1e-12, atol_velocity=1e-10)


def swing(t0=0.0):
    w = 2 * np.pi * 3
    return FunctionMotion(
        lambda t: [0.05 * (1 - np.cos(w * (t - t0))), 0.0, 0.0],
        lambda t: [0.05 * w * np.sin(w * (t - t0)), 0.0, 0.0],
        lambda t: [0.05 * w**2 * np.cos(w * (t - t0)), 0.0, 0.0],
    )


TABLE = Table([0.0, 0.01, 0.02, 0.2], [[0, 0, 0], [0, 0.2, 0], [0.1, 0, 0.1], [0, 0, 0]])
CASES = {
    "undamped": {"damping": NoDamping()},
    "dashpot": {"damping": Dashpot(viscosity_time=1e-3)},
    "rayleigh": {"damping": Rayleigh(alpha=3.0, beta=1e-3)},
    "toe": {"damping": Dashpot(zeta=0.2), "toe": 0.05},
    "engineering": {"damping": Dashpot(viscosity_time=1e-3), "toe": 0.02, "law": "engineering"},
    "loads": {"damping": NoDamping(), "loads": [Gravity([0, 0, -9.81]), NodalLoad("few", TABLE)]},
    "driven": {"damping": Dashpot(viscosity_time=1e-3), "restraints": [Restraint("one", "xyz", swing())]},
    "half held": {"damping": Rayleigh(beta=1e-3), "restraints": [Restraint("few", "xz")]},
}


def built(*, damping, toe=0.0, law="st_venant_kirchhoff", loads=(), restraints=(), seed=1):
    net = random_net(seed)
    cord = Material(youngs_modulus=1e6, density=1000.0, diameter=2e-2, toe_strain=toe, law=law)
    system = System(net, cord, damping=damping, loads=loads, restraints=restraints)
    return system, State.at(net.nodes, random_velocities(net, seed) * ~system.restrained)


@pytest.mark.parametrize("case", CASES)
def test_flights_agree_with_ida_and_the_error_falls_with_the_step(case):
    system, start = built(**CASES[case])
    sharp = simulate(system, start, [0.0, 0.03], options=SHARP)[-1]
    h0 = SolverOptions(method="explicit").max_step or 1e-4
    errors = []
    for h in (h0 / 4, h0 / 8, h0 / 16):
        flown = simulate(system, start, [0.0, 0.03], options=SolverOptions(method="explicit", max_step=h))[-1]
        errors.append(float(np.abs(flown.x - sharp.x).max()))
    # IDA is sharp to some 1e-8; the error is of first order at least where dashpots and kinks act
    assert errors[-1] < 1e-3
    assert errors[2] < 0.75 * errors[0]


def test_an_undamped_taut_string_converges_with_the_square_of_the_step():
    """Always taut, so smooth: the order of the step is 2."""
    net = line(4)
    stretched = net.nodes * 1.05
    system = System(net, SOFT, damping=NoDamping(), restraints=[Restraint("first"), Restraint("last")])
    v = np.zeros((5, 3))
    v[1:4, 2] = [0.5, -0.3, 0.2]
    exact = SolverOptions("dop853", rtol=1e-11, atol_position=1e-13, atol_velocity=1e-11)
    sharp = simulate(system, State.at(stretched, v), [0.0, 0.02], options=exact)[-1]
    steps = [2e-5, 1e-5, 5e-6]
    errors = []
    for h in steps:
        options = SolverOptions(method="explicit", max_step=h)
        flown = simulate(system, State.at(stretched, v), [0.0, 0.02], options=options)[-1]
        errors.append(np.abs(flown.x - sharp.x).max())
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope == pytest.approx(2.0, abs=0.1)  # the next term of the error is of h⁴


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    "damping", [NoDamping(), Dashpot(viscosity_time=2e-4), Rayleigh(beta=5e-4, alpha=10.0)]
)
def test_the_step_is_below_the_true_limit_of_the_taut_net_and_not_far(seed, damping):
    """True limit: h² K + 2 h C ≤ 4 M as matrices, from dense eigenvalues with all cables taut; C of dashpots alone."""
    net = random_net(seed)
    taut = net.nodes * 1.9  # every cable is longer than at rest
    system = System(net, SOFT, damping=damping)
    assert (system.tension(taut) > 0).all()
    start = State.at(taut)
    solver = ExplicitSolver(
        system, system.drive_from(taut), SolverOptions(method="explicit", accuracy="fast")
    )
    solver.enter(system, 0.0, np.stack((start.x, start.v)), np.stack((start.v, start.a)))
    h = solver._stable / solver._share
    zero = np.zeros_like(taut)
    n, cj = taut.size, 1.0
    J = full_jacobian(system, 0.0, taut, zero, cj).toarray()  # its lower half is T, M + D for c_j = 1
    M = system.mass_matrix().toarray()
    K, C = J[n:, :n], J[n:, n:] - M - system.damping_matrix().toarray()
    largest = eigh(h**2 * K + 2 * h * C, M, eigvals_only=True)[-1]
    assert largest <= 4.0
    # the bound takes all cables of a node for parallel and at the limit of strain: rarely more than 6 times off
    assert largest > 4.0 / 6


def test_a_step_that_is_too_long_is_stopped_by_its_energy(monkeypatch):
    monkeypatch.setitem(explicit.FRACTIONS, "standard", 3.0)
    system, start = reference_flight(6)
    with pytest.raises(
        RunError, match=r"failed at t = 0\.\d+ s: its energy rose .* explicit step .* too long"
    ):
        simulate(system, start, [0.0, 1.0], options=EXPLICIT)


def test_flights_repeat_bit_for_bit_and_frames_change_nothing():
    system, start = reference_flight(6)
    few = simulate(system, start, [0.0, 0.5], options=EXPLICIT)
    many = simulate(system, start, np.linspace(0.0, 0.5, 40), options=EXPLICIT)
    assert few.statistics["steps"] == many.statistics["steps"]
    np.testing.assert_array_equal(few[-1].x, many[-1].x)
    np.testing.assert_array_equal(few[-1].v, many[-1].v)
    assert few[-1].balance.dissipated_energy == many[-1].balance.dissipated_energy
    assert few[-1].balance.peak_tension == max(frame.balance.peak_tension for frame in many)


def test_momentum_of_a_free_net_is_kept():
    system, start = reference_flight(8)
    flight = simulate(system, start, [0.0, 1.0], options=EXPLICIT)
    # round-off of some 30 000 steps at 1e-16 of 7 N s, adding up as their square root or less
    np.testing.assert_allclose(system.momentum(flight[-1].v), system.momentum(start.v), rtol=0, atol=1e-12)


def test_the_energy_residual_falls_with_the_step_and_is_small():
    system, start = reference_flight(8)
    shares = []
    for accuracy in ("fast", "standard", "accurate"):
        flight = simulate(
            system, start, [0.0, 1.0], options=SolverOptions(method="explicit", accuracy=accuracy)
        )
        first, last = (
            system.kinetic_energy(s.v) + system.elastic_energy(s.x) for s in (flight[0], flight[-1])
        )
        shares.append(abs(last + flight[-1].balance.dissipated_energy - first) / first)
    assert shares[0] > shares[1] > shares[2]
    # measured 0.9, 0.3 and 0.05 % on nets of 11 and 21 knots a side; the summary warns over 1 %
    assert shares[1] < 0.01
    assert shares[2] < 0.002


def test_undamped_energy_is_kept_over_many_periods():
    """The energy of a taut string does not drift."""
    net = line(3)
    x = net.nodes * 1.05
    x[1, 2] = 0.02
    system = System(net, SOFT, damping=NoDamping(), restraints=[Restraint("first"), Restraint("last")])
    flight = simulate(system, State.at(x), np.linspace(0.0, 2.0, 200), options=EXPLICIT)
    energy = np.array([system.kinetic_energy(s.v) + system.elastic_energy(s.x) for s in flight])
    swing = np.ptp(energy[:100]) / energy[0]
    assert abs(energy[100:].mean() / energy[:100].mean() - 1) < 0.1 * swing + 1e-12


def test_a_short_pulse_gives_its_exact_momentum():
    net = line(4)
    system = System(
        net, SOFT, damping=NoDamping(), loads=[NodalLoad("last", Pulse([3.0, 0.0, -2.0], 0.01, 0.0101))]
    )
    flight = simulate(system, State.at(net.nodes), [0.0, 0.007, 0.05], options=EXPLICIT)
    exact = 1e-4 * np.array([3.0, 0.0, -2.0])
    np.testing.assert_allclose(system.momentum(flight[-1].v), exact, rtol=1e-11, atol=1e-16)
    np.testing.assert_allclose(flight[-1].balance.external_impulse, exact, rtol=1e-11, atol=1e-16)


def test_driven_nodes_follow_exactly_and_their_work_and_impulse_are_booked():
    system, start = built(**CASES["driven"])
    flight = simulate(
        system, start, np.linspace(0, 0.2, 11), options=SolverOptions(method="explicit", accuracy="accurate")
    )
    motion = swing()
    for frame in flight:
        np.testing.assert_allclose(frame.x[0], start.x[0] + motion.at(frame.t)[0], rtol=0, atol=1e-12)
    change = system.momentum(flight[-1].v) - system.momentum(start.v)
    # the impulse is a sum of reactions by the trapezoidal rule, the momentum one of half kicks: O(h) apart at the ends
    np.testing.assert_allclose(
        flight[-1].balance.external_impulse, change, rtol=0, atol=2e-3 * np.abs(change).max()
    )
    first, last = (system.kinetic_energy(s.v) + system.elastic_energy(s.x) for s in (flight[0], flight[-1]))
    balance = flight[-1].balance
    assert last + balance.dissipated_energy - balance.external_work - first == pytest.approx(
        0.0, abs=5e-3 * first
    )


def test_a_jump_of_velocity_is_a_break_with_its_impulse():
    net = line(3)
    motion = TableMotion([0.0, 0.01, 1.0], [[0, 0, 0], [0, 0, 0], [0.99, 0, 0]], interpolation="linear")
    system = System(net, SOFT, damping=NoDamping(), restraints=[Restraint("last", "xyz", motion)])
    flight = simulate(system, State.at(net.nodes), [0.0, 0.02], options=EXPLICIT)
    assert flight.statistics["starts"] == 2
    np.testing.assert_allclose(flight[-1].v[-1], [1.0, 0.0, 0.0], rtol=1e-12, atol=0)


def test_watchers_see_the_step_of_the_largest_tension():
    system, start = reference_flight(6)
    seen = []

    class Watcher:
        def watch(self, state):
            seen.append(system.peak_tension(state.x))

        def __call__(self, state):
            pass

    flight = simulate(system, start, [0.0, 0.6], observers=[Watcher()], options=EXPLICIT)
    assert max(seen) == pytest.approx(flight.peak_tension.max(), rel=1e-12)
    assert len(seen) < 2 + 2 * flight.statistics["steps"] / CHUNK + 50


def test_a_toe_lengthens_the_step_while_tensions_are_low():
    net = line(4)
    soft = Material(youngs_modulus=1e7, density=1000.0, diameter=2e-3, toe_strain=0.2)
    system = System(net, soft, damping=NoDamping())
    v = np.zeros((5, 3))
    v[:, 0] = np.linspace(0.0, 8.0, 5)  # it is drawn out, and stiffens
    flight = simulate(system, State.at(net.nodes, v), [0.0, 0.1], options=EXPLICIT)
    assert flight.statistics["step_lengths"] > 1


def test_tolerances_and_unknown_methods_are_refused():
    with pytest.raises(InputError, match="rtol says nothing to the explicit method"):
        SolverOptions(method="explicit", rtol=1e-5)
    with pytest.raises(InputError, match="choose one of ida, explicit, cvode_bdf"):
        SolverOptions(method="euler")


@pytest.mark.parametrize(
    ("damping", "method"),
    [
        (NoDamping(), "explicit"),
        (Dashpot(viscosity_time=1e-5), "explicit"),
        (Dashpot(viscosity_time=3e-4), "explicit"),
        (Dashpot(viscosity_time=3e-3), "ida"),
        (Rayleigh(beta=1e-5), "explicit"),
        (Rayleigh(beta=1e-2), "explicit"),
    ],
)
def test_the_cheaper_method_is_ida_only_where_the_dashpot_is_strong(damping, method):
    """As measured on the reference flight of 21 × 21 knots, see `SHORTENED`; Rayleigh damping bounds no step."""
    system, _ = reference_flight(20, damping=damping)
    advice = cheaper_method(system)
    assert advice["method"] == method
    assert "shortens" in advice["reason"]


def test_books_of_frames_lie_between_those_of_the_steps_around_them():
    """Also in a chunk that is reported in two parts, up to its new largest tension and after it."""
    system, start = reference_flight(6)
    steps = []

    class Watcher:
        def watch(self, state):
            steps.append((state.t, state.balance.dissipated_energy))

        def __call__(self, state):
            pass

    times = np.linspace(0.0, 0.9, 1500)
    flight = simulate(system, start, times, observers=[Watcher()], options=EXPLICIT)
    t, lost = np.array(steps).T
    after = np.searchsorted(t, times).clip(1, len(t) - 1)
    low, high = np.minimum(lost[after - 1], lost[after]), np.maximum(lost[after - 1], lost[after])
    # the discrete work of a dashpot may swing within a step by h² of its power: a thousandth of all that is lost
    slack = 1e-3 * lost[-1]
    assert (flight.dissipated_energy >= low - slack).all()
    assert (flight.dissipated_energy <= high + slack).all()
