"""Input files of Abaqus and CalculiX: each keyword that places or groups something, beside the right value."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from netdae.core.errors import MeshError
from netdae.mesh.io import describe, write_net
from netdae.model.net import CableNet

FAULTS = Path(__file__).parent / "faults"
ROW = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 2., 0., 0.\n"
CORDS = "*ELEMENT, TYPE=T3D2, ELSET=CORDS\n1, 1, 2\n2, 2, 3\n"


def read(tmp_path, text):
    (tmp_path / "net.inp").write_text(text)
    return describe(tmp_path / "net.inp")


def sizes(groups):
    return {name: len(member) for name, member in groups.items() if name != "all"}


def test_part_placed_twice_is_there_twice():
    net = describe(FAULTS / "instance_shift.inp").net
    np.testing.assert_array_equal(
        net.nodes, [[0, 0, 5], [1, 0, 5], [2, 0, 5], [0, 1, 5], [1, 1, 5], [2, 1, 5]]
    )
    np.testing.assert_array_equal(net.cables, [[0, 1], [1, 2], [3, 4], [4, 5]])
    np.testing.assert_array_equal(net.cable_groups["CORDS"], [0, 1, 2, 3])
    np.testing.assert_array_equal(net.cable_groups["CORD-2.CORDS"], [2, 3])


@pytest.mark.parametrize(
    ("name", "nodes", "cables"),
    [
        ("generate_no_step", {"ALLN": 3, "CORD": 3}, {"CORD": 2}),
        ("node_nset", {"KNOTS": 3, "ENDS": 2, "CORDS": 3}, {"CORDS": 2}),
        ("comment", {"Ends": 2, "Cords": 3}, {"Cords": 2}),
        ("twoel", {"EA": 2, "EB": 2}, {"EA": 1, "EB": 1}),
        ("lower_case_type", {"KNOTS": 3, "ENDS": 2, "CORDS": 3}, {"CORDS": 2}),
        ("ngen", {"LINE": 11, "CORDS": 11}, {"CORDS": 10}),
    ],
)
def test_groups_have_the_members_that_the_deck_names(name, nodes, cables):
    found = describe(FAULTS / f"{name}.inp")
    assert sizes(found.net.node_groups) == nodes
    assert sizes(found.net.cable_groups) == cables
    assert found.findings == ()
    np.testing.assert_allclose(found.net.rest_length, 1.0, rtol=1e-15)
    assert found.net.cable_count == found.net.node_count - 1


def test_cylindrical_nodes_and_systems_are_places_in_metres(tmp_path):
    net = read(tmp_path, f"*NODE, SYSTEM=C\n1, 2., 90., 1.\n2, 2., 180., 1.\n3, 0,, 1.\n{CORDS}").net
    np.testing.assert_allclose(net.nodes, [[0, 2, 1], [-2, 0, 1], [0, 0, 1]], atol=1e-15)
    # origin (5, 0, 0), X1 along +y, Y1 on the side of +z: local (1, 2, 3) is (5 + 3, 1, 2)
    system = "*SYSTEM\n5., 0., 0., 5., 1., 0.\n5., 0., 1.\n"
    net = read(tmp_path, f"{system}*NODE\n1, 1., 2., 3.\n*SYSTEM\n*NODE\n2, 1, 0, 0\n3, 2, 0, 0\n{CORDS}").net
    np.testing.assert_allclose(net.nodes, [[8, 1, 2], [1, 0, 0], [2, 0, 0]], atol=1e-15)
    # without a second line Z stays and X1 is projected on the XY plane
    net = read(tmp_path, f"*SYSTEM\n0, 0, 1, 0, 2, 9\n{ROW}{CORDS}").net
    np.testing.assert_allclose(net.nodes, [[0, 0, 1], [0, 1, 1], [0, 2, 1]], atol=1e-15)
    net = read(tmp_path, f"*SYSTEM\n0, 0, 7\n{ROW}{CORDS}").net
    np.testing.assert_array_equal(net.nodes[:, 2], 7)


def test_instance_is_shifted_then_turned_about_its_axis(tmp_path):
    rng = np.random.default_rng(3)
    for _ in range(5):
        x, t, a, b = rng.normal(size=(3, 3)), *rng.normal(size=(3, 3))
        angle = rng.uniform(-180, 180)
        nodes = "\n".join(f"{k + 1}, {', '.join(map(repr, row))}" for k, row in enumerate(x.tolist()))
        shift, turn = (", ".join(map(repr, row.tolist())) for row in (t, [*a, *b, angle] @ np.eye(7)))
        net = read(
            tmp_path,
            f"*PART, NAME=p\n*NODE\n{nodes}\n{CORDS}*END PART\n*ASSEMBLY, NAME=a\n*INSTANCE, NAME=p-1, PART=P\n"
            f"{shift}\n{turn}\n*END INSTANCE\n*NSET, NSET=top, INSTANCE=p-1\n3\n*NSET, NSET=pair\np-1.1, TOP\n"
            "*END ASSEMBLY\n",
        ).net
        axis = (b - a) / np.linalg.norm(b - a)
        right = Rotation.from_rotvec(np.deg2rad(angle) * axis).apply(x + t - a) + a
        np.testing.assert_allclose(net.nodes, right, rtol=0, atol=1e-14)
        assert sizes(net.node_groups) == {"top": 1, "pair": 2, "CORDS": 3}


def test_sets_of_the_assembly_hide_those_of_parts(tmp_path):
    part = f"*PART, NAME=p\n{ROW}{CORDS}*NSET, NSET=S\n1, 2\n*END PART\n"
    both = "*INSTANCE, NAME=a, PART=p\n*END INSTANCE\n*INSTANCE, NAME=b, PART=p\n0, 0, 1\n*END INSTANCE\n"
    net = read(tmp_path, f"{part}*ASSEMBLY\n{both}*NSET, NSET=s, INSTANCE=b\n3\n*END ASSEMBLY\n").net
    np.testing.assert_array_equal(net.node_groups["s"], [5])
    np.testing.assert_array_equal(net.node_groups["a.S"], [0, 1])
    np.testing.assert_array_equal(net.node_groups["b.S"], [3, 4])


def test_rows_of_elements_make_a_square_net(tmp_path):
    # 4 × 4 nodes by *NGEN and *NFILL; 3 × 4 cables along x, 4 × 3 along y
    text = (
        "*NODE\n1, 0, 0\n4, 3, 0\n31, 0, 3\n34, 3, 3\n*NGEN, NSET=low\n1, 4\n*NGEN, NSET=high\n31, 34, 1\n"
        "*NFILL, NSET=all knots\nlow, high, 3, 10\n*ELEMENT, TYPE=T3D2\n1, 1, 2\n101, 1, 11\n"
        "*ELGEN, ELSET=along\n1, 3, 1, 1, 4, 10, 10\n*ELGEN, ELSET=across\n101, 4, 1, 1, 3, 10, 10\n"
    )
    net = read(tmp_path, text).net
    right = CableNet.square(side=3.0, cells=3)
    places = {tuple(row) for row in np.add(right.nodes, [1.5, 1.5, 0]).round(9).tolist()}
    assert {tuple(row) for row in net.nodes.round(9).tolist()} == places
    assert sizes(net.cable_groups) == {"along": 12, "across": 12}
    assert len(net.node_groups["all knots"]) == 16
    np.testing.assert_allclose(net.rest_length, 1.0, rtol=1e-15)


def test_copies_of_nodes_and_elements_are_made(tmp_path):
    text = (
        f"{ROW}{CORDS}*NSET, NSET=row, GENERATE\n1, 3\n"
        "*NCOPY, CHANGE NUMBER=10, OLD SET=row, NEW SET=other, SHIFT\n0, 4, 0\n0, 0, 0, 0, 0, 1, 90\n"
        "*ELCOPY, ELEMENT SHIFT=10, OLD SET=cords, SHIFT NODES=10, NEW SET=more\n"
    )
    net = read(tmp_path, text).net
    # (x, 4, 0) turned by 90 degrees about z
    np.testing.assert_allclose(net.nodes[3:], [[-4, 0, 0], [-4, 1, 0], [-4, 2, 0]], atol=1e-15)
    assert sizes(net.cable_groups) == {"CORDS": 2, "more": 2}


def test_spellings_of_keywords_names_and_lines(tmp_path):
    text = (
        '*node, nset="My knots"\n1, 0.D0, 0, 0\n2, 1.0d+0\n ** between\n3, 2, , \n'
        "*Element , Type = T3D2 ,\nElset = cords\n1, 1,\n2\n2, 2, 3\n"
        '*NSET, NSET=both\n"My knots", 3,\n*NSET, NSET=Both\nMY END\n*NSET, NSET=my end, GENERATE\n1, 3, 2\n'
        "*NSET, NSET=of, ELSET=Cords\n*NODE OUTPUT, NSET=both\nU\n*NODE FILE\nU\n"
    )
    found = read(tmp_path, text)
    np.testing.assert_array_equal(found.net.nodes[:, 0], [0, 1, 2])
    assert sizes(found.net.node_groups) == {"My knots": 3, "both": 3, "my end": 2, "of": 3, "cords": 3}
    assert found.findings == ()


def test_included_files_are_read_in_place(tmp_path):
    (tmp_path / "nodes.inc").write_text(ROW)
    (tmp_path / "cords.txt").write_text("1, 1, 2\n2, 2, 3\n")
    text = "*INCLUDE, INPUT=nodes.inc\n*ELEMENT, TYPE=T3D2, ELSET=c, INPUT=cords.txt\n"
    assert sizes(read(tmp_path, text).net.cable_groups) == {"c": 2}
    (tmp_path / "nodes.inc").write_text("*INCLUDE, INPUT=nodes.inc\n")
    with pytest.raises(MeshError, match="end the circle"):
        read(tmp_path, text)
    (tmp_path / "nodes.inc").unlink()
    with pytest.raises(MeshError, match=r"line 1: \*INCLUDE: there is no file nodes.inc beside"):
        read(tmp_path, text)


def test_elements_that_are_no_cables_are_a_note(tmp_path):
    text = (
        f"{ROW}4, 0, 1, 0\n{CORDS}*ELEMENT, TYPE=SPRINGA\n7, 1, 3\n*ELEMENT, TYPE=S3, ELSET=cloth\n8, 1, 2, 4\n"
        "*ELEMENT, TYPE=MASS\n9, 2\n*TIE, NAME=t\na, b\n"
    )
    found = read(tmp_path, text)
    assert found.net.cable_count == 2
    text = " | ".join(found.findings)
    assert "elements that are no cables are left out: 1 MASS, 1 SPRINGA" in text
    assert "*TIE holds nodes together" in text
    assert "surface_edges = true" in text
    net = describe(tmp_path / "net.inp", surface_edges=True).net
    assert sizes(net.cable_groups) == {"CORDS": 2, "border": 3, "cloth": 3}


def test_quadratic_surfaces_and_volumes_over_several_lines(tmp_path):
    ring = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
    nodes = "".join(f"{k + 1}, {x}, {y}, 0\n" for k, (x, y) in enumerate(ring))
    solid = "*ELEMENT, TYPE=C3D8\n5, 1, 2, 3, 4,\n5, 6, 7, 8\n"
    (tmp_path / "net.inp").write_text(f"*NODE\n{nodes}*ELEMENT, TYPE=S8R\n1, 1, 2, 3, 4\n5, 6, 7, 8\n{solid}")
    net = describe(tmp_path / "net.inp", surface_edges=True).net
    assert net.cable_count == 8
    np.testing.assert_array_equal(net.rest_length, 1)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (f"*NODE, SYSTEM=S\n1, 1, 2, 3\n{CORDS}", r"\*NODE, SYSTEM=S is not read"),
        (f"{ROW}*NMAP, NSET=a\n1\n{CORDS}", r"line 5: \*NMAP is not read"),
        (f"{ROW}*NGEN, LINE=C\n1, 3, 1, 2\n{CORDS}", r"\*NGEN, LINE=C is not read"),
        (f"{ROW}*NGEN\n1, 2000000003\n{CORDS}", r"there is no node 2000000003"),
        (f"{ROW}2000000003, 9\n*NGEN\n1, 2000000003\n", r"makes 2000000002 nodes"),
        (f"{ROW}{CORDS}*ELGEN\n1, 2000000000, 1, 1\n", r"line 9 makes 2000000000 nodes"),
        (f"{ROW}*NCOPY, OLD SET=a, REFLECT=MIRROR, CHANGE NUMBER=9\n{CORDS}", "REFLECT is not read"),
        (f"*PART, NAME=p\n{ROW}{CORDS}*END PART\n", r"the part P is placed nowhere"),
        (f"{ROW}{CORDS}*INSTANCE, NAME=a, PART=b\n*END INSTANCE\n", r"no \*PART, NAME=b before it"),
        (f"*PARAMETER\na=1\n*NODE\n1, <a>\n{CORDS}", r"line 4: <a> is a \*PARAMETER"),
        (f"*NODE\n1, one\n{CORDS}", "line 2: 'one' is no number"),
        (f"{ROW}*ELEMENT, TYPE=T3D2\n1, 1, 2\n2, 2,", "has 1 of 2 nodes: the file is cut off"),
    ],
)
def test_what_is_not_read_is_named(tmp_path, text, words):
    with pytest.raises(MeshError, match=words) as caught:
        read(tmp_path, text)
    assert "\n" not in str(caught.value)


def test_losses_are_told(tmp_path):
    found = read(tmp_path, f"{ROW}{CORDS}*NSET, NSET=ENDS\n1, 3, 7,\n*ELSET, ELSET=E\ngone\n")
    assert found.findings == (
        "the set ENDS has 1 member that the file does not have (first: 7)",
        "the set E has 1 member that the file does not have (first: gone)",
    )
    found = read(tmp_path, f"{ROW}{CORDS}*NSET, NSET=ENDS\n1, 3, 2, 1")
    assert found.findings == ("the file ends within the line '1, 3, 2, 1': check that it is whole",)


def test_line_missing_from_a_written_file_is_told(tmp_path):
    write_net(CableNet.square(side=1.0, cells=3), tmp_path / "whole.inp")
    lines = (tmp_path / "whole.inp").read_text().splitlines()
    rng = np.random.default_rng(4)
    data = [k for k, line in enumerate(lines) if not line.startswith("*")]
    for k in rng.choice(data, 12, replace=False):
        with pytest.raises(MeshError):
            read(tmp_path, "\n".join([*lines[:k], *lines[k + 1 :]]) + "\n")
