"""Design variables, with their bounds or choices."""

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, Complaint, Complaints, check_one_of, is_number, shown
from vibrocap.case.sections import is_kind
from vibrocap.physics.dimensions.conversion import quantity
from vibrocap.physics.names import split_path
from vibrocap.physics.system import System
from vibrocap.studies.plan.designs import Range, range_from
from vibrocap.studies.plan.runs import Column, axis_of
from vibrocap.studies.plan.variation import kinds_chosen, path_complaints, refusal

FAR = 1e3  # distance of designs that differ in a choice: their motions are not of one kind
APART = 1e-3  # in shares, of the differences that give the slopes of a function of one's own, to the fourth order
FACTOR = "factor:"  # before a range: of a factor of the system's own values, which several paths may share
DIFFERENCES = ((-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0))


def factored(key: Any, ends: Any) -> tuple[tuple[str, ...], bool, Any, list[Complaint]]:
    """(paths that a key names, whether a factor of their own values is given, it without that word, what is wrong)."""
    paths = tuple(part.strip() for part in key.split(",")) if isinstance(key, str) else tuple(key)
    factor = isinstance(ends, str) and ends.startswith(FACTOR)
    words = f"several parameters share a factor of their own values: {FACTOR}"
    words += ends if isinstance(ends, str) else "LOW:HIGH"
    wrong = [Complaint(",".join(paths), words)] if len(paths) > 1 and not factor else []
    return paths, factor, ends.removeprefix(FACTOR) if factor else ends, wrong


@dataclasses.dataclass(frozen=True)
class DesignSpace:
    """The design variables of a search, each a range of numbers or a list of choices.

    A design is a point of the unit cube, [variables]: the share of each range, logarithmic where the range is; of n
    choices, the share k/n to (k+1)/n stands for choice k.

    through: None where the variables are parameters of the system; else a function of variables of one's own, called
    with an array [designs] of each by its name, that returns arrays by path of a parameter
    """

    variables: tuple[Range | Column, ...]
    through: Callable[..., Mapping[str, Any]] | None = dataclasses.field(default=None, compare=False)

    @property
    def paths(self) -> tuple[str, ...]:
        """The paths, or the names, of the variables, as they were given."""
        return tuple(variable.path for variable in self.variables)

    @property
    def continuous(self) -> np.ndarray:
        """Indices of the variables that are ranges."""
        return np.flatnonzero([isinstance(variable, Range) for variable in self.variables])

    def apart(self, shares: np.ndarray) -> np.ndarray:
        """Places [designs, variables] whose distances say how near designs are; other choices are far apart."""
        shifted = np.array(shares, dtype=float)
        for i, variable in enumerate(self.variables):
            if isinstance(variable, Column):
                shifted[:, i] = FAR * _choice(variable, shares[:, i])
        return shifted

    def _own(self, shares: np.ndarray) -> dict[str, np.ndarray]:
        """Values [designs] of the variables at shares [designs, variables]; of objects where there are words."""
        columns = zip(self.variables, shares.T, strict=True)
        return {x.path: x.at(column) if isinstance(x, Range) else x.array[_choice(x, column)] for x, column in columns}

    def values(self, shares: np.ndarray) -> dict[str, np.ndarray]:
        """Values [designs] of the parameters by path at shares [designs, variables]; of objects where words are."""
        return self._made(self._own(shares), len(shares))

    def _made(self, own: dict[str, np.ndarray], designs: int) -> dict[str, np.ndarray]:
        """Values [designs] of the parameters by path, of those of the variables."""
        return own if self.through is None else made_through(self.through, own, designs)

    def made(self, values: Mapping[str, float]) -> dict[str, float | str]:
        """The parameters of one design by path, of its variables by path."""
        return _first(self._made({path: np.array([value]) for path, value in values.items()}, 1))

    def design(self, share: np.ndarray) -> dict[str, float | str]:
        """The variables of one design, at its shares [variables]."""
        return _first(self._own(share[None]))

    def parameters(self, share: np.ndarray) -> dict[str, float | str]:
        """The parameters of one design by path, at its shares [variables]."""
        return _first(self.values(share[None]))

    def share_of(self, design: Mapping[str, Any]) -> np.ndarray:
        """The shares [variables] of a design, which names every variable by its path; ValueError for one outside."""
        point = np.empty(len(self.variables))
        for i, variable in enumerate(self.variables):
            if variable.path not in design:
                raise ValueError(f"should give {variable.path}")
            value = design[variable.path]
            if isinstance(variable, Column):
                check_one_of(variable.path, value, variable.values)  # type: ignore[arg-type]
                point[i] = (variable.values.index(value) + 0.5) / len(variable.values)
                continue
            if not (is_number(value) and variable.low <= value <= variable.high):
                within = f"from {variable.low:g} to {variable.high:g}"
                raise ArgumentError(variable.path, f"should be {within}, got {shown(value)}")
            ends = np.array([variable.low, value, variable.high])
            low, here, high = np.log(ends) if variable.logarithmic else ends
            point[i] = (here - low) / (high - low)
        return point

    def derivative(self, index: int, share: float) -> float:
        """d(value)/d(share) of a range."""
        variable = self.variables[index]
        assert isinstance(variable, Range)
        return variable.slope(share)

    def slopes(self, share: np.ndarray) -> dict[str, np.ndarray]:
        """d(value)/d(share) [continuous] of each parameter, by path, at shares [variables] of a design."""
        moving = self.continuous
        if self.through is None:
            rates = np.diag([self.derivative(int(i), float(share[i])) for i in moving])
            return {self.paths[i]: rate for i, rate in zip(map(int, moving), rates, strict=True)}
        steps = np.zeros((len(moving), len(DIFFERENCES), len(self.variables)))
        steps[np.arange(len(moving)), :, moving] = [APART * place for place, _ in DIFFERENCES]
        values = self.values((share + steps).reshape(-1, len(self.variables)))
        weights = np.array([weight for _, weight in DIFFERENCES]) / APART
        return {path: x.reshape(len(moving), -1) @ weights for path, x in values.items()}

    def require_numbers(self, complaints: Complaints) -> list[str]:
        """The paths of ranges of numbers; complaints about the others."""
        numbers = [self.paths[i] for i in self.continuous if not is_kind(self.paths[i])]
        for path in self.paths:
            if path not in numbers:
                complaints.add(path, "should be a number with its bounds, such as 0.1:0.5")
        return numbers

    def record(self) -> dict[str, Any]:
        """The variables by path, in the words in which they can be given again, and what is made of them."""
        words: dict[str, Any] = {}
        for x in self.variables:
            kind = "log:" if isinstance(x, Range) and x.logarithmic else ""
            words[x.path] = f"{kind}{x.low!r}:{x.high!r}" if isinstance(x, Range) else list(x.values)
        if self.through is None:
            return words
        places = np.random.default_rng(0).random((3, len(self.variables)))
        return words | {path: list(map(float, x)) for path, x in self.values(places).items()}


def made_through(through: Callable[..., Any], own: Mapping[str, np.ndarray], many: int) -> dict[str, np.ndarray]:
    """Values [many] by path that a function makes of quantities of one's own."""
    return {path: np.broadcast_to(np.asarray(x, dtype=float), many) for path, x in through(**own).items()}


def through_complaints(system: System, names: Iterable[str], values: Callable[[], Mapping[str, Any]]) -> list[str]:
    """What is wrong with the function of quantities of one's own that gives these values by path."""
    try:
        return path_complaints(values(), [system.parts], system.units)
    except (TypeError, ValueError, AttributeError) as error:
        text = f"should take arrays of {', '.join(names)} and return arrays by path; it ends in: {error}"
        return [Complaint("through", text)]


def refusal_among(system: System, columns: Mapping[str, np.ndarray]) -> tuple[str, ...]:
    """What a part refuses of one of many variations, columns [variations] by path; the extremes are asked first."""
    ends = (int(end(column)) for column in columns.values() for end in (np.argmin, np.argmax))
    order = dict.fromkeys((*ends, *range(len(next(iter(columns.values()))))))
    asked = (refusal(system, {path: float(column[k]) for path, column in columns.items()}) for k in order)
    return next(filter(None, asked), ())


def _first(values: Mapping[str, np.ndarray]) -> dict[str, float | str]:
    """The first of each column."""
    return {path: x if isinstance(x := column[0], str) else float(x) for path, column in values.items()}


def _choice(variable: Column, share: np.ndarray) -> np.ndarray:
    """Numbers of the choices at shares."""
    return np.minimum((share * len(variable.values)).astype(int), len(variable.values) - 1)


def design_space(
    system: System, over: Any, complaints: Complaints, through: Callable[..., Mapping[str, Any]] | None = None
) -> DesignSpace:
    """The space that `over` of `optimise` describes; what is wrong with it is added to the complaints.

    through: see `DesignSpace`
    """
    if not isinstance(over, Mapping) or not over:
        wanted = "should name at least one design variable with its bounds, such as drive.frequency=0.5:3"
        complaints.add("over", wanted)
        return DesignSpace(())
    variables: list[Range | Column] = []
    tied: dict[str, tuple[str, ...]] = {}
    begun = len(complaints)
    for path, ends in over.items():
        paths, factor, ends, wrong = factored(path, ends)
        complaints += wrong
        if factor:
            tied[path] = paths
        variable, wrong = axis_of(path, ends) if _is_choice(path, ends) else range_from(path, ends)
        complaints += wrong
        variables.append(variable)
    space = DesignSpace(tuple(variables), through)
    if through is not None:
        if len(complaints) == begun:
            complaints += _function_complaints(system, space)
        return space
    every = [path for name in over for path in tied.get(name, [name])]
    if len(complaints) == begun:
        choices = [variable for variable in variables if isinstance(variable, Column) and is_kind(variable.path)]
        kinds = {variable.path: variable.values[0] for variable in choices}
        complaints += path_complaints(every, [kinds_chosen(system, kinds)], system.units)
        starts = [path for path in every if path.startswith("initial.")]
        complaints += [Complaint(path, "a start is no design variable; give it by `starts`") for path in starts]
    if len(complaints) == begun:
        if again := twice(every, system):
            complaints.add(again[0], f"is the same quantity as {again[1]}; give it once")
        for path in (path for paths in tied.values() for path in paths if not is_number(system.parameter(path))):
            complaints.add(path, "has no number of its own that a factor multiplies")
        for text in (x for x in variables if tied and isinstance(x, Column) and x.is_text):
            complaints.add(text.path, "should be numbers beside a factor")
    if len(complaints) == begun:
        space = DesignSpace(space.variables, _factors(system, tied)) if tied else space
        complaints += _end_complaints(system, space)
    return space


def twice(paths: Sequence[str], system: System) -> list[str]:
    """Those of some paths that name the same quantity as another."""
    plain = [quantity(path, system).plain for path in paths]
    return [path for path, one in zip(paths, plain, strict=True) if plain.count(one) > 1]


def _factors(system: System, tied: Mapping[str, Sequence[str]]) -> Callable[..., Mapping[str, Any]]:
    """The function that makes parameters of variables some of which are factors of the system's own values."""
    own = {path: float(system.parameter(path)) for paths in tied.values() for path in paths}

    def through(**values: np.ndarray) -> dict[str, np.ndarray]:
        products = {}
        for name, x in values.items():
            products |= {path: own[path] * x for path in tied[name]} if name in tied else {name: x}
        return products

    return through


def _function_complaints(system: System, space: DesignSpace) -> list[str]:
    """What is wrong with variables of one's own and with the function that makes parameters of them."""
    if wrong := [x.path for x in space.variables if not x.path.isidentifier()]:
        return [Complaint(wrong[0], "should be a name, an argument of the function `through`")]
    if words := [x.path for x in space.variables if isinstance(x, Column) and x.is_text]:
        return [Complaint(words[0], "should be numbers, as the function `through` takes them")]
    return through_complaints(system, space.paths, lambda: space.values(np.full((1, len(space.variables)), 0.5)))


def _is_choice(path: str, ends: Any) -> bool:
    """Whether choices are given, not the two ends of a range."""
    if is_kind(path) or isinstance(ends, str):
        return is_kind(path) or ":" not in ends
    return isinstance(ends, (Sequence, np.ndarray)) and not (len(ends) == 2 and all(map(is_number, ends)))


def _end_complaints(system: System, space: DesignSpace) -> list[str]:
    """What parts refuse at the ends of single ranges; a part that compares its fields is asked design by design."""
    complaints: list[str] = []
    for variable in space.variables:
        parts: list[Any] = [system.parts.get(split_path(path.strip())[0]) for path in variable.path.split(",")]
        comparing = (type(x).__pydantic_decorators__.model_validators or hasattr(x, "__post_init__") for x in parts)
        if isinstance(variable, Range) and None not in parts and not any(comparing):
            ends = [{variable.path: end} for end in (variable.low, variable.high)]
            ends = [end if space.through is None else space.through(**end) for end in ends]
            complaints += [complaint for end in ends for complaint in refusal(system, end)][:1]
    return complaints
