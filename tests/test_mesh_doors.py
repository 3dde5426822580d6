"""More formats of nets, conversion between them, and files that are no files."""

import os

import numpy as np
import pytest
import pyvista

from netdae.cli import main
from netdae.core.errors import MeshError
from netdae.mesh.graph import net_of_graph
from netdae.mesh.io import SUFFIXES, describe, read_net, write_net
from netdae.model.net import CableNet


def test_vtk_reads_the_vtp_that_netdae_writes(tmp_path):
    net = CableNet.square(side=2.0, cells=2)
    write_net(net, tmp_path / "net.vtp")
    mesh = pyvista.read(tmp_path / "net.vtp")
    np.testing.assert_array_equal(mesh.points, net.nodes)
    np.testing.assert_array_equal(mesh.lines.reshape(-1, 3)[:, 1:], net.cables)
    np.testing.assert_array_equal(np.flatnonzero(mesh.point_data["corners"]), net.node_groups["corners"])


def test_poly_data_of_pyvista_is_a_net(tmp_path):
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    pyvista.PolyData(points, lines=[5, 0, 1, 2, 3, 0]).save(tmp_path / "loop.vtp")
    np.testing.assert_array_equal(read_net(tmp_path / "loop.vtp").cables, [[0, 1], [1, 2], [2, 3], [3, 0]])


BLENDER = """\
# Blender 4.1
o Net
v 0 0 0
v 1 0 0
v 1 1 0
l 1 2
l 2 3
g rim second
l -1 1
g tips
p 1 3
"""


def test_lines_of_obj_are_cables(tmp_path):
    (tmp_path / "net.obj").write_text(BLENDER)
    net = read_net(tmp_path / "net.obj")
    np.testing.assert_array_equal(net.cables, [[0, 1], [1, 2], [2, 0]])
    assert {name: member.tolist() for name, member in net.cable_groups.items()} == {
        "Net": [0, 1],
        "rim": [2],
        "second": [2],
        "all": [0, 1, 2],
    }
    np.testing.assert_array_equal(net.node_groups["tips"], [0, 2])
    (tmp_path / "net.obj").write_text(BLENDER.replace("l 2 3", "l 2 9"))
    with pytest.raises(MeshError, match="line 7 names vertex 9, but there are 3 before it"):
        read_net(tmp_path / "net.obj")


def test_pair_of_csv_tables_is_a_net(tmp_path):
    (tmp_path / "net_nodes.csv").write_text("x,y,z,group,mass\n0,0,0,tips;held,\n1,0,0,,0.2\n2,0,0,tips,\n")
    (tmp_path / "net_cables.csv").write_text("i,j,rest_length,diameter,group\n0,1,1.1,,a\n1,2,,0.002,a\n")
    for name in ("net_nodes.csv", "net_cables.csv"):
        found = describe(tmp_path / name)
        np.testing.assert_array_equal(found.net.rest_length, [1.1, 1.0])
        np.testing.assert_array_equal(found.net.cable_data["diameter"], [np.nan, 0.002])
        np.testing.assert_array_equal(found.net.node_groups["tips"], [0, 2])
        np.testing.assert_array_equal(found.net.cable_groups["a"], [0, 1])
        assert found.findings == (
            "the column mass is not read: give the masses of node groups in [[masses]]",
        )
    (tmp_path / "net_nodes.csv").write_text("name,x,y,z\nA,0,0,0\nB,1,0,0\n")
    (tmp_path / "net_cables.csv").write_text("i,j\nA,B\n")
    assert read_net(tmp_path / "net_nodes.csv").cable_count == 1
    (tmp_path / "net_cables.csv").write_text("i,j\nA,C\n")
    with pytest.raises(
        MeshError, match=r"net_cables.csv: line 2: j is 'C', but there is no node of this name"
    ):
        read_net(tmp_path / "net_nodes.csv")
    (tmp_path / "net_cables.csv").unlink()
    with pytest.raises(MeshError, match=r"the other table, net_cables\.csv, is not beside this one"):
        read_net(tmp_path / "net_nodes.csv")
    (tmp_path / "net_nodes.csv").write_text("x,y\n")
    with pytest.raises(MeshError, match="header is 'x,y', expected x,y,z"):
        read_net(tmp_path / "net_nodes.csv")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_mesh_is_converted_to_every_format(tmp_path, suffix, capsys):
    net = CableNet.hexagon(radius=1.0, rings=2)
    write_net(net, tmp_path / "from.vtu")
    there, back = tmp_path / f"there{suffix}", tmp_path / "back.obj"
    assert main(["mesh", "--from", str(tmp_path / "from.vtu"), "-o", str(there)]) == 0
    assert main(["mesh", "--from", str(there), "-o", str(back)]) == 0
    same = read_net(back)
    np.testing.assert_array_equal(same.nodes, net.nodes)
    np.testing.assert_array_equal(same.cables, net.cables)
    for name in ("border", "corners", "centre"):
        np.testing.assert_array_equal(same.node_groups[name], net.node_groups[name])
    assert main(["mesh", "--from", str(there)]) == 2
    assert "--from FILE -o FILE" in capsys.readouterr().err


def test_nodes_of_pieces_that_touch_are_joined_on_request(tmp_path):
    # two pieces of cord and a third that begins 1e-9 m beside the end of the first
    text = "v 0 0 0\nv 1 0 0\nv 1 1e-9 0\nv 2 0 0\ng tip\np 3\ng default\nl 1 2\nl 3 4\n"
    (tmp_path / "net.obj").write_text(text)
    found = describe(tmp_path / "net.obj")
    assert found.net.node_count == 4
    assert "merge = 1e-6" in found.findings[0]
    found = describe(tmp_path / "net.obj", merge=1e-6)
    np.testing.assert_array_equal(found.net.cables, [[0, 1], [1, 2]])
    np.testing.assert_array_equal(found.net.node_groups["tip"], [1])
    assert "1 node joined with another within 1e-06 m" in found.findings
    with pytest.raises(MeshError, match="joins both ends of cable 1 "):
        describe(tmp_path / "net.obj", merge=1.5)
    with pytest.raises(MeshError, match="merge is -1, expected"):
        describe(tmp_path / "net.obj", merge=-1.0)


@pytest.mark.skipif(os.name != "posix", reason="there are no devices among the files")
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("pipe.vtu", "a device or a pipe"),
        ("n" * 300 + ".vtu", "File name too long"),
        ("nul\0.vtu", "the name has a NUL"),
    ],
)
def test_names_that_are_no_files_are_one_line(tmp_path, name, words):
    os.mkfifo(tmp_path / "pipe.vtu")
    with pytest.raises(MeshError, match=words) as caught:
        read_net(tmp_path / name)
    assert "\0" not in str(caught.value)


class Graph:
    """What of a networkx graph is used."""

    def __init__(self, nodes, edges):
        self._nodes, self._edges = nodes, edges

    def nodes(self, data):
        return self._nodes

    def edges(self, data):
        return self._edges


def test_graph_is_a_net():
    nodes = [
        ("a", {"pos": (0, 0), "group": "tips"}),
        (7, {"pos": (1, 0)}),
        ("c", {"pos": (2, 0, 1), "group": ["tips", "x"]}),
    ]
    edges = [("a", 7, {"diameter": 2e-3}), (7, "c", {"group": "red", "rest_length": 2.0})]
    net = net_of_graph(Graph(nodes, edges))
    np.testing.assert_array_equal(net.nodes, [[0, 0, 0], [1, 0, 0], [2, 0, 1]])
    np.testing.assert_array_equal(net.cables, [[0, 1], [1, 2]])
    np.testing.assert_array_equal(net.node_groups["tips"], [0, 2])
    np.testing.assert_array_equal(net.cable_groups["red"], [1])
    np.testing.assert_array_equal(net.rest_length, [1.0, 2.0])
    np.testing.assert_array_equal(net.cable_data["diameter"], [2e-3, np.nan])
    with pytest.raises(MeshError, match="node 'b' of the graph has no pos"):
        net_of_graph(Graph([("b", {})], []))
