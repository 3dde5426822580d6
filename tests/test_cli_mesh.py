"""The verbs `mesh` and `info`, and the nets in meshes/."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from cyclopts import App, CycloptsError

from netdae.cli.info import info
from netdae.cli.mesh import app as mesh_app
from netdae.core.errors import InputError
from netdae.mesh.io import describe, read_net

MESHES = Path(__file__).parent.parent / "meshes"
COMMANDS = re.findall(r"`netdae (mesh [^`]*)`", (MESHES / "README.md").read_text(encoding="utf-8"))


def run(command):
    app = App(name="netdae", result_action="return_value")
    app.command(mesh_app, name="mesh")
    app.command(info)
    app(shlex.split(command), exit_on_error=False, print_error=False)


def same(net, other):
    np.testing.assert_array_equal(net.cables, other.cables)
    # sines and cosines may differ in the last digit from one machine to another
    np.testing.assert_allclose(net.nodes, other.nodes, rtol=0, atol=1e-14)
    for groups, others in ((net.node_groups, other.node_groups), (net.cable_groups, other.cable_groups)):
        assert {name: list(member) for name, member in groups.items()} == {
            name: list(member) for name, member in others.items()
        }


@pytest.mark.parametrize("command", COMMANDS)
def test_each_shipped_mesh_is_what_its_command_makes(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    run(command)
    name = shlex.split(command)[-1]
    assert capsys.readouterr().out.startswith(f"{name}: ")
    same(read_net(tmp_path / name), read_net(MESHES / name))
    assert describe(MESHES / name).findings == ()


def test_every_shipped_mesh_has_its_command():
    shipped = {file.name for file in MESHES.iterdir()} - {"README.md"}
    assert shipped == {shlex.split(command)[-1] for command in COMMANDS}


def test_existing_file_is_kept_unless_overwriting_is_asked_for(tmp_path):
    file = tmp_path / "net.vtu"
    run(f"mesh square --side 1 --cells 2 -o {file}")
    before = file.read_bytes()
    with pytest.raises(InputError, match="exists"):
        run(f"mesh square --side 1 --cells 3 -o {file}")
    assert file.read_bytes() == before
    run(f"mesh square --side 1 --cells 3 --overwrite -o {file}")
    assert read_net(file).node_count == 16
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("--side 0 --cells 2 -o net.vtu", "side is 0"),
        ("--side nan --cells 2 -o net.vtu", "side is nan"),
        ("--side 1 --cells 0 -o net.vtu", "cells is 0"),
        ("--side 1 --cells 1 -o net.stl", r"'\.stl' is unknown: netdae reads and writes \.vtu"),
        ("--side 1 --cells 1 -o net", "no ending"),
        ("--side 1 --cells 4.9 -o net.vtu", '"4.9", expected a whole number'),
        ("--side 1 --cells 0x4 -o net.vtu", '"0x4", expected a whole number'),
        ("--side 1 --cells 2 --subdivide 0 -o net.vtu", "square net: subdivide is 0"),
        (
            "--side 1e200 --cells 2 -o net.vtu",
            "side is 1e[+]200, give a length above zero, 1e[+]06 m at most",
        ),
    ],
)
def test_mistake_is_one_clear_line_and_leaves_no_file(arguments, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises((InputError, CycloptsError), match=words) as caught:
        run(f"mesh square {arguments}")
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_folder_of_the_file_is_made(tmp_path):
    run(f"mesh square --side 1 --cells 2 -o {tmp_path / 'new' / 'deep' / 'net.vtu'}")
    assert read_net(tmp_path / "new" / "deep" / "net.vtu").node_count == 9


def test_place_that_cannot_be_written_is_one_line(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError, match="cannot be written") as caught:
        run(f"mesh square --side 1 --cells 2 -o {tmp_path / 'file' / 'net.vtu'}")
    assert "\n" not in str(caught.value)

    def closed(self, *arguments, **options):
        raise PermissionError(
            13, "Permission denied"
        )  # as where a folder is closed, root is not kept out of one

    monkeypatch.setattr(Path, "unlink", closed)
    monkeypatch.setattr("meshio.vtu.write", closed)
    with pytest.raises(InputError, match="cannot be written: Permission denied"):
        run(f"mesh square --side 1 --cells 2 -o {tmp_path / 'net.vtu'}")


def test_info_says_what_is_in_a_mesh(tmp_path, capsys):
    file = tmp_path / "two.inp"
    file.write_text(
        "*NODE\n1, 0, 0, 0\n2, 3, 4, 0\n3, 9, 0, 0\n4, 9, 1, 0\n5, 2, 2, 2\n6, 9, 1, 0\n7, 9, 2, 0\n"
        "*ELEMENT, TYPE=T3D2, ELSET=long\n1, 1, 2\n2, 2, 1\n*ELEMENT, TYPE=T3D2\n3, 3, 4\n4, 6, 7\n"
    )
    run(f"info {file}")
    lines = capsys.readouterr().out.splitlines()
    text = {line[:17].strip(): line[17:] for line in lines}
    assert lines[0] == str(file)
    assert text["nodes"] == "6"
    assert text["cables"] == "3"
    assert text["node groups"] == "all 6, long 2"
    assert text["cable groups"] == "all 3, long 1"
    assert text["connected parts"] == "3"
    assert text["total length"] == "7 m"  # 5 + 1 + 1
    assert text["bounding box"] == "x 0 to 9, y 0 to 4, z 0 to 0 m"
    notes = [line for line in lines if line.startswith("note")]
    assert len(notes) == 3
    assert "1 cable given twice" in notes[0]
    assert "1 node without a cable" in notes[1]
    assert "1 node at the place of another" in notes[2]


def test_info_of_a_surface_counts_its_edges_on_request(tmp_path, capsys):
    file = tmp_path / "quad.inp"
    file.write_text("*NODE\n1,0,0\n2,1,0\n3,1,1\n4,0,1\n*ELEMENT,TYPE=S4\n1,1,2,3,4\n")
    with pytest.raises(InputError, match="surface"):
        run(f"info {file}")
    run(f"info {file} --surface-edges")
    assert "cable groups     all 4, border 4" in capsys.readouterr().out


def test_verbs_import_no_heavy_library():
    code = (
        "import sys, netdae.cli.mesh, netdae.cli.info;"
        "print({'numpy', 'scipy', 'meshio', 'pyvista', 'numba'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
