"""The command line: verbs, exit codes 0, 1 (a run failed), 2 (a user's mistake), 130 (Ctrl-C)."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from cyclopts import App, CycloptsError

from netdae import __version__
from netdae.errors import InputError, RunError

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
app.command("netdae.cli.mesh:app", name="mesh", help="Generate a net and write it to a mesh file.")
app.command("netdae.cli.info:info", name="info", help="Say what is in a mesh file.")
app.command(
    "netdae.cli.schema:schema", name="schema", help="Print the JSON schema of a scenario, for editors."
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what the arguments, by default those of the process, ask; the exit code.

    What a user can mend is one line on stderr; a bug keeps its traceback.
    """
    try:
        app(
            list(sys.argv[1:] if arguments is None else arguments),
            exit_on_error=False,
            print_error=False,
        )
        sys.stdout.flush()
    except CycloptsError as error:
        return _say(f"{error} See netdae --help", 2)
    except InputError as error:
        return _say(str(error), 2)
    except RunError as error:
        return _say(str(error), 1)
    except KeyboardInterrupt as interrupt:
        return _say(str(interrupt) or "interrupted", 130)
    except BrokenPipeError:  # the reader of what is printed has left, for instance head
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 0


def _say(message: str, code: int) -> int:
    print(" ".join(message.split()), file=sys.stderr)
    return code
