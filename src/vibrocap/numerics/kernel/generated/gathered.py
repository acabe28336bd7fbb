"""Places of what an ensemble gathers over the window of a run, see `gathered_entries` in `memory_layout.py`."""

INTEGRAL = MAGNITUDE = PEAK = LARGEST = LEAST = STICK_TIME = STICK_PHASES = PHASE_SIDE = PHASE_LENGTH = 0
LETTER_SIDE = LETTER_LENGTH = LETTER_COUNT = LETTERS = ASYMMETRY = 0
LIFTED = 0  # whether the true load has been below zero
