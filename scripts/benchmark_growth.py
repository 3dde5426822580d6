"""How the cost of netdae's methods grows with the net, and what a residual costs outside the linear solve.

Steps are timed over a short window from the middle of the flight, where a tenth of the cables is taut: the
state there comes from an explicit run. Symbols: n knots, m cables.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from benchmark_workers import Crashed, Worker, side_by_side

LENGTH = 0.02  # s
REPEATS = 2
LONGER = 5  # times the length, for the explicit method: its steps are short
SERIES = (("ida", "dashpot"), ("ida", "rayleigh-1e-3"), ("explicit", "dashpot"))
RESIDUAL = ("ida", "dashpot")
ALONG = (
    41,
    (0.05, 0.2, 0.35, 0.5, 0.65, 0.8, 0.95),
)  # knots a side, and s: where the share of taut cables is read


class Midflights:
    """States (x, v) in the middle of flights, each computed once."""

    def __init__(self, workers: list[Worker], *, begin: float, scale: float) -> None:
        self._workers, self._begin, self._scale = workers, begin, scale
        self._states: dict[tuple[str, int], Any] = {}

    def of(self, cases: Sequence[str], knots: int) -> list[Any]:
        """The states of a net with several dampings, computed side by side."""
        start = {"knots": knots, "end": self._begin, "scale": self._scale}
        new = [case for case in cases if (case, knots) not in self._states]
        found = side_by_side(self._workers, [("midflight", {"case": case, **start}) for case in new])
        self._states.update({(case, knots): state for case, state in zip(new, found, strict=True)})
        return [self._states[case, knots] for case in cases]


def windows(
    workers: list[Worker],
    sizes: Sequence[int],
    midflights: Midflights,
    *,
    length: float,
    limit: float,
    late: Callable[[], bool],
) -> list[dict[str, Any]]:
    """Seconds per step, and per residual, of netdae's methods at several sizes, the best of a few windows."""
    cases = sorted({case for _, case in SERIES})
    found = []
    for knots in sizes:
        if late():
            break
        states = midflights.of(cases, knots)
        for method, case in SERIES:
            x, v = states[cases.index(case)]
            runs: list[dict[str, Any]] = []
            for _ in range(REPEATS):
                if late() or (runs and runs[0]["wall_seconds"]["total"] > limit / REPEATS):
                    break
                span = length * (LONGER if method == "explicit" else 1)
                arguments = {"method": method, "case": case, "knots": knots, "length": span}
                try:
                    run = workers[0].run("window", **arguments, x=x, v=v, limit=limit)
                except Crashed:
                    run = None
                if run is None:
                    break
                runs.append(run)
            if runs:
                found.append({"method": method, "case": case, "knots": knots, **_best(runs)})
    return found


def along_flight(
    workers: list[Worker], knots: int, begins: Sequence[float], *, scale: float, length: float, limit: float
) -> list[dict[str, Any]]:
    """Seconds per explicit step, and the share of taut cables, at several times of one flight."""
    found = []
    for begin in begins:
        x, v = Midflights(workers, begin=begin, scale=scale).of(["dashpot"], knots)[0]
        arguments = {"method": "explicit", "case": "dashpot", "knots": knots, "length": length}
        runs = [workers[0].run("window", **arguments, x=x, v=v, limit=limit) for _ in range(REPEATS)]
        if None in runs:
            break
        best = _best(runs)
        found.append({"knots": knots, "begin": begin, "taut": runs[0]["taut"], **best})
    return found


def _best(runs: list[dict[str, Any]]) -> dict[str, Any]:
    best = min(runs, key=lambda run: run["wall_seconds"]["total"])
    steps = best["steps"]
    result = {
        "cables": best["cables"],
        "steps": steps,
        "step_seconds": best["wall_seconds"]["total"] / max(steps, 1),
    }
    if "residuals" in best:
        # compiled callbacks have no clock of their own: then all that the steps took, solves and SUNDIALS in it
        part = "residual" if "residual" in best["wall_seconds"] else "steps"
        per_run = [run["wall_seconds"][part] / max(run["residuals"], 1) for run in runs]
        result["residual_seconds"] = min(per_run)
        result["setups_per_step"] = best["setups"] / max(steps, 1)
    return result


def exponent(found: list[dict[str, Any]], method: str, case: str) -> float | None:
    """P of seconds per step ~ knots^p, fitted from 21 knots a side up; None without two sizes."""
    rows = [row for row in found if (row["method"], row["case"]) == (method, case) and row["knots"] >= 21]
    if len(rows) < 2:
        return None
    n = np.log([row["knots"] ** 2 for row in rows])
    return float(np.polyfit(n, np.log([row["step_seconds"] for row in rows]), 1)[0])


def residual_cost(found: list[dict[str, Any]]) -> tuple[float, float] | None:
    """A and b of seconds per residual = a + b m, fitted in shares from 11 knots a side up; None without two sizes.

    With compiled callbacks they are an upper bound, see `_best`.
    """
    rows = [row for row in found if (row["method"], row["case"]) == RESIDUAL and row["knots"] >= 11]
    if len(rows) < 2:
        return None
    seconds = np.array([row["residual_seconds"] for row in rows])
    b, a = np.polyfit([row["cables"] for row in rows], seconds, 1, w=1 / seconds)
    return float(a), float(b)


def large_nets(knots: int, end: float, limit: float) -> list[dict[str, Any]]:
    """A short flight of a large net by each of netdae's methods, each in a process of its own."""
    found = []
    for method in ("explicit", "ida", "ida-toe"):
        worker = Worker()
        try:
            result = worker.run("large", method=method, knots=knots, end=end, limit=limit)
        except Crashed as reason:
            result = {"state": "failed", "note": str(reason)}
        worker.end()
        result.pop("measures", None)
        found.append({"method": method, "knots": knots, "end": end, **result})
    return found
