"""What a page can measure of many motions: where each number stands in a result, and what it is divided by."""

from typing import Any

from vibrocap.measures.during_run import asked_groups, measure_table
from vibrocap.measures.response import MIRRORED
from vibrocap.numerics.api import BrowserKernel, codes
from vibrocap.physics.system import System

ASKED = codes.ASK_EXTREMES | codes.ASK_INTEGRALS | codes.ASK_PEAK | codes.ASK_SYMMETRY | codes.ASK_WORD


def measure_records(system: System, kernel: BrowserKernel) -> list[dict[str, Any]]:
    """The measures of a system: name, meaning, and how the number is read from a result of the kernel.

    take: places whose numbers are added with the signs beside them; over: "periods" or "time" of the window, or "";
    asked: groups of measures that have to be gathered for it
    """
    layout = kernel.layout
    first = layout.start_place
    cyclic, sticks = system.machine.cyclic, system.friction.kind == "set-valued"
    found: dict[str, tuple[list[list[int]], str]] = {}
    if cyclic is not None:
        at = first + system.state_names.index(cyclic)
        travel = [[at + layout.states, 1], [at, -1]]
        found |= {"mean_velocity": (travel, "time"), "drift": (travel, "periods")}
    found["response_period"] = [[kernel.result_head["response_period"], 1]], ""
    if sticks:
        found["stick_fraction"] = [[layout.gathered_slice("STICK_TIME").start, 1]], "time"
    channels = layout.gathered_slice("INTEGRAL").start
    for i, channel in enumerate(system.channels):
        found[f"{channel}_work"] = [[channels + i, 1]], "periods"
    found["peak_friction"] = [[layout.gathered_slice("PEAK").start, 1]], ""
    for i, state in enumerate(system.state_names):
        if state != cyclic and state not in system.friction.switched:
            found[f"largest_{state}"] = [[layout.gathered_slice("LARGEST").start + i, 1]], ""
    table = measure_table(system)
    return [
        {
            "name": name,
            "meaning": table[name].meaning,
            "take": take,
            "over": over,
            "asked": asked_groups([table[name]]),
        }
        for name, (take, over) in found.items()
        if name in table
    ]


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
