"""Surface meshes of targets: files, checks and repairs, signed distances on a grid."""

from __future__ import annotations

import sys

import numpy as np
import pytest
import trimesh

import netdae as nd
from netdae.core.errors import MeshError
from netdae.mesh import surface_grid
from netdae.mesh.closest import closest, signed_distances, tree_of
from netdae.mesh.receded import receded
from netdae.mesh.surface import check_size, read_surface, surface_mesh
from netdae.model.shapes.distance import curvatures
from netdae.model.shapes.part import parts_of, surface_of
from netdae.model.shapes.solid import of_surface
from netdae.model.shapes.surfaces import Surface, joined

BOX = surface_of(nd.Box((1.0, 0.6, 0.4)))
BALL = surface_of(nd.Sphere(0.5))
CONE = surface_of(nd.Cone(0.5, 0.2, 0.7))
CELLS = 16


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setattr(surface_grid, "cache_folder", lambda: tmp_path / "cache")
    return tmp_path / "cache"


def moved(surface, by):
    return Surface(surface.points + by, surface.triangles)


def inverted(surface):
    return Surface(surface.points, surface.triangles[:, ::-1])


def rows_of(shape, points):
    parts = parts_of([nd.Part(shape)])
    return curvatures(parts.kind[0], parts.first[0], parts.numbers, np.ascontiguousarray(points))


def a_torus():
    mesh = trimesh.creation.torus(0.5, 0.15, major_sections=24, minor_sections=12)
    return Surface(np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64))


def prism(outline):
    """A polygon that is star-shaped about its first corner, counter-clockwise, from z = 0 to 1."""
    n = len(outline)
    points = np.concatenate([np.column_stack([outline, np.full(n, z)]) for z in (0.0, 1.0)])
    caps = [(0, i, i + 1) for i in range(1, n - 1)]
    sides = [(i, (i + 1) % n, n + (i + 1) % n) for i in range(n)]
    sides += [(i, n + (i + 1) % n, n + i) for i in range(n)]
    triangles = [c[::-1] for c in caps] + [tuple(n + i for i in c) for c in caps] + sides
    return Surface(points, np.array(triangles))


def an_angle():
    """An L of unit thickness, with an edge that runs inwards."""
    return prism([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]])


def a_fan():
    """A regular tetrahedron with two faces cut into twenty from a corner: most normals there are of one face."""
    a, b, c, d = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
    cut = b + np.linspace(0, 1, 21)[:, None] * (c - b)
    points = np.concatenate([cut, [a, d]])
    faces = (
        [(21, i, i + 1) for i in range(20)]
        + [(22, i + 1, i) for i in range(20)]
        + [(21, 22, 0), (21, 20, 22)]
    )
    return Surface(points, np.array(faces))


SURFACES = {"fan": a_fan(), "box": BOX, "ball": BALL, "cone": CONE, "torus": a_torus(), "angle": an_angle()}


@pytest.mark.parametrize("name", SURFACES)
def test_the_closest_point_is_that_of_every_triangle_in_turn(name):
    surface = SURFACES[name]
    rng = np.random.default_rng(1)
    points = rng.uniform(surface.points.min(axis=0) - 0.3, surface.points.max(axis=0) + 0.3, (40, 3))
    points[:10] = surface.points[rng.integers(0, len(surface.points), 10)]
    found = closest(tree_of(*surface), points)
    v = surface.points[surface.triangles]
    pairs = np.tile(v, (len(points), 1, 1)), np.repeat(points, len(v), axis=0)
    nearest = np.linalg.norm(trimesh.triangles.closest_point(*pairs) - pairs[1], axis=1)
    assert np.allclose(found.distance, nearest.reshape(len(points), -1).min(axis=1), rtol=0, atol=1e-12)
    assert np.allclose(np.linalg.norm(points - found.place, axis=1), found.distance, rtol=0, atol=1e-12)


def test_the_closest_point_of_a_triangle_is_right_around_each_corner_and_edge():
    rng = np.random.default_rng(8)
    seen = set()
    for _ in range(20):
        triangle = rng.normal(size=(3, 3))
        points = rng.normal(size=(100, 3)) * 2.0
        found = closest(tree_of(triangle, np.array([[0, 1, 2]])), points)
        expected = trimesh.triangles.closest_point(np.tile(triangle, (100, 1, 1)), points)
        assert np.allclose(found.place, expected, rtol=0, atol=1e-12)
        seen |= set(found.feature.tolist())
        # the feature is the one that the place is on
        weights = np.linalg.lstsq(triangle.T, found.place.T, rcond=None)[0].T
        zeros = {0: (), 1: (1, 2), 2: (0, 2), 3: (0, 1), 4: (2,), 5: (0,), 6: (1,)}
        for feature, weight in zip(found.feature.tolist(), weights, strict=True):
            assert tuple(np.flatnonzero(np.abs(weight) < 1e-9)) == zeros[feature]
    assert seen == set(range(7))


def winding_numbers(surface, points):
    """How often the surface surrounds each point: the sum of solid angles over 4π (van Oosterom and Strackee 1983)."""
    a, b, c = (surface.points[surface.triangles[:, k]] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(each, axis=2) for each in (a, b, c))
    up = np.einsum("kmi,kmi->km", a, np.cross(b, c))
    down = la * lb * lc + np.sum(a * b, axis=2) * lc + np.sum(b * c, axis=2) * la + np.sum(c * a, axis=2) * lb
    return np.arctan2(up, down).sum(axis=1) / (2.0 * np.pi)


@pytest.mark.parametrize("name", SURFACES)
def test_the_sign_is_that_of_the_winding_number(name):
    surface = SURFACES[name]
    rng = np.random.default_rng(2)
    points = rng.uniform(surface.points.min(axis=0) - 0.1, surface.points.max(axis=0) + 0.1, (400, 3))
    # near corners and edges, where the closest point belongs to several faces
    ends = surface.points[surface.triangles[rng.integers(0, len(surface.triangles), 100)]]
    points[:100] = ends[:, 0] + rng.normal(size=(100, 3)) * 0.03
    points[100:200] = 0.5 * (ends[:, 0] + ends[:, 1]) + rng.normal(size=(100, 3)) * 0.03
    inside = winding_numbers(surface, points) > 0.5
    assert np.array_equal(signed_distances(tree_of(*surface), surface.triangles, points) < 0.0, inside)
    assert 40 < inside.sum() < 360


def test_a_grid_of_a_box_is_off_by_no_more_than_it_says():
    mesh = surface_mesh(*BOX, rounding=0.0, cells=CELLS)
    rng = np.random.default_rng(3)
    exact = nd.Box((1.0, 0.6, 0.4), rounding=0.0)
    points = rng.uniform(-0.55, 0.55, (20000, 3))
    phi = rows_of(exact, points)[:, 0]
    points, phi = (
        points[np.abs(phi) < mesh.spacing / np.sqrt(12)],
        phi[np.abs(phi) < mesh.spacing / np.sqrt(12)],
    )
    error = np.abs(rows_of(mesh, points)[:, 0] - phi)
    assert len(points) > 1000
    assert error.max() <= 1.05 * mesh.error  # other points than those that the error was taken of
    assert error.max() >= 0.5 * mesh.error  # and it is not much too large
    assert mesh.error <= 0.5 * mesh.spacing


def test_the_error_on_a_smooth_surface_falls_with_the_square_of_the_spacing():
    fine = surface_of(nd.Sphere(0.5))
    errors = [surface_mesh(*fine, rounding=0.0, cells=cells).error for cells in (8, 16)]
    # h²/(4 R) along one axis, twice that across; the chords of 48 segments add 1 mm at most
    for cells, error in zip((8, 16), errors, strict=True):
        h = 1.0 / cells
        assert error <= 3.0 * h**2 / (8.0 * (0.5 - h)) + 1.1e-3
    assert errors[1] < 0.45 * errors[0]


def test_the_grid_is_exact_at_its_nodes():
    mesh = surface_mesh(*CONE, rounding=0.0, cells=CELLS)
    rng = np.random.default_rng(4)
    index = rng.integers(0, np.array(mesh.values.shape), (500, 3))
    nodes = mesh.origin + mesh.spacing * index
    exact = signed_distances(tree_of(*CONE), CONE.triangles, nodes)
    assert np.allclose(rows_of(mesh, nodes)[:, 0], exact, rtol=0, atol=1e-12)
    low, high = CONE.points.min(axis=0), CONE.points.max(axis=0)
    assert np.all(mesh.origin < low - mesh.spacing)
    assert np.all(mesh.origin + mesh.spacing * (np.array(mesh.values.shape) - 1) > high + mesh.spacing)


def test_the_bound_of_the_slope_holds_outside_and_is_reached():
    mesh = surface_mesh(*BOX, rounding=0.0, cells=CELLS)
    points = np.random.default_rng(5).uniform(-0.6, 0.6, (20000, 3))
    rows = rows_of(mesh, points)
    slope = np.linalg.norm(rows[rows[:, 0] > 0.0, 1:4], axis=1)
    assert slope.max() <= mesh.lipschitz + 1e-12
    assert mesh.lipschitz < 1.8
    assert nd.Part(mesh).shape.core().lipschitz == mesh.lipschitz


def test_rounding_keeps_faces_and_takes_edges_off():
    sharp, rounded = (surface_mesh(*BOX, rounding=r, cells=CELLS) for r in (0.0, 0.1))
    exact = nd.Box((1.0, 0.6, 0.4), rounding=0.1)
    index = np.indices(rounded.values.shape).reshape(3, -1).T
    nodes = rounded.origin + rounded.spacing * index
    assert np.allclose(rounded.values.reshape(-1), rows_of(exact, nodes)[:, 0], rtol=0, atol=1e-12)
    assert rounded.error < 0.7 * sharp.error
    assert rounded.rounding == 0.1


def test_faces_recede_at_an_edge_that_runs_inwards_too():
    inner = receded(SURFACES["angle"], 0.1)
    expected = [(0.1, 0.1), (1.9, 0.1), (1.9, 0.9), (0.9, 0.9), (0.9, 1.9), (0.1, 1.9)]
    assert np.allclose(inner.points[:6], np.column_stack([expected, np.full(6, 0.1)]), rtol=0, atol=1e-12)


def test_receding_takes_a_layer_off_a_smooth_surface():
    inner = receded(BALL, 0.05)
    assert np.allclose(np.linalg.norm(inner.points, axis=1), 0.45, rtol=0, atol=2e-3)


def test_digits_lost_in_a_file_do_not_push_points_aside():
    mesh = trimesh.creation.box((1.0, 1.0, 1.0)).subdivide().subdivide()
    points = mesh.vertices + np.random.default_rng(9).normal(size=mesh.vertices.shape) * 1e-7
    inner = receded(Surface(points, np.array(mesh.faces, dtype=np.int64)), 0.05)
    assert np.allclose(np.abs(inner.points).max(axis=1), 0.45, rtol=0, atol=1e-5)
    assert np.linalg.norm(inner.points - points, axis=1).max() <= 0.05 * np.sqrt(3.0) + 1e-5


def test_walls_that_recede_through_each_other_are_refused():
    void = inverted(surface_of(nd.Box((0.992, 0.592, 0.392))))  # walls of 4 mm
    with pytest.raises(nd.InputError, match="larger than a part of it that is thin"):
        surface_mesh(*joined([BOX, void]), rounding=3e-3, cells=CELLS)
    assert surface_mesh(*joined([BOX, void]), rounding=1e-3, cells=CELLS).rounding == 1e-3


def test_a_chamfer_narrower_than_its_rounding_is_refused():
    cut = 2.7e-3  # a chamfer 3.8 mm wide, of which a rounding of 5 mm takes 2 · 5 mm · tan 22.5° = 4.1 mm
    bevelled = prism([[0, 0], [1, 0], [1, 1 - cut], [1 - cut, 1], [0, 1]])
    assert surface_mesh(*bevelled, rounding=4e-3, cells=CELLS).rounding == 4e-3
    with pytest.raises(nd.InputError, match="finely resolved: give less, or 0"):
        surface_mesh(*bevelled, rounding=5e-3, cells=CELLS)


def test_edges_of_voids_that_recede_through_each_other_are_refused():
    # two tetrahedra with edges across each other, 4 mm apart, all corners far from the other
    block = surface_of(nd.Box((2.0, 2.0, 2.0)))
    edge, back = [[-0.3, 0, 0.002], [0.3, 0, 0.002]], [[0, -0.3, 0.3], [0, 0.3, 0.3]]
    upper = Surface(np.array(edge + back), np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))
    lower = Surface(upper.points[:, [1, 0, 2]] * [1, 1, -1], upper.triangles)
    both = joined([block, upper, lower])
    assert surface_mesh(*both, rounding=1e-3, cells=CELLS).rounding == 1e-3
    with pytest.raises(nd.InputError, match="larger than a part of it that is thin"):
        surface_mesh(*both, rounding=3e-3, cells=CELLS)


def test_without_rounding_given_thin_parts_stay_sharp_and_it_is_told():
    thin = surface_of(nd.Box((1.0, 0.6, 0.008), rounding=0.0))
    mesh = surface_mesh(*thin, cells=CELLS)
    assert mesh.rounding == 0.0
    assert "edges left sharp" in mesh.notes[0]
    assert surface_mesh(*BOX, cells=CELLS).rounding == 5e-3
    with pytest.raises(nd.InputError, match=r"rounding is 0.005 m, larger than a part of it that is thin"):
        surface_mesh(*thin, rounding=5e-3, cells=CELLS)


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply"])
def test_a_file_is_read_with_its_volume_and_inertia(tmp_path, suffix):
    path = tmp_path / f"target.{suffix}"
    trimesh.Trimesh(*CONE, process=False).export(path)
    mesh = read_surface(path, cells=CELLS)
    assert mesh.notes == ()
    assert len(mesh.points) == len(CONE.points)
    ours, theirs = mesh.solid(), trimesh.Trimesh(*CONE, process=False)
    # files keep seven or eight digits
    assert ours.mass == pytest.approx(theirs.volume, rel=1e-6)
    assert ours.centre == pytest.approx(theirs.center_mass, abs=1e-6)
    assert ours.inertia == pytest.approx(theirs.moment_inertia, abs=1e-6 * ours.inertia.max())
    assert nd.RigidBody.of_parts([nd.Part(mesh)], mass=3.0).mass == pytest.approx(3.0)


def test_a_file_in_millimetres_is_scaled_or_told(tmp_path):
    path = tmp_path / "target.stl"
    trimesh.Trimesh(1e3 * BOX.points, BOX.triangles, process=False).export(path)
    assert read_surface(path, scale=1e-3, cells=CELLS).solid().mass == pytest.approx(0.24, rel=1e-6)
    surface = Surface(1e3 * BOX.points, BOX.triangles)
    message = (
        r"target.stl: the surface is 1000 m long, 200 times the net of 5 m: .*millimetres give scale = 0.001"
    )
    with pytest.raises(MeshError, match=message):
        check_size(surface, 5.0, "target.stl")
    check_size(BOX, 5.0, "target.stl")
    check_size(moved(BOX, 100.0), 0.1, "a small net, a far target")


def test_a_surface_that_is_inside_out_is_turned_round():
    mesh = surface_mesh(*inverted(BOX), cells=CELLS)
    assert mesh.notes == ("the surface was inside out, turned round",)
    assert mesh.solid().mass == pytest.approx(0.24)
    assert rows_of(mesh, np.zeros((1, 3)))[0, 0] < 0.0


def test_triangles_wound_against_the_others_are_turned_round():
    triangles = BALL.triangles.copy()
    some = np.random.default_rng(6).permutation(len(triangles) - 1)[:200] + 1
    some[0] = 0  # the one from which the others are reached
    triangles[some] = triangles[some][:, ::-1]
    mesh = surface_mesh(BALL.points, triangles, cells=CELLS)
    assert mesh.notes == ("200 triangles wound against the others turned round",)
    assert mesh.solid().mass == pytest.approx(of_surface(BALL).mass)


def test_a_void_is_one_whatever_way_it_is_wound():
    inner = surface_of(nd.Box((0.5, 0.3, 0.2)))
    for void in (inner, inverted(inner)):
        mesh = surface_mesh(*joined([BOX, void]), rounding=0.0, cells=CELLS)
        assert mesh.solid().mass == pytest.approx(0.24 - 0.03)
        assert rows_of(mesh, np.zeros((1, 3)))[0, 0] == pytest.approx(0.1, abs=mesh.error)
        assert len(mesh.notes) == int(void is inner)


def test_points_and_triangles_given_twice_are_kept_once():
    each_on_its_own = Surface(BOX.points[BOX.triangles].reshape(-1, 3), np.arange(36).reshape(-1, 3))
    flat = np.array([[0, 0, 1]])
    triangles = np.concatenate([each_on_its_own.triangles, each_on_its_own.triangles[:2], flat])
    mesh = surface_mesh(each_on_its_own.points, triangles, cells=CELLS)
    assert len(mesh.points) == 8
    assert len(mesh.triangles) == 12
    assert mesh.notes == (
        "1 triangle with two corners at one place dropped",
        "2 triangles given twice, kept once",
    )


def moebius(count=12):
    angle = 2 * np.pi * np.arange(count) / count
    across = 0.2 * np.column_stack([np.cos(angle / 2), np.sin(angle / 2)])
    rims = []
    for s in (1, -1):
        r = 1 + s * across[:, 0]
        rims.append(np.column_stack([r * np.cos(angle), r * np.sin(angle), s * across[:, 1]]))
    strip = []
    for i in range(count):
        a, b = i, count + i
        c, d = (i + 1, count + i + 1) if i < count - 1 else (count, 0)
        strip += [(a, b, c), (b, d, c)]
    return np.concatenate(rims), np.array(strip)


def projective_plane():
    """Its triangulation by six points: closed, with one side."""
    ring = [1, 2, 3, 4, 5]
    faces = [(0, ring[i], ring[(i + 1) % 5]) for i in range(5)]
    faces += [(ring[i], ring[(i + 1) % 5], ring[(i + 3) % 5]) for i in range(5)]
    return np.random.default_rng(7).normal(size=(6, 3)), np.array(faces)


def with_a_fin():
    """Two tetrahedra on both sides of a triangle that is there too."""
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -1]]
    faces = [(0, 1, 2), (0, 1, 3), (0, 1, 4), (1, 2, 3), (0, 2, 3), (1, 2, 4), (0, 2, 4)]
    return np.array(points, dtype=float), np.array(faces)


@pytest.mark.parametrize(
    ("surface", "message"),
    [
        (Surface(BOX.points, BOX.triangles[:-1]), r"is open: 3 of 18 edges belong to one triangle only, the first"),
        (joined([BOX, moved(BOX, (0.9, 0.1, 0.05))]), r"crosses itself: \d+ edges through a triangle, first at \("),
        (moebius(), r"is open: 24 of 48 edges"),
        (projective_plane(), r"has one side only, like a Möbius strip"),
        (Surface(BOX.points, BOX.triangles[:0]), r"has no triangles: a target needs a closed surface, not a net"),
        (Surface(BOX.points * np.nan, BOX.triangles), r"not a finite number"),
        (Surface(BOX.points * 0.0, BOX.triangles), r"at one place"),
        (Surface(BOX.points * [1, 1, 0], BOX.triangles), r"the surface is branched|the surface is open|no volume"),
        (with_a_fin(), r"is branched: 3 of 9 edges join three"),
    ],
    ids=["open", "crossing", "Möbius", "projective plane", "empty", "nan", "point", "flat", "branched"],
)  # fmt: skip
def test_what_is_no_closed_surface_is_refused_in_one_line(surface, message):
    with pytest.raises(MeshError, match=message) as caught:
        surface_mesh(*surface, cells=CELLS)
    assert "\n" not in str(caught.value)


def test_pieces_that_lie_on_each_other_are_refused():
    on_top = moved(surface_of(nd.Box((0.5, 0.3, 0.2))), (0.1, 0.05, 0.3))
    with pytest.raises(MeshError, match="inside of the surface cannot be told from its outside everywhere"):
        surface_mesh(*joined([BOX, on_top]), rounding=0.0, cells=CELLS)
    apart = surface_mesh(*joined([BOX, moved(on_top, (0.0, 0.0, 1e-3))]), rounding=0.0, cells=CELLS)
    assert apart.solid().mass == pytest.approx(0.24 + 0.03)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("absent.stl", None, r"absent.stl: cannot be read: No such file"),
        ("empty.stl", b"", r"empty.stl: the file is empty"),
        ("net.vtu", b"<VTKFile>", r"net.vtu: this is the format of a net, and a target needs a closed surface"),
        ("part.step", b"ISO", r"part.step: the format .step is not known: give one of .stl, .obj, .ply"),
        ("broken.ply", b"ply\nformat ascii 1.0\nelement vertex 5\n", r"broken.ply: cannot be read as PLY"),
        ("broken.stl", b"\x00" * 200, r"broken.stl: (cannot be read as STL|the file has no triangles)"),
        ("lines.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nl 2 3\n", r"lines.obj: .*no triangles|cannot be read as OBJ"),
        ("open.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", r"open.obj: the surface is open: 3 of 3 edges"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_surface_is_refused_in_one_line(tmp_path, name, content, message):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(MeshError, match=message) as caught:
        read_surface(tmp_path / name, cells=CELLS)
    assert "\n" not in str(caught.value)


def test_without_trimesh_it_is_told_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(
        MeshError, match=r"x.stl: .*trimesh, which is missing: pip install 'netdae\[capture\]'"
    ):
        read_surface(tmp_path / "x.stl")


def test_a_grid_is_taken_from_disk_the_second_time(own_cache, monkeypatch):
    first = surface_mesh(*BOX, cells=CELLS)
    assert len(list(own_cache.iterdir())) == 1

    def never(*given):
        raise AssertionError("the grid was made again")

    with monkeypatch.context() as patch:
        patch.setattr(surface_grid, "signed_distances", never)
        again = surface_mesh(*BOX, cells=CELLS)
    assert np.array_equal(again.values, first.values)
    assert (again.error, again.spacing) == (first.error, first.spacing)
    surface_mesh(*BOX, cells=CELLS, rounding=0.0)
    surface_mesh(*BOX, cells=CELLS + 1)
    surface_mesh(*moved(BOX, 1e-6), cells=CELLS)
    assert len(list(own_cache.iterdir())) == 4


def test_without_a_place_for_the_cache_the_grid_is_made_each_time(own_cache, monkeypatch):
    own_cache.write_text("a file where the folder should be", encoding="utf-8")
    first = surface_mesh(*BOX, cells=CELLS)
    monkeypatch.setattr(surface_grid, "cache_folder", lambda: None)
    assert np.array_equal(surface_mesh(*BOX, cells=CELLS).values, first.values)


def test_a_grid_cut_short_on_disk_is_made_anew(own_cache):
    first = surface_mesh(*BOX, cells=CELLS)
    (file,) = own_cache.iterdir()
    file.write_bytes(file.read_bytes()[:1000])
    assert np.array_equal(surface_mesh(*BOX, cells=CELLS).values, first.values)


def test_the_cache_folder_is_the_one_of_the_system(monkeypatch, tmp_path):
    monkeypatch.undo()
    for platform, name, value in (("linux", "XDG_CACHE_HOME", tmp_path), ("win32", "LOCALAPPDATA", tmp_path)):
        monkeypatch.setattr(surface_grid.sys, "platform", platform)
        monkeypatch.setenv(name, str(value))
        assert surface_grid.cache_folder() == tmp_path / "netdae" / "grids"
    monkeypatch.setattr(surface_grid.sys, "platform", "darwin")
    assert surface_grid.cache_folder().parts[-4:] == ("Library", "Caches", "netdae", "grids")


def test_bad_numbers_are_refused(tmp_path):
    with pytest.raises(nd.InputError, match=r"cells is 4: give 8 to 256"):
        read_surface(tmp_path / "x.stl", cells=4)
    with pytest.raises(nd.InputError, match=r"scale is 0 m: give"):
        read_surface(tmp_path / "x.stl", scale=0.0)
    with pytest.raises(nd.InputError, match="rounding is -1 m"):
        surface_mesh(*BOX, rounding=-1.0)
