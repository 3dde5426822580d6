"""What the worker processes do: flights with a limit, members of the ensemble, windows of flights."""

from __future__ import annotations

import resource
import sys
from typing import Any

import numpy as np
from benchmark_flight import CASES, Clock, Flight, TimeUp
from benchmark_methods import METHODS, STANDARD
from benchmark_others import NotAvailable
from benchmark_truth import fly_tightly, part_of

import netdae as nd

WARM: dict[str, Any] = {
    "knots": 4,
    "seed": 0,
    "end": 2e-3,
    "scale": 1.001,
}  # taut at once: everything is compiled
_warm: set[tuple[str, bool]] = set()


def _warm_up(name: str, case_name: str) -> None:
    case, method = CASES[case_name], METHODS[name]
    key = name, case.beta > 0
    if key not in _warm:
        flight = Flight.of(case=case, toe=method.toe, **WARM)
        method.fly(flight, method.ladder[0], Clock(1e9, flight.end))
        _warm.add(key)


def fly(*, method: str, rung: Any, case: str, limit: float, **start: Any) -> dict[str, Any]:
    """One timed flight; `start` as Flight.of takes it.

    Gives state ("ok", "limit", "unavailable" or "failed") and what belongs to it: seconds, measures (k, 14),
    counts; reached and projected seconds; note.
    """
    chosen = METHODS[method]
    clock = Clock(limit, start["end"])
    try:
        _warm_up(method, case)
        flight = Flight.of(case=CASES[case], toe=chosen.toe, **start)
        positions, velocities, counts = chosen.fly(flight, rung, clock)
    except TimeUp:
        found = {"seconds": clock.seconds, "reached": clock.reached, "projected": clock.projected}
        return {"state": "limit", **found}
    except NotAvailable as reason:
        return {"state": "unavailable", "note": str(reason)}
    except Exception as reason:  # another package's failure is a result, not the end of the benchmark
        return {"state": "failed", "note": f"{type(reason).__name__}: {reason}".splitlines()[0][:200]}
    measures = np.array([flight.measures(x, v) for x, v in zip(positions, velocities, strict=True)])
    over = clock.seconds > limit
    return {
        "state": "limit" if over else "ok",
        "seconds": clock.seconds,
        "reached": flight.end,
        "projected": clock.seconds,
        "measures": measures,
        "counts": counts,
    }


def member(*, number: int, case: str, **start: Any) -> np.ndarray:
    """Measures (k, 14) of one member of the ensemble of tight runs."""
    flight = Flight.of(case=CASES[case], seed=number, **start)
    positions, velocities, _ = fly_tightly(flight, part_of(number), Clock(1e9, flight.end))
    return np.array([flight.measures(x, v) for x, v in zip(positions, velocities, strict=True)])


def midflight(*, case: str, **start: Any) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities at the end of a flight of the tight ensemble's kind at half the stable step."""
    flight = Flight.of(case=CASES[case], seed=0, **start)
    positions, velocities, _ = fly_tightly(flight, 0.5, Clock(1e9, flight.end))
    return positions[-1], velocities[-1]


def window(
    *, method: str, case: str, knots: int, x: np.ndarray, v: np.ndarray, length: float, limit: float
) -> dict[str, Any] | None:
    """Statistics of one of netdae's methods at standard over `length` seconds from (x, v)."""
    _warm_up(method, case)
    options: dict[str, Any] = {"accuracy": "standard"}
    if method == "explicit":
        options["method"] = "explicit"
    flight = Flight.of(knots, CASES[case], seed=0, end=length)
    clock = Clock(limit, length)
    run = nd.integrate(
        flight.system,
        nd.State.at(x, v),
        np.linspace(0.0, length, 5),
        options=nd.SolverOptions(**options),
    )
    taut = []
    for state in run:
        taut.append(float((flight.system.strain(state.x) > 0).mean()))
        try:
            clock.check(state.t)
        except TimeUp:
            return None
    statistics = dict(run.statistics)
    statistics["cables"] = flight.system.net.cable_count
    statistics["taut"] = float(np.mean(taut))
    return statistics


def large(*, method: str, knots: int, end: float, limit: float) -> dict[str, Any]:
    """A flight of a large net, with the peak memory of the whole process in MiB."""
    rung = "standard" if method == "explicit" else STANDARD
    result = fly(method=method, rung=rung, case="dashpot", limit=limit, knots=knots, seed=0, end=end)
    kilo = 1024 if sys.platform != "darwin" else 1024**2  # ru_maxrss is in KiB, on macOS in bytes
    return {**result, "memory_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / kilo}
