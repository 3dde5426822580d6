"""How a drawcord closes a net, at the tolerances of its speed and at finer ones: does the mouth come to one value?

    python scripts/closing_convergence.py
    python scripts/closing_convergence.py --knots 11 --rings 40 --factors 1 0.1

The flight: a 5 m net of 1 mm cord, 0.5 kg at its corners, 3 % slack, a little bowed and at rest. The same cord runs
through k knots of its border and is wound in from 20 m at 5 m/s, until 0.5 m are left: a mouth that a hand covers.
There the drum's stop holds it, since nothing keeps cables from passing through each other and the corners would fly on
and open the net again. The motor pulls with 10 N at most, which brings the corners to their speed, 0.9 m/s, in 30 ms:
so slowly that the cord does not throw them, and that they come to the middle as the last of it is wound in. (By 50 N
they get twice the speed, pass each other after two thirds of the time, and are jerked by the cord from the other side.)

Each flight starts disturbed by 1e-6 m. For each k and factor on the tolerances: perimeter in m and area in m² of the
mouth, along all knots of its border, when a quarter, a half and three quarters are wound in, and at the end; the
momentum that came up, over Σ m |v|; the energy that is not accounted for, over the motor's work.
Judged are the areas on the way: they shall differ from those of the finest flight of this k by `AGREED` of the area at
the start at most. At the end the cord, and where all knots have rings the border, shall be as long as is left of it;
the finest flight shall account for its energy, but for `ACCOUNTED` of the work. With few rings the border hangs in
loops: its perimeter stays, and the area is that of the loops.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

import netdae as nd
from netdae.system.closing import tightened

SIDE, SLACK = 5.0, 0.97  # m
HAUL = nd.Haul(speed=5.0, force=10.0, final_length=0.5)
CORD = nd.Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)
SHARES = (0.25, 0.5, 0.75)
SETTLES = 0.3  # s after which a drum at its full speed would have been at its stop

AGREED = 0.01
"""Of the area at the start: how far flights at different tolerances may lie apart on the way."""

ACCOUNTED = 0.01
"""Of the motor's work: what the finest flight may lose to the integrator."""

LONGER = 1.1
"""Over what is left of the cord: the longest that it may be at the end, with its stretch and the stop's."""


@dataclass(frozen=True)
class Flown:
    """What a flight came to: perimeters in m and areas in m² of the mouth at the start, on the way and at the end.

    cord : m, way of the cord through its rings at the end; wound_in : m
    momentum : share of Σ m |v|; residual : share of the motor's work
    """

    perimeters: tuple[float, ...]
    areas: tuple[float, ...]
    cord: float
    wound_in: float
    momentum: float
    residual: float
    steps: int
    seconds: float


def fly(cells: int, rings: int, options: nd.SolverOptions, *, seed: int = 0) -> Flown:
    """Close a net of `cells` meshes a side by a cord through `rings` knots of its border."""
    net = nd.CableNet.square(side=SIDE, cells=cells)
    loop = nd.mouth_of(net, "border")
    through = loop[np.linspace(0, len(loop), rings, endpoint=False).round().astype(int)]
    x = net.nodes * [SLACK, SLACK, 1.0]
    x[:, 2] += 1e-3 * (
        x[:, 0] ** 2 + x[:, 1] ** 2
    )  # lying flat and just taut, every cable would be at its kink
    x += 1e-6 * np.random.default_rng(seed).standard_normal(x.shape)
    cord = nd.Drawcord(CORD, HAUL, nodes=tuple(through.tolist()), rings=nd.Rings(fastened=False))
    closed = nd.with_closings(net, nd.State.at(x, np.zeros_like(x)), [cord])
    system = nd.System(
        closed.net,
        {"all": CORD, **closed.materials},
        damping=nd.Dashpot(viscosity_time=1e-5),
        masses={"corners": 0.5},
        restraints=closed.restraints,
        reels=closed.reels,
        forces=closed.forces,
    )
    way = float(closed.net.rest_length[closed.net.cables_of("closing")].sum()) - HAUL.final_length
    times = np.array([0.0, *(share * way / HAUL.speed for share in SHARES), way / HAUL.speed + SETTLES])
    begin = perf_counter()
    flight = nd.simulate(system, closed.start, times, options=options)
    seconds = perf_counter() - begin
    states = list(flight)

    def total(state: nd.State) -> float:
        stored = system.kinetic_energy(state.v) + system.elastic_energy(state.x)
        return float(stored + state.balance.dissipated_energy - state.balance.external_work)

    last = states[-1]
    largest = max(float(system.spatial_mass @ np.linalg.norm(state.v, axis=1)) for state in states)
    return Flown(
        tuple(_length(state.x[loop]) for state in states),
        tuple(nd.vector_area(state.x[loop]) for state in states),
        _length(last.x[through]),
        float(last.x[-1, 0]) / way,
        max(float(np.abs(system.momentum(state.v)).max()) for state in states) / largest,
        (total(last) - total(states[0])) / last.balance.external_work,
        flight.statistics["steps"],
        seconds,
    )


def _length(points: np.ndarray) -> float:
    """Length of the closed line through points (n, 3), m."""
    return float(np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1).sum())


def options_for(factor: float) -> nd.SolverOptions:
    """Those that a scenario with this drawcord would be flown with, its tolerances times `factor`."""
    cord = nd.Drawcord(CORD, HAUL, group="border")
    rtol, position, velocity = tightened(nd.SolverOptions().tolerances, [cord])
    return nd.SolverOptions(
        rtol=factor * rtol, atol_position=factor * position, atol_velocity=factor * velocity
    )


def judged(rings: int, knots: int, flown: Sequence[Flown]) -> list[str]:
    """What is wrong with the flights of one cord, the finest last: nothing, if they come to one value."""
    finest, start = flown[-1], flown[-1].areas[0]
    apart = max(abs(a - b) for one in flown for a, b in zip(one.areas[:-1], finest.areas, strict=False))
    wrong = []
    if apart > AGREED * start:
        wrong.append(f"the areas on the way lie {apart:.2g} m² apart, {apart / start:.1%} of the first")
    for one in flown:
        around = one.perimeters[-1] if rings == knots else one.cord
        if around > LONGER * HAUL.final_length:
            wrong.append(f"the mouth is {around:.3g} m round at the end, not {HAUL.final_length:g} m")
        if one.momentum > 1e-9:  # round-off of some 1e5 steps
            wrong.append(f"a share of {one.momentum:.1g} of the momentum came from nowhere")
    if abs(finest.residual) > ACCOUNTED:
        wrong.append(f"{finest.residual:.1%} of the motor's work is not accounted for in the finest flight")
    return wrong


def _row(rings: int, name: str, one: Flown) -> str:
    mouths = "  ".join(
        f"{length:6.2f} {area:6.3f}" for length, area in zip(one.perimeters[1:], one.areas[1:], strict=True)
    )
    return (
        f"{rings:5d}  {name:>8}  {one.seconds:7.1f} {one.steps:8d}  {mouths}  {one.wound_in:7.2%}"
        f"  {one.momentum:8.0e}  {one.residual:+8.2%}"
    )


def main(arguments: Sequence[str]) -> int:
    """Print the table and what it shows; 1 where the flights of a cord do not come to one value."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--knots", type=int, default=21, help="on a side")
    parser.add_argument(
        "--rings", type=int, nargs="+", metavar="K", help="8 40 80, as far as there are knots"
    )
    parser.add_argument("--factors", type=float, nargs="+", metavar="F", default=[1.0, 0.1, 0.01])
    parser.add_argument(
        "--explicit", action="store_true", help="fly by the explicit method, too, once for each cord"
    )
    parser.add_argument("--quick", action="store_true", help="6 knots on a side, 20 rings, factors 1 and 0.1")
    asked = parser.parse_args(arguments)
    cells = 5 if asked.quick else asked.knots - 1
    border = 4 * cells
    if asked.quick:
        asked.rings, asked.factors = [border], [1.0, 0.1]
    for k in asked.rings or []:
        if not 3 <= k <= border:
            parser.error(f"a cord through {k} rings: the border has {border} knots, give 3 to {border}")
    if min(asked.factors) <= 0 or cells < 1:
        parser.error("give factors above zero, and two knots on a side at least")
    print(
        f"{cells + 1} x {cells + 1} knots; perimeter and area of the mouth where a share of the cord is wound in"
    )
    shares = "".join(f"{share:^15.0%}" for share in SHARES)
    print(f"rings  x tolerance  wall, s    steps  {shares}{'end':^15}  wound in  momentum    energy")
    wrong = 0
    for rings in asked.rings or sorted({min(k, border) for k in (8, 40, 80)}):
        methods = {f"{factor:g}": options_for(factor) for factor in sorted(asked.factors, reverse=True)}
        if asked.explicit:
            methods = {"explicit": nd.SolverOptions("explicit", accuracy="accurate"), **methods}
        flown = []
        for name, options in methods.items():
            try:
                flown.append(fly(cells, rings, options))
            except nd.NetdaeError as error:
                print(f"{rings:5d}  {name:>8}  {error}", flush=True)
                wrong += 1
            else:
                print(_row(rings, name, flown[-1]), flush=True)
        if not flown:
            continue
        found = judged(rings, border, flown)
        wrong += len(found)
        for line in found or [f"they come to one value, within {AGREED:.0%} of the area at the start"]:
            print(f"{rings:5d}  {line}", flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
