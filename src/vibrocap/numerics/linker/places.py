"""Places for names: the entries of a lane, in a kernel's text, become entries of its flat arrays."""

import re

from vibrocap.numerics.kernel.lane import Gathered, Lane, Numbers, Rows, Wholes

ARRAYS = {
    name: array
    for array, entries in (("ints", Wholes), ("floats", Numbers), ("floats", Gathered))
    for name in entries.__annotations__
}
ROWS = {"row": "SERIES", "guard_row": "SWITCH"}  # of whole series: the place of the first coefficient
assert ROWS.keys() == Rows.__annotations__.keys()
ENTRY = re.compile(r"\b(lane|lanes|at|shared|stepper|alone)\.(\w+)(\[?)")
HOOK = re.compile(r"\bhook\.(?=\w+\()")
SIMPLE = re.compile(r"\w+|\w+\[\w+\]")  # an index that needs no brackets before `* LANES`


def with_places(text: str) -> str:
    """The text of a kernel with places for names, line by line as before; hooks are called by their own names.

        lane.time        floats[TIME + lane]             lane.side[c]     floats[SIDE + c * LANES + lane]
        lanes.time       load(floats, TIME)              lane.row[i]      SERIES + i * (ORDER + 1) * LANES + lane
        at.side[c]       SIDE + c * LANES                alone.side[c]    floats[SIDE + c]

    Raises ValueError for an entry that no lane has.
    """
    done, start = [], 0
    for match in ENTRY.finditer(text):
        if match.start() < start:
            continue  # within an index that is done
        owner, name, bracket = match.groups()
        if name not in ARRAYS and name not in ROWS:
            raise ValueError(f"`{match[0]}`: {Lane.__module__} has no entry of this name")
        place, end = ROWS.get(name, name.upper()), match.end()
        several = owner in ("lane", "lanes", "at")
        if bracket:
            end = _closing(text, end)
            index = with_places(text[match.end() : end - 1])
            if several or name in ROWS:
                index = index if SIMPLE.fullmatch(index) else f"({index})"
            place += f" + {index}{' * (ORDER + 1)' if name in ROWS else ''}{' * LANES' if several else ''}"
        if owner == "lane":
            place += " + lane"
        if name in ARRAYS and owner != "at":
            place = f"load({ARRAYS[name]}, {place})" if owner == "lanes" else f"{ARRAYS[name]}[{place}]"
        done += [text[start : match.start()], place]
        start = end
    return HOOK.sub("", "".join([*done, text[start:]]).replace("every_lane()", "range(LANES)"))


def _closing(text: str, start: int) -> int:
    """Behind the bracket that closes the one before `start`."""
    depth = 1
    for end in range(start, len(text)):
        depth += {"[": 1, "]": -1}.get(text[end], 0)
        if depth == 0:
            return end + 1
    raise ValueError(f"`{text[start : start + 40]}`: its bracket is not closed")
