"""What machines of several bodies in a row share: their parameters, the classes of each number of bodies, pictures."""

import functools
import itertools
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Literal, NamedTuple

from vibrocap.physics.machines.machine import Machine, Shape, SIScales, parameter, parameters
from vibrocap.physics.numbering import numbered

APART = 5.0  # of the middles of neighbouring bodies in pictures, where no gap has opened
WORDS = (
    "two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen seventeen eighteen"
)
NUMBERS = dict(enumerate([*WORDS.split(), "nineteen", "twenty"], start=2))


def row_of_bodies(places: Sequence[Any], link: Literal["spring", "rod"]) -> tuple[Shape, ...]:
    """Blocks at places along the ground, joined by what is of the kind `link`, "spring" or "rod"."""
    found = []
    for i, x in enumerate(places, start=1):
        found += [Shape("box", f"body {i}", ((x, 0.25),), (1.0, 0.5))]
        found += [Shape("contact", f"contact {i}", ((x, 0.0),), (0.9, 0.0))]
    for i, (behind, ahead) in enumerate(itertools.pairwise(places), start=1):
        found.append(Shape(link, f"{link} {i}", ((behind + 0.5, 0.25), (ahead - 0.5, 0.25))))
    return tuple(found)


class Numbered(NamedTuple):
    """A parameter that every body or gap has; the first one's may be of another type than the others'."""

    name: str
    of: Literal["body", "gap"]
    first: Any
    others: Any
    default: float
    symbol: str
    meaning: str
    role: str


class Row(Machine):
    """Bodies 1, 2, ... in a row, each with a contact of its own; `row_of` makes the class of each number of them."""

    bodies: ClassVar[int]
    summary: ClassVar[str]  # of the class of a number of bodies
    row_parameters: ClassVar[tuple[Numbered, ...]]  # its parameters
    cyclic: ClassVar = "position"
    channels: ClassVar = ("drive", "damper")
    si_scales: ClassVar = SIScales
    si_load: ClassVar = "1 where the coefficients of the law are forces in N"
    normal_load: Any

    @classmethod
    def of_bodies(cls, bodies: int) -> Mapping[str, Any]:
        """What else of the class depends on the number of bodies."""
        return {}

    def _all(self, name: str, count: int) -> tuple:
        """A parameter of the first so many bodies or gaps."""
        return tuple(getattr(self, numbered(name, i)) for i in range(1, count + 1))

    def load(self):
        """N of body 1."""
        return self.normal_load

    def further_loads(self) -> tuple:
        """N_2, N_3, ..."""
        return self._all("normal_load", self.bodies)[1:]


@functools.cache
def row_of(kind: type[Row], bodies: int) -> Any:
    """The class of a row of two to twenty bodies, "two-body-crawler" and so on."""
    if bodies not in NUMBERS:
        raise ValueError(f"bodies should be a whole number from 2 to {max(NUMBERS)}, got {bodies!r}")
    fields: dict[str, Any] = {}
    types: dict[str, Any] = {}
    for each in kind.row_parameters:
        for i in range(1, bodies + (each.of == "body")):
            name = numbered(each.name, i)
            fields[name] = parameter(each.default, f"{each.symbol}_{i}", each.meaning.format(i), each.role)
            types[name] = each.first if i == 1 else each.others
    word, what = NUMBERS[bodies], kind.__name__
    space = {
        **fields,
        "__annotations__": types,
        "__module__": kind.__module__,
        "__qualname__": f"{word.title()}Body{what}",
        "__doc__": f"{word.title()} {kind.summary}\n\n    {kind.__doc__}",
        "__reduce__": lambda self: (_made, (kind, bodies, {name: getattr(self, name) for name in fields})),
        "name": f"{word}-body-{what.lower()}",
        "bodies": bodies,
        "contacts": tuple(numbered("velocity", i) for i in range(2, bodies + 1)),
        **kind.of_bodies(bodies),
    }
    return parameters(type(f"{word.title()}Body{what}", (kind,), space))


def row_called(kind: type[Row], name: str) -> Any:
    """The class of a row by its name; KeyError for what is none."""
    bodies = {f"{word}-body-{kind.__name__.lower()}": number for number, word in NUMBERS.items()}
    return row_of(kind, bodies[name])


def _made(kind: type[Row], bodies: int, values: dict[str, Any]) -> Any:
    """A machine again, where it was pickled: the classes of more than three bodies can be found in no module."""
    return row_of(kind, bodies)(**values)
