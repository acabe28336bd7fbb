"""Places of entries (`lane.py`) where a text needs the place itself, of work rows, and among what is integrated."""

BACKUP = INT_COUNT = KEPT = LETTERS = MARKS = PEAK = PERIOD_BUDGET = RETURN_MARKS = 0
RUN = SERIES = SHOWN = STATUS = WAITING = WORK = 0
GUARD = 0  # a work row of the event search
SHIFT = 0  # what all velocities are ahead of the state that they share, see `shifts`
SHIFTS = 0  # how many these are
FRICTION = 0  # of R among the functions of the instant that are gathered
