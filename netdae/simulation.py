"""A simulation: a system with its start, its times and its options, ready to fly."""

from __future__ import annotations

from dataclasses import dataclass

from netdae._arrays import FloatArray
from netdae.integration import Integration, Watch, integrate
from netdae.metrics import DeploymentMetrics
from netdae.options import SolverOptions
from netdae.state import State
from netdae.system import System


@dataclass(frozen=True, eq=False)
class Simulation:
    """All that a flight needs.

    times : (k,), s, of the frames; the first is the start's
    metrics : the observer that measures the deployment
    findings : what the author of the mesh file should know
    """

    title: str
    system: System
    start: State
    times: FloatArray
    options: SolverOptions
    metrics: DeploymentMetrics
    findings: tuple[str, ...] = ()

    def integrate(self, watch: tuple[Watch, ...] = ()) -> Integration:
        """Iterator over the States at `times`."""
        return integrate(self.system, self.start, self.times, options=self.options, watch=watch)
