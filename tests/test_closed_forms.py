"""Closed forms beside those of `netdae verify`: when a bungee is slack, and the limit of a stiff pendulum."""

import math

import numpy as np
import pytest
from conftest import line
from scipy.optimize import brentq
from scipy.special import ellipk

import netdae as nd
from netdae.runs.verification.cases.bungee import DROP, Bungee

G = 9.81  # m/s²
GRAVITY = nd.Gravity([0.0, 0.0, -G])
ANCHOR = nd.Restraint("first")


def options(rtol):
    return nd.SolverOptions(rtol=rtol, atol_position=rtol, atol_velocity=10 * rtol)


def weight_on_a_cable(stiffness, mass=1.0, length=1.0):
    """One cable that hangs from node 0 and carries node 1; EA in N."""
    cord = nd.Material(youngs_modulus=1e6 * stiffness, area=1e-6, linear_density=1e-6)
    return nd.System(
        line(1, length=length),
        cord,
        damping=nd.NoDamping(),
        masses={"last": mass},
        loads=[GRAVITY],
        restraints=[ANCHOR],
    )


# Bungee


def test_bungee_is_slack_just_until_the_fall_has_its_length():
    b = Bungee()
    times = [0.0, b.to_taut - 1e-4, b.to_taut + 1e-4, 2 * b.to_lowest - b.to_taut - 1e-4]
    times.append(times[-1] + 2e-4)
    flight = nd.simulate(b.system, b.start, times, options=options(1e-9))
    tension = [b.system.tension(x)[0] for x in flight.positions]
    assert np.array_equal(np.array(tension) > 0, [False, False, True, True, False])
    fall = -DROP - 0.5 * G * times[1] ** 2
    assert flight.positions[1, 1, 2] == pytest.approx(fall, rel=1e-9)


# Pendulum


def bottom_passage(stiffness, angle):
    """Time at which a weight let go at `angle` from the vertical passes below its anchor, s."""
    system = weight_on_a_cable(stiffness)
    m = system.mass[1]
    # begins with the pull m g cos θ, so that it rings little along the cable
    pull = m * G * math.cos(angle)
    length = brentq(lambda s: stiffness * 0.5 * (s * s - 1) * s - pull, 1.0, 2.0, xtol=1e-15)
    start = nd.State.at([[0.0] * 3, [length * math.sin(angle), 0.0, -length * math.cos(angle)]])
    expected = math.sqrt(1 / G) * ellipk(math.sin(angle / 2) ** 2)
    times = expected + np.arange(-20, 21) * 1e-3
    flight = nd.simulate(system, start, [0.0, *times], options=options(1e-10))
    x, v = flight.positions[1:, 1, 0], flight.velocities[1:, 1, 0]
    k = int(np.flatnonzero((x[:-1] > 0) & (x[1:] <= 0))[0])
    h = times[1] - times[0]

    def hermite(s):
        return (
            (1 + 2 * s) * (1 - s) ** 2 * x[k]
            + s * (1 - s) ** 2 * h * v[k]
            + s * s * (3 - 2 * s) * x[k + 1]
            + s * s * (s - 1) * h * v[k + 1]
        )

    return times[k] + h * brentq(hermite, 0.0, 1.0), expected


def test_pendulum_with_a_large_swing_follows_the_elliptic_integral():
    passages = [bottom_passage(EA, math.pi / 2) for EA in (8e3, 16e3, 32e3)]
    t = np.array([passage for passage, _ in passages])
    once = 2 * t[1:] - t[:-1]  # takes out 1/EA, then 1/EA²
    rigid = (4 * once[1] - once[0]) / 3
    assert rigid == pytest.approx(passages[0][1], rel=1e-6)
    assert t[0] / passages[0][1] - 1 > 1e-4  # so the extrapolation had work to do
