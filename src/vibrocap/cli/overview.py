"""The help of the command line as a whole, read from the texts of the commands, of which it imports none."""

import ast
import pkgutil
from collections.abc import Iterator
from pathlib import Path

from vibrocap.cli import commands

GROUPS = ("start", "run", "steady", "design", "data", "out")  # of commands, in the order of the help
REQUESTS = ([], ["--help"], ["-h"])  # the lines that it answers
ABOUT = "Vibro-driven capsules: they travel by shaking an inner mass against friction."
BEGIN = """\
To begin with:
  vibrocap examples --to examples
  vibrocap simulate examples/travels-by-stick-slip.toml --plot run.png
vibrocap COMMAND --help explains a command; --completion SHELL is for TAB.
Exit codes: 0 done, 2 wrong input, 3 a run that could not be completed.
"""


def names() -> list[str]:
    """The commands: a module each in `commands`."""
    return [iter_module.name.replace("_", "-") for iter_module in pkgutil.iter_modules(commands.__path__)]


def summaries() -> Iterator[tuple[str, str, str]]:
    """(name, group, first paragraph of the help) of each command."""
    for module in pkgutil.iter_modules(commands.__path__):
        text = Path(module.module_finder.path, f"{module.name}.py").read_text(encoding="utf-8")  # type: ignore[union-attr]
        for node in ast.parse(text).body:
            match node:
                case ast.FunctionDef(
                    decorator_list=[ast.Call(func=ast.Name("command"), args=[ast.Constant(str(group)), *_])]
                ):
                    first, _, _ = (ast.get_docstring(node) or "").partition("\n\n")
                    yield module.name.replace("_", "-"), group, " ".join(first.split())


def overview() -> str:
    """The help of the command line: its commands in groups, on one screen."""
    lines, entries = ["Usage: vibrocap COMMAND", "", ABOUT, ""], list(summaries())
    for group in GROUPS:
        own = [(name, summary) for name, its_group, summary in entries if its_group == group]
        heads = [group, *[""] * len(own)]
        lines += [f"{head:<8}{name:<13}{summary}" for head, (name, summary) in zip(heads, own, strict=False)]
    return "\n".join([*lines, "", BEGIN])
