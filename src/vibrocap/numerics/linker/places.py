"""Places for names: the entries of a lane, in a kernel's text, become entries of its flat arrays."""

import re

from vibrocap.numerics.kernel.driven_generated import Law
from vibrocap.numerics.kernel.lane import Gathered, Lane, Numbers, Rows, Wholes

WHOLES, NUMBERS = (Wholes, Law.__bases__[0]), (Numbers, Gathered, Law.__bases__[1])
ARRAYS = {
    name: array
    for array, records in (("ints", WHOLES), ("floats", NUMBERS))
    for record in records
    for name in record.__annotations__
}
ROWS = {"row": "SERIES", "guard_row": "SWITCH", "guess_row": "GUESS", "load_row": "REACTION"}
OF_CONTACT = {"velocity": "VELOCITY_OF", "sticking_force": "STICKING_FORCE_OF", "limit": "LIMIT_OF"}
assert Rows.__annotations__.keys() == {*ROWS, *OF_CONTACT, *(f"{name}_row" for name in OF_CONTACT)}
ENTRY = re.compile(r"\b(lane|lanes|at|shared|stepper|alone|law)\.(\w+)(\[?)")
HOOK = re.compile(r"\bhook\.(?=\w+\()")
SIMPLE = re.compile(r"\w+|\w+\[\w+\]")  # an index that needs no brackets before `* LANES`


def with_places(text: str) -> str:
    """The text of a kernel with places for names, line by line as before; hooks are called by their own names.

        lane.time        floats[TIME + lane]             lane.side[c]     floats[SIDE + c * LANES + lane]
        lanes.time       load(floats, TIME)              lane.row[i]      SERIES + i * (ORDER + 1) * LANES + lane
        at.side[c]       SIDE + c * LANES                alone.side[c]    floats[SIDE + c]
        lane.velocity[c] floats[VELOCITY_OF[c] + lane]   lane.velocity_row[c]    VELOCITY_OF[c] + lane

    Raises ValueError for an entry that no lane has.
    """
    done, start = [], 0
    for match in ENTRY.finditer(text):
        if match.start() < start:
            continue  # within an index that is done
        (owner, name, bracket), end, index = match.groups(), match.end(), ""
        if name not in ARRAYS and name not in Rows.__annotations__:
            raise ValueError(f"`{match[0]}`: {Lane.__module__} has no entry of this name")
        if bracket:
            end = _closing(text, end)
            index = with_places(text[match.end() : end - 1])
        place = _place(owner, name, index)
        if owner != "at" and not name.endswith("row"):
            array = ARRAYS.get(name, "floats")
            place = f"load({array}, {place})" if owner == "lanes" else f"{array}[{place}]"
        done += [text[start : match.start()], place]
        start = end
    return HOOK.sub("", "".join([*done, text[start:]]).replace("every_lane()", "range(LANES)"))


def _place(owner: str, name: str, index: str) -> str:
    """The place of an entry, or of the item of it at an index."""
    several, lane = owner in ("lane", "lanes", "at"), " + lane" if owner == "lane" else ""
    if owner != "law" and name.removesuffix("_row") in OF_CONTACT:
        return f"{OF_CONTACT[name.removesuffix('_row')]}[{index}]{lane}"
    if not index:
        return name.upper() + lane
    factors = (" * (ORDER + 1)" if name in ROWS else "") + (" * LANES" if several else "")
    index = index if not factors or SIMPLE.fullmatch(index) else f"({index})"
    return f"{ROWS.get(name, name.upper())} + {index}{factors}{lane}"


def _closing(text: str, start: int) -> int:
    """Behind the bracket that closes the one before `start`."""
    depth = 1
    for end in range(start, len(text)):
        depth += {"[": 1, "]": -1}.get(text[end], 0)
        if depth == 0:
            return end + 1
    raise ValueError(f"`{text[start : start + 40]}`: its bracket is not closed")
