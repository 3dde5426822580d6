"""Compiled kernels are as new as all their sources."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import netdae
from netdae.core.kernel_cache import forget_outdated
from netdae.core.sources import Sources
from netdae.forces.law import version_of

INNER = "from numba import njit\n\n@njit(cache=True)\ndef inner(x):\n    return x + {gain}\n"
OUTER = (
    "from netdae.core.kernel_cache import forget_outdated\n"
    "forget_outdated({folder!r})\n"
    "from numba import njit\nfrom inner import inner\n\n"
    "@njit(cache=True)\ndef outer(x):\n    return inner(x)\n\nprint(outer(1))\n"
)


def reported(folder: Path) -> str:
    done = subprocess.run(
        [sys.executable, "outer.py"], cwd=folder, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


def test_a_kernel_is_compiled_anew_where_one_that_it_calls_has_changed(tmp_path: Path) -> None:
    (tmp_path / "inner.py").write_text(INNER.format(gain=1), encoding="utf-8")
    (tmp_path / "outer.py").write_text(OUTER.format(folder=str(tmp_path)), encoding="utf-8")
    assert reported(tmp_path) == "2"
    (tmp_path / "inner.py").write_text(INNER.format(gain=10), encoding="utf-8")
    assert reported(tmp_path) == "11"  # numba alone would say 2


FILES = ["kernel.f-3.py311.1.nbc", "kernel.f-3.py311.nbi"]


@pytest.mark.parametrize(("edited", "kept"), [("kernel", []), ("other", FILES)])
def test_only_newer_sources_of_kernels_count(tmp_path: Path, edited: str, kept: list[str]) -> None:
    cache = tmp_path / "deep" / "__pycache__"
    cache.mkdir(parents=True)
    for name in ("kernel", "other"):
        (tmp_path / "deep" / f"{name}.py").write_text("", encoding="utf-8")
        os.utime(tmp_path / "deep" / f"{name}.py", (100.0, 100.0))
    for name in FILES:
        (cache / name).write_bytes(b"")
        os.utime(cache / name, (200.0, 200.0))
    os.utime(tmp_path / "deep" / f"{edited}.py", (300.0, 300.0))
    forget_outdated(str(tmp_path))
    assert sorted(path.name for path in cache.iterdir()) == kept


def test_an_edit_of_a_law_outdates_its_own_kernels_and_no_step() -> None:
    package = Path(netdae.__file__).parent
    sources = Sources(str(package))
    laws = {str(package / "forces" / f"{name}.py") for name in ("cables", "drawcord", "orbit", "air", "reel")}
    for driver in (
        "explicit/verlet",
        "explicit/drums",
        "ida/newton",
        "forces/table",
        "forces/loops",
    ):
        assert not sources.closure_of(str(package / f"{driver}.py")) & laws, driver
    # laws are distinguished by a hash of all that they are made of
    assert str(package / "forces/cables.py") in sources.closure_of(str(package / "forces/reel.py"))
    assert version_of("netdae.forces.cables") != version_of("netdae.forces.reel")
    assert version_of("somewhere.else") == ""
