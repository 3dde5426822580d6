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

# from the bottom up; a module imports its own layer or lower ones. A new module gets its place here.
LAYERS = (
    (
        *("_arrays", "_files", "_kernel_cache", "_sources", "addresses", "compilation", "earth", "errors"),
        *("journal", "lock", "records", "workers"),
    ),
    (
        *("assembly", "block_ldl", "closing", "damping", "forces", "masses", "material", "matrices"),
        *("motions", "net", "net_forces", "patterns", "phases", "reels", "restraints", "scalar_ldl"),
        *("signals", "state"),
    ),
    (
        *("closed", "ejection", "external_forces", "force_ranking", "initial", "mouth", "plausibility"),
        *("scales", "stowing", "surface_forces", "system", "tether", "tethered"),
    ),
    (
        *("balance", "cvode", "explicit", "finder", "flight", "ida", "integration", "ivp", "ledger"),
        *("linear_solver", "mark", "modes", "options", "statics", "stepper"),
    ),
    ("checkpoint", "ensemble", "events", "figures", "gauge", "metrics", "observers", "recorder"),
    ("mesh", "vtk"),
    ("rendering",),
    ("scenario", "tables"),
    ("ensemble_folder", "jacobian_check", "plotting", "run_folder", "run_summary", "stopped_run"),
    ("cli",),
)
LAYER_OF = {name: number for number, names in enumerate(LAYERS) for name in names}

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


def layer_of(module):
    return LAYER_OF.get(module.split(".")[1], 0)


def test_every_module_has_its_layer():
    modules = {module.split(".")[1] for module in MODULES if module != "netdae"}
    assert modules - {*LAYER_OF} == set()


@pytest.mark.parametrize("module", [module for module in MODULES if module != "netdae"])
def test_imports_go_down_only(module):
    higher = {name for name in own_imports_of(MODULES[module]) if layer_of(name) > layer_of(module)}
    assert higher == set()


def test_imports_make_no_circle():
    graph = {module: own_imports_of(path) for module, path in MODULES.items() if module != "netdae"}
    list(graphlib.TopologicalSorter(graph).static_order())  # raises CycleError with the circle


@pytest.mark.parametrize(
    ("library", "homes"),
    [
        ("meshio", {"mesh.formats"}),
        ("pyvista", {"vtk", "mesh.vtk_lines", "rendering.frames", "rendering.scene"}),
        ("sksundae", {"cvode", "ida.stepper"}),
        ("cyclopts", {"cli"}),
        ("matplotlib", {"plotting.drawing", "plotting.style", "rendering.colours"}),
        ("PIL", {"rendering.views", "rendering.labels", "rendering.movie_file"}),
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
import netdae, netdae.flight, netdae.integration, netdae.cli.run
from types import ModuleType
assert not [name for name in netdae.__all__ if isinstance(getattr(netdae, name), ModuleType)]
"""
    assert "pyvista" in loaded_after(code)  # all of them were loaded
