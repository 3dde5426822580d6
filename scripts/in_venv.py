"""Run a command of netdae in a virtual environment of its own, made at the first call.

    python3 scripts/in_venv.py netdae run scripts/corner_shot.toml -o out/corner_shot
    python3 scripts/in_venv.py --extra test pytest

The environment is the folder .venv of the project. It holds netdae, installed in place, and what it needs;
--extra test adds what the tests need. Nothing but Python 3.11 or newer is asked for. An environment that was
left unfinished, or whose project has been moved, is cleared and made anew.
"""

from __future__ import annotations

import os
import shutil
import signal
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
        return _say(f"Python 3.11 or newer is needed, this is {sys.version.split()[0]}", 2)
    extras = _extras()
    if extra and extra not in extras:
        return _say(f"there is no --extra {extra}: give one of {', '.join(extras)}", 2)
    try:
        prepare(extra)
    except subprocess.CalledProcessError as error:
        return _say(f"the installation failed: {_reason_of(error)}: mend it and call again", 1)
    except OSError as error:
        return _say(f"{HOME} cannot be made: {error.strerror or error}", 1)
    except KeyboardInterrupt:
        return _say("the installation was interrupted: call again to make it anew", 130)
    command = shutil.which(arguments[0], path=str(BIN))
    if command is None:
        return _say(f"there is no command {arguments[0]!r} in {BIN}: netdae --help reports its own", 2)
    environment = {**os.environ, "PATH": f"{BIN}{os.pathsep}{os.environ.get('PATH', '')}"}
    return _code_of([command, *arguments[1:]], environment)


def prepare(extra: str) -> None:
    """Make the environment, or bring it up to date when pyproject.toml is newer than it.

    Raises CalledProcessError where pip fails, OSError where nothing can be written.
    """
    done = HOME / f"netdae-installed-{extra or 'plain'}"
    wanted = PROJECT / "pyproject.toml"
    moved = any(_project_of(mark) != str(PROJECT) for mark in HOME.glob("netdae-installed-*"))
    if not moved and done.exists() and done.stat().st_mtime >= wanted.stat().st_mtime:
        return
    print(f"netdae: installing into {HOME} (once)", file=sys.stderr, flush=True)
    python = [str(BIN / "python"), "-m", "pip"]
    if moved or not _answers([*python, "--version"]):
        venv.create(HOME, with_pip=True, clear=True)
    target = f"{PROJECT}[{extra}]" if extra else str(PROJECT)
    pip = [*python, "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "--editable", target], check=True, stderr=subprocess.PIPE, text=True)
    # commands hold the folder in which they were installed: the mark reports it
    done.write_text(str(PROJECT), encoding="utf-8")


def _extras() -> list[str]:
    import tomllib  # not in a Python that is too old

    project = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return sorted(project.get("optional-dependencies", {}))


def _project_of(mark: Path) -> str:
    return mark.read_text(encoding="utf-8", errors="replace")


def _answers(command: list[str]) -> bool:
    try:
        return subprocess.run(command, capture_output=True, check=False).returncode == 0
    except OSError:
        return False


def _reason_of(error: subprocess.CalledProcessError) -> str:
    """The line in which pip says why, or the command that failed."""
    said = error.stderr or error.output or ""
    lines = (said.decode(errors="replace") if isinstance(said, bytes) else said).split("\n")
    reported = [line.strip() for line in lines if line.strip()]
    why = [line for line in reported if line.lower().startswith("error")] or reported
    return why[-1] if why else f"{' '.join(map(str, error.cmd))} gave {error.returncode}"


def _code_of(command: list[str], environment: dict[str, str]) -> int:
    """Exit code of a command that is run to its end; Ctrl-C reaches it by itself, so wait for what it says."""
    signal.signal(signal.SIGINT, lambda number, frame: None)  # the command starts with the usual handling
    code = subprocess.Popen(command, env=environment).wait()
    return code if code >= 0 else 128 - code  # ended by a signal, reported as shells do


def _say(message: str, code: int) -> int:
    print(f"netdae: {' '.join(message.split())}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
