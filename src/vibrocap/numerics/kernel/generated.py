"""The contract of generated code: what `codegen/source.py` writes for one system, under these names.

Linking puts the generated definitions, and the places of `memory_layout.py`, in the place of these. As all parts of a
kernel share one space of names, its modules import all of them. `floats` is the memory of all lanes.
"""

# What is known of the equations of one system: what these constants rule out is not compiled.
MAYBE_STIFF = False  # whether a contact has a law with a force for every velocity
SEVERAL = False  # whether there are several contacts
LIMIT_CONSTANT = True  # whether the largest holding force never changes along a motion
SHARP = True  # whether the law has functions that could hide within a step, see `resolution.py`
VELOCITY_JUMPS = False  # whether the contact velocity jumps where the drive has a corner
FOLLOWS_LOAD = False  # whether the load of the contact follows the motion
LACUNARY = False  # whether four terms hold a step from stick: a law has a whole power of the speed, or is not alone
ROUGH = (0,)  # of each contact: 1 where it can stick and its law has a power of the speed that is not whole
GAPS = False  # whether a law has a whole power of the speed from the third on, see `structure.py`
SHARP_INTERNAL = False  # whether any of them depends on an internal state, or on several contacts
SHARP_CONTACT = 0  # the contact on whose velocity they depend otherwise
WATCHED = 0  # true loads that are looked at, which friction takes as constant
CYCLIC = 2  # the state on which nothing depends
TURN_COUNT = 0  # coordinates that turn, on which everything depends with a period
TURN_STATES = (-1,)  # which states they are
TURN_RADII = (1.0,)  # their periods over 2 pi
RETURNING = False  # whether returns tell that a motion has settled
PLACE = 0  # the coordinate that is largest there, or has turned, where a motion returns that comes to rest nowhere
PLACE_TURN = 0.0  # its period, if it turns
MIRROR = (-1,)  # sign of each state under the half-period symmetry
STICKS = (1,)  # of each contact: 1 where it can stick
KINKS = (0,)  # of each contact: 1 where it has a force for every velocity, with a kink at rest
STATE_OF = (3,)  # of each contact: the state that moves one to one with its velocity
SHARED = False  # whether some share one state, as their distances are imposed
DYNAMIC = False  # whether the loads of several contacts follow the motion
GROUP = (0,)  # of each of several contacts: the first one of those that act on one another
SLOWED = False  # whether bristles of a contact may be on a slow manifold, see `step/slow_manifold.py`
MANIFOLDS = 1  # number of slow manifolds
SLOW_CONTACT = (0,)  # of each: number of its contact
PAIR = False  # whether they are those of two states of one contact of a motion alone, which may be slaved together
SLOW_STATE: tuple[int, ...] = (-1,)  # of each: the state that is slaved; -1: there is none

# The guards of the branches of law and machine: at a zero of one, the equations go over to another of their pieces.
SWITCHES = 1  # how many guards there are
LOCATED = (1,)  # of each guard: whether it is a series, whose zero is an event, or asked where a step starts
POLISHED = (0,)  # of each guard of a branch: whether its series may leave out what it is over the tolerance
BRANCHES = 1  # how many of them belong to branches; behind them stand bounds at which a run ends
BOUND_KINDS = (0,)  # number of each bound among the kinds that there are
LAW_BRANCHES = 1  # how many of those are the law's, which stand before the machine's
SWITCH = 0  # first coefficient of the series of the guards (of the machine's to ORDER, of others to ORDER - 1)
IMPACT = -1  # place among what is integrated of the energy lost in impacts; -1: there is none
OCCURRED = -1  # place of how often each guard of the machine fell to zero; -1: it is not counted

# Sizes of the memory, see `memory_layout.py`.
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

# Places of entries (`lane.py`) where a text needs the place itself, of work rows, and among what is integrated.
BACKUP = INT_COUNT = KEPT = LETTERS = MARKS = PEAK = PERIOD_BUDGET = RETURN_MARKS = 0
RUN = SERIES = SHOWN = STATUS = WAITING = WORK = 0
GUARD = 0  # a work row of the event search
SHIFT = 0  # what all velocities are ahead of the state that they share, see `shifts`
SHIFTS = 0  # how many these are
FRICTION = 0  # of R among the functions of the instant that are gathered

# Functions that are written for one system.


def jet(floats):
    """Taylor coefficients of states, contact velocity and guards for all lanes, written to SERIES."""
    raise NotImplementedError


def slow_jet(floats, lane) -> None:
    """The same of a motion alone on its slow manifold, or of the lanes that are on theirs, one sweep."""
    raise NotImplementedError


def guard_simd(floats, selected, contact, side, stuck, direction, one, two, h) -> None:
    """Of all lanes at once (`plain_vectors.py`): the guard over a step of length h as a polynomial, written to WORK.

    selected: the lanes in which it is written, where contacts are several
    The guard is side * velocity without its first coefficients that vanish (in the lanes `one` and `two`, so many), or,
    in the lanes `stuck`, limit - direction * sticking force.
    """
    raise NotImplementedError


def switch_simd(floats, row, one, h) -> None:
    """The same of the guard of a branch with its series at row; without its first coefficient in the lanes `one`."""
    raise NotImplementedError


def signs_simd(floats) -> tuple:
    """(first coefficient, value at the end of the step, sign changes of the coefficients in the Bernstein basis) of
    that polynomial."""
    raise NotImplementedError


def guard_at(floats, x) -> tuple:
    """(value, slope) of it at x, a number per lane from 0 to 1."""
    raise NotImplementedError


def unresolved(floats, lane, h, lasting, start_low, start_high, low, high, widened):
    """How many sharp functions of the law a step of length h might not see, of a lane or of all; see `resolution.py`.

    start_low, start_high: within which the contact velocity starts; low, high: within which it stays
    lasting: time over which what is not seen would act
    widened: natural sizes by which every other state may be off, in a proof that is to last
    """
    raise NotImplementedError


def rates(floats, t, point, lane, out):
    """y' of one lane at the state floats[point:point + STATES], written to floats[out:out + STATES]."""
    raise NotImplementedError


def jacobian(floats, t, point, lane, out):
    """Partial derivatives of `rates` at the state floats[point:point + STATES].

    Written to floats[out + i * (STATES + 1) + j] for row i and state j; j = STATES: time.
    """
    raise NotImplementedError


def contact_velocity(floats, t, point, contact, lane):
    """Velocity of a contact (0: the first) of one lane at the state floats[point:point + STATES]."""
    raise NotImplementedError


def contact_rows(floats, t, point, lane, out):
    """The problem of several contacts at the state floats[point:point + STATES], see `events/decision.py`.

    From `out` on: b [n], A [n n], n [n], C [n n] (1 and 0 of constant loads); then seven numbers of each contact: force
    while it slides, what pushes it then, what pushes it at rest, least and most that it can hold, least and most once
    it has given way.
    """
    raise NotImplementedError


def holding(floats, t, point, lane, out):
    """Of each contact the force that would hold it over the middle of what it can hold, and how far that reaches.

    At the state floats[point:point + STATES]; 2 CONTACTS numbers from `out` on, 0 of a contact that cannot rest.
    """
    raise NotImplementedError


def reaction(floats, t, point, which, lane):
    """One of the true loads that are watched, at the state floats[point:point + STATES]."""
    raise NotImplementedError


def evidence(floats, t, point, lane, out):
    """What the equations say at the state floats[point:point + STATES], for `observe/evidence.py`.

    From `out` on: the first BASE rates; of each contact the force that holds it over the middle of what can be held,
    its limit (0 of one that cannot rest), and of a further one that has a side its velocity.
    """
    raise NotImplementedError


def shifts(floats, t, lane, out):
    """Of each contact velocity at imposed distances what it is ahead of the state that all share.

    From `out` on, three numbers of each: that function of time, and its first two derivatives.
    """
    raise NotImplementedError


def machine_energy(floats, t, point, lane):
    """Kinetic and potential energy of the machine at the state floats[point:point + STATES]; of laws with branches."""
    raise NotImplementedError


def integrands(floats, t, point, lane, out):
    """The functions of which an ensemble gathers integrals and peaks, at the state floats[point:point + STATES].

    Written to floats[out:out + INTEGRANDS]: powers by channel, R, R times contact velocity, R once more, own functions
    to be integrated; then own functions of which the largest value is wanted.
    """
    raise NotImplementedError


def guard_tangents(floats, t, point, lane, out):
    """How the guards grow along the tangent: velocity, holding force and limit of each contact, then those of pieces.

    Only of equations with a tangent, see `tangents.py`.
    """
    raise NotImplementedError


def switches(floats, t, point, lane, out):
    """The guards of the branches at the state floats[point:point + STATES], written to floats[out:out + SWITCHES]."""
    raise NotImplementedError


def after_switch(floats, t, point, lane, which, out):
    """The states after guard `which` has fallen to zero, written to floats[out:out + STATES]."""
    raise NotImplementedError


def after_reversal(floats, t, point, lane, contact, out):
    """The states after a contact (0: the first) has turned to its side, written to floats[out:out + STATES]."""
    raise NotImplementedError


def observables(floats, t, point, lane, out):
    """What a page draws besides the states, at floats[point:point + STATES]; to floats[out:out + OBSERVABLES]."""
    raise NotImplementedError


def beginning(floats, t, point, lane, out):
    """Room and natural sizes of the states, period, velocity of each contact; ROOM + STATES + 1 + CONTACTS numbers."""
    raise NotImplementedError


def drive_table(floats, t, point, lane, out):
    """Of each segment of the part that begins at t, of the drive's period, its length and its coefficients.

    To floats[out:out + TABLE_NUMBERS].
    """
    raise NotImplementedError
