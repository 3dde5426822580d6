"""Reels flown by the explicit method: as IDA flies them, under brakes far too stiff for an explicit step."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import SOFT, STIFF, random_net
from flights import energy_of, explicit_options
from scipy.linalg import eigh

from netdae.forces.loads import Gravity, NodalLoad
from netdae.model.motions import FunctionMotion
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.solvers.explicit import stepper as explicit
from netdae.solvers.explicit.stable_step import stable_step
from netdae.solvers.explicit.stepper import ExplicitSolver
from netdae.solvers.flight import simulate
from netdae.solvers.linalg.condensed import full_jacobian
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot, NoDamping
from netdae.system.reels import CREEP, Reel
from netdae.system.system import System

TIGHT = SolverOptions(rtol=1e-9, atol_position=1e-11, atol_velocity=1e-9)
ANCHOR, BOB, DRUM = 0, 1, 2


def tether(reel, *, cord=SOFT, bob=0.3, anchor=None, damping=None, loads=(), drum=()):
    """A cable of 1 m from an anchor, held or of a mass in kg, to a bob, on a reel."""
    nodes = np.array([[0.0, 0, 0], [1.0, 0, 0], [0.0, 0, 0]])
    groups = {"anchor": [ANCHOR], "bob": [BOB], "drum": [DRUM]}
    net = CableNet(nodes, [[ANCHOR, BOB]], groups, rest_length=[1.0])
    masses = {"bob": bob} | ({} if anchor is None else {"anchor": anchor})
    held = [Restraint("anchor")] if anchor is None else []
    return System(
        net,
        cord,
        masses=masses,
        damping=damping or NoDamping(),
        restraints=[*held, *drum],
        loads=loads,
        reels=[reel],
    )


def at(system, x_of_bob, v_of_bob, v_of_drum=0.0):
    x, v = system.net.nodes.copy(), np.zeros((3, 3))
    x[BOB], v[BOB], v[DRUM, 0] = x_of_bob, v_of_bob, v_of_drum
    return State.at(x, v)


def test_a_brake_that_no_explicit_step_could_take_stops_a_mass_with_a_constant_force():
    """(m + I) v̇ = −F_b: v falls linearly, and the whole way is (m + I) v²/(2 F_b)."""
    m, inertia, brake, v = 2.0, 0.5, 5.0, 3.0
    system = tether(Reel(DRUM, [0], inertia=inertia, brake_force=brake), cord=STIFF, bob=m)
    tension = brake * m / (m + inertia)
    stop = v * (m + inertia) / brake
    start = at(system, [1 + tension / 1e5, 0, 0], [v, 0, 0], v)
    flight = simulate(system, start, [0.0, 0.5 * stop, stop + 0.5], options=explicit_options())
    h = (stop + 0.5) / flight.statistics["steps"]
    assert h * brake / (CREEP * inertia) > 5  # 2 is the limit of an explicit brake
    half, last = flight[1], flight[-1]
    # the friction's smoothing costs v₀²/(2v²) ~ 1e-7, the cable stretches with its length by 4e-5 of it
    assert half.v[DRUM, 0] == pytest.approx(v / 2, rel=1e-4)
    assert half.x[DRUM, 0] == pytest.approx(3 / 8 * v * stop, rel=1e-4)
    assert last.x[DRUM, 0] == pytest.approx((m + inertia) * v**2 / (2 * brake), rel=2e-4)
    assert abs(last.v[DRUM, 0]) < CREEP
    assert last.balance.dissipated_energy == pytest.approx(0.5 * (m + inertia) * v**2, rel=1e-4)


def test_a_held_drum_creeps_as_the_brake_says():
    """Below the brake force F_b a pull F gives ṡ = v₀ F/√(F_b² − F²)."""
    pull, brake = 3.0, 5.0
    system = tether(
        Reel(DRUM, [0], inertia=0.1, brake_force=brake),
        cord=STIFF,
        bob=1.0,
        loads=[NodalLoad("bob", [pull, 0, 0])],
        damping=Dashpot(viscosity_time=1e-3),
    )
    start = at(system, [1 + pull / 1e5, 0, 0], [0, 0, 0])
    flight = simulate(system, start, [0.0, 1.0, 2.0], options=explicit_options())
    creep = CREEP * pull / np.sqrt(brake**2 - pull**2)
    assert flight[-1].x[DRUM, 0] - flight[1].x[DRUM, 0] == pytest.approx(creep, rel=1e-3)  # strain 3e-5


def swing(amplitude, omega):
    """Winds s = a (1 − cos ω t) out and in."""
    return FunctionMotion(
        lambda t: [amplitude * (1 - np.cos(omega * t)), 0, 0],
        lambda t: [amplitude * omega * np.sin(omega * t), 0, 0],
        lambda t: [amplitude * omega**2 * np.cos(omega * t), 0, 0],
    )


DASHPOT = Dashpot(viscosity_time=2e-3)
CASES = {
    "free": (Reel(DRUM, [0], inertia=0.1), {"anchor": 0.5}, ([0.7, 0, 0], [1.0, 0.5, 0])),
    "braked": (
        Reel(DRUM, [0], inertia=0.1, brake_force=0.5, viscosity=0.1, longest=0.25),
        {"anchor": 0.5, "damping": DASHPOT},
        ([0.9, 0, 0], [2.0, 0.5, 0]),
    ),
    "ratchet": (
        Reel(DRUM, [0], inertia=0.1, brake_force=0.5, ratchet=True, share=-1.0),
        {"damping": DASHPOT, "loads": [Gravity([0, 0, -9.81])]},
        ([0.6, 0, -0.79], [0.0, 0.0, 0]),
    ),
    "driven": (
        Reel(DRUM, [0], inertia=0.1, brake_force=0.5),
        {
            "damping": DASHPOT,
            "loads": [Gravity([0, 0, -9.81])],
            "drum": [Restraint("drum", "x", swing(0.15, 9.0))],
        },
        ([0.5, 0, -0.85], [0.0, 1.0, 0]),
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_reels_fly_and_book_as_with_ida(case):
    reel, settings, start = CASES[case]
    system = tether(reel, **settings)
    begin, times = at(system, *start), np.linspace(0.0, 0.6, 7)
    sharp = simulate(system, begin, times, options=TIGHT)
    errors = []
    for h in (1e-4, 2.5e-5):
        flight = simulate(system, begin, times, options=explicit_options(max_step=h))
        kept = np.array([energy_of(system, frame) for frame in flight])
        errors.append(
            [
                np.abs(flight.positions - sharp.positions).max(),
                np.abs(flight.dissipated_energy - sharp.dissipated_energy).max(),
                np.abs(flight.external_work - sharp.external_work).max(),
                np.abs(flight.external_impulse - sharp.external_impulse).max(),
                np.abs(flight.external_angular_impulse - sharp.external_angular_impulse).max(),
                np.abs(kept - kept[0]).max(),
            ]
        )
    # ways of 0.3 m, energies of 0.4 to 4 J; measured up to 8e-5, 7e-5, 1e-5, 1e-5, 1e-6 and 5e-5, of the first order
    # in h by dashpots, brakes and stops
    assert (np.array(errors[0]) < [2e-4, 2e-4, 5e-5, 3e-5, 3e-6, 2e-4]).all()
    # IDA's own errors are 1e-8
    assert (np.array(errors[1]) < 0.4 * np.array(errors[0]) + 1e-8).all()


def test_a_free_tether_keeps_momentum_to_round_off_while_it_pays_out():
    reel, settings, start = CASES["free"]
    system = tether(reel, **settings)
    flight = simulate(system, at(system, *start), [0.0, 2.0], options=explicit_options())
    first, last = flight[0], flight[-1]
    assert abs(last.x[DRUM, 0]) > 0.1
    np.testing.assert_allclose(system.momentum(last.v), system.momentum(first.v), rtol=0, atol=1e-13)
    turned = [system.angular_momentum(each.x, each.v) for each in (first, last)]
    np.testing.assert_allclose(turned[1], turned[0], rtol=0, atol=1e-13)
    assert last.balance.external_impulse == (0.0, 0.0, 0.0)


HARDLY = Dashpot(viscosity_time=1e-15)  # so that it flies by Verlet, as reels do


def test_a_locked_drum_is_a_cable():
    """Its reaction, a force along no axis of space, is no impulse."""
    system = tether(Reel(DRUM, [0], inertia=0.1), anchor=0.5, drum=[Restraint("drum", "x")])
    net = CableNet(system.net.nodes[:2], [[0, 1]], rest_length=[1.0], node_groups={"a": [0], "b": [1]})
    plain = System(net, SOFT, masses={"a": 0.5, "b": 0.3}, damping=HARDLY)
    start = at(system, [0.9, 0, 0], [1.0, 0.4, 0])
    options, times = explicit_options(max_step=1e-4), [0.0, 0.3, 0.6]
    one = simulate(system, start, times, options=options)
    other = simulate(plain, State.at(start.x[:2], start.v[:2]), times, options=options)
    np.testing.assert_allclose(one.positions[:, :2], other.positions, rtol=0, atol=1e-12)  # other sums
    assert (one.external_impulse == 0).all()
    np.testing.assert_allclose(one.peak_tension, other.peak_tension, rtol=1e-9)


def net_with_reels(seed, damping):
    """A random net, three cables of which are on two light drums."""
    net = random_net(seed)
    nodes = np.vstack((net.nodes, np.zeros((2, 3))))
    with_drums = CableNet(nodes, net.cables, rest_length=net.rest_length)
    reels = [Reel(12, [0, 3], inertia=1e-3, longest=2.0), Reel(13, [7], inertia=5e-4, share=-2.0)]
    return System(with_drums, SOFT, damping=damping, reels=reels), nodes


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("damping", [NoDamping(), Dashpot(viscosity_time=2e-4)])
def test_the_step_is_below_the_true_limit_of_a_taut_net_with_reels(seed, damping):
    """True limit: h² K + 2 h C ≤ 4 M as matrices, from dense eigenvalues with all cables taut and drums wound in."""
    system, x = net_with_reels(seed, damping)
    x[:12] *= 1.9
    options = explicit_options(accuracy="fast")
    solver = ExplicitSolver(system, system.drive_from(x), options)
    zero = np.zeros_like(x)
    solver.enter(system, 0.0, np.stack((x, zero)), np.stack((zero, zero)))
    h = solver._stable / explicit.FRACTIONS["fast"]
    wound = x.copy()
    for reel in system.reels:  # by a fifth of the shortest of its cables, up to which the step has to hold
        L = system.net.rest_length[reel.cables].min()
        wound[reel.node, 0] = -0.2 * L / reel.share
    largest = []
    for place in (x, wound):
        strain = system.strain(place)
        assert (strain > 0).all()
        n = place.size
        J = full_jacobian(system, 0.0, place, zero, 1.0).toarray()  # its lower half is T, M + D for c_j = 1
        free = ~system.restrained.ravel()
        M = system.mass_matrix().toarray()
        K, C = J[n:, :n], J[n:, n:] - M
        both = (h**2 * K + 2 * h * C)[np.ix_(free, free)]
        largest.append(eigh(0.5 * (both + both.T), M[np.ix_(free, free)], eigvals_only=True)[-1])
    assert max(largest) <= 4.0
    # the bound takes all cables of a node for parallel and at the limit of strain
    assert max(largest) > 4.0 / 10


def test_the_step_of_a_single_cable_is_its_true_limit_when_wound_in_by_a_fifth():
    """On a heavy drum two masses move against a spring k: h² k (1/m + 1/M) = 4."""
    system = tether(Reel(DRUM, [0], inertia=1e9), bob=0.3, anchor=0.5)
    L = 0.7
    x = system.net.nodes.copy()
    x[DRUM, 0] = L - 1.0
    k = system.cords.axial_stiffness[0] / (0.8 * L)
    limit = 2 / np.sqrt(k * (1 / system.mass[[BOB, ANCHOR]]).sum())
    # the strain of 1e-9 and the drum's mass are left out
    assert stable_step(system, 1e-9, x=x) == pytest.approx(limit, rel=1e-7)


def test_steps_shorten_as_a_reel_winds_in():
    system = tether(
        Reel(DRUM, [0], inertia=0.1),
        damping=DASHPOT,
        loads=[NodalLoad("bob", [1.0, 0, 0])],
        drum=[Restraint("drum", "x", swing(-0.4, 3.0))],
    )
    start = at(system, [1.03, 0, 0], [0, 0, 0])
    flight = simulate(system, start, [0.0, 1.0], options=explicit_options())
    assert flight[-1].x[DRUM, 0] < -0.79
    assert flight.statistics["step_lengths"] >= 5  # 0.8⁷ = 0.2
    assert energy_of(system, flight[-1]) == pytest.approx(energy_of(system, flight[0]), abs=2e-2)
