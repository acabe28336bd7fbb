"""What machines of several bodies in a row share: words for their number, names of parameters, pictures."""

import itertools
from collections.abc import Sequence
from typing import Any, Literal

from vibrocap.physics.machines.machine import Shape

APART = 5.0  # of the middles of neighbouring bodies in pictures, where no gap has opened
NUMBERS = {2: "two", 3: "three", 4: "four", 5: "five", 6: "six", 7: "seven", 8: "eight", 9: "nine", 10: "ten"}


def numbered(name: str, number: int) -> str:
    """The name of a parameter of a body or gap: the first one has no number in it."""
    return name if number == 1 else f"{name}_{number}"


def row_of_bodies(places: Sequence[Any], link: Literal["spring", "rod"]) -> tuple[Shape, ...]:
    """Blocks at places along the ground, joined by what is of the kind `link`, "spring" or "rod"."""
    found = []
    for i, x in enumerate(places, start=1):
        found += [Shape("box", f"body {i}", ((x, 0.25),), (1.0, 0.5))]
        found += [Shape("contact", f"contact {i}", ((x, 0.0),), (0.9, 0.0))]
    for i, (behind, ahead) in enumerate(itertools.pairwise(places), start=1):
        found.append(Shape(link, f"{link} {i}", ((behind + 0.5, 0.25), (ahead - 0.5, 0.25))))
    return tuple(found)
