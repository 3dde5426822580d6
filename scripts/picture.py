"""Picture of a flight: several of its frames side by side, cables coloured by tension, slack ones grey.

    python scripts/picture.py out/corner_shot scripts/pictures/corner_shot.png

Needs no display.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pyvista as pv

from netdae.vtk import read_frame, read_series

PANEL = (440, 400)  # pixels


def draw(folder: Path, picture: Path, *, frames: int) -> None:
    """Write a PNG of `frames` frames, evenly spread over the series in `folder`."""
    series = read_series(folder / "series.pvd")
    chosen = [series[i] for i in np.linspace(0, len(series) - 1, frames).round().astype(int)]
    grids = [(time, read_frame(file)) for time, file in chosen]
    points = np.concatenate([grid.points for _, grid in grids])
    low, high = points.min(axis=0), points.max(axis=0)
    size = float(np.linalg.norm(high - low))
    peak = max(float(np.quantile(grid.cell_data["tension"], 0.98)) for _, grid in grids) or 1.0
    plotter = pv.Plotter(
        off_screen=True, shape=(1, frames), window_size=(PANEL[0] * frames, PANEL[1]), border=False
    )
    plotter.set_background("white")
    for panel, (time, grid) in enumerate(grids):
        plotter.subplot(0, panel)
        taut = grid.cell_data["taut"] == 1
        if (~taut).any():
            plotter.add_mesh(grid.extract_cells(~taut), color="grey", line_width=1)
        if taut.any():
            tubes = grid.extract_cells(taut).extract_surface(algorithm=None).tube(radius=size / 500)
            last = panel == frames - 1
            plotter.add_mesh(
                tubes,
                scalars="tension",
                clim=(0, peak),
                cmap="plasma",
                show_scalar_bar=last,
                scalar_bar_args={"title": "tension, N", "color": "black", "n_labels": 3, "height": 0.08},
            )
        bullets = grid.extract_points(
            grid.point_data["mass"] > 0.1 * grid.point_data["mass"].max(), include_cells=False
        )
        plotter.add_mesh(bullets, color="black", point_size=9, render_points_as_spheres=True)
        plotter.add_text(f"{time:.2f} s", position="upper_left", font_size=10, color="black")
        centre = (low + high) / 2
        plotter.camera_position = [
            tuple(centre + size * np.array([0.95, -1.4, 0.7])),
            tuple(centre),
            (0, 0, 1),
        ]
    picture.parent.mkdir(parents=True, exist_ok=True)
    plotter.screenshot(picture)
    plotter.close()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="output folder of a run")
    parser.add_argument("picture", type=Path, help="PNG to write")
    parser.add_argument("--frames", type=int, default=4)
    options = parser.parse_args()
    draw(options.folder, options.picture, frames=options.frames)
