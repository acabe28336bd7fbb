"""One thread of a GPU: it takes run after run from a queue, and goes on where the last launch stopped."""

from vibrocap.numerics.kernel.codes import RUNNING
from vibrocap.numerics.kernel.generated import RUN, STATUS, WORK
from vibrocap.numerics.kernel.hook import advance, ends_trial
from vibrocap.numerics.kernel.loop.run_queue import begin_run, end_run

# Places of `queue`.
NEXT, END, BUSY = 0, 1, 2  # first run that no thread has begun; end of the runs; threads that go on in another launch
WHOLE_SIZE = 0  # numbers in `ints`; set behind this text


def run_thread(
    floats, ints, trace, queue, start_floats, start_ints, kept_floats, kept_ints, thread, threads, fresh, rounds
):
    """Make up to `rounds` steps, through run after run of the trace, until the queue is empty.

    kept_floats, kept_ints: [entries, threads] what threads carry between launches; fresh: begin from start_* instead
    """
    for i in range(WORK):
        floats[i] = start_floats[i] if fresh != 0 else kept_floats[i * threads + thread]
    for i in range(WHOLE_SIZE):
        ints[i] = start_ints[i] if fresh != 0 else kept_ints[i * threads + thread]
    over = False
    for _ in range(rounds):
        # One that left alone, from within a condition, would keep those behind the condition apart ever after.
        if in_all_threads(over):
            break
        if not over and ints[STATUS] != RUNNING and not ends_trial(floats, ints, 0):
            if ints[RUN] >= 0:
                end_run(floats, ints, trace, 0)
            run = take(queue, NEXT, 1)
            if run < queue[END]:
                begin_run(floats, ints, trace, 0, run)
            else:
                over = True
        if not over:
            advance(floats, ints, trace, 1)
    if not over:
        take(queue, BUSY, 1)
    for i in range(WORK):
        kept_floats[i * threads + thread] = floats[i]
    for i in range(WHOLE_SIZE):
        kept_ints[i * threads + thread] = ints[i]


def take(ints, place, amount):
    """Add an amount to an entry at once, whoever else does, and return what stood there before."""
    before = ints[place]
    ints[place] = before + amount
    return before


def in_all_threads(condition):
    """Whether a condition holds in all threads that go together, each of which waits here for the others."""
    return condition
