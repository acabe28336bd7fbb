"""Returns are not counted: the starts of drive periods tell whether a motion has settled."""

from vibrocap.numerics.kernel.generated.lane import PERIOD_COUNT
from vibrocap.numerics.kernel.observe.settle import LONGEST_PERIOD


def begin_returns(floats, ints, lane):
    """A run begins."""


def period_mark(ints, lane):
    """(number of the mark at the start of the present period, longest response looked for)."""
    return ints[PERIOD_COUNT + lane], LONGEST_PERIOD


def settled_by_returns(floats, ints, lane):
    """At a return: nothing."""
    return 0


def tell_returns(floats, ints, lane):
    """The run ends."""
