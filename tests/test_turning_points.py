"""Turning points as events: rates against differences, a pendulum and a spring against their exact times."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.random import default_rng
from scipy.special import ellipk

import netdae as nd
from netdae.core.errors import InputError, ScenarioError
from netdae.events.event import QUANTITIES
from netdae.events.quantities import MEASURES, Scene
from netdae.events.rates import RATES
from netdae.forces.rings import Rings
from netdae.system.closing import Drawcord, Haul, Winch
from netdae.system.closing_assembly import with_closings

G = 9.81
CORD = nd.Material(youngs_modulus=1e8, density=1000.0, diameter=1e-3, strength=80.0, toe_strain=1e-2)


@pytest.fixture(scope="module")
def whole():
    net = nd.CableNet.square(side=2.0, cells=4)
    start = nd.State.at(net.nodes)
    tied = nd.with_tether(
        net,
        start,
        nd.Tether(
            group="centre",
            elements=2,
            material=CORD,
            slack=0.05,
            payout="braked",
            brake_force=5.0,
            drum_inertia=0.1,
            chaser=nd.Chaser((0.0, 0.0, -2.0), mass=10.0),
        ),
    )
    haul = Haul(speed=1.0, force=1e3, final_length=0.4)
    closings = (
        Drawcord(CORD, haul, group="border", rings=Rings(size=0.01)),
        Winch((0,), (24,), CORD, haul),
    )
    closed = with_closings(tied.net, tied.start, closings)
    system = nd.System(
        closed.net,
        {"all": CORD, **tied.materials, **closed.materials},
        damping=nd.NoDamping(),
        masses={"corners": 0.1, **tied.masses},
        restraints=[*tied.restraints, *closed.restraints],
        reels=(*tied.reels, *closed.reels),
        forces=closed.forces,
        target=nd.Target((nd.Part(nd.Sphere(0.3)),), motion="moving", position=(0.1, 0.2, 3.0)),
    )
    return system, system.whole(closed.start)


@pytest.mark.parametrize("figure", list(RATES))
@pytest.mark.parametrize("seed", range(4))
def test_rates_are_those_of_the_figures(whole, figure, seed):
    system, start = whole
    rng = default_rng(seed)
    events = [nd.Event("corner_area", 1.0), nd.Event("tether_taut"), nd.Event("chaser_distance", 1.0)]
    scene = Scene(system, events, mouth="border", corners="corners")
    x = start.x * 1.1 + 0.02 * rng.normal(size=start.x.shape)
    v = rng.normal(size=x.shape)
    if seed % 2:  # a start with momentum: its distances are along it
        scene.begin(nd.State.at(start.x, np.ones_like(v)))
    else:
        scene.begin(start)

    def at(h):
        return MEASURES[figure](scene, nd.State.at(x + h * v))

    h = 1e-6
    expected = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)
    assert expected != 0
    # round-off of the figure over h
    assert RATES[figure](scene, nd.State.at(x, v)) == pytest.approx(
        expected, rel=1e-7, abs=1e-9 * abs(at(0)) / 1e-1
    )


def test_the_largest_strain_is_of_each_kind_of_cable(whole):
    """The rates above are of the net's cables: those of tether, winch and drawcord, one by one."""
    system, start = whole
    from netdae.events.rates import strain_rates

    rng = default_rng(9)
    x = start.x * 1.1 + 0.02 * rng.normal(size=start.x.shape)
    v, h = rng.normal(size=x.shape), 1e-6
    expected = (8 * (system.strain(x + h * v) - system.strain(x - h * v))) / (12 * h)
    expected -= (system.strain(x + 2 * h * v) - system.strain(x - 2 * h * v)) / (12 * h)
    np.testing.assert_allclose(strain_rates(system, x, v), expected, rtol=1e-7, atol=1e-8)


def test_every_figure_that_turns_has_a_rate():
    assert {*RATES} == {name for name, quantity in QUANTITIES.items() if quantity.turns}


# Exact instants

OPTIONS = {
    "ida": nd.SolverOptions(rtol=1e-8, atol_position=1e-10, atol_velocity=1e-9),
    "explicit": nd.SolverOptions("explicit", accuracy="accurate", max_step=1e-4),
}


def pendulum(EA: float):
    net = nd.CableNet([[0, 0, 0], [math.sin(math.pi / 3), 0, -0.5]], [[0, 1]], {"top": [0], "bob": [1]})
    cord = nd.Material(youngs_modulus=EA / 1e-6, density=0.0, area=1e-6, strength=100.0)
    return nd.System(
        net,
        cord,
        damping=nd.Dashpot(viscosity_time=1e-3),
        masses={"bob": 1.0},
        loads=[nd.Gravity([0, 0, -G])],
        restraints=[nd.Restraint("top")],
    )


def flown(system, start, end, events, method):
    detector = nd.EventDetector(events, system)
    flight = list(nd.integrate(system, start, [start.t, end], options=OPTIONS[method], events=detector))
    return flight, detector.records


@pytest.mark.parametrize("method", ["ida", "explicit"])
def test_a_pendulum_turns_at_half_its_exact_period(method):
    """From 60° at rest: T = 4 √(l/g) K(sin 30°), whatever the amplitude."""
    system = pendulum(1e5)
    events = [
        nd.Event("distance", at="maximum", repeat=True, name="far"),
        nd.Event("distance", at="minimum", repeat=True, name="back"),
    ]
    period = 4 * math.sqrt(1.0 / G) * ellipk(math.sin(math.pi / 6) ** 2)
    # the centre of mass is the bob's and is 1.732 m away, at the other side, after half a period
    _, records = flown(system, nd.State.at(system.net.nodes), 1.3 * period, events, method)
    times = {
        name: [r["time"] for r in records if r["name"] == name and r["time"]] for name in ("far", "back")
    }
    # the cord of 1e5 N stretches by 2 m g/EA at most, 2e-4: half of it on the period
    np.testing.assert_allclose(times["far"], [0.5 * period], rtol=1.5e-4)
    np.testing.assert_allclose(times["back"], [period], rtol=1.5e-4)
    far = next(r for r in records if r["name"] == "far")
    assert far["at"] == "maximum"
    assert far["reached"] == pytest.approx(math.sqrt(3.0), rel=1e-4)


@pytest.mark.parametrize("method", ["ida", "explicit"])
def test_the_tension_of_a_spring_turns_at_each_half_period(method):
    EA, m = 50.0, 0.5
    net = nd.CableNet([[0, 0, 0], [0, 0, -1.0]], [[0, 1]], {"top": [0], "bob": [1]})
    cord = nd.Material(youngs_modulus=EA / 1e-6, density=0.0, area=1e-6, law="engineering", strength=100.0)
    system = nd.System(
        net,
        cord,
        damping=nd.NoDamping(),
        masses={"bob": m},
        loads=[nd.Gravity([0, 0, -G])],
        restraints=[nd.Restraint("top")],
    )
    half, rest = math.pi / math.sqrt(EA / m), m * G / EA
    events = [
        nd.Event("tension_over_strength", at="maximum", repeat=True),
        nd.Event("tension_over_strength", at="minimum", repeat=True),
        nd.Event("tension_over_strength", 0.11, at="maximum", name="large"),
    ]
    start = nd.State.at([[0, 0, 0], [0, 0, -1.0 - 0.5 * rest]])
    _, records = flown(system, start, 3.5 * half, events, method)
    found = [(r["name"], r["time"]) for r in records if r["time"]]
    names = [
        "tension_over_strength_maximum",
        "tension_over_strength_minimum",
        "tension_over_strength_maximum",
    ]
    assert [name for name, _ in found] == names
    # a rate that passes zero at E11″ = ω² E: errors of v of 1e-9 m/s over 0.05 m · ω²
    np.testing.assert_allclose([t / half for _, t in found], [1, 2, 3], rtol=2e-6)
    assert records[0]["reached"] == pytest.approx(1.5 * m * G / 100.0, rel=1e-6)
    # the tension swings by m g, 0.049 of the strength: never by 0.11
    assert [r["time"] for r in records if r["name"] == "large"] == [None]
    assert records[-1]["value"] == 0.11


def test_a_stop_at_the_turning_point_ends_the_flight_there():
    system = pendulum(1e4)
    flight, _ = flown(
        system,
        nd.State.at(system.net.nodes),
        5.0,
        [nd.Event("distance", at="maximum", action="stop")],
        "explicit",
    )
    assert flight[-1].v[1] @ [1, 0, 0] == pytest.approx(0.0, abs=1e-3)
    assert flight[-1].x[1, 0] == pytest.approx(-math.sin(math.pi / 3), rel=1e-2)


def test_a_net_at_rest_does_not_turn():
    net = nd.CableNet.square(side=1.0, cells=2)
    cord = nd.Material(youngs_modulus=1e9, density=1000.0, diameter=1e-3, prestress=3.0, strength=100.0)
    system = nd.System(
        net, cord, damping=nd.Dashpot(viscosity_time=1e-5), restraints=[nd.Restraint("border")]
    )
    events = [
        nd.Event(figure, at=at)
        for figure in ("mouth_area", "distance", "tension_over_strength", "all_slack")
        for at in ("maximum", "minimum")
    ]
    detector = nd.EventDetector(events, system)
    list(nd.integrate(system, nd.State.at(net.nodes), [0.0, 0.05], events=detector))
    assert not detector.fired


def test_two_events_at_one_turning_point_both_happen():
    system = pendulum(1e4)
    events = [nd.Event("distance", at="maximum", name=name) for name in ("one", "two")]
    _, records = flown(system, nd.State.at(system.net.nodes), 1.5, events, "explicit")
    assert {r["name"] for r in records if r["time"]} == {"one", "two"}


def test_a_detector_goes_on_from_its_memory():
    system = pendulum(1e4)
    events = [nd.Event("distance", at="maximum"), nd.Event("distance", at="minimum")]
    one, other = nd.EventDetector(events, system), nd.EventDetector(events, system)
    start = nd.State.at(system.net.nodes)
    list(nd.integrate(system, start, [0.0, 1.5], options=OPTIONS["explicit"], events=one))
    other.begin(start)
    other.restore(one.memory())
    assert other.records == one.records
    np.testing.assert_array_equal(other.memory()["watches"], one.memory()["watches"])


# What is refused


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: nd.Event("distance", at="top"), "at is 'top': choose one of value, maximum, minimum"),
        (lambda: nd.Event("largest_mouth_area", at="maximum"), "largest_mouth_area is a maximum itself"),
        (
            lambda: nd.Event("distance", -1.0, at="minimum"),
            "value is -1, expected zero or more: the least fall",
        ),
        (
            lambda: nd.Event("distance", math.nan, at="maximum"),
            "value is nan, expected zero or more: the least rise",
        ),
    ],
)
def test_a_wrong_turning_point_is_reported_in_one_line(make, words):
    with pytest.raises(InputError, match=words):
        make()


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
[[restraints]]
group = "corners"
[[loads]]
kind = "gravity"
g = [0.0, 0.0, -9.81]
[[events]]
figure = "distance"
at = "{}"
value = 0.001
action = "stop"
[solver]
end = 1.0
"""


def test_a_scenario_stops_where_its_net_has_fallen_deepest(tmp_path):
    file = tmp_path / "flight.toml"
    file.write_text(SCENARIO.format("maximum"), encoding="utf-8")
    simulation = nd.read_scenario(file).build()
    states = list(simulation.integrate())
    assert [event.name for event in simulation.events.events] == ["distance_maximum_0.001"]
    momentum = simulation.system.momentum(states[-1].v)
    assert states[-1].t < 1.0
    assert abs(momentum[2]) < 1e-6 * float(np.abs(simulation.system.mass).sum())


def test_a_scenario_with_another_place_is_refused(tmp_path):
    file = tmp_path / "flight.toml"
    file.write_text(SCENARIO.format("maximun"), encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"\[\[events\]\] 1 at is the text .* did you mean maximum"):
        nd.read_scenario(file).build()
