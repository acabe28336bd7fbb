"""Parts of one's own on the command line: `--parts FILE`, which every command takes that knows parts by name."""

import functools
import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

from vibrocap.cli.options import Refusal

HELP = """
    parts
        a Python file with laws, machines or drives of your own, which is run; may be repeated
"""


def taking_parts(command: Callable[..., int]) -> Callable[..., int]:
    """The command with one more option, `--parts`: files of parts, which are loaded before anything else."""

    @functools.wraps(command)
    def run(*given: Any, parts: list[Path] | None = None, **options: Any) -> int:
        load(parts or ())
        return command(*given, **options)

    signature = inspect.signature(command)
    option = inspect.Parameter("parts", inspect.Parameter.KEYWORD_ONLY, default=None, annotation=list[Path] | None)
    run.__signature__ = signature.replace(parameters=[*signature.parameters.values(), option])  # type: ignore[attr-defined]
    run.__annotations__ = {**command.__annotations__, "parts": list[Path] | None}
    words = inspect.cleandoc(command.__doc__ or "")
    heading = "" if "\nParameters\n---" in words else "\n\nParameters\n----------"
    run.__doc__ = words + heading + "\n" + inspect.cleandoc(HELP) + "\n"
    return run


def load(files: "list[Path] | tuple[Path, ...]") -> tuple[type, ...]:
    """The parts of files, registered; Refusal, with every file that cannot be used."""
    from vibrocap.physics.part_files import PartsError, load_parts

    found: list[type] = []
    complaints = []
    for path in files:
        try:
            found += load_parts(path)
        except PartsError as error:
            complaints.append(f"--parts: {error}")
    if complaints:
        raise Refusal(*complaints)
    return tuple(found)
