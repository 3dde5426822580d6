"""Pictures of the stowed shapes in their canisters, seen from aside and from above, for the manual.

    python3 scripts/in_venv.py python scripts/stowed_pictures.py scripts/pictures

writes stowed_scaled.png, stowed_accordion.png and stowed_star.png: a 5 m square net, its border red, its bullets black,
its canister grey. Needs no display.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv

import netdae as nd
from netdae.core.errors import InputError
from netdae.initial.accordion import accordion
from netdae.initial.canister import Canister
from netdae.initial.star import star

WIDTH, HEIGHT = 480, 480  # pixels of a panel
AWAY = np.array([0.8, -1.4, 0.9])
NET = {"side": 5.0, "cells": 20}


class Pack(NamedTuple):
    """A shape: net, start, canister, and the height of what is seen, m."""

    net: nd.CableNet
    start: nd.State
    canister: Canister | None
    height: float


def packs() -> dict[str, Pack]:
    """The shapes by their names."""
    net = nd.CableNet.square(**NET)
    square, round_ = Canister(depth=0.3, side=0.75), Canister(depth=0.3, diameter=0.6)
    return {
        "scaled": Pack(*nd.scaled(net, [0.1, 0.1, 1.0]), None, 0.9),
        "accordion": Pack(*accordion(net, square, folds=(6, 6)), square, 1.2),
        "star": Pack(*star(net, round_), round_, 0.8),
    }


def draw(pack: Pack, picture: Path) -> None:
    """Write a PNG of a pack, from aside on the left, from above on the right."""
    plotter = pv.Plotter(off_screen=True, shape=(1, 2), window_size=(2 * WIDTH, HEIGHT), border=False)
    plotter.set_background("white")
    for panel, (away, up) in enumerate(((AWAY, (0, 0, 1)), (np.array([0.0, 0.0, 1.0]), (0, 1, 0)))):
        plotter.subplot(0, panel)
        _add_pack(plotter, pack)
        middle = np.array([0.0, 0.0, 0.0 if pack.canister is None else pack.canister.depth / 2])
        plotter.camera_position = [tuple(middle + 5 * away), tuple(middle), up]
        plotter.enable_parallel_projection()
        plotter.camera.parallel_scale = pack.height / 2
        plotter.reset_camera_clipping_range()
    plotter.screenshot(picture)
    plotter.close()


def _add_pack(plotter: Any, pack: Pack) -> None:
    net, x = pack.net, pack.start.x
    for group, color, width in (("inner", "steelblue", 1), ("border", "crimson", 2)):
        cables = net.cables[net.cables_of(group)]
        lines = np.column_stack([np.full(len(cables), 2), cables]).ravel()
        plotter.add_mesh(pv.PolyData(x, lines=lines), color=color, line_width=width)
    plotter.add_points(
        x[net.nodes_of("corners")], color="black", point_size=11, render_points_as_spheres=True
    )
    if pack.canister is not None:
        plotter.add_mesh(_hull(pack.canister), color="grey", line_width=1)


def _hull(canister: Canister) -> Any:
    """Edges of a canister that stands on z = 0."""
    count = 96 if canister.diameter is not None else 4
    angle = 2 * np.pi * (np.arange(count) + 0.5) / count
    reach = canister.width / 2 * (1 if count > 4 else np.sqrt(2))
    rim = reach * np.column_stack([np.cos(angle), np.sin(angle)])
    points = np.concatenate([np.insert(rim, 2, z, axis=1) for z in (0.0, canister.depth)])
    ring = np.column_stack([np.arange(count), np.roll(np.arange(count), -1)])
    posts = np.column_stack([np.arange(count), np.arange(count) + count])[:: max(1, count // 8)]
    lines = np.concatenate([ring, ring + count, posts])
    return pv.PolyData(points, lines=np.column_stack([np.full(len(lines), 2), lines]).ravel())


def main(arguments: list[str]) -> int:
    """Draw all shapes into a folder; the exit code, 2 with one line for a user's mistake."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="folder of the PNGs")
    folder = parser.parse_args(arguments).folder
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with pv.vtk_verbosity("error"):  # where there is no display VTK warns that it draws without
            for name, pack in packs().items():
                draw(pack, folder / f"stowed_{name}.png")
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(f"{folder}: the pictures cannot be written: {error.strerror or error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
