"""`vibrocap machines`: which machines there are, and what one is: its words, parameters and equations of motion."""

import inspect
from pathlib import Path
from typing import Any

from rich.table import Table

from vibrocap.arguments import suggestion
from vibrocap.citations.bibliography import references
from vibrocap.cli.options import Refusal
from vibrocap.cli.terminal import OK, Page
from vibrocap.io.json_text import json_text
from vibrocap.io.motion_file import read_source


def machines(name: str | None = None, /, *, latex: bool = False, json: bool = False) -> int:
    """The machines, a line each; of one: what it is, its parameters, its source, and its equations of motion.

    The equations are derived from its description: a prime is a rate, R friction, N a load, H the energy, d a motion
    that the drive imposes, s a stop that is touched (1 in front, -1 behind, 0 not).

    Parameters
    ----------
    name
        a machine, or a case file (.toml) with the machine and the values of its words, such as normal_load = "dynamic"
    latex
        print its equations alone, as LaTeX
    json
        print one JSON object
    """
    from vibrocap.physics import catalogue
    from vibrocap.physics.equations import equations_of
    from vibrocap.physics.machines.described import Described
    from vibrocap.physics.parameters import parameter_table
    from vibrocap.physics.symbols import printed

    page = Page()
    if name is None:
        known = {each: _first_line(kind) for each, kind in catalogue.machines().items()}
        if json:
            page.say(json_text({"machines": known}))
            return OK
        width = max(map(len, known)) + 2
        for each, words in known.items():
            page.say(f"{each:<{width}}{words}")
        page.say("\nNext: vibrocap machines pendulum-capsule")
        return OK
    machine = _machine(name, catalogue.machines())
    equations = equations_of(machine, "latex" if latex else "text") if isinstance(machine, Described) else None
    lines = [] if equations is None else [*equations.lines]
    if json:
        page.say(json_text({"machine": machine.name, "equations": lines}))
        return OK
    if latex:
        print("\n".join(lines))
        return OK
    page.say(inspect.cleandoc(type(machine).__doc__ or machine.name))
    table = Table(box=None, pad_edge=False)
    for title in ("parameter", "symbol", "value", "meaning"):
        table.add_column(title, justify="right" if title == "value" else "left")
    for info in parameter_table(machine):
        value = getattr(machine, info.name)
        shown = f"{value:g}" if isinstance(value, float) else "none" if value is None else str(value)
        table.add_row(info.name, printed(info.symbol), shown, info.meaning)
    page.print()
    page.print(table)
    page.say("\nEquations of motion, derived from its description:\n")
    page.say("\n".join(f"    {line}" for line in lines or ["none: it is not described by its parts"]))
    said = [each.text for each in references(type(machine).source, machine.name)] or ["not recorded"]
    page.say("\nsource     " + "\n           ".join(said))
    return OK


def _first_line(kind: type) -> str:
    return inspect.cleandoc(kind.__doc__ or "").partition("\n")[0]


def _machine(name: str, known: Any) -> Any:
    """The machine of a name, with its defaults, or that of a case."""
    if name.endswith(".toml"):
        return read_source(Path(name)).system.machine
    if name not in known:
        raise Refusal(f"NAME: there is no machine {name!r}; {suggestion(name, known)}")
    return known[name]()
