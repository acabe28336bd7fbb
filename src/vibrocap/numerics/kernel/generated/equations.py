"""Functions that are written for one system; `floats` is the memory of all lanes."""


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


def evidence(floats, t, point, side, lane, out):
    """What the equations say at the state floats[point:point + STATES], for `observe/evidence.py`.

    From `out` on: the first BASE rates; of each contact that can stick the force that holds it over the middle of what
    can be held, and its limit; of further contacts the velocity along their side.
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
