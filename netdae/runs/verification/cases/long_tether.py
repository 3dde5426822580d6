"""A tether along the radius of an orbit, with masses at its ends, pulls with 3 n² m L, m = m₁ m₂/(m₁ + m₂).

From Clohessy and Wiltshire's ẍ = 3 n² x of each mass about their common centre. The stiff cord rings with periods far
below the flight's: whatever gives the forces of the orbit as impulses rings it.
"""

from __future__ import annotations

import numpy as np

from netdae.forces import earth
from netdae.forces.orbit import Orbit
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.runs.verification.case import Case, Check, Curve, Picture, Setting, Source, Study
from netdae.solvers.flight import simulate
from netdae.system.damping import NoDamping
from netdae.system.system import System

n = earth.mean_motion(600e3)
CHASER, BODY, LENGTH = 400.0, 20.0, 1000.0  # kg, kg, m
TENSION = 3 * n * n * CHASER * BODY / (CHASER + BODY) * LENGTH
STIFFNESSES = (1e4, 1e5, 1e6)  # N
CLOHESSY = Source(
    "W. H. Clohessy, R. S. Wiltshire, Terminal guidance system for satellite rendezvous, "
    "Journal of the Aerospace Sciences 27 (1960) 653–658",
    "https://doi.org/10.2514/8.8704",
)


def tether(EA: float) -> tuple[System, State]:
    """Both masses on one cable along x, stretched by its tension; the cord has 1 g."""
    nodes = np.array([[0.0, 0.0, 0.0], [LENGTH, 0.0, 0.0]])
    nodes[:, 0] -= LENGTH * BODY / (CHASER + BODY)
    net = CableNet(
        nodes,
        np.array([[0, 1]]),
        {"chaser": np.array([0]), "body": np.array([1])},
        rest_length=np.array([LENGTH]),
    )
    cord = Material(youngs_modulus=EA / 1e-6, density=1.0, area=1e-6)
    masses = {"chaser": CHASER, "body": BODY}
    system = System(net, cord, masses=masses, damping=NoDamping(), loads=[Orbit(n)])
    return system, State.at(nodes * (1 + TENSION / EA))


def held(setting: Setting, EA: float) -> Study:
    """Tension over 200 s of a tether of that stiffness."""
    system, start = tether(EA)
    times = np.linspace(0.0, 200.0, 201)
    flight = simulate(system, start, times, options=setting.options())
    found = np.array([system.tension(state.x)[0] for state in flight])
    check = Check.of(
        f"tension at EA = {EA:g} N",
        "N",
        found,
        TENSION,
        relative=1e-4,
        reason="the start leaves out the stretch by the strain itself, 7e-6, and the cord's gram, 2e-5 of the masses",
    )
    return Study(
        (check,),
        Picture(
            "time, s",
            "tension, mN",
            (Curve("3 n² m L", times[[0, -1]], [1e3 * TENSION] * 2),),
            (Curve(f"netdae, EA {EA:g} N", times[::10], 1e3 * found[::10]),),
        ),
    )


def fly(setting: Setting) -> Study:
    """Three stiffnesses."""
    studies = [held(setting, EA) for EA in STIFFNESSES]
    return Study(tuple(check for each in studies for check in each.checks), studies[0].picture)


CASE = Case(
    name="long-tether",
    title="Tension of a long tether in orbit",
    statement="A 1000 m tether at rest along the radius has the tension of the gravity gradient, 3 n² m L.",
    sources=(CLOHESSY,),
    fly=fly,
    settings=tuple(
        Setting(method, accuracy=accuracy)
        for method in ("ida", "explicit")
        for accuracy in ("fast", "standard", "accurate")
    ),
    quick=(Setting("ida", accuracy="standard"), Setting("explicit", accuracy="standard")),
)
