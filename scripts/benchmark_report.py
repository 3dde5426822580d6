"""Tables and plot of a benchmark."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from benchmark_contest import in_tolerances
from benchmark_goals import goals_of
from benchmark_growth import exponent, residual_cost
from benchmark_methods import METHODS

LEAST = 1e-2  # of a tolerance; the plot shows smaller errors there


def write(folder: Path, found: dict[str, Any]) -> str:
    """Write benchmark.json, benchmark.md, and the plot as .png and .svg; return the Markdown."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "benchmark.json").write_text(json.dumps(found, indent=1, default=_plain), encoding="utf-8")
    text = markdown(found)
    (folder / "benchmark.md").write_text(text, encoding="utf-8")
    plot(folder, found)
    return text


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else str(value)


def markdown(found: dict[str, Any]) -> str:
    """All tables."""
    parts = [
        "# Benchmark",
        f"{found['date']}, {found['machine']}; "
        + ", ".join(f"{k} {v}" for k, v in found["versions"].items())
        + ".",
        f"One thread each. Flights from starts disturbed by 1e-10 m; a method counts at its loosest rung that keeps "
        "bullets within 1 cm and mouth area and kinetic + elastic energy within 1 % of the mean of eight tight "
        "explicit runs, beside 2 σ √(1/k + 1/8) for the scatter σ of such runs, k flights of the method. "
        f"Best of up to {found['repeats']} flights, in turns with the other methods. "
        f"Limit {found['limit']:g} s a flight, twice that for netdae and the hand-written Verlet; "
        "a flight is given up early where its pace leads past twice its limit. "
        "On larger nets a method begins one rung looser than where it counted on the smaller. "
        "In brackets the ratio to the hand-written Verlet.",
    ]
    for case in _in_order(found, "case"):
        parts += [f"## Wall seconds, {case}", _seconds_table(found, case)]
    rates = [
        f"{row['case']} {row['knots']} × {row['knots']}: {point['counts']['cable_steps_per_second'] / 1e6:.0f}"
        for row in found["outcomes"]
        if row["method"] == "verlet" and (point := row["chosen"])
    ]
    parts += (
        ["Million cable-steps per second of the hand-written Verlet: " + "; ".join(rates) + "."]
        if rates
        else []
    )
    notes = [
        f"- {METHODS[name].title}: {METHODS[name].differs}."
        for name in _in_order(found, "method")
        if METHODS[name].differs
    ]
    parts += ["What differs:", "\n".join(notes)] if notes else []
    if found["cells"]:
        parts += ["## Accuracy at the rung that counts", _accuracy_table(found)]
    if found["windows"]:
        parts += ["## Growth, from mid-flight", _windows_table(found)]
    if found["along"]:
        parts += ["## An explicit step along a flight", _along_table(found)]
    if found["large"]:
        parts += ["## Large nets", _large_table(found)]
    goals = goals_of(found)
    if goals:
        parts += [
            "## Goals",
            _table(("goal", "found", "met"), [(g["goal"], g["found"], g["met"]) for g in goals]),
        ]
    return "\n\n".join(parts) + "\n"


def _in_order(found: dict[str, Any], key: str) -> list[Any]:
    return list(dict.fromkeys(row[key] for row in found["outcomes"]))


def _table(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]
    lines = [[cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in (head, *rows)]
    lines.insert(1, ["-" * width for width in widths])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _short(seconds: float) -> str:
    return f"{seconds:.3g}" if seconds < 100 else f"{seconds:.0f}"


def state_of(row: dict[str, Any], verlet: float | None) -> str:
    """What the table of seconds says of a method in a cell."""
    if row["state"] == "limit":
        text = f"> {_short(row['limit'])}"
        pace = row["projected"]
        if pace is not None and np.isfinite(pace) and pace > 1.2 * row["limit"]:
            text += f" (pace {_short(pace)})"
        return text
    if row["state"] == "skipped":
        return row["note"]
    if row["state"] in ("unavailable", "failed"):
        return "not available" if row["state"] == "unavailable" else "failed"
    if row["state"] == "no time":
        return "no time left"
    ratio = "" if verlet is None else f" ({row['seconds'] / verlet:.3g})"
    return _short(row["seconds"]) + ratio + (" inaccurate" if row["state"] == "inaccurate" else "")


def _span(begin: float, end: float) -> str:
    return f"{end:g} s" + (f" from {begin:g} s" if begin else "")


def _seconds_table(found: dict[str, Any], case: str) -> str:
    rows = [row for row in found["outcomes"] if row["case"] == case]
    cells = sorted({(row["knots"], row["begin"], row["end"]) for row in rows})
    head = ("method", *(f"{knots} × {knots}, {_span(begin, end)}" for knots, begin, end in cells))
    lines = []
    for name in dict.fromkeys(row["method"] for row in rows):
        line = [METHODS[name].title]
        for knots, *_ in cells:
            here = {row["method"]: row for row in rows if row["knots"] == knots}
            verlet = here["verlet"]["seconds"] if "verlet" in here else None
            line.append(state_of(here[name], verlet) if name in here else "–")
        lines.append(tuple(line))
    return _table(head, lines)


def _errors(errors: dict[str, float]) -> tuple[str, str, str]:
    return f"{1e3 * errors['bullets']:.2f}", f"{100 * errors['area']:.2f}", f"{100 * errors['energy']:.2f}"


def _accuracy_table(found: dict[str, Any]) -> str:
    head = ("net", "method", "rung", "flights", "bullets, mm", "area, %", "energy, %", "of allowed", "note")
    lines = []
    for cell in found["cells"]:
        net = f"{cell['case']} {cell['knots']} × {cell['knots']}"
        lines.append(
            (net, "σ of single tight runs", "", str(cell["members"]), *_errors(cell["scatter"]), "", "")
        )
        for row in found["outcomes"]:
            if (row["case"], row["knots"]) != (cell["case"], cell["knots"]):
                continue
            point = row["chosen"] or (row["points"][-1] if row["points"] else None)
            note = row["note"] if row["state"] in ("unavailable", "failed") else ""
            if point is None:
                if note:
                    lines.append((net, row["method"], *[""] * 6, note))
                continue
            note = "" if row["state"] == "ok" else f"{row['state']}: the tightest that ended"
            numbers = (*_errors(point["errors"]), f"{point['excess']:.2f}")
            lines.append((net, row["method"], point["label"], str(len(point["all_seconds"])), *numbers, note))
    return _table(head, lines)


def _windows_table(found: dict[str, Any]) -> str:
    head = ("method", "damping", "net", "cables", "steps", "µs a step", "setups a step", "µs a residual")
    lines = []
    for row in found["windows"]:
        residual = f"{1e6 * row['residual_seconds']:.1f}" if "residual_seconds" in row else ""
        setups = f"{row['setups_per_step']:.2f}" if "setups_per_step" in row else ""
        size = f"{row['knots']} × {row['knots']}"
        numbers = (
            str(row["cables"]),
            str(row["steps"]),
            f"{1e6 * row['step_seconds']:.1f}",
            setups,
            residual,
        )
        lines.append((row["method"], row["case"], size, *numbers))
    texts = []
    for method, case in dict.fromkeys((row["method"], row["case"]) for row in found["windows"]):
        p = exponent(found["windows"], method, case)
        if p is not None:
            texts.append(f"{method}, {case}: a step grows as knots^{p:.2f}.")
    cost = residual_cost(found["windows"])
    if cost is not None:
        texts.append(
            f"A residual takes {cost[0] * 1e6:.1f} µs + {cost[1] * 1e9:.1f} ns a cable at most: with compiled "
            "callbacks all that steps take, solves and SUNDIALS in it, is counted."
        )
    return _table(head, lines) + "\n\n" + " ".join(texts)


def _along_table(found: dict[str, Any]) -> str:
    head = ("net", "from, s", "taut, %", "µs a step")
    return _table(
        head,
        [
            (
                f"{row['knots']} × {row['knots']}",
                f"{row['begin']:g}",
                f"{100 * row['taut']:.1f}",
                f"{1e6 * row['step_seconds']:.2f}",
            )
            for row in found["along"]
        ],
    )


def _large_table(found: dict[str, Any]) -> str:
    head = ("method", "net", "flight, s", "state", "wall seconds", "peak memory of the process, MiB")
    lines = []
    for row in found["large"]:
        size, memory = f"{row['knots']} × {row['knots']}", row.get("memory_mib")
        lines.append(
            (
                row["method"],
                size,
                f"{row['end']:g}",
                row["state"] + (f": {row['note']}" if row.get("note") else ""),
                _short(row["seconds"]) if "seconds" in row else "",
                f"{memory:.0f}" if memory else "",
            )
        )
    return _table(head, lines)


def plot(folder: Path, found: dict[str, Any]) -> None:
    """Work against precision, a panel for each cell in which something flew."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.lines import Line2D

    cells = [c for c in found["cells"] if any(r["points"] for r in _rows(found, c))]
    if not cells:
        return
    columns = min(len(cells), 3)
    lines = -(-len(cells) // columns)
    figure, axes = plt.subplots(
        lines, columns, figsize=(max(4.6 * columns, 9.0), 3.8 * lines + 0.9), squeeze=False
    )
    names = _in_order(found, "method")
    colors = [*(f"C{k}" for k in range(10)), "black", "rosybrown"]
    style = {name: (colors[k % 12], "os^vD<>phX*P"[k % 12]) for k, name in enumerate(names)}
    for axis in axes.flat[len(cells) :]:
        axis.set_axis_off()
    for axis, cell in zip(axes.flat, cells, strict=False):
        axis.axhspan(1e-9, in_tolerances(cell["scatter"]), color="0.92", zorder=0)
        axis.axhline(1.0, color="0.4", linewidth=1, linestyle="--")
        for row in _rows(found, cell):
            color, marker = style[row["method"]]
            if row["points"]:
                x = [point["seconds"] for point in row["points"]]
                y = [max(in_tolerances(point["errors"]), LEAST) for point in row["points"]]
                axis.plot(x, y, color=color, marker=marker, markersize=5, linewidth=1, fillstyle="none")
            if (point := row["chosen"]) and row["state"] == "ok":
                axis.plot(
                    point["seconds"], max(in_tolerances(point["errors"]), LEAST), color=color, marker=marker
                )
            if row["state"] == "limit":
                axis.plot(row["limit"], 1.0, color=color, marker=marker, fillstyle="none")
                axis.annotate("→", (row["limit"], 1.0), color=color)
        axis.set(xscale="log", yscale="log", ylim=(0.8 * LEAST, 1e2))
        left, right = axis.get_xlim()
        axis.set_xlim(
            10 ** np.floor(np.log10(left)), 10 ** np.ceil(np.log10(right))
        )  # whole decades carry labels
        span = _span(cell["begin"], cell["end"])
        axis.set_title(f"{cell['case']}, {cell['knots']} × {cell['knots']}, {span}", fontsize=10)
        axis.set_xlabel("wall seconds")
        axis.set_ylabel("largest error / its tolerance")
    handles = [
        Line2D([], [], color=style[n][0], marker=style[n][1], linewidth=1, label=METHODS[n].title)
        for n in names
    ]
    figure.legend(handles=handles, loc="lower center", ncols=min(4, len(names)), fontsize=8, frameon=False)
    figure.tight_layout(rect=(0, 0.9 / figure.get_figheight(), 1, 1))
    for kind in ("png", "svg"):
        figure.savefig(folder / f"benchmark.{kind}", dpi=130)
    plt.close(figure)


def _rows(found: dict[str, Any], cell: dict[str, Any]) -> list[dict[str, Any]]:
    return [row for row in found["outcomes"] if (row["case"], row["knots"]) == (cell["case"], cell["knots"])]
