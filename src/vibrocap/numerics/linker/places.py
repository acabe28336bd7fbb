"""Places for names: the entries of a lane, in a kernel's text, become entries of its flat arrays."""

import re

from vibrocap.numerics.kernel.lane import Gathered, Lane, Numbers, Wholes

ARRAYS = {
    name: array
    for array, each in (("ints", Wholes), ("floats", Numbers), ("floats", Gathered))
    for name in each.__annotations__
}
ENTRY = re.compile(r"\b(lane|shared|stepper)\.(\w+)(\[?)")
SIMPLE = re.compile(r"\w+|\w+\[\w+\]")  # an index that needs no brackets before `* LANES`


def with_places(text: str) -> str:
    """The text of a kernel with `floats[TIME + lane]` for `lane.time`, line by line as before.

    Of `shared` and `stepper` it is the entry of the first lane. Raises ValueError for an entry that no lane has.
    """
    done, at = [], 0
    for match in ENTRY.finditer(text):
        if match.start() < at:
            continue  # within an index that is done
        owner, name, bracket = match.groups()
        if name not in ARRAYS:
            raise ValueError(f"`{match[0]}`: {Lane.__module__} has no entry of this name")
        place, end = name.upper(), match.end()
        if bracket:
            end = _closing(text, end)
            index = with_places(text[match.end() : end - 1])
            if owner == "lane":
                index = f"{index if SIMPLE.fullmatch(index) else f'({index})'} * LANES"
            place += f" + {index}"
        if owner == "lane":
            place += " + lane"
        done += [text[at : match.start()], f"{ARRAYS[name]}[{place}]"]
        at = end
    return "".join([*done, text[at:]]).replace("every_lane()", "range(LANES)")


def _closing(text: str, start: int) -> int:
    """Behind the bracket that closes the one before `start`."""
    depth = 1
    for end in range(start, len(text)):
        depth += {"[": 1, "]": -1}.get(text[end], 0)
        if depth == 0:
            return end + 1
    raise ValueError(f"`{text[start : start + 40]}`: its bracket is not closed")
