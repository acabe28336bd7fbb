"""A case as a library in C99: sources that move its motion on, with the exact contact, and a program that prints it.

The library allocates nothing and has no global state: one flat struct holds a motion and is copied by assignment.
It gives the bits of the package's kernel without fused operations, whatever the compiler and its optimisation.
"""

import hashlib
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from vibrocap.arguments import ArgumentError, shown
from vibrocap.case.case import Case
from vibrocap.exchange import c_templates as templates
from vibrocap.exchange.stepped_case import REFUSED, Input, Port, SteppedCase
from vibrocap.files import made_folder, write_text

NAME = re.compile(r"[a-z][a-z0-9_]{0,30}")
SAMPLES = 64  # lines of main.c in each period of the drive
AN_INPUT = """The drive is an input: @name@_set_input says what it is from then on; until then it is 0. Where it jumps,
   a contact that is at rest is asked again whether it stays there."""


def c_files(case: Case, name: str = "capsule", input: Input = None) -> dict[str, str]:
    """The sources of a case, by file name: NAME.h, NAME.c, main.c and README.txt; numbers are in SI if the case is.

    name: of the library, with which all its names begin: lower-case letters, digits and underscores
    input: "drive", if the drive is set by the caller; None: it is that of the case
    Raises ArgumentError for another name or input.
    """
    checked_name(name)
    stepped = SteppedCase(case, input)
    text = stepped.kernel.c_text(f"{name}_kernel")
    words = _words(stepped, text, name)
    return {
        f"{name}.c": f'#include "{name}.h"\n\n{text}\n{_filled(templates.INTERFACE, words)}',
        f"{name}.h": _filled(templates.HEADER, words),
        "main.c": _filled(templates.MAIN if input is None else templates.INPUT_MAIN, words),
        "README.txt": _filled(templates.README, words),
    }


def checked_name(name: str) -> str:
    """A name with which others may begin in C; ArgumentError for another."""
    if not isinstance(name, str) or not NAME.fullmatch(name):
        wanted = "should be up to 31 lower-case letters, digits and underscores that begin with a letter"
        raise ArgumentError("name", f"{wanted}, got {shown(name)}")
    return name


def export_c(case: Case, folder: str | Path, name: str = "capsule", input: Input = None) -> list[Path]:
    """Write the sources of a case into a folder, made where it is missing; the paths. See `c_files`.

    Raises WriteError where the folder cannot be written.
    """
    files = c_files(case, name, input)
    place = made_folder(folder)
    return [write_text(place / name, text) for name, text in files.items()]


def _words(stepped: SteppedCase, text: str, name: str) -> dict[str, str]:
    """Contents of the places of the templates."""
    kernel, memory = stepped.kernel, stepped.memory()
    sizes = {"floats": memory.floats.size, "ints": memory.ints.size, "trace": memory.trace.size}
    codes = _first_codes(stepped)
    firsts = {code: text_of for code, text_of in stepped.statuses.items() if codes[code] == code}
    same = {code: first for code, first in codes.items() if first != code}
    statuses = {code: text_of.upper().replace(" ", "_") for code, text_of in firsts.items() if code > REFUSED}
    defines = [f"#define {name.upper()}_{text_of} {code}" for code, text_of in statuses.items()]
    held, in_si = stepped.input is not None, stepped.system.units is not None
    words = {name: str(place) for name, place in (kernel.places | sizes).items()}
    return words | {
        "name": name,
        "NAME": name.upper(),
        "drive_said": AN_INPUT if held else "The drive is that of the case.",
        "units_said": "All numbers are in SI, in the units that the tables of quantities tell."
        if in_si
        else "All numbers are dimensionless, as in the case.",
        "kilobytes": f"{8 * sum(sizes.values()) / 1000:.1f}",
        "states": str(len(stepped.states)),
        "observables": str(len(stepped.observables)),
        "parameters": str(len(stepped.parameters)),
        "contacts": str(stepped.contacts),
        "inputs": str(len(stepped.inputs)),
        "event_kinds": str(len(stepped.event_kinds)),
        "contact_kinds": str(stepped.contact_kinds),
        "counts": str(kernel.layout.counts),
        "same_statuses": "".join(f"    case {code}: return {other};\n" for code, other in same.items()),
        "status_defines": "\n".join(defines),
        "statuses": "\n".join(f'    case {code}: return "{text_of}";' for code, text_of in firsts.items()),
        "event_names": ", ".join(f'"{event_kind}"' for event_kind in stepped.event_kinds),
        "time_infos": _infos([stepped.time]),
        "input_infos": _infos(stepped.inputs),
        "parameter_infos": _infos(stepped.parameters),
        "state_infos": _infos(stepped.states),
        "observable_infos": _infos(stepped.observables),
        "parameter_places": ", ".join(str(parameter.place) for parameter in stepped.parameters) or "0",
        "set_floats": _settings("floats", memory.floats),
        "set_ints": _settings("ints", memory.ints),
        "input_declared": templates.INPUT_DECLARED if held else "",
        "input_defined": templates.INPUT_DEFINED if held else "",
        "identity": ", ".join(str(byte) for byte in hashlib.sha256(text.encode()).digest()[:8]),
        "samples": str(SAMPLES),
        "lines": str(math.floor(SAMPLES * stepped.case.periods + 0.5)),
        "period": number(stepped.case.system.drive.period * stepped.time.scale),
        "run": "< inputs.txt > motion.csv" if held else "> motion.csv",
    }


def _first_codes(stepped: SteppedCase) -> dict[int, int]:
    """Each status of the kernel, and the first that says the same."""
    firsts: dict[str, int] = {}
    return {code: firsts.setdefault(text, code) for code, text in stepped.statuses.items()}


def _infos(ports: Sequence[Port]) -> str:
    """Initialisers of quantities; C has no empty arrays."""
    numbers = (", ".join(map(number, (port.scale, port.in_unit, *port.bounds))) for port in ports)
    rows = (f'\n    {{"{port.name}", "{port.unit}", {row}}}' for port, row in zip(ports, numbers, strict=True))
    return ",".join(rows) or '{"", "", 0.0, 0.0, 0.0, 0.0}'


def _settings(array: str, values: np.ndarray) -> str:
    return "\n".join(f"  c->{array}[{i}] = {number(values[i].item())};" for i in np.flatnonzero(values).tolist())


def number(value: float | int) -> str:
    """A number of C, to the last bit."""
    if isinstance(value, int):
        return f"INT64_C({value})" if value >= 0 else f"-INT64_C({-value})"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return value.hex()


def _filled(template: str, words: Mapping[str, str]) -> str:
    """A template with its @places@ filled, which may hold places themselves."""
    while re.search(r"@\w+@", template):
        template = re.sub(r"@(\w+)@", lambda match: words[match[1]], template)
    return template
