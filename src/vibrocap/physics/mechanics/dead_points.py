"""Dead points: where the mass matrix loses its rank, so that no acceleration follows from the forces.

    u^T M u = sum of m (x'^2 + z'^2) + J phi'^2

vanishes where some u lets every mass stand. A mass that surely moves with one coordinate, while those known before
stand, lets that one stand too. M is singular exactly where it is so on the coordinates that are left, the loose ones:
mostly none, so that nothing has to be watched. Of the others the pivots are.
"""

import itertools
from collections.abc import Iterator
from typing import Any

from vibrocap.physics import elementary
from vibrocap.physics.mechanics.sums import Sum, eliminate, total, written

DEAD = 1e-9  # of its largest terms, the inertia that is left: forces give accelerations that much larger
BOUNDED = ("sin", "cos", "tanh")  # functions that are at most 1


def loose(motion: Any) -> list[str]:
    """The coordinates that may move while every mass stands, in some state and for some parameters."""
    sure = [x for x, size in motion.moved if _is_positive(size, motion.inputs)]
    left = [*motion.names]

    def stands(name: str) -> bool:
        alone = (x.slope(name) for x in sure if [*filter(x.slope, left)] == [name])
        return _is_positive(total(slope * slope for slope in alone), motion.inputs)

    while standing := [*filter(stands, left)]:
        left = [name for name in left if name not in standing]
    return left


def _is_positive(x: Sum, inputs: Any) -> bool:
    """Whether a sum is surely positive: a positive number or parameter, and whatever else is not negative."""
    products = [product for product, c in x.terms.items() if c > 0.0]
    kept = all(n % 2 == 0 or atom in inputs.least for product in products for atom, n in product)
    positive = any(all(inputs.least.get(atom, 0.0) > 0.0 for atom, _ in product) for product in products)
    return len(products) == len(x.terms) and kept and positive


def pivots(motion: Any) -> Iterator[Any]:
    """What is positive until the mass matrix is singular: of each loose coordinate the inertia left, less `DEAD`."""
    names = [] if motion.imposes else loose(motion)
    rows = [[motion.inertia(i, j) for j in names] for i in names]
    largest = [_largest(rows[i][i], motion) for i in range(len(names))]
    eliminate(rows, len(names))
    for i, size in enumerate(largest):
        yield written(Sum.of(rows[i][i]) - DEAD * size)


def _largest(x: Sum, motion: Any) -> Sum:
    """Root of the sum of the squares of all terms, in which states and bounded functions count as one."""
    states = {*motion.inputs.states}
    squares = Sum()
    for product, c in x.terms.items():
        kept = ((atom, n) for atom, n in product if atom.op not in BOUNDED and atom not in states)
        term = Sum.of(c)
        for atom in itertools.chain.from_iterable(itertools.repeat(atom, n) for atom, n in kept):
            term = term * atom
        squares = squares + term * term
    return Sum.of(elementary.sqrt(squares))
