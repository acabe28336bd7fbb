"""Numbers in names: what belongs to the first contact, body or gap has none, what belongs to another ends in its."""

import re

_NUMBER = re.compile(r"(?:_([2-9]|[1-9][0-9]{1,8}))?")  # "_2", "_10", not "_1" or "_02"


def numbered(name: str, number: int) -> str:
    """What a quantity, part or parameter of one of several is called: "friction" of the first, "friction_2"."""
    return name if number == 1 else f"{name}_{number}"


def number_in(name: object, first: str) -> int:
    """Whose a name is that is `first` for the first one: 1 of "friction", 2 of "friction_2", 0 where it is neither."""
    found = _NUMBER.fullmatch(name, len(first)) if isinstance(name, str) and name.startswith(first) else None
    return 0 if found is None else int(found[1] or 1)
