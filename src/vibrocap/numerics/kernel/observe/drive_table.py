"""The table of a drive with corners, written by the kernel itself, where whoever runs it knows no Python."""

from vibrocap.numerics.kernel.generated.equations import drive_table
from vibrocap.numerics.kernel.generated.places import WORK
from vibrocap.numerics.kernel.generated.sizes import COEFFICIENTS, STATES, TABLE_NUMBERS
from vibrocap.numerics.kernel.lane import shared


def write_table(floats, ints, trace, period, place):
    """Write SEGMENT_COUNT rows to the trace: the share of the period at the end of each segment, its coefficients.

    The parts of the period are equal, as many as there are rows for them, and no rounding adds up at their ends. See
    `numerics/expressions/corners.py`.
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
