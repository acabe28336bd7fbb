"""The numbers by which a kernel says things: why a run ended, kinds of event, groups of measures, modes."""

# What a lane is doing, or why it stopped.
BEGINNING = -1  # what it begins with stands in memory, see `loop/one_step.py`
RUNNING = 0
DONE = 1
TRACE_FULL = 2
STEP_UNDERFLOW = 3
NOT_FINITE = 4
TOO_MANY_EVENTS = 5
UNDECIDED = 6
TOO_MANY_STEPS = 7
AMBIGUOUS_CONTACTS = 4  # number of that bound among those that there are, see `physics/system.py`
BEYOND_BOUND = 8  # the first of the equations' bounds; the next ones have the next numbers

# Kinds of event.
STICK = 0
SLIP_FORWARD = 1
SLIP_BACK = 2
REVERSAL = 3
GRAZE = 4
SWITCHED = 5  # the law goes over to another of its pieces
BOUND_REACHED = 6  # the first of the equations' bounds; the next ones have the next numbers
MACHINE_SWITCHED = 20  # at the first guard of the machine; the next ones have the next numbers
PLACE_PASSED = 9  # number of the place of returns among the events of a step
FIRST_SWITCH = 10  # number of the first guard of the pieces among the events of a step

# Groups of measures, powers of two: an ensemble gathers those that are asked for (ASKED).
ASK_INTEGRALS = 1  # works, impulse, areas of the friction loop, own integrals
ASK_MAGNITUDE = 2  # integral of |R|
ASK_PEAK = 4  # largest |R|, own extremes
ASK_EXTREMES = 8  # of the states
ASK_MODES = 16  # sticking, and the mode sequence of the last period
ASK_SYMMETRY = 32
ASK_TRANSIENT = 64  # how a run comes to its steady motion, for which it has to wait
FUNCTIONS_PER_CONTACT = 3  # gathered: R, its power, R times the acceleration
MODE_PLACES = 4  # numbers that hold a mode sequence
LETTERS_PER_PLACE = 26  # of two bits each

# What a kernel and readers of stored motions hold alike.
# Of the defect, over the tolerance: at most 500 in motions of all laws at tolerances from 1e-4 to 1e-14, from 1e3 to
# 1e5 where a law was stepped over.
DEFECT_BOUND = 1e3
LONGEST_PERIOD = 16  # a response of a longer period is not looked for
SLIVER = 1e-12  # of a period: what a window cuts off a phase by rounding is no phase
