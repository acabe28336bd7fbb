"""Following a state of steady sliding over a parameter by its arclength, with the eigenvalues matched along the way."""

import dataclasses

import numpy as np

from vibrocap.orbits.equilibria.search import STANDS
from vibrocap.orbits.equilibria.steady_equations import Mode
from vibrocap.results import Advised

MOST_CORRECTIONS = 12
SMALLEST = 1e-9  # step, in natural sizes and shares of the range, below which nothing is told apart
STRAIGHT = 0.95  # cosine of the turn of the tangent over a step
BENT = 0.1  # of an eigenvalue, by which it may leave the straight line amid a step
LONGEST = 0.02  # share of the range, and of the size of the states


class EquilibriumEnd(Advised):
    """Why a branch of equilibria was not followed further; `advice` says what to try."""

    PARAMETER_BOUND = "parameter bound", "The end of the range asked for."
    REST = "contact comes to rest", "The sliding velocity of a contact vanishes: beyond it sticks or slides back."
    OTHER_BRANCH = "other branch of the equations", "A stop is met or left, or a law changes its piece; look beyond it."
    NO_LOAD = "load vanishes", "The machine would lift off, or its load does not follow from the forces any more."
    CLOSED = "closed", "The branch has come back to its start."
    NEWTON_FAILED = "Newton failed", "No next state is found, however small the step: start beyond this parameter."
    TOO_MANY_POINTS = "too many points", "Raise `points`."

    @property
    def early(self) -> bool:
        """Whether the branch continues, but was not followed so far."""
        return self in (EquilibriumEnd.NEWTON_FAILED, EquilibriumEnd.TOO_MANY_POINTS)


@dataclasses.dataclass(frozen=True, eq=False)
class Place:
    """A point of a branch: x, its unit tangent, its eigenvalues in an order that is kept along the branch."""

    x: np.ndarray
    tangent: np.ndarray
    eigenvalues: np.ndarray


def placed(mode: Mode, x: np.ndarray, towards: np.ndarray, like: np.ndarray | None = None) -> Place:
    """The place at a state, its tangent on the side of a vector, its eigenvalues matched with those of a neighbour."""
    derivative = mode.derivative(x)
    tangent = np.linalg.svd(_balanced(derivative)[0])[2][-1]
    tangent = tangent if tangent @ towards >= 0.0 else -tangent
    return Place(x, tangent, matched(np.linalg.eigvals(derivative[:, :-1]).astype(complex), like))


def matched(values: np.ndarray, like: np.ndarray | None) -> np.ndarray:
    """Eigenvalues in the order of a neighbour's to which they are nearest."""
    from scipy.optimize import linear_sum_assignment  # only here: it takes long to load

    if like is None:
        return values
    sizes = np.maximum(np.abs(values)[None], np.abs(like)[:, None])
    away = np.abs(values[None] - like[:, None]) / np.where(sizes > 0.0, sizes, 1.0)
    return values[linear_sum_assignment(away)[1]]


def _balanced(derivative: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(the derivative with rows of length 1, these lengths)."""
    rows = np.linalg.norm(derivative, axis=1)
    rows = np.where(rows > 0.0, rows, 1.0)
    return derivative / rows[:, None], rows


def corrected(mode: Mode, guess: np.ndarray, normal: np.ndarray) -> np.ndarray | None:
    """The state nearest to a guess in the plane across a vector; None where Newton's method leads to none."""
    x, last = guess, np.inf
    for _ in range(MOST_CORRECTIONS):
        values, derivative = mode.rates(x), mode.derivative(x)
        if not (np.all(np.isfinite(values)) and np.all(np.isfinite(derivative))):
            return None
        balanced, rows = _balanced(derivative)
        matrix = np.vstack((balanced, normal))
        step = np.linalg.lstsq(matrix, -np.append(values / rows, normal @ (x - guess)), rcond=1e-14)[0]
        x, size = x + step, float(np.max(np.abs(step)))
        if size <= 1e-15 * (1.0 + float(np.max(np.abs(x)))) or (size <= 1e-11 and size >= 0.5 * last):
            return x
        last = size
    return x if last <= 1e-11 else None


def limits(mode: Mode, x: np.ndarray) -> np.ndarray:
    """What is positive while the mode holds: speeds of sliding, guards of the branches, bounds of the equations."""
    recording, problem = mode.problem.recording, mode.problem
    velocities = mode.values(problem.velocities, x)
    sliding = [
        side * velocity / problem.sizes[each.state] - STANDS if each.kind != "smooth" else 1.0
        for side, velocity, each in zip(mode.sides, velocities, recording.contacts, strict=True)
    ]
    return np.concatenate((sliding, mode.values(recording.switches, x) + 1e-9, mode.values(recording.bounds, x)))


def followed(mode: Mode, start: Place, most: int) -> tuple[list[Place], EquilibriumEnd]:
    """Places of a branch from a start along its tangent, and why it ends.

    A step is accepted where the tangent hardly turns and where every eigenvalue amid it is nearly the mean of those at
    its ends, so that none of them passes the imaginary axis unseen.
    """
    places, ds = [start], 0.1 * LONGEST
    while len(places) < most:
        here = places[-1]
        q, onward = float(here.x[-1]), float(here.tangent[-1])
        if (q >= 1.0 - 1e-13 and onward > 0.0) or (q <= 1e-13 and onward < 0.0):
            return places, EquilibriumEnd.PARAMETER_BOUND
        new = _step(mode, here, ds)
        if new is None:
            ds *= 0.4
            if ds < SMALLEST:
                return places, EquilibriumEnd.NEWTON_FAILED
            continue
        fallen = np.flatnonzero(~(limits(mode, new.x) > 0.0))
        if fallen.size:
            end, kind = _at_limit(mode, here, new, int(fallen[0]))
            return [*places, end], kind
        places.append(new)
        if _returned(places):
            return places, EquilibriumEnd.CLOSED
        ds = min(2.0 * ds, LONGEST * (1.0 + float(np.max(np.abs(new.x)))))
    return places, EquilibriumEnd.TOO_MANY_POINTS


def _step(mode: Mode, here: Place, ds: float) -> Place | None:
    """The next place, not beyond the range; None where the step is too long."""
    guess, normal = here.x + ds * here.tangent, here.tangent
    if not 0.0 <= guess[-1] <= 1.0:
        bound = float(guess[-1] > 1.0)
        guess = here.x + (bound - here.x[-1]) / here.tangent[-1] * here.tangent
        guess[-1], normal = bound, np.eye(len(guess))[-1]
    found = corrected(mode, guess, normal)
    if found is None or np.linalg.norm(found - guess) > 0.3 * ds or not -1e-13 <= found[-1] <= 1.0 + 1e-13:
        return None
    new = placed(mode, found, found - here.x, here.eigenvalues)
    if new.tangent @ here.tangent < STRAIGHT:
        return None
    amid = between(mode, here, new, 0.5)
    if amid is None:
        return None
    middle, mean = matched(amid.eigenvalues, here.eigenvalues), 0.5 * (here.eigenvalues + new.eigenvalues)
    size = np.max(np.abs([here.eigenvalues, middle, new.eigenvalues]), axis=0)
    # What is rounding beside the largest eigenvalue is not resolved.
    floor = 1e-12 * float(np.max(size, initial=0.0))
    bent = np.abs(middle - mean) > BENT * size + floor
    return None if bent.any() and ds > 1e3 * SMALLEST else new


def between(mode: Mode, first: Place, last: Place, share: float) -> Place | None:
    """The place at a share of the way from one to another; None where Newton's method leads to none."""
    way = last.x - first.x
    found = corrected(mode, first.x + share * way, way / np.linalg.norm(way))
    return None if found is None else placed(mode, found, way, first.eigenvalues)


def _at_limit(mode: Mode, here: Place, beyond: Place, which: int) -> tuple[Place, EquilibriumEnd]:
    """The last place before one of the limits falls to zero, by bisection, and what it is."""
    low, high, found = 0.0, 1.0, here
    while high - low > 1e-14:
        share = 0.5 * (low + high)
        trial = between(mode, here, beyond, share)
        if trial is not None and np.all(limits(mode, trial.x) > 0.0):
            low, found = share, trial
        else:
            high = share
    contacts, switches = len(mode.sides), len(mode.problem.recording.switches)
    if which < contacts:
        return found, EquilibriumEnd.REST
    return found, EquilibriumEnd.OTHER_BRANCH if which < contacts + switches else EquilibriumEnd.NO_LOAD


def _returned(places: list[Place]) -> bool:
    """Whether the last step has passed the first place again."""
    if len(places) < 10:
        return False
    way, back = places[-1].x - places[-2].x, places[0].x - places[-2].x
    share = float(np.clip(back @ way / (way @ way), 0.0, 1.0))
    off = float(np.linalg.norm(share * way - back))
    return off <= 0.05 * float(np.linalg.norm(way)) and float(places[0].tangent @ places[-1].tangent) > STRAIGHT
