"""A case as a library in C99: sources that compute its motion with the exact contact, and a program that prints it.

The library allocates nothing and has no global state: one flat struct holds a motion and is copied by assignment.
It gives the bits of the package's kernel without fused operations, whatever the compiler and its optimisation.
"""

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from vibrocap.arguments import ArgumentError, shown
from vibrocap.case.case import Case
from vibrocap.exchange.c_templates import HEADER, INTERFACE, MAIN, README
from vibrocap.files import made_folder, write_text
from vibrocap.motion.equations import equations, parameter_values
from vibrocap.motion.simulate import STATUSES, event_kinds
from vibrocap.motion.start import initial_state
from vibrocap.numerics.api import ExportedMotion, codes, exported_motion

NAME = re.compile(r"[a-z][a-z0-9_]{0,30}")


def c_files(case: Case, name: str = "capsule") -> dict[str, str]:
    """The sources of a case, by file name: NAME.h, NAME.c, main.c and README.txt. Times and states are dimensionless.

    name: of the library, with which all its names begin: lower-case letters, digits and underscores
    Raises ArgumentError for another name.
    """
    checked_name(name)
    system, run = case.system, case.run
    initial = [*initial_state(system, case.initial).values()]
    given = equations(system), parameter_values(system), initial, system.drive.period
    motion = exported_motion(*given, **run, prefix=name)
    words = _words(case, motion, name)
    return {
        f"{name}.h": _filled(HEADER, words),
        f"{name}.c": f'#include "{name}.h"\n\n{motion.text}\n{_filled(INTERFACE, words)}',
        "main.c": _filled(MAIN, words),
        "README.txt": _filled(README, words),
    }


def checked_name(name: str) -> str:
    """A name with which others may begin in C; ArgumentError for another."""
    if not isinstance(name, str) or not NAME.fullmatch(name):
        wanted = "should be up to 31 lower-case letters, digits and underscores that begin with a letter"
        raise ArgumentError("name", f"{wanted}, got {shown(name)}")
    return name


def export_c(case: Case, folder: str | Path, name: str = "capsule") -> list[Path]:
    """Write the sources of a case into a folder, made where it is missing; the paths. See `c_files`.

    Raises WriteError where the folder cannot be written.
    """
    files = c_files(case, name)
    place = made_folder(folder)
    return [write_text(place / each, text) for each, text in files.items()]


def _words(case: Case, motion: ExportedMotion, name: str) -> dict[str, str]:
    """What stands in the places of the templates."""
    system, layout = case.system, motion.layout
    kinds = event_kinds(system.placed.switch_events)
    statuses = {codes.RUNNING: "running", codes.TRACE_FULL: "trace full"}
    statuses |= {code: status.value for code, status in STATUSES.items()}
    constants = motion.constants
    return {
        "name": name,
        "NAME": name.upper(),
        "floats": str(motion.floats.size),
        "ints": str(motion.ints.size),
        "trace": str(motion.trace.size),
        "kilobytes": str(round(8 * (motion.floats.size + motion.ints.size + motion.trace.size) / 1000)),
        "rows": str(layout.rows),
        "states": ", ".join(f'"{each}"' for each in system.state_names),
        "kinds": ", ".join(f'"{each}"' for each in kinds),
        "kind_count": str(len(kinds)),
        "statuses": "\n".join(f'    case {code}: return "{text}";' for code, text in statuses.items()),
        "set_floats": _settings("floats", motion.floats),
        "set_ints": _settings("ints", motion.ints),
        "set_trace": _settings("trace", motion.trace),
        **{each: str(value) for each, value in constants.items()},
    }


def _settings(array: str, values: np.ndarray) -> str:
    """Statements that set what is not zero."""
    from_numbers = ((int(i), values[i].item()) for i in np.flatnonzero(values))
    return "\n".join(f"  c->{array}[{i}] = {_number(value)};" for i, value in from_numbers)


def _number(value: float | int) -> str:
    if isinstance(value, int):
        return f"INT64_C({value})" if value >= 0 else f"-INT64_C({-value})"
    return "INFINITY" if np.isposinf(value) else value.hex()


def _filled(template: str, words: Mapping[str, str]) -> str:
    """A template with its @places@ filled."""
    return re.sub(r"@(\w+)@", lambda found: words[found[1]], template)
