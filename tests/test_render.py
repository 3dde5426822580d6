"""Pictures, movies and pages of a flight, judged by what can be seen in them."""

from __future__ import annotations

import base64
import importlib.util
import json
import re
import shutil
import subprocess
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import CORD
from PIL import Image

from netdae.core.errors import InputError
from netdae.model.net import CableNet
from netdae.model.restraints import Restraint
from netdae.model.state import State
from netdae.model.tether import Chaser, Tether
from netdae.output.vtk import RESTRAINED, VtuSeries, grid_of, read_frame
from netdae.system.damping import NoDamping
from netdae.system.system import System
from netdae.system.tether_assembly import with_tether
from netdae.visual.rendering import movie_file
from netdae.visual.rendering.camera import extent_of, view_of
from netdae.visual.rendering.colours import HELD, PALE, peak_of, round_down, round_up, tension_map
from netdae.visual.rendering.frames import cast_of, read_footage
from netdae.visual.rendering.labels import font_size, footer_height
from netdae.visual.rendering.scene import Stage, room_for
from netdae.visual.rendering.views import Look, render_page, render_picture, render_sheet
from netdae.visual.rendering.views import render_movie as movie_of

SIDE, CELLS = 4.0, 4
FRAMES = 4
SMALL = (200, 180)
HAS_MP4 = importlib.util.find_spec("imageio_ffmpeg") is not None


def stretched(x, part, factor):
    """The net with the x of its nodes in `part` scaled, so that some cables are taut and others slack."""
    y = 0.97 * x
    y[part, 0] *= factor
    return y


def write_flight(folder, *, tethered=True, closing=True, times=None, drift=(0.0, 0.0, 3.0)):
    """A run's folder: a square net whose half with y > 0.5 is taut, carried along, with tether and closing cords."""
    net = CableNet.square(side=SIDE, cells=CELLS)
    if closing:
        net = replace(net, cable_groups={**net.cable_groups, "closing": net.cables_of("border")})
    masses, reels = {"corners": 0.5}, ()
    n = net.node_count
    x = stretched(net.nodes, net.nodes[:, 1] > 0.5, 1.06)
    tied = SimpleNamespace(net=net, start=State.at(x))
    if tethered:
        tether = Tether(
            "centre",
            3,
            CORD,
            Chaser((0.0, 0.0, -2.0), mass=300.0),
            slack=0.0,
            payout="free",
            drum_inertia=0.1,
        )
        tied = with_tether(net, State.at(x), tether)
        masses, reels = {**masses, **tied.masses}, tied.reels
    system = System(tied.net, CORD, masses=masses, damping=NoDamping(), reels=reels)
    series = VtuSeries(folder / "series.pvd")
    series.begin(system)
    for k, t in enumerate(np.linspace(0.0, 0.3, FRAMES) if times is None else times):
        moved = np.array(tied.start.x)
        moved[:n] += k / (FRAMES - 1) * np.asarray(drift)
        if tethered:
            moved[tied.net.nodes_of("reel")] = [1000.0 * k, 0.0, 0.0]  # a length, not a place: in no picture
        series(State.at(moved, t=float(t)))
    series.end()
    return system


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    folder = tmp_path_factory.mktemp("flight")
    write_flight(folder)
    return folder


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """Without tether and closing cords; at rest but for its way."""
    folder = tmp_path_factory.mktemp("plain")
    write_flight(folder, tethered=False, closing=False)
    return folder


def pixels_of(file):
    return np.asarray(Image.open(file).convert("RGB")).astype(int)


def scene_of(pixels):
    """A picture without its footer and the time."""
    width = pixels.shape[1]
    cut = pixels[: -footer_height(width)].copy()
    cut[: int(2.2 * font_size(width)), : 8 * font_size(width)] = 255
    return cut


def near(pixels, colour, width=60):
    """Which pixels have about that colour."""
    rgb = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)])
    return np.abs(pixels - rgb).sum(axis=-1) < width


def colourful(pixels):
    return np.ptp(pixels, axis=-1) > 60


def drawn(folder, number, *, size=(300, 260), view="oblique", peak=None, fit="all"):
    """Frame, shot and pixels of the scene alone."""
    footage = read_footage(folder)
    frame = footage.frame(number)
    nodes = footage.cast.drawn if fit == "all" else footage.cast.net
    extent = extent_of([frame], nodes, view=view_of(view), camera="follow")
    (shot,) = extent.shots(size, room=room_for(footage.cast, size))
    with Stage(footage.cast, size, peak=peak or peak_of([frame], footage.cast)) as stage:
        return footage, frame, shot, stage.draw(frame, shot).astype(int)


# who is who


def test_bullets_chaser_and_kinds_of_cables_are_reported_from_a_frame(flight):
    cast = read_footage(flight).cast
    net = CableNet.square(side=SIDE, cells=CELLS)
    assert cast.bullets.tolist() == net.nodes_of("corners").tolist()
    assert cast.net.tolist() == list(range(net.node_count))
    assert len(cast.chaser) == 1
    assert np.bincount(cast.kind).tolist() == [net.cable_count - 16, 3, 16]
    assert cast.typical_length == pytest.approx(1.0, rel=1e-12)


def test_a_node_without_a_cable_is_neither_drawn_nor_in_the_camera_s_way(tmp_path):
    net = CableNet.square(side=SIDE, cells=CELLS)
    lone = replace(net, nodes=np.concatenate((net.nodes, [[1000.0, 0.0, 0.0]])))
    grid = grid_of(lone)
    grid.point_data["displacement"], grid.point_data["mass"] = np.zeros((lone.node_count, 3)), 1.0
    assert cast_of(grid).drawn.tolist() == list(range(net.node_count))


def test_no_bullets_are_seen_in_a_net_without_masses(tmp_path):
    net = CableNet.hexagon(radius=2.0, rings=3)
    series = VtuSeries(tmp_path / "series.pvd")
    series.begin(System(net, CORD, damping=NoDamping()))
    series(State.at(net.nodes))
    series.end()
    assert read_footage(tmp_path).cast.bullets.tolist() == []


# the camera


@pytest.mark.parametrize("view", ["oblique", "x", "y", "z", (1.0, -2.0, 0.5)])
def test_points_appear_where_the_camera_says(plain, view):
    """The bullets' black spheres, whose middles the shot predicts, are found in the picture."""
    footage, frame, shot, pixels = drawn(plain, 2, view=view)
    dark = pixels.sum(axis=-1) < 240
    for column, row in shot.pixels(frame.points[footage.cast.bullets]).round().astype(int):
        around = dark[row - 3 : row + 4, column - 3 : column + 4]
        assert around.mean() > 0.5  # a cable towards the eye may cover a part


@pytest.mark.parametrize("camera", ["follow", "still"])
@pytest.mark.parametrize("size", [(300, 200), (150, 400)])
def test_every_node_is_inside_the_picture_with_room_for_its_sign(flight, camera, size):
    footage = read_footage(flight)
    frames = [footage.frame(k) for k in range(FRAMES)]
    room = room_for(footage.cast, size)
    extent = extent_of(frames, footage.cast.drawn, view=view_of("oblique"), camera=camera)
    tightest = []
    for frame, shot in zip(frames, extent.shots(size, room=room), strict=True):
        pixels = shot.pixels(frame.points[footage.cast.drawn])
        margin = min(pixels.min(), (np.asarray(size) - pixels).min())
        assert margin > room - 1e-6
        tightest.append(margin)
    assert min(tightest) == pytest.approx(room, abs=1e-6)  # and fills it


def test_a_still_camera_stands_and_a_following_one_goes_along(plain):
    footage = read_footage(plain)
    frames = [footage.frame(k) for k in range(FRAMES)]
    shots = {
        camera: extent_of(frames, footage.cast.net, view=view_of("x"), camera=camera).shots(
            (200, 200), room=10
        )
        for camera in ("follow", "still")
    }
    first = footage.cast.net[:1]
    way = {
        camera: np.ptp(
            [shot.pixels(f.points[first])[0] for f, shot in zip(frames, taken, strict=True)], axis=0
        )
        for camera, taken in shots.items()
    }
    assert np.abs(way["follow"]).max() < 1e-9  # the net is carried along unchanged
    assert way["still"][1] * shots["still"][0].scale == pytest.approx(3.0, rel=1e-12)  # m, up
    assert way["still"][0] == pytest.approx(0.0, abs=1e-9)


def test_a_picture_s_axes_are_right_handed_with_z_up():
    for name in ("oblique", "x", "y", "z", (0.0, 0.0, -2.0), (1.0, 2.0, 3.0)):
        view = view_of(name)
        axes = np.stack([view.right, view.up, view.toward])
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
        assert np.linalg.det(axes) == pytest.approx(1.0, rel=1e-14)
        assert view.up[2] >= 0


# what is seen


def test_taut_cables_are_coloured_and_slack_ones_grey(plain):
    """Along each cable that lies free: the pixels at its middle."""
    footage, frame, shot, pixels = drawn(plain, 0, view="z")
    middles = frame.points[footage.cast.cables].mean(axis=1)
    assert 4 < frame.taut.sum() < len(frame.taut) - 4
    for taut, (column, row) in zip(frame.taut, shot.pixels(middles).round().astype(int), strict=True):
        patch = pixels[row - 2 : row + 3, column - 2 : column + 3].reshape(-1, 3)
        if taut:
            assert np.ptp(patch, axis=1).max() > 60  # the darkest end of the colours has 90
        else:
            assert np.ptp(patch, axis=1).max() < 12
            assert patch.sum(axis=1).min() < 3 * 240  # it is there
    grey = (np.ptp(pixels, axis=-1) < 12) & (pixels.sum(axis=-1) < 3 * 235) & (pixels.sum(axis=-1) > 3 * 100)
    assert grey.sum() > 300
    assert colourful(pixels).sum() > 300


def test_tension_gives_the_colour_of_the_bar(plain):
    """The hue at the middle of a taut cable is that of its tension, whatever the light on it."""
    footage, frame, _, _ = drawn(plain, 0)
    tension = frame.tension[frame.taut].max()
    for share in (0.1, 0.5, 1.0):
        _, _, shot, pixels = drawn(plain, 0, view="z", peak=tension / share)
        cable = int(frame.tension.argmax())
        ((column, row),) = (
            shot.pixels(frame.points[footage.cast.cables[cable]].mean(axis=0)[None]).round().astype(int)
        )
        patch = pixels[row - 1 : row + 2, column - 1 : column + 2].reshape(-1, 3)
        found = patch[np.ptp(patch, axis=1).argmax()].astype(float)
        wanted = 255 * tension_map()[round(255 * share)]
        # the light makes a tube darker or brighter, by one factor for all three
        cosine = found @ wanted / np.linalg.norm(found) / np.linalg.norm(wanted)
        assert cosine > 0.98


def test_tether_closing_cords_chaser_and_bullets_have_their_colours(flight, plain):
    def counts(folder):
        _, _, _, pixels = drawn(folder, 1)
        red, green, blue = np.moveaxis(pixels, -1, 0)
        return {
            "tether": ((blue > 100) & (green > 80) & (red < 60) & (blue > green)).sum(),
            "closing": ((green > 90) & (red < 0.6 * green) & (blue < 0.75 * green)).sum(),
            "panel": ((blue > 100) & (green < 90) & (red < 60)).sum(),
            "bullets": (pixels.sum(axis=-1) < 160).sum(),
        }

    there, without = counts(flight), counts(plain)
    assert all(count > 15 for count in there.values()), there
    assert without["bullets"] > 15
    assert without["tether"] == without["closing"] == without["panel"] == 0


def write_held(folder):
    """A net that hangs by its corners until 0.15 s: two frames of it held, two of it free."""
    net = CableNet.square(side=SIDE, cells=CELLS)
    system = System(net, CORD, damping=NoDamping(), restraints=[Restraint("corners", axes="xy", until=0.15)])
    series = VtuSeries(folder / "series.pvd")
    series.begin(system)
    for t in np.linspace(0.0, 0.3, FRAMES):
        series(State.at(0.97 * net.nodes, t=float(t)))
    series.end()


@pytest.mark.parametrize("view", ["oblique", "x", "z"])
def test_held_nodes_stand_on_a_sign_while_they_are_held(tmp_path, view):
    write_held(tmp_path)
    _, frame, shot, pixels = drawn(tmp_path, 1, view=view)
    corners = CableNet.square(side=SIDE, cells=CELLS).nodes_of("corners")
    assert frame.held.tolist() == corners.tolist()
    blue = held_pixels(pixels)
    for column, row in shot.pixels(frame.points[corners]).round().astype(int):
        # at its tip, and below it as wide as high
        assert blue[row + 3 : row + 7, column - 1 : column + 2].mean() > 0.8
        assert not blue[row - 6 : row - 2, column - 6 : column + 7].any()
    _, free, _, pixels = drawn(tmp_path, 2, view=view)
    assert len(free.held) == 0
    assert not held_pixels(pixels).any()


def held_pixels(pixels):
    """Which pixels have the hue of that sign, whatever the light on it."""
    wanted = np.array([int(HELD[i : i + 2], 16) for i in (1, 3, 5)], dtype=float)
    length = np.linalg.norm(pixels, axis=-1)
    cosine = pixels @ wanted / np.maximum(length, 1.0) / np.linalg.norm(wanted)
    return (cosine > 0.98) & (np.ptp(pixels, axis=-1) > 60)


def test_the_sign_of_held_nodes_is_explained_where_one_is_in_sight(tmp_path):
    write_held(tmp_path)
    look, footer = Look(size=(640, 400)), footer_height(640)
    for number, there in ((0, True), (3, False)):
        render_picture(tmp_path, tmp_path / "p.png", frame=number, look=look)
        assert (held_pixels(pixels_of(tmp_path / "p.png")[-footer:]).sum() > 20) == there
    render_sheet(tmp_path, tmp_path / "s.png", frames=[0, 3], look=look)
    assert held_pixels(pixels_of(tmp_path / "s.png")[-footer:]).sum() > 20
    data = data_in(render_page(tmp_path).file.read_text(encoding="utf-8"))
    corners = CableNet.square(side=SIDE, cells=CELLS).nodes_of("corners").tolist()
    assert [reported["held"] for reported in data["frames"]] == [corners, corners, [], []]


def test_frames_that_do_not_tell_what_is_held_are_drawn_without(tmp_path):
    write_held(tmp_path)
    file = tmp_path / "frames" / "frame_000000.vtu"
    grid = read_frame(file)
    assert RESTRAINED in grid.point_data
    del grid.point_data[RESTRAINED]
    grid.save(file)
    assert RESTRAINED not in read_frame(file).point_data
    assert len(read_footage(tmp_path).frame(0).held) == 0
    render_picture(tmp_path, tmp_path / "p.png", frame=0, look=Look(size=(640, 400)))
    assert not held_pixels(pixels_of(tmp_path / "p.png")).any()
    render_page(tmp_path, frames=[0])


def test_the_colours_grow_darker_with_tension():
    """So that they can be read in grey, where slack cables are paler than all of them."""
    luminance = tension_map(64) @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(luminance) < 0).all()
    slack = int(PALE["net"][1:3], 16) / 255
    assert luminance.max() < slack


def test_the_scale_bar_is_as_long_as_it_says(plain, tmp_path):
    """Seen from above, the bullets are a known distance apart; the bar beside them reports the same metres a pixel."""
    file = tmp_path / "p.png"
    render_picture(plain, file, frame=0, look=Look(view="z", size=(400, 400)))
    pixels = pixels_of(file)
    footer = pixels[-footer_height(400) :]
    dark = footer[:, :130].sum(axis=-1) < 200
    row = dark.sum(axis=1).argmax()
    columns = np.flatnonzero(dark[row])
    bar = columns.max() - columns.min()
    black = scene_of(pixels).sum(axis=-1) < 160
    spread = np.ptp(np.flatnonzero(black.any(axis=0))) - 2 * 6.5 * (0.4 + 400 / 1600)  # spheres' radii
    # the lower bullets' distance: 0.97 of the side; the upper's, which is wider: 1.06 times that
    metres = bar * 0.97 * 1.06 * SIDE / spread
    assert metres == pytest.approx(0.5, rel=0.05)


# what is written


def test_the_picture_has_its_size_time_and_footer_and_is_not_empty(flight, tmp_path):
    done = render_picture(flight, tmp_path / "sub" / "p.png", frame=2, look=Look(size=SMALL))
    assert (done.frames, done.times) == ((2,), (pytest.approx(0.2),))
    pixels = pixels_of(done.file)
    assert pixels.shape == (SMALL[1], SMALL[0], 3)
    assert (scene_of(pixels) < 200).any(axis=-1).mean() > 0.01
    size = font_size(SMALL[0])
    assert (pixels[: 2 * size, : 6 * size] < 100).any()
    assert colourful(pixels[-footer_height(SMALL[0]) :]).sum() > 50


def test_the_frame_is_that_of_the_largest_mouth_or_nearest_to_a_time(tmp_path, flight):
    write_flight(tmp_path)
    look = Look(size=SMALL)
    assert render_picture(tmp_path, look=look).frames == (FRAMES - 1,)  # nothing reports of a mouth
    (tmp_path / "metrics.csv").write_text("time,mouth_area\n0.0,1.0\n0.1,5.0\n0.2,\n0.3,2.0\n")
    assert render_picture(tmp_path, look=look).frames == (FRAMES - 1,)  # a damaged table neither
    (tmp_path / "metrics.csv").write_text("time,mouth_area\n0.0,1.0\n0.1,5.0\n0.2,nan\n0.3,2.0\n")
    done = render_picture(tmp_path, look=look)
    assert (done.frames, done.file) == ((1,), tmp_path / "picture.png")
    assert render_picture(tmp_path, time=0.16, look=look).frames == (2,)


def test_a_sheet_shows_the_frames_side_by_side_on_one_scale(plain, tmp_path):
    done = render_sheet(plain, tmp_path / "s.png", frames=[0, 3], look=Look(size=(400, 240), view="z"))
    assert done.frames == (0, 3)
    pixels = pixels_of(done.file)
    assert pixels.shape == (240, 400, 3)
    left, right = np.split(pixels[20 : -footer_height(400)], 2, axis=1)
    spans = [np.ptp(np.flatnonzero((half.sum(axis=-1) < 160).any(axis=0))) for half in (left, right)]
    assert spans[0] > 120
    assert abs(spans[0] - spans[1]) <= 1
    assert render_sheet(plain, tmp_path / "s.png", count=3, look=Look(size=SMALL)).frames == (0, 2, 3)
    assert len(render_sheet(plain, tmp_path / "s.png", count=9, look=Look(size=SMALL)).frames) == FRAMES


def test_the_gif_has_the_frames_asked_for_at_its_rate(flight, tmp_path):
    reported = []
    done = movie_of(
        flight,
        tmp_path / "m.gif",
        rate=10.0,
        look=Look(size=(201, 181)),
        report=lambda count, total: reported.append((count, total)),
    )
    assert done.frames == (0, 1, 2, 3)
    assert reported == [(k, FRAMES) for k in range(1, FRAMES + 1)]
    movie = Image.open(done.file)
    assert (movie.n_frames, movie.size, movie.info["duration"]) == (FRAMES, (200, 180), 100)
    pictures = []
    for k in range(FRAMES):
        movie.seek(k)
        pictures.append(np.asarray(movie.convert("RGB")).astype(int))
    assert (pictures[0][0, -1] == 255).all()  # paper stays white
    assert np.abs(pictures[0] - pictures[-1]).max() > 100
    render_picture(flight, tmp_path / "p.png", frame=0, look=Look(size=(200, 180), peak=1.0))
    assert len(movie_of(flight, tmp_path / "m.gif", frames=[1], look=Look(size=SMALL)).frames) == 1
    assert Image.open(tmp_path / "m.gif").n_frames == 1


def test_a_gif_s_colours_are_those_of_the_picture(flight, tmp_path):
    """The palette is made before anything is drawn: no colour of a picture is far from it."""
    look = Look(size=(300, 240))
    movie_of(flight, tmp_path / "m.gif", frames=[1], look=look)
    render_picture(flight, tmp_path / "p.png", frame=1, look=look)
    difference = np.abs(pixels_of(tmp_path / "m.gif") - pixels_of(tmp_path / "p.png")).max(axis=-1)
    assert np.quantile(difference, 0.9) == 0  # paper
    assert np.quantile(difference, 0.99) <= 16  # edges, of which there are more shades than 256
    assert difference.max() < 60


@pytest.mark.skipif(not HAS_MP4, reason="needs imageio-ffmpeg")
def test_the_mp4_has_the_frames_asked_for_at_its_rate(flight, tmp_path):
    from imageio_ffmpeg import read_frames

    done = movie_of(flight, tmp_path / "m.mp4", frames=[0, 1, 3], rate=12.0, look=Look(size=(201, 181)))
    assert done.frames == (0, 1, 3)
    reader = read_frames(str(done.file))
    about = next(reader)
    assert (about["size"], about["fps"]) == ((200, 180), 12.0)
    pictures = [np.frombuffer(data, np.uint8).reshape(180, 200, 3).astype(int) for data in reader]
    assert len(pictures) == 3
    assert (scene_of(pictures[0]) < 200).any(axis=-1).mean() > 0.01
    assert [file.name for file in tmp_path.iterdir()] == ["m.mp4"]


def test_without_imageio_ffmpeg_a_movie_is_a_gif_and_mp4_says_what_it_needs(flight, tmp_path, monkeypatch):
    monkeypatch.setattr(movie_file, "find_spec", lambda name: None)
    assert movie_file.best_ending() == ".gif"
    with pytest.raises(InputError, match=r"m\.mp4: MP4 needs .* pip install 'netdae\[movie\]', or"):
        movie_of(flight, tmp_path / "m.mp4")


# the page


def data_in(page):
    (text,) = re.findall(r'<script type="application/json" id="flight">(.*?)</script>', page, re.DOTALL)
    return json.loads(text)


@pytest.mark.parametrize("far", [False, True], ids=["near, 16 bit", "far, 32 bit"])
def test_the_page_has_the_frames_positions_within_its_rounding(tmp_path, far):
    write_flight(tmp_path, drift=(0.0, 0.0, 400.0) if far else (0.0, 0.0, 3.0))
    done = render_page(tmp_path, frames=[0, 2, 3])
    assert done.file == tmp_path / "flight.html"
    data = data_in(done.file.read_text(encoding="utf-8"))
    footage = read_footage(tmp_path)
    assert data["nodes"] == footage.cast.drawn.tolist()
    assert data["step"] <= 1e-4 * SIDE * 2
    assert data["width"] == (32 if far else 16)
    assert np.array(data["nodes"])[np.array(data["cables"])].tolist() == footage.cast.cables.tolist()
    assert [reported["number"] for reported in data["frames"]] == [0, 2, 3]
    for reported in data["frames"]:
        frame = footage.frame(reported["number"])
        assert reported["time"] == frame.t
        whole = np.frombuffer(base64.b64decode(reported["positions"]), f"<i{data['width'] // 8}").reshape(
            -1, 3
        )
        error = np.asarray(reported["origin"]) + data["step"] * whole - frame.points[footage.cast.drawn]
        assert np.abs(error).max() <= 0.5 * data["step"] * (1 + 1e-6)
        tension = np.frombuffer(base64.b64decode(reported["tension"]), np.uint8).astype(float)
        assert ((tension > 0) == frame.taut).all()
        shown = (tension - 1) / 254 * data["peak"]
        below = frame.taut & (frame.tension < data["peak"])
        assert np.abs(shown - frame.tension)[below].max() <= 0.5 * data["peak"] / 254 * (1 + 1e-9)
        assert reported["largest"] == pytest.approx(frame.tension[footage.cast.kind == 0].max(), rel=1e-3)


def test_the_page_loads_nothing_from_elsewhere(flight, tmp_path):
    (tmp_path / "x").mkdir()
    page = render_page(flight, tmp_path / "x" / "f.html").file.read_text(encoding="utf-8")
    assert "http:" not in page
    assert "https:" not in page
    assert not re.search(r'\b(src|href)\s*=\s*"(?!data:)', page)
    assert not re.search(r"\b(import|fetch|XMLHttpRequest|url)\s*\(", page)
    assert "{{" not in page


def test_a_title_with_signs_of_html_stays_words(tmp_path):
    write_flight(tmp_path)
    (tmp_path / "scenario.toml").write_text('title = "</script><b>5 m & more"\n')
    page = render_page(tmp_path).file.read_text(encoding="utf-8")
    assert "<title>&lt;/script&gt;&lt;b&gt;5 m &amp; more</title>" in page
    assert data_in(page)["title"] == "</script><b>5 m & more"


def test_the_page_survives_any_title(tmp_path):
    write_flight(tmp_path)
    title = "<!--<script> {{data}} {{title}} \x1b[31m"
    (tmp_path / "scenario.toml").write_text(f"title = {json.dumps(title)}\n", encoding="utf-8")
    page = render_page(tmp_path).file.read_text(encoding="utf-8")
    assert data_in(page)["title"] == title
    # within a script, <!-- and <script hide its end from a browser
    assert "<" not in re.search(r'id="flight">(.*?)</script>', page, re.DOTALL)[1]
    assert "<title>&lt;!--&lt;script&gt; {{data}} {{title}}" in page


def in_browser(page, folder):
    """Pixels of a page's scene as a browser shows its frame 1."""
    command = [
        *(
            "chromium",
            "--headless=new",
            "--no-sandbox",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
        ),
        *(
            "--hide-scrollbars",
            "--window-size=640,600",
            "--virtual-time-budget=2000",
            "--enable-logging=stderr",
        ),
        *(
            f"--user-data-dir={folder / 'profile'}",
            f"--screenshot={folder / 'shot.png'}",
            f"file://{page}#frame=1",
        ),
    ]
    reported = subprocess.run(command, capture_output=True, text=True, timeout=120).stderr
    assert "CONSOLE" not in reported
    return pixels_of(folder / "shot.png")[170:-60, :]


@pytest.mark.skipif(shutil.which("chromium") is None, reason="needs a browser")
def test_the_page_draws_in_a_browser(flight, tmp_path):
    scene = in_browser(render_page(flight, tmp_path / "f.html", look=Look(view="x")).file, tmp_path)
    assert colourful(scene).sum() > 100
    assert (scene.sum(axis=-1) < 200).sum() > 100  # bullets


@pytest.mark.skipif(shutil.which("chromium") is None, reason="needs a browser")
def test_the_page_shows_what_is_held_in_a_browser(tmp_path):
    write_held(tmp_path)
    scene = in_browser(render_page(tmp_path).file, tmp_path)
    # four triangles as wide and high as 13 pixels
    assert held_pixels(scene).sum() == pytest.approx(4 * 13 * 13 / 2, rel=0.2)


# wrong input


def test_folders_without_frames_and_wrong_numbers_are_reported(tmp_path, flight):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="none is not a folder: give the output folder of netdae run"):
        render_picture(tmp_path / "none")
    with pytest.raises(InputError, match="file is not a folder"):
        render_picture(tmp_path / "file")
    with pytest.raises(InputError, match="has no frames: give the output folder of netdae run"):
        render_sheet(tmp_path)
    series = VtuSeries(tmp_path / "series.pvd")
    series.begin(System(CableNet.square(side=1.0, cells=2), CORD, damping=NoDamping()))
    with pytest.raises(InputError, match="has no frames yet"):
        movie_of(tmp_path)
    for number in (-1, FRAMES):
        with pytest.raises(InputError, match=f"frame {number} is not in .*: its frames are 0 to 3"):
            render_picture(flight, tmp_path / "p.png", frame=number)
    with pytest.raises(InputError, match="frame 7 is not in"):
        render_page(flight, tmp_path / "p.html", frames=[0, 7])
    for t in (-0.1, 0.4, np.nan):
        with pytest.raises(InputError, match=r"time .* s is not in .*: its frames are from 0 to 0\.3 s"):
            render_picture(flight, tmp_path / "p.png", time=t)
    with pytest.raises(InputError, match="no frames are given"):
        render_sheet(flight, tmp_path / "p.png", frames=[])


def test_a_damaged_frame_is_reported_by_its_name(tmp_path):
    write_flight(tmp_path)
    file = tmp_path / "frames" / "frame_000002.vtu"
    data = bytearray(file.read_bytes())
    begin = data.index(b"<AppendedData")
    for k in range(begin + 100, len(data) - 100, 7):
        data[k] ^= 0x5A
    file.write_bytes(data)
    with pytest.raises(InputError, match=r"frame_000002\.vtu is damaged: choose other frames"):
        movie_of(tmp_path, tmp_path / "m.gif")
    file.write_bytes(data[: len(data) // 2])
    with pytest.raises(InputError, match=r"frame_000002\.vtu is cut off"):
        render_picture(tmp_path, frame=2)
    file.unlink()
    with pytest.raises(InputError, match=r"frame_000002\.vtu cannot be read"):
        render_picture(tmp_path, frame=2)
    assert render_picture(tmp_path, frame=1, look=Look(size=SMALL)).frames == (1,)


def test_a_frame_of_another_net_is_reported(tmp_path, flight):
    write_flight(tmp_path, tethered=False)
    shutil.copy(flight / "frames" / "frame_000001.vtu", tmp_path / "frames" / "frame_000001.vtu")
    with pytest.raises(InputError, match=r"frame_000001\.vtu shows another net than .*frame_000000\.vtu"):
        render_sheet(tmp_path)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"view": "up"}, "view 'up' is unknown: give oblique, x, y, z, or a vector"),
        ({"view": (0.0, 0.0, 0.0)}, "is no direction"),
        ({"view": (1.0, np.nan, 0.0)}, "is no direction"),
        ({"camera": "fly"}, "camera 'fly' is unknown: give follow or still"),
        ({"fit": "some"}, "fit 'some' is unknown: give all or net"),
        ({"size": (10, 100)}, "size 10,100 is out of range: give 64 to 8192 pixels"),
        ({"peak": 0.0}, "peak 0 N is no end for the colours"),
    ],
)
def test_a_look_that_cannot_be_is_refused(wrong, words):
    with pytest.raises(InputError, match=re.escape(words)):
        Look(**wrong)


def test_files_that_cannot_be_written_are_reported(flight, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"p\.jpg: give a name that ends in \.png"):
        render_picture(flight, tmp_path / "p.jpg")
    with pytest.raises(InputError, match=r"m\.avi: give a name that ends in \.mp4 or \.gif"):
        movie_of(flight, tmp_path / "m.avi")
    with pytest.raises(InputError, match=r"p\.png cannot be written: .*: give another name by -o"):
        render_picture(flight, tmp_path / "file" / "p.png")
    (tmp_path / "folder.html").mkdir()
    with pytest.raises(InputError, match=r"folder\.html cannot be written: it is a folder"):
        render_page(flight, tmp_path / "folder.html")


def test_round_numbers():
    assert [round_up(value) for value in (0.97, 1.0, 1.2, 3.1, 8.5, 0.031, 77)] == [
        1,
        1,
        1.5,
        4,
        10,
        0.04,
        80,
    ]
    assert [round_down(value) for value in (0.97, 1.0, 3.1, 8.5, 0.031)] == [0.5, 1, 2, 5, 0.02]
