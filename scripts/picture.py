"""Picture of a flight: several of its frames side by side, cables coloured by tension, slack ones grey.

    python3 scripts/in_venv.py python scripts/picture.py out/corner_shot scripts/pictures/corner_shot.png

All panels have the same scale, each looks at the middle of its net. The colours end at the tension that 98 % of
the cables stay below in every panel. Needs no display.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv

from netdae.errors import InputError
from netdae.vtk import read_frame, read_series

WIDTH, LABEL = 440, 60  # pixels: width of a panel; height of the time above the net and of the scale below
SHARE = 0.98  # a few snapping cables would leave all others one colour
AWAY = np.array([0.95, -1.4, 0.7]) / np.linalg.norm([0.95, -1.4, 0.7])
RIGHT = np.cross([0.0, 0.0, 1.0], AWAY) / np.linalg.norm(np.cross([0.0, 0.0, 1.0], AWAY))
UP = np.cross(AWAY, RIGHT)


def draw(folder: Path, picture: Path, *, frames: int) -> None:
    """Write a PNG of `frames` frames, evenly spread over the series in `folder`."""
    series = read_series(folder / "series.pvd")
    if not series:
        raise InputError(f"{folder}: its series has no frames yet: wait for the flight")
    chosen = [series[i] for i in np.linspace(0, len(series) - 1, frames).round().astype(int)]
    grids = [(time, read_frame(file)) for time, file in chosen]
    seen = [grid.points @ np.column_stack([RIGHT, UP, AWAY]) for _, grid in grids]
    wide, high, _ = np.max([np.ptp(points, axis=0) for points in seen], axis=0)
    net = WIDTH * 0.92  # pixels across the widest net
    height = int(np.clip(net * high / wide, 0.4 * WIDTH, 1.2 * WIDTH)) + 2 * LABEL
    scale = max(wide / net, high / (height - 2 * LABEL))  # m a pixel
    peak = max(float(np.quantile(grid.cell_data["tension"], SHARE)) for _, grid in grids) or 1.0
    plotter = pv.Plotter(
        off_screen=True, shape=(1, frames), window_size=(WIDTH * frames, height), border=False
    )
    plotter.set_background("white")
    for panel, ((time, grid), points) in enumerate(zip(grids, seen, strict=True)):
        plotter.subplot(0, panel)
        _add_net(plotter, grid, peak, radius=scale, last=panel == frames - 1)
        plotter.add_text(f"{time:.2f} s", position="upper_left", font_size=10, color="black")
        across, up, away = (points.min(axis=0) + points.max(axis=0)) / 2
        centre = across * RIGHT + up * UP + away * AWAY
        plotter.camera_position = [tuple(centre + 3 * max(wide, high) * AWAY), tuple(centre), (0, 0, 1)]
        plotter.enable_parallel_projection()
        plotter.camera.parallel_scale = scale * height / 2
        plotter.reset_camera_clipping_range()
    picture.parent.mkdir(parents=True, exist_ok=True)
    plotter.screenshot(picture)
    plotter.close()


def _add_net(plotter: Any, grid: Any, peak: float, *, radius: float, last: bool) -> None:
    taut = grid.cell_data["taut"] == 1
    if (~taut).any():
        plotter.add_mesh(grid.extract_cells(~taut), color="grey", line_width=1)
    if taut.any():
        plotter.add_mesh(
            grid.extract_cells(taut).extract_surface(algorithm=None).tube(radius=radius),
            scalars="tension",
            clim=(0, peak),
            cmap="plasma",
            show_scalar_bar=last,
            scalar_bar_args={
                "title": f"tension, N ({SHARE:.0%} below)".replace("%", " %"),
                "color": "black",
                "n_labels": 2,
                "fmt": "%.3g",
                "height": 0.1,
                "title_font_size": 16,
                "label_font_size": 14,
            },
        )
    heavy = grid.point_data["mass"] > 0.1 * grid.point_data["mass"].max()
    bullets = grid.extract_points(heavy, include_cells=False)
    plotter.add_mesh(bullets, color="black", point_size=9, render_points_as_spheres=True)


def main(arguments: list[str]) -> int:
    """Draw as the arguments ask; the exit code, 2 with one line for a user's mistake."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="output folder of a run")
    parser.add_argument("picture", type=Path, help="PNG to write")
    parser.add_argument("--frames", type=int, choices=range(1, 13), default=4, metavar="1 to 12")
    options = parser.parse_args(arguments)
    try:
        if options.picture.suffix.lower() != ".png":
            raise InputError(f"{options.picture}: give the name of a .png file")
        with pv.vtk_verbosity("error"):  # where there is no display VTK warns that it draws without
            draw(options.folder, options.picture, frames=options.frames)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(f"{options.picture} cannot be written: {error.strerror or error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
