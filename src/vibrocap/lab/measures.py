"""What a page can measure of many motions: how each measure is read from a result of the kernel."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.lab.written import Ways, Written, chosen, text_of
from vibrocap.measures.during_run import asked_groups, measure_table, resolved, values
from vibrocap.measures.gathered import Gathered
from vibrocap.measures.measure import Measure, Reduction, Standard
from vibrocap.measures.response import MIRRORED
from vibrocap.numerics.api import BrowserKernel, RunResults, codes
from vibrocap.physics.system import System

ASKED = codes.ASK_EXTREMES | codes.ASK_INTEGRALS | codes.ASK_PEAK | codes.ASK_SYMMETRY | codes.ASK_WORD


def measure_records(system: System, kernel: BrowserKernel) -> list[dict[str, Any]]:
    """The measures of a system that are numbers: name, meaning, groups that have to be gathered, and how to read it.

    read: an expression in JavaScript of the result r of the kernel, the drive period T, the threshold of settling h and
    of whether the system has the half-period symmetry, m. It is what the measure itself does, written down; a measure
    that this system does not have, or that needs a kernel of its own, is left out.
    """
    found, known = [], measure_table()
    for name, measure in measure_table(system).items():
        _, needed = resolved(name if name in known else measure)  # that of a further contact may be no common one
        if any(
            isinstance(each.how, Reduction) or (isinstance(each.how, Standard) and each.how.text) for each in needed
        ):
            continue
        read = _read(system, kernel, needed, name)
        if read != "NaN":
            found.append({"name": name, "meaning": measure.meaning, "asked": asked_groups(needed), "read": read})
    return found


def _read(system: System, kernel: BrowserKernel, needed: Sequence[Measure], name: str) -> str:
    ways = Ways()
    layout = kernel.layout

    def asked() -> Any:
        numbers = np.array([[Written(1.0, f"r[{i}]", ways) for i in range(layout.result_size)]], dtype=object)
        period = np.array([Written(1.0, "T", ways)], dtype=object)
        mirrored = np.array([ways.answer("m")])
        threshold: Any = np.array([Written(1.0, "h", ways)], dtype=object)  # a number alone would lose its text
        return values(needed, Gathered(system, RunResults(layout, numbers), period, mirrored, threshold))[name][0]

    ends = ways.through(asked)
    return chosen([(way, text_of(value if isinstance(value, float) else math.nan)) for way, value in ends])


def result_record(kernel: BrowserKernel) -> dict[str, Any]:
    """Where the rest of a result stands: its head by name, the word of its last period, how far it is from a mirror."""
    layout = kernel.layout
    letters = layout.gathered_slice("LETTERS")
    return {
        "head": kernel.result_head,
        "letters": [letters.start, letters.stop, codes.LETTERS_PER_PLACE],
        "letter_count": layout.gathered_slice("LETTER_COUNT").start,
        "asymmetry": layout.gathered_slice("ASYMMETRY").start,
        "mirrored": MIRRORED,
        "asked": ASKED,
    }
