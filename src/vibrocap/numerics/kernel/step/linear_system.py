"""The linear systems of implicit equations: their place in the work space, and elimination."""

from vibrocap.numerics.kernel.generated.places import WORK
from vibrocap.numerics.kernel.generated.sizes import EVENT_WORK, STATES

STAGES = 8  # of the implicit step
WIDTH = STATES + 1
# Places in the work space, after that of the event search: the Jacobian outlives a search.
JACOBIAN = WORK + EVENT_WORK
MATRIX = JACOBIAN + STATES * WIDTH
STAGE = MATRIX + STATES * STATES
POINT = STAGE + STAGES * STATES
RATE = POINT + STATES
REFERENCE = RATE + STATES  # of velocities at imposed distances: number of the one that is followed, then all of them


def factorise(floats):
    """LU decomposition of the matrix in the work space, in place, without pivoting.

    1/(gamma h) dominates the diagonal for the steps that the error control takes; a vanishing pivot shows as a stage
    that is not finite, and the step is refused.
    """
    for j in range(STATES):
        pivot = 1.0 / floats[MATRIX + j * STATES + j]
        for i in range(j + 1, STATES):
            factor = floats[MATRIX + i * STATES + j] * pivot
            floats[MATRIX + i * STATES + j] = factor
            if factor != 0.0:
                for k in range(j + 1, STATES):
                    floats[MATRIX + i * STATES + k] -= factor * floats[MATRIX + j * STATES + k]


def solve(floats, start):
    """Solve for the right-hand side at floats[start:start + STATES], in place."""
    for i in range(STATES):
        for j in range(i):
            floats[start + i] -= floats[MATRIX + i * STATES + j] * floats[start + j]
    for i in range(STATES - 1, -1, -1):
        for j in range(i + 1, STATES):
            floats[start + i] -= floats[MATRIX + i * STATES + j] * floats[start + j]
        floats[start + i] /= floats[MATRIX + i * STATES + i]
