"""One instant of a motion alone: its states in the work space, and what follows from them."""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.generated.equations import beginning, observables
from vibrocap.numerics.kernel.generated.places import WORK
from vibrocap.numerics.kernel.generated.sizes import OBSERVABLES, ROOM, STATES
from vibrocap.numerics.kernel.lane import alone

INSTANT = WORK
OBSERVED = INSTANT + STATES


def take_sizes(floats):
    """Write the natural sizes of the states to where the run looks for them; the period of the drive.

    They follow from the parameters and the states in memory. Behind the instant stand room, sizes and period.
    """
    for i in range(STATES):
        floats[INSTANT + i] = alone.state[i]
    beginning(floats, 0.0, INSTANT, 0, OBSERVED)
    for i in range(STATES):
        alone.scale[i] = floats[OBSERVED + ROOM + i]
    return floats[OBSERVED + ROOM + STATES]


def write_observed(floats, ints, trace, s, out):
    """Write the states of the instant, at time s of the series, and the observables there to the trace from `out` on.

    What depends on the law's forces is asked at a state consistent with the slopes, see `stiff_point.py`.
    """
    for i in range(STATES):
        trace[out + i] = floats[INSTANT + i]
    hook.consistent_state(floats, ints, 0, s, INSTANT)
    observables(floats, alone.time + s, INSTANT, 0, OBSERVED)
    for i in range(OBSERVABLES):
        trace[out + STATES + i] = floats[OBSERVED + i]
