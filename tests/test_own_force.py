"""User-defined forces: balanced by all methods, compiled or written in Python, refused in one line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest

import netdae as nd
from netdae.forces.force import Account, Tangent

STIFFNESS = 20.0  # N/m


@dataclass(frozen=True, eq=False)
class Bungee:
    """Springs from nodes (m, 1) to the origin, without length at rest."""

    nodes: np.ndarray
    newton: str = "symmetric"
    jumps: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()
    external: bool = True

    def force(self, t: float, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        return -STIFFNESS * x

    def tangent(self, t: float, x: np.ndarray, v: np.ndarray) -> Tangent:
        K = np.tile(-STIFFNESS * np.eye(3)[None, None, :, None, :], (len(x), 1, 1, 1, 1))
        return Tangent.of_all(K, np.zeros_like(K))

    def account(self, t: float, x: np.ndarray, v: np.ndarray) -> Account:
        return Account(stored_energy=0.5 * STIFFNESS * float(np.vdot(x, x)))


class Flat(Bungee):
    def force(self, t: float, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.zeros((1, 3))


class Bare:
    nodes = np.array([[0]])


def system_with(force: object) -> tuple[nd.System, nd.State]:
    net = nd.CableNet.square(side=1.0, cells=2)
    cord = nd.Material(youngs_modulus=1e8, density=1000.0, diameter=1e-3)
    system = nd.System(
        net,
        cord,
        damping=nd.NoDamping(),
        masses={"all": 0.05},
        forces=[force],  # type: ignore[list-item]
    )
    net, start = nd.scaled(net, [0.8, 0.8, 1.0])
    return system, start


class Bungees(NamedTuple):
    """The same in compiled code."""

    stiffness: nd.Reals  # (m,), N/m


@nd.compiled
def _pull(p, e, s, x, v, f):  # type: ignore[no-untyped-def]
    for a in range(3):
        f.conservative[0, a] = -p.stiffness[e] * x[0, a]
    return True


@nd.compiled
def _slope(p, e, s, x, v, K, C):  # type: ignore[no-untyped-def]
    for a in range(3):
        K[0, a, 0, a] = -p.stiffness[e]
    return True


@nd.compiled
def _stored(p, e, x):  # type: ignore[no-untyped-def]
    return 0.5 * p.stiffness[e] * (x[0, 0] ** 2 + x[0, 1] ** 2 + x[0, 2] ** 2)


BUNGEE = nd.Law(Bungees, force=_pull, tangent=_slope, energy=_stored, nodes=1, external=True)
NODES = np.array([[0], [8]])
WRITTEN = {
    "in Python": lambda: Bungee(NODES),
    "compiled": lambda: nd.ElementForce(BUNGEE, NODES, Bungees(np.full(2, STIFFNESS))),
}


@pytest.mark.parametrize("written", WRITTEN)
@pytest.mark.parametrize("method", ["ida", "explicit", "rk45", "bdf", "cvode_bdf"])
def test_what_a_user_defined_force_stores_is_in_the_balance(method: str, written: str) -> None:
    """Of the flight, of the rows of metrics.csv, and of the summary."""
    system, start = system_with(WRITTEN[written]())
    options = nd.SolverOptions(method, accuracy="accurate")  # type: ignore[arg-type]
    metrics = nd.DeploymentMetrics()
    flight = nd.simulate(system, start, np.linspace(0.0, 0.3, 7), options=options, observers=[metrics])
    stored = [system.elastic_energy(state.x) for state in flight]
    total = [
        system.kinetic_energy(state.v)
        + energy
        + state.balance.dissipated_energy
        - state.balance.external_work
        for state, energy in zip(flight, stored, strict=True)
    ]
    assert max(stored) - min(stored) > 0.5 * max(stored)  # springs have given what they held
    # snaps of undamped cables cost the integrators up to 0.4 %; without the springs' energy it would be half of it
    np.testing.assert_allclose(total, total[0], atol=1e-2 * max(stored))
    assert abs(flight[-1].balance.external_work) < 1e-2 * max(stored)  # of a fixed anchor: none
    assert np.abs(metrics.table()["energy_residual"]).max() < 1e-2 * max(stored)
    assert abs(metrics.summary()["energy_residual_share"]) < 1e-2


@pytest.mark.parametrize("method", ["ida", "explicit"])
def test_a_force_of_another_shape_is_reported_in_one_line(method: str) -> None:
    system, start = system_with(Flat(np.array([[0], [8]])))
    options = nd.SolverOptions(method)  # type: ignore[arg-type]
    with pytest.raises(nd.RunError, match=r"Flat.force gave an array \(1, 3\), expected \(2, 1, 3\)"):
        nd.simulate(system, start, [0.0, 0.01], options=options)


def test_what_is_no_force_is_refused_by_what_it_lacks() -> None:
    with pytest.raises(
        nd.InputError, match="Bare is no force: it lacks newton, jumps, kinks, external, force"
    ):
        system_with(Bare())


def test_trial_steps_that_are_much_too_long_are_shortened() -> None:
    net = nd.CableNet.square(side=4.0, cells=6)
    cord = nd.Material(youngs_modulus=1e9, density=1140.0, diameter=1e-3)
    system = nd.System(net, cord, damping=nd.Dashpot(viscosity_time=1e-7), masses={"corners": 0.3})
    net, start = nd.scaled(net, [0.4, 0.4, 1.0])
    start = nd.ejected(net, start, "corners", speed=3.0, half_angle_deg=45.0)
    flight = nd.simulate(system, start, [0.0, 0.5], options=nd.SolverOptions("dop853"))
    assert np.isfinite(flight[-1].x).all()
