"""`vibrocap` and `python -m vibrocap` are the command line; here it hears interrupts, from the first import on."""

import gc
import os
import signal
import sys
from typing import Any

from vibrocap import working_folder
from vibrocap.cli.overview import REQUESTS, overview

INTERRUPTED = 130  # as a shell says it


def run() -> int:
    """Run the command line; returns its exit code.

    The first interrupt (Ctrl-C) ends what is being done in good order, and the command says what is kept. One during
    the imports, when there is nothing to put in order, or a second one, ends the process at once.
    """
    orderly = False

    def interrupted(number: int, frame: Any) -> None:
        nonlocal orderly
        if orderly:
            orderly = False
            raise KeyboardInterrupt
        os.write(2, b"Interrupted.\n")
        os._exit(INTERRUPTED)

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # and not ignored, as in the background
        signal.signal(signal.SIGINT, interrupted)
    working_folder.leave_out()
    if sys.argv[1:] in REQUESTS:  # before the commands and their libraries are imported
        print(overview(), end="")
        return 0
    gc.disable()  # while modules are made, which stay
    from vibrocap.cli.main import main

    gc.freeze()
    gc.enable()
    orderly = True
    return main()


if __name__ == "__main__":
    sys.exit(run())
