"""Parts of one's own: `--parts FILE`, which every command takes that knows parts by name, and `vibrocap check`."""

import dataclasses
import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any

from vibrocap.arguments import suggestion
from vibrocap.cli.options import Refusal, also_taking
from vibrocap.cli.terminal import OK, WRONG_INPUT, Page, progress
from vibrocap.quantities.json_text import json_text

HELP = """
    parts
        a Python file with laws, machines, drives or controllers of your own, which is run; may be repeated
"""


def taking_parts(command: Callable[..., int]) -> Callable[..., int]:
    """The command with one more option, `--parts`: files of parts, which are loaded before anything else."""

    @functools.wraps(command)
    def run(*given: Any, parts: list[Path] | None = None, **options: Any) -> int:
        load(parts or ())
        return command(*given, **options)

    return also_taking(command, run, {"parts": (list[Path] | None, None)}, HELP)


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


def check(*names: str, quick: bool = False, json: bool = False) -> int:
    """Whether a law, a machine, a drive or a controller keeps its contract, and if not, what is wrong.

    The part is tested with its defaults and with other numbers: sampled, recorded, and simulated for some periods.

    Exit codes: 0 all keep their contracts, 2 one does not.

    Parameters
    ----------
    names
        laws, machines, drives or controllers by name [default: those of --parts]
    quick
        leave out the short motion, which compiles the equations
    json
        print one JSON object instead of the reports
    """
    from vibrocap.contracts.check_part import check_part

    parts = _parts(names)
    reports = []
    for part in parts:
        with progress(f"Checking {part.name}"):
            reports.append(check_part(part, motion=not quick))
    page = Page()
    if json:
        page.say(json_text({"parts": [dataclasses.asdict(each) | {"ok": each.ok} for each in reports]}))
    else:
        page.say("\n\n".join(map(str, reports)))
    return OK if all(each.ok for each in reports) else WRONG_INPUT


def _parts(names: tuple[str, ...]) -> list[Any]:
    """The parts of these names, or those of one's own; Refusal, with the nearest name, for what there is not."""
    from vibrocap.physics.catalogue import controllers, drives, laws, machines, registered

    if not names:
        if not registered():
            raise Refusal(
                "Name a law, a machine, a drive or a controller, such as lugre, or a file of yours: --parts mylaws.py."
            )
        return list(registered())
    catalogues = (laws(), machines(), drives(), controllers())
    known = [name for catalogue in catalogues for name in catalogue]
    complaints = [
        f"no law, machine, drive or controller is called {name!r}; {suggestion(name, known, cutoff=0.0)}"
        for name in names
        if not any(name in catalogue for catalogue in catalogues)
    ]
    if complaints:
        raise Refusal(*complaints)
    return [catalogue[name] for name in names for catalogue in catalogues if name in catalogue]
