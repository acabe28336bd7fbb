"""Numbers in names: what belongs to the first contact, body or gap has none, what belongs to another ends in its."""

import re

_NUMBERED = re.compile(r"(.+)_([2-9]|[1-9][0-9]{1,8})")  # "friction_2", not "friction_1" or "friction_02"


def numbered(name: str, number: int) -> str:
    """What a quantity, part or parameter of one of several is called: "friction" of the first, "friction_2"."""
    return name if number == 1 else f"{name}_{number}"


def name_and_number(name: str) -> tuple[str, int]:
    """What it is called of the first one, and whose it is: ("friction", 2) of "friction_2", ("friction", 1) without."""
    found = _NUMBERED.fullmatch(name)
    return (name, 1) if found is None else (found[1], int(found[2]))


def number_in(name: object, first: str) -> int:
    """Whose a name is that is `first` for the first one: 1 of "friction", 2 of "friction_2", 0 where it is neither."""
    stem, number = name_and_number(name) if isinstance(name, str) else ("", 0)
    return number if stem == first else 0
