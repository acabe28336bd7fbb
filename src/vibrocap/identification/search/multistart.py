"""Search: the coordinates of least squares, from several starts, drafted on few samples and polished on all."""

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from vibrocap.identification.problem.prediction import Prediction
from vibrocap.identification.search.descent import COARSE_STOP, STOP, descent
from vibrocap.identification.search.loss import Loss, Minimum, finite

SCREENED = 32  # points looked at per start
SHORT, LONG, POLISH = 10, 40, 60  # evaluations of a first draft, of the best drafts and of the polish
CARRIED = 3  # drafts that are carried on
SCAN, SCAN_REACH, LOOKS = 41, 8.0, 5  # points of a scan, its reach in coarse steps, scans at most
SAME_COST = 1e-4  # relative difference of the costs of drafts that came to the same end
DAMPED, FARTHEST = 1e-9, 100.0  # of J^T J; of another coordinate's change along a valley


@dataclasses.dataclass(frozen=True, eq=False)
class Start:
    """One start of a multi-start search: where it began, the draft's end and its cost per sample."""

    u: np.ndarray
    end: np.ndarray
    cost: float

    in_record = "cost"


def search(
    prediction: Prediction,
    draft: Prediction,
    first: Sequence[np.ndarray],
    also: Sequence[np.ndarray] = (),
    *,
    starts: int,
    loss: Loss,
    seed: int,
    report: Callable[[float], Any],
) -> tuple[Minimum, tuple[Start, ...]]:
    """The best minimum from several starts: `first` and the best of random points around the last of them.

    Drafts run on `draft` (the same law and coordinates, fewer samples); the best is polished on `prediction`. So are
    those that began at `also`, the ends of simpler fits, unless they came to the same: what such a fit reaches is never
    missed.
    """
    ends = drafts(draft, first, also, starts=starts, loss=loss, seed=seed, report=report)
    stop = COARSE_STOP if any(coordinate.jumps for coordinate in prediction.space.coordinates) else STOP
    best, least = None, ends[0][0].cost
    for i, (end, begin) in enumerate(ends):
        if i == 0 or (any(begin is start for start in also) and end.cost > (1 + SAME_COST) * least):
            tried = _scanned(prediction, descent(prediction, end.u, loss, evaluations=POLISH, stop=stop), loss)
            best = tried if best is None or tried.cost < best.cost else best
            report(0.75)
    assert best is not None
    report(0.8)
    return best, tuple(Start(u, end.u, end.cost / draft.size) for end, u in ends)


def drafts(
    draft: Prediction,
    first: Sequence[np.ndarray],
    also: Sequence[np.ndarray] = (),
    *,
    starts: int,
    loss: Loss,
    seed: int,
    report: Callable[[float], Any] = lambda _: None,
) -> list[tuple[Minimum, np.ndarray]]:
    """Ends and begins of the local searches on thinned records, the best first; those from `also` come on top."""
    first = list(first)[:starts]
    begins = [np.clip(u, draft.space.low, draft.space.high) for u in first]
    if starts > len(begins):
        begins += _promising(draft, first[-1], starts - len(begins), loss, seed)
    begins += also
    report(0.05)
    minima: list[tuple[Minimum, np.ndarray]] = []
    for i, u in enumerate(begins):
        minima.append((descent(draft, u, loss, evaluations=SHORT, stop=1e-4), u))
        report(0.05 + 0.5 * (i + 1) / len(begins))
    minima.sort(key=lambda pair: pair[0].cost)
    for i, (end, u) in enumerate(minima):
        if i < CARRIED or any(u is start for start in also):
            minima[i] = (_scanned(draft, descent(draft, end.u, loss, evaluations=LONG, stop=1e-6), loss), u)
        report(0.55 + 0.15 * (i + 1) / len(minima))
    minima.sort(key=lambda pair: pair[0].cost)
    return minima


def _scanned(prediction: Prediction, best: Minimum, loss: Loss) -> Minimum:
    """The minimum, after looks along coordinates in which the force is not smooth: there a descent ends too soon.

    The others stay, or follow as the slopes say that they should; a lower point starts a new descent.
    """
    for j, coordinate in enumerate(prediction.space.coordinates):
        if not coordinate.jumps:
            continue
        for _ in range(LOOKS):
            moves = coordinate.step * np.linspace(-SCAN_REACH, SCAN_REACH, SCAN)[:, None]
            lines = [np.eye(len(best.u))[j], _valley(best, j)]
            table = np.concatenate([best.u + moves * line for line in lines])
            table = np.clip(table, prediction.space.low, prediction.space.high)
            costs = loss.cost(finite(prediction.error_table(table)))
            lowest = table[int(np.argmin(costs))]
            if not costs.min() < best.cost:
                break
            again = descent(prediction, lowest, loss, evaluations=POLISH, stop=COARSE_STOP)
            if not again.cost < best.cost:
                break
            best = again
    return best


def _valley(best: Minimum, j: int) -> np.ndarray:
    """How all coordinates change along the valley of the cost when coordinate j changes by 1, at most as much each."""
    line = np.linalg.solve(best.slopes.T @ best.slopes + DAMPED * np.eye(len(best.u)), np.eye(len(best.u))[j])
    return line / line[j] if line[j] > 0 and np.abs(line).max() <= line[j] * FARTHEST else np.eye(len(best.u))[j]


def _promising(draft: Prediction, centre: np.ndarray, count: int, loss: Loss, seed: int) -> list[np.ndarray]:
    """The best `count` of many points around a centre, not too near to each other."""
    spread = np.array([coordinate.spread for coordinate in draft.space.coordinates])
    normal = np.random.default_rng(seed).normal(size=(max(64, SCREENED * count), len(centre)))
    table = np.clip(centre + spread * normal, draft.space.low, draft.space.high)
    costs = loss.cost(finite(draft.error_table(table)))
    order = np.argsort(costs, kind="stable")
    kept: list[int] = []
    for least in (1.0, 0.0):  # first those that are apart, then any
        for i in order:
            apart = all(np.linalg.norm(normal[i] - normal[j]) > least for j in kept)
            if len(kept) < count and i not in kept and apart:
                kept.append(int(i))
    return [table[i] for i in kept]
