"""What a page can measure of many motions: how each measure is read from a result of the kernel."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.lab.controls import exponents
from vibrocap.lab.written import Ways, Written, chosen, text_of
from vibrocap.measures.during_run import asked_groups, measure_table, resolved, values
from vibrocap.measures.gathered import Gathered
from vibrocap.measures.measure import Measure, Reduction, Standard, own_integrands
from vibrocap.measures.recorded.settling import MIRROR_SHARE
from vibrocap.motion.recording.equations import equations
from vibrocap.numerics.api import BrowserKernel, Integrands, RunResults, codes
from vibrocap.physics.parameters import dimension_of_unit
from vibrocap.physics.system import System

ASKED = codes.ASK_SYMMETRY | codes.ASK_MODES  # of a motion on show: what the readouts say


def gathered_functions(system: System) -> Integrands | None:
    """The functions of the instant of all measures of a system that need some of their own; None where none does.

    One kernel has them all: it gathers them where works or peaks are asked for.
    """
    return own_integrands(_reductions(system), equations(system))


def _reductions(system: System) -> tuple[Measure, ...]:
    _, needed = resolved(list(measure_table(system)), system)
    return tuple(measure for measure in needed if isinstance(measure.how, Reduction))


def measure_records(system: System, kernel: BrowserKernel) -> list[dict[str, Any]]:
    """The measures of a system that are numbers: name, meaning, groups that have to be gathered, and how to read it.

    si: the SI unit of one that has one, and its exponents of mass, length and time

    read: an expression in JavaScript of the result r of the kernel, the drive period T, the threshold of settling h and
    of whether the system has the half-period symmetry, m. It is what the measure itself does, written down; a measure
    that this system does not have is left out.
    """
    records = []
    for name, measure in measure_table(system).items():
        _, needed = resolved(name, system)
        if any(isinstance(part.how, Standard) and part.how.text for part in needed):
            continue
        read = _read(system, kernel, needed, name)
        if read != "NaN":
            si = None if measure.si_unit == "1" else [measure.si_unit, exponents(dimension_of_unit(measure.si_unit))]
            record = {"name": name, "meaning": measure.meaning, "asked": asked_groups(needed), "read": read}
            records.append(record if si is None else record | {"si": si})
    return records


def _read(system: System, kernel: BrowserKernel, needed: Sequence[Measure], name: str) -> str:
    ways, layout = Ways(), kernel.layout
    own = _reductions(system)  # whose numbers stand in the order of the kernel
    ordered = (*own, *(measure for measure in needed if measure not in own))
    numbers = np.array([[Written(1.0, f"r[{i}]", ways) for i in range(layout.result_size)]], dtype=object)
    period = np.array([Written(1.0, "T", ways)], dtype=object)
    threshold: Any = np.array([Written(1.0, "h", ways)], dtype=object)  # a number alone would lose its text

    def asked() -> Any:
        mirrored = np.array([ways.answer("m")])
        gathered = Gathered(system, RunResults(layout, numbers), period, lambda: mirrored, threshold)
        return values(ordered, gathered)[name][0]

    ends = ways.through(asked)
    return chosen([(condition, text_of(value if isinstance(value, float) else math.nan)) for condition, value in ends])


def result_record(system: System, kernel: BrowserKernel) -> dict[str, Any]:
    """Where the rest of a result stands: its head by name, the mode sequences of contacts, its distance from its mirror
    image."""
    layout = kernel.layout
    letters, counts = (layout.gathered_slice(name).start for name in ("LETTERS", "LETTER_COUNT"))
    places = [(letters + k * codes.MODE_PLACES, counts + k) for k in range(len(system.laws))]
    return {
        "head": kernel.result_head,
        "letters": [None if law.kind == "smooth" else at for law, at in zip(system.laws, places, strict=True)],
        "letter_places": [codes.MODE_PLACES, codes.LETTERS_PER_PLACE],
        "asymmetry": layout.gathered_slice("ASYMMETRY").start,
        "mirrored": MIRROR_SHARE,
        "asked": ASKED,
    }
