"""Sizes of the memory, see `memory_layout.py`."""

from vibrocap.numerics.kernel.memory_layout import Layout

_EXAMPLE = Layout(states=4, order=12, parameters=10).constants()
LANES = _EXAMPLE["LANES"]
STATES = _EXAMPLE["STATES"]
ORDER = _EXAMPLE["ORDER"]
PIECE_SIZE = _EXAMPLE["PIECE_SIZE"]
RATE_ROWS = (1, -1, 3, -1)  # of each row the one that is its rate and tells its series, else -1
WHOLE_ROWS = (1, 3)  # rows of which a piece on the trace has all coefficients
WHOLE_COUNT = 2
EVENT_SIZE = _EXAMPLE["EVENT_SIZE"]
EVENT_WORK = _EXAMPLE["EVENT_WORK"]
PARAMETERS = _EXAMPLE["PARAMETERS"]
PRESENT = _EXAMPLE["PRESENT"]
COEFFICIENTS = _EXAMPLE["COEFFICIENTS"]
CONTACTS = _EXAMPLE["CONTACTS"]
MARK_COUNT = 1
MARK_SIZE = _EXAMPLE["MARK_SIZE"]
MEASURED_COUNT = _EXAMPLE["MEASURED_COUNT"]
RUN_SIZE = _EXAMPLE["RUN_SIZE"]
RESULT_SIZE = _EXAMPLE["RESULT_SIZE"]
BASE = 2  # states of the motion itself, where tangents follow them
INTEGRANDS = SUMMED = 0  # functions of the instant that an ensemble gathers, of which the first SUMMED are integrated
OBSERVABLES = 0  # functions of the instant that a page draws, see `observe/instants.py`
ROOM = 0  # bounds of states at the start, two for each state that has any
TABLE_NUMBERS = 0  # of the segments of a part of the drive's period: length and coefficients of each
