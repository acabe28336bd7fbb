"""Checks of a plan before any work: every value that a machine, a law or a drive would refuse, all at once."""

import itertools
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import Complaint
from vibrocap.case.case import CaseError
from vibrocap.case.sections import is_kind
from vibrocap.physics.dimensions.conversion import INITIAL
from vibrocap.physics.names import split_path
from vibrocap.physics.system import System
from vibrocap.studies.plan.axes import Grid
from vibrocap.studies.plan.cases import CaseList
from vibrocap.studies.plan.designs import Drawn
from vibrocap.studies.plan.runs import Column, Runs
from vibrocap.studies.plan.variation import kinds_chosen, path_complaints, refusal

LIMIT = 20_000  # combinations tried before any work (some 20 microseconds each); the others are looked at tile by tile
SHOWN = 20  # complaints about single cases


def plan_complaints(system: System, plan: Runs) -> list[str]:
    """What is wrong with the paths and the values of a plan, in words."""
    if isinstance(plan, CaseList):
        return _case_complaints(system, plan)
    kinds = [kinds_chosen(system, kinds) for kinds in kind_choices(plan)]
    complaints = path_complaints(plan.paths, kinds, system.units)
    if complaints:
        return complaints
    return _merged(complaint for values in _trials(system, plan) for complaint in refusal(system, values))


def check_runs(system: System, values: Mapping[str, np.ndarray]) -> None:
    """CaseError for the first run whose values are refused; values: arrays [runs] by path."""
    names = [path for path in values if not path.startswith(INITIAL)]
    for row in dict.fromkeys(zip(*(values[path].tolist() for path in names), strict=True)):
        run = {path: value for path, value in zip(names, row, strict=True) if value is not None and value == value}
        if complaints := refusal(system, run):
            raise CaseError(complaints, "the run with " + ", ".join(f"{path} = {x}" for path, x in run.items()))


def kind_choices(plan: Runs) -> Iterator[dict[str, Any]]:
    """Every combination of kinds in a grid; of a design there is one, that of the case."""
    axes = [axis for axis in plan.axes if is_kind(axis.path)] if isinstance(plan, Grid) else []
    for kinds in itertools.product(*(axis.values for axis in axes)):
        yield {axis.path: kind for axis, kind in zip(axes, kinds, strict=True)}


def _case_complaints(system: System, plan: CaseList) -> list[str]:
    complaints = []
    for number in range(plan.count):
        case = plan.case(number)
        texts = path_complaints(case, [kinds_chosen(system, case)], system.units)
        if not texts and number < LIMIT:
            texts = list(refusal(system, case))
        complaints += [Complaint(f"cases[{number}]", complaint) for complaint in texts]
        if len(complaints) >= SHOWN:
            return [*complaints[:SHOWN], "and perhaps more"]
    return complaints


def _groups(system: System, plan: Grid) -> Iterator[tuple[dict[str, Any], list[Column], bool]]:
    """(kinds, axes of one part, whether that part has rules between its fields), for all kinds and parts.

    Where a part has such rules, values that are good one by one may be refused together.
    """
    for kinds in kind_choices(plan):
        choice = kinds_chosen(system, kinds)
        numbered = [axis for axis in plan.axes if not is_kind(axis.path) and not axis.path.startswith(INITIAL)]
        parts: dict[str, list[Column]] = {}
        for axis in numbered:
            parts.setdefault(split_path(axis.path)[0], []).append(axis)
        for part, axes in parts.items():
            kind = choice[part] if isinstance(choice[part], type) else type(choice[part])
            yield kinds, axes, bool(kind.__pydantic_decorators__.model_validators) or hasattr(kind, "__post_init__")


def _trials(system: System, plan: Runs) -> Iterator[dict[str, Any]]:
    """Values to try: all combinations that matter where they are few, else the corners and what lies along them."""
    if isinstance(plan, Drawn):
        ranges = [span for span in plan.ranges if not span.path.startswith(INITIAL)]
        ends = [Column(span.path, (span.low, span.high)) for span in ranges]
        yield from itertools.islice(_crossed(ends), LIMIT)
        return
    assert isinstance(plan, Grid)
    first = {axis.path: axis.values[0] for axis in plan.axes if not axis.path.startswith(INITIAL)}
    for kinds in kind_choices(plan):
        yield first | kinds
    for kinds, axes, ruled in _groups(system, plan):
        few = int(np.prod([len(axis.values) for axis in axes], dtype=object)) <= LIMIT
        for values in _crossed(axes) if ruled and few else _along(axes, ruled):
            yield first | kinds | values


def _crossed(axes: list[Column]) -> Iterator[dict[str, Any]]:
    for values in itertools.product(*(axis.values for axis in axes)):
        yield dict(zip((axis.path for axis in axes), values, strict=True))


def _along(axes: list[Column], ruled: bool) -> Iterator[dict[str, Any]]:
    """Each axis on its own; between the corners of the others where values must suit each other."""
    share = max(1, LIMIT // (len(axes) * (2 ** (len(axes) - 1) if ruled else 1)))
    for axis in axes:
        others = [Column(other.path, _ends(other)) for other in axes if other is not axis] if ruled else []
        step = -(-len(axis.values) // share)
        thinned = dict.fromkeys([*_ends(axis), *axis.values[::step]])
        for rest in itertools.islice(_crossed(others), LIMIT):
            for value in thinned:
                yield rest | {axis.path: value}


def _ends(axis: Column) -> tuple[Any, ...]:
    numbers = [value for value in axis.values if isinstance(value, (int, float))]
    return tuple(dict.fromkeys([*([min(numbers), max(numbers)] if numbers else []), axis.values[0]]))


def _merged(complaints: Iterable[str]) -> list[str]:
    """One line per field: its first complaint, and how many more values are refused."""
    kinds: dict[str, dict[str, None]] = {}
    for complaint in complaints:
        what = re.sub(r"\(.*?\)|, got .*", "", complaint)
        kinds.setdefault(what, {})[complaint] = None
    more = [len(texts) - 1 for texts in kinds.values()]
    firsts = [next(iter(texts)) for texts in kinds.values()]
    return [first + (f" (and {n} more such)" if n else "") for first, n in zip(firsts, more, strict=True)]
