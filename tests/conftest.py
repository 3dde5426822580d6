"""Small nets, systems and starts that several tests share."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.random import default_rng

from netdae.initial.scaled import ejected, scaled
from netdae.model.material import Material
from netdae.model.net import CableNet
from netdae.model.state import State
from netdae.runs.verification.nets import line as line
from netdae.solvers.driver import integrate
from netdae.solvers.ida import iteration, record
from netdae.solvers.ida.taut import Damped
from netdae.solvers.options import SolverOptions
from netdae.system.damping import Dashpot
from netdae.system.system import System

CORD = Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)
"""Cord of the reference flight: EA 54.98 kN, 1.09 g/m."""

SOFT = Material(youngs_modulus=1e7, density=1000.0, diameter=2e-3)
"""Cord whose waves take 10 ms a metre, EA 31.4 N: taut and slack phases can be resolved in small tests."""

STIFF = Material(youngs_modulus=1e11, linear_density=1e-9, area=1e-6)
"""Massless cord that hardly stretches, EA 100 kN: strains of 1e-5 under 1 N."""


def pytest_configure(config) -> None:
    """Compile the kernels once, before the workers start: no two of them do so at once."""
    if hasattr(config, "workerinput") or not config.getoption("numprocesses", None):
        return
    net, start = scaled(CableNet.square(side=1.0, cells=2), (0.8, 0.8, 1.0))
    system = System(net, CORD, masses={"corners": 0.1}, damping=Dashpot(viscosity_time=1e-5))
    for method in ("explicit", "ida"):
        list(integrate(system, start, [0.0, 1e-4], options=SolverOptions(method)))


def random_net(seed: int = 0, nodes: int = 12, cables: int = 30) -> CableNet:
    """Connected net of random nodes; at x̄ half of the cables are slack and half taut, by a strain of 2 % or more.

    Node groups: "few", three nodes, and "one", node 0.
    """
    rng = default_rng(seed)
    x = rng.uniform(-1.0, 1.0, (nodes, 3))
    tree = {(int(rng.integers(i)), i) for i in range(1, nodes)}
    pairs = [(i, j) for i in range(nodes) for j in range(i + 1, nodes) if (i, j) not in tree]
    rng.shuffle(pairs)
    joined = rng.permutation([*sorted(tree), *pairs[: cables - len(tree)]])
    length = np.linalg.norm(x[joined[:, 1]] - x[joined[:, 0]], axis=1)
    slackness = np.where(
        np.arange(cables) % 2, rng.uniform(1.03, 1.5, cables), rng.uniform(0.8, 0.97, cables)
    )
    return CableNet(x, joined, {"few": [1, 4, 7], "one": [0]}, rest_length=length * slackness)


def random_velocities(net: CableNet, seed: int = 0, size: float = 1.0) -> np.ndarray:
    """Velocities (n, 3) of `size` m/s."""
    return size * default_rng(seed + 1000).standard_normal((net.node_count, 3))


def reference_flight(
    cells: int = 10,
    *,
    seed: int | None = 0,
    damping=None,
    cord: Material = CORD,
    rotation_deg=(0.0, 0.0, 0.0),
) -> tuple[System, State]:
    """The reference flight of a 5 m net shot by its corners, 11 × 11 nodes unless reported; system and start.

    seed : of the disturbance by 1e-10 m that ends the symmetry; None for the symmetric start
    rotation_deg : turn of the whole scenario, the ejection's axis with it
    """
    net, start = scaled(CableNet.square(side=5.0, cells=cells), (0.4, 0.4, 1.0), rotation_deg=rotation_deg)
    axis = np.cross(net.nodes[cells + 1] - net.nodes[0], net.nodes[1] - net.nodes[0])  # +z where not turned
    start = ejected(net, start, "corners", speed=2.5, half_angle_deg=45.0, axis=axis)
    x = start.x if seed is None else start.x + 1e-10 * default_rng(seed).standard_normal(start.x.shape)
    system = System(net, cord, masses={"corners": 0.5}, damping=damping or Dashpot(viscosity_time=1e-5))
    return system, State.at(x, start.v)


@pytest.fixture
def without_rules_for_taut_cables(monkeypatch):
    """IDA as it is, without the rules of `ida.taut`, which the driver from Python follows by other means."""
    for module in (iteration, record):
        monkeypatch.setattr(module, "damped_of", lambda system, x: Damped(np.zeros(1), np.zeros(1)))
        monkeypatch.setattr(
            module, "stiffness_of", lambda system, x: [np.zeros(len(each.nodes)) for each in system.forces]
        )
