"""Imports go down only, heavy libraries are imported where they are used and nowhere else."""

import ast
import graphlib
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent / "netdae"
MODULES = {
    ".".join(("netdae", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__"): path
    for path in sorted(PACKAGE.rglob("*.py"))
}

# from the bottom up; a module imports from its own room or from those below it
ROOMS = (
    *("manual", "core", "model", "forces", "system", "mesh", "initial", "solvers", "events"),
    *("output", "scenario", "runs", "visual", "cli"),
)
SHOWN = 15  # entries of the package at most, beside dunder files: what one takes in at a glance

HEAVY = ("numpy", "scipy", "numba", "pyvista", "matplotlib", "meshio", "sksundae")


def imports_of(path):
    """All names that a module imports, also inside functions: `a.b` and, for `from a import b`, `a.b` too."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.name} imports relatively"
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return names


def own_imports_of(path):
    return {name for name in imports_of(path) if name in MODULES and name != "netdae"}


def room_of(module):
    return module.split(".")[1]


def is_left(path):
    """Whether it is a folder of an earlier version, of which only compiled files are left."""
    return path.is_dir() and {each.name for each in path.iterdir()} <= {"__pycache__"}


def test_the_package_is_seen_at_a_glance():
    entries = {
        path.name for path in PACKAGE.iterdir() if not path.name.startswith("__") and not is_left(path)
    }
    assert {*ROOMS} <= entries
    assert len(entries) <= SHOWN


@pytest.mark.parametrize("module", [module for module in MODULES if module != "netdae"])
def test_imports_go_down_only(module):
    below = ROOMS[: ROOMS.index(room_of(module)) + 1]
    assert {name for name in own_imports_of(MODULES[module]) if room_of(name) not in below} == set()


def test_imports_make_no_circle():
    graph = {module: own_imports_of(path) for module, path in MODULES.items() if module != "netdae"}
    list(graphlib.TopologicalSorter(graph).static_order())  # raises CycleError with the circle


@pytest.mark.parametrize(
    ("library", "homes"),
    [
        ("meshio", {"mesh.formats", "mesh.xdmf"}),
        (
            "pyvista",
            {
                "output.vtk",
                "output.target_series",
                "mesh.vtk_lines",
                "visual.rendering.frames",
                "visual.rendering.scene",
            },
        ),
        ("sksundae", {"solvers.cvode", "solvers.ida.stepper"}),
        ("cyclopts", {"cli"}),
        ("trimesh", {"mesh.surface"}),
        (
            "matplotlib",
            {
                "visual.plotting.comparison",
                "visual.plotting.drawing",
                "visual.plotting.style",
                "visual.rendering.colours",
            },
        ),
        ("mujoco", {"runs.verification.peer_models"}),
        ("exudyn", {"runs.verification.peer_models"}),
        ("PIL", {"visual.rendering.views", "visual.rendering.labels", "visual.rendering.movie_file"}),
    ],
)
def test_library_is_imported_in_one_place(library, homes):
    found = {
        "cli" if module.startswith("netdae.cli") else module.removeprefix("netdae.")
        for module, path in MODULES.items()
        if any(name.split(".")[0] == library for name in imports_of(path))
    }
    assert found - homes == set()
    assert found != set()


def loaded_after(code):
    shown = subprocess.run(
        [sys.executable, "-c", f"import sys\n{code}\nprint(*sys.modules, file=sys.stderr)"],
        capture_output=True,
        text=True,
        check=True,
    )
    return {name.split(".")[0] for name in shown.stderr.split()}


@pytest.mark.parametrize(
    "code",
    [
        "import netdae",
        "from netdae.cli import main\nassert main(['--help']) == 0",
        "from netdae.cli import main\nassert main(['run', '--help']) == 0 and main(['mesh', 'square', '-h']) == 0",
    ],
    ids=["import", "help", "help of verbs"],
)
def test_nothing_heavy_is_imported_before_it_is_used(code):
    assert loaded_after(code) & {*HEAVY} == set()


def test_every_public_name_can_be_had_whatever_was_imported_before():
    code = """
import netdae, netdae.solvers.flight, netdae.solvers.driver, netdae.cli.run
from types import ModuleType
assert not [name for name in netdae.__all__ if isinstance(getattr(netdae, name), ModuleType)]
"""
    assert "pyvista" in loaded_after(code)  # all of them were loaded
