"""The reference flight in Exudyn and MuJoCo, where they are installed (`pip install netdae[benchmark]`).

Both take explicit steps at a part of the stable step of the frozen Verlet, on one thread. The building of
their models is not counted.
"""

from __future__ import annotations

from benchmark_flight import Clock, Flight
from benchmark_verlet import Flown

from netdae.runs.verification import peer_models
from netdae.runs.verification.peer_models import NotAvailable as NotAvailable
from netdae.runs.verification.peer_models import PeerFlight


def _for_peers(flight: Flight, part: float) -> PeerFlight:
    return PeerFlight(
        flight.system,
        flight.x,
        flight.v,
        tuple(flight.times.tolist()),
        part * flight.stable_step(),
        tau=flight.case.tau,
        beta=flight.case.beta,
    )


def fly_exudyn(flight: Flight, part: float, clock: Clock) -> Flown:
    """Exudyn's explicit velocity Verlet."""
    return peer_models.fly_exudyn(_for_peers(flight, part), clock)


def fly_mujoco(flight: Flight, part: float, clock: Clock) -> Flown:
    """MuJoCo's symplectic Euler step."""
    return peer_models.fly_mujoco(_for_peers(flight, part), clock)
