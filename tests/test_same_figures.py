"""The same file gives the same figures: from the first flight on, and whatever was compiled or flown before."""

from __future__ import annotations

import importlib
import pkgutil
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import CodeType, FunctionType

from numba.core.ccallback import CFunc
from numba.core.dispatcher import Dispatcher
from shots import shot

import netdae
from netdae.forces import loops
from netdae.solvers.ida import calls

ROOT = Path(__file__).resolve().parent.parent
SCENARIO = shot(
    title="small",
    youngs_modulus="70e9",
    viscosity_time="1e-5",
    mass=0.1,
    scale=0.5,
    speed=2.0,
    half_angle_deg=45.0,
    accuracy=None,
    frames=3,
)


def test_the_first_flight_gives_the_figures_of_the_second(tmp_path: Path) -> None:
    """IDA's Newton iteration, which calls most of the others, is compiled anew; all kernels, by the script alone."""
    (tmp_path / "small.toml").write_text(SCENARIO, encoding="utf-8")
    script = [sys.executable, str(ROOT / "scripts" / "first_flight.py"), str(tmp_path / "small.toml")]
    done = subprocess.run([*script, "--forget", "ida/calls.on_newton"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    # one kernel for each Python that has been used here, and its index
    assert re.fullmatch(
        r"small.toml, [1-9]\d* kernels compiled anew: 3 frames agree bit for bit\n", done.stdout
    )


def compiled_functions() -> Iterator[Dispatcher]:
    for found in pkgutil.walk_packages(netdae.__path__, "netdae."):
        if ".visual" not in found.name and ".cli" not in found.name:
            for thing in vars(importlib.import_module(found.name)).values():
                if isinstance(thing, Dispatcher):
                    yield thing


def names_in(code: CodeType) -> set[str]:
    inner = (each for each in code.co_consts if isinstance(each, CodeType))
    return set(code.co_names).union(*map(names_in, inner))


def test_a_compiled_function_that_others_call_is_inlined() -> None:
    """Otherwise a process has several copies, which differ in round-off, and runs the one that it loads first."""
    makers = (*vars(loops).values(), *vars(calls).values())  # of C functions, with those inside
    codes = [(each.py_func.__code__, each.py_func.__globals__) for each in compiled_functions()]
    codes += [(each.__code__, each.__globals__) for each in makers if isinstance(each, FunctionType)]
    codes += [(each._pyfunc.__code__, each._pyfunc.__globals__) for each in makers if isinstance(each, CFunc)]
    called = {id(space.get(name)): space.get(name) for code, space in codes for name in names_in(code)}
    copied = {
        f"{each.py_func.__module__}.{each.py_func.__qualname__}"
        for each in called.values()
        if isinstance(each, Dispatcher) and not each.targetoptions.get("forceinline")
    }
    # inlined at its four places, it would take 20 s more to compile; a capture's first flight may differ in round-off
    assert copied == {"netdae.model.shapes.distance.curvature_at"}


PROGRAM = """
import numpy as np
import netdae as nd
from netdae.initial.scaled import ejected, scaled
from netdae.solvers.ida.newton import solve
if {load}:
    for signature, *_ in solve._cache._cache_file._load_index():
        solve.compile(signature)
    assert solve.overloads
net, start = scaled(nd.CableNet.square(side=1.0, cells=4), (0.5, 0.5, 1.0))
start = ejected(net, start, "corners", speed=2.0, half_angle_deg=45.0)
cord = nd.Material(youngs_modulus=70e9, density=1390.0, diameter=1e-3)
system = nd.System(net, cord, masses={{"corners": 0.1}}, damping=nd.Dashpot(viscosity_time=1e-5))
print(nd.simulate(system, start, np.linspace(0, 0.1, 3))[-1].x.tobytes().hex())
"""


def test_a_flight_does_not_depend_on_what_was_loaded_before_it() -> None:
    """Kernels that another use of the package has loaded change no bit of IDA's flight."""
    plain, loaded = (
        subprocess.run(
            [sys.executable, "-c", PROGRAM.format(load=load)], capture_output=True, text=True, check=True
        ).stdout
        for load in (False, True)
    )
    assert plain == loaded
