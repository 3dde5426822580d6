"""Nets small or simple enough for a solution in closed form."""

import math

import numpy as np
import pytest
from conftest import line
from scipy.integrate import quad
from scipy.optimize import brentq, root
from scipy.special import ellipk

import netdae as nd

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


# Bungee: slack fall, stretch, rebound, slack flight up, and again


class Bungee:
    """Energy and quadrature for a mass m that is dropped `drop` below the anchor of a cable L, EA."""

    EA, L, drop = 60.0, 1.5, 0.3

    def __init__(self):
        self.system = weight_on_a_cable(self.EA, length=self.L)
        self.m = self.system.mass[1]  # with the half of the cable
        self.lowest = brentq(self.excess, self.L, 10 * self.L, xtol=1e-14)
        self.to_taut = math.sqrt(2 * (self.L - self.drop) / G)
        # dt = dl/v; l = lowest − s² takes the root out of v at the lowest point
        stretch, _ = quad(
            lambda s: 2 * s / math.sqrt(-2 * self.excess(self.lowest - s * s) / self.m),
            0.0,
            math.sqrt(self.lowest - self.L),
            epsabs=1e-13,
        )
        self.to_lowest = self.to_taut + stretch

    def excess(self, length):
        """Stored energy, ½ EA L E11², less the energy of the fall, J."""
        E11 = 0.5 * ((length / self.L) ** 2 - 1)
        return 0.5 * self.EA * self.L * E11**2 - self.m * G * (length - self.drop)


def test_bungee_turns_where_energy_says_and_when_quadrature_says():
    b = Bungee()
    start = nd.State.at([[0.0, 0.0, 0.0], [0.0, 0.0, -b.drop]])
    turns = b.to_lowest * np.arange(1, 5)  # lowest, back at the start, lowest, back at the start
    flight = nd.simulate(b.system, start, [0.0, *turns], options=options(1e-10))
    z, v, a = (values[1:, 1, 2] for values in (flight.positions, flight.velocities, flight.accelerations))
    late = -v / a  # v is all but zero there: one step of Newton's finds where it is
    np.testing.assert_allclose(turns + late, turns, rtol=1e-6)
    np.testing.assert_allclose(z + 0.5 * v * late, np.tile([-b.lowest, -b.drop], 2), rtol=1e-6)
    E11 = 0.5 * ((b.lowest / b.L) ** 2 - 1)
    pull = b.EA * E11 * b.lowest / b.L
    assert a[0] == pytest.approx(pull / b.m - G, rel=1e-6)
    assert a[1] == pytest.approx(-G, rel=1e-6)  # slack


def test_bungee_is_slack_just_until_the_fall_has_its_length():
    b = Bungee()
    start = nd.State.at([[0.0, 0.0, 0.0], [0.0, 0.0, -b.drop]])
    times = [0.0, b.to_taut - 1e-4, b.to_taut + 1e-4, 2 * b.to_lowest - b.to_taut - 1e-4]
    times.append(times[-1] + 2e-4)
    flight = nd.simulate(b.system, start, times, options=options(1e-9))
    tension = [b.system.tension(x)[0] for x in flight.positions]
    assert np.array_equal(np.array(tension) > 0, [False, False, True, True, False])
    fall = -b.drop - 0.5 * G * times[1] ** 2
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


# Taut string


def taut_string(cables, stretch=1.01, length=2.0):
    """A string along x drawn out from its rest length of `length` m; its system and drawn positions."""
    cord = nd.Material(youngs_modulus=2e9, density=1100.0, diameter=2e-3)
    ends = [nd.Restraint("first"), nd.Restraint("last")]
    system = nd.System(line(cables, length=length), cord, damping=nd.NoDamping(), restraints=ends)
    return system, system.net.nodes * [stretch, 1.0, 1.0]


def wave_speeds(stretch):
    """c of transverse waves on the drawn string, in the current and in the reference configuration."""
    E, rho = 2e9, 1100.0
    S11 = E * 0.5 * (stretch**2 - 1)
    return stretch * math.sqrt(S11 / rho), math.sqrt(S11 / rho)


@pytest.mark.parametrize("cables", [2, 5, 12])
def test_taut_string_of_lumps_rings_as_lagrange_found(cables):
    system, drawn = taut_string(cables)
    n = np.arange(1, cables)
    current, reference = wave_speeds(1.01)
    for c, L in ((current, 2.02), (reference, 2.0)):
        expected = cables * c / (math.pi * L) * np.sin(n * math.pi / (2 * cables))
        found, modes = nd.frequencies(system, drawn, count=2 * len(n))
        # each twice, in y and in z; the longitudinal ones are ten times as high
        np.testing.assert_allclose(found, np.repeat(expected, 2), rtol=1e-8)
    shape = np.sin(math.pi * np.arange(cables + 1) / cables)
    first = np.linalg.norm(modes[0], axis=1)
    np.testing.assert_allclose(first / first.max(), shape / shape.max(), atol=1e-6)


def test_taut_string_comes_to_the_continuum_with_the_square_of_the_cable_length():
    counts = np.array([8, 16, 32, 64])
    c, _ = wave_speeds(1.01)
    for n in (1, 3):
        limit = n * c / (2 * 2.02)
        errors = [1 - nd.frequencies(*taut_string(N), count=2 * n)[0][-1] / limit for N in counts]
        slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
        # the next term, x²/20 with x = nπ/16, bends it by 0.02 for n = 3
        assert slope == pytest.approx(-2.0, abs=0.03)


def test_string_plucked_in_its_first_mode_swings_with_its_frequency():
    system, drawn = taut_string(6)
    frequency, modes = nd.frequencies(system, drawn, count=1)
    shape = 1e-5 * modes[0] / np.abs(modes[0]).max()  # m; so small that the pull does not change
    period = 1 / frequency[0]
    flight = nd.simulate(
        system,
        nd.State.at(drawn + shape),
        period * np.array([0.0, 0.25, 0.5, 1.0]),
        options=nd.SolverOptions(rtol=1e-9, atol_position=1e-12, atol_velocity=1e-9),
    )
    for x, swing in zip(flight.positions, (1.0, 0.0, -1.0, 1.0), strict=True):
        # slopes of 2e-5 raise the strain of 1e-2 by 1e-10: linear; the tolerance is the integrator's
        np.testing.assert_allclose(x - drawn, swing * shape, atol=1e-9)


# Elastic catenary


class Catenary:
    """Irvine's elastic catenary: cable of rest length S, weight w per rest length, hung over `span`, `rise`."""

    span, rise, S, EA, mu = 8.0, 1.5, 9.0, 400.0, 0.5

    def __init__(self):
        w = self.w = self.mu * G
        self.H, self.V = root(
            lambda p: self.at(self.S, *p) - [self.span, self.rise], [w * self.S] * 2, tol=1e-13
        ).x
        np.testing.assert_allclose(self.at(self.S, self.H, self.V), [self.span, self.rise], rtol=1e-12)

    def at(self, s, H, V):
        """x and z of the point s of rest length from the end in the origin; H, V the pull on the other end."""
        W = V - self.w * self.S  # vertical pull at s = 0, along the cable
        P = W + self.w * s
        x = H * s / self.EA + H / self.w * (np.arcsinh(P / H) - np.arcsinh(W / H))
        z = (P * P - W * W) / (2 * self.EA * self.w) + (np.hypot(H, P) - np.hypot(H, W)) / self.w
        return np.array([x, z])


def hung(cables):
    """The catenary of `cables` pieces: largest error of a node and of the pull on the upper end."""
    c = Catenary()
    net = line(cables, length=c.S)
    cord = nd.Material(youngs_modulus=1e6 * c.EA, area=1e-6, linear_density=c.mu, law="engineering")
    ends = [nd.Restraint("first"), nd.Restraint("last")]
    system = nd.System(net, cord, damping=nd.NoDamping(), loads=[GRAVITY], restraints=ends)
    start = np.linspace(0, 1, cables + 1)[:, None] * [c.span, 0.0, c.rise]
    rest = nd.equilibrium(system, start)
    x, z = c.at(net.nodes[:, 0], c.H, c.V)
    node = np.abs(rest.x - np.stack((x, 0 * x, z), axis=1)).max()
    pull = np.abs(rest.reactions[-1] - [c.H, 0.0, c.V]).max()
    return node, pull


def test_elastic_catenary_under_refinement():
    counts = np.array([10, 20, 40, 80])
    errors = np.array([hung(N) for N in counts])
    for column in errors.T:
        slope = np.polyfit(np.log(counts), np.log(column), 1)[0]
        assert slope == pytest.approx(-2.0, abs=0.05)
    assert errors[-1, 0] < 1e-3 * Catenary.span
