"""Scans of many steps at once: the same values as state by state, the same events, and far fewer states looked at."""

import numpy as np
import pytest
from numpy.random import default_rng

from netdae.events.detector import EventDetector
from netdae.events.event import QUANTITIES, Event
from netdae.events.quantities import MEASURES, Scene
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.solvers.driver import integrate
from netdae.solvers.options import SolverOptions
from netdae.system.damping import NoDamping
from netdae.system.reels import Reel
from netdae.system.system import System

FAST = [name for name, quantity in QUANTITIES.items() if quantity.fast and quantity.needs != "contact"]
NODES = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [9.0, 9.0, 9.0]])


def reeled(law, toe):
    """Four cables, of which the first two are the tether, and the first is on a reel whose drum is the last node."""
    net = CableNet(
        NODES,
        [[0, 1], [1, 2], [2, 3], [3, 1]],
        {"chaser": [0], "end": [2], "drums": [4]},
        {"tether": [0, 1]},
    )
    cord = Material(youngs_modulus=1e7, density=1e3, diameter=1e-3, law=law, toe_strain=toe, strength=5.0)
    return System(net, cord, masses={"end": 0.1}, damping=NoDamping(), reels=[Reel(4, [0], inertia=0.1)])


@pytest.mark.parametrize("figure", FAST)
@pytest.mark.parametrize(("law", "toe"), [("st_venant_kirchhoff", 0.0), ("engineering", 0.05)])
def test_a_scan_has_the_values_of_each_state(figure, law, toe):
    system = reeled(law, toe)
    scene = Scene(system, [], mouth=None, corners=None)
    x = NODES + 0.2 * default_rng(7).standard_normal((40, *NODES.shape))
    x[:, 4] = 0.1 * default_rng(8).standard_normal((40, 3))
    v = np.zeros_like(NODES)
    expected = [MEASURES[figure](scene, State(0.0, each, v, v)) for each in x]
    scan = scene.scan(figure)
    assert scan is not None
    # the same formulas in another order: round-off
    np.testing.assert_allclose(scan.largest(x), expected, rtol=1e-12, atol=1e-12)
    assert len(set(expected)) > 10


def swinging():
    """A weight that flies to the end of a cord, is pulled back at once, and flies off."""
    net = CableNet([[0, 0, 0], [1, 0, 0]], [[0, 1]], {"chaser": [0], "end": [1]}, {"tether": [0]})
    cord = Material(youngs_modulus=1e9, density=1e-3, diameter=1e-3, strength=5.0)
    system = System(net, cord, damping=NoDamping(), masses={"end": 0.1}, restraints=[Restraint("chaser")])
    return system, State.at([[0, 0, 0], [0.95, 0, 0]], [[0, 0, 0], [1.0, 0, 0]])


OPTIONS = {
    "ida": SolverOptions(rtol=1e-8, atol_position=1e-10, atol_velocity=1e-9, max_step=2e-5),
    "explicit": SolverOptions("explicit", max_step=2e-5),
}


class Seen:
    """Counts the states that a watch is shown."""

    count = 0

    def __call__(self, state):
        self.count += 1


@pytest.mark.parametrize("method", ["ida", "explicit"])
def test_events_are_found_as_without_a_scan_and_few_states_are_looked_at(method, monkeypatch):
    """All of them happen and end within the 35 ms of the pull, several of them in one chunk of steps."""
    found, seen = [], []
    for scans in (True, False):
        if not scans:
            monkeypatch.setattr(EventDetector, "scan", lambda self: None)
        system, start = swinging()
        events = [Event("tether_taut"), Event("tether_tension", 1.0), Event("tension_over_strength", 0.3)]
        detector = EventDetector([*events, Event("all_slack")], system)
        seen.append(Seen())
        flight = integrate(
            system, start, [0.0, 0.1], options=OPTIONS[method], events=detector, watch=[seen[-1]]
        )
        assert list(flight)[-1].t == 0.1
        found.append({record["name"]: record["time"] for record in detector.records})
    assert len(found[0]) == 4
    assert None not in found[0].values()
    # the same steps, inside which an instant is located alike: a ten-thousandth of a step is left for round-off
    assert found[0] == pytest.approx(found[1], rel=0, abs=1e-9)
    assert seen[0].count < 0.25 * seen[1].count


@pytest.mark.parametrize(
    "events", [[Event("all_slack", repeat=True)], [Event("tether_taut"), Event("all_slack", repeat=True)]]
)
def test_a_repeated_event_has_every_step_reported(events):
    system, start = swinging()
    detector = EventDetector(events, system)
    detector.begin(start)
    assert detector.needs_every_step
    assert detector.scan() is None


def test_the_scan_of_a_detector_finds_the_first_step_of_any_event():
    """The cord is taut after the steps 3 and 4 of seven, and loaded over 1 N after step 4 alone."""
    system, start = swinging()
    detector = EventDetector([Event("tether_tension", 1.0), Event("tether_taut")], system)
    detector.begin(start)
    x = np.repeat(start.x[None], 7, axis=0)
    assert detector.scan()(x) == len(x)
    pull = system.cords.axial_stiffness[0]
    x[3, 1, 0], x[4, 1, 0] = 1.0 + 0.5 / pull, 1.0 + 2.0 / pull
    assert detector.scan()(x) == 3
    x[3, 1, 0] = 0.9
    assert detector.scan()(x) == 4
