"""The gallery of the manual: each shipped scenario flown, one picture and one line for it.

    python3 scripts/in_venv.py python scripts/gallery.py scripts/pictures/gallery

Flies every scenario of this folder by the explicit method, with 25 frames. Pictures the
largest mouth, or two thirds of the way where a net is widest at its start; a net that is held, towed or meets a body,
at the end; and one that closes at its widest, half closed and at the end, from ahead. Prints a row of its table each.
"""

from __future__ import annotations

import argparse
import csv
import os
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import netdae as nd
from netdae.model.net import CableNet
from netdae.model.tether import is_own_node
from netdae.runs.folder import RunFolder, fly
from netdae.system.system import System

SCRIPTS = Path(__file__).resolve().parent
FRAMES = 25
LOOK = nd.Look(size=(640, 480), fit="net")
AHEAD = nd.Look(size=(640, 300), fit="net", view=(0.35, 1.4, 0.35))
"""Of the nets that close, which fly along y: one looks into the mouth."""


def shown(script: Path, picture: Path, *, end: float | None) -> str:
    """Fly a scenario, make its picture, and return its row.

    end : s after its begin, to fly shorter; None for the whole flight
    """
    scenario = nd.read_scenario(script)
    simulation = scenario.build()
    begin, last = float(simulation.times[0]), float(simulation.times[-1])
    times = np.linspace(begin, last if end is None else min(begin + end, last), FRAMES)
    # no tolerances: those of a scenario for IDA say nothing to the explicit method
    options = nd.SolverOptions("explicit", accuracy=simulation.options.accuracy)
    simulation = replace(simulation, options=options, times=times)
    with tempfile.TemporaryDirectory() as folder:
        summary = fly(simulation, RunFolder(Path(folder) / "run", scenario))
        if _closes(simulation.system.net):
            nd.render_sheet(
                Path(folder) / "run", picture, frames=_of_closing(Path(folder) / "run"), look=AHEAD
            )
        else:
            meets = simulation.system.body is not None or bool(simulation.system.obstacles)
            time = _telling(summary, held=meets or _held(simulation.system))
            nd.render_picture(Path(folder) / "run", picture, time=time, look=LOOK)
    line = _line_of(summary, drums=len(simulation.system.reels), held=_held(simulation.system))
    return f"| ![{simulation.title}]({_place_of(picture)}) | `{script.name}`: {line} |"


def _closes(net: CableNet) -> bool:
    """Whether cords close the net."""
    return "closing" in net.cable_groups


def _held(system: System) -> bool:
    """Whether nodes of the net itself are held or driven during the whole flight."""
    own = is_own_node(system.net)
    return any(each.permanent and bool(own[each.nodes_of(system.net)].any()) for each in system.restraints)


def _of_closing(folder: Path) -> list[int]:
    """Frames of a net that closes: widest, first under half of that, and last."""
    with (folder / "metrics.csv").open(newline="", encoding="utf-8") as rows:
        # loops of the border may close before the corners do
        area = np.array(
            [max(float(row["mouth_area"]), float(row["corner_area"])) for row in csv.DictReader(rows)]
        )
    widest, last = int(area.argmax()), len(area) - 1
    half = widest + int(np.argmax(area[widest:] < 0.5 * area[widest]))
    return sorted({widest, half, last})


def _telling(summary: dict[str, Any], *, held: bool) -> float:
    """Time of the picture, s."""
    begin, end = summary["solver"]["begin"], summary["deployment"]["end_time"]
    if held:
        return float(end)
    widest = summary["deployment"].get("largest_mouth_area_time", begin)
    return widest if widest > begin + 0.1 * (end - begin) else begin + 2 / 3 * (end - begin)


def _line_of(summary: dict[str, Any], *, drums: int, held: bool) -> str:
    figures, solver = summary["deployment"], summary["solver"]
    knots, begin = summary["net"]["nodes"] - drums, solver["begin"]
    since = f" from {begin:g} s on" if begin else ""
    words = [f"{summary['title']}, {knots} knots, {figures['end_time'] - begin:.3g} s{since}"]
    if held:
        force = np.linalg.norm(np.sum([each["final_reaction"] for each in summary["restraints"]], axis=0))
        words.append(f"held or drawn with {force:.3g} N at the end")
    elif "largest_mouth_area" in figures:
        words.append(
            f"largest mouth {figures['largest_mouth_area']:.3g} m² at {figures['largest_mouth_area_time']:.3g} s"
        )
    if any(event["action"] == "start_closing" for event in summary["events"]):
        words.append(
            f"mouth {figures['final_mouth_area']:.2g} and corners {figures['final_corner_area']:.2g} m² at the end"
        )
    words.append(f"peak tension {figures['peak_tension']:.3g} N")
    happened = [event["name"] for event in summary["events"] if event["time"] is not None]
    if happened:
        words.append(f"events {', '.join(happened)}")
    return "; ".join(words)


def _place_of(picture: Path) -> str:
    """The picture as the manual names it."""
    top, place = SCRIPTS.parent, picture.resolve()
    if not place.is_relative_to(top):
        return str(picture)
    return Path(os.path.relpath(place, top / "netdae" / "manual")).as_posix()


def main(arguments: list[str]) -> int:
    """Make the gallery as the arguments ask; the exit code, 2 with one line for a user's mistake."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="folder of the pictures")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="scenarios by their names, without .toml")
    parser.add_argument("--end", type=float, help="fly so many seconds only")
    options = parser.parse_args(arguments)
    scripts = sorted(SCRIPTS.glob("*.toml"))
    if options.only:
        scripts = [script for script in scripts if script.stem in options.only]
    try:
        options.folder.mkdir(parents=True, exist_ok=True)
        for script in scripts:
            print(shown(script, options.folder / f"{script.stem}.png", end=options.end), flush=True)
    except (nd.NetdaeError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
