"""shape = "equilibrium": catenaries, hanging chains and sagging nets by their closed forms, and what is refused."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import netdae as nd
from netdae.core.errors import ScenarioError

G = 9.81
DAMPING = '[damping]\nkind = "none"\n'
GRAVITY = f'[[loads]]\nkind = "gravity"\ng = [0.0, 0.0, -{G}]\n'
SOLVER = "[solver]\nend = 0.2\n[output]\nframes = 3\n"
CORD = "[[material]]\nyoungs_modulus = {}\nlinear_density = 0.1\narea = 1e-6\n{}"
ENDS = '[[restraints]]\ngroup = "ends"\n'


def chain_file(folder, pieces, length=2.0, **groups):
    x = np.zeros((pieces + 1, 3))
    x[:, 0] = np.linspace(-0.5 * length, 0.5 * length, pieces + 1)
    net = nd.CableNet(x, [[k, k + 1] for k in range(pieces)], {"ends": [0, pieces], **groups})
    nd.write_net(net, folder / "chain.vtu")
    return '[net]\nfile = "chain.vtu"\n'


def built(folder, *parts):
    file = folder / "flight.toml"
    file.write_text("\n".join(parts), encoding="utf-8")
    return nd.read_scenario(file).build()


def stays(simulation, tolerance):
    """Whether the flight stays where it begins, to m."""
    states = list(simulation.integrate())
    np.testing.assert_allclose(states[-1].x, simulation.start.x, atol=tolerance)


def test_a_chain_between_near_supports_hangs_as_a_catenary(tmp_path):
    """z = a cosh(x/a) with 2a sinh(d/2a) = L between supports d apart, with the tension λ g z along the chain."""
    pieces, near = 80, 0.6
    simulation = built(
        tmp_path,
        chain_file(tmp_path, pieces),
        CORD.format("1e12", ""),
        DAMPING,
        GRAVITY,
        ENDS,
        f'[initial]\nshape = "equilibrium"\nscale = [{near}, 1.0, 1.0]\n',
        SOLVER,
    )
    d = 2.0 * near
    a = brentq(lambda a: 2 * a * math.sinh(d / (2 * a)) - 2.0, 0.1, 10.0)
    x = simulation.start.x
    exact = a * (np.cosh(x[:, 0] / a) - math.cosh(d / (2 * a)))
    # the chain of pieces l is a polygon whose corners lie off the curve by about l²/8a, a = 0.35 m
    np.testing.assert_allclose(x[:, 2], exact, atol=(2.0 / pieces) ** 2 / (8 * a))
    np.testing.assert_allclose(x[:, 1], 0.0, atol=1e-12)
    middle = 0.5 * (x[1:, 2] + x[:-1, 2]) + a * math.cosh(d / (2 * a))
    np.testing.assert_allclose(simulation.system.tension(x), 0.1 * G * middle, rtol=2e-3)
    assert not simulation.findings


def test_a_hanging_elastic_chain_is_as_long_as_by_hooke(tmp_path):
    """By the engineering law piece k from the top bears N_k = (p − k − ½) λ L̄ g, and is longer by N_k L̄/EA."""
    pieces, length, EA = 10, 2.0, 50.0
    simulation = built(
        tmp_path,
        chain_file(tmp_path, pieces, top=[0]),
        CORD.format(EA / 1e-6, 'law = "engineering"\n'),
        DAMPING,
        GRAVITY,
        '[[restraints]]\ngroup = "top"\n',
        '[initial]\nshape = "equilibrium"\nrotation_deg = [0.0, 30.0, 0.0]\n',
        SOLVER,
    )
    x, L = simulation.start.x, length / pieces
    N = (pieces - np.arange(pieces) - 0.5) * 0.1 * L * G
    below = np.concatenate(([0.0], np.cumsum(L * (1 + N / EA))))
    np.testing.assert_allclose(
        x[0] - x[:, 2:] * [0, 0, 1], x[0] - np.outer(x[0, 2] - below, [0, 0, 1]), atol=1e-10
    )
    np.testing.assert_allclose(x[:, :2], x[:1, :2] * np.ones((pieces + 1, 1)), atol=1e-9)
    stays(simulation, 1e-8)


def test_a_taut_net_sags_under_its_weight_as_a_membrane(tmp_path):
    """A grid under the tension T in each cord, of the mesh a and masses m, obeys the discrete Poisson equation
    T/a Σ (w_k − w) = m g of the four neighbours, for slopes that are small."""
    cells, T = 6, 200.0
    simulation = built(
        tmp_path,
        f'[net]\nkind = "square"\nside = 3.0\ncells = {cells}\n',
        CORD.format("1e9", f"prestress = {T}\n"),
        DAMPING,
        GRAVITY,
        '[[restraints]]\ngroup = "border"\n',
        '[initial]\nshape = "equilibrium"\n',
        SOLVER,
    )
    net, n = simulation.system.net, cells + 1
    w = simulation.start.x[:, 2]
    place = np.lexsort((net.nodes[:, 0], net.nodes[:, 1]))
    grid = w[place].reshape(n, n)
    m = simulation.system.mass[place].reshape(n, n)[1:-1, 1:-1]
    bend = grid[2:, 1:-1] + grid[:-2, 1:-1] + grid[1:-1, 2:] + grid[1:-1, :-2] - 4 * grid[1:-1, 1:-1]
    # slopes of 1e-2 raise the tension by EA/T (1e-2)²/2, 3e-4
    np.testing.assert_allclose(T / (3.0 / cells) * bend, m * G, rtol=1e-3)
    assert 4e-3 < -w.min() < 7e-3
    stays(simulation, 1e-7)


def test_velocities_are_those_of_the_net_at_rest(tmp_path):
    """Spin and shots act on the places at rest, and shots point outward from there."""
    parts = (
        '[net]\nkind = "square"\nside = 2.0\ncells = 4\n',
        CORD.format("1e9", ""),
        DAMPING,
        '[[masses]]\ngroup = "corners"\nmass = 0.2\n',
        '[[loads]]\nkind = "spring"\ngroup = "corners"\nstiffness = 40.0\n',  # its anchors are in the mesh
        GRAVITY,
    )
    shot = '[[initial.ejection]]\ngroup = "corners"\nspeed = 2.0\nhalf_angle_deg = 30.0\naxis = [0.0, 0.0, -1.0]\n'
    begin = '[initial]\nshape = "equilibrium"\nspin_deg_s = [0.0, 0.0, 90.0]\n'
    simulation = built(tmp_path, *parts, begin, shot, SOLVER)
    x, v, m = simulation.start.x, simulation.start.v, simulation.system.mass
    still = nd.State.at(x)
    force = simulation.system.force(0.0, x, still.v)
    assert np.abs(force).max() < 1e-8
    corners = simulation.system.net.nodes_of("corners")
    np.testing.assert_allclose(-40.0 * x[corners, 2].sum(), G * m.sum(), rtol=1e-9)
    spinning = nd.spun(still, m, [0, 0, 90.0])
    exact = nd.ejected(
        simulation.system.net, spinning, "corners", speed=2.0, half_angle_deg=30.0, axis=(0, 0, -1.0)
    )
    np.testing.assert_allclose(v, exact.v, atol=1e-12)


def test_a_tether_and_a_closing_cord_come_to_rest_too(tmp_path):
    cord = "youngs_modulus = 1e9\ndensity = 1000\ndiameter = 1e-3\n"
    simulation = built(
        tmp_path,
        '[net]\nkind = "square"\nside = 2.0\ncells = 4\n',
        CORD.format("1e9", ""),
        '[damping]\nkind = "dashpot"\nviscosity_time = 1e-4\n',
        GRAVITY,
        '[tether]\ngroup = "centre"\nelements = 4\nslack = 0.02\npayout = "braked"\nbrake_force = 500.0\n'
        f"drum_inertia = 0.1\n{cord}",
        '[tether.chaser]\nposition = [0.0, 0.0, 2.0]\nmotion = "fixed"\n',
        '[[closing]]\nkind = "drawcord"\nrings = "border"\nspeed = 1.0\nforce = 50.0\n'
        f"final_length = 1.0\nbegin = 0.1\n{cord}",
        '[initial]\nshape = "equilibrium"\n',
        "[solver]\nend = 0.09\n[output]\nframes = 3\n",
    )
    system, x = simulation.system, simulation.start.x
    weight = G * system.spatial_mass[:25].sum()
    tether = system.net.cables_of("tether")
    assert system.tension(x)[tether[0]] == pytest.approx(weight, rel=0.02)  # and half a piece of its own
    f = np.where(system.restrained, 0.0, system.force(0.0, x, np.zeros_like(x)))
    own = system.in_space
    assert np.abs(f[own]).max() < 1e-6


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ((GRAVITY,), r"\[initial\] shape: there is no equilibrium: a load of .* they fall freely"),
        (
            (
                "[orbit]\naltitude = 600e3\n",
                '[[loads]]\nkind = "nodal"\ngroup = "ends"\nforce = [1.0, 0.0, 0.0]\n',
            ),
            r"\[initial\] shape: the nearest equilibrium is .* m away",
        ),
        (('[initial]\nshape = "equilibrium"\nfolds = [2, 2]\n',), r'folds is a key of shape = "accordion"'),
    ],
)
def test_what_has_no_rest_is_refused_in_one_line(tmp_path, parts, words):
    begin = () if "[initial]" in parts[0] else ('[initial]\nshape = "equilibrium"\n',)
    net = chain_file(tmp_path, 4)
    with pytest.raises(ScenarioError, match=words) as caught:
        built(tmp_path, net, CORD.format("1e9", ""), DAMPING, *parts, *begin, SOLVER)
    assert "\n" not in str(caught.value)


def test_what_hangs_slack_is_named(tmp_path):
    simulation = built(
        tmp_path,
        chain_file(tmp_path, 4),
        CORD.format("1e9", ""),
        DAMPING,
        ENDS,
        '[initial]\nshape = "equilibrium"\nscale = [0.5, 1.0, 1.0]\n',
        SOLVER,
    )
    (finding,) = simulation.findings
    assert "at rest 9 motions have no stiffness, first of node 1 along xyz" in finding
