"""A mode of several contacts that is tried: its forces, accelerations and loads, one linear problem, see `decision.py`.

Contacts at imposed distances answer alike (rows of A are the same): they rest together only if their accelerations free
of friction are the same. A little more on the diagonal keeps them apart, and divides the one force that they hold then.
"""

from vibrocap.numerics.kernel.generated.facts import DYNAMIC, SHARED
from vibrocap.numerics.kernel.generated.places import WORK
from vibrocap.numerics.kernel.generated.sizes import CONTACTS, STATES

SOFTNESS = 1e-12  # of the largest entry of A: added to the diagonal for contacts at imposed distances

# Places in the work space: a state; b, A, n, seven numbers of each contact, and where loads follow the motion C, as
# `contact_rows` writes them.
FREE_ROWS = WORK + STATES
SLOWING = FREE_ROWS + CONTACTS
LOAD_ROWS = SLOWING + CONTACTS * CONTACTS
LEVELS = LOAD_ROWS + CONTACTS
LEVEL_COUNT = 7
SLIDING, APPLIED, APPLIED_AT_REST, LEAST_STICKING, MOST_STICKING, LEAST_KINETIC, MOST_KINETIC = 0, 1, 2, 3, 4, 5, 6
RAISED_ROWS = LEVELS + LEVEL_COUNT * CONTACTS
MATRIX_ROWS = RAISED_ROWS + CONTACTS * CONTACTS  # with the right-hand side
FORCES = MATRIX_ROWS + CONTACTS * (CONTACTS + 1)
ACCELERATIONS = FORCES + CONTACTS
NORMALS = ACCELERATIONS + CONTACTS
TRIED = NORMALS + CONTACTS  # side of each contact in the mode that is tried
AT_REST = TRIED + CONTACTS  # 1: it is asked
GAVE = AT_REST + CONTACTS  # 1: it has given way
OPEN_FORCES = GAVE + CONTACTS  # 1: the forces alone do not decide
OPEN_GROUP = OPEN_FORCES + CONTACTS  # of each group, 1: one of it is to be asked
CONSISTENT_SIDE = OPEN_GROUP + CONTACTS
CONSISTENT_ACCELERATION = CONSISTENT_SIDE + CONTACTS
KNOWN_SIZE = CONSISTENT_ACCELERATION + CONTACTS  # sum of the sizes of what accelerates a contact but unknown forces
OPEN = KNOWN_SIZE + CONTACTS  # numbers of the contacts of the problem
UNKNOWN = OPEN + CONTACTS  # of those whose forces are unknown in the mode that is tried
LARGEST_SIZE = UNKNOWN + CONTACTS  # largest sum of all that accelerates one of them: its rounding is a share of that


def sticking_range(floats, c):
    """(least, most) that a contact at rest may take, under the load of the mode that is tried."""
    levels = LEVELS + LEVEL_COUNT * c
    least, most = floats[levels + LEAST_STICKING], floats[levels + MOST_STICKING]
    if floats[GAVE + c] == 1.0:
        least, most = floats[levels + LEAST_KINETIC], floats[levels + MOST_KINETIC]
    applied = floats[levels + APPLIED_AT_REST]
    return least * floats[NORMALS + c] - applied, most * floats[NORMALS + c] - applied


def find_forces(floats, count):
    """Write the forces, accelerations and loads of the mode that is tried.

    The force of a contact that slides is known where loads are constant; one linear problem gives all others.
    """
    unknown = 0
    for i in range(count):
        c = int(floats[OPEN + i])
        if DYNAMIC or rests(floats, c):
            floats[UNKNOWN + unknown] = floats[OPEN + i]
            unknown += 1
        else:
            level, applied = sliding_force(floats, c)
            floats[FORCES + c] = level * floats[LOAD_ROWS + c] - applied
    for i in range(unknown):
        write_row(floats, i, unknown, count)
    eliminate(floats, unknown)
    largest = 0.0
    for i in range(count):
        c = int(floats[OPEN + i])
        acceleration = floats[FREE_ROWS + c]
        normal = floats[LOAD_ROWS + c]
        size = floats[KNOWN_SIZE + c]
        for k in range(count):
            j = int(floats[OPEN + k])
            term = floats[SLOWING + c * CONTACTS + j] * floats[FORCES + j]
            acceleration -= term
            size += abs(term)
            if DYNAMIC:
                normal -= floats[RAISED_ROWS + c * CONTACTS + j] * floats[FORCES + j]
        floats[ACCELERATIONS + c] = acceleration
        floats[NORMALS + c] = normal
        largest = max(largest, size)
    floats[LARGEST_SIZE] = largest


def rests(floats, c):
    """Whether a contact rests in the mode that is tried."""
    return floats[AT_REST + c] == 1.0 and floats[TRIED + c] == 0.0


def sliding_force(floats, c):
    """(force over load, what pushes it besides) of a contact that slides in the mode that is tried."""
    levels = LEVELS + LEVEL_COUNT * c
    if floats[AT_REST + c] != 1.0:
        return floats[levels + SLIDING], floats[levels + APPLIED]
    first = LEAST_KINETIC if floats[GAVE + c] == 1.0 else LEAST_STICKING
    return floats[levels + first + (1 if floats[TRIED + c] > 0.0 else 0)], floats[levels + APPLIED_AT_REST]


def write_row(floats, i, unknown, count):
    """Write row i of the linear problem for so many unknown forces."""
    row, c = MATRIX_ROWS + i * (CONTACTS + 1), int(floats[UNKNOWN + i])
    if not rests(floats, c):
        level, applied = sliding_force(floats, c)
        for k in range(unknown):
            floats[row + k] = level * floats[RAISED_ROWS + c * CONTACTS + int(floats[UNKNOWN + k])]
        floats[row + i] += 1.0
        floats[row + CONTACTS] = level * floats[LOAD_ROWS + c] - applied
        return
    known = floats[FREE_ROWS + c]
    if unknown < count:
        for k in range(count):
            j = int(floats[OPEN + k])
            if not rests(floats, j):
                known -= floats[SLOWING + c * CONTACTS + j] * floats[FORCES + j]
    for k in range(unknown):
        floats[row + k] = floats[SLOWING + c * CONTACTS + int(floats[UNKNOWN + k])]
    if SHARED and unknown > 1:
        largest, widest = 0.0, 0.0
        for k in range(count):
            j = int(floats[OPEN + k])
            largest = max(largest, abs(floats[SLOWING + j * CONTACTS + j]))
            widest = max(widest, half_width(floats, j))
        floats[row + i] += SOFTNESS * largest * (widest / (half_width(floats, c) + SOFTNESS * widest))
    floats[row + CONTACTS] = known


def half_width(floats, c):
    """Of the forces that a contact can hold, with a little more so that one which holds nothing has a share."""
    levels = LEVELS + LEVEL_COUNT * c
    return 0.5 * (floats[levels + MOST_STICKING] - floats[levels + LEAST_STICKING]) + 1e-150


def eliminate(floats, unknown):
    """Solve the linear problem in the work space for forces, by elimination with the largest pivot of each column."""
    width = CONTACTS + 1
    for i in range(unknown):
        best = i
        for j in range(i + 1, unknown):
            if abs(floats[MATRIX_ROWS + j * width + i]) > abs(floats[MATRIX_ROWS + best * width + i]):
                best = j
        if best != i:
            for k in range(width):
                kept = floats[MATRIX_ROWS + i * width + k]
                floats[MATRIX_ROWS + i * width + k] = floats[MATRIX_ROWS + best * width + k]
                floats[MATRIX_ROWS + best * width + k] = kept
        for j in range(i + 1, unknown):
            factor = floats[MATRIX_ROWS + j * width + i] / floats[MATRIX_ROWS + i * width + i]
            if factor != 0.0:
                for k in range(i, unknown):
                    floats[MATRIX_ROWS + j * width + k] -= factor * floats[MATRIX_ROWS + i * width + k]
                floats[MATRIX_ROWS + j * width + CONTACTS] -= factor * floats[MATRIX_ROWS + i * width + CONTACTS]
    for i in range(unknown - 1, -1, -1):
        value = floats[MATRIX_ROWS + i * width + CONTACTS]
        for k in range(i + 1, unknown):
            value -= floats[MATRIX_ROWS + i * width + k] * floats[FORCES + int(floats[UNKNOWN + k])]
        floats[FORCES + int(floats[UNKNOWN + i])] = value / floats[MATRIX_ROWS + i * width + i]
