"""What netdae aims at, as ratios in one run, and what this run found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from benchmark_growth import exponent, residual_cost


@dataclass(frozen=True)
class Bounds:
    """Seconds that a method took, or, `over`, that it took more than; then with those at its pace."""

    seconds: float
    over: bool = False
    pace: float = 0.0


def seconds_of(outcomes: list[dict[str, Any]], method: str, case: str, knots: int) -> Bounds | None:
    """What a method took at its accurate rung; its limit where it went over it; None if it did not count."""
    for row in outcomes:
        if (row["method"], row["case"], row["knots"]) == (method, case, knots):
            if row["state"] == "ok" or (row["state"] == "inaccurate" and method == "verlet"):
                return Bounds(row["seconds"])
            if row["state"] == "limit":
                return Bounds(row["limit"], over=True, pace=row["projected"] or 0.0)
    return None


# slow method, fast method, damping, sizes, least ratio
AT_LEAST = (
    ("verlet", "explicit", "dashpot", (11,), 1 / 0.35),
    ("verlet", "explicit", "dashpot", (21, 41, 81), 4),
    ("exudyn", "explicit", "dashpot", (21,), 30),
    ("mujoco", "explicit", "dashpot", (21,), 30),
    ("verlet", "ida-toe", "dashpot", (21, 41), 1 / 8),
    ("verlet", "ida", "dashpot", (21, 41), 1 / 16),
    ("bdf", "ida", "dashpot", (11, 21), 10),
    ("radau", "ida", "dashpot", (11, 21), 10),
    ("ida-gmres", "ida", "dashpot", (11, 21), 10),
    ("ida-sparse", "ida", "dashpot", (11,), 100),
    ("verlet", "ida", "rayleigh-1e-3", (21,), 15),
)
GROWTH = (("ida", "dashpot", 1.2), ("ida", "rayleigh-1e-3", 1.5), ("explicit", "dashpot", 1.1))
RESIDUAL = (30e-6, 40e-9)  # s, and s per cable
LARGE_MIB = 4096


def goals_of(found: dict[str, Any]) -> list[dict[str, str]]:
    """Rows with goal, found and met: "yes", "no", "by its pace" of a flight that was stopped, or "?" where
    this run cannot report."""
    rows = []
    for slow, fast, case, sizes, least in AT_LEAST:
        for knots in sizes:
            slower = seconds_of(found["outcomes"], slow, case, knots)
            faster = seconds_of(found["outcomes"], fast, case, knots)
            if slower is not None or faster is not None:
                rows.append(
                    _ratio_row(f"{fast} against {slow}, {case}, {knots} × {knots}", slower, faster, least)
                )
    for method, case, most in GROWTH:
        p = exponent(found["windows"], method, case)
        if p is not None:
            rows.append(
                _row(f"growth of a step, {method}, {case}: knots^{most} at most", f"{p:.2f}", p <= most)
            )
    cost = residual_cost(found["windows"])
    if cost is not None:
        text = f"{cost[0] * 1e6:.1f} µs + {cost[1] * 1e9:.1f} ns"
        met = cost[0] <= RESIDUAL[0] and cost[1] <= RESIDUAL[1]
        rows.append(_row("a residual outside the linear solve: 30 µs + 40 ns a cable at most", text, met))
    for row in found["large"]:
        size = f"{row['knots']} × {row['knots']}"
        memory = row.get("memory_mib", float("inf"))
        text = f"{row['state']}, {row.get('seconds', 0):.0f} s, {memory:.0f} MiB"
        met = row["state"] == "ok" and memory <= LARGE_MIB
        rows.append(_row(f"{row['method']} flies {size} for {row['end']:g} s within 4 GiB", text, met))
    return rows


def _ratio_row(title: str, slow: Bounds | None, fast: Bounds | None, least: float) -> dict[str, str]:
    wanted = f"{least:g} times as fast" if least >= 1 else f"{1 / least:.3g} times the time at most"
    title = f"{title}: {wanted}"
    if slow is None or fast is None or (slow.over and fast.over):
        return {"goal": title, "found": "not measured", "met": "?"}
    ratio = slow.seconds / fast.seconds
    sign = ">" if slow.over else "<" if fast.over else ""
    text = (
        f"{sign} {ratio:.3g}"
        if least >= 1
        else f"{'<' if slow.over else '>' if fast.over else ''} {1 / ratio:.3g}"
    )
    if slow.over and ratio < least <= slow.pace / fast.seconds:
        return {
            "goal": title,
            "found": f"{text.strip()} ({slow.pace / fast.seconds:.3g} at its pace)",
            "met": "by its pace",
        }
    if (slow.over and ratio < least) or (fast.over and ratio >= least):
        return {"goal": title, "found": text.strip(), "met": "?"}
    return _row(title, text.strip(), ratio >= least)


def _row(title: str, text: str, met: bool) -> dict[str, str]:
    return {"goal": title, "found": text, "met": "yes" if met else "no"}
