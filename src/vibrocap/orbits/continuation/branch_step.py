"""The next point of a branch: how far to go, and what to make of it where Newton's method does not get there."""

import numpy as np

from vibrocap.orbits.continuation.branch_end import BranchEnd
from vibrocap.orbits.continuation.branch_point import BranchPoint, corrected, tangent
from vibrocap.orbits.continuation.corner import around_corner
from vibrocap.orbits.maps.closing_map import Closing, Closure
from vibrocap.orbits.maps.itinerary import same_cycle

SMALLEST = 1e-10  # step below which a branch counts as ended
STRAIGHT = 0.9  # cosine of the turn of the tangent over a step
SHORT = 1e-4  # share of the largest step from which on a kink is taken for what it is
OFF = 0.3  # share of a step by which a point may be off the guess
CORNER = 1e-2  # share of the largest step from which on a corner is looked for
QUICK = 3  # steps of Newton's method after which the next step may be longer


def next_point(
    closure: Closure, here: BranchPoint, ds: float, longest: float
) -> tuple[BranchPoint | None, float, BranchEnd]:
    """(next point, length of the step after it, why there is none)."""
    trial: Closing | None = None
    while ds >= SMALLEST:
        normal, length = here.tangent, ds
        guess = here.x + length * here.tangent
        bounded = not 0.0 <= guess[-1] <= 1.0
        if bounded:
            bound = float(guess[-1] > 1.0)
            length = (bound - here.x[-1]) / here.tangent[-1]
            guess = here.x + length * here.tangent
            guess[-1] = bound
            normal = np.zeros(len(guess))
            normal[-1] = 1.0
        found, steps = corrected(closure, guess, normal, float(normal @ guess), here.closing)
        if found is not None and -1e-12 <= found.x[-1] <= 1.0 + 1e-12:
            towards = found.x - here.x
            new = BranchPoint(found, tangent(found, towards / np.linalg.norm(towards)))
            short = ds <= SHORT * longest
            straight = float(new.tangent @ here.tangent) >= STRAIGHT or short
            near = float(np.linalg.norm(found.x - guess)) <= (1.0 if short else OFF) * length
            if straight and near and towards @ here.tangent > 0.0:
                longer = 1.5 * ds if steps <= QUICK else ds
                return new, (ds if bounded else min(longer, longest)), BranchEnd.PARAMETER_BOUND
        trial = closure.attempt(here.x + ds * here.tangent, here.closing)
        if ds <= CORNER * longest and not same_cycle(trial.word, here.closing.word):
            turned = around_corner(closure, here, trial, ds)
            if turned is not None:
                return turned, float(np.linalg.norm(turned.x - here.x)), BranchEnd.PARAMETER_BOUND
        ds *= 0.4
    changed = trial is not None and not same_cycle(trial.word, here.closing.word)
    return None, ds, BranchEnd.ORBIT_CEASES if changed else BranchEnd.NEWTON_FAILED
