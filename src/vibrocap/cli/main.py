"""The command line: its commands from their modules, their exit codes, and `main`, which runs one.

Exit codes: 0 done; 2 wrong input, each bad field named on stderr before any work; 3 a run that could not be completed,
with its status and what was computed until then; 130 interrupted.
"""

import collections
import contextlib
import difflib
import functools
import importlib
import inspect
import io
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, Literal

from cyclopts import App, CycloptsError, Parameter, UnknownOptionError

from vibrocap import files, inputs
from vibrocap.arguments import SettingError
from vibrocap.case.case import CaseError
from vibrocap.cli.command_examples import examples_of
from vibrocap.cli.completers import completing, example_names, machine_names, measure_names, part_names, script
from vibrocap.cli.options import Refusal, needs, own_names, writable_folder
from vibrocap.cli.parts import taking_parts
from vibrocap.cli.pictures import taking_page
from vibrocap.cli.terminal import (
    BROKEN_PIPE,
    INCOMPLETE,
    INTERRUPTED,
    OK,
    WRONG_INPUT,
    Page,
    complain,
    progress,
    table,
)
from vibrocap.files import WriteError, write_text

OF_REPORT = (("claims", "json"), ("claims", "csv"), ("load", "json"), ("report", "html"))  # what `reproduce` writes
WIDE = 120  # columns of a terminal
BEGIN = """To begin with:

  vibrocap examples --to examples
  vibrocap simulate examples/travels-by-stick-slip.toml --plot run.png

`vibrocap COMMAND --help` explains a command, with examples. \
Exit codes: 0 done, 2 wrong input, 3 a run that could not be completed.
"""


def reproduce(*, out: Path = Path("out"), only: str | None = None) -> int:
    """The paper: its figures from our own runs, its claims with their verdicts, one HTML report.

    Parameters
    ----------
    out
        folder for report.html, the figures and their data; made where it is missing
    only
        one figure and its claims, such as fig09; the report is report-fig09.html then
    """
    from vibrocap.paper.figures.catalogue import KEYS

    if only is not None and only not in KEYS:
        raise Refusal(f"--only: should be one of {', '.join(KEYS)}, got {only!r}")
    needs("reproduce", "matplotlib")
    writable_folder("--out", out)
    ending = "" if only is None else f"-{only}"
    own_names("--out", out, *(f"{name}{ending}.{kind}" for name, kind in OF_REPORT))
    from vibrocap.report.reproduce import reproduce as reproduced

    with progress("The paper") as report:
        result = reproduced(out, only, lambda what, share: report(share, what))
    print_claims(result)
    return OK


def print_claims(result: Any) -> None:
    """The summary of `vibrocap reproduce`: every claim with its verdict, and where the report lies.

    The numbers found stand beside it where the terminal is wide enough; the report has them all.
    """
    page = Page()
    wide = page.width >= WIDE
    made = table("Claims of the paper", "claim", "where", "verdict", *(["found"] if wide else []))
    made.columns[1].no_wrap = False
    for verdict in result.claims:
        found = ", ".join(f"{name} {value:.5g}" for name, value in verdict.finding.found.items())
        made.add_row(verdict.claim.key, verdict.claim.where, verdict.verdict, *([found] if wide else []))
    page.print(made)
    counts = collections.Counter(verdict.finding.outcome.value for verdict in result.claims)
    tally = ", ".join(f"{outcome} {count}" for outcome, count in counts.most_common())
    page.print(f"{len(result.claims)} claims in {result.seconds:.0f} s: {tally}.")
    page.say(f"Report: {result.report}")


def completion(shell: Literal["bash", "zsh", "fish", "powershell"], /, *, install: bool = False) -> int:
    """The script that lets a shell complete what stands behind vibrocap.

    That is its commands and options, the names of laws, machines, drives, measures
    and examples, and the paths and states of the case on the line.

    Parameters
    ----------
    shell
        bash, zsh, fish or powershell
    install
        write it to where the shell looks for such scripts, instead of printing it; for bash and zsh with a line in
        .bashrc or .zshrc
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


def paragraphs(command: Callable) -> str:
    """What a command does, a line for each paragraph, so that the terminal wraps it."""
    said, _, _ = (inspect.getdoc(command) or "").partition("\n\nParameters\n")
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in said.split("\n\n"))


# name of a command: the module in `cli/` that holds its function, in the order in which they are listed
COMMANDS = {
    "new": "commands.start",
    "examples": "commands.start",
    "reproduce": "main",
    "simulate": "commands.simulate",
    "convert": "commands.start",
    "limits": "commands.friction",
    "sweep": "commands.sweep",
    "measures": "commands.sweep",
    "verify": "commands.sweep",
    "plot": "commands.sweep",
    "orbit": "commands.orbit",
    "branch": "commands.branch",
    "basins": "commands.branch",
    "crossing": "commands.crossing",
    "equilibria": "commands.equilibria",
    "optimise": "commands.optimise",
    "robust": "commands.robust",
    "bound": "commands.bound",
    "calibrate": "commands.calibrate",
    "lab": "commands.lab",
    "export": "commands.export",
    "friction": "commands.friction",
    "machines": "commands.machines",
    "fit": "commands.fit",
    "check": "parts",
    "stick-slip": "commands.records",
    "datasets": "commands.records",
    "cite": "commands.cite",
    "completion": "main",
}
WITH_PICTURES = ("simulate", "plot", "branch", "basins", "equilibria", "optimise", "fit", "stick-slip")
# They know no part, or see to it themselves.
WITHOUT_PARTS = ("examples", "completion", "reproduce", "verify", "plot", "friction", "stick-slip", "datasets")
OWN_OFFERS = {
    "examples": {"names": example_names},
    "check": {"names": part_names},
    "machines": {"name": machine_names},
    "optimise": {"against": measure_names},
}


@functools.cache
def app_of(*names: str) -> App:
    """The command line with these commands, whose modules are imported; by default with all."""
    made = App(
        name="vibrocap",
        help="Vibro-driven capsules: machines that travel by shaking an inner mass against friction.",
        help_epilogue=BEGIN,
        help_format="plaintext",
        version=_version,
        result_action="return_value",
        default_parameter=Parameter(negative=()),
        suppress_keyboard_interrupt=False,  # `main` says what was interrupted
    )
    for name in names or COMMANDS:
        command = getattr(importlib.import_module(f"vibrocap.cli.{COMMANDS[name]}"), name.replace("-", "_"))
        if isinstance(command, App):  # it has its own examples
            made.command(command)
            continue
        run = completing(**OWN_OFFERS.get(name, {}))(command)
        run = taking_page(run) if name in WITH_PICTURES else run
        run = run if name in WITHOUT_PARTS else taking_parts(run)
        made.command(run, help=paragraphs(command), help_epilogue=examples_of(name))
    return made


def _version() -> str:
    from importlib.metadata import version

    return version("vibrocap")


def __getattr__(name: str) -> Any:
    """`app`: the command line with all commands."""
    if name == "app":
        return app_of()
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


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


def unknown_option(error: UnknownOptionError) -> str:
    """An unknown option, and one of a similar name: the dashes, which all have, make none similar."""
    given = (error.token.keyword or error.token.value).partition("=")[0]
    names = {name.strip("-"): name for each in error.argument_collection if each.parse for name in each.names}
    near = difflib.get_close_matches(given.strip("-"), names, n=1, cutoff=0.65)
    return f"Unknown option: {given}.{f' Did you mean {names[near[0]]}?' if near else ''}"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns its exit code."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by who called; what is printed goes nowhere
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 - open to the end
        if isinstance(stream := getattr(sys, name), io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters still gets the numbers
    given = sys.argv[1:] if arguments is None else list(arguments)
    app = app_of(*(name for name in given[:1] if name in COMMANDS))  # one that is named needs no other
    try:
        with _nothing_read_is_replaced():
            code = int(app(given, exit_on_error=False, print_error=False) or OK)
        sys.stdout.flush()
        return code
    except (CaseError, Refusal, SettingError) as error:
        complain(str(error))
    except CycloptsError as error:
        said = unknown_option(error) if isinstance(error, UnknownOptionError) else str(error)
        complain(f"{said}\nvibrocap --help shows the commands with an example each.")
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
