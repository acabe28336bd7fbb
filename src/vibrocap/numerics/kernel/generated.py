"""The contract of generated code: what `source.py` writes for one system and the kernel modules call by these names.

Linking (`link.py`) puts the generated definitions, and the places of `memory_layout.py`, in the place of these.
"""

from vibrocap.numerics.kernel.memory_layout import Layout

SET_VALUED = True  # whether the contact can stick
KINKED = False  # whether the law has a kink at rest
MAYBE_STIFF = False  # whether a contact has a law with a force for every velocity
SEVERAL = False  # whether there are several contacts
LIMIT_CONSTANT = True  # whether the largest holding force never changes along a motion
SHARP = True  # whether the law has functions that could hide within a step, see `resolution.py`
MIRRORED = True  # whether these are the same for either direction of sliding
VELOCITY_JUMPS = False  # whether the contact velocity jumps where the drive has a corner
FOLLOWS_LOAD = False  # whether the load of the contact follows the motion
SPARSE = False  # whether the law hides near rest: three terms in four of a series may vanish, or it has a logarithm
SHARP_INTERNAL = False  # whether any of them depends on an internal state
CYCLIC = 2  # the state on which nothing depends
CONTACT_STATE = 3  # the state that moves one to one with the contact velocity

_EXAMPLE = Layout(lanes=1, states=4, rows=9, order=12, parameters=10).constants()
LANES = _EXAMPLE["LANES"]
STATES = _EXAMPLE["STATES"]
ROWS = _EXAMPLE["ROWS"]
ORDER = _EXAMPLE["ORDER"]
PIECE_SIZE = _EXAMPLE["PIECE_SIZE"]
EVENT_SIZE = _EXAMPLE["EVENT_SIZE"]
EVENT_WORK = _EXAMPLE["EVENT_WORK"]
PARAMETERS = _EXAMPLE["PARAMETERS"]
PRESENT = _EXAMPLE["PRESENT"]
COEFFICIENTS = _EXAMPLE["COEFFICIENTS"]
MARK_COUNT = 1
MEASURED_COUNT = _EXAMPLE["MEASURED_COUNT"]
RUN_SIZE = _EXAMPLE["RUN_SIZE"]
RESULT_SIZE = _EXAMPLE["RESULT_SIZE"]
STATUS = PERIOD_COUNT = WHOLE_PERIODS = ARRIVING = ZEROS = STIFF = PATIENCE = TAYLOR_STEPS = IMPLICIT_STEPS = 0
EVENTS = EVENT_LIMIT = IDLE = PIECES = PIECE_LIMIT = RECORDED_EVENTS = RECORDED_EVENT_LIMIT = 0
PIECE_START = RECORDED_EVENT_START = 0
PERIOD_BUDGET = RUN = STEP_LIMIT = WINDOW = WINDOW_START = RESPONSE = SINCE = ASKED = RESULT_START = NEXT_RUN = (
    LAST_RUN
) = MORE = 0
SEGMENT = CYCLE = TABLE = SEGMENT_COUNT = TABLE_START = TABLE_STRIDE = UNTIL = 0
STEP = INVERSE_SCALE = THRESHOLD = REMAINING = START_STATE = MEASURED = MARKS = 0
INTEGRAL = MAGNITUDE = PEAK = LARGEST = LEAST = STICK_TIME = STICK_PHASES = PHASE_SIDE = PHASE_LENGTH = 0
LETTER_SIDE = LETTER_LENGTH = LETTER_COUNT = LETTERS = ASYMMETRY = 0
TIME = PERIOD = TAIL = SIDE = CAME_FROM = TOLERANCE = IMPLICIT_STEP = EXPLICIT_STEP = DAMPED_STEP = DECAY_RATE = 0
CONTACT_RESIDUAL = HOLD_RATE = SAFE_SPEED = UNSAFE_SPEED = FAR_SPEED = NEAR_SPEED = PENDING = DELAY = 0
STATE = PARAMETER = SCALE = SERIES = WORK = 0

# What is gathered by an ensemble: functions of the instant, of which the first SUMMED are integrated; FRICTION: the
# place of R among them; MIRROR: sign of each state under the half-period symmetry.
INTEGRANDS = SUMMED = FRICTION = 0
IMPACT = -1  # place among them of the channel that takes the energy lost in impacts; -1: there is none
MIRROR = (-1,)
WATCHED = False  # whether the true load of the contact is looked at, which friction takes as constant
REACTION = LIFTED = 0  # first coefficient of its series (to ORDER - 2); whether it has been below zero
OCCURRED = -1  # place of how often each guard of the machine fell to zero; -1: it is not counted
OBSERVABLES = 0  # functions of the instant that a page draws, see `observe/instants.py`
ROOM = 0  # bounds of states at the start, two for each state that has any
TABLE_NUMBERS = 0  # of the segments of a drive with corners: length and coefficients of each

# First coefficients of rows of the series: contact velocity, force that would hold the contact and largest holding
# force (both to ORDER - 1), a work row of the event search, and the guards of the law's pieces (to ORDER - 1).
VELOCITY = HOLD = LIMIT = GUARD = SWITCH = 0
IMPOSED = 0  # and of the velocities of further contacts that are no states (to ORDER)
IMPOSED_COUNT = 0  # how many these are
SHIFT = 0  # and of what all velocities are ahead of the state that they share, see `shifts`
SHIFTS = 0  # how many these are
SWITCHES = 1  # how many guards there are
LOCATED = (1,)  # of each guard: whether it is a series, whose zero is an event, or asked where a step starts
BRANCHES = 1  # how many of them belong to branches; behind them stand bounds at which a run ends
BOUND_KINDS = (0,)  # number of each bound among the kinds that there are
LAW_BRANCHES = 1  # how many of those are the law's, which stand before the machine's
TURNING = (-1,)  # of each guard under which a further contact turns: the state that moves as its velocity does; else -1
SIDES_AT_REST = (-1,)  # states that are 0 while a further contact sticks
STICKS = (0,)  # of each contact: 1 where it can stick
SIDES_COUNT = 0  # how many these are
BASE = 2  # states of the motion itself, where tangents follow them


def jet(floats):
    """Taylor coefficients of states, integrals, contact velocity and guards for all lanes, written to SERIES."""
    raise NotImplementedError


def guard_simd(floats, side, stuck, push, one, two, h) -> tuple:
    """Of all lanes at once (`plain_vectors.py`): the guard over a step of length h as a polynomial, written to WORK.

    The guard is side * velocity without its first coefficients that vanish (in the lanes `one` and `two`, so many), or,
    in the lanes `stuck`, limit - push * holding force.
    Returns (first coefficient, value at the end of the step, sign changes of the coefficients in the Bernstein basis).
    """
    raise NotImplementedError


def guard_at(floats, x) -> tuple:
    """(value, slope) of that polynomial at x, a number per lane from 0 to 1."""
    raise NotImplementedError


def unresolved(floats, lane, h, lasting, start_low, start_high, low, high, widened):
    """How many sharp functions of the law a step of length h might not see, see `resolution.py`.

    start_low, start_high: within which the contact velocity starts; low, high: within which it stays
    lasting: time over which what is not seen would act
    widened: natural sizes by which every other state may be off, in a proof that is to last
    """
    raise NotImplementedError


def unresolved_simd(floats, h, lasting, start_low, start_high, low, high):
    """`unresolved` of all lanes."""
    raise NotImplementedError


def rates(floats, t, point, side, lane, out):
    """y' of one lane at the state floats[point:point + STATES], written to floats[out:out + ROWS]."""
    raise NotImplementedError


def jacobian(floats, t, point, side, lane, out):
    """Partial derivatives of `rates` at the state floats[point:point + STATES].

    Written to floats[out + i * (STATES + 1) + j] for row i and state j; j = STATES: time.
    """
    raise NotImplementedError


def holding_force(floats, t, point, lane):
    """Force that would hold the contact of one lane, over the middle of what it can hold, at the state from `point` on.

    Only of laws that can stick.
    """
    raise NotImplementedError


def holding_limit(floats, t, point, lane):
    """How far the forces that the contact of one lane can hold reach from their middle, at a state."""
    raise NotImplementedError


def contact_velocity(floats, t, point, lane):
    """Contact velocity of one lane at the state floats[point:point + STATES]."""
    raise NotImplementedError


def reaction(floats, t, point, side, lane):
    """The true load of the contact at the state floats[point:point + STATES]; where it is watched."""
    raise NotImplementedError


def shifts(floats, t, lane, out):
    """Of each contact velocity at imposed distances what it is ahead of the state that all share.

    From `out` on, three numbers of each: that function of time, and its first two derivatives.
    """
    raise NotImplementedError


def machine_energy(floats, t, point, lane):
    """Kinetic and potential energy of the machine at the state floats[point:point + STATES]; of laws with branches."""
    raise NotImplementedError


def integrands(floats, t, point, side, lane, out):
    """The functions of which an ensemble gathers integrals and peaks, at the state floats[point:point + STATES].

    Written to floats[out:out + INTEGRANDS]: powers by channel, R, R times contact velocity, R once more, own functions
    to be integrated; then own functions of which the largest value is wanted.
    """
    raise NotImplementedError


def guard_tangents(floats, t, point, side, lane, out):
    """How the guards grow along the tangent: contact velocity, holding force, its limit, then those of the pieces.

    Only of equations with a tangent, see `tangents.py`.
    """
    raise NotImplementedError


def switches(floats, t, point, side, lane, out):
    """The guards of the branches at the state floats[point:point + STATES], written to floats[out:out + SWITCHES]."""
    raise NotImplementedError


def after_switch(floats, t, point, side, lane, which, out):
    """The states after guard `which` has fallen to zero, written to floats[out:out + STATES]."""
    raise NotImplementedError


def after_reversal(floats, t, point, side, lane, out):
    """The states after the contact has turned to the side, written to floats[out:out + STATES]."""
    raise NotImplementedError


def observables(floats, t, point, side, lane, out):
    """What a page draws besides the states, at floats[point:point + STATES]; to floats[out:out + OBSERVABLES]."""
    raise NotImplementedError


def beginning(floats, t, point, side, lane, out):
    """Room of the states, natural size of every state, period and contact velocity; ROOM + STATES + 2 numbers."""
    raise NotImplementedError


def drive_table(floats, t, point, side, lane, out):
    """Of each segment of a drive with corners its length and its coefficients; to floats[out:out + TABLE_NUMBERS]."""
    raise NotImplementedError
