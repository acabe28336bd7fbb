"""Choice of the step for equations that are never stiff (set-valued laws: at rest they stick, else they are smooth).

Tangents are followed by Taylor steps too: an implicit step would need second derivatives.
"""

from vibrocap.numerics.kernel.generated import PATIENCE
from vibrocap.numerics.kernel.step.stabilised import series_step

FOR_GOOD = 2**40  # steps


def chosen_step(real, whole, lane, remaining):
    """The step of the series, and no look at any other."""
    whole[PATIENCE + lane] = FOR_GOOD
    return series_step(real, whole, lane, remaining)[0]


def polished_step(real, whole, lane, h, longest):
    """A Taylor series needs no repeated step: its root is the event."""
    return 1, h


def repeat_to(real, whole, lane, h):
    """Nothing to repeat."""
