"""Places of an ensemble only, see `memory_layout.py`."""

# its queue of runs, windows and settling
RUN = NEXT_RUN = LAST_RUN = MORE = RESULT_START = ASKED = STEP_LIMIT = PERIOD_BUDGET = WINDOW = WINDOW_START = 0
EVIDENCE_PERIODS = 0
EXTRAPOLATE = MODES = LAST_MODES = STEADY = STEADY_MARK = NEXT_TRIAL = ON_TRIAL = REFUSED_TRIALS = KEPT = 0
SLOW = SWEEPS = WAIT = PAUSE = OWN_DECAY = DRIFT = KICK = GUESS = 0  # of slow manifolds
RESPONSE = SINCE = STEP = EVENT_CONTACT = DELAY = INVERSE_SCALE = THRESHOLD = REMAINING = START_STATE = MEASURED = (
    MARKS
) = 0

# its returns
RETURN_COUNT = LEFT = QUIET_SINCE = BY_PLACE = PASSED = PASSED_AT = BEGUN_AT = SETTLED_AT = 0
RETURN_TIMES = RETURN_MARKS = 0

# what it gathers over the window of a run, see `gathered_entries.py`
INTEGRAL = MAGNITUDE = PEAK = LARGEST = LEAST = STICK_TIME = STICK_PHASES = PHASE_SIDE = PHASE_LENGTH = 0
LETTER_SIDE = LETTER_LENGTH = LETTER_COUNT = LETTERS = ASYMMETRY = 0
DEFECT = HOLD_SHARE = LEAST_VELOCITY = 0  # evidence that it is a motion of the equations
RETURNS = CYCLE_TIME = SETTLED_TIME = 0  # of its returns, and of the cycle that they make
LIFTED = 0  # whether the true load has been below zero
