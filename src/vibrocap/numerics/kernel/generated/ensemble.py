"""Places of an ensemble only: its queue of runs, windows and settling, see `memory_layout.py`."""

RUN = NEXT_RUN = LAST_RUN = MORE = RESULT_START = ASKED = STEP_LIMIT = PERIOD_BUDGET = WINDOW = WINDOW_START = 0
RESPONSE = SINCE = STEP = DELAY = INVERSE_SCALE = THRESHOLD = REMAINING = START_STATE = MEASURED = MARKS = 0
