"""Places of a stepper only, see `memory_layout.py`."""

# what it is asked, and how far it has come
LENGTH = BEGUN = STEPS_PER_CALL = STOPPING = STOPPED = NOTICED = ENDED = INPUT = NEW_INPUT = CLOCK = CLOCK_REST = 0

# the step within which its clock stands
PIECE_CLOCK = PIECE_TIME = PIECE_LENGTH = PIECE_SEGMENT = PIECE_STIFF = SHOWN_SIDE = 0

# events: counted, the last one, those later than the clock and how many there can be
COUNTED = LAST_KIND = LAST_CONTACT = LAST_TIME = 0
WAITING_EVENTS = WAITING_KIND = WAITING_CONTACT = WAITING_TIME = WAITING = 0

# its trace: what it shows, and a backup of what it carries, of which so many are ints
SHOWN = BACKUP = INT_COUNT = 0
