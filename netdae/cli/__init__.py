"""The command line: verbs, exit codes 0, 1 (a run failed), 2 (a user's mistake), 130 (Ctrl-C)."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TextIO

from cyclopts import App, CoercionError, CycloptsError, MissingArgumentError, UnusedCliTokensError

from netdae import __version__
from netdae.core.errors import InputError, RunError
from netdae.core.files import reason_of
from netdae.core.text import as_text

app = App(
    name="netdae",
    help="Simulate deployable cable nets for active space-debris removal.",
    version=__version__,
    result_action="return_value",
    suppress_keyboard_interrupt=False,
)
app.command("netdae.cli.run:run", name="run", help="Run a scenario and write its frames and figures.")
app.command(
    "netdae.cli.check:check", name="check", help="Build a scenario and check its Jacobian; fly nothing."
)
app.command(
    "netdae.cli.forces:forces", name="forces", help="Rank the forces on a net by what they do in its flight."
)
app.command("netdae.cli.mesh:app", name="mesh", help="Generate or convert a net and write it to a mesh file.")
app.command("netdae.cli.info:info", name="info", help="Say what is in a mesh file.")
app.command(
    "netdae.cli.render:render", name="render", help="Make pictures, movies or a page for browsers of a run."
)
app.command("netdae.cli.plot:plot", name="plot", help="Draw the figures of runs as PNG and SVG.")
app.command(
    "netdae.cli.verify:verify",
    name="verify",
    help="Fly the verification cases and write a report that compares them with theory.",
)
app.command(
    "netdae.cli.schema:schema", name="schema", help="Print the JSON schema of a scenario, for editors."
)
app.command(
    "netdae.cli.manual:manual", name="manual", help="List the pages of the manual, or print one of them."
)

_PLACES = {"scenario": "SCENARIO.toml", "mesh": "MESH", "folder": "DIR"}
_TAKES = {
    "run": "one scenario at a time",
    "check": "one scenario at a time",
    "forces": "one scenario at a time",
    "info": "one mesh at a time",
    "render": "one folder at a time",
    "schema": "nothing",
    "manual": "one page at a time",
}
_NUMBERS: dict[type | None, str] = {float: "a number", int: "a whole number"}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command in the arguments, by default those of the process; return the exit code.

    An error that a user can fix is one line on stderr; a bug keeps its traceback.
    """
    with _output() as output:
        code = _code_of(list(sys.argv[1:] if arguments is None else arguments))
    # a pipe breaks when its reader has gone, for instance head
    if output.error is None or isinstance(output.error, BrokenPipeError):
        return code
    reason = reason_of(output.error)
    return code or _say(f"what is printed cannot be written: {reason}: make room, or print elsewhere", 1)


def _code_of(arguments: list[str]) -> int:
    try:
        app(arguments, exit_on_error=False, print_error=False)
    except CycloptsError as error:
        verb = " ".join(["netdae", *(error.command_chain or ())])
        return _say(f"{_words_of(error, verb)} See {verb} --help", 2)
    except InputError as error:
        return _say(str(error), 2)
    except RunError as error:
        return _say(str(error), 1)
    except KeyboardInterrupt as interrupt:
        return _say(str(interrupt) or "interrupted", 130)
    return 0


def _words_of(error: CycloptsError, verb: str) -> str:
    """What is wrong on the command line."""
    if isinstance(error, MissingArgumentError) and error.argument is not None:
        name = error.argument.name.lstrip("-")
        if name in _PLACES:
            return f"{name.upper()} is missing: {verb} {_PLACES[name]}."
        if not error.argument.tokens and error.keyword is None:
            return f"{error.argument.name} is missing."
        if error.keyword is not None:
            return f"{error.keyword} needs a value."
    if isinstance(error, UnusedCliTokensError):
        spare, name = " ".join(error.unused_tokens or ()), verb.removeprefix("netdae ")
        return f"{spare} is too much: {verb} takes {_TAKES.get(name, 'its options alone')}."
    if isinstance(error, CoercionError) and error.msg is None and error.token is not None:
        expected = _NUMBERS.get(error.target_type)
        if expected:
            return f'Invalid value for {error.token.keyword}: "{error.token.value}", expected {expected}.'
    return f"{error!s}." if str(error)[-1:] not in ".?" else str(error)


class _Output:
    """Standard output in which printing never fails, so that no flight ends by it; the error is kept in `error`."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.error: OSError | None = None
        with contextlib.suppress(AttributeError, ValueError):  # not a file's stream
            stream.reconfigure(errors="replace")  # type: ignore[attr-defined]  # characters that a terminal lacks

    def write(self, text: str) -> int:
        """Print, unless printing has failed before."""
        self._try(lambda: self._stream.write(text))
        return len(text)

    def flush(self) -> None:
        """Print what is buffered."""
        self._try(self._stream.flush)

    def _try(self, action: Callable[[], object]) -> None:
        if self.error is None:
            try:
                action()
            except OSError as error:
                self.error = error
                with contextlib.suppress(OSError):  # what Python still prints at its end goes nowhere
                    os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextlib.contextmanager
def _output() -> Iterator[_Output]:
    """Replace standard output by a safe stream; a closed stream becomes one to nowhere."""
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115  # for as long as the process lives
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115
    stream = sys.stdout
    output = _Output(stream)
    sys.stdout = output
    try:
        yield output
    finally:
        output.flush()
        sys.stdout = stream


def _say(message: str, code: int) -> int:
    with contextlib.suppress(OSError):  # there is no other place to say it
        print(as_text(" ".join(message.split())), file=sys.stderr)
    return code
