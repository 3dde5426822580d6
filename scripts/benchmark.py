"""Netdae against other ways to fly the same net, in one run: a table and a work-precision plot.

    python scripts/benchmark.py -o out/benchmark            # under 12 minutes on a quiet machine with two cores
    python scripts/benchmark.py -o out/full --full          # all methods with all dampings at all sizes: an hour
    python scripts/benchmark.py -o out/large --large        # 161 × 161 knots for 0.1 s by each of netdae's methods
    python scripts/benchmark.py -o out/b --sizes 21 --cases dashpot --methods verlet explicit ida

Exudyn and MuJoCo take part where they are installed: pip install netdae[benchmark].
"""

from __future__ import annotations

import argparse
import os
import platform
from collections.abc import Iterator
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter, strftime
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"  # before numpy and SuperLU_MT are imported; the workers inherit it

from benchmark_contest import Cell, Entry, Rules, Truth, contest
from benchmark_flight import CASES
from benchmark_growth import ALONG, LENGTH, Midflights, along_flight, large_nets, windows
from benchmark_methods import METHODS
from benchmark_report import write
from benchmark_truth import MEMBERS
from benchmark_workers import Worker

SIZES = (11, 21, 41, 81)
STRONG = "rayleigh-1e-3"
LARGE_LIMIT = 900.0  # s
MIDDLE = (
    0.5  # s; where the largest nets start, in the lively middle of the flight: their first tenths are slack
)
# damping, knots, begin and end, in order of weight: what comes last is left out when the budget is spent;
# None stands for the growth
PLAN: tuple[tuple[str, int, float, float] | None, ...] = (
    ("dashpot", 11, 0.0, 1.0),
    ("dashpot", 21, 0.0, 1.0),
    (STRONG, 11, 0.0, 1.0),
    (STRONG, 21, 0.0, 1.0),
    ("dashpot", 41, 0.0, 1.0),
    None,
    ("dashpot", 81, MIDDLE, 0.05),
    ("rayleigh-1e-4", 11, 0.0, 1.0),
    ("rayleigh-1e-5", 11, 0.0, 1.0),
    ("rayleigh-1e-4", 21, 0.0, 1.0),
    ("rayleigh-1e-5", 21, 0.0, 1.0),
    *((case, 41, MIDDLE, 0.1) for case in (STRONG, "rayleigh-1e-4", "rayleigh-1e-5")),
    *((case, 81, MIDDLE, 0.02) for case in (STRONG, "rayleigh-1e-4", "rayleigh-1e-5")),
)
HALF = 9  # of the plan, which is flown unless --full


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, default=Path("out/benchmark"))
    parser.add_argument("--sizes", type=int, nargs="+", help="knots a side; all of 11 21 41 81 by default")
    parser.add_argument("--cases", nargs="+", choices=CASES, help="dampings; all by default")
    parser.add_argument(
        "--methods", nargs="+", choices=METHODS, help="all by default, the slow ones not everywhere"
    )
    parser.add_argument("--repeats", type=int, default=3, help="flights of which the best counts")
    parser.add_argument("--limit", type=float, default=20.0, help="s, of one flight; twice that for netdae")
    parser.add_argument("--budget", type=float, default=660.0, help="s, after which no further flight begins")
    parser.add_argument("--full", action="store_true", help="fly all there is, whatever the budget")
    parser.add_argument(
        "--end",
        type=float,
        help="s of flight; 1 s by default, on the largest nets a part of it",
    )
    parser.add_argument("--no-growth", action="store_true", help="leave out the cost of steps and residuals")
    parser.add_argument("--large", action="store_true", help="only fly 161 × 161 knots for 0.1 s")
    parser.add_argument("--quick", action="store_true", help="4 × 4 knots for 0.02 s: does the script work?")
    return parser.parse_args()


def main() -> None:
    """Fly, print, write."""
    asked = arguments()
    begin = perf_counter()
    found: dict[str, Any] = {
        "date": strftime("%Y-%m-%d"),
        "machine": f"{os.cpu_count()} × {_processor()}",
        "versions": _versions(),
        "limit": asked.limit,
        "repeats": asked.repeats,
        "cells": [],
        "outcomes": [],
        "windows": [],
        "along": [],
        "large": [],
    }
    if asked.large:
        found["large"] = large_nets(
            11 if asked.quick else 161, 0.01 if asked.quick else 0.1, 15 * asked.limit
        )
    else:
        workers = [Worker(), Worker()]
        begins, scale = (0.005, 0.995) if asked.quick else (MIDDLE, 0.4)
        midflights = Midflights(workers, begin=begins, scale=scale)
        try:
            for plan in plans(asked):
                _say(begin, "growth" if plan is None else f"{plan.case} {plan.knots} × {plan.knots}")
                if plan is None:
                    found["windows"] = _windows(workers, midflights, asked, begin)
                    knots, times = (4, (0.004, 0.008)) if asked.quick else ALONG
                    if not asked.sizes or knots in asked.sizes:
                        short = 0.002 if asked.quick else LENGTH
                        limits = {"length": short, "limit": asked.limit}
                        found["along"] = along_flight(workers, knots, times, scale=scale, **limits)
                else:
                    _compete(workers, midflights, plan, asked, begin, found)
        finally:
            for worker in workers:
                worker.end()
    found["wall_seconds"] = perf_counter() - begin
    print(write(asked.output, found))
    _say(begin, f"written to {asked.output}")


def plans(asked: argparse.Namespace) -> Iterator[Cell | None]:
    """The cells to fly, and None for the growth."""
    if asked.quick:
        for case in asked.cases or ("dashpot", "rayleigh-1e-4"):
            yield Cell(case, 4, asked.end or 0.02, scale=0.995)
        if not asked.no_growth:
            yield None
        return
    whole = asked.full or asked.sizes or asked.cases
    for plan in PLAN if whole else PLAN[:HALF]:
        if plan is None:
            if not asked.no_growth:
                yield None
            continue
        case, knots, start, end = plan
        if case in (asked.cases or CASES) and knots in (asked.sizes or SIZES):
            yield Cell(case, knots, asked.end or end, 0.0 if asked.end else start)
    for knots in sorted(set(asked.sizes or ()) - {*SIZES}):
        for case in asked.cases or CASES:
            yield Cell(case, knots, asked.end or 1.0)


def _methods(cell: Cell, asked: argparse.Namespace) -> list[str]:
    damping = {"dashpot": "dashpot", STRONG: "strong"}.get(cell.case, "weak")
    everywhere = asked.quick or asked.full
    chosen = [name for name, method in METHODS.items() if everywhere or damping in method.dampings]
    return list(asked.methods or chosen)


def _compete(
    workers: list[Worker],
    midflights: Midflights,
    cell: Cell,
    asked: argparse.Namespace,
    begin: float,
    found: dict[str, Any],
) -> None:
    entries = [_entry(name, cell, asked.limit, found["outcomes"]) for name in _methods(cell, asked)]

    def late() -> bool:
        return not asked.full and perf_counter() - begin > asked.budget

    members = 0
    if late():
        for entry in entries:
            entry.state = "no time"
    else:
        if cell.begin:
            cell = replace(cell, state=midflights.of([cell.case], cell.knots)[0])
        truth = Truth.of(workers, cell)
        members = MEMBERS
        spare = 1.0 if cell.knots <= 21 else 0.0
        rules = Rules(asked.repeats, asked.limit / 4, spare, late)
        contest(workers, cell, entries, truth, rules)
        found["cells"].append({**cell.row, "members": members, "scatter": truth.band})
    for entry in entries:
        row = {name: value for name, value in vars(entry).items() if name not in ("runs", "ladder", "place")}
        found["outcomes"].append({**cell.row, **row, "chosen": entry.chosen})


def _entry(name: str, cell: Cell, limit: float, outcomes: list[dict[str, Any]]) -> Entry:
    method = METHODS[name]
    entry = Entry(name, method.ladder, 2 * limit if method.own else limit)
    for row in outcomes:
        if (row["method"], row["case"]) == (name, cell.case) and row["knots"] < cell.knots:
            if row["state"] == "limit":
                entry.state = "skipped"
                entry.note = f"> {row['limit']:.3g} at {row['knots']} × {row['knots']} already"
            elif row["state"] in ("skipped", "unavailable"):
                entry.state, entry.note = row["state"], row["note"]
            elif row["state"] == "ok":
                entry.place = max(0, method.ladder.index(row["chosen"]["rung"]) - 1)
    return entry


def _windows(
    workers: list[Worker], midflights: Midflights, asked: argparse.Namespace, begin: float
) -> list[dict[str, Any]]:
    return windows(
        workers,
        (3, 4) if asked.quick else asked.sizes or SIZES,
        midflights,
        length=0.002 if asked.quick else LENGTH,
        limit=asked.limit,
        late=lambda: not asked.full and perf_counter() - begin > asked.budget,
    )


def _say(begin: float, text: str) -> None:
    print(f"[{perf_counter() - begin:5.0f} s] {text}", flush=True)


def _processor() -> str:
    cpus = Path("/proc/cpuinfo")
    lines = cpus.read_text(encoding="utf-8").splitlines() if cpus.is_file() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def _versions() -> dict[str, str]:
    found = {"Python": platform.python_version()}
    for package in ("netdae", "numpy", "scipy", "numba", "scikit-sundae", "exudyn", "mujoco"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


if __name__ == "__main__":
    main()
