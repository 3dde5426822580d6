"""Meshes of other programs: whole files are read, damaged ones are told from features that are not read."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import pyvista
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

from netdae.core.errors import MeshError
from netdae.mesh.io import describe

FAULTS = Path(__file__).parent / "faults"


def frame():
    """A triangle of lines with a tail, with data of every kind that netdae uses."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [2, 1, 0]], dtype=float)
    cells = [2, 0, 1, 2, 1, 2, 2, 2, 0, 2, 2, 3]
    grid = pyvista.UnstructuredGrid(np.array(cells), np.full(4, 3), points)
    grid.cell_data["rim"] = np.array([1, 1, 1, 0], dtype=np.int8)
    grid.cell_data["diameter"] = np.array([1e-3, 2e-3, 3e-3, 4e-3])
    grid.point_data["corners"] = np.array([1, 1, 1, 0], dtype=np.uint8)
    return grid


def check_frame(found):
    np.testing.assert_array_equal(found.net.nodes, frame().points)
    np.testing.assert_array_equal(found.net.cables, [[0, 1], [1, 2], [2, 0], [2, 3]])
    np.testing.assert_array_equal(found.net.cable_groups["rim"], [0, 1, 2])
    np.testing.assert_array_equal(found.net.node_groups["corners"], [0, 1, 2])
    np.testing.assert_array_equal(found.net.cable_data["diameter"], [1e-3, 2e-3, 3e-3, 4e-3])


def write_by_vtk(path, mode, compressor, header=64, writer=vtkXMLUnstructuredGridWriter, data=None):
    writer = writer()
    writer.SetInputData(frame() if data is None else data)
    writer.SetFileName(str(path))
    getattr(writer, f"SetDataModeTo{mode.removesuffix('Raw')}")()
    writer.SetEncodeAppendedData(mode == "Appended")
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    getattr(writer, f"SetHeaderTypeToUInt{header}")()
    writer.Write()


MODES = [
    (mode, compressor, header)
    for mode in ("Ascii", "Binary", "Appended", "AppendedRaw")
    for compressor in ("None", "ZLib", "LZ4", "LZMA")
    for header in (32, 64)
]


@pytest.mark.parametrize(("mode", "compressor", "header"), MODES)
def test_every_form_of_a_vtu_that_vtk_writes_is_read(tmp_path, mode, compressor, header):
    write_by_vtk(tmp_path / "net.vtu", mode, compressor, header)
    check_frame(describe(tmp_path / "net.vtu"))


@pytest.mark.parametrize("name", ["strings.vtu", "lz4.vtu"])
def test_arrays_that_netdae_does_not_use_do_not_stop_a_vtu(name):
    net = describe(FAULTS / name).net
    truth = pyvista.read(FAULTS / name)
    np.testing.assert_array_equal(net.nodes, truth.points)
    np.testing.assert_array_equal(net.cables, truth.cell_connectivity.reshape(-1, 2))
    np.testing.assert_array_equal(net.cable_data["diameter"], truth.cell_data["diameter"])
    np.testing.assert_array_equal(net.cable_groups["rim"], np.flatnonzero(truth.cell_data["rim"]))


def test_quadratic_cells_of_vtk_have_their_edges_as_of_vtu(tmp_path):
    with pytest.raises(MeshError, match=r"surface_edges = true .*--surface-edges"):
        describe(FAULTS / "quad8.vtk")
    net = describe(FAULTS / "quad8.vtk", surface_edges=True).net
    pyvista.read(FAULTS / "quad8.vtk").save(tmp_path / "quad8.vtu")
    same = describe(tmp_path / "quad8.vtu", surface_edges=True).net
    np.testing.assert_array_equal(net.nodes, same.nodes)
    assert {frozenset(pair) for pair in net.cables.tolist()} == {
        frozenset(pair) for pair in same.cables.tolist()
    }
    np.testing.assert_array_equal(net.rest_length, 0.5)


def test_count_beyond_the_file_is_one_line_before_vtk_reads():
    with pytest.raises(MeshError, match="promises more or other cells than the file holds"):
        describe(FAULTS / "cell_count_2e9.vtk")


def test_pointer_of_git_lfs_is_named():
    with pytest.raises(MeshError, match="a pointer of Git LFS, not the mesh: fetch it by git lfs pull"):
        describe(FAULTS / "lfs_pointer.inp")


def test_sections_of_other_programs_are_passed_over():
    found = describe(FAULTS / "own_section.msh")
    np.testing.assert_array_equal(found.net.nodes, [[0, 0, 0], [1, 0, 0]])
    np.testing.assert_array_equal(found.net.cables, [[0, 1]])


def test_element_data_of_some_elements_leave_the_others_to_the_material():
    net = describe(FAULTS / "element_data_of_some.msh").net
    np.testing.assert_array_equal(net.cable_data["diameter"], [np.nan, 2e-3])  # element 2 of the file


def test_nodes_with_parameters_are_where_their_coordinates_say(tmp_path):
    text = (
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n2 3 1 3\n0 1 0 1\n1\n0 0 0\n1 1 1 2\n2\n3\n1 0 0 0.5\n2 0 0 1\n"
        "$EndNodes\n$Elements\n1 2 1 2\n1 1 1 2\n1 1 2\n2 2 3\n$EndElements\n"
    )
    (tmp_path / "net.msh").write_text(text)
    np.testing.assert_array_equal(describe(tmp_path / "net.msh").net.nodes[:, 0], [0, 1, 2])
    (tmp_path / "net.msh").write_text(text.replace("3\n1 0 0 0.5\n", ""))
    with pytest.raises(MeshError, match="promises more numbers than it holds"):
        describe(tmp_path / "net.msh")


@pytest.mark.parametrize("line", ["2 1 0 0", "2 1 2 0 1 2 3"])
def test_line_missing_from_a_msh_is_told(tmp_path, line):
    text = (FAULTS / "element_data_of_some.msh").read_text()
    assert f"{line}\n" in text
    (tmp_path / "net.msh").write_text(text.replace(f"{line}\n", ""))
    with pytest.raises(MeshError, match=r"the header promises \d (nodes|elements) and the file has \d"):
        describe(tmp_path / "net.msh")


def test_poly_lines_of_xdmf_are_cables(tmp_path):
    found = describe(FAULTS / "polyline_fenics.xdmf")
    np.testing.assert_array_equal(found.net.nodes, [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]])
    np.testing.assert_array_equal(found.net.cables, [[0, 1], [1, 2], [2, 3]])
    text = (FAULTS / "polyline_fenics.xdmf").read_text()
    from_one = text.replace("0 1\n1 2\n2 3", "1 2\n2 3\n3 4").replace(
        '"PolyLine"', '"POLYLINE" BaseOffset="1"'
    )
    for other in (from_one, text.replace('"3 2"', '"6"')):
        (tmp_path / "net.xdmf").write_text(other)
        np.testing.assert_array_equal(describe(tmp_path / "net.xdmf").net.cables, found.net.cables)


def test_series_in_time_of_xdmf_begins_with_its_first_grid(tmp_path):
    text = (FAULTS / "polyline_fenics.xdmf").read_text()
    begin, end = text.index("<Grid"), text.index("</Domain>")
    grid = text[begin:end]
    later = (
        '<Grid Name="later"><Topology Reference="/Xdmf/Domain/Grid/Grid[1]/Topology"/>'
        '<Geometry Reference="/Xdmf/Domain/Grid/Grid[1]/Geometry"/></Grid>'
    )
    series = f'<Grid GridType="Collection" CollectionType="Temporal">{grid}{later}</Grid>'
    (tmp_path / "net.xdmf").write_text(text[:begin] + series + text[end:])
    found = describe(tmp_path / "net.xdmf")
    assert found.net.cable_count == 3
    assert found.findings == ("a series in time of 2 grids, of which the first is read",)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("PolyLine", "Wedge_99", "a topology of type wedge_99 is not read"),
        ("XYZ", "ORIGIN_DXDYDZ", "a geometry of type ORIGIN_DXDYDZ is not read"),
        ("2 3</DataItem>", "2</DataItem>", "promises 6 values and there are 5"),
        ('NumberOfElements="3"', 'NumberOfElements="4"', "promises 4 cells and the file has 3"),
        ('"4 3"', '"400000000 3"', "would take over 2 GiB of memory"),
    ],
)
def test_features_of_xdmf_that_are_not_read_are_told_from_damage(tmp_path, old, new, words):
    text = (FAULTS / "polyline_fenics.xdmf").read_text()
    assert old in text
    (tmp_path / "net.xdmf").write_text(text.replace(old, new))
    with pytest.raises(MeshError, match=words):
        describe(tmp_path / "net.xdmf")


def mutants(whole, rng, count):
    """The file cut, with a byte changed, with a line less, and with a number made large."""
    for k in range(count):
        place = int(rng.integers(1, len(whole)))
        if k % 4 == 0:
            yield whole[:place]
        elif k % 4 == 1:
            yield whole[:place] + bytes([int(rng.integers(256))]) + whole[place + 1 :]
        elif k % 4 == 2:
            lines = whole.splitlines(keepends=True)
            gone = int(rng.integers(len(lines)))
            yield b"".join(lines[:gone] + lines[gone + 1 :])
        else:
            numbers = list(re.finditer(rb"\d+", whole))
            found = numbers[int(rng.integers(len(numbers)))]
            large = [b"2000000000", b"-1", b"9223372036854775808", b"1e300"][int(rng.integers(4))]
            yield whole[: found.start()] + large + whole[found.end() :]


READ = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))  # address space, of which libraries take half
from pathlib import Path
from netdae.core.errors import MeshError
from netdae.mesh.io import describe
for file in sorted(Path(sys.argv[1]).iterdir()):
    print(file.name, flush=True)
    try:
        describe(file)
    except MeshError as error:
        assert "\\n" not in str(error)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory")
def test_damaged_files_end_no_process(tmp_path):
    rng = np.random.default_rng(17)
    (tmp_path / "some").mkdir()
    frame().save(tmp_path / "text.vtk", binary=False)
    frame().save(tmp_path / "bytes.vtk")
    write_by_vtk(tmp_path / "text.vtu", "Ascii", "None")
    write_by_vtk(tmp_path / "bytes.vtu", "AppendedRaw", "ZLib")
    for whole in [*tmp_path.glob("*.v*"), FAULTS / "instance_shift.inp", FAULTS / "own_section.msh"]:
        for k, data in enumerate(mutants(whole.read_bytes(), rng, 40)):
            (tmp_path / "some" / f"{whole.stem}_{k}{whole.suffix}").write_bytes(data)
    done = subprocess.run([sys.executable, "-c", READ, tmp_path / "some"], capture_output=True, text=True)
    names = done.stdout.split()
    assert (done.returncode, len(names)) == (0, 240), (names[-1], done.stderr[-2000:])
