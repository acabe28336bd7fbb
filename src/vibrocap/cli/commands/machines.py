"""`vibrocap machines`: which machines there are, and what one is: its words, parameters and equations of motion."""

import inspect
from pathlib import Path
from typing import Any

from vibrocap.arguments import suggestion
from vibrocap.citations.bibliography import references
from vibrocap.cli.options import Refusal
from vibrocap.cli.terminal import OK, Page, parameters_in_words
from vibrocap.io.motion_file import read_source
from vibrocap.quantities.json_text import json_text


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
    from vibrocap.physics.machines.machine import Machine

    page, known = Page(), catalogue.machines()
    if name is None:
        words = {each: inspect.cleandoc(kind.__doc__ or "").partition("\n")[0] for each, kind in known.items()}
        lines = [f"{each:<{max(map(len, words)) + 2}}{said}" for each, said in words.items()]
        told = [*lines, "\nNext: vibrocap machines pendulum-capsule"]
        page.say(json_text({"machines": words}) if json else "\n".join(told))
        return OK
    machine = _machine(name, known)
    own = equations_of(machine, "latex" if latex else "text").lines if isinstance(machine, Machine) else ()
    if json or latex:
        print(json_text({"machine": machine.name, "equations": list(own)}) if json else "\n".join(own))
        return OK
    page.say(inspect.cleandoc(type(machine).__doc__ or machine.name) + "\n")
    page.print(parameters_in_words(machine))
    page.say("\nEquations of motion, derived from its description:\n")
    page.say("\n".join(f"    {line}" for line in own or ["none: it is not described by its parts"]))
    said = [each.text for each in references(type(machine).source, machine.name)] or ["not recorded"]
    page.say("\nsource     " + "\n           ".join(said))
    return OK


def _machine(name: str, known: Any) -> Any:
    """The machine of a name, with its defaults, or that of a case."""
    if name.endswith(".toml"):
        return read_source(Path(name)).system.machine
    if name not in known:
        raise Refusal(f"NAME: there is no machine {name!r}; {suggestion(name, known)}")
    return known[name]()
