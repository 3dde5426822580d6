"""Tasks for the tests of `netdae.runs.workers`, in a module that a worker imports in no time."""

import os
import signal
import time
from pathlib import Path

from netdae.core.errors import RunError


def mixed(item, report):
    """Does what the item says, and writes a file where it comes to its end."""
    path, what = item
    if what == "fail":
        raise RunError("the run failed at t = 1 s")
    if what == "bug":
        raise ZeroDivisionError("a bug")
    if what == "die":
        os._exit(3)
    if what == "wait":
        try:
            while True:
                report(os.getpid())
                time.sleep(0.02)
        except KeyboardInterrupt:
            Path(path).write_text("stopped")
            raise
    if what == "report":
        report((os.environ["OMP_NUM_THREADS"], signal.getsignal(signal.SIGINT) == signal.SIG_IGN))
    Path(path).write_text("done")
