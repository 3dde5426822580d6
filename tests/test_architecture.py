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
    ("_arrays", "_files", "compilation", "earth", "errors", "journal", "lock", "workers"),
    (
        *(
            "assembly",
            "block_ldl",
            "scalar_ldl",
            "closing",
            "damping",
            "forces",
            "masses",
            "material",
            "matrices",
        ),
        *("motions", "net", "net_forces", "patterns", "phases", "reels", "restraints", "signals", "state"),
    ),
    (
        *("accordion_fold", "closed", "ejection", "external_forces", "force_ranking", "initial", "mouth"),
        *(
            "opening",
            "plausibility",
            "scales",
            "star_fold",
            "stowed",
            "surface_forces",
            "system",
            "tether",
            "tethered",
        ),
    ),
    (
        *("addresses", "balance", "chunk", "cvode", "explicit", "finder", "flight", "ida", "ida_books"),
        *("ida_calls", "ida_chunk", "ida_failures", "ida_kernel", "ida_layout", "ida_matrix", "ida_memory"),
        *("ida_record", "integration", "ivp", "kernel", "kernel_cables", "kernel_forces", "kernel_reels"),
        *("kernel_cordage", "kernel_loads", "kernel_rayleigh", "kernel_strings", "kernel_surfaces"),
        *("addressed", "ida_asked", "ida_asking", "ida_dyads", "ida_further", "ida_further_calls"),
        *("ida_further_functions", "ida_further_record"),
        *("ida_lines", "ida_links", "ida_outside", "ida_reels"),
        *("kicks", "ledger", "linear_solver", "mark", "modes", "native_ida", "options", "statics"),
        *("stable_step", "stepper", "sundials", "verlet"),
    ),
    (
        *("checkpoint", "ensemble", "event_book", "event_figures", "event_watches", "events", "figures"),
        *("gauge", "metrics", "observers", "recorder"),
    ),
    (
        *("inp", "mesh_findings", "mesh_formats", "mesh_io", "mesh_net"),
        *("msh", "raw_mesh", "vtk", "vtk_lines"),
    ),
    (
        *("flight_page", "movie_file", "render", "render_camera", "render_colours", "render_frames"),
        *("render_labels", "render_look", "render_scene"),
    ),
    (
        *("scenario", "scenario_build", "scenario_closed", "scenario_closing", "scenario_cords"),
        *("scenario_digest",),
        *("scenario_environment", "scenario_events", "scenario_files", "scenario_groups", "scenario_initial"),
        *("scenario_loads", "scenario_metrics", "scenario_nets", "scenario_problems", "scenario_restraints"),
        *("scenario_schema", "scenario_section"),
        *(
            "scenario_signals",
            "scenario_tables",
            "scenario_tether",
            "scenario_tethered",
            "simulation",
            "tables",
        ),
    ),
    (
        *("ensemble_folder", "jacobian_check", "plot_drawing", "plot_figures", "plot_marks", "plot_runs"),
        *("plot_style", "plots", "run_folder", "run_summary", "stopped_run"),
    ),
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
        ("meshio", {"mesh_formats"}),
        ("pyvista", {"vtk", "vtk_lines", "render_frames", "render_scene"}),
        ("sksundae", {"cvode", "ida"}),
        ("cyclopts", {"cli"}),
        ("matplotlib", {"plot_drawing", "plot_style", "render_colours"}),
        ("PIL", {"render", "render_labels", "movie_file"}),
    ],
)
def test_library_is_imported_in_one_place(library, homes):
    found = {
        module.split(".")[1]
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
