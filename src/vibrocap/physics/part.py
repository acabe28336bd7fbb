"""Parts in SI: a machine, a law or a drive whose parameters are given with their units."""

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from vibrocap.physics.parameters import parameters


@dataclasses.dataclass(frozen=True)
class PartInSI:
    """A part whose parameters are given in SI; `System` makes the part of it, by the scales of its machine.

    part: its class. values: by keys that carry their unit, such as "bristle_stiffness_N_per_m".
    """

    part: type
    values: Mapping[str, Any]


class Part:
    """What every machine, law and drive offers besides its physics.

    source: where it was published: works separated by semicolons, each by its key in the bibliography of the package
        (`vibrocap/citations/bibliography.bib`) or in words; "vibrocap" where it was made here
    wrappers, wrapped: of the class of a wrapped part, the wrappers from the inside out, and the plain part in them
    """

    source: ClassVar[str] = ""
    wrappers: ClassVar[tuple[Callable, ...]] = ()
    wrapped: ClassVar[Any] = None

    @classmethod
    def in_si(cls, **values: Any) -> Any:
        """This part with its parameters in SI, each with its unit in its name: `Harmonic.in_si(frequency_Hz=5, ...)`.

        The keys are those of a case file in SI; `System` takes it, if its other parts are in SI too.
        """
        return PartInSI(cls, values)


def wrapped_class(wrapper: Callable, cls: Any, part: Any) -> Any:
    """Finish the class of a wrapped law or drive: its name, its documentation, its fields, and how it is pickled.

    wrapper: the function that makes it   cls: the class, whose base is the part   part: the class that is wrapped
    """
    cls.__name__ = cls.__qualname__ = f"{wrapper.__name__.title()}{part.__name__}"
    cls.__doc__ = f"{part.__name__}, {wrapper.__name__}: see `{wrapper.__module__}`.\n\n    {part.__doc__}"
    cls.name = f"{wrapper.__name__}-{part.name}"
    cls.wrappers, cls.wrapped = (*part.wrappers, wrapper), part.wrapped or part
    cls.__reduce__ = _pickled
    return parameters(cls)


def inner_part(part: Any, outer: Any) -> Any:
    """The part inside a wrapped one, with its parameters; what the wrapper says anew it does not see."""
    inner = object.__new__(part)
    vars(inner).update(vars(outer))
    return inner


def _pickled(part: Any) -> tuple:
    """How to make a wrapped part again; its class can be found in no module."""
    values = {field.name: getattr(part, field.name) for field in dataclasses.fields(part)}
    return _unpickled, (part.wrapped, part.wrappers, values)


def _unpickled(part: Any, wrappers: tuple[Callable, ...], values: Mapping[str, Any]) -> Any:
    for wrapper in wrappers:
        part = wrapper(part)
    return part(**values)
