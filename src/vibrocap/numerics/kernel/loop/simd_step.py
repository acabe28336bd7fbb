"""One step of all lanes at once: side by side where a step is plain, one by one where it takes decisions.

Every lane has a step, a mode and events of its own. What all lanes share is arithmetic: the series, the length of the
step, the proof that no event lies within it or the root where one does, and the state at its end. A lane on which more
is to be decided than that takes `one_step.step`, like a single motion; the others would do the same there.
"""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.arithmetic.plain_vectors import align_stack, all_lanes, bits, load, min, store, where
from vibrocap.numerics.kernel.arithmetic.roots import EPSILON, HUGE, SLIGHT
from vibrocap.numerics.kernel.codes import FIRST_SWITCH, NOT_FINITE, RUNNING, TOO_MANY_STEPS
from vibrocap.numerics.kernel.events.contact import cross, pin
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import at, every_lane, lanes
from vibrocap.numerics.kernel.loop.one_step import step, turn
from vibrocap.numerics.kernel.loop.side_by_side import (
    before_turning,
    first_events,
    out_of_doubt,
    passing_simd,
    resolved_simd,
    root_simd,
    still_simd,
    taylor_steps,
)
from vibrocap.numerics.kernel.step.resolved import excursion
from vibrocap.numerics.kernel.step.slow_manifold import follow_manifolds, settled_lanes, slow_lanes
from vibrocap.numerics.kernel.step.stabilised import PLAIN_REACH, one_rests, stabilised_step
from vibrocap.numerics.kernel.step.taylor import NON_STIFF, least_of_cubic, series_value, sign_in_doubt


def advance(floats, ints, trace, rounds):
    running = lanes.status == RUNNING
    all_running = bits(running)
    for _ in range(rounds):
        slow = 0
        if SLOWED and not SEVERAL:  # of several contacts one function makes the series of all lanes
            slow = bits(running & slow_lanes(floats))
        if slow != all_running:
            jet(floats)
        if slow != 0:
            slow_jet(floats, all_lanes())
        waiting = all_running ^ step_simd(floats, ints, trace, running)
        if waiting != 0:
            for lane in every_lane():
                if (waiting >> lane) & 1:
                    step(floats, ints, trace, lane)
        running = lanes.status == RUNNING
        over = running & (lanes.taylor_steps + lanes.implicit_steps >= lanes.step_limit)
        store(ints, at.status, where(over, TOO_MANY_STEPS, lanes.status))
        if bits(running & ~over) != all_running:
            return


def step_simd(floats, ints, trace, running):
    """One step of all lanes on which it is plain; returns these lanes, as bits. Its phases are those of `step`."""
    align_stack()
    every = all_lanes()
    remaining = lanes.until - lanes.time
    longest, last, before, clear = taylor_steps(floats)
    free = longest
    damped = running & ~running
    slow = damped
    if SLOWED:
        slow = running & slow_lanes(floats)
    moving, turning, longest, reach = signs_count(floats, ints, running, slow, longest)
    if MAYBE_STIFF:
        moving, longest, damped = plain_methods(floats, ints, moving, slow, turning, longest, reach, last, before)
    if SLOWED and bits(slow) != 0:
        longest = before_turning(floats, slow, longest)
    h = min(remaining, longest)
    plain = modes_hold_simd(floats, ints, moving, clear, h)
    settled, near, far = plain, plain, plain
    if SLOWED and bits(slow) != 0:
        settled, near, far = settled_lanes(floats, h, longest)
        plain = plain & (~slow | (settled & near))
    if SHARP and STICKS[SHARP_CONTACT] + KINKS[SHARP_CONTACT] == 0:
        side, start = lanes.side[SHARP_CONTACT], lanes.velocity[SHARP_CONTACT]
        change = excursion(floats, at.velocity_row[SHARP_CONTACT] + every, h)
        plain = plain & resolved_simd(floats, side, start, change, h, plain)
    plain, h, event, which = first_events(floats, ints, plain, slow, longest, h)
    plain, h, event, which = first_switches(floats, ints, plain, slow | damped, h, event, which)
    if MAYBE_STIFF:
        store(floats, at.damped_step, where(damped & ~plain, longest, 0.0))
    if SLOWED:
        follow_manifolds(floats, slow, (settled, near, far), plain, h, where(slow, max(h, free), 0.0))
    move_simd(floats, ints, trace, plain, h)
    if SEVERAL or BRANCHES > 0:
        store(floats, at.event_contact, which)
    if SHARED:
        moved = bits(plain)
        for lane in every_lane():
            if (moved >> lane) & 1:
                pin(floats, lane)
    finish_simd(floats, ints, trace, bits(plain & event), bits(plain & (remaining - h <= 2.0 * EPSILON * lanes.period)))
    return bits(plain | slow)


def signs_count(floats, ints, running, slow, longest):
    """(lanes whose kinked contacts tell their side over the step, those so near rest that the sign of a velocity
    counts, lengths of the steps, how far a plain series reaches)."""
    moving = running
    turning = running & ~running
    reach = longest
    if MAYBE_STIFF and SEVERAL:
        rate = lanes.decay_rate
        reach = where(rate * longest > PLAIN_REACH, PLAIN_REACH / rate, longest)
    for c in range(CONTACTS):
        if KINKS[c] == 1:
            tolerance, speed = lanes.tolerance, abs(lanes.velocity[c])
            if SEVERAL:
                tolerance = tolerance * lanes.scale[STATE_OF[c]]
            counts = 0.1 * (speed + abs(load(floats, at.velocity_row[c] + LANES)) * longest) >= tolerance
            if SEVERAL and bits(moving & ~counts) != 0:
                if SLOWED and bits(slow & ~counts) != 0:
                    reach = out_of_doubt(floats, c, slow & ~counts, reach)
                    longest = where(slow, min(longest, reach), longest)
                h = min(lanes.until - lanes.time, reach)
                turning = turning | ~(counts | still_simd(floats, ints, c, h))
                counts = counts | ~sign_in_doubt(floats, c, all_lanes(), h)
            moving = moving & counts
    return moving, turning, longest, reach


def plain_methods(floats, ints, moving, slow, turning, longest, reach, last, before):
    """(lanes whose method stays, lengths of their steps, in which of them a stabilised one), as in
    `stabilised.series_step`."""
    rate = lanes.decay_rate
    non_stiff = ~(rate * longest > NON_STIFF) & (slow | (ORDER * last * longest < NON_STIFF * before))
    non_stiff = non_stiff | (longest >= lanes.until - lanes.time)
    for c in range(CONTACTS):
        non_stiff = non_stiff | (lanes.transition[c] > 0)
    moving = moving & (lanes.stiff == 0) & (non_stiff | slow | (lanes.patience > 1))
    if SEVERAL:
        moving = moving & (non_stiff | ~one_rests(floats, all_lanes()))
        longest = where(turning, reach, longest)
    longest, damped = stabilised_step(floats, all_lanes(), moving & ~non_stiff & ~turning, longest, lanes.tolerance)
    return moving, longest, damped


def modes_hold_simd(floats, ints, moving, clear, h):
    """Lanes whose modes hold at the start of the step, and whose equations do over all of it; clear: far from bounds"""
    plain = moving & (h > 0.0) & ((h > 4.0 * EPSILON * lanes.period) | (h >= lanes.until - lanes.time))
    for c in range(CONTACTS):
        plain = plain & (lanes.transition[c] >= 0) & (lanes.transition[c] <= 2)
    plain = hook.tangents_wait(ints, plain)
    if BRANCHES < SWITCHES and bits(plain & ~clear) != 0:
        for i in range(BRANCHES, SWITCHES):
            row = at.guard_row[i]
            holds = load(floats, row) > 0.0
            if LOCATED[i] == 1:
                holds = within_piece(floats, row, h)
            plain = plain & (clear | holds)
    if RETURNING:
        plain = plain & ~passing_simd(floats, h)
    return plain


def first_switches(floats, ints, plain, slaved, h, event, which):
    """The same as of `side_by_side.first_events`, with what ends a branch; slaved: lanes whose steps are no series"""
    for i in range(BRANCHES):
        row = at.guard_row[i]
        clear = ~plain | within_piece(floats, row, h)
        if bits(~clear) != 0:
            first, following = load(floats, row), load(floats, row + LANES) * h
            one = (abs(first) <= SLIGHT) & (following > SLIGHT)  # as behind an impact
            sure = first > SLIGHT
            if i >= LAW_BRANCHES:
                sure = sure | one
            switch_simd(floats, row, one, h)
            leading, last, changes = signs_simd(floats)
            located = ~clear & sure & (leading > 0.0) & (changes == 1.0) & ~slaved
            plain = plain & (clear | located | (sure & (leading > 0.0) & (changes == 0.0)))
            if bits(located) != 0:
                h = where(located, h * root_simd(floats, leading, last, located), h)
                if i >= LAW_BRANCHES and POLISHED[i] == 1:
                    h = polished_simd(floats, ints, i, located, h)
                    plain = plain & (h > 0.0)
                event = event | located
                which = where(located, 1.0 * (CONTACTS + i), which)
    return plain, h, event, which


def polished_simd(floats, ints, i, located, h):
    """The steps, with those made longer or shorter that end where the series of guard i vanishes, until the guard does;
    0 of a lane in which it does not."""
    store(floats, at.step, h)
    found = bits(located)
    for lane in every_lane():
        if (found >> lane) & 1:
            left = lane.until - lane.time
            event, polished = hook.polished_switch(floats, ints, lane, FIRST_SWITCH + i, lane.step, left, False)
            lane.step = polished if event != 0 else 0.0
    return load(floats, at.step)


def within_piece(floats, row, h):
    """Where a guard stays positive over the step beyond doubt, so that its branch lasts; or the true load does.

    As in `ahead_simd`: its first four terms stay above the sum of all others, which is largest at the end of the step.
    """
    every = all_lanes()
    others = abs(load(floats, row + ORDER * LANES))
    for k in range(ORDER - 1, 3, -1):
        others = others * h + abs(load(floats, row + k * LANES))
    return least_of_cubic(floats, row + every, others, h) > 0.0


def move_simd(floats, ints, trace, plain, h):
    """Put the lanes at the ends of their steps, after the hook for measuring saw the pieces."""
    every = all_lanes()
    store(floats, at.step, h)
    measured = plain & (lanes.window_start > -1)
    measuring = bits(measured)
    if measuring != 0:
        for lane in every_lane():
            if (measuring >> lane) & 1:
                hook.on_piece(floats, ints, trace, lane, lane.step)
        for w in range(WATCHED):
            above = within_piece(floats, at.load_row[w], h)
            doubtful = bits(measured & (lanes.lifted[w] == 0.0) & ~above)
            if doubtful != 0:
                for lane in every_lane():
                    if (doubtful >> lane) & 1:
                        hook.look_at_load(floats, ints, lane, w, lane.step)
    finite = plain
    for i in range(STATES):
        row = at.row[i]
        following = series_value(floats, row + every, h)
        finite = finite & (abs(following) <= HUGE)
        store(floats, at.state[i], where(plain, following, lanes.state[i]))
    time = lanes.time
    store(floats, at.time, where(plain, time + h, time))
    store(ints, at.status, where(plain & ~finite, NOT_FINITE, lanes.status))
    for c in range(CONTACTS):
        store(ints, at.transition[c], where(plain, 0, lanes.transition[c]))
        if SEVERAL:
            store(ints, at.gave_way[c], where(plain, 0, lanes.gave_way[c]))
    store(ints, at.zero_progress, where(plain, 0, lanes.zero_progress))
    store(ints, at.taylor_steps, where(plain, lanes.taylor_steps + 1, lanes.taylor_steps))
    if MAYBE_STIFF:
        store(ints, at.patience, where(plain, lanes.patience - 1, lanes.patience))


def finish_simd(floats, ints, trace, events, turns):
    """What follows a step: the contact comes to rest or slips, a segment of the drive or the period is over."""
    both = events | turns
    if both == 0:
        return
    for lane in every_lane():
        if (both >> lane) & 1 and lane.status == RUNNING:
            event = 0
            if (events >> lane) & 1:
                event = 1
                c = int(lane.event_contact) if SEVERAL or BRANCHES > 0 else 0
                if c >= CONTACTS:
                    event = FIRST_SWITCH + c - CONTACTS
                    c = 0
                elif lane.side[c] == 0.0:
                    event = 2 if series_value(floats, lane.sticking_force_row[c], lane.step) > 0.0 else -2
                cross(floats, ints, trace, lane, event, c, lane.step)
            if (turns >> lane) & 1 and lane.status == RUNNING:
                turn(floats, ints, trace, lane, event, lane.step)
