"""What a kernel gathers over the window of a run: names and sizes, in the order in which they stand in a result."""

from typing import TYPE_CHECKING

from vibrocap.numerics.expressions.traits import Traits
from vibrocap.numerics.kernel.codes import MODE_PLACES

if TYPE_CHECKING:
    from vibrocap.numerics.codegen.source import Integrands


def gathered_entries(
    has: Traits, integrands: "Integrands", machine_switches: int = 0, watched: int = 0, returns: bool = False
) -> tuple[tuple[str, int], ...]:
    """Names and sizes of what is gathered over the window of a run; the names are constants of the linked kernel.

    machine_switches: guards of the machine; watched: true loads that are looked at, of those that are held constant
    returns: whether these tell that a motion has settled
    """
    states, contacts = has.states, has.contacts
    return (
        ("INTEGRAL", integrands.summed),
        ("MAGNITUDE", contacts),  # integral of |R|
        ("PEAK", contacts + integrands.own_extremes),  # largest |R| of each contact, then own ones
        ("LARGEST", states),
        ("LEAST", states),
        ("STICK_TIME", contacts),
        ("STICK_PHASES", contacts),
        ("PHASE_SIDE", contacts),  # of the present phase of the window
        ("PHASE_LENGTH", contacts),
        ("LETTER_SIDE", contacts),  # of the present phase of the last period
        ("LETTER_LENGTH", contacts),
        ("LETTER_COUNT", contacts),
        ("LETTERS", contacts * MODE_PLACES),
        ("ASYMMETRY", 1),
        ("DEFECT", 1),  # evidence, see `observe/evidence.py`
        ("STICKING_SHARE", 1),
        ("LEAST_VELOCITY", 1),
        *((("OCCURRED", machine_switches),) if machine_switches else ()),  # how often each of them fell to zero
        *((("LIFTED", watched),) if watched else ()),  # 1 once a true load has been below zero
        # returns of the whole run; length of the window of a cycle, 0: of none; time from which on it was settled
        *((("RETURNS", 1), ("CYCLE_TIME", 1), ("SETTLED_TIME", 1)) if returns else ()),
    )
