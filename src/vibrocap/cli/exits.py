"""Exit codes of the commands, and how a command says why it ends with one of them."""

import sys

OK, WRONG_INPUT, INCOMPLETE, INTERRUPTED, BROKEN_PIPE = 0, 2, 3, 130, 141


def complain(message: str) -> None:
    """Print a message to stderr."""
    print(message, file=sys.stderr)
