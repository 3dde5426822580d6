"""The stage: one frame drawn in three dimensions, off-screen, to pixels; with pyvista, and no display.

Cables are tubes, the net's taut ones coloured by tension, slack ones thin and pale; tether and closing cords have
colours of their own. Bullets are spheres, the chaser is a box with two panels, and what is held or driven stands on a
cone: signs of one size on paper, not to scale. A target is drawn to scale, lit, with its axes x, y and z from the
origin of its frame in red, green and blue.
"""

from __future__ import annotations

from types import TracebackType
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from netdae.core.arrays import BoolArray, FloatArray
from netdae.visual.rendering.camera import Shot
from netdae.visual.rendering.colours import (
    AXES,
    BODY,
    BULLET,
    CHASER,
    HELD,
    PALE,
    PANEL,
    PAPER,
    STRONG,
    tension_map,
)
from netdae.visual.rendering.frames import KINDS, Body, Cast, Frame

Pixels = NDArray[np.uint8]
"""A picture, (height, width, 3)."""

_USUAL = 960.0  # pixels: width at which the radii below are meant
_TAUT, _SLACK, _CORD, _SLACK_CORD = 1.5, 0.55, 2.0, 1.2  # radii in pixels
_BULLET, _CHASER = 6.5, 10.0  # radius and half an edge, pixels
_HELD, _HELD_HEIGHT = 6.5, 13.0  # radius and height of a cone, pixels
_PANEL_FROM, _PANEL_HALF = 2.6, 1.3  # middle and half the length of a panel, times the chaser's half edge
_SHARE_OF_MESH = (
    0.11  # largest radius of a taut cable over the typical length of cables: dense nets stay open
)
_SIDES = 8


def sign_size(size: tuple[int, int]) -> float:
    """How large bullets and chaser are drawn, times their usual size, on a picture of that width and height."""
    return max(1.0, size[0] / _USUAL) * min(1.0, 0.4 + size[0] / 1600)


def room_for(cast: Cast, size: tuple[int, int], *, held: bool = False) -> float:
    """Pixels that the signs of a flight need between the nodes they stand for and the picture's edge.

    held : whether a node is held or driven
    """
    sign = _HELD_HEIGHT if held else _BULLET
    if len(cast.chaser):
        sign = (_PANEL_FROM + _PANEL_HALF) * _CHASER
    return max(0.05 * min(size), (sign + 3.0) * sign_size(size))


class Stage:
    """Draws frames of one flight; a context manager, as it holds a window of VTK.

    size : width and height, pixels
    peak : N, the tension at which the colours end
    """

    def __init__(self, cast: Cast, size: tuple[int, int], *, peak: float) -> None:
        self._cast = cast
        self._size = size
        self._peak = peak
        self._map = tension_map()
        with pv.vtk_verbosity("off"):  # without a display VTK reports that it draws off-screen
            self._plotter: Any = pv.Plotter(off_screen=True, window_size=size, lighting="none", border=False)
            self._plotter.set_background(PAPER)
            self._plotter.enable_anti_aliasing("msaa", multi_samples=8)
            self._plotter.enable_parallel_projection()
            self._lamp = pv.Light(light_type="camera light")
            self._plotter.add_light(self._lamp)

    def __enter__(self) -> Stage:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._plotter.close()

    def draw(self, frame: Frame, shot: Shot) -> Pixels:
        """The picture of a frame as the shot sees it."""
        plotter = self._plotter
        with pv.vtk_verbosity("off"):
            plotter.clear_actors()
            self._add_cables(frame, shot)
            self._add_bodies(frame, shot)
            if frame.body is not None:
                self._add_target(frame.body, shot)
            away = 2.0 * (shot.depth + max(shot.size) * shot.scale)
            plotter.camera.focal_point = shot.centre
            plotter.camera.position = shot.centre + away * shot.view.toward
            plotter.camera.up = shot.view.up
            plotter.camera.parallel_scale = shot.scale * shot.size[1] / 2
            plotter.reset_camera_clipping_range()
            plotter.render()
            return np.array(plotter.screenshot(return_img=True), dtype=np.uint8)[..., :3]

    def _add_cables(self, frame: Frame, shot: Shot) -> None:
        cast = self._cast
        pixel = shot.scale * max(1.0, self._size[0] / _USUAL)  # m
        taut = min(_TAUT * pixel, _SHARE_OF_MESH * cast.typical_length)
        taut = max(taut, 0.6 * pixel)
        net = cast.kind == 0
        self._add_tubes(frame, net & frame.taut, taut, colour=None)
        self._add_tubes(frame, net & ~frame.taut, min(_SLACK * pixel, taut), colour=PALE["net"])
        for kind, name in enumerate(KINDS):
            if kind:
                own = cast.kind == kind
                self._add_tubes(frame, own & frame.taut, _CORD * pixel, colour=STRONG[name])
                self._add_tubes(frame, own & ~frame.taut, _SLACK_CORD * pixel, colour=PALE[name])

    def _add_tubes(self, frame: Frame, chosen: BoolArray, radius: float, *, colour: str | None) -> None:
        """Tubes of the chosen cables, by tension where no colour is given."""
        ends = frame.points[self._cast.cables[chosen]]  # cable, end, axis
        long = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) > 0
        if not long.any():
            return
        ends = ends[long]
        if colour is None:
            share = np.clip(frame.tension[chosen][long] / self._peak, 0.0, 1.0)
            rgb = self._map[(share * (len(self._map) - 1)).round().astype(int)]
            mesh = tubes(ends, radius)
            mesh.cell_data["rgb"] = (255 * np.repeat(rgb, _SIDES, axis=0)).round().astype(np.uint8)
            self._plotter.add_mesh(mesh, scalars="rgb", rgb=True, **_LOOK)
        else:
            self._plotter.add_mesh(tubes(ends, radius), color=colour, **_LOOK)

    def _add_target(self, body: Body, shot: Shot) -> None:
        """Its surface, with each edge sharp, and its axes, as long as its frame's origin is far from its points."""
        surface = pv.PolyData.from_regular_faces(body.points, body.triangles)
        # points of flat faces are not shared, so that light shows the edges
        surface = surface.compute_normals(feature_angle=30.0, split_vertices=True)
        self._plotter.add_mesh(
            surface, color=BODY, smooth_shading=True, **{**_LOOK, "ambient": 0.35, "diffuse": 0.7}
        )
        own, pixel = body.own_points, shot.scale * sign_size(self._size)
        for axis, colour in enumerate(AXES):
            length = axis_length(own, axis)
            ends = np.stack((body.origin, body.origin + length * body.axes[:, axis]))
            self._plotter.add_mesh(tubes(ends[None], 1.6 * pixel), color=colour, **_LOOK)

    def _add_bodies(self, frame: Frame, shot: Shot) -> None:
        pixel = shot.scale * sign_size(self._size)  # m
        for place in frame.points[self._cast.bullets]:
            ball = pv.Sphere(radius=_BULLET * pixel, center=place, theta_resolution=20, phi_resolution=20)
            self._plotter.add_mesh(ball, color=BULLET, smooth_shading=True, **_LOOK)
        if len(frame.held):
            self._plotter.add_mesh(_supports(frame.points[frame.held], shot, pixel), color=HELD, **_LOOK)
        half = _CHASER * pixel
        for place in frame.points[self._cast.chaser]:
            self._plotter.add_mesh(_box(place, (half, half, half)), color=CHASER, **_LOOK)
            for side in (-_PANEL_FROM, _PANEL_FROM):
                aside = place + np.array([side * half, 0.0, 0.0])
                panel = _box(aside, (_PANEL_HALF * half, 0.12 * half, 0.75 * half))
                self._plotter.add_mesh(panel, color=PANEL, **_LOOK)


_LOOK: dict[str, Any] = {
    "ambient": 0.6,  # so that colours stay near those of the bar
    "diffuse": 0.45,
    "specular": 0.15,
    "specular_power": 20,
    "show_scalar_bar": False,
    "reset_camera": False,
    "render": False,
}


def axis_length(own: FloatArray, axis: int) -> float:
    """How long an axis of a body is drawn, m: an eighth of its size beyond its points (k, 3), in its frame."""
    size = float(np.ptp(own, axis=0).max())
    return max(float(own[:, axis].max()), 0.0) + 0.125 * size


def _supports(places: FloatArray, shot: Shot, pixel: float) -> Any:
    """Cones with their tips at places (k, 3), upright in the picture; in front of cables, which would pierce them."""
    up, toward, high = shot.view.up, shot.view.toward, _HELD_HEIGHT * pixel
    centre = _HELD * pixel * toward - 0.5 * high * up
    cone = pv.Cone(center=centre, direction=up, height=high, radius=_HELD * pixel, resolution=24)
    return pv.PolyData(places).glyph(geom=cone, orient=False, scale=False)


def _box(centre: FloatArray, half: tuple[float, float, float]) -> Any:
    low, high = centre - half, centre + np.asarray(half)
    return pv.Box(bounds=(low[0], high[0], low[1], high[1], low[2], high[2]))


def tubes(ends: FloatArray, radius: float) -> Any:
    """Tubes of eight sides between pairs of points (k, 2, 3), one after the other, with normals; open at the ends."""
    along = ends[:, 1] - ends[:, 0]
    along /= np.linalg.norm(along, axis=1)[:, None]
    least = np.eye(3)[np.abs(along).argmin(axis=1)]  # the axis most across
    first = np.cross(along, least)
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(along, first)
    turn = 2 * np.pi * np.arange(_SIDES) / _SIDES
    # cable, side, axis
    normals = np.cos(turn)[:, None] * first[:, None] + np.sin(turn)[:, None] * second[:, None]
    points = ends[:, :, None] + radius * normals[:, None]  # cable, end, side, axis
    k = len(ends)
    here = np.arange(_SIDES)
    after = (here + 1) % _SIDES
    faces = np.stack([np.full(_SIDES, 4), here, after, after + _SIDES, here + _SIDES], axis=1)  # side, corner
    shifts = np.zeros((k, 1, 5), dtype=np.int64)
    shifts[:, 0, 1:] = (2 * _SIDES * np.arange(k))[:, None]
    mesh = pv.PolyData(points.reshape(-1, 3), faces=(faces + shifts).ravel())
    mesh.point_data["Normals"] = np.repeat(normals[:, None], 2, axis=1).reshape(-1, 3)
    mesh.point_data.active_normals_name = "Normals"
    return mesh
