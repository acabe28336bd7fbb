"""Whether a motion has settled: the decision, from its stroboscopic states modulo the cyclic coordinate."""


def remember(real, whole, lane):
    """Keep the stroboscopic state of the period that begins."""


def settled_response(real, whole, lane):
    """(response period, period since which it was settled, bound of the distance to go); (0, 0, 0.0): not settled."""
    return 0, 0, 0.0
