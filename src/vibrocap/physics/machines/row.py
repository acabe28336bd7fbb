"""What machines of several bodies in a row share: their parameters, and the classes of each number of bodies."""

import functools
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Literal, NamedTuple

from vibrocap.physics.machines.consistent_units import ConsistentUnits
from vibrocap.physics.machines.machine import parameter, parameters
from vibrocap.physics.names import numbered

WORDS = (
    "two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen seventeen eighteen"
)
NUMBERS = dict(enumerate([*WORDS.split(), "nineteen", "twenty"], start=2))


class Numbered(NamedTuple):
    """A parameter of every body or gap, or of the whole row; that of the first may be of another type than the others.

    meaning: {} stands for the number of the body or gap
    """

    name: str
    of: Literal["body", "gap", "row"]
    first: Any
    others: Any
    default: float
    symbol: str
    meaning: str
    role: str


class Row(ConsistentUnits):
    """Bodies 1, 2, ... in a row, each with a contact of its own; `row_of` makes the class of each number of them."""

    called: ClassVar[tuple[str, str]]  # what a body and the row are: ("body", "crawler") of "two-body-crawler"
    bodies: ClassVar[int]
    summary: ClassVar[str]  # of the class of a number of bodies
    row_parameters: ClassVar[tuple[Numbered, ...]]  # its parameters
    si_load: ClassVar = "1 where the coefficients of the law are forces in N"
    normal_load: Any

    @classmethod
    def of_bodies(cls, bodies: int) -> Mapping[str, Any]:
        """What else of the class depends on the number of bodies."""
        return {}

    def _whole(self, name: str):
        return sum(self._all(name, self.bodies))

    def _all(self, name: str, count: int) -> tuple:
        """A parameter of the first so many bodies or gaps."""
        return tuple(getattr(self, numbered(name, i)) for i in range(1, count + 1))


@functools.cache
def row_of(kind: type[Row], bodies: int) -> Any:
    """The class of a row of two to twenty bodies, "two-body-crawler" and so on; ValueError for another number."""
    if bodies not in NUMBERS:
        raise ValueError(f"bodies should be a whole number from 2 to {max(NUMBERS)}, got {bodies!r}")
    fields: dict[str, Any] = {}
    types: dict[str, Any] = {}
    counts = {"body": bodies, "gap": bodies - 1, "row": 1}
    for row_parameter in kind.row_parameters:
        for i in range(1, counts[row_parameter.of] + 1):
            name, symbol = (
                numbered(row_parameter.name, i),
                row_parameter.symbol if row_parameter.of == "row" else f"{row_parameter.symbol}_{i}",
            )
            fields[name] = parameter(row_parameter.default, symbol, row_parameter.meaning.format(i), row_parameter.role)
            types[name] = row_parameter.first if i == 1 else row_parameter.others
    words = (NUMBERS[bodies], *kind.called)
    class_name = "".join(word.title() for word in words)
    space = {
        **fields,
        "__annotations__": types,
        "__module__": kind.__module__,
        "__qualname__": class_name,
        "__doc__": f"{words[0].title()} {kind.summary}\n\n    {kind.__doc__}",
        "__reduce__": lambda self: (_made, (kind, bodies, {name: getattr(self, name) for name in fields})),
        "name": "-".join(words),
        "bodies": bodies,
        **kind.of_bodies(bodies),
    }
    return parameters(type(class_name, (kind,), space))


def row_called(name: str, kinds: Sequence[type[Row]]) -> Any:
    """The class of a row of one of these kinds by its name, such as "five-body-worm"; KeyError for what is none."""
    known = {"-".join((word, *kind.called)): (kind, number) for kind in kinds for number, word in NUMBERS.items()}
    return row_of(*known[name])


def _made(kind: type[Row], bodies: int, values: dict[str, Any]) -> Any:
    """A machine again, where it was pickled: the classes of more than three bodies can be found in no module."""
    return row_of(kind, bodies)(**values)
