"""Search: the coordinates of least squares, from several starts, drafted on few samples and polished on all."""

import dataclasses
import warnings
from collections.abc import Callable, Sequence

import numpy as np

from vibrocap.identification.coordinates import STEP
from vibrocap.identification.descent import descent
from vibrocap.identification.minimum import Loss, Minimum, finite
from vibrocap.identification.prediction import Prediction

SCREENED = 8  # points looked at per start
SHORT, LONG, POLISH = 10, 40, 60  # evaluations of a first draft, of the best drafts and of the polish
CARRIED = 3  # drafts that are carried on
SCAN, REACH = 81, 8.0  # points of a scan and its reach, in coarse steps


@dataclasses.dataclass(frozen=True, eq=False)
class Start:
    """One start of a multi-start search: where it began, the draft's end and its cost per sample."""

    u: np.ndarray
    end: np.ndarray
    cost: float


def search(
    prediction: Prediction,
    draft: Prediction,
    first: Sequence[np.ndarray],
    *,
    starts: int,
    loss: Loss,
    seed: int,
    progress: Callable[[float], None] | None = None,
) -> tuple[Minimum, tuple[Start, ...]]:
    """The best minimum from several starts: `first` and the best of a scrambled Sobol sequence around the last of them.

    Drafts run on `draft` (the same law and coordinates, fewer samples); the best is polished on `prediction`.
    """
    said = progress or (lambda _: None)
    first = list(first)[-starts:] if starts < len(first) else first
    begins = [np.clip(u, prediction.space.low, prediction.space.high) for u in first]
    if starts > len(begins):
        begins += _promising(draft, first[-1], starts - len(begins), loss, seed)
    said(0.05)
    drafts: list[tuple[Minimum, np.ndarray]] = []
    for i, u in enumerate(begins):
        drafts.append((descent(draft, u, loss, evaluations=SHORT, stop=1e-4), u))
        said(0.05 + 0.5 * (i + 1) / len(begins))
    drafts.sort(key=lambda each: each[0].cost)
    for i in range(min(CARRIED, len(drafts))):
        u = drafts[i][0].u
        drafts[i] = (descent(draft, u, loss, evaluations=LONG, stop=1e-6), drafts[i][1])
        said(0.55 + 0.15 * (i + 1) / CARRIED)
    drafts.sort(key=lambda each: each[0].cost)
    best = _scanned(prediction, descent(prediction, drafts[0][0].u, loss, evaluations=POLISH), loss)
    said(0.8)
    return best, tuple(Start(u, end.u, end.cost / draft.size) for end, u in drafts)


def _scanned(prediction: Prediction, best: Minimum, loss: Loss) -> Minimum:
    """The minimum, after a look along coordinates in which the force is not smooth: there a descent ends too soon."""
    for j, coordinate in enumerate(prediction.space.coordinates):
        if coordinate.step <= STEP:
            continue
        table = np.tile(best.u, (SCAN, 1))
        table[:, j] = np.clip(
            best.u[j] + coordinate.step * np.linspace(-REACH, REACH, SCAN),
            prediction.space.low[j],
            prediction.space.high[j],
        )
        costs = loss.cost(finite(prediction.error_table(table)))
        i = int(np.argmin(costs))
        if costs[i] < best.cost:
            again = descent(prediction, table[i], loss, evaluations=POLISH)
            best = again if again.cost < best.cost else best
    return best


def _promising(draft: Prediction, centre: np.ndarray, count: int, loss: Loss, seed: int) -> list[np.ndarray]:
    """The best `count` of many points around a centre, not too near to each other."""
    from scipy.special import ndtri
    from scipy.stats import qmc

    spread = np.array([each.spread for each in draft.space.coordinates])
    with warnings.catch_warnings():  # a number that is no power of two balances the sequence less well, no more
        warnings.simplefilter("ignore")
        points = qmc.Sobol(len(centre), rng=seed).random(max(64, SCREENED * count))
    normal = ndtri(np.clip(points, 1e-6, 1 - 1e-6))
    table = np.clip(centre + spread * normal, draft.space.low, draft.space.high)
    costs = loss.cost(finite(draft.error_table(table)))
    order = np.argsort(costs, kind="stable")
    chosen: list[int] = []
    for least in (1.0, 0.0):  # first those that are apart, then any
        for i in order:
            apart = all(np.linalg.norm(normal[i] - normal[j]) > least for j in chosen)
            if len(chosen) < count and i not in chosen and apart:
                chosen.append(int(i))
    return [table[i] for i in chosen]
