"""How well does the explicit method keep the energy of undamped nets over a million steps?

    python scripts/undamped_drift.py
    python scripts/undamped_drift.py --steps 200000

Two systems, by the step of undamped nets at half of the stable step, and by the velocity Verlet that damped ones take,
at 0.9, 0.5 and 0.3 of it: the reference net of 11 x 11 knots in free flight, and a string of 1 m in 10 pieces, at
strain 1e-3 between its ends, whose middle knot is pulled aside by 2 cm. A row each: steps, time flown, largest change
of the energy over the first, passes over the mean forces per step, and seconds of the processor.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from numpy.random import default_rng

import netdae as nd
from netdae.core.errors import RunError
from netdae.solvers.explicit import kernel, stepper

CORD = nd.Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)
LOSSLESS = kernel.lossless_of


def net() -> tuple[nd.System, nd.State]:
    """The reference flight without damping, from a start disturbed by 1e-10 m."""
    square, start = nd.scaled(nd.CableNet.square(side=5.0, cells=10), (0.4, 0.4, 1.0))
    start = nd.ejected(square, start, "corners", speed=2.5, half_angle_deg=45.0, axis=[0.0, 0.0, 1.0])
    system = nd.System(square, CORD, masses={"corners": 0.5}, damping=nd.NoDamping())
    x = start.x + 1e-10 * default_rng(0).standard_normal(start.x.shape)
    return system, nd.State.at(x, start.v)


def string() -> tuple[nd.System, nd.State]:
    """The taut string."""
    x = np.zeros((11, 3))
    x[:, 0] = np.linspace(0.0, 1.0, 11)
    line = nd.CableNet(x, np.stack((np.arange(10), np.arange(1, 11)), axis=1), {"ends": [0, 10]})
    system = nd.System(line, CORD, damping=nd.NoDamping(), restraints=[nd.Restraint("ends")])
    x = 1.001 * x
    x[5, 2] = 0.02
    return system, nd.State.at(x)


def fly(system: nd.System, start: nd.State, steps: int, share: float, verlet: bool) -> str:
    """Fly and return the row's figures."""
    kernel.lossless_of = (lambda system: []) if verlet else LOSSLESS
    stepper.FRACTIONS["standard"] = share
    solver = stepper.ExplicitSolver(system, system.drive_from(start.x), nd.SolverOptions(method="explicit"))
    a = system.acceleration(0.0, start.x, start.v)
    solver.enter(system, 0.0, np.stack((start.x, start.v)), np.stack((start.v, a)))

    def energy(x: np.ndarray, v: np.ndarray) -> float:
        return system.kinetic_energy(v) + system.elastic_energy(x)

    first, worst, passes, t, stopped = energy(start.x, start.v), 0.0, 0.0, 0.0, ""
    begin = time.process_time()
    try:
        while solver.counts["steps"] < steps:
            last = solver.step(1e9)[-1]
            t, worst = last.t, max(worst, abs(energy(*last.y) / first - 1.0))
            if not verlet:
                passes += solver._kernel._between.values.passes[0]
    except RunError:
        stopped = ", stopped"
    n = solver.counts["steps"]
    seconds = time.process_time() - begin
    per_step = f"{passes / n:.1f}" if passes else "1"
    return f"{n} steps, {t:.3g} s{stopped}: {worst:.2g}, {per_step} passes a step, {seconds:.2g} s"


def main() -> None:
    """Print all rows."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--steps", type=int, default=1_000_000)
    steps = parser.parse_args().steps
    for case in (net, string):
        fly(*case(), 1000, 0.5, False)  # compiles
        fly(*case(), 1000, 0.5, True)
        print(f"{case.__name__}, discrete gradient at 0.5: {fly(*case(), steps, 0.5, False)}")
        for share in (0.9, 0.5, 0.3):
            print(f"{case.__name__}, Verlet at {share}: {fly(*case(), steps, share, True)}")


if __name__ == "__main__":
    main()
