"""The command line: its commands from their modules, its help, its exit codes, and `main`, which runs one.

Exit codes: 0 done; 2 wrong input, each bad field named on stderr before any work; 3 a run that could not be completed,
with its status and what was computed until then; 130 interrupted.
"""

import contextlib
import difflib
import functools
import importlib
import io
import os
import shlex
import sys
from collections.abc import Iterator, Sequence
from typing import Literal

from cyclopts import App, CycloptsError, Parameter, UnknownOptionError, UnusedCliTokensError

from vibrocap import files, inputs
from vibrocap.arguments import Refusal, SettingError
from vibrocap.case.case import CaseError
from vibrocap.cli import commands
from vibrocap.cli.command import COMMANDS
from vibrocap.cli.completers import script
from vibrocap.cli.overview import ABOUT, REQUESTS, names, overview
from vibrocap.cli.terminal import BROKEN_PIPE, INCOMPLETE, INTERRUPTED, OK, WRONG_INPUT, Page, complain
from vibrocap.files import WriteError, write_text

# commands of earlier versions, by their first words: what they are now
MOVED = {
    "bound": "lines of `vibrocap orbit CASE`, and of `vibrocap optimise`",
    "check": "`vibrocap list PART --check`",
    "cite": "`vibrocap simulate CASE --cite text`",
    "completion": "`vibrocap --completion SHELL`",
    "convert": "`vibrocap new --from CASE`",
    "datasets fetch": "`vibrocap list datasets --fetch NAME`",
    "datasets": "`vibrocap list datasets`",
    "friction list": "`vibrocap list laws`",
    "friction show": "`vibrocap friction LAW`",
    "friction test": "`vibrocap friction LAW --tests`",
    "limits": "`vibrocap friction CASE`",
    "machines": "`vibrocap list machines`",
    "measures": "`vibrocap list measures`",
    "verify": "`vibrocap sweep FOLDER --verify`",
}


@functools.cache
def app_of(*wanted: str) -> App:
    """The command line with these commands, whose modules are imported; by default with all."""
    app = App(
        name="vibrocap",
        help=ABOUT,
        help_format="plaintext",
        version=_version,
        result_action="return_value",
        default_parameter=Parameter(negative=()),
        suppress_keyboard_interrupt=False,  # `main` says what was interrupted
    )
    for name in wanted or names():
        importlib.import_module(f"{commands.__name__}.{name.replace('-', '_')}")
        command = COMMANDS[name]
        examples = "Examples:\n\n" + "".join(f"  {line}\n" for line in command.examples)
        app.command(command.entry(), name=name, help=command.words, help_epilogue=examples)
    app.command(completion, name="--completion", show=False)
    return app


def completion(shell: Literal["bash", "zsh", "fish", "powershell"], /, *, install: bool = False) -> int:
    """Print a shell completion script.

    It completes commands and options, the names of parts, measures and examples, and the paths of the case on the line.

    Parameters
    ----------
    shell
        bash, zsh, fish or powershell
    install
        write it to the folder of such scripts instead; for bash and zsh with a line in .bashrc or .zshrc
    """
    app = app_of()
    text = script(app, shell)
    if install:
        path = app.install_completion(shell=shell)
        write_text(path, text)
        Page().say(f"Written: {path}\nIt works in the next shell.")
    else:
        print(text)
    return OK


def _version() -> str:
    from importlib.metadata import version

    return version("vibrocap")


def _silence() -> None:
    """Where the standard output takes no more, nothing more is written to it, not even when Python ends."""
    with contextlib.suppress(OSError, ValueError):
        try:
            sys.stdout.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@contextlib.contextmanager
def _nothing_read_is_replaced() -> Iterator[None]:
    """Within it no file is written in place of one that was read, by whatever name."""
    inputs.READ.clear()
    files.PROTECTED = inputs.READ
    try:
        yield
    finally:
        files.PROTECTED = set()


def misunderstood(error: CycloptsError) -> str:
    """What cannot be read of a line; of an unknown option one of a similar name, as which no dash counts."""
    if isinstance(error, UnusedCliTokensError):
        return f"There is no place for {shlex.join(error.unused_tokens or [])}."
    if not isinstance(error, UnknownOptionError):
        return str(error)
    word = (error.token.keyword or error.token.value).partition("=")[0]
    names = {
        name.strip("-"): name for argument in error.argument_collection if argument.parse for name in argument.names
    }
    near = difflib.get_close_matches(word.strip("-"), names, n=1, cutoff=0.65)
    return f"Unknown option: {word}.{f' Did you mean {names[near[0]]}?' if near else ''}"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns its exit code."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by who called; what is printed goes nowhere
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 - open to the end
        if isinstance(stream := getattr(sys, name), io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters still gets the numbers
    words = sys.argv[1:] if arguments is None else list(arguments)
    if words in REQUESTS:
        print(overview(), end="")
        return OK
    for old, new in MOVED.items():
        if words[: len(old.split())] == old.split():
            complain(f"`vibrocap {old}` is now {new}.")
            return WRONG_INPUT
    app = app_of(*(name for name in words[:1] if name in names()))  # one that is named needs no other
    try:
        with _nothing_read_is_replaced():
            code = int(app(words, exit_on_error=False, print_error=False) or OK)
        sys.stdout.flush()
        return code
    except (CaseError, Refusal, SettingError) as error:
        complain(str(error))
    except CycloptsError as error:
        known = words[0] in names() if words else False
        help_ = f"{words[0]} --help explains its options" if known else "--help shows the commands"
        complain(f"{misunderstood(error)}\nvibrocap {help_}, with examples.")
    except BrokenPipeError:  # the reader of a pipe, `head` for instance, has seen enough
        _silence()
        return BROKEN_PIPE
    except WriteError as error:
        complain(str(error))
        return INCOMPLETE
    except OSError as error:  # the standard output on a full disk, a file that is gone since it was looked for
        where = error.filename or ("standard output" if error.errno else "a file")  # the libraries of files name none
        complain(f"{where}: {error.strerror or error}")
        _silence()
        return INCOMPLETE
    except KeyboardInterrupt as interruption:
        complain(str(interruption) or "Interrupted.")
        return INTERRUPTED
    except Exception as error:  # a fault in a part of the user's own is theirs to mend; any other is ours
        from vibrocap.numerics.expressions.refusals import RecordingError
        from vibrocap.physics.part_files import place_in_parts

        place, text = place_in_parts(error), str(error)
        if place is not None and not text.startswith(place):
            text = f"{place}: {type(error).__name__}: {text}"
        elif place is None and not isinstance(error, RecordingError):
            raise
        complain(text)
    return WRONG_INPUT
