"""What a user of Python names: a closing and its metrics by names of `nd` alone, all of which are there."""

import ast
import importlib
from pathlib import Path

import numpy as np
import pytest

import netdae as nd


def test_a_net_is_closed_and_measured_by_public_names():
    net = nd.CableNet.square(side=2.0, cells=2)
    cord = nd.Material(youngs_modulus=1e8, density=1000.0, diameter=1e-3)
    drawcord = nd.Drawcord(
        cord, nd.Haul(2.0, 20.0, 2.0), group="border", rings=nd.Rings(friction=0.1, fastened=False)
    )
    winch = nd.Winch((0,), (8,), cord, nd.Haul(1.0, 5.0, 1.0))
    rings = nd.rings_through(net, drawcord)
    loop = nd.mouth_of(net, "border")
    np.testing.assert_array_equal(rings, loop)
    assert nd.vector_area(net.nodes[loop]) == 4.0
    closed = nd.with_closings(net, nd.State.at(net.nodes), [drawcord, winch])
    system = nd.System(
        closed.net,
        {"all": cord, **closed.materials},
        damping=nd.Dashpot(viscosity_time=1e-4),
        masses={"corners": 0.1},
        restraints=closed.restraints,
        reels=closed.reels,
        forces=closed.forces,
    )
    metrics = nd.DeploymentMetrics()
    nd.simulate(system, closed.start, [0.0, 0.2], observers=[metrics])
    assert [*metrics.table()] == [*nd.COLUMNS]
    first, last = (dict(zip(nd.COLUMNS, row, strict=True)) for row in metrics.rows)
    assert (first["mouth_area"], last["time"]) == (4.0, 0.2)
    # both motors have wound in at their speed for 0.2 s, less the time in which they spin up, 10 ms
    assert first["closing_length"] - last["closing_length"] == pytest.approx(0.2 * 3.0, rel=0.1)


def test_every_name_is_in_the_module_that_it_is_loaded_from_and_in_the_types():
    source = ast.parse(Path(nd.__file__).read_text(encoding="utf-8"))
    typed = {
        (node.module, alias.name)
        for part in source.body
        if isinstance(part, ast.If)
        for node in part.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    loaded = {(module, name) for module, names in nd._HOMES.items() for name in names}
    assert typed == loaded
    for module, name in loaded:
        assert getattr(nd, name) is getattr(importlib.import_module(module), name)
