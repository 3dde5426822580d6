"""What each accuracy preset keeps on the reference flight, against an ensemble of sharp runs.

    python scripts/accuracy.py

The flight: 5 m square net of 1 mm cord, drawn together to 0.4, four 0.5 kg bullets at 2.5 m/s and 45°,
dashpot 1e-5 s. Past its first snaps the flight is chaotic, so each run starts disturbed by 1e-10 m and is
compared with the mean of the sharp runs, whose own spread stands in the first row.
"""

from __future__ import annotations

import argparse
from time import perf_counter
from typing import NamedTuple

import numpy as np

import netdae as nd


class Figures(NamedTuple):
    """What a flight is judged by, at each of k times."""

    bullets: np.ndarray  # (k, 4, 3), m
    area: np.ndarray  # (k,), m²
    energy: np.ndarray  # (k,), kinetic + elastic, J
    residual: np.ndarray  # (k,), share of the start energy that the integrator took or gave
    steps: int
    seconds: float


def fly(cells: int, end: float, seed: int, options: nd.SolverOptions) -> Figures:
    """One flight from a start disturbed with that seed."""
    net = nd.CableNet.square(side=5.0, cells=cells)
    cord = nd.Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)
    system = nd.System(net, cord, masses={"corners": 0.5}, damping=nd.Dashpot(viscosity_time=1e-5))
    net, start = nd.scaled(net, [0.4, 0.4, 1.0])
    start = nd.ejected(net, start, "corners", speed=2.5, half_angle_deg=45.0)
    noise = 1e-10 * np.random.default_rng(seed).standard_normal(start.x.shape)
    start = nd.State.at(start.x + noise, start.v)
    begin = perf_counter()
    flight = nd.simulate(system, start, np.linspace(0.0, end, 5), options=options)
    seconds = perf_counter() - begin
    loop, frames = nd.mouth_of(net, "border"), list(flight)[1:]
    energy = np.array([system.kinetic_energy(s.v) + system.elastic_energy(s.x) for s in frames])
    total = energy + np.array([s.balance.dissipated_energy for s in frames])
    start_energy = system.kinetic_energy(start.v) + system.elastic_energy(start.x)
    return Figures(
        np.array([s.x[net.nodes_of("corners")] for s in frames]),
        np.array([nd.vector_area(s.x[loop]) for s in frames]),
        energy,
        (total - start_energy) / start_energy,
        flight.statistics["steps"],
        seconds,
    )


def main() -> None:
    """Print one line for the sharp ensemble and one for each preset."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cells", type=int, default=10)
    parser.add_argument("--end", type=float, default=1.0, help="s")
    parser.add_argument("--sharp", type=int, default=4, help="sharp runs")
    parser.add_argument("--runs", type=int, default=3, help="runs of each preset")
    parser.add_argument("--rtol", type=float, default=1e-7, help="of the sharp runs")
    asked = parser.parse_args()
    sharp = nd.SolverOptions(rtol=asked.rtol, atol_position=0.1 * asked.rtol, atol_velocity=10 * asked.rtol)
    truth = [fly(asked.cells, asked.end, seed, sharp) for seed in range(asked.sharp)]
    bullets, area, energy = (np.mean([run[part] for run in truth], axis=0) for part in range(3))
    print(f"{asked.cells} x {asked.cells} meshes, {asked.end:g} s, largest difference at four times")
    print("                    bullets, mm  mouth area, %  energy, %  unaccounted, %   steps       s")
    rows = {"sharp": truth}
    for method in ("ida", "explicit"):
        for accuracy in ("fast", "standard", "accurate"):
            options = nd.SolverOptions(method=method, accuracy=accuracy)
            flown = [fly(asked.cells, asked.end, 100 + seed, options) for seed in range(asked.runs)]
            rows[f"{method}, {accuracy}"] = flown
    for name, runs in rows.items():
        worst = [
            max(1e3 * float(np.linalg.norm(run.bullets - bullets, axis=-1).max()) for run in runs),
            max(100 * float(np.abs(run.area / area - 1).max()) for run in runs),
            max(100 * float(np.abs(run.energy / energy - 1).max()) for run in runs),
            max((100 * float(run.residual[-1]) for run in runs), key=abs),
        ]
        steps = int(np.mean([run.steps for run in runs]))
        seconds = min(run.seconds for run in runs)
        print(
            f"{name:19} {worst[0]:11.2f} {worst[1]:14.2f} {worst[2]:10.2f} {worst[3]:15.3f} {steps:7d} {seconds:7.2f}"
        )


if __name__ == "__main__":
    main()
