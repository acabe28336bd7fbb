"""Returns are not counted: the starts of drive periods tell whether a motion has settled."""


def begin_returns(floats, ints, lane):
    """A run begins."""


def quiet_since(ints, lane):
    """Marks count from the start of the run."""
    return 0


def response_sought(longest):
    """Longest response that the starts of periods tell."""
    return longest


def place_passed(floats, ints, lane, h):
    """There is no place."""
    return -1.0


def on_place(floats, ints, lane):
    """There is no place."""


def on_return(floats, ints, lane):
    """The velocity of a contact has fallen to zero."""


def tell_returns(floats, ints, lane):
    """The run ends."""
