"""A contest: all methods fly one net with one damping, in turns, each at its loosest accurate tolerance.

Accurate is a method whose mean of k flights differs from the mean of the ensemble of K tight runs, at each
quarter of the flight, by no more than 1 cm at each bullet and 1 % in mouth area and in kinetic + elastic
energy, beside the two standard deviations that the chaos of the flight itself puts between two such means:
2 σ √(1/k + 1/K), with σ of the ensemble. The rule is the same for all. A rung is given up after one flight that
is off by more than twice what is allowed; else the mean of all its flights decides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from benchmark_truth import MEMBERS
from benchmark_workers import Crashed, Worker, side_by_side

BULLET, AREA, ENERGY = 0.01, 0.01, 0.01  # m, shares
DOUBT = 2.0
FIRST_SEED = 100  # of the methods' flights: another than those of the ensemble


@dataclass(frozen=True, eq=False)
class Cell:
    """A net of `knots` × `knots` knots with a damping, flown for `end` s.

    begin : s, where in the reference flight it starts; then `state` is the (x, v) there
    scale : by which the net is drawn together at the start of the reference flight
    """

    case: str
    knots: int
    end: float
    begin: float = 0.0
    scale: float = 0.4
    state: tuple[np.ndarray, np.ndarray] | None = None

    @property
    def start(self) -> dict[str, Any]:
        """Arguments of a task that flies it."""
        return {name: getattr(self, name) for name in ("case", "knots", "end", "scale", "state")}

    @property
    def row(self) -> dict[str, Any]:
        """What is reported of it."""
        return {name: getattr(self, name) for name in ("case", "knots", "begin", "end")}


@dataclass(frozen=True, eq=False)
class Truth:
    """Mean and standard deviation (k, 14) of the ensemble of tight runs."""

    mean: np.ndarray
    scatter: np.ndarray

    @classmethod
    def of(cls, workers: list[Worker], cell: Cell) -> Truth:
        """Fly the ensemble."""
        tasks = [("member", {"number": k, **cell.start}) for k in range(MEMBERS)]
        runs = np.array(side_by_side(workers, tasks))
        return cls(runs.mean(axis=0), runs.std(axis=0, ddof=1))

    def _differences(self, difference: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        bullets = np.linalg.norm(difference[:, :12].reshape(len(difference), 4, 3), axis=2)
        relative = np.abs(difference[:, 12:] / self.mean[:, 12:])
        return bullets, relative[:, 0], relative[:, 1]

    def errors(self, measures: np.ndarray) -> dict[str, float]:
        """Largest errors of a mean of flights: bullets in m, area and energy as shares."""
        parts = self._differences(measures - self.mean)
        return dict(zip(("bullets", "area", "energy"), (float(part.max()) for part in parts), strict=True))

    def excess(self, measures: np.ndarray, flights: int) -> float:
        """Largest error over what is allowed to a mean of so many flights: accurate up to 1."""
        band = 2 * np.sqrt(1 / flights + 1 / MEMBERS)
        errors, scatter = self._differences(measures - self.mean), self._differences(self.scatter)
        shares = [
            error / (tolerance + band * sigma)
            for error, tolerance, sigma in zip(errors, (BULLET, AREA, ENERGY), scatter, strict=True)
        ]
        worst = max(float(np.max(share)) for share in shares)
        return worst if np.isfinite(worst) else np.inf

    @property
    def band(self) -> dict[str, float]:
        """Largest standard deviations of single tight runs: bullets in m, area and energy as shares."""
        parts = self._differences(self.scatter)
        return dict(zip(("bullets", "area", "energy"), (float(part.max()) for part in parts), strict=True))


def in_tolerances(errors: dict[str, float]) -> float:
    """Largest of the three errors in units of its tolerance, without any allowance for chaos."""
    return max(errors["bullets"] / BULLET, errors["area"] / AREA, errors["energy"] / ENERGY)


@dataclass(eq=False)
class Entry:
    """A method in a contest.

    state : "flying", and at last "ok", "inaccurate" at its tightest, "limit", "unavailable", "failed", "no time",
        "skipped" where it was over its limit on a smaller net
    place : of the rung it flies at, at first of the loosest that is tried
    limit : s, of one flight, and half of what it may spend in all; in the state "limit" what it took more than
    points : for each rung flown its best seconds, errors and excess
    """

    method: str
    ladder: tuple[Any, ...]
    limit: float
    place: int = 0
    state: str = "flying"
    runs: list[dict[str, Any]] = field(default_factory=list)
    points: list[dict[str, Any]] = field(default_factory=list)
    spent: float = 0.0
    seconds: float | None = None
    projected: float | None = None
    reached: float | None = None
    note: str = ""

    @property
    def chosen(self) -> dict[str, Any] | None:
        """The point of the rung that counts: the last before any that were flown for the plot only."""
        counted = [point for point in self.points if not point["extra"]]
        return counted[-1] if counted and self.state in ("ok", "inaccurate") else None


@dataclass(frozen=True)
class Rules:
    """How often and how long methods fly.

    repeats : flights at the rung that counts, of which the best is taken
    patience : s in all, over which a method's flights are not repeated
    spare : s; methods faster than that fly the tighter rungs too, for the plot
    late : reports whether the time of the whole benchmark is over
    """

    repeats: int
    patience: float
    spare: float
    late: Callable[[], bool]


def contest(workers: list[Worker], cell: Cell, entries: list[Entry], truth: Truth, rules: Rules) -> None:
    """Fly all entries in turns until each has its state."""
    while any(entry.state == "flying" for entry in entries):
        for entry in entries:
            if entry.state == "flying":
                _turn(workers[0], cell, entry, truth, rules)
    for entry in entries:
        while (
            entry.state == "ok"
            and entry.place + 1 < len(entry.ladder)
            and entry.points[-1]["seconds"] < rules.spare
            and not rules.late()
        ):
            entry.place += 1
            run = _flown(workers[0], cell, entry, entry.limit)
            if run["state"] != "ok":
                break
            entry.points.append(_point(entry.ladder[entry.place], [run], truth, extra=True))


def _flown(worker: Worker, cell: Cell, entry: Entry, limit: float) -> dict[str, Any]:
    seed = FIRST_SEED + len(entry.runs)
    rung = entry.ladder[entry.place]
    try:
        return worker.run("fly", method=entry.method, rung=rung, limit=limit, seed=seed, **cell.start)
    except Crashed as reason:
        return {"state": "failed", "note": str(reason)}


def _point(rung: Any, runs: list[dict[str, Any]], truth: Truth, *, extra: bool) -> dict[str, Any]:
    mean = np.mean([run["measures"] for run in runs], axis=0)
    best = min(runs, key=lambda run: run["seconds"])
    return {
        "rung": rung,
        "label": str(rung),
        "seconds": best["seconds"],
        "all_seconds": [run["seconds"] for run in runs],
        "errors": truth.errors(mean),
        "excess": truth.excess(mean, len(runs)),
        "counts": best["counts"],
        "extra": extra,
    }


def _turn(worker: Worker, cell: Cell, entry: Entry, truth: Truth, rules: Rules) -> None:
    """One flight, and what follows from it."""
    accurate = bool(entry.runs) and entry.points[-1]["excess"] <= 1  # this is a repeat
    if rules.late():
        entry.state = "ok" if accurate else "no time"
        return
    limit = min(entry.limit, 2.0 * entry.limit - entry.spent)
    run = _flown(worker, cell, entry, limit)
    if run["state"] != "ok" and accurate:
        entry.state = "ok"
        return
    if run["state"] != "ok":
        entry.state, entry.note = run["state"], run.get("note", "")
        entry.projected, entry.reached = run.get("projected"), run.get("reached")
        # a tighter rung takes no less than the looser one before it
        entry.limit = max(limit, entry.seconds or 0.0)
        return
    entry.spent += run["seconds"]
    if entry.runs:
        entry.points.pop()
    entry.runs.append(run)
    point = _point(entry.ladder[entry.place], entry.runs, truth, extra=False)
    entry.points.append(point)
    entry.seconds = point["seconds"]
    if point["excess"] <= 1:
        if len(entry.runs) >= rules.repeats or entry.spent > rules.patience:
            entry.state = "ok"
    elif point["excess"] <= DOUBT and len(entry.runs) < rules.repeats:
        return
    elif entry.place + 1 == len(entry.ladder):
        entry.state = "inaccurate"
    else:
        entry.place += 1
        entry.runs = []
        if entry.spent >= 1.9 * entry.limit:
            entry.state, entry.limit = "limit", point["seconds"]
