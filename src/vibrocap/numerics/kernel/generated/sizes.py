"""Sizes of the memory, see `memory_layout.py`."""

LANES = CONTACTS = MARK_COUNT = 1
STATES, ORDER, PARAMETERS = 4, 12, 10
PIECE_SIZE = EVENT_SIZE = EVENT_WORK = PRESENT = COEFFICIENTS = MARK_SIZE = MEASURED_COUNT = RUN_SIZE = RESULT_SIZE = 0
RATE_ROWS = (1, -1, 3, -1)  # of each row the one that is its rate and tells its series, else -1
WHOLE_ROWS = (1, 3)  # rows of which a piece on the trace has all coefficients
WHOLE_COUNT = 2
BASE = 2  # states of the motion itself, where tangents follow them
INTEGRANDS = SUMMED = 0  # functions of the instant that an ensemble gathers, of which the first SUMMED are integrated
OBSERVABLES = 0  # functions of the instant that a page draws, see `observe/instants.py`
ROOM = 0  # bounds of states at the start, two for each state that has any
TABLE_NUMBERS = 0  # of the segments of a part of the drive's period: length and coefficients of each
