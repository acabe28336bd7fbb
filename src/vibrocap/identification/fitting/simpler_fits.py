"""Starts from simpler fits: of the laws that a law contains, and of the same law without bounds of one's own.

A law that contains another can be no worse than that, but a search of more parameters can end in a worse minimum. So it
also starts from the best of what it contains.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from vibrocap.identification.problem.data_scales import DataScales
from vibrocap.identification.problem.parametrisation import Parametrisation, law_class, parametrisation
from vibrocap.identification.problem.prediction import Prediction
from vibrocap.identification.search.loss import Loss, SearchStatus
from vibrocap.identification.search.multistart import drafts
from vibrocap.physics.parameters import parameter_table

Draft = Callable[[Parametrisation], Prediction]  # the draft that belongs to a choice of parameters


def simpler_starts(
    draft: Draft,
    chosen: Parametrisation,
    scales: DataScales,
    bounds: Mapping[str, tuple[float, float]],
    starts: int,
    loss: Loss,
    seed: int,
) -> list[np.ndarray]:
    """Coordinates, nuisances included, of the best drafts of the simpler fits of a choice.

    draft: the thinned records with a law and its coordinates. What the choice holds stays held.
    """
    space, found = draft(chosen).space, []
    if bounds:
        found.append(_best(draft, _choice(chosen.template, chosen.space.names, scales), scales, {}, starts, loss, seed))
    for name, values in type(chosen.template).special_cases.items():
        simpler = _special_case(chosen, name, values, scales, bounds)
        if simpler is None:
            continue
        best = _best(draft, simpler, scales, bounds, starts, loss, seed)
        if best is not None:
            found.append({**best, **{k: best.get(v, 1.0) if isinstance(v, str) else v for k, v in values.items()}})
    middle = dict(zip(space.names, space.values(_padded(chosen.start, space)).tolist(), strict=True))
    return [
        space.of({**middle, **{k: v for k, v in each.items() if k in middle}}) for each in found if each is not None
    ]


def _choice(template: Any, free: Iterable[str], scales: DataScales, bounds: Any = None) -> Parametrisation:
    """The choice of a law's free parameters; the others are held at the template's values."""
    names = tuple(free)
    held = {
        info.name: value
        for info in parameter_table(template)
        if info.name not in names and isinstance(value := getattr(template, info.name), float)
    }
    return parametrisation(type(template), scales, names, held, bounds)


def _special_case(
    chosen: Parametrisation, name: str, values: Mapping[str, float | str], scales: DataScales, bounds: Any
) -> Parametrisation | None:
    """The choice of a simpler law; None where what is held does not allow it."""
    template, free = chosen.template, chosen.space.names
    for own, value in values.items():
        wanted = getattr(template, value) if isinstance(value, str) else value
        if own not in free and getattr(template, own) != wanted:
            return None
    cls = law_class(name)
    shared = [info.name for info in parameter_table(cls) if info.name in free]
    if not shared:
        return None
    inner = cls(**{
        info.name: getattr(template, info.name) for info in parameter_table(cls) if hasattr(template, info.name)
    })  # fmt: skip
    kept = {k: pair for k, pair in bounds.items() if k in shared}
    return _choice(inner, shared, scales, kept)


def _best(
    draft: Draft,
    chosen: Parametrisation,
    scales: DataScales,
    bounds: Mapping[str, tuple[float, float]],
    starts: int,
    loss: Loss,
    seed: int,
) -> dict[str, float] | None:
    """Values by name of the best draft of a choice, its own simpler fits among the starts."""
    prediction = draft(chosen)
    also = simpler_starts(draft, chosen, scales, bounds, starts, loss, seed)
    best = drafts(prediction, [_padded(chosen.start, prediction.space)], also, starts=starts, loss=loss, seed=seed)[0][
        0
    ]
    if best.status == SearchStatus.FAILED:
        return None
    return dict(zip(prediction.space.names, prediction.space.values(best.u).tolist(), strict=True))


def _padded(start: np.ndarray, space: Any) -> np.ndarray:
    return np.concatenate([start, np.zeros(len(space.coordinates) - len(start))])
