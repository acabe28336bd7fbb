"""Starts from simpler fits: of the laws that a law contains, and of the same law without bounds of one's own.

A law that contains another can be no worse than that, but a search of more parameters can end in a worse minimum. So it
also starts from the best of what it contains.
"""

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from vibrocap.identification.problem.data_scales import DataScales
from vibrocap.identification.problem.parametrisation import Parametrisation, law_class, parametrisation
from vibrocap.identification.problem.prediction import Prediction
from vibrocap.identification.search.loss import Loss, SearchStatus
from vibrocap.identification.search.multistart import drafts
from vibrocap.physics.parameters import parameter_table


@dataclasses.dataclass(frozen=True)
class SimplerFits:
    """The fits of the laws that a law contains, on thinned records; `best` of a choice is that of its own drafts.

    draft: what belongs to a choice of parameters, nuisances included; scales: of the data; bounds: those of one's own
    """

    draft: Callable[[Parametrisation], Prediction]
    scales: DataScales
    bounds: Mapping[str, tuple[float, float]]
    starts: int
    seed: int

    def ends(self, choice: Parametrisation, loss: Loss) -> list[np.ndarray]:
        """Coordinates, nuisances included, of the best drafts of the simpler fits of a choice."""
        space, ends = self.draft(choice).space, []
        if self.bounds:
            free = self._choice(choice.template, choice.space.names)
            ends.append(dataclasses.replace(self, bounds={}).best(free, loss))
        for name, values in type(choice.template).special_cases.items():
            simpler = self._special_case(choice, name, values)
            best = None if simpler is None else self.best(simpler, loss)
            if best is not None:
                ends.append({**best, **{k: best.get(v, 1.0) if isinstance(v, str) else v for k, v in values.items()}})
        middle = space.named(space.begun(choice.start))
        known = [{k: v for k, v in end.items() if k in middle} for end in ends if end is not None]
        return [space.of({**middle, **end}) for end in known]

    def best(self, choice: Parametrisation, loss: Loss) -> dict[str, float] | None:
        """Values by name of the best draft of a choice, its own simpler fits among the starts."""
        prediction = self.draft(choice)
        first, also = [prediction.space.begun(choice.start)], self.ends(choice, loss)
        end, _ = drafts(prediction, first, also, starts=self.starts, loss=loss, seed=self.seed)[0]
        return None if end.status == SearchStatus.FAILED else prediction.space.named(end.u)

    def _choice(self, template: Any, free: Iterable[str], bounds: Any = None) -> Parametrisation:
        """The choice of a law's free parameters; the others are held at the template's values."""
        names = tuple(free)
        held = {
            info.name: value
            for info in parameter_table(template)
            if info.name not in names and isinstance(value := getattr(template, info.name), float)
        }
        return parametrisation(type(template), self.scales, names, held, bounds)

    def _special_case(
        self, choice: Parametrisation, name: str, values: Mapping[str, float | str]
    ) -> Parametrisation | None:
        """The choice of a simpler law; None where what is held does not allow it."""
        template, free = choice.template, choice.space.names
        for own, value in values.items():
            wanted = getattr(template, value) if isinstance(value, str) else value
            if own not in free and getattr(template, own) != wanted:
                return None
        cls = law_class(name)
        infos = parameter_table(cls)
        shared = [info.name for info in infos if info.name in free]
        if not shared:
            return None
        inner = cls(**{info.name: getattr(template, info.name) for info in infos if hasattr(template, info.name)})
        return self._choice(inner, shared, {k: pair for k, pair in self.bounds.items() if k in shared})
