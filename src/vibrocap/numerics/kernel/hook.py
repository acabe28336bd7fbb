"""Hooks: what a kernel calls without knowing which module answers, as `hook.on_event(...)`.

Linking puts the functions of the module in their place that a recipe (`linker.py`) has chosen, with these arguments;
their own docstrings say what these do not. Where none does, what stands here is what happens: nothing, for the most
part. What cannot be done without raises an error here: a module defines all of those of a section, or none.
"""

from vibrocap.numerics.kernel.generated import jet

# How far the next step goes, and by which method.


def step_length(floats, ints, lane, remaining) -> float:
    """Length of the next step, no longer than `remaining`, with its series in memory."""
    raise NotImplementedError


# Natural sizes of the states, of which an ensemble keeps the inverses.


def inverse_scale(floats, i, lane):
    """One over the natural size of state i, of a lane or of all."""
    return 1.0 / lane.scale[i]


# What series a step has, and what a motion alone keeps of a step for the next one.


def next_series(floats, ints) -> None:
    """Make the series of all lanes at their present states."""
    jet(floats)


def follow_step(floats, event, h) -> None:
    """After a step of length h, to an event or none, of a motion alone: what its next series begins with."""


# What is done anew where a step is implicit.


def polished_step(floats, ints, lane, h, longest) -> tuple:
    """(event, length) of the step, made again where it has to be, that ends at the event found at h."""
    return 1, h


def made_again(floats, ints, lane, h) -> bool:
    """Whether the step is implicit; then it is made again with this length, so that it is as exact as its end."""
    return False


def shorter_step(floats, ints, lane, h) -> float:
    """Make the present implicit step anew, of several contacts: part of the way to an event at h. 0 where it is near.

    The next steps are explicit then.
    """
    return h


def leave_implicit(ints, lane) -> None:
    """Let the next steps be explicit."""


# The branches of the law on each side of rest, and the bounds of the equations.


def within_bounds(floats, ints, trace, lane) -> bool:
    """Whether the equations hold at the start of the step; if not, the run ends."""
    return True


def branch_holds(floats, ints, trace, lane) -> bool:
    """Whether the present branch holds at the start of the step; if not, the next one begins."""
    return True


def first_switch(floats, lane, event, h) -> tuple:
    """(event, instant): the event known so far, or that of a branch that ends before."""
    return event, h


def polished_switch(floats, ints, lane, event, h, remaining, again) -> tuple:
    """(event, length) of the step to a guard of a branch, which vanishes there to rounding; event 0: it does not.

    again: whether the step was `made_again`
    """
    return event, h


def begin_branch(floats, ints, trace, lane, which) -> None:
    """Begin the branch that follows guard number `which`."""


def turned(floats, lane, contact) -> None:
    """Change what a reversal of a contact (0: the first) changes in its law, besides the side."""


def way_out(floats, lane, c) -> float:
    """Side to which contact c, at rest for good in the present branch, slides from it."""
    return lane.side[c]


def branch_in_doubt(floats, lane, h) -> bool:
    """Whether a guard may have fallen to zero at the end of a step of length h."""
    return False


def guards_at(floats, lane, s, out) -> None:
    """Write the guards at time s of the present series."""


def interpolated_guards(floats, lane, h) -> None:
    """Write the series of the branches' guards over an implicit step of length h."""


# Which of several contacts rest.


def decide_together(floats, ints, lane) -> None:
    """Decide the sides of all contacts that rest or have come to rest, at the lane's present state."""


# The corners of the drive.


def begin_drive(floats, ints, trace, lane, run) -> None:
    """A run begins on a lane, which stands at its time."""


def at_corner(floats, ints, trace, lane) -> bool:
    """Whether the lane, at the end of a step, stands at a corner within the period; then it is turned."""
    return False


def begin_drive_period(floats, ints, trace, lane) -> None:
    """A period begins, at time 0."""


def drive_goes_over(floats, ints, trace, lane) -> bool:
    """Whether the drive, at the end of the last period, has a corner; it is then the one of the next period."""
    return False


# The tangent of the motion.


def tangent_waits(ints, lane) -> bool:
    """Whether the tangent has yet to enter the present piece."""
    return False


def leave_piece(floats, ints, lane, event, contact, h) -> None:
    """At an event, at time h of the series: the tangent becomes the change of the state at the event."""


def stay_in_piece(ints, lane) -> None:
    """A contact is set to rest by what moves no event: the tangent enters the same piece once more."""


def enter_piece(floats, ints, lane) -> None:
    """A piece begins, whose series stands in memory: the change at the event becomes one at one time."""


def tangents_wait(ints, plain):
    """Of all lanes: those of `plain` whose tangent does not wait."""
    return plain


# What is kept of a motion.


def has_room(floats, ints, trace, lane) -> bool:
    """Whether one more step can be kept; if not, the lane waits."""
    return True


def on_piece(floats, ints, trace, lane, h) -> None:
    """After a step of length h, whose series is in memory."""
    raise NotImplementedError


def on_event(floats, ints, trace, lane, kind, contact, s) -> None:
    """At an event of this kind of a contact (0: the first, -1: of none), s after the start of the present step."""


def on_jump(floats, ints, lane, gained) -> None:
    """At an impact, which changes the energy of the machine at one instant."""


def on_period(floats, ints, trace, lane) -> None:
    """At the start of a run and at the end of each whole period."""
    raise NotImplementedError


# What is kept of the last instant of a run.


def on_instant(floats, ints, trace, lane) -> None:
    """At the last instant of a run, at which the mode of the lane was decided once more; its series is in memory."""


# The true load, of one that is held constant.


def watch_load(floats, ints, lane, h) -> None:
    """After a step of length h, whose series is in memory: whether the true load has fallen below zero."""


def look_at_load(floats, ints, lane, w, h) -> None:
    """The same, of a step on which no bound tells."""


# Where a law is asked: at the state of the series, but for laws that may be stiff.


def consistent_state(floats, ints, lane, s, point) -> None:
    """Move the state at floats[point:point + STATES], that of the series at time s, to where the law is asked."""


def fit_to_slopes(floats, lane, s, point) -> float:
    """Move that state to the one consistent with the slopes; how far over natural sizes, 0.0 where it stays."""
    return 0.0


# Evidence that what is measured is a motion of the equations.


def take_evidence(floats, ints, lane, h) -> None:
    """Ask the equations of a piece of length h, whose series stands in memory."""


# Returns, by which motions settle that nothing drives in time.


def begin_returns(floats, ints, lane) -> None:
    """A run begins."""


def quiet_since(ints, lane) -> int:
    """The period at whose start stands the first mark."""
    return 0


def response_sought(longest) -> int:
    """Longest response that the starts of periods tell, `longest` where there are no other marks."""
    return longest


def place_passed(floats, ints, lane, h) -> float:
    """Time within the step, whose series is in memory, at which the place of returns is passed; -1.0: it is not."""
    return -1.0


def on_place(floats, ints, lane) -> None:
    """The lane stands where the place of returns is passed."""


def on_return(floats, ints, lane) -> None:
    """The velocity of a contact has fallen to zero, whatever it does next; the lane stands there."""


def tell_returns(floats, ints, lane) -> None:
    """The run ends."""


# How a run comes to its steady motion without waiting.


def begin_marks(ints, lane) -> None:
    """A run begins."""


def note_event(floats, ints, lane, event, c) -> None:
    """An event of contact c begins to change the mode of the lane."""


def starts_trial(floats, ints, lane) -> bool:
    """At a mark that is remembered, of a run that has not settled: whether it goes on from an extrapolated limit."""
    return False


def trial_fails(floats, ints, lane) -> bool:
    """At the end of a period: whether it was a trial that is refused, so that the lane stands where it was before."""
    return False


def ends_trial(floats, ints, lane) -> bool:
    """Of a lane that has stopped: whether that was within a trial, so that it runs on from where it was before."""
    return False


# How a stepper passes to the instant that is asked for.


def set_out(floats, ints, trace, length) -> None:
    """The motion is to go on by a length."""
    raise NotImplementedError


def under_way(floats, ints) -> bool:
    """Whether a further step is needed, of a motion that runs."""
    return True


def come_in(floats, ints, trace, length) -> None:
    """The last step is made: the clock stands at the instant, at an event before, or where the motion ended."""
    raise NotImplementedError


def keep_piece(floats, ints, trace, h) -> None:
    """A step of length h was accepted; the lane stands at its start."""
    raise NotImplementedError


def keep_event(floats, ints, kind, contact, s) -> None:
    """An event at time s after the lane's present time."""
    raise NotImplementedError


def show_instant(floats, ints, point) -> float:
    """Put the step in place in which the clock stands, and its state there to `point`; the time since it began."""
    raise NotImplementedError


def side_shown(floats, ints, contact) -> float:
    """Side of a contact (0: the first) at the clock."""
    raise NotImplementedError


# The loop over the lanes.


def advance(floats, ints, trace, rounds) -> None:
    """Advance all running lanes by up to `rounds` steps, or until the first of them stops."""
    raise NotImplementedError
