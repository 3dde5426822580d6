"""The compiled driver of IDA against the one from Python, against IDA's own polynomial, and where it gives way."""

import gc
import logging
import re
from pathlib import Path

import numpy as np
import pytest
from conftest import SOFT, line, random_net, random_velocities, reference_flight

from netdae.core.errors import RunError
from netdae.forces.force import Account, LinkedTangent
from netdae.forces.loads import Gravity, NodalLoad
from netdae.model.material import Material
from netdae.model.motions import Steady
from netdae.model.restraints import Restraint
from netdae.model.signals import Pulse, Table
from netdae.model.state import State
from netdae.solvers import driver as integration
from netdae.solvers.driver import integrate
from netdae.solvers.flight import simulate
from netdae.solvers.ida import memory as ida_memory
from netdae.solvers.ida import native as native_ida
from netdae.solvers.ida import sundials
from netdae.solvers.ida import trial as ida_trial
from netdae.solvers.ida.native import NativeIda, ida_stepper
from netdae.solvers.ida.polish import Polish
from netdae.solvers.ida.stepper import IdaSolver
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping, Rayleigh
from netdae.system.system import System

TOE = Material(youngs_modulus=1e7, density=1000.0, diameter=2e-3, toe_strain=0.02)
SPRING = Material(youngs_modulus=1e7, density=1000.0, diameter=2e-3, law="engineering", toe_strain=0.01)
SLOPE = Table([0.0, 0.013, 0.04, 1.0], [[0, 0, 0], [0, 3, 0], [1, 0, 0], [1, 0, 2]])
DAMPINGS = {
    "none": NoDamping(),
    "dashpot": Dashpot(viscosity_time=1e-4),
    "rayleigh": Rayleigh(alpha=2.0, beta=1e-3),
}
GROUND = Gravity([0.0, 0.0, -9.81])
TOW = Restraint("one", axes="xz", motion=Steady((0.5, 0.0, -0.3)))
KNOWN = {
    "sharp": (SOFT, "none", [], []),
    "toe": (TOE, "dashpot", [], []),
    "engineering": (SPRING, "dashpot", [GROUND], [Restraint("few")]),
    "guided": (SOFT, "dashpot", [GROUND], [Restraint("few", axes="xz")]),
    "rayleigh": (SOFT, "rayleigh", [GROUND], [Restraint("few", axes="yz")]),
    "pulse": (SOFT, "dashpot", [NodalLoad("few", Pulse([9.0, 0.0, 0.0], 0.011, 0.023))], []),
    "table": (SOFT, "rayleigh", [NodalLoad("few", SLOPE), GROUND], []),
    "towed": (TOE, "rayleigh", [NodalLoad("few", SLOPE)], [TOW, Restraint("few")]),
}
TIGHT = SolverOptions(rtol=1e-10, atol_position=1e-11, atol_velocity=1e-9)


def made(name):
    """A random net with half of its cables taut, and its start."""
    cord, damping, loads, restraints = KNOWN[name]
    net = random_net(3)
    system = System(
        net, cord, damping=DAMPINGS[damping], masses={"few": 0.2}, loads=loads, restraints=restraints
    )
    v = random_velocities(net)
    for restraint in restraints:
        nodes, axes = restraint.nodes_of(net), restraint.axis_indices
        v[np.ix_(nodes, axes)] = restraint.motion.at(0.0)[1][axes]
    return system, State.at(net.nodes, v)


def driven_by(monkeypatch, driver):
    where = {
        "compiled": ("netdae.solvers.ida.native", "ida_stepper"),
        "python": ("netdae.solvers.ida.stepper", "IdaSolver"),
    }
    monkeypatch.setitem(integration._STEPPERS, "ida", where[driver])


@pytest.fixture
def compiled(monkeypatch):
    driven_by(monkeypatch, "compiled")


def stepper_of(system, start, options=None):
    return ida_stepper(system, system.drive_from(start.x), options or SolverOptions())


def entered(system, start, options=None):
    """The compiled driver at its start."""
    solver = stepper_of(system, start, options)
    assert isinstance(solver, NativeIda)
    a = system.acceleration(0.0, start.x, start.v)
    solver.enter(system, 0.0, np.stack((start.x, start.v)), np.stack((start.v, a)))
    return solver


@pytest.mark.parametrize("name", KNOWN)
def test_it_flies_as_the_driver_from_python(name, monkeypatch):
    """At tight tolerance and before chaos: the global error of both is up to a thousand times 1e-11 m."""
    system, start = made(name)
    flights = []
    for driver in ("compiled", "python"):
        driven_by(monkeypatch, driver)
        flights.append(simulate(system, start, np.linspace(0.0, 0.05, 6), options=TIGHT))
    for one, other in zip(*flights, strict=True):
        np.testing.assert_allclose(one.x, other.x, rtol=0, atol=1e-7)
        np.testing.assert_allclose(one.v, other.v, rtol=0, atol=1e-5)
        for field in ("dissipated_energy", "external_work", "external_impulse", "external_angular_impulse"):
            of_one, of_other = (np.array(getattr(state.balance, field)) for state in (one, other))
            # sums over steps that differ: the driver from Python starts anew after its first steps
            np.testing.assert_allclose(of_one, of_other, rtol=0, atol=3e-6, err_msg=field)
    # both report the largest tension at their internal steps, which are not the same
    peaks = [flight.peak_tension.max() for flight in flights]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-3)


@pytest.mark.parametrize("name", KNOWN)
def test_with_ida_s_own_settings_it_makes_the_same_steps(name, monkeypatch, without_rules_for_taut_cables):
    monkeypatch.setattr(ida_memory, "KEPT_STEPS", (1.0, 2.0))
    monkeypatch.setattr(ida_memory, "KEPT_CJ", 0.25)
    monkeypatch.setattr(ida_memory, "KEPT_CJ_WHOLE", 0.25)
    monkeypatch.setattr(ida_memory, "NEWTON_TOLERANCE", 0.33)
    system, start = made(name)
    counts, last = [], []
    for driver in ("compiled", "python"):
        driven_by(monkeypatch, driver)
        flight = simulate(system, start, [0.0, 0.02])
        counts.append({key: flight.statistics[key] for key in ("steps", "residuals", "setups", "solves")})
        last.append(flight[-1].x)
    assert counts[0] == counts[1]
    assert counts[0]["steps"] > 15
    np.testing.assert_allclose(*last, rtol=0, atol=1e-9)  # of round-off that snaps have amplified


@pytest.mark.parametrize("name", KNOWN)
def test_its_books_are_those_of_the_ledger(name, monkeypatch, compiled):
    """Frames and steps with the shares that it reports, and without, so that the running balance integrates itself."""
    system, start = made(name)
    times = np.linspace(0.0, 0.05, 40)
    monkeypatch.setattr(native_ida, "CHUNK", 1)
    flights = [simulate(system, start, times)]
    step, output = NativeIda.step, NativeIda.output
    monkeypatch.setattr(NativeIda, "step", lambda self, t: [s._replace(share=None) for s in step(self, t)])
    monkeypatch.setattr(NativeIda, "output", lambda self, t: output(self, t)._replace(share=None))
    flights.append(simulate(system, start, times))
    for one, other in zip(*flights, strict=True):
        np.testing.assert_array_equal(one.x, other.x)
        # the same sums in another order
        assert one.balance.dissipated_energy == pytest.approx(
            other.balance.dissipated_energy, rel=1e-10, abs=1e-12
        )
        assert one.balance.external_work == pytest.approx(other.balance.external_work, rel=1e-10, abs=1e-12)
        for field in ("external_impulse", "external_angular_impulse"):
            np.testing.assert_allclose(
                getattr(one.balance, field),
                getattr(other.balance, field),
                rtol=1e-10,
                atol=1e-12,
                err_msg=field,
            )
        assert one.balance.peak_tension == pytest.approx(other.balance.peak_tension, rel=1e-12)


@pytest.mark.parametrize("name", ["towed", "pulse"])
def test_chunks_change_nothing(name, monkeypatch, compiled):
    system, start = made(name)
    times = np.linspace(0.0, 0.05, 12)
    flights = []
    for chunk in (1, 3, 64):
        monkeypatch.setattr(native_ida, "CHUNK", chunk)
        flights.append(simulate(system, start, times))
    for flight in flights[1:]:
        assert flight.statistics["steps"] == flights[0].statistics["steps"]
        np.testing.assert_array_equal(flight.positions, flights[0].positions)
        np.testing.assert_array_equal(flight.accelerations, flights[0].accelerations)
        # sums over a chunk, then over chunks
        np.testing.assert_allclose(flight.dissipated_energy, flights[0].dissipated_energy, rtol=1e-12)
        np.testing.assert_allclose(flight.external_work, flights[0].external_work, rtol=1e-10, atol=1e-13)
        assert flight.peak_tension.max() == flights[0].peak_tension.max()


def test_a_flight_is_repeated_bit_for_bit(compiled):
    system, start = reference_flight(6)
    one, other = (simulate(system, start, [0.0, 0.5]) for _ in range(2))
    np.testing.assert_array_equal(one.positions, other.positions)
    np.testing.assert_array_equal(one.dissipated_energy, other.dissipated_energy)


def test_every_step_is_reported_where_it_is_asked_for():
    system, start = reference_flight(4)
    solver = entered(system, start)
    solver.every_step = True
    for k in range(30):
        assert len(solver.step(0.5)) == 1
        assert solver.counts["steps"] == k + 1


def test_max_step_bounds_the_steps():
    system, start = reference_flight(4)
    solver = entered(system, start, SolverOptions(max_step=1e-4))
    solver.step(0.02)
    assert np.diff(solver._record.chunk.times[: solver._row + 1]).max() <= 1e-4 * (1 + 1e-12)
    assert solver._row > 8


def test_a_chunk_ends_in_time_and_tells_the_largest_tension():
    """The first step of a chunk may be longer than its span; those around a new largest tension are told too."""
    system, start = reference_flight(6)
    reported = []
    for chunk in (1, 64):
        solver = entered(system, start)
        solver.every_step = chunk == 1
        t, seen = 0.0, []
        while t < 0.9:
            before, steps = t, solver.step(0.9)
            assert len(steps) <= 4
            t = steps[-1].t
            if chunk > 1 and t - before > native_ida.SPAN:
                inner = solver._record.chunk.times[: solver._row + 1]
                assert inner[-2] - inner[0] < native_ida.SPAN
            seen += [(step.t, system.peak_tension(step.y[0])) for step in steps]
        reported.append((len(seen), max(seen, key=lambda row: row[1])))
    assert reported[0][1] == reported[1][1]
    assert reported[1][0] < 0.3 * reported[0][0]


@pytest.mark.parametrize("accuracy", ["fast", "standard", "accurate"])
def test_states_between_steps_are_those_of_ida_s_own_polynomial(accuracy, monkeypatch):
    """Both interpolate what is right to the tolerance; the norm is IDA's, and they differ by a part of it.

    Without the balance in which `ida.polish` puts them: tests/test_taut_undamped.py has its tensions.
    """
    monkeypatch.setattr(Polish, "between", lambda self, part, step, h: step)
    system, start = reference_flight(6)
    options = SolverOptions(accuracy=accuracy)
    rtol, atol_position, atol_velocity = options.tolerances
    solver = entered(system, start, options)
    solver.every_step = True
    t, differences = 0.0, []
    y = np.empty((2, *start.x.shape))
    atol = np.array([atol_position, atol_velocity])[:, None, None]
    while t < 0.45:
        (step,) = solver.step(0.45)
        for share in (0.25, 0.5, 0.75):
            at = t + share * (step.t - t)
            solver._memory.polynomial(at, y.reshape(-1))
            inner = solver.output(at)
            d = 1e-3 * (step.t - t)
            rate = (solver.output(at + d).y[1] - solver.output(at - d).y[1]) / (2 * d)
            # of a cubic, of round-off, and of d² of its third derivative
            np.testing.assert_allclose(inner.yp[1], rate, rtol=1e-4, atol=1e-4 * np.abs(rate).max() + 1e-6)
            differences.append(np.sqrt(np.mean(((inner.y - y) / (rtol * np.abs(y) + atol)) ** 2)))
        t = step.t
    # at fast some steps find free waves, whose velocities are tested without what is stiff in them
    assert np.quantile(differences, 0.99) < (1.5 if accuracy == "fast" else 0.3)
    assert np.median(differences) < 0.1


class Odd:
    """A force with links that no compiled code knows."""

    nodes, links = np.array([[1, 2, 3]]), np.array([[1, 2], [2, 3]])
    newton, jumps, kinks, external = "links", (), (), True
    force = tangent = account = None


def test_a_force_with_links_of_one_s_own_is_left_to_python():
    system = System(line(4), SOFT, damping=NoDamping(), forces=[Odd()])
    assert isinstance(stepper_of(system, State.at(system.net.nodes)), IdaSolver)


class Idle:
    """A force with links, written in Python, that does nothing."""

    nodes, links = np.array([[1, 2, 3]]), np.array([[1, 2], [2, 3]])
    newton, jumps, kinks, external = "links", (), (), False

    def force(self, t, x, v):
        return np.zeros_like(x)

    def newton_part(self, t, x, v):
        blocks, dyads = np.zeros((0, 2, 3, 2, 3)), np.zeros((0, 3, 3))
        return LinkedTangent(blocks, blocks, dyads, dyads, dyads)

    def tangent(self, t, x, v):
        return self.newton_part(t, x, v).whole(self.nodes, self.links)

    def account(self, t, x, v):
        return Account()


def test_a_force_with_links_in_python_is_flown_by_the_python_driver_which_is_noted(monkeypatch, compiled):
    net = line(4)
    start = State.at(net.nodes, random_velocities(net))
    flights = []
    for forces in ([], [Idle()]):
        run = integrate(System(net, SOFT, damping=DAMPINGS["dashpot"], forces=forces), start, [0.0, 0.02])
        *_, last = run
        flights.append((run, last))
    (without, there), (run, here) = flights
    assert (without.statistics["driver"], without.notes) == ("compiled", ())
    assert run.statistics["driver"] == "python"
    assert run.statistics["steps"] > 10
    (note,) = run.notes
    assert note == (
        "IDA was driven from Python, which takes 3 to 17 times as long: "
        "Idle has links and is written in Python: write it as a Law"
    )
    driven_by(monkeypatch, "python")  # without the force, which is nothing
    *_, there = integrate(System(net, SOFT, damping=DAMPINGS["dashpot"]), start, [0.0, 0.02])
    np.testing.assert_allclose(here.x, there.x, rtol=0, atol=1e-12)
    np.testing.assert_allclose(here.v, there.v, rtol=0, atol=1e-10)


@pytest.mark.parametrize("driver", [NativeIda, IdaSolver])
def test_both_drivers_find_the_flight_of_the_trial(driver):
    assert ida_trial.difference(driver) <= ida_trial.AGREES


class Shifted(NativeIda):
    """It reports velocities that are wrong by a little."""

    wrong = 2 * ida_trial.AGREES

    def step(self, stop):
        return [step._replace(y=step.y + np.array([[[0.0]], [[self.wrong]]])) for step in super().step(stop)]


class NoNumbers(Shifted):
    wrong = np.nan


class Heavy(NativeIda):
    """What its kernels work on is not the system."""

    def __init__(self, *flight):
        super().__init__(*flight)
        self._record._net.values.mass[:] *= 1.001


class Singular(NativeIda):
    """Its setups of Newton's matrix fail: nothing moves the nodes but their cable."""

    def __init__(self, *flight):
        super().__init__(*flight)
        self._record._net.values.mass[:] = 0.0


@pytest.fixture
def trial_note(monkeypatch, tmp_path):
    """The trial's note, which is not there yet, as if the library had not been tried."""
    note = tmp_path / "notes" / "ida-agrees"
    monkeypatch.setattr(ida_trial, "_note", lambda: note)
    native_ida._check_library.cache_clear()
    yield note
    native_ida._check_library.cache_clear()


BROKEN = [(Shifted, r"2\.?\d*e-06"), (NoNumbers, "nan"), (Heavy, r"9.6\de-05"), (Singular, "inf")]


@pytest.mark.parametrize(("driver", "found"), BROKEN)
def test_a_driver_that_goes_astray_is_not_trusted(driver, found, trial_note):
    words = rf"^IDA differs from SciPy by {found} on two nodes, more than 1e-06$"
    for _ in range(2):  # nothing is noted
        with pytest.raises(sundials.Unavailable, match=words):
            ida_trial.check_agreement(driver)
        assert not trial_note.exists()


@pytest.mark.parametrize("driver", [driver for driver, _ in BROKEN])
def test_with_a_driver_that_goes_astray_flights_are_left_to_python(driver, trial_note, monkeypatch, caplog):
    monkeypatch.setattr(native_ida, "NativeIda", driver)
    system, start = reference_flight(2)
    with caplog.at_level(logging.INFO):
        solver = stepper_of(system, start)
    assert isinstance(solver, IdaSolver)
    assert re.search(r"3 to 17 times as long: IDA differs from SciPy by \S+ on two nodes", solver.note)
    assert solver.note in caplog.text


def test_a_driver_that_agrees_is_tried_once(trial_note):
    def never(*flight):
        raise AssertionError

    ida_trial.check_agreement(NativeIda)
    assert trial_note.exists()
    ida_trial.check_agreement(never)


def test_true_products_are_left_to_python():
    system, start = reference_flight(2)
    assert isinstance(stepper_of(system, start, SolverOptions(products="true")), IdaSolver)
    assert isinstance(stepper_of(system, start), NativeIda)


def odd_slots(address, index=0):
    return 0


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("VERSION", 8, r"version 7, expected 8"),
        ("_SIGNATURES", {**sundials._SIGNATURES, "IDAFly": (None, ())}, "SUNDIALS has no IDAFly"),
        ("word", odd_slots, "not where it was expected"),
        ("importlib", None, None),
    ],
)
def test_another_library_than_expected_is_left_to_python(name, value, words, monkeypatch, caplog):
    if words is None:
        monkeypatch.setattr(sundials.importlib.util, "find_spec", lambda package: None)
        words = "is not there"
    else:
        monkeypatch.setattr(sundials, name, value)
    sundials.sundials.cache_clear()
    system, start = reference_flight(2)
    with caplog.at_level(logging.INFO):
        assert isinstance(stepper_of(system, start), IdaSolver)
    assert re.search(f"IDA was driven from Python, which takes 3 to 17 times as long: .*{words}", caplog.text)
    sundials.sundials.cache_clear()


def test_a_residual_that_is_not_finite_is_one_error_with_node_and_time(capfd):
    system, start = made("pulse")
    solver = entered(system, start)
    solver.step(0.005)
    (row,) = (k for k, force in enumerate(system.forces) if getattr(force, "signal", None) is not None)
    solver._record.table.rows.start[row, 1] = np.nan  # of the pulse on nodes 1, 4 and 7
    words = r"at t = 0\.00\d+ s the residual of the velocity of node 1 along y is not finite"
    with pytest.raises(RunError, match=words):
        solver.step(0.01)
    assert capfd.readouterr() == ("", "")


def test_a_matrix_that_leads_astray_is_counted_and_ends_in_words(capfd):
    system, start = reference_flight(4, damping=Rayleigh(beta=1e-4))
    solver = entered(system, start)
    flown = solver.step(1.0)
    members = solver._record._ldl.values.order
    members[:] = np.roll(members, 1)
    with pytest.raises(
        RunError,
        match=r"t = \S+ s: Newton's iteration failed again .* worst is the \w+ of node \d+ along .*cables",
    ):
        flown.extend(step for _ in range(3) for step in solver.step(1.0))  # it may do in a first step
    assert solver.counts["newton_failures"] > 5
    assert flown[-1].t == solver._t  # the steps before the failure were reported
    assert capfd.readouterr() == ("", "")


def test_a_net_that_nothing_holds_is_reported():
    """A knot without mass in a flat net, whose Rayleigh damping holds it in the plane only."""
    system, start = reference_flight(2, damping=Rayleigh(beta=1e-4))
    solver = entered(system, start)
    solver._record._net.values.mass[4] = 0.0
    with pytest.raises(RunError, match=r"t = 0 s: the Newton matrix is singular at node 4"):
        solver.step(1.0)


def test_two_hundred_flights_leave_no_memory_behind(compiled):
    """One of 11 × 11 knots has a megabyte of its own."""
    if not Path("/proc/self/statm").exists():
        pytest.skip("the size of the process is not reported here")
    system, start = reference_flight(10)

    def size():
        gc.collect()
        return int(Path("/proc/self/statm").read_text().split()[1]) * 4096

    def files():
        return len(list(Path("/proc/self/fd").iterdir()))

    def fly(count):
        for _ in range(count):
            run = integrate(system, start, [0.0, 1e-4, 1.0])
            next(run), next(run)

    fly(20)
    before, opened = size(), files()
    fly(200)
    assert size() - before < 30e6
    assert files() == opened


def test_all_that_it_has_of_sundials_is_given_back(monkeypatch):
    called = []
    call = sundials.Sundials.call
    monkeypatch.setattr(
        sundials.Sundials,
        "call",
        lambda self, name, *given: (called.append(name), call(self, name, *given))[1],
    )
    system, start = reference_flight(2)
    solver = entered(system, start)
    solver.step(0.1)
    del solver
    for make, free in (
        ("SUNContext_Create", "SUNContext_Free"),
        ("N_VMake_Serial", "N_VDestroy"),
        ("SUNDenseMatrix", "SUNMatDestroy"),
        ("SUNLinSolNewEmpty", "SUNLinSolFreeEmpty"),
        ("SUNNonlinSolNewEmpty", "SUNNonlinSolFreeEmpty"),
        ("IDACreate", "IDAFree"),
    ):
        assert called.count(make) == called.count(free) > 0


def test_a_restraint_that_begins_later_has_a_driver_of_its_own_and_the_counts_go_on(compiled):
    late = Restraint("one", motion=Steady((0.1, 0.0, 0.0), since=0.05), begin=0.05)
    net = random_net(0)
    system = System(net, SOFT, damping=DAMPINGS["dashpot"], restraints=[late])
    run = integrate(system, State.at(net.nodes), [0.0, 0.04, 0.1])
    drivers, steps = [], []
    for _ in run:
        drivers.append(run._solver)
        steps.append(run.statistics["steps"])
    assert drivers[0] is drivers[1] is not drivers[2]
    assert {each.driver for each in drivers} == {"compiled"}
    assert 0 == steps[0] < steps[1] < steps[2]
