"""What a measure taken during the run is: its name, what it means, and how it comes about.

There are three ways: a standard measure is read from what every kernel gathers (`during_run`); a reduction is the mean,
the integral, the largest or the least value over the window of a function of the instant, of one's own; a derived
measure is a function of other measures.
"""

import copy
import dataclasses
import keyword
from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.measures.gathered import Gathered
from vibrocap.numerics.api import Integrands, integrands_source
from vibrocap.numerics.expressions.equations import Equations, rate_of
from vibrocap.numerics.expressions.graph import Expression, Graph
from vibrocap.physics.names import numbered

Function = Callable[["Instant"], Any]


@dataclasses.dataclass(frozen=True)
class Standard:
    """Read from what the kernel gathers.

    groups: what has to be gathered for it, a sum of `ASK_...` of `codes`
    value: of the runs that finished, one number (or text) per run
    """

    value: Callable[[Gathered], np.ndarray]
    groups: int = 0
    text: bool = False


@dataclasses.dataclass(frozen=True)
class Reduction:
    """The mean, integral, largest, least or peak (largest size) over the window of a function of the instant."""

    kind: Literal["mean", "integral", "largest", "least", "peak"]
    function: Function


@dataclasses.dataclass(frozen=True)
class Derived:
    """A function of other measures, given as arrays with one value per run (plain numbers for a single motion)."""

    function: Callable[..., Any]
    of: tuple[str, ...]


def _reducing(kind: Any, words: str) -> Any:
    """What makes a measure that is a reduction of this kind."""

    def make(cls, name: str, meaning: str, function: Function, unit: str = "1", si_unit: str = "1") -> "Measure":
        return cls(name, meaning, Reduction(kind, function), unit, si_unit)

    make.__name__, make.__qualname__, make.__doc__ = kind, f"Measure.{kind}", words
    return classmethod(make)


@dataclasses.dataclass(frozen=True)
class Measure:
    """A measure during a run.

    name: a Python name; meaning: a few words, with the window
    how: a `Reduction` or `Derived`, best made by `Measure.largest` and its like; unit: "1" where it has none
    si_unit: in which a study of a system that knows its scales gives it, such as "N m/s"; "1": as it is
    """

    name: str
    meaning: str
    how: Standard | Reduction | Derived
    unit: str = "1"
    si_unit: str = "1"

    def __post_init__(self):
        if not self.name.isidentifier() or keyword.iskeyword(self.name):
            raise ValueError(f"name of a measure should be a Python name such as 'peak_power', got {self.name!r}")

    @property
    def is_text(self) -> bool:
        return isinstance(self.how, Standard) and self.how.text

    mean = _reducing("mean", "The mean over time of a function of the instant (`Instant`), over the window.")
    integral = _reducing("integral", "The integral over time of a function of the instant, over the window.")
    largest = _reducing("largest", "The largest value of a function of the instant in the window.")
    least = _reducing("least", "The least value of a function of the instant in the window.")
    peak = _reducing("peak", "The largest size of a function of the instant in the window, whatever its sign.")

    @classmethod
    def derived(
        cls,
        name: str,
        meaning: str,
        function: Callable[..., Any],
        of: tuple[str, ...],
        unit: str = "1",
        si_unit: str = "1",
    ) -> "Measure":
        """A function of other measures: called with the arrays of the measures `of`, in that order."""
        return cls(name, meaning, Derived(function, tuple(of)), unit, si_unit)


class Instant:
    """One instant of a motion, of which a measure of one's own is a function.

    `m.angle`, `m.velocity`, ... are the states, `m.friction`, `m.holding_force`, `m.drive`, `m.contact_velocity`, ...
    the observables, `m.drive_rate` the rate of the drive between its jumps, `m.drive_power`, ... the power of each
    channel, `m.time` the time since the start of the period, `m.side` the side of the contact (1, -1; 0: stuck),
    `m.side_2` that of the second. `m["machine.mass_ratio"]` is a parameter. They are recorded: the function is called
    once and should be a formula of them, with `vibrocap.physics.elementary` for sin, cos, exp and powers.
    """

    def __init__(self, equations: Equations):
        graph = equations.graph
        self._known = {
            "time": graph.node("time"),
            **{numbered("side", i + 1): graph.node("side", i) for i in range(len(equations.contacts))},
            **{name: graph.node("state", i) for i, name in enumerate(equations.state_names)},
            **equations.observables,
            **{f"{name}_power": power for name, power in zip(equations.channels, equations.powers, strict=True)},
            "drive_rate": rate_of(equations.observables["drive"], equations.rates),
        }
        self._parameters = {path: graph.node("parameter", i) for i, path in enumerate(equations.parameter_paths)}

    def __getattr__(self, name: str) -> Expression:
        known = self.__dict__.get("_known", {})
        if name in known:
            return known[name]
        raise AttributeError(f"{name!r} is not known of an instant of this system; there is {', '.join(known)}")

    def __getitem__(self, path: str) -> Expression:
        if path in self._parameters:
            return self._parameters[path]
        raise KeyError(f"{path!r} is not a number of this system; there is {', '.join(self._parameters)}")


def own_integrands(needed: Sequence[Measure], equations: Equations) -> Integrands | None:
    """The functions of all reductions among measures, recorded; None where there is none.

    Raises ValueError for a function that cannot be recorded: it names what the system does not have, or branches on a
    value.
    """
    sums = [measure for measure in needed if is_summed(measure)]
    extremes = [measure for measure in needed if isinstance(measure.how, Reduction) and not is_summed(measure)]
    if not sums and not extremes:
        return None
    own = copy.deepcopy(equations)  # what is recorded for a measure is none of the equations' business
    graph, instant = own.graph, Instant(own)
    functions = [_recorded(measure, graph, instant) for measure in sums]
    signed = [
        sign * function
        for measure in extremes
        for function in [_recorded(measure, graph, instant)]
        for sign in signs_of_extremes(measure)
    ]
    return integrands_source(own, functions, signed)


def is_summed(measure: Measure) -> bool:
    """Whether a measure is a mean or an integral of a function of one's own."""
    return isinstance(measure.how, Reduction) and measure.how.kind in ("mean", "integral")


def signs_of_extremes(measure: Measure) -> tuple[float, ...]:
    """With which signs a function of one's own is recorded, so that the largest value of each is what is wanted."""
    assert isinstance(measure.how, Reduction)
    return {"largest": (1.0,), "least": (-1.0,), "peak": (1.0, -1.0)}[measure.how.kind]


def _recorded(measure: Measure, graph: Graph, instant: Instant) -> Expression:
    assert isinstance(measure.how, Reduction)
    try:
        return graph.expression(measure.how.function(instant))
    except (AttributeError, KeyError, TypeError) as error:
        text = error.args[0] if error.args else str(error)
        raise ArgumentError("measures", f"{measure.name}: is not available: {text}") from error
