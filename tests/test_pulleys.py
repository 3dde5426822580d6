"""Pulleys: a block and tackle, the capstan's ratio, statics, and what is refused."""

import math

import numpy as np
import pytest

import netdae as nd
from netdae.cli import main
from netdae.core.errors import InputError, ScenarioError
from netdae.forces.rings import Rings
from netdae.runs.verification.cases.atwood import ROPE, SLACK, machine, segments

G = 9.81


OPTIONS = {
    "ida": nd.SolverOptions(rtol=1e-7, atol_position=1e-9, atol_velocity=1e-8),
    "explicit": nd.SolverOptions("explicit", accuracy="accurate"),
}


@pytest.mark.parametrize("method", OPTIONS)
def test_a_block_and_tackle_halves_the_force(method):
    """From a hook down to a free block of mass M, up over a fixed sheave, down to m: m falls twice as fast as M rises.

    2 T − M g = M a, m g − T = 2 m a, so a = g (2m − M)/(4m + M) and T = 3 m M g/(4m + M).
    """
    M, m, end = 1.5, 1.0, 0.3
    a, T = G * (2 * m - M) / (4 * m + M), 3 * m * M * G / (4 * m + M)
    system, start = machine([[0, 0, 0], [0, 0, -2.0], [0, 0, 0.0], [0, 0, -1.0]], {1: M, 3: m}, [0, 2], T)
    flight = nd.simulate(system, start, [0.0, end], options=OPTIONS[method])
    np.testing.assert_allclose(flight[-1].x[1, 2], -2.0 + 0.5 * a * end**2, atol=2e-5)
    np.testing.assert_allclose(flight[-1].x[3, 2], -1.0 - a * end**2, atol=2e-5)
    np.testing.assert_allclose(segments(system, flight[-1]), T, rtol=2e-3)


def test_a_tackle_balances_where_the_weights_do():
    """Two hooks 2 b apart, a block of mass M between them, m at the end beyond: the sides stand at cos θ = M/2m."""
    M, m, b = 1.0, 0.8, 0.5
    system, start = machine([[-b, 0, 0], [0, 0, -0.5], [b, 0, 0], [b, 0, -1.0]], {1: M, 3: m}, [0, 2], 1.0)
    rest = nd.equilibrium(system, start)
    down = math.tan(math.acos(M / (2 * m)))  # sideways over down
    np.testing.assert_allclose(rest.x[1], [0.0, 0.0, -b / down], atol=1e-6)
    # the way over a ring of the size η is longer than the distance h by (η/h)²/2, 1e-8
    np.testing.assert_allclose(segments(system, rest.state), m * G, rtol=1e-7)


def test_friction_holds_what_the_capstan_bears():
    """Masses whose ratio is below e^{μπ} creep only, as fast as friction is short of its full value."""
    m1, m2, friction, creep = 1.2, 1.0, 0.2, 1e-3
    system, start = machine(
        [[0, 0, -1.0], [0, 0, 0], [0, 0, -1.5]],
        {0: m1, 2: m2},
        [1],
        1.1 * G,
        friction=friction,
        creep=creep,
        damping=nd.Dashpot(viscosity_time=1e-2),
    )
    flight = nd.simulate(system, start, [0.0, 0.3, 0.6], options=OPTIONS["ida"])
    share = math.log(m1 / m2) / (friction * math.pi)  # γ(u) = u/√(1 + u²), u = c/v₀
    slide = creep * share / math.sqrt(1 - share**2)
    np.testing.assert_allclose(flight[-1].v[[0, 2], 2], [-slide, slide], rtol=5e-3)


def test_an_endless_cord_keeps_its_length_and_both_momenta():
    rng = np.random.default_rng(2)
    places = np.array([[0, 0, 0], [1.0, 0, 0], [1.2, 0.9, 0], [0, 1.0, 0.3]])
    net = nd.CableNet(places, [[0, 2]], rest_length=[1e3])
    cord = nd.PulleyCord(ROPE, nodes=(0, 1, 2, 3), closed=True)
    strung = nd.with_pulleys(net, nd.State.at(places, rng.normal(size=(4, 3))), [cord])
    system = nd.System(
        strung.net,
        {"all": SLACK, **strung.materials},
        damping=nd.NoDamping(),
        masses={"all": 0.5},
        restraints=strung.restraints,
        reels=strung.reels,
    )
    flight = nd.simulate(system, strung.start, [0.0, 0.5], options=OPTIONS["explicit"])
    first, last = flight[0], flight[-1]
    np.testing.assert_allclose(system.momentum(last.v), system.momentum(first.v), atol=1e-12)
    np.testing.assert_allclose(
        system.angular_momentum(last.x, last.v), system.angular_momentum(first.x, first.v), atol=1e-11
    )
    way = np.linalg.norm(np.roll(last.x[:4], -1, axis=0) - last.x[:4], axis=1).sum()
    assert way < 1.01 * np.linalg.norm(np.roll(places, -1, axis=0) - places, axis=1).sum()


@pytest.mark.parametrize("method", OPTIONS)
@pytest.mark.parametrize("flipped", [False, True])
def test_cables_of_the_net_become_a_cord_that_slides(method, flipped):
    """A prestressed line over a sheave: it starts at its prestress, and as an Atwood machine falls at once."""
    m1, m2, end = 2.0, 1.0, 0.3
    a, T = G * (m1 - m2) / (m1 + m2), 2 * m1 * m2 * G / (m1 + m2)
    places = np.array([[0, 0, -1.0], [0, 0, -0.5], [0, 0, 0.0], [0, 0, -1.5]])
    pairs = [[1, 0], [2, 3], [1, 2]] if flipped else [[0, 1], [1, 2], [2, 3]]
    net = nd.CableNet(places, pairs, {"first": [0], "last": [3], "sheave": [2]}, {"rope": [0, 1, 2]})
    rope = nd.Material(youngs_modulus=1e10, density=0.0, area=1e-6, prestress=T)
    # a second ring, at node 1, leads the cord and is held too
    strung = nd.with_pulleys(net, nd.State.at(places), [nd.PulleyCord(cables="rope", rings=Rings(1e-2))])
    system = nd.System(
        strung.net,
        rope,
        damping=nd.NoDamping(),
        masses={"first": m1, "last": m2, "sheave": 0.0},
        loads=[nd.Gravity([0, 0, -G])],
        restraints=[*strung.restraints, nd.Restraint("sheave"), nd.Restraint((1,))],
        reels=strung.reels,
    )
    np.testing.assert_allclose(system.tension(strung.start.x)[:3], T, rtol=1e-11)
    flight = nd.simulate(system, strung.start, [0.0, end], options=OPTIONS[method])
    # a ring of 1 cm takes the more of the cord the nearer a mass is to it: (η/d)²/2 of the pull, 2e-4
    np.testing.assert_allclose(
        flight[-1].x[[0, 3], 2], [-1.0 - 0.5 * a * end**2, -1.5 + 0.5 * a * end**2], atol=2e-4
    )


# What is refused

NET = nd.CableNet(
    [[k % 3, k // 3, 0] for k in range(9)],
    [*([k, k + 1] for k in (0, 1, 3, 4, 6, 7)), [0, 3], [1, 4]],
    {"border": [0, 1, 2], "corners": [0, 2]},
    {"two": [0, 1, 4, 5], "one": [0]},
)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: nd.PulleyCord(ROPE), "pulleys: give just one of a group, a list of nodes and"),
        (lambda: nd.PulleyCord(nodes=(0, 1)), "the cord has no material: give one"),
        (lambda: nd.PulleyCord(ROPE, cables="border"), "have a material, a length and ends: leave them out"),
        (lambda: nd.PulleyCord(cables="rope"), "there is no cable group 'rope'"),
        (lambda: nd.PulleyCord(cables="all"), "cables of 'all' meet at node"),
        (
            lambda: nd.PulleyCord(cables="two"),
            "the cables of 'two' are several cords: node 6 is not on the one",
        ),
        (lambda: nd.PulleyCord(cables="one"), "the cord 'one' is one cable: it slides through nothing"),
        (
            lambda: nd.PulleyCord(ROPE, nodes=(0, 1), loop="border"),
            "the rings have an order of their own: leave the loop out",
        ),
        (
            lambda: nd.PulleyCord(ROPE, nodes=(0, 1), length=0.0),
            "length is 0 m: give a finite number above zero",
        ),
        (lambda: nd.PulleyCord(ROPE, nodes=(0,)), "the cord runs through 1 node: give two or more"),
        (lambda: nd.PulleyCord(ROPE, nodes=(0, 9)), "runs through node 9, but the net has 9 nodes"),
        (lambda: nd.PulleyCord(ROPE, nodes=(0, 1, 0)), "through node 0 twice: let it pass each ring once"),
        (lambda: nd.PulleyCord(ROPE, nodes=(0, 1), closed=True), "an endless cord runs through 2 nodes"),
        (
            lambda: nd.PulleyCord(ROPE, nodes=(0, 1, 2), length=1e-3),
            "2 rings of 0.001 m side by side take 0.002 m",
        ),
        (lambda: nd.PulleyCord(ROPE, group="corners"), "corners"),
    ],
)
def test_a_cord_that_cannot_be_is_refused_in_one_line(make, words):
    with pytest.raises(InputError, match=words) as caught:
        nd.with_pulleys(NET, nd.State.at(NET.nodes), [make()])
    assert str(caught.value).startswith(("pulleys: ", "there is no", "the mouth"))


def test_names_that_the_net_has_already_are_refused():
    cord = nd.PulleyCord(ROPE, nodes=(0, 1))
    once = nd.with_pulleys(NET, nd.State.at(NET.nodes), [cord])
    with pytest.raises(InputError, match="the net has a cable group 'pulleys' already"):
        nd.with_pulleys(once.net, once.start, [cord])


# The scenario

SCENARIO = """
[net]
kind = "square"
side = 1.0
cells = 2

[[material]]
youngs_modulus = 1e8
density = 1000
diameter = 1e-3

[damping]
kind = "dashpot"
viscosity_time = 1e-4

[[masses]]
group = "border"
mass = 0.05

[[restraints]]
group = "centre"

[[loads]]
kind = "gravity"
g = [0.0, 0.0, -9.81]

[[pulleys]]
rings = {}
friction = 0.1
youngs_modulus = 1e8
density = 0
diameter = 1e-3

[[pulleys]]
rings = [0, 4, 8]
length = 1.6
youngs_modulus = 1e8
density = 0
diameter = 1e-3

{}

[solver]
end = 0.2

[output]
frames = 3
"""


def file_of(folder, rings='"border"\nclosed = true', more=""):
    file = folder / "flight.toml"
    file.write_text(SCENARIO.format(rings, more), encoding="utf-8")
    return file


def test_a_scenario_strings_its_cords(tmp_path):
    simulation = nd.read_scenario(file_of(tmp_path)).build()
    net = simulation.system.net
    assert len(net.cables_of("pulleys_1")) == 8
    assert len(net.cables_of("pulleys_2")) == 2
    np.testing.assert_array_equal(net.cables_of("pulleys"), np.arange(12, 22))
    np.testing.assert_allclose(net.rest_length[net.cables_of("pulleys_2")].sum(), 1.6, rtol=1e-14)
    assert simulation.system.spatial_mass[:9].sum() == pytest.approx(simulation.system.mass.sum(), rel=1e-15)
    assert simulation.metrics.begin(simulation.system) is None


def test_a_scenario_with_pulleys_may_start_at_rest(tmp_path):
    file = file_of(tmp_path, more='[initial]\nshape = "equilibrium"\n')
    simulation = nd.read_scenario(file).build()
    system, x = simulation.system, simulation.start.x
    f = np.where(system.restrained, 0.0, system.force(0.0, x, np.zeros_like(x)))
    assert np.abs(f).max() < 1e-7


@pytest.mark.parametrize("verb", ["check", "forces", "run"])
def test_each_verb_takes_pulleys(verb, tmp_path, capsys):
    out = ["-o", str(tmp_path / "out")] if verb == "run" else []
    assert main([verb, str(file_of(tmp_path)), *out]) == 0
    assert "wrong" not in capsys.readouterr().out


def test_a_scenario_makes_cables_slide(tmp_path):
    text = SCENARIO.format("[0, 4]", "").replace(
        "rings = [0, 4]\nfriction = 0.1\nyoungs_modulus = 1e8\ndensity = 0\ndiameter = 1e-3\n",
        'cables = "border"\n',
    )
    file = tmp_path / "flight.toml"
    file.write_text(text, encoding="utf-8")
    simulation = nd.read_scenario(file).build()
    net = simulation.system.net
    np.testing.assert_array_equal(net.cables_of("pulleys_1"), net.cables_of("border"))
    assert net.cable_count == 12 + 2
    assert len(list(simulation.integrate())) == 3


@pytest.mark.parametrize(
    ("rings", "more", "words"),
    [
        ("[0, 99]", "", r"\[\[pulleys\]\] 1: the cord runs through node 99, but the net has 9 nodes"),
        ('"bordr"', "", r"\[\[pulleys\]\] 1: there is no node group 'bordr': did you mean 'border'"),
        ("3", "", r"\[\[pulleys\]\] 1 rings"),
        ("[0, 1]\nspeed = 1.0", "", r"\[\[pulleys\]\] 1 speed is an unknown key"),
    ],
)
def test_a_wrong_scenario_is_one_line(tmp_path, rings, more, words):
    with pytest.raises(ScenarioError, match=words) as caught:
        nd.read_scenario(file_of(tmp_path, rings, more)).build()
    assert "\n" not in str(caught.value)
