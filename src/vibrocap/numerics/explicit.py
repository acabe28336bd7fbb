"""Choice of the step for equations that are never stiff (set-valued laws: at rest they stick, else they are smooth)."""

from vibrocap.numerics.taylor import taylor_step


def chosen_step(real, whole, lane, remaining):
    """The Taylor step."""
    return taylor_step(real, whole, lane)


def polished_step(real, whole, lane, h, longest):
    """A Taylor series needs no repeated step: its root is the event."""
    return 1, h
