"""What of a shot depends on how many pieces each cord of the net is cut into, and what does not.

    python scripts/mesh_convergence.py
    python scripts/mesh_convergence.py --quick

The flight: a net of 5 x 5 meshes of 1 m, of 1 mm cord, drawn together to 0.4, four 0.5 kg bullets at 2.5 m/s and 45°,
dashpot 1e-5 s, by the explicit method. It is the same net each time, of the same mass; its cords are cut into 1, 2, 4
and 8 pieces, which makes 6, 11, 21 and 41 knots along a side. Past its first snaps the flight is chaotic: several
flights of each start disturbed by 1e-6 m, and a figure is reported as their mean ± standard deviation.

A mean has the uncertainty std/√N. Where two rows differ by less than that, more pieces would show nothing but chance.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator, Sequence
from time import perf_counter
from typing import NamedTuple

import numpy as np

import netdae as nd

SIDE, CELLS = 5.0, 5  # m
PIECES = (1, 2, 4, 8)
MEMBERS = 6
END = 1.7  # s, a little after the widest mouth
DISTURBANCE = 1e-6  # m
CORD = nd.Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)
OPTIONS = nd.SolverOptions(method="explicit", accuracy="standard")


class Figures(NamedTuple):
    """What is reported of a flight."""

    peak_tension: float  # N
    usual_tension: float  # N, not passed for 99.9 % of the time
    mouth_area: float  # m², the largest
    widest_time: float  # s
    end_energy: float  # kinetic + elastic at the end over that of the start


HEADS = ("peak tension, N", "tension 99.9 %, N", "largest mouth, m²", "at, s", "energy at the end, %")
DIGITS = (1, 2, 2, 3, 2)


def fly(pieces: int, seed: int, *, end: float = END) -> Figures:
    """One flight of the net, its cords cut into `pieces`, from a start disturbed with that seed."""
    net = nd.CableNet.square(side=SIDE, cells=CELLS, subdivide=pieces)
    net, start = nd.scaled(net, [0.4, 0.4, 1.0])
    start = nd.ejected(net, start, "corners", speed=2.5, half_angle_deg=45.0)
    noise = DISTURBANCE * np.random.default_rng(seed).standard_normal(start.x.shape)
    start = nd.State.at(start.x + noise, start.v)
    system = nd.System(net, CORD, masses={"corners": 0.5}, damping=nd.Dashpot(viscosity_time=1e-5))
    metrics = nd.DeploymentMetrics(mouth="border")
    flight = nd.simulate(system, start, np.linspace(0.0, end, 5), observers=[metrics], options=OPTIONS)
    reported, last = metrics.summary(), flight[-1]
    energy = system.kinetic_energy(last.v) + system.elastic_energy(last.x)
    before = system.kinetic_energy(start.v) + system.elastic_energy(start.x)
    return Figures(
        reported["peak_tension"],
        reported["tension_quantile_99_9"],
        reported["largest_mouth_area"],
        reported["largest_mouth_area_time"],
        100 * energy / before,
    )


def rows(pieces: Iterable[int], members: int, *, end: float = END) -> Iterator[str]:
    """The table, a line each as it comes."""
    yield f"| pieces a cord | knots along a side | {' | '.join(HEADS)} | s a flight |"
    yield "| --- | --- |" + " --- |" * (len(HEADS) + 1)
    for count in pieces:
        began = perf_counter()
        figures = np.array([fly(count, seed, end=end) for seed in range(members)])
        seconds = (perf_counter() - began) / members
        mean, std = figures.mean(axis=0), figures.std(axis=0, ddof=1)
        reported = [f"{m:.{d}f} ± {s:.{d}f}" for m, s, d in zip(mean, std, DIGITS, strict=True)]
        yield f"| {count} | {CELLS * count + 1} | {' | '.join(reported)} | {seconds:.2f} |"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pieces", nargs="+", type=int, default=[*PIECES], help="that a cord is cut into")
    parser.add_argument("--members", type=int, default=MEMBERS, help="flights of each, 2 or more")
    parser.add_argument("--quick", action="store_true", help="1 and 2 pieces, two short flights each")
    reported = parser.parse_args(arguments)
    if reported.members < 2 or min(reported.pieces) < 1:
        parser.error("give 2 members and 1 piece at least")
    fly(1, 0, end=0.01)  # compiles
    lines = rows((1, 2), 2, end=0.2) if reported.quick else rows(reported.pieces, reported.members)
    for line in lines:
        print(line, flush=True)


if __name__ == "__main__":
    main()
