"""Several contacts at rest at one instant: which of them stay, and which slide to which side? One decision for all.

Friction accelerates the contacts and, where loads follow the motion, changes the loads (`physics/contacts.py`):

    a = b - A R,     N = n - C R

A contact at rest stays (a = 0, R within what it can hold) or slides to the side of its acceleration with the largest
force of that side: a linear complementarity problem with bounds (Pfeiffer and Glocker 1996; Acary and Brogliato 2008,
ch. 8). A is positive semidefinite, so that with constant loads a solution exists and the accelerations are unique; it
is found by pivoting on the contact of least number that does not fit (Murty 1974), from all at rest; but most often
contacts that come to rest slide on through it, so this is tried first. Under loads that friction makes there may be
several solutions or none: all modes are tried.

A contact gives way at the largest force that it can hold; only then does friction fall to that of the slowest slide. So
the problem is solved again for those that gave way until no other one does; where some pass through rest and others
were there before, those that pass give way first. The problem is that of the contacts at rest that are to be asked, and
of those on which these act (`GROUP`); friction of contacts that slide is known where loads are constant, else unknown.

What is too near a limit to be decided by forces alone is left at rest, TIED: then the series of the force that holds it
decides, see `contact.decide`. So it is of all that rest together at imposed distances, each with a share of one force:
they answer alike (rows of A are the same), and a little more on its diagonal keeps them apart. Where their distances
begin to change they part: small accelerations to the sides to which the first coefficients of their velocities move
them decide who stays.
"""

from vibrocap.numerics.kernel.codes import AMBIGUOUS_CONTACTS, BEYOND_BOUND, UNDECIDED
from vibrocap.numerics.kernel.events.transitions import MODE_HOLDS, TIED, give_way, is_open
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.step.taylor import write_state

UNDECIDED_SHARE = 1e-9  # of forces and of accelerations: what is nearer to a limit, or to none, is left to the series
FITTING = 1e-11  # of them: what is within while pivoting
SOFTNESS = 1e-12  # of the largest entry of A: added to the diagonal for contacts at imposed distances
PARTING = 1e-4  # of what contacts at imposed distances hold: accelerates those that part
MOST_TRIED = 6  # contacts at rest of which all modes are tried
MOST_PIVOTS = 20  # per contact
NONE_FITS, ONE_FITS, SEVERAL_FIT = 0, 1, 2
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


def decide_together(floats, ints, lane):
    """Decide the sides of all contacts that are to be asked, and of those at rest on which they act."""
    write_state(floats, lane, WORK)
    contact_rows(floats, lane.time, WORK, lane, FREE_ROWS)
    count = pose(floats, ints, lane)
    for _ in range(CONTACTS + 1):
        fits = solve_modes(floats, count)
        if fits != ONE_FITS:
            lane.status = BEYOND_BOUND + AMBIGUOUS_CONTACTS if DYNAMIC else UNDECIDED
            return
        passing = 0.0
        giving = 0.0
        for i in range(count):
            c = int(floats[OPEN + i])
            if floats[AT_REST + c] == 1.0 and floats[GAVE + c] == 0.0 and floats[TRIED + c] != 0.0:
                giving += 1.0
                if lane.came_from[c] != 0.0:
                    passing += 1.0
        if giving == 0.0 or count == 1:  # alone, it slides on the more when friction falls
            break
        for i in range(count):
            c = int(floats[OPEN + i])
            first = passing == 0.0 or lane.came_from[c] != 0.0
            if floats[AT_REST + c] == 1.0 and floats[TRIED + c] != 0.0 and first:
                floats[GAVE + c] = 1.0
    for i in range(count):
        c = int(floats[OPEN + i])
        if floats[AT_REST + c] == 1.0:
            if floats[OPEN_FORCES + c] == 1.0:
                lane.transition[c] = TIED
                continue
            vanishing = max(TIED - lane.transition[c], 1)
            lane.came_from[c] = 0.0
            lane.transition[c] = MODE_HOLDS
            if floats[TRIED + c] != 0.0:
                give_way(floats, ints, lane, c, floats[TRIED + c], vanishing)


def pose(floats, ints, lane):
    """List the contacts of the problem, with what of their accelerations is known in every mode; how many."""
    for c in range(CONTACTS):
        floats[OPEN_GROUP + c] = 0.0
        if is_open(ints, lane, c):
            floats[OPEN_GROUP + GROUP[c]] = 1.0
    count = 0
    for c in range(CONTACTS):
        floats[TRIED + c] = lane.side[c]
        floats[GAVE + c] = float(lane.gave_way[c])
        floats[AT_REST + c] = 0.0
        floats[FORCES + c] = 0.0
        rests_now = STICKS[c] == 1 and floats[TRIED + c] == 0.0
        if (rests_now or DYNAMIC) and floats[OPEN_GROUP + GROUP[c]] == 1.0:
            floats[OPEN + count] = float(c)
            floats[AT_REST + c] = 1.0 if rests_now else 0.0
            if rests_now:
                floats[TRIED + c] = -lane.came_from[c]
            count += 1
        elif not rests_now:
            level, applied = sliding_force(floats, c)
            floats[FORCES + c] = level * floats[LOAD_ROWS + c] - applied
    for i in range(count):
        c = int(floats[OPEN + i])
        size = abs(floats[FREE_ROWS + c])
        if not DYNAMIC:
            for j in range(CONTACTS):
                term = floats[SLOWING + c * CONTACTS + j] * floats[FORCES + j]
                floats[FREE_ROWS + c] -= term
                size += abs(term)
        floats[KNOWN_SIZE + c] = size
    if SHARED:
        accelerate_parting(floats, ints, lane, count)
    return count


def accelerate_parting(floats, ints, lane, count):
    """Let contacts that part accelerate as the first coefficients of their velocities that do not vanish move them."""
    widest, fastest, first = 0.0, 0.0, ORDER
    for i in range(count):
        c = int(floats[OPEN + i])
        widest = max(widest, half_width(floats, c))
        if lane.transition[c] < TIED:
            first = min(first, TIED - lane.transition[c])
    for i in range(count):
        fastest = max(fastest, abs(floats[lane.velocity_row[int(floats[OPEN + i])] + first * LANES]))
    for i in range(count):
        c = int(floats[OPEN + i])
        if lane.transition[c] < TIED:
            floats[FREE_ROWS + c] += PARTING * widest * (floats[lane.velocity_row[c] + first * LANES] / fastest)


def solve_modes(floats, count):
    """Find the mode for those that have given way so far, and which of its sides the forces decide; how many fit."""
    fits = ONE_FITS if not DYNAMIC and pivot(floats, count) else try_all(floats, count)
    if fits != ONE_FITS:
        return fits
    faint = UNDECIDED_SHARE * floats[LARGEST_SIZE]
    for i in range(count):
        c = int(floats[OPEN + i])
        floats[OPEN_FORCES + c] = 0.0
        if floats[AT_REST + c] == 1.0:
            if floats[TRIED + c] != 0.0:
                if abs(floats[ACCELERATIONS + c]) <= faint:
                    floats[OPEN_FORCES + c] = 1.0
                    floats[TRIED + c] = 0.0
            else:
                least, most = sticking_range(floats, c)
                size = UNDECIDED_SHARE * (abs(least) + abs(most) + abs(floats[FORCES + c]))
                if SHARED or most - floats[FORCES + c] <= size or floats[FORCES + c] - least <= size:
                    floats[OPEN_FORCES + c] = 1.0
    return fits


def pivot(floats, count):
    """Find the mode of constant loads; did it end?

    The expected mode holds where it moves all that slide in it beyond doubt, as accelerations are unique. Else, from
    all at rest, the first contact that does not fit is changed.
    """
    expected = False
    for i in range(count):
        expected = expected or floats[TRIED + int(floats[OPEN + i])] != 0.0
    for _ in range(MOST_PIVOTS * count):
        find_forces(floats, count)
        misfit = first_misfit(floats, count, UNDECIDED_SHARE if expected else -FITTING)
        if misfit < 0:
            return True
        if expected:
            expected = False
            for i in range(count):
                floats[TRIED + int(floats[OPEN + i])] = 0.0
        elif floats[TRIED + misfit] != 0.0:
            floats[TRIED + misfit] = 0.0
        else:
            most = sticking_range(floats, misfit)[1]
            floats[TRIED + misfit] = 1.0 if floats[FORCES + misfit] > most else -1.0
    return False


def first_misfit(floats, count, share):
    """The least number of a contact at rest that does not fit the mode that is tried; -1: all do.

    share: of the largest acceleration, which those that slide are to reach
    """
    least_speeding = share * floats[LARGEST_SIZE]
    for i in range(count):
        c = int(floats[OPEN + i])
        if floats[AT_REST + c] == 1.0:
            if floats[TRIED + c] != 0.0:
                if floats[TRIED + c] * floats[ACCELERATIONS + c] < least_speeding:
                    return c
            else:
                least, most = sticking_range(floats, c)
                size = FITTING * (abs(least) + abs(most) + abs(floats[FORCES + c]))
                if floats[FORCES + c] > most + size or floats[FORCES + c] < least - size:
                    return c
    return -1


def try_all(floats, count):
    """Find the mode by trying all: NONE_FITS, ONE_FITS, or SEVERAL_FIT with other accelerations.

    One under which a load would be negative counts only where no other fits: the machine lifts off there.
    """
    modes = 1
    resting = 0
    for i in range(count):
        if floats[AT_REST + int(floats[OPEN + i])] == 1.0:
            resting += 1
            modes *= 3
    if resting > MOST_TRIED:
        return NONE_FITS
    for lifting in range(2):
        consistent = 0
        for number in range(modes):
            rest = number
            for i in range(count):
                c = int(floats[OPEN + i])
                if floats[AT_REST + c] == 1.0:
                    floats[TRIED + c] = float(rest % 3)
                    if rest % 3 == 2:
                        floats[TRIED + c] = -1.0
                    rest = rest // 3
            find_forces(floats, count)
            if first_misfit(floats, count, -FITTING) >= 0 or (lifting == 0 and not presses(floats, count)):
                continue
            if consistent == 0:
                consistent = 1
                for i in range(count):
                    c = int(floats[OPEN + i])
                    floats[CONSISTENT_SIDE + c] = floats[TRIED + c]
                    floats[CONSISTENT_ACCELERATION + c] = floats[ACCELERATIONS + c]
            elif differs(floats, count):
                return SEVERAL_FIT
        if consistent == 1:
            for i in range(count):
                c = int(floats[OPEN + i])
                floats[TRIED + c] = floats[CONSISTENT_SIDE + c]
            find_forces(floats, count)
            return ONE_FITS
    return NONE_FITS


def presses(floats, count):
    """Whether all loads of the mode that is tried are positive."""
    least = floats[NORMALS + int(floats[OPEN])]
    for i in range(1, count):
        least = min(least, floats[NORMALS + int(floats[OPEN + i])])
    return least > 0.0


def differs(floats, count):
    """Whether the mode that is tried accelerates the contacts otherwise than the one that was found."""
    largest = 0.0
    for i in range(count):
        c = int(floats[OPEN + i])
        largest = max(largest, abs(floats[ACCELERATIONS + c] - floats[CONSISTENT_ACCELERATION + c]))
    return largest > UNDECIDED_SHARE * floats[LARGEST_SIZE]


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
                one, other = MATRIX_ROWS + i * width + k, MATRIX_ROWS + best * width + k
                floats[one], floats[other] = floats[other], floats[one]
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
