"""Does the first flight, for which kernels are compiled, give the figures of later ones, which find them on disk?

    python scripts/first_flight.py
    python scripts/first_flight.py scripts/corner_shot.toml scripts/closing_winches.toml
    python scripts/first_flight.py scripts/rayleigh_shot.toml --forget ida/calls.on_newton

A copy of the package without its kernels, or without those in files that begin with what `--forget` names, flies each
scenario in a process of its own, and then again in another one. The frames are compared bit for bit, and where they
differ the exit code is 1.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import netdae

HERE = Path(__file__).resolve().parent
RUN = "import sys; from netdae.cli import main; sys.exit(main())"


def forget(package: Path, kernels: Sequence[str]) -> int:
    """Delete the kernels of a package, all or those whose folder and name begin so; return how many there were."""
    gone = 0
    for path in package.glob("**/__pycache__/*.nb?"):
        name = f"{path.parent.parent.name}/{path.name}"
        if not kernels or any(name.startswith(kernel) for kernel in kernels):
            path.unlink()
            gone += 1
    return gone


def fly(place: Path, scenario: Path, out: Path) -> dict[str, np.ndarray]:
    """The frames of a flight by the package in a folder, in a process of its own."""
    environment = {**os.environ, "PYTHONPATH": str(place)}
    environment.pop("NUMBA_CACHE_DIR", None)
    command = [sys.executable, "-c", RUN, "run", str(scenario), "-o", str(out)]
    subprocess.run(command, cwd=place, env=environment, check=True, stdout=subprocess.DEVNULL)
    with np.load(out / "trajectory.npz") as arrays:
        return {name: arrays[name] for name in arrays.files}


def differing(one: dict[str, np.ndarray], other: dict[str, np.ndarray]) -> list[str]:
    """Names of the arrays that are not the same bit for bit."""
    return [name for name in one if one[name].tobytes() != other[name].tobytes()]


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly each scenario for the first and the second time; return 0 if the frames agree."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("scenarios", nargs="*", type=Path, default=[HERE / "corner_shot.toml"])
    parser.add_argument("--forget", nargs="*", default=[], help="folder/name with which kernels begin")
    options = parser.parse_args(arguments)
    failed = False
    for scenario in options.scenarios:
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder)
            shutil.copytree(Path(netdae.__file__).parent, place / "netdae")
            gone = forget(place / "netdae", options.forget)
            first, second = (fly(place, scenario.resolve(), place / name) for name in ("first", "second"))
            differ = differing(first, second)
        what = f"differ in {', '.join(differ)}" if differ else "agree bit for bit"
        print(f"{scenario.name}, {gone} kernels compiled anew: {len(first['times'])} frames {what}")
        failed |= bool(differ)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
