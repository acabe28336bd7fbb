"""One instant of a motion alone: its states in the work space, and what follows from them.

And the table of a drive with corners, written by the kernel itself, where whoever runs it knows no Python.
"""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import alone, shared

INSTANT = WORK
OBSERVED = INSTANT + STATES


def take_sizes(floats):
    """Write the natural sizes of the states to where the run looks for them; the period of the drive.

    They follow from the parameters and the states in memory. Behind the instant stand room, sizes and period.
    """
    for i in range(STATES):
        floats[INSTANT + i] = alone.state[i]
    beginning(floats, 0.0, INSTANT, 0, OBSERVED)
    for i in range(STATES):
        alone.scale[i] = floats[OBSERVED + ROOM + i]
    return floats[OBSERVED + ROOM + STATES]


def write_observed(floats, ints, trace, s, out):
    """Write the states of the instant, at time s of the series, and the observables there to the trace from `out` on.

    What depends on the law's forces is asked at a state consistent with the slopes, see `linear_system.py`.
    """
    for i in range(STATES):
        trace[out + i] = floats[INSTANT + i]
    hook.consistent_state(floats, ints, 0, s, INSTANT)
    observables(floats, alone.time + s, INSTANT, 0, OBSERVED)
    for i in range(OBSERVABLES):
        trace[out + STATES + i] = floats[OBSERVED + i]


def write_table(floats, ints, trace, period, place):
    """Write SEGMENT_COUNT rows to the trace: the share of the period at the end of each segment, its coefficients.

    The parts of the period are equal, as many as there are rows for them, and no rounding adds up at their ends. See
    `numerics/expressions/equations.py`.
    """
    if TABLE_NUMBERS > 0:
        width, out = COEFFICIENTS + 1, WORK + STATES
        rows = TABLE_NUMBERS // width
        parts = shared.segment_count // rows
        for k in range(parts):
            drive_table(floats, k * (period / parts), WORK, 0, out)
            share = 0.0
            for i in range(rows):
                row = place + (k * rows + i) * width
                share += floats[out + i * width]
                trace[row] = (k + 1) / parts if i == rows - 1 else k / parts + share
                for j in range(COEFFICIENTS):
                    trace[row + 1 + j] = floats[out + i * width + 1 + j]
