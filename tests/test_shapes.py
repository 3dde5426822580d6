"""Signed distances of rigid shapes, and their mass properties.

A closed convex set with the support function h(u) = max over its points of u · y has the signed distance
φ(q) = max over unit u of u · q − h(u), inside and outside. So φ is exact if n · q − h(n) = φ for its own n, and no
other direction gives more. The support functions are written here from each shape's faces, apart from the package.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation
from trimesh.triangles import closest_point

import netdae as nd
from netdae.core.records import Record
from netdae.model.shapes.distance import closest_parts, curvature_at, curvatures, distance_at
from netdae.model.shapes.kinds import FRUSTUM, GRID
from netdae.model.shapes.part import parts_of, surface_of
from netdae.model.shapes.rigid_body import principal
from netdae.model.shapes.solid import joined_solids, of_surface
from netdae.model.shapes.surfaces import distinct

ROUND_OFF = 1e-12  # sizes are 1 m
BALL = np.random.default_rng(0).normal(size=(20, 3))
CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
TETRAHEDRON = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]

SHAPES = {
    "sphere": nd.Sphere(0.7),
    "capsule": nd.Capsule(0.3, 1.4),
    "plane": nd.Plane(),
    "box": nd.Box((1.0, 0.6, 0.4), rounding=0.1),
    "sharp box": nd.Box((1.0, 0.6, 0.4), rounding=0.0),
    "box that is a plate within": nd.Box((1.0, 0.6, 0.4), rounding=0.2),
    "cylinder": nd.Cylinder(0.5, 0.9, rounding=0.1),
    "sharp cylinder": nd.Cylinder(0.5, 0.9, rounding=0.0),
    "nozzle": nd.Cone(0.6, 0.2, 0.8, rounding=0.05),
    "nozzle upwards": nd.Cone(0.2, 0.6, 0.8, rounding=0.0),
    "apex": nd.Cone(0.5, 0.0, 0.8, rounding=0.05),
    "apex within only": nd.Cone(0.04, 0.5, 0.8, rounding=0.1),
    "cube as a hull": nd.ConvexHull(CUBE, rounding=0.1),
    "sharp cube as a hull": nd.ConvexHull(CUBE, rounding=0.0),
    "tetrahedron": nd.ConvexHull(TETRAHEDRON, rounding=0.03),
    "hull": nd.ConvexHull(BALL / np.linalg.norm(BALL, axis=1, keepdims=True), rounding=0.1),
    "sharp hull": nd.ConvexHull(BALL, rounding=0.0),
}
FINITE = [name for name in SHAPES if name != "plane"]
PLACE = np.array([0.3, -0.2, 0.5])
ATTITUDE = np.array([0.5, -0.1, 0.7, 0.4]) / math.sqrt(0.91)


def rows_of(shape, points, position=(0, 0, 0), attitude=(1, 0, 0, 0)):
    parts = parts_of([nd.Part(shape, position, attitude)])
    return curvatures(parts.kind[0], parts.first[0], parts.numbers, np.ascontiguousarray(points, dtype=float))


def phi_and_n(shape, points, **place):
    rows = rows_of(shape, points, **place)
    return rows[:, 0], rows[:, 1:4]


def hessians(rows):
    xx, yy, zz, xy, xz, yz = rows[:, 4:].T
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)


def around(shape, count, seed=1):
    """Random points in and near a shape, some of them within 1 cm of its surface."""
    rng = np.random.default_rng(seed)
    low, high = (-1.5, 1.5) if isinstance(shape, nd.Plane) else extent(shape)
    points = rng.uniform(low - 0.4, high + 0.4, (count, 3))
    phi, n = phi_and_n(shape, points[::2])
    points[::2] += (rng.uniform(-0.01, 0.01, len(phi)) - phi)[:, None] * n
    return points


def extent(shape):
    points = shape.surface().points
    return points.min(axis=0), points.max(axis=0)


def directions(count, seed=2):
    u = np.random.default_rng(seed).normal(size=(count, 3))
    u[: count // 4] *= np.random.default_rng(seed).integers(
        0, 2, (count // 4, 3)
    )  # along axes and in their planes
    u = u[np.linalg.norm(u, axis=1) > 0]
    return u / np.linalg.norm(u, axis=1, keepdims=True)


def support(shape, u):
    """h of a shape, (k,): that of the set that is left when all faces recede by the rounding, and the rounding."""
    across = np.hypot(u[:, 0], u[:, 1])
    if isinstance(shape, nd.Sphere):
        return np.full(len(u), shape.radius)
    if isinstance(shape, nd.Capsule):
        return shape.radius + (shape.length / 2 - shape.radius) * np.abs(u[:, 2])
    if isinstance(shape, nd.Box):
        return np.abs(u) @ (np.array(shape.size) / 2 - shape.rounding) + shape.rounding
    if isinstance(shape, nd.Cylinder):
        r, z = shape.radius - shape.rounding, shape.length / 2 - shape.rounding
        return r * across + z * np.abs(u[:, 2]) + shape.rounding
    if isinstance(shape, nd.Cone):
        z = shape.length / 2
        slope = np.array([shape.length, shape.base_radius - shape.top_radius])
        slope /= np.linalg.norm(slope)
        level = slope @ [shape.base_radius, -z] - shape.rounding
        rims = [
            ((level - slope[1] * end) / slope[0], end) for end in (shape.rounding - z, z - shape.rounding)
        ]
        rims = [(r, end) if r >= 0 else (0.0, level / slope[1]) for r, end in rims]
        return np.max([r * across + end * u[:, 2] for r, end in rims], axis=0) + shape.rounding
    points = np.asarray(shape.points)
    if shape.rounding == 0.0:
        return (u @ points.T).max(axis=1)
    from scipy.spatial import ConvexHull

    planes = ConvexHull(points).equations
    return np.array([most_along(each, planes, shape.rounding) for each in u])


def most_along(u, planes, rounding):
    found = linprog(-u, planes[:, :3], -planes[:, 3] - rounding, bounds=[(None, None)] * 3)
    return -found.fun + rounding


@pytest.mark.parametrize("name", FINITE)
def test_phi_is_the_distance_in_the_direction_of_its_normal(name):
    shape = SHAPES[name]
    points = around(shape, 60 if "hull" in name or name == "tetrahedron" else 2000)
    phi, n = phi_and_n(shape, points)
    # LP solvers keep 1e-9
    assert np.allclose(np.sum(n * points, axis=1) - support(shape, n), phi, rtol=0, atol=1e-8)


@pytest.mark.parametrize("name", FINITE)
def test_no_direction_gives_a_larger_distance(name):
    shape = SHAPES[name]
    u = directions(60 if "hull" in name or name == "tetrahedron" else 1000)
    points = around(shape, 1000)
    phi, _ = phi_and_n(shape, points)
    assert np.all((points @ u.T - support(shape, u)).max(axis=1) <= phi + 1e-8)


def test_phi_of_a_plane_is_the_height():
    points = around(nd.Plane(), 50)
    phi, n = phi_and_n(nd.Plane(), points)
    assert np.array_equal(phi, points[:, 2])
    assert np.array_equal(n, np.tile([0.0, 0.0, 1.0], (50, 1)))


@pytest.mark.parametrize("name", SHAPES)
def test_normal_and_hessian_are_the_derivatives(name):
    shape = SHAPES[name]
    points = around(shape, 2000)
    place = {"position": PLACE, "attitude": ATTITUDE}
    points = PLACE + points @ Rotation.from_quat(ATTITUDE, scalar_first=True).as_matrix().T
    rows = rows_of(shape, points, **place)
    H = hessians(rows)
    step = 1e-5
    ahead = [rows_of(shape, points + step * axis, **place) for axis in np.eye(3)]
    behind = [rows_of(shape, points - step * axis, **place) for axis in np.eye(3)]
    # a stencil that crosses from one face, edge or vertex to another sees two Hessians, or two normals inside
    across = np.zeros(len(points), dtype=bool)
    for other in ahead + behind:
        change = np.abs(hessians(other) - H).max(axis=(1, 2))
        across |= change > 50 * step * (np.abs(H).max(axis=(1, 2)) + 0.5) ** 2
        across |= np.abs(other[:, 1:4] - rows[:, 1:4]).max(axis=1) > 50 * step * (
            1 + np.abs(H).max(axis=(1, 2))
        )
    assert np.mean(across) < 0.03
    # points near the centre or an edge have Hessians to 1/d
    kept = ~across & (np.abs(H).max(axis=(1, 2)) < 100)
    assert np.mean(kept) > 0.85
    for axis in range(3):
        of_phi = (ahead[axis][:, 0] - behind[axis][:, 0]) / (2 * step)
        of_n = (ahead[axis][:, 1:4] - behind[axis][:, 1:4]) / (2 * step)
        # errors of central differences are step² times the third derivative, here below 2 max |H|²
        scale = 1 + np.abs(H).max(axis=(1, 2)) ** 3
        assert np.all(np.abs(of_phi - rows[:, 1 + axis])[kept] < 1e-9 * scale[kept])
        assert np.all(np.abs(of_n - H[:, axis])[kept].max(axis=1) < 2e-9 * scale[kept])


# what the closest point is on: a Hessian has rank 0 on a face, 1 on an edge, 2 at a vertex
@pytest.mark.parametrize(
    ("name", "seen"),
    [
        ("box", {0, 1, 2}),
        ("cylinder", {0, 1, 2}),  # flat ends, the side, the rims
        ("nozzle", {0, 1, 2}),
        ("apex", {0, 1, 2}),
        ("cube as a hull", {0, 1, 2}),
        ("tetrahedron", {0, 1, 2}),
        ("sharp hull", {0, 1, 2}),
        ("capsule", {1, 2}),
        ("sphere", {2}),
        ("plane", {0}),
    ],
)
def test_the_points_of_these_tests_see_every_kind_of_feature(name, seen):
    H = hessians(rows_of(SHAPES[name], around(SHAPES[name], 2000)))
    ranks = np.sum(np.linalg.eigvalsh(H) > 1e-6, axis=1)
    assert set(ranks.tolist()) == seen
    assert min(np.bincount(ranks, minlength=3)[sorted(seen)]) > 20


@pytest.mark.parametrize("name", SHAPES)
def test_the_normal_turns_no_faster_than_the_distance_to_the_core_allows(name):
    shape = SHAPES[name]
    points = around(shape, 3000)
    rounding = shape.core().offset
    d = phi_and_n(shape, points)[0] + rounding
    outside = d > 0.01
    rng = np.random.default_rng(3)
    others = points + rng.normal(size=points.shape) * 0.02 * rng.uniform(0, 1, (len(points), 1))
    step = np.linalg.norm(others - points, axis=1)
    other_d, other_n = phi_and_n(shape, others)
    outside &= other_d + rounding > 0.01
    turn = np.linalg.norm(other_n - phi_and_n(shape, points)[1], axis=1)
    assert outside.sum() > 500
    # projections on a convex core are no farther apart than the points, so the unit vectors from them turn by step/d
    assert np.all(turn[outside] <= 2.0 * (step / np.minimum(d, other_d + rounding))[outside] + ROUND_OFF)


@pytest.mark.parametrize("name", SHAPES)
def test_phi_is_convex_with_slope_one(name):
    shape = SHAPES[name]
    a, b = around(shape, 3000), around(shape, 3000, seed=4)
    (phi_a, n), (phi_b, _), (middle, _) = (phi_and_n(shape, each) for each in (a, b, 0.5 * (a + b)))
    assert np.all(np.abs(phi_a - phi_b) <= np.linalg.norm(a - b, axis=1) + ROUND_OFF)
    assert np.all(middle <= 0.5 * (phi_a + phi_b) + ROUND_OFF)
    assert np.allclose(np.linalg.norm(n, axis=1), 1.0, rtol=0, atol=ROUND_OFF)
    core = shape.core()
    assert core.convex
    assert core.lipschitz == 1.0


@pytest.mark.parametrize("name", SHAPES)
def test_nothing_is_not_a_number(name):
    shape = SHAPES[name]
    special = [
        shape.surface().points,
        [[0, 0, 0], [0, 0, 0.1], [0, 0, 2], [0, 0, -2], [1e-200, 0, 0], [1e-160, 1e-170, -1e-165]],
        [[0, 0, 1e-310], [1e300 / 1e150, 0, 0], [0.4, 0, 0.35], [0.5, 0.3, 0.2], [0.4, 0.2, 0.1]],
    ]
    for edge in (0.1, 0.2, 0.3, 0.35, 0.4, 0.45, 0.5, 0.6, 0.7):
        special += [np.concatenate([edge * np.eye(3), -edge * np.eye(3)]), edge * CUBE]
    rows = rows_of(shape, np.concatenate(special))
    assert np.isfinite(rows[:, :4]).all()
    assert not np.isnan(rows).any()
    assert np.allclose(np.linalg.norm(rows[:, 1:4], axis=1), 1.0, rtol=0, atol=ROUND_OFF)


@pytest.mark.parametrize("name", SHAPES)
def test_a_point_that_is_not_a_number_has_no_distance(name):
    assert np.isnan(rows_of(SHAPES[name], [[np.nan, 0.1, 0.1], [0.1, 0.1, np.nan]])[:, 0]).all()


@pytest.mark.parametrize("name", FINITE)
def test_faces_stay_where_they_are_when_edges_are_rounded(name):
    shape = SHAPES[name]
    surface = surface_of(shape)
    corners = surface.points[surface.triangles]
    size = np.ptp(surface.points, axis=0).max()
    phi, _ = phi_and_n(shape, corners.mean(axis=1))
    chord = 0.0 if isinstance(shape, nd.Box | nd.ConvexHull) else size * math.pi**2 / 2 / 48**2
    if shape.core().offset == 0.0:
        assert np.allclose(phi_and_n(shape, surface.points)[0], 0.0, rtol=0, atol=ROUND_OFF)
        assert np.all(np.abs(phi) <= chord + ROUND_OFF)
    else:
        assert np.min(np.abs(phi)) <= chord + 1e-9  # vertices of receded hulls keep 1e-10
        assert np.all(phi >= -chord - 1e-9)  # nothing grows


@pytest.mark.parametrize(
    "name", ["sphere", "capsule", "sharp box", "sharp cylinder", "nozzle upwards", "sharp hull"]
)
def test_the_triangulated_surface_is_as_far_as_phi_says(name):
    surface = surface_of(SHAPES[name])
    v = surface.points[surface.triangles]
    points = around(SHAPES[name], 60)
    pairs = np.tile(v, (len(points), 1, 1)), np.repeat(points, len(v), axis=0)
    nearest = np.linalg.norm(closest_point(*pairs) - pairs[1], axis=1).reshape(len(points), -1).min(axis=1)
    phi = np.abs(phi_and_n(SHAPES[name], points)[0])
    chord = (
        0.0 if "box" in name or "hull" in name else 2 * 0.7 * (1 - math.cos(math.pi / 48))
    )  # twice on a sphere
    assert np.allclose(nearest, phi, rtol=0, atol=chord + ROUND_OFF)


def test_a_part_is_placed_by_its_position_and_attitude():
    turn = Rotation.from_quat(ATTITUDE, scalar_first=True).as_matrix()
    shape = SHAPES["nozzle"]
    q = around(shape, 200)
    here, there = rows_of(shape, q), rows_of(shape, PLACE + q @ turn.T, PLACE, ATTITUDE)
    assert np.allclose(there[:, 0], here[:, 0], rtol=0, atol=ROUND_OFF)
    assert np.allclose(there[:, 1:4], here[:, 1:4] @ turn.T, rtol=0, atol=ROUND_OFF)
    H = turn @ hessians(here) @ turn.T
    assert np.allclose(hessians(there), H, rtol=0, atol=ROUND_OFF * np.abs(H).max())


def test_a_compound_is_seen_through_its_record_part_by_part():
    parts = parts_of([nd.Part(shape, 2.0 * k * PLACE, ATTITUDE) for k, shape in enumerate(SHAPES.values())])
    record = Record(parts)
    points = np.random.default_rng(6).uniform(-3, 3, (5, 3))
    for p, shape in enumerate(SHAPES.values()):
        rows = rows_of(shape, points, 2.0 * p * PLACE, ATTITUDE)
        for point, row in zip(points, rows, strict=True):
            assert np.allclose(
                curvature_at(record.address, p, *point), row, rtol=0, atol=1e-9 * np.abs(row).max()
            )
            assert np.allclose(distance_at(record.address, p, *point), row[:4], rtol=0, atol=ROUND_OFF)
            # the sphere around each part bounds its distance from below
            assert row[0] >= np.linalg.norm(point - parts.centre[p]) - parts.radius[p] - ROUND_OFF
    least, part = closest_parts(parts.kind, parts.first, parts.numbers, points)
    all_of_them = [
        [distance_at(record.address, p, *point)[0] for p in range(len(SHAPES))] for point in points
    ]
    assert np.allclose(least, np.min(all_of_them, axis=1), rtol=0, atol=ROUND_OFF)
    assert np.array_equal(part, np.argmin(all_of_them, axis=1))


@pytest.mark.parametrize("name", FINITE)
def test_the_sphere_around_a_part_contains_it(name):
    core = SHAPES[name].core()
    u = directions(500)
    on_it = np.array(core.centre) + core.radius * u
    assert np.all(phi_and_n(SHAPES[name], on_it)[0] >= -ROUND_OFF)
    assert core.radius <= np.linalg.norm(np.ptp(np.array(extent(SHAPES[name])), axis=0)) / 2 * 1.2


# a polynomial that a trilinear interpolation reproduces
def trilinear(q):
    x, y, z = q.T
    value = 0.3 + 0.2 * x - 0.5 * y + 0.1 * z + 0.2 * x * y - 0.1 * y * z + 0.15 * x * z + 0.3 * x * y * z
    slope = [0.2 + 0.2 * y + 0.15 * z + 0.3 * y * z, -0.5 + 0.2 * x - 0.1 * z + 0.3 * x * z]
    slope.append(0.1 - 0.1 * y + 0.15 * x + 0.3 * x * y)
    mixed = [0.2 + 0.3 * z, 0.15 + 0.3 * y, -0.1 + 0.3 * x]
    return np.column_stack([value, *slope, *np.zeros((3, len(q))), *mixed])


def grid_of(function, origin=(-0.5, -0.4, -0.3), spacing=0.1, counts=(11, 9, 8)):
    index = np.indices(counts).reshape(3, -1).T
    values = function(np.array(origin) + spacing * index).reshape(counts)
    cube = surface_of(nd.Box((0.2, 0.2, 0.2)))
    return nd.SurfaceMesh(cube.points, cube.triangles, origin, spacing, values, error=0.0)


def test_a_grid_is_interpolated_trilinearly_with_its_own_derivatives():
    grid = grid_of(lambda q: trilinear(q)[:, 0])
    points = np.random.default_rng(7).uniform([-0.5, -0.4, -0.3], [0.5, 0.4, 0.4], (500, 3))
    assert np.allclose(rows_of(grid, points), trilinear(points), rtol=0, atol=1e-11)
    assert grid.core().kind == GRID
    assert not grid.core().convex


def test_beyond_a_grid_phi_is_a_lower_bound_and_goes_on_without_a_jump():
    grid = grid_of(lambda q: np.linalg.norm(q, axis=1) - 0.1)
    rng = np.random.default_rng(8)
    points = rng.normal(size=(2000, 3))
    outside = (np.abs(points) > [0.51, 0.41, 0.41]).any(axis=1)
    rows = rows_of(grid, points)
    phi = np.linalg.norm(points, axis=1) - 0.1
    assert np.all(rows[outside, 0] <= phi[outside] + 0.013)  # what the grid is off by, h²/(4 r)
    assert np.all(rows[outside, 0] >= 0.5 * phi[outside])
    others = points + rng.normal(size=points.shape) * 1e-6
    jump = np.abs(rows_of(grid, others)[:, 0] - rows[:, 0])
    assert np.all(jump <= grid.lipschitz * np.linalg.norm(others - points, axis=1) + ROUND_OFF)
    step = 1e-6
    for axis, unit in enumerate(np.eye(3)):
        ahead, behind = rows_of(grid, points + step * unit), rows_of(grid, points - step * unit)
        smooth = np.abs(ahead[:, 1:4] - behind[:, 1:4]).max(axis=1) < 1e-4
        assert smooth.mean() > 0.95
        assert np.allclose(((ahead - behind)[:, 0] / (2 * step))[smooth], rows[smooth, 1 + axis], atol=1e-7)
        off = ((ahead - behind)[:, 1:4] / (2 * step) - hessians(rows)[:, axis])[smooth & outside]
        assert np.all(np.abs(off) < 1e-5)


def test_far_from_numbers_a_grid_stays_in_its_memory():
    grid = grid_of(lambda q: np.linalg.norm(q, axis=1) - 0.1)
    rows = rows_of(grid, [[np.nan, 0, 0], [1e30, 0, 0], [0, -1e30, 0]])
    assert np.isnan(rows[0, 0])
    assert np.allclose(rows[1:3, 0], 1e30)


def by_integration(radius, low, high):
    """Volume and inertia of a body of revolution of unit density about the z axis, and about x through the origin."""
    volume = quad(lambda z: math.pi * radius(z) ** 2, low, high, epsabs=1e-13)[0]
    along = quad(lambda z: math.pi / 2 * radius(z) ** 4, low, high, epsabs=1e-13)[0]
    return (
        volume,
        along,
        along / 2 + quad(lambda z: math.pi * (radius(z) * z) ** 2, low, high, epsabs=1e-13)[0],
    )


@pytest.mark.parametrize(
    ("shape", "radius", "half"),
    [
        (nd.Sphere(0.7), lambda z: math.sqrt(max(0.49 - z * z, 0.0)), 0.7),
        (nd.Capsule(0.3, 1.4), lambda z: math.sqrt(max(0.09 - max(abs(z) - 0.4, 0.0) ** 2, 0.0)), 0.7),
        (nd.Cylinder(0.5, 0.9), lambda z: 0.5, 0.45),
        (nd.Cone(0.6, 0.2, 0.8), lambda z: 0.4 - 0.5 * z, 0.4),
        (nd.Cone(0.0, 0.5, 0.8), lambda z: 0.25 + 0.625 * z, 0.4),
    ],
)
def test_mass_properties_of_revolution_are_the_integrals(shape, radius, half):
    solid = shape.solid()
    volume, along, across = by_integration(radius, -half, half)
    first = quad(lambda z: math.pi * radius(z) ** 2 * z, -half, half, epsabs=1e-13)[0]
    across -= first**2 / volume
    # quad meets the square roots at the ends of spheres to 1e-9
    assert solid.mass == pytest.approx(volume, rel=1e-8)
    assert solid.centre == pytest.approx([0, 0, first / volume], abs=1e-8)
    assert solid.inertia == pytest.approx(np.diag([across, across, along]), rel=1e-8, abs=1e-12)


def test_a_hull_of_the_corners_of_a_box_has_its_mass_properties_wherever_it_is():
    box = nd.Part(nd.Box((1.0, 0.6, 0.4)), PLACE, ATTITUDE)
    hull = nd.ConvexHull(box.surface().points)
    assert len(hull.polytope.faces) == 6
    ours, theirs = box.solid(), hull.solid()
    assert theirs.mass == pytest.approx(0.24, rel=ROUND_OFF)
    assert theirs.centre == pytest.approx(PLACE, abs=ROUND_OFF)
    assert theirs.inertia == pytest.approx(ours.inertia, abs=ROUND_OFF)
    assert np.linalg.eigvalsh(ours.inertia) == pytest.approx(
        [0.02 * (0.36 + 0.16), 0.02 * (1 + 0.16), 0.02 * (1 + 0.36)], rel=ROUND_OFF
    )


def test_points_that_almost_coincide_are_one():
    cube = np.concatenate([CUBE, CUBE + 1e-12, CUBE + 0.5e-9])
    hull = nd.ConvexHull(cube, rounding=0.1)
    assert len(hull.polytope.points) == 8
    assert len(hull.polytope.faces) == 6
    first, same = distinct(np.array([[0.0, 0, 0], [1, 0, 0], [1e-10, 0, 0], [1, 0, 0]]), 1e-9)
    assert np.array_equal(first[same], [0, 1, 0, 1])


@pytest.mark.parametrize(
    "points", [[], [[1, 2, 3]], [[0, 0, 0], [1, 1, 1]], CUBE[[0, 1, 2, 0]], CUBE[[0] * 5]]
)
def test_points_without_a_volume_have_no_hull(points):
    with pytest.raises(nd.InputError, match="convex hull"):
        nd.ConvexHull(points)


def test_two_halves_are_the_whole():
    half = nd.Box((0.5, 0.6, 0.4))
    parts = [nd.Part(half, (-0.25, 0, 0)), nd.Part(half, (0.25, 0, 0))]
    whole, joined = nd.Box((1.0, 0.6, 0.4)).solid(), joined_solids([part.solid() for part in parts])
    assert joined.mass == pytest.approx(whole.mass)
    assert joined.inertia == pytest.approx(whole.inertia, abs=1e-15)
    by_mass = nd.RigidBody.of_parts(parts, masses=[30.0, 10.0])
    assert by_mass.mass == pytest.approx(40.0)
    assert by_mass.centre == pytest.approx([-0.125, 0, 0])
    # each half (a² + b²) m/12 about its own centre, and 30 (0.125)² + 10 (0.375)² for the places
    assert by_mass.inertia[2] == pytest.approx(40 * (0.25 + 0.36) / 12 + 30 * 0.125**2 + 10 * 0.375**2)
    by_density, by_total = (
        nd.RigidBody.of_parts(parts, density=500.0),
        nd.RigidBody.of_parts(parts, mass=120.0),
    )
    assert by_density.mass == pytest.approx(120.0)
    assert by_density.tensor == pytest.approx(by_total.tensor)


@pytest.mark.parametrize("name", FINITE)
def test_the_surface_holds_the_volume_seen_from_outside(name):
    shape = SHAPES[name]
    exact, polyhedral = shape.solid(), of_surface(surface_of(shape))
    loss = 0.02  # of chords: (2/3) (π/48)² across, twice as much for spheres
    assert (1 - loss) * exact.mass <= polyhedral.mass <= exact.mass * (1 + ROUND_OFF)
    assert polyhedral.centre == pytest.approx(exact.centre, abs=0.01)
    assert polyhedral.inertia == pytest.approx(exact.inertia, abs=2 * loss * exact.inertia.max())


def test_principal_axes_are_a_rotation_that_gives_the_tensor_back():
    rng = np.random.default_rng(9)
    for _ in range(50):
        points = rng.normal(size=(6, 3)) * [1.0, 2.0, 0.3]
        tensor = sum(np.dot(y, y) * np.eye(3) - np.outer(y, y) for y in points)
        body = nd.RigidBody.from_inertia(3.0, tensor, centre=PLACE)
        assert body.tensor == pytest.approx(tensor, abs=1e-12 * tensor.max())
        turn = Rotation.from_quat(body.axes, scalar_first=True).as_matrix()
        assert np.linalg.det(turn) == pytest.approx(1.0)
        assert np.all(np.diag(turn) > 0.0) or np.trace(turn) > 0.0  # the closest to the body's own


def test_a_diagonal_tensor_keeps_its_order_and_axes():
    for moments in ([3.0, 2.0, 4.0], [1.0, 1.0, 1.0]):
        found, axes = principal(np.diag(moments))
        assert np.array_equal(found, moments)
        assert np.array_equal(axes, [1, 0, 0, 0])


def test_a_body_seen_from_its_principal_axes_is_the_same_body():
    parts = [nd.Part(nd.Box((1.0, 0.6, 0.4)), PLACE, ATTITUDE), nd.Part(nd.Cone(0.5, 0.2, 0.7), (1, 0, 0))]
    body = nd.RigidBody.of_parts(parts, density=300.0)
    seen = [part.seen_from(body.centre, body.axes) for part in parts]
    solid = joined_solids([part.solid().times(300.0) for part in seen])
    assert solid.centre == pytest.approx(np.zeros(3), abs=ROUND_OFF)
    assert solid.inertia == pytest.approx(np.diag(body.inertia), abs=1e-12 * body.inertia.max())
    points = np.random.default_rng(10).uniform(-1.5, 1.5, (200, 3))
    turn = Rotation.from_quat(body.axes, scalar_first=True)
    there = turn.inv().apply(points - body.centre)
    here, far = parts_of(parts), parts_of(seen)
    assert np.allclose(
        closest_parts(here.kind, here.first, here.numbers, points)[0],
        closest_parts(far.kind, far.first, far.numbers, np.ascontiguousarray(there))[0],
        rtol=0,
        atol=ROUND_OFF,
    )


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: nd.Sphere(0.0), r"sphere: radius is 0 m: give a finite number above zero"),
        (lambda: nd.Sphere("1"), r"sphere: radius is '1': give"),
        (lambda: nd.Capsule(0.5, 0.9), r"capsule: length is 0.9 m .*give at least 1 m"),
        (lambda: nd.Box((1, 2)), r"box: size is \(1, 2\): give 3 finite numbers"),
        (lambda: nd.Box((1, 2, -1)), r"box: size along z is -1 m"),
        (
            lambda: nd.Box((1, 2, 0.008)),
            r"box: rounding is 0.005 m, larger than the part: give less than 0.004 m",
        ),
        (lambda: nd.Box((1, 2, 3), rounding=-1), r"box: rounding is -1 m: give a finite number zero or more"),
        (lambda: nd.Cylinder(0.2, 1.0, rounding=0.3), r"cylinder: rounding is 0.3 m.*less than 0.2 m"),
        (lambda: nd.Cylinder(0.2, math.inf), r"cylinder: length is inf m"),
        (lambda: nd.Cone(0, 0, 1), r"cone: both radii are 0 m"),
        (lambda: nd.Cone(1, 1, 1, rounding=0.6), r"cone: rounding is 0.6 m.*less than 0.5"),
        (lambda: nd.ConvexHull([[0, 0, 0]]), r"convex hull: points have the shape \(1, 3\)"),
        (lambda: nd.ConvexHull(CUBE[:4]), r"convex hull: its points are all in one plane"),
        (lambda: nd.ConvexHull(CUBE, rounding=0.6), r"convex hull: rounding is 0.6 m.*less than 0.5 m"),
        (lambda: nd.Plane().solid(), r"plane: a half-space has no finite mass"),
        (lambda: nd.Part(nd.Sphere(1), (0, 0)), r"part: position is \(0, 0\)"),
        (lambda: nd.Part(nd.Sphere(1), attitude=(0, 0, 0, 0)), r"part: attitude is the zero quaternion"),
        (lambda: parts_of([]), r"target: it has no parts"),
        (lambda: nd.RigidBody(0.0, (1, 1, 1)), r"target: mass is 0 kg"),
        (lambda: nd.RigidBody(1.0, (1, 1, 3)), r"1, 1, 3 kg m², but no body's largest moment exceeds"),
        (lambda: nd.RigidBody(1.0, (1, 0, 1)), r"1, 0, 1 kg m²: give numbers above zero"),
        (
            lambda: nd.RigidBody.from_inertia(1.0, np.arange(9).reshape(3, 3)),
            r"not symmetric: I_xz is 2 and I_zx is 6",
        ),
        (lambda: nd.RigidBody.from_inertia(1.0, [1, 2]), r"inertia is \[1, 2\]: give three principal"),
        (lambda: nd.RigidBody.of_parts([], mass=1.0), r"it has no parts"),
        (lambda: nd.RigidBody.of_parts([nd.Part(nd.Sphere(1))]), r"just one of mass, masses and density"),
        (lambda: nd.RigidBody.of_parts([nd.Part(nd.Sphere(1))], density=0.0), r"mass or density of a part"),
        (lambda: nd.RigidBody.of_parts([nd.Part(nd.Sphere(1))], masses=[1, 2]), r"has 1 parts|shape \(2,\)"),
    ],
)
def test_bad_input_is_one_clear_line(make, message):
    with pytest.raises(nd.InputError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_the_largest_rounding_of_a_cone_is_its_inscribed_sphere():
    # a cone of radius 3 and height 4: a 3-4-5 triangle twice, with the inscribed radius 12/(3 + 5) = 1.5
    assert nd.Cone(3.0, 0.0, 4.0, rounding=1.499).core().kind == FRUSTUM
    with pytest.raises(nd.InputError, match="rounding"):
        nd.Cone(3.0, 0.0, 4.0, rounding=1.501)
