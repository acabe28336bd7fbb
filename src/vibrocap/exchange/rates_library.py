"""A case in C99 as rates, guards and decisions, for firmware and integrators that are not ours.

It takes some hundred bytes of a motion where a stepper takes thousands, and leaves integration and location of events
to whoever calls it, and so the error.
"""

from importlib.resources import files as own_files
from pathlib import Path

import numpy as np

from vibrocap.case.case import Case
from vibrocap.exchange import c_library as library
from vibrocap.exchange import rates_templates as templates
from vibrocap.exchange.rates import Rates
from vibrocap.exchange.stepped_case import Input, SteppedCase
from vibrocap.files import made_folder, write_text
from vibrocap.physics.drives.drive import Drive

AN_INPUT = "The drive is an input: @name@_set_input says what it is from then on; until then it is 0."


def rates_files(case: Case, name: str = "capsule", input: Input = None) -> dict[str, str]:
    """The sources of a case, by file name: NAME.h, NAME.c, main.c (an integrator) and README.txt, as of `c_files`.

    Raises ArgumentError for another name or input, and for cases that have no such form: see `Rates`.
    """
    library.checked_name(name)
    rates = Rates(SteppedCase(case, input), name, "to", "export it as a stepper, --to c")
    words = _words(rates)
    text = f'#include "{name}.h"\n\n#include <string.h>\n\n{rates.instant.text}\n{templates.INTERFACE}'
    return {
        f"{name}.c": library.filled(text, words),
        f"{name}.h": library.filled(templates.HEADER, words),
        "main.c": library.filled(templates.MAIN, words),
        "README.txt": library.filled(templates.README, words),
    }


def export_rates(case: Case, folder: str | Path, name: str = "capsule", input: Input = None) -> list[Path]:
    """Write the sources of a case into a folder, made where it is missing; the paths. See `rates_files`.

    Raises WriteError where the folder cannot be written.
    """
    files = rates_files(case, name, input)
    place = made_folder(folder)
    return [write_text(place / each, text) for each, text in files.items()]


def _words(rates: Rates) -> dict[str, str]:
    """What stands in the places of the templates."""
    stepped, constants = rates.stepped, rates.constants
    held = stepped.input is not None
    shared = own_files("vibrocap.exchange.fmu") / "c" / "rates.h"
    return library.common_words(stepped, rates.name) | {
        "drive_said": AN_INPUT if held else library.OWN_DRIVE,
        "guards": str(rates.guards),
        "inputs": "1" if held else "0",
        "event_kinds": str(len(rates.counted)),
        "event_names": ", ".join(f'"{each}"' for each in rates.counted),
        "values": str(constants["VALUES"]),
        "counts": str(constants["COUNTS"]),
        "bytes": str(8 * (constants["VALUES"] + 1 + constants["COUNTS"])),
        "constants": "\n".join(f"#define {each} {place}" for each, place in constants.items()),
        "declarations": "\n".join(rates.lines),
        "rates": shared.read_text(encoding="utf-8"),
        "PARAMETER": "PARAMETER",
        "set_values": library.settings("values", np.array(rates.values)),
        "infinity": "HUGE_VAL",
        "input_declared": templates.INPUT_DECLARED if held else "",
        "input_defined": templates.INPUT_DEFINED if held else "",
        "input_first": templates.INPUT_FIRST if held else "",
        "input_set": templates.INPUT_SET if held else "",
        "size": library.number(_size(stepped.case.system.drive)),
        "of": templates.OF_INPUT if held else templates.OF_CASE,
    }


def _size(drive: Drive) -> float:
    """The largest absolute value of a drive, of 64 in a period."""
    return float(np.max(np.abs([drive.value(t) for t in np.linspace(0.0, drive.period, 64).tolist()])))
