"""Mesh files: those that other programs wrote, round trips, and files that are no nets."""

import logging
import re

import gmsh
import meshio
import numpy as np
import pytest
import pyvista
from scipy.spatial.distance import pdist

from netdae.core.errors import MeshError
from netdae.mesh.io import SUFFIXES, describe, read_net, write_net
from netdae.model.net import CableNet

# gmsh's points of the frame, and its lines between them
FRAME = [(0, 0), (2, 0), (2, 2), (0, 2)]


@pytest.fixture
def model():
    """A square frame with a diagonal: 2 + 2 + 2 + 2 + 3 lines, groups that overlap, names used twice."""
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("frame")
    geo = gmsh.model.geo
    points = [geo.addPoint(x, y, 0, 1.0) for x, y in FRAME]
    sides = [geo.addLine(points[k], points[(k + 1) % 4]) for k in range(4)]
    diagonal = geo.addLine(points[0], points[2])
    geo.addPoint(5, 5, 0)  # of construction: no cable ends here
    geo.synchronize()
    gmsh.model.addPhysicalGroup(0, points, 1, "corners")
    gmsh.model.addPhysicalGroup(0, points[:2], 2, "border")
    gmsh.model.addPhysicalGroup(1, sides, 3, "border")
    gmsh.model.addPhysicalGroup(1, [sides[0], diagonal], 4, "red cord")
    gmsh.model.addPhysicalGroup(1, [-sides[2]], 5, "turned")
    gmsh.model.addPhysicalGroup(1, [-sides[1]], 9)  # without a name
    gmsh.model.mesh.generate(1)
    yield gmsh.model
    gmsh.finalize()


def write_gmsh(path, version, binary=0, **options):
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    for name, value in options.items():
        gmsh.option.setNumber(f"Mesh.{name}", value)
    gmsh.write(str(path))
    return path


def places(net, group):
    return sorted(map(tuple, net.nodes[net.node_groups[group]].round(6)[:, :2].tolist()))


def length(net, group):
    return net.rest_length[net.cable_groups[group]].sum()


# with SaveAll, elements in no group are written too; 2.2 then has no groups at all
@pytest.mark.parametrize(
    ("version", "binary", "save_all"),
    [(2.2, 0, 0), (2.2, 1, 0), (4.1, 0, 0), (4.1, 1, 0), (4.1, 0, 1), (4.1, 1, 1)],
)
def test_groups_that_gmsh_wrote_are_read(model, tmp_path, version, binary, save_all):
    file = write_gmsh(tmp_path / "frame.msh", version, binary)
    if save_all:
        model.removePhysicalGroups([(1, 9), (1, 5)])
        file = write_gmsh(tmp_path / "frame.msh", version, binary, SaveAll=1)
    found = describe(file)
    net = found.net
    assert (net.node_count, net.cable_count) == (10, 11)
    assert places(net, "corners") == sorted(FRAME)
    assert places(net, "border") == [(0, 0), (2, 0)]  # the points of this name, not the ends of the curves
    # lengths of the curves, which gmsh places to 1e-11
    assert length(net, "border") == pytest.approx(8, rel=1e-9)
    assert length(net, "red cord") == pytest.approx(2 + 8**0.5, rel=1e-9)
    assert len(net.cable_groups["red cord"]) == 5
    assert len(net.node_groups["red cord"]) == 6
    if not save_all:
        assert length(net, "9") == pytest.approx(2, rel=1e-9)
        assert length(net, "turned") == pytest.approx(2, rel=1e-9)
    dropped = [text for text in found.findings if "without a cable" in text]
    assert found.findings == tuple(dropped)  # no line is taken for a double


def test_file_without_any_group_is_read(model, tmp_path):
    model.removePhysicalGroups()
    for version in (2.2, 4.1):
        net = read_net(write_gmsh(tmp_path / f"{version}.msh", version))
        assert net.cable_count == 11
        assert length(net, "all") == pytest.approx(8 + 8**0.5, rel=1e-9)


def test_points_of_construction_are_dropped_and_said(model, tmp_path, caplog):
    model.removePhysicalGroups()
    with caplog.at_level(logging.WARNING):
        net = read_net(write_gmsh(tmp_path / "frame.msh", 4.1))
    assert net.node_count == 10
    assert "1 node without a cable dropped" in caplog.text


@pytest.mark.parametrize(("version", "shown"), [(1, "version 1 "), (4.0, "version 4.0 ")])
def test_versions_that_are_not_read_are_named(model, tmp_path, version, shown):
    with pytest.raises(MeshError, match=shown):
        read_net(write_gmsh(tmp_path / "old.msh", version))


@pytest.mark.parametrize("suffix", [".msh", ".inp"])
def test_quadratic_lines_of_gmsh_are_split_at_their_middle(model, tmp_path, suffix):
    model.mesh.setOrder(2)
    file = write_gmsh(tmp_path / f"frame{suffix}", 4.1)
    found = describe(file)
    assert (found.net.node_count, found.net.cable_count) == (21, 22)
    # a wrong order of the three nodes would make cables of full length and change the total
    assert length(found.net, "all") == pytest.approx(8 + 8**0.5, rel=1e-9)
    assert any("11 lines" in text for text in found.findings)


def test_gmsh_reads_the_groups_that_netdae_writes(tmp_path):
    net = CableNet.diamond(side=2.0, cells=3, subdivide=2)
    file = tmp_path / "net.msh"
    write_net(net, file)
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(file))
        names = {gmsh.model.getPhysicalName(*pair): pair for pair in gmsh.model.getPhysicalGroups(0)}
        for name in ("border", "corners", "centre"):
            tags, _ = gmsh.model.mesh.getNodesForPhysicalGroup(*names[name])
            assert sorted(int(tag) - 1 for tag in tags) == net.node_groups[name].tolist()
        lines = {gmsh.model.getPhysicalName(*pair): pair for pair in gmsh.model.getPhysicalGroups(1)}
        for name in ("border", "inner"):
            pairs = []
            for curve in gmsh.model.getEntitiesForPhysicalGroup(*lines[name]):
                pairs.append(gmsh.model.mesh.getElementsByType(1, int(curve))[1])
            pairs = np.concatenate(pairs).reshape(-1, 2).astype(int) - 1
            np.testing.assert_array_equal(pairs, net.cables[net.cable_groups[name]])
    finally:
        gmsh.finalize()


def rich_net():
    """A bent net with data, rest lengths and overlapping groups."""
    plain = CableNet.square(side=2.0, cells=3, subdivide=2)
    rng = np.random.default_rng(5)
    count = plain.cable_count
    diameter = rng.uniform(1e-4, 1e-3, count)
    diameter[::3] = np.nan  # the material holds
    return CableNet(
        plain.nodes + rng.normal(0, 0.05, plain.nodes.shape),
        plain.cables,
        {**plain.node_groups, "some": [1, 3, 5], "none": []},
        {**plain.cable_groups, "some": [0, 2], "knot-2": np.arange(count)},
        rng.uniform(0.2, 0.4, count),
        {"diameter": diameter, "youngs_modulus": rng.uniform(1e9, 7e10, count)},
    )


def assert_same(net, other):
    np.testing.assert_array_equal(net.nodes, other.nodes)
    np.testing.assert_array_equal(net.cables, other.cables)
    np.testing.assert_array_equal(net.rest_length, other.rest_length)
    assert set(net.cable_data) == set(other.cable_data)
    for name, values in net.cable_data.items():
        np.testing.assert_array_equal(values, other.cable_data[name])
    for groups, others in ((net.node_groups, other.node_groups), (net.cable_groups, other.cable_groups)):
        for name, member in groups.items():
            if len(member):
                np.testing.assert_array_equal(member, others[name])


@pytest.mark.parametrize("suffix", [".vtu", ".vtp", ".vtk", ".msh", ".xdmf"])
def test_net_with_data_survives_the_round_trip_bit_for_bit(tmp_path, suffix):
    net = rich_net()
    write_net(net, tmp_path / f"net{suffix}")
    found = describe(tmp_path / f"net{suffix}")
    assert_same(net, found.net)
    assert found.findings == ()
    assert found.unused_data == ()
    assert [file.name for file in tmp_path.iterdir()] == [f"net{suffix}"]


def test_inp_keeps_groups_and_refuses_data(tmp_path):
    net = CableNet.hexagon(radius=1.0, rings=2, subdivide=3)
    write_net(net, tmp_path / "net.inp")
    assert_same(net, read_net(tmp_path / "net.inp"))
    with pytest.raises(MeshError, match=r"no place for diameter, youngs_modulus, rest_length"):
        write_net(rich_net(), tmp_path / "rich.inp")
    assert not (tmp_path / "rich.inp").exists()


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_net_that_a_file_cannot_hold_is_refused_and_leaves_none(tmp_path, suffix, capfd):
    plain = CableNet([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1]])
    with pytest.raises(MeshError, match="node 2, which has no cable"):
        write_net(plain, tmp_path / f"loose{suffix}")
    double = CableNet([[0, 0, 0], [1, 0, 0]], [[0, 1], [1, 0]])
    with pytest.raises(MeshError, match="1 cables, not the same 2"):
        write_net(double, tmp_path / f"double{suffix}")
    assert list(tmp_path.iterdir()) == []
    if suffix in (".xdmf", ".vtp"):  # they hold any name
        return
    named = CableNet([[0, 0, 0], [1, 0, 0]], [[0, 1]], {'a,"b\nc': [0]})
    with pytest.raises(MeshError, match="cannot hold this net") as caught:
        write_net(named, tmp_path / f"named{suffix}")
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")


def test_netdae_files_open_in_pyvista_with_their_groups(tmp_path):
    net = rich_net()
    for suffix in (".vtu", ".vtk"):
        write_net(net, tmp_path / f"net{suffix}")
        mesh = pyvista.read(tmp_path / f"net{suffix}")
        np.testing.assert_array_equal(mesh.points, net.nodes)
        np.testing.assert_array_equal(mesh.cell_connectivity.reshape(-1, 2), net.cables)
        np.testing.assert_array_equal(np.flatnonzero(mesh.cell_data["border"]), net.cable_groups["border"])
        np.testing.assert_array_equal(np.flatnonzero(mesh.point_data["corners"]), net.node_groups["corners"])


def poly_lines():
    """One triangle, one vertex, then two poly lines of four and three points, and one line."""
    cells = [3, 6, 7, 0, 1, 2, 4, 0, 1, 2, 3, 3, 3, 4, 5, 2, 5, 6]
    kinds = [5, 1, 4, 4, 3]
    points = np.array([[0, 0], [1, 0], [2, 0], [3, 0], [3, 1], [3, 3], [0, 3], [0, 9]], dtype=float)
    grid = pyvista.UnstructuredGrid(cells, kinds, np.column_stack([points, np.zeros(8)]))
    grid.cell_data["red"] = np.array([0, 0, 1, 0, 1], dtype=np.int32)
    grid.cell_data["diameter"] = [np.nan, np.nan, 1.0, 2.0, 3.0]
    grid.cell_data["rest_length"] = [np.nan, np.nan, 6.0, 6.0, 3.0]
    grid.point_data["end"] = np.array([1, 0, 0, 0, 0, 0, 1, 0], dtype=np.uint8)
    return grid


@pytest.mark.parametrize("suffix", [".vtu", ".vtk"])
@pytest.mark.parametrize("binary", [True, False])
def test_poly_lines_become_cables_with_their_data(tmp_path, suffix, binary, capfd):
    file = tmp_path / f"net{suffix}"
    poly_lines().save(file, binary=binary)
    found = describe(file)
    net = found.net
    np.testing.assert_array_equal(net.cables, [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 6]])
    np.testing.assert_array_equal(net.cable_groups["red"], [0, 1, 2, 5])
    np.testing.assert_array_equal(net.node_groups["end"], [0, 6])
    np.testing.assert_array_equal(net.cable_data["diameter"], [1, 1, 1, 2, 2, 3])
    # 6 m shared as 1 : 1 : 1 and as 1 : 2
    np.testing.assert_allclose(net.rest_length, [2, 2, 2, 2, 4, 3], rtol=1e-15)
    text = " ".join(found.findings)
    assert "2 lines of more than two points" in text
    assert "surface cells are left out" in text
    assert "1 node without a cable" in text
    assert capfd.readouterr() == ("", "")


def test_quadratic_lines_of_vtk_are_split_at_their_middle(tmp_path):
    points = np.array([[0, 0, 0], [2, 0, 0], [1, 0, 0], [2, 2, 0], [2, 1, 0]], dtype=float)
    pyvista.UnstructuredGrid([3, 0, 1, 2, 3, 1, 3, 4], [21, 21], points).save(tmp_path / "net.vtk")
    net = read_net(tmp_path / "net.vtk")
    np.testing.assert_array_equal(net.cables, [[0, 2], [2, 1], [1, 4], [4, 3]])
    np.testing.assert_array_equal(net.rest_length, 1)


def test_poly_data_with_lines_is_read(tmp_path):
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    pyvista.PolyData(points, lines=[5, 0, 1, 2, 3, 0]).save(tmp_path / "loop.vtk")
    net = read_net(tmp_path / "loop.vtk")
    np.testing.assert_array_equal(net.cables, [[0, 1], [1, 2], [2, 3], [3, 0]])


def test_all_pieces_of_a_vtu_are_read(tmp_path):
    def piece(x):
        return (
            '<Piece NumberOfPoints="2" NumberOfCells="1"><Points><DataArray type="Float64" NumberOfComponents="3" '
            f'format="ascii">{x} 0 0 {x + 1} 0 0</DataArray></Points><Cells>'
            '<DataArray type="Int64" Name="connectivity" format="ascii">0 1</DataArray>'
            '<DataArray type="Int64" Name="offsets" format="ascii">2</DataArray>'
            '<DataArray type="UInt8" Name="types" format="ascii">3</DataArray></Cells></Piece>'
        )

    head = '<VTKFile type="UnstructuredGrid" version="1.0"><UnstructuredGrid>'
    (tmp_path / "two.vtu").write_text(f"{head}{piece(0)}{piece(5)}</UnstructuredGrid></VTKFile>")
    net = read_net(tmp_path / "two.vtu")
    np.testing.assert_array_equal(net.cables, [[0, 1], [2, 3]])
    np.testing.assert_array_equal(net.nodes[:, 0], [0, 1, 5, 6])


@pytest.mark.parametrize("data_format", ["HDF", "XML"])
def test_xdmf_of_meshio_in_two_dimensions_is_read(tmp_path, data_format):
    mesh = meshio.Mesh(
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]],
        [("line", [[0, 1], [1, 2]])],
        cell_data={"kind": [np.array([7, 3])], "area": [np.array([1e-6, 2e-6])], "tension": [np.zeros(2)]},
    )
    meshio.xdmf.write(tmp_path / "flat.xdmf", mesh, data_format=data_format)
    found = describe(tmp_path / "flat.xdmf")
    np.testing.assert_array_equal(found.net.nodes[:, 2], 0)
    np.testing.assert_array_equal(found.net.cable_data["area"], [1e-6, 2e-6])
    np.testing.assert_array_equal(found.net.cable_groups["kind"], [0, 1])
    np.testing.assert_array_equal(found.net.cable_groups["kind:3"], [1])
    assert found.unused_data == ("tension",)


INP = "*NODE\n1,0,0,0\n2,1,0,0\n3,2,0,0\n4,3,0,0\n"


def test_sets_of_inp_go_to_the_elements_they_name(tmp_path):
    file = tmp_path / "net.inp"
    file.write_text(
        f"*HEADING\n{INP}*ELEMENT, TYPE=T3D2\n1,1,2\n*ELEMENT, TYPE=B31, ELSET=late\n2,2,3\n"
        "*ELEMENT, TYPE=T3D2, ELSET=late\n3,3,4\n*NSET, NSET=ends\n1, 4\n*NSET, NSET=row, GENERATE\n1, 3, 1\n"
        "*ELSET, ELSET=first\n1\n*NODE OUTPUT\nU\n*NODE OUTPUT\nV\n"
    )
    net = read_net(file)
    np.testing.assert_array_equal(net.cable_groups["late"], [1, 2])
    np.testing.assert_array_equal(net.cable_groups["first"], [0])
    np.testing.assert_array_equal(net.node_groups["ends"], [0, 3])
    np.testing.assert_array_equal(net.node_groups["row"], [0, 1, 2])
    np.testing.assert_array_equal(net.node_groups["late"], [1, 2, 3])


def test_edges_of_a_surface_are_a_net_on_request(tmp_path):
    grid = pyvista.ImageData(dimensions=(4, 3, 1)).cast_to_unstructured_grid()
    points, quads = grid.points, grid.cell_connectivity.reshape(-1, 4)[:, [0, 1, 3, 2]]  # pixels
    line = np.array([[0, 1]])
    for cells in ([("quad", quads)], [("quad", quads), ("line", line)]):
        meshio.write_points_cells(tmp_path / "grid.vtu", points, cells)
        found = describe(tmp_path / "grid.vtu", surface_edges=True)
        # 3 × 2 cells of 1 m: 17 edges, 10 of them on the boundary
        assert (found.net.node_count, found.net.cable_count) == (12, 17)
        assert len(found.net.cable_groups["border"]) == 10
        assert len(found.net.node_groups["border"]) == 10
        assert len(found.net.cable_groups["inner"]) == 7
        assert found.findings == ()
    assert read_net(tmp_path / "grid.vtu").cable_count == 1  # the lines alone, unless edges are asked for
    meshio.write_points_cells(tmp_path / "grid.vtu", points, [("quad", quads)])
    with pytest.raises(MeshError, match=r"a surface mesh without lines is no net.*surface_edges"):
        read_net(tmp_path / "grid.vtu")
    meshio.write_points_cells(tmp_path / "line.vtu", points, [("line", line)])
    with pytest.raises(MeshError, match="no surface cells"):
        read_net(tmp_path / "line.vtu", surface_edges=True)


def test_doubles_and_coincident_nodes_are_reported(tmp_path, caplog):
    points = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 0, 1e-13], [1, 1, 0.0]]
    mesh = meshio.Mesh(
        points,
        [("line", [[0, 1], [1, 2], [2, 1], [3, 4], [1, 0]])],
        cell_data={
            "a": [np.array([1, 0, 0, 0, 0])],
            "b": [np.array([0, 1, 1, 0, 1])],
            "diameter": [np.array([np.nan, 2, 3, 4, 5])],
        },
    )
    meshio.vtu.write(tmp_path / "net.vtu", mesh)
    with caplog.at_level(logging.WARNING):
        net = read_net(tmp_path / "net.vtu")
    np.testing.assert_array_equal(net.cables, [[0, 1], [1, 2], [3, 4]])
    # 0–1 is in a and, written again, in b: one cable in both; 1–2 twice in b is a slip
    np.testing.assert_array_equal(net.cable_groups["a"], [0])
    np.testing.assert_array_equal(net.cable_groups["b"], [0, 1])
    np.testing.assert_array_equal(net.cable_data["diameter"], [5, 2, 4])
    assert "1 cable given twice, kept once (first: between node 2 (from 0) and node 1 (from 0)" in caplog.text
    assert "1 node at the place of another (first: node 1 (from 0) and node 3 (from 0)" in caplog.text
    assert pdist(net.nodes).min() < 1e-12  # nothing was joined


def vtu(points, cells, **data):
    return lambda path: meshio.vtu.write(path, meshio.Mesh(points, cells, **data))


def text(words):
    return lambda path: path.write_text(words)


TWO = [[0.0, 0, 0], [1, 0, 0]]
VTK_HEAD = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n"
MSH22 = (
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n2\n11 0 0 0\n13 1 0 0\n$EndNodes\n"
    "$Elements\n2\n{}\n$EndElements\n"
)
MSH41 = (
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 2 11 13\n1 1 0 2\n11\n13\n0 0 0\n1 0 0\n$EndNodes\n"
    "$Elements\n1 1 7 7\n1 1 1 1\n{}\n$EndElements\n"
)
MSH_HEAD = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
BAD = {
    "empty": ("net.vtu", text(""), "the file is empty"),
    "suffix": ("net.stl", text("solid"), "'.stl' is unknown"),
    "no_suffix": ("net", text("solid"), "no ending"),
    "not_xml": ("net.vtu", text("nonsense"), "cannot be read as .vtu"),
    "cut_xml": ("net.vtu", text("<VTKFile type='UnstructuredGrid'>"), "cannot be read as .vtu"),
    "wrong_xml": ("net.xdmf", text("<a/>"), "cannot be read as .xdmf"),
    "xdmf_no_h5": (
        "net.xdmf",
        text(
            "<Xdmf Version='3.0'><Domain><Grid><Geometry GeometryType='XYZ'><DataItem DataType='Float' "
            "Dimensions='2 3' Format='HDF' Precision='8'>gone.h5:/a</DataItem></Geometry></Grid></Domain></Xdmf>"
        ),
        "with the data, is missing",
    ),
    "not_vtk": ("net.vtk", text("nonsense\n"), "cannot be read as .vtk"),
    "bad_number": ("net.vtk", text(f"{VTK_HEAD}POINTS 2 double\n0 0 0 1 0 zero\n"), "cannot be read as .vtk"),
    "few_numbers": (
        "net.vtk",
        text(f"{VTK_HEAD}POINTS 2 double\n0 0 0 1\n"),
        "promises 6 coordinates, more than",
    ),
    "no_cells": ("net.vtk", text(f"{VTK_HEAD}POINTS 2 double\n0 0 0 1 0 0\n"), "no lines"),
    "not_msh": ("net.msh", text("nonsense"), "this is no MSH file"),
    "msh_3": ("net.msh", text("$MeshFormat\n3 0 8\n$EndMeshFormat\n"), "version 3 is not read"),
    "msh_cut": ("net.msh", text(f"{MSH_HEAD}$Nodes\n1 5 1 5\n1 1 0 5\n1\n2"), "cut off"),
    "msh_open": (
        "net.msh",
        text(
            f"{MSH_HEAD}$Nodes\n1 2 1 2\n1 1 0 2\n1\n2\n0 0 0\n1 0 0\n$EndNodes\n$Elements\n1 1 1 1\n1 1 1 1\n1 1 2\n"
        ),
        "cut off, a section of it does not end",
    ),
    "msh_names": ("net.msh", text(f'{MSH_HEAD}$PhysicalNames\n1\n1 1 "a"\n'), "does not end"),
    "msh_entities": ("net.msh", text(f"{MSH_HEAD}$Entities\n1 0\n$EndEntities\n"), "cut off"),
    "msh_part": ("net.msh", text(f"{MSH_HEAD}$PartitionedEntities\n"), "partitioned"),
    "not_inp": ("net.inp", text("nonsense\n"), "no nodes"),
    "inp_kind": (
        "net.inp",
        text(f"{INP}*ELEMENT, TYPE=SPRING\n1,1,2\n"),
        "no lines, its elements are 1 SPRING",
    ),
    "inp_node": ("net.inp", text(f"{INP}*ELEMENT, TYPE=T3D2\n9,1,77\n"), "element 9 .* node 77, but"),
    "inp_twice": ("net.inp", text(f"{INP}*NODE\n4,0,0,9\n"), "line 7: node 4 is given a second time"),
    "inp_set": (
        "net.inp",
        text(f"{INP}*ELEMENT, TYPE=T3D2\n1,1,2\n*ELSET\n1\n"),
        "line 8: .ELSET has no name",
    ),
    "no_lines": ("net.vtu", vtu(TWO, [("vertex", [[0], [1]])]), "no lines"),
    "volume": ("net.vtu", vtu([*TWO, [0.0, 1, 0], [0, 0, 1]], [("tetra", [[0, 1, 2, 3]])]), "1 volume cell"),
    "nan": ("net.vtu", vtu([[0.0, 0, 0], [1, np.nan, 0]], [("line", [[0, 1]])]), r"node 1 .*\(1, nan, 0\)"),
    "infinite": ("net.vtu", vtu([[np.inf, 0, 0], [1, 0, 0]], [("line", [[0, 1]])]), "node 0 .*inf"),
    "itself": (
        "net.vtu",
        vtu(TWO, [("line", [[0, 1], [1, 1]])]),
        r"cable 1 \(from 0\) joins node 1 \(from 0\) to itself",
    ),
    "outside": ("net.vtu", vtu(TWO, [("line", [[0, 1], [0, 2]])]), "joins node 2, but the file has 2 nodes"),
    "msh22_lost": (
        "net.msh",
        text(MSH22.format("7 1 2 0 1 11 12\n8 1 2 0 1 11 11")),
        "element 7 .* node 12, but",
    ),
    "msh22_itself": (
        "net.msh",
        text(MSH22.format("7 1 2 0 1 11 13\n8 1 2 0 1 11 11")),
        "cable 8 of the file joins node 11 of the file to itself",
    ),
    "msh41_lost": ("net.msh", text(MSH41.format("7 11 99")), "element 7 .* node 99, but"),
    "msh41_itself": (
        "net.msh",
        text(MSH41.format("7 13 13")),
        "cable 7 of the file joins node 13 of the file to",
    ),
    "inp_itself": (
        "net.inp",
        text(f"{INP}*ELEMENT, TYPE=T3D2\n5, 1,\n2\n9,3,3\n"),
        "cable 9 of the file joins node 3 of the file to itself",
    ),
    "inp_zero": (
        "net.inp",
        text("*NODE\n4,0,0,0\n6,0,0,0\n*ELEMENT, TYPE=T3D2\n9,4,6\n"),
        "cable 9 of the file between node 4 of the file and node 6 of the file has the rest length 0 m",
    ),
    "far": ("net.vtu", vtu([[0.0, 0, 0], [1e200, 0, 0]], [("line", [[0, 1]])]), r"node 1 .*1e\+06 at most"),
    "zero": ("net.vtu", vtu([[1.0, 0, 0], [1, 0, 0]], [("line", [[0, 1]])]), "rest length 0 m"),
    "negative": (
        "net.vtu",
        vtu(TWO, [("line", [[0, 1]])], cell_data={"area": [np.array([-1.0])]}),
        r"cable 0 \(from 0\) has area -1",
    ),
    "vector": (
        "net.vtu",
        vtu(TWO, [("line", [[0, 1]])], cell_data={"area": [np.ones((1, 3))]}),
        "one number per cable",
    ),
    "cubic": ("net.vtu", vtu([*TWO, *TWO], [("line4", [[0, 1, 2, 3]])]), "curved lines of type line4"),
}


@pytest.mark.parametrize("name", BAD)
def test_file_that_is_no_net_gives_one_line_with_its_name(name, tmp_path, capfd):
    file, make, words = BAD[name]
    make(tmp_path / file)
    capfd.readouterr()
    with pytest.raises(MeshError, match=words) as caught:
        read_net(tmp_path / file)
    assert str(caught.value).startswith(f"{tmp_path / file}: ")
    assert "\n" not in str(caught.value)
    # nothing of other libraries' insides
    assert not re.search("0x|ReadError|axis|reshape|broadcast|out of bounds|unpack", str(caught.value))
    assert capfd.readouterr() == ("", "")


def test_missing_file_and_folder_are_named(tmp_path):
    with pytest.raises(MeshError, match="no such file"):
        read_net(tmp_path / "none.vtu")
    (tmp_path / "folder.vtu").mkdir()
    with pytest.raises(MeshError, match="this is a folder"):
        read_net(tmp_path / "folder.vtu")
    with pytest.raises(MeshError, match="this is a folder"):
        write_net(CableNet.square(side=1, cells=1), tmp_path / "folder.vtu", overwrite=True)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_file_cut_anywhere_is_reported_or_whole_where_it_still_reads(tmp_path, suffix, capfd):
    write_net(CableNet.square(side=1.0, cells=2), tmp_path / f"whole{suffix}")
    whole = (tmp_path / f"whole{suffix}").read_bytes()
    rng = np.random.default_rng(11)
    cut = tmp_path / f"cut{suffix}"
    refused = []
    # the last number lost, and anywhere; the last line's end alone may be missing
    for stop in [len(whole) - 2, *rng.integers(1, len(whole) - 2, 25).tolist()]:
        cut.write_bytes(whole[:stop])
        try:
            net = read_net(cut)
        except MeshError as error:
            refused.append(str(error))
        else:
            # a .vtk may end just before one of its data: that is a whole file with fewer groups, not a wrong one
            assert suffix == ".vtk"
            assert {*net.cable_groups, *net.node_groups} <= {"all", "border", "corners", "centre", "inner"}
    assert len(refused) >= 24
    assert not any("\n" in line for line in refused)
    assert not any(
        re.search("0x|ReadError|axis|reshape|broadcast|out of bounds|unpack", line) for line in refused
    )
    assert capfd.readouterr() == ("", "")
