"""Run a command of netdae in a virtual environment of its own, made at the first call.

    python3 scripts/in_venv.py netdae run scripts/corner_shot.toml -o out/corner_shot
    python3 scripts/in_venv.py --extra test pytest

The environment is the folder .venv of the project. It holds netdae, installed in place, and what it needs;
--extra test adds what the tests need. Nothing but Python 3.11 or newer is asked for.
"""

from __future__ import annotations

import os
import subprocess
import sys
import venv
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent
HOME = PROJECT / ".venv"
BIN = HOME / ("Scripts" if os.name == "nt" else "bin")


def main(arguments: list[str]) -> int:
    """Make sure of the environment and run the command in it; its exit code."""
    extra = ""
    if arguments[:1] == ["--extra"]:
        extra, arguments = "".join(arguments[1:2]), arguments[2:]
    if not arguments or arguments[0].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    if sys.version_info < (3, 11):  # noqa: UP036  # this file is what an older Python meets first
        print(f"netdae needs Python 3.11 or newer, this is {sys.version.split()[0]}", file=sys.stderr)
        return 2
    prepare(extra)
    environment = {**os.environ, "PATH": f"{BIN}{os.pathsep}{os.environ.get('PATH', '')}"}
    return subprocess.run([str(BIN / arguments[0]), *arguments[1:]], env=environment, check=False).returncode


def prepare(extra: str) -> None:
    """Make the environment, or bring it up to date when pyproject.toml is newer than it."""
    done = HOME / f"netdae-installed-{extra or 'plain'}"
    wanted = PROJECT / "pyproject.toml"
    if done.exists() and done.stat().st_mtime >= wanted.stat().st_mtime:
        return
    print(f"netdae: installing into {HOME} (once)", file=sys.stderr, flush=True)
    if not (BIN / ("python.exe" if os.name == "nt" else "python")).exists():
        venv.create(HOME, with_pip=True)
    target = f"{PROJECT}[{extra}]" if extra else str(PROJECT)
    pip = [str(BIN / "python"), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "--editable", target], check=True)
    done.touch()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
