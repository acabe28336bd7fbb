"""Functions that are written for one system; `floats` is the memory of all lanes."""


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
