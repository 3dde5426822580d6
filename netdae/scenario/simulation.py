"""A simulation: a system with its start, its times and its options, ready to fly."""

from __future__ import annotations

from dataclasses import dataclass

from netdae.core.arrays import FloatArray
from netdae.events.detector import EventDetector
from netdae.initial.ejection import Launch
from netdae.model.state import State
from netdae.output.metrics import DeploymentMetrics
from netdae.solvers.driver import Integration, Watch, integrate
from netdae.solvers.options import SolverOptions
from netdae.solvers.snapshot import Memory
from netdae.system.system import System


@dataclass(frozen=True, eq=False)
class Simulation:
    """All that a flight needs.

    times : (k,), s, of the frames; the first is the start's
    metrics : the observer that measures the deployment
    findings : what the author of the mesh file should know
    events : finds what happens during the flight; None where nothing is looked for
    launch : the bullets that are shot
    notes : what was set for the flight beside what its scenario says, and what is unusual in it, see `plausibility`
    """

    title: str
    system: System
    start: State
    times: FloatArray
    options: SolverOptions
    metrics: DeploymentMetrics
    findings: tuple[str, ...] = ()
    events: EventDetector | None = None
    launch: Launch | None = None
    notes: tuple[str, ...] = ()

    def integrate(self, watch: tuple[Watch, ...] = (), *, resume: Memory | None = None) -> Integration:
        """Iterator over the States at `times`; over those that are left where a flight's memory is gone on from."""
        return integrate(
            self.system,
            self.start,
            self.times,
            options=self.options,
            watch=watch,
            events=self.events,
            resume=resume,
        )

    def compile(self) -> None:
        """Compile the kernels of the flight, once for all processes that fly it."""
        begin, end = float(self.times[0]), float(self.times[-1])
        for _ in integrate(
            self.system, self.start, [begin, begin + 1e-6 * (end - begin)], options=self.options
        ):
            pass
