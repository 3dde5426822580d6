"""The compiled driver of IDA where Python is asked: forces written in Python, signals and motions that are no lines."""

import numpy as np
import pytest
from conftest import SOFT, random_net, random_velocities
from test_native_ida_reels import _rates, _residual, _setup, _solve, driven_by

from netdae.forces.air import AirDrag
from netdae.forces.force import Account, Tangent
from netdae.forces.loads import Gravity, NodalLoad
from netdae.forces.orbit import Orbit
from netdae.forces.solar import SolarPressure
from netdae.model.motions import FunctionMotion, TableMotion
from netdae.model.restraints import Restraint
from netdae.model.signals import Table
from netdae.model.state import State
from netdae.solvers.flight import simulate
from netdae.solvers.ida.kernel import RATES
from netdae.solvers.ida.native import NativeIda, ida_stepper
from netdae.solvers.linalg.condensed import CondensedSolver
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, Rayleigh
from netdae.system.system import System

TIGHT = SolverOptions(rtol=1e-10, atol_position=1e-11, atol_velocity=1e-9)
PAIRS = np.array([[2, 5], [9, 0], [11, 2]])
STIFF, VISCOUS = 400.0, 2.0


class Struts:
    """Springs with dampers that push too, from outside where reported, on pairs that no cable need join."""

    nodes, jumps, kinks = PAIRS, (), ()

    def __init__(self, newton="symmetric", *, external=False, bad=None):
        self.newton, self.external, self.bad = newton, external, bad or (lambda what, t: None)

    def force(self, t, x, v):
        self.bad("force", t)
        pull = STIFF * (x[:, 1] - x[:, 0]) + VISCOUS * (v[:, 1] - v[:, 0])
        return np.stack((pull, -0.5 * pull if self.external else -pull), axis=1)

    def tangent(self, t, x, v):
        self.bad("tangent", t)
        K = np.zeros((3, 2, 3, 2, 3))
        for a in range(3):
            K[:, 0, a, 1, a] = K[:, 1, a, 0, a] = 1.0
            K[:, 0, a, 0, a] = K[:, 1, a, 1, a] = -1.0
        if self.external:
            K[:, 1] *= 0.5
        return Tangent.of_all(STIFF * K, VISCOUS * K)

    def account(self, t, x, v):
        self.bad("account", t)
        d, w = x[:, 1] - x[:, 0], v[:, 1] - v[:, 0]
        power = VISCOUS * np.vdot(w, w)
        given = float(np.vdot(self.force(t, x, v), v)) if self.external else 0.0
        return Account(0.5 * STIFF * float(np.vdot(d, d)), 0.0 if self.external else float(power), given)


SWAY = Table([0.0, 0.5, 1.0], [[0, 0, 0], [0, 3, 0], [1, 0, 0]], interpolation="cubic")
SWING = FunctionMotion(
    lambda t: [0.01 * (1 - np.cos(50 * t)), 0.3 * t, 0.0],
    lambda t: [0.5 * np.sin(50 * t), 0.3, 0.0],
    lambda t: [25 * np.cos(50 * t), 0.0, 0.0],
)
CURVE = TableMotion([0.0, 0.02, 0.06, 1.0], [[0, 0, 0], [0.01, 0, 0], [0, 0.03, 0], [0, 0, 0.1]])
DASHPOT = Dashpot(viscosity_time=1e-4)
KNOWN = {
    "struts": {"forces": [Struts()], "loads": [Orbit(0.3)]},
    "outside": {"forces": [Struts(external=True)], "restraints": [Restraint("few", axes="xz")]},
    "explicit struts": {"forces": [Struts("nothing")], "damping": Rayleigh(alpha=2.0, beta=1e-3)},
    "whole": {"forces": [Struts(), Struts(external=True)], "damping": Rayleigh(alpha=2.0, beta=1e-3)},
    "functions": {"loads": [NodalLoad("few", lambda t: [9 * np.sin(70 * t), 0, t]), Gravity(SWAY)]},
    "wind": {"loads": [AirDrag(wind=SWAY), SolarPressure(sun=SWAY, pressure=3.0)]},
    "swing": {"restraints": [Restraint("few", motion=SWING)]},
    "curve": {
        "restraints": [Restraint("one", axes="xz", motion=CURVE), Restraint("few", axes="y", motion=SWING)]
    },
    "all": {
        "forces": [Struts(external=True)],
        "restraints": [Restraint("few", motion=SWING)],
        "loads": [Gravity(SWAY)],
    },
}


def made(name):
    net = random_net(3)
    more = {"damping": DASHPOT} | KNOWN[name]
    return System(net, SOFT, masses={"few": 0.2}, **more)


def start_of(system):
    v = random_velocities(system.net)
    for restraint in system.restraints:
        nodes, axes = restraint.nodes_of(system.net), restraint.axis_indices
        v[np.ix_(nodes, axes)] = restraint.motion.at(0.0)[1][axes]
    return State.at(system.net.nodes, v)


def compiled_of(system):
    solver = ida_stepper(system, system.drive_from(system.net.nodes), SolverOptions())
    assert isinstance(solver, NativeIda)
    solver._record.go_on(system.during(0.0, 1.0), 0.0)
    return solver


@pytest.mark.parametrize("name", KNOWN)
def test_residual_rates_and_matrix_are_those_of_the_forces(name):
    system, t, cj = made(name), 0.03, 200.0
    solver, drive = compiled_of(system), system.drive_from(system.net.nodes)
    address, ours = solver._record.address, CondensedSolver(system)
    rng, free = np.random.default_rng(4), ~system.restrained
    size, out = 6 * system.net.node_count, np.empty(RATES)
    x_d, v_d, a_d = drive.at(t)
    for _ in range(3):
        y = np.stack((system.net.nodes, np.zeros_like(system.net.nodes)))
        y += 0.1 * rng.standard_normal(y.shape)
        x, v = y
        yp, F = rng.standard_normal(y.shape), np.empty(y.shape)
        tension = _rates(address, t, y.ravel(), out)  # leaves restrained axes at t
        assert _residual(address, t, y.ravel(), yp.ravel(), F.ravel()) == -1
        f = system.force(t, x, v)
        np.testing.assert_allclose(F[0][free], (yp[0] - v)[free], rtol=1e-14)
        expected = system.mass[:, None] * yp[1] - f
        np.testing.assert_allclose(F[1][free], expected[free], rtol=1e-12, atol=1e-10)
        np.testing.assert_allclose(F[0][~free], (x - x_d)[~free], atol=1e-15)
        np.testing.assert_allclose(F[1][~free], (v - v_d)[~free], atol=1e-15)
        _, dissipated, external = system.account(t, x, v)
        reactions = system.reactions(t, x, v, a_d)
        wrench = system.external_wrench(t, x, v) + system.wrench(x, reactions)
        scale = np.abs(f).max()
        assert out[0] == pytest.approx(dissipated, rel=1e-12, abs=1e-12 * scale)
        assert out[1] == pytest.approx(external + np.vdot(reactions, v_d), rel=1e-12, abs=1e-12 * scale)
        np.testing.assert_allclose(out[2:].reshape(2, 3), wrench, rtol=1e-12, atol=1e-12 * scale)
        assert tension == pytest.approx(system.peak_tension(x), rel=1e-12)
        assert _setup(address, t, y.ravel(), cj) == -1
        ours.setup(system.during(0.0, 1.0), t, x, v, cj)
        r = rng.standard_normal(y.shape)
        r[:, ~free] = 0.0
        z, reported = np.empty(size), np.empty(y.shape)
        _solve(address, r.ravel(), cj, 1.2 * cj, z)
        ours.solve(r[0], r[1], 1.2 * cj, reported[0], reported[1])
        for part, whole in zip(z.reshape(y.shape), reported, strict=True):
            np.testing.assert_allclose(part, whole, rtol=1e-8, atol=1e-9 * np.abs(whole).max())


@pytest.mark.parametrize("name", KNOWN)
def test_it_flies_as_the_driver_from_python(name, monkeypatch):
    """At tight tolerance and before chaos: the global error of both is up to ten thousand times 1e-11 m."""
    system, flights = made(name), []
    for driver in ("compiled", "python"):
        driven_by(monkeypatch, driver)
        flights.append(simulate(system, start_of(system), np.linspace(0.0, 0.03, 4), options=TIGHT))
        assert flights[-1].statistics["driver"] == driver
    for one, other in zip(*flights, strict=True):
        np.testing.assert_allclose(one.x, other.x, rtol=0, atol=1e-7)
        np.testing.assert_allclose(one.v, other.v, rtol=0, atol=1e-5)
        for field in ("dissipated_energy", "external_work", "external_impulse", "external_angular_impulse"):
            of_one, of_other = (np.array(getattr(state.balance, field)) for state in (one, other))
            np.testing.assert_allclose(of_one, of_other, rtol=1e-5, atol=5e-6, err_msg=field)
    ours, theirs = (flight.statistics for flight in flights)
    # restrained axes and tangents are where they belong: without either there are twice as many and more
    assert ours["residuals"] / ours["steps"] < 1.3 * theirs["residuals"] / theirs["steps"]


@pytest.mark.parametrize("where", ["force", "tangent", "account"])
def test_what_a_force_raises_arrives_as_it_was_raised(where, monkeypatch):
    def bad(what, t):
        if what == where and t > 0.01:
            raise ZeroDivisionError(f"in {what}")

    driven_by(monkeypatch, "compiled")
    system = System(random_net(3), SOFT, damping=DASHPOT, masses={"few": 0.2}, forces=[Struts(bad=bad)])
    shown = []
    with pytest.raises(ZeroDivisionError, match=f"in {where}"):
        simulate(system, start_of(system), [0.0, 0.1], observers=[lambda state: shown.append(state.t)])
    assert shown
    assert max(shown) < 0.02


def test_what_a_motion_raises_arrives_as_it_was_raised(monkeypatch):
    def late(t):
        if t > 0.005:
            raise ArithmeticError("no further")
        return [0.0, 0.0, 0.0]

    driven_by(monkeypatch, "compiled")
    motion = FunctionMotion(late, lambda t: [0.0, 0.0, 0.0], lambda t: [0.0, 0.0, 0.0])
    system = System(
        random_net(3),
        SOFT,
        damping=DASHPOT,
        masses={"few": 0.2},
        restraints=[Restraint("one", motion=motion)],
    )
    monkeypatch.setattr("netdae.model.restraints.check_derivatives", lambda *reported: None)
    with pytest.raises(ArithmeticError, match="no further"):
        simulate(system, start_of(system), [0.0, 0.1])


def test_an_interrupt_ends_the_flight_at_once():
    def bad(what, t):
        if t > 0.003:
            raise KeyboardInterrupt

    system = System(random_net(3), SOFT, damping=DASHPOT, masses={"few": 0.2}, forces=[Struts(bad=bad)])
    solver, start = compiled_of(system), start_of(system)
    a = system.acceleration(0.0, start.x, start.v)
    solver.enter(system.during(0.0, 1.0), 0.0, np.stack((start.x, start.v)), np.stack((start.v, a)))
    with pytest.raises(KeyboardInterrupt):
        list(iter(lambda: solver.step(1.0), []))
