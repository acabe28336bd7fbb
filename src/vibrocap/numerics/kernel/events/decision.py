"""Several contacts at rest at one instant: which of them stay, and which slide to which side? One decision for all.

Friction accelerates the contacts and, where loads follow the motion, changes the loads (`physics/contacts.py`):

    a = b - A R,     N = n - C R

A contact at rest stays (a = 0, R within what it can hold) or slides to the side of its acceleration with the largest
force of that side: a linear complementarity problem with bounds (Pfeiffer and Glocker 1996; Acary and Brogliato 2008,
ch. 8). A is positive semidefinite, so that with constant loads a solution exists and the accelerations are unique; it
is found by pivoting on the contact of least number that does not fit (Murty 1974), from all at rest. Under loads that
friction makes there may be several solutions or none: all modes are tried.

A contact gives way at the largest force that it can hold; only then does friction fall to that of the slowest slide. So
the problem is solved again for those that gave way, with what they can hold then, until no other one does; where some
pass through rest and others were there before, those that pass give way first.

The problem is that of the contacts at rest that are to be asked, and of those at rest on which these act; friction of
contacts that slide is known where loads are constant, and else unknown as well. Contacts that do not act on one another
(`GROUP`) are decided apart.

Contacts at imposed distances answer alike (rows of A are the same): they rest together only if their accelerations free
of friction are the same, and then hold one force in equal shares of their limits. While pivoting, a little more on the
diagonal keeps them apart.

What is too near a limit to be decided by forces alone is left at rest, with TO_DECIDE = 2: then the series of the force
that holds it decides, see `contact.decide`.
"""

from vibrocap.numerics.kernel.codes import AMBIGUOUS_CONTACTS, BEYOND_BOUND, UNDECIDED
from vibrocap.numerics.kernel.generated.equations import contact_rows
from vibrocap.numerics.kernel.generated.facts import DYNAMIC, GROUP, ROW_LIKE, SHARED, STICKS
from vibrocap.numerics.kernel.generated.lane import (
    CAME_FROM,
    GAVE_WAY,
    SIDE,
    STATE,
    STATUS,
    TIME,
    TO_DECIDE,
    WORK,
    ZEROS,
)
from vibrocap.numerics.kernel.generated.sizes import CONTACTS, LANES, STATES

UNDECIDED_SHARE = 1e-9  # of forces and of accelerations: what is nearer to a limit, or to none, is left to the series
FITTING = 1e-11  # of them: what is within while pivoting
SOFTNESS = 1e-12  # of the largest entry of A: added to the diagonal while pivoting, for contacts at imposed distances
MOST_TRIED = 6  # contacts at rest of which all modes are tried
MOST_PIVOTS = 20  # per contact
NONE_FITS, ONE_FITS, SEVERAL_FIT = 0, 1, 2

# Places in the work space: a state; b, A, n, C and seven numbers of each contact, as `contact_rows` writes them.
FREE_ROWS = WORK + STATES
SLOWING = FREE_ROWS + CONTACTS
LOAD_ROWS = SLOWING + CONTACTS * CONTACTS
RAISED_ROWS = LOAD_ROWS + CONTACTS
HELD_LEVELS = RAISED_ROWS + CONTACTS * CONTACTS
LEVELS_EACH = 7
SLIDING, PUSHED, PUSHED_AT_REST, LEAST_HELD, MOST_HELD, LEAST_KINETIC, MOST_KINETIC = 0, 1, 2, 3, 4, 5, 6
MATRIX_ROWS = HELD_LEVELS + LEVELS_EACH * CONTACTS  # with the right-hand side
TAKEN = MATRIX_ROWS + CONTACTS * (CONTACTS + 1)
ACCELERATIONS = TAKEN + CONTACTS
NORMALS = ACCELERATIONS + CONTACTS
TRIED = NORMALS + CONTACTS  # side of each contact in the mode that is tried
AT_REST = TRIED + CONTACTS  # 1: it is asked
GAVE = AT_REST + CONTACTS  # 1: it has given way
TIED = GAVE + CONTACTS  # 1: the forces alone do not decide
FOUND_SIDE = TIED + CONTACTS
FOUND_ACCELERATION = FOUND_SIDE + CONTACTS
KNOWN_SIZE = FOUND_ACCELERATION + CONTACTS  # sum of the sizes of what accelerates a contact but unknown forces
OPEN = KNOWN_SIZE + CONTACTS  # numbers of the contacts of the problem
UNKNOWN = OPEN + CONTACTS  # of those whose forces are unknown in the mode that is tried
LARGEST_SIZE = UNKNOWN + CONTACTS  # largest sum of all that accelerates one of them: its rounding is a share of that


def decide_together(floats, ints, lane):
    """Decide the sides of all contacts that are to be asked, and of those at rest on which they act, at the lane's
    present state."""
    for i in range(STATES):
        floats[WORK + i] = floats[STATE + i * LANES + lane]
    contact_rows(floats, floats[TIME + lane], WORK, floats[SIDE + lane], lane, FREE_ROWS)
    count = pose(floats, ints, lane)
    for _ in range(CONTACTS + 1):
        fits = solve_modes(floats, count)
        if fits != ONE_FITS:
            ints[STATUS + lane] = BEYOND_BOUND + AMBIGUOUS_CONTACTS if DYNAMIC else UNDECIDED
            return
        passing = 0.0
        giving = 0.0
        for i in range(count):
            c = int(floats[OPEN + i])
            if floats[AT_REST + c] == 1.0 and floats[GAVE + c] == 0.0 and floats[TRIED + c] != 0.0:
                giving += 1.0
                if floats[CAME_FROM + c * LANES + lane] != 0.0:
                    passing += 1.0
        if giving == 0.0:
            break
        for i in range(count):
            c = int(floats[OPEN + i])
            first = passing == 0.0 or floats[CAME_FROM + c * LANES + lane] != 0.0
            if floats[AT_REST + c] == 1.0 and floats[TRIED + c] != 0.0 and first:
                floats[GAVE + c] = 1.0
    for i in range(count):
        c = int(floats[OPEN + i])
        if floats[AT_REST + c] == 1.0:
            ints[TO_DECIDE + c * LANES + lane] = 2 if floats[TIED + c] == 1.0 else 0
            if floats[TRIED + c] != 0.0:
                floats[SIDE + c * LANES + lane] = floats[TRIED + c]
                floats[CAME_FROM + c * LANES + lane] = 0.0
                ints[ZEROS + c * LANES + lane] = 1
                ints[GAVE_WAY + c * LANES + lane] = 1
            elif floats[TIED + c] == 0.0:
                floats[CAME_FROM + c * LANES + lane] = 0.0


def pose(floats, ints, lane):
    """List the contacts of the problem, with what of their accelerations is known in every mode; how many."""
    count = 0
    for c in range(CONTACTS):
        floats[TRIED + c] = floats[SIDE + c * LANES + lane]
        floats[GAVE + c] = float(ints[GAVE_WAY + c * LANES + lane])
        floats[AT_REST + c] = 0.0
        floats[TAKEN + c] = 0.0
        rests_now = STICKS[c] == 1 and floats[TRIED + c] == 0.0
        if (rests_now or DYNAMIC) and group_is_asked(ints, lane, c):
            floats[OPEN + count] = float(c)
            floats[AT_REST + c] = 1.0 if rests_now else 0.0
            count += 1
        elif not rests_now:
            level, pushed = sliding_force(floats, c)
            floats[TAKEN + c] = level * floats[LOAD_ROWS + c] - pushed
    for i in range(count):
        c = int(floats[OPEN + i])
        size = abs(floats[FREE_ROWS + c])
        if not DYNAMIC:
            for j in range(CONTACTS):
                term = floats[SLOWING + c * CONTACTS + j] * floats[TAKEN + j]
                floats[FREE_ROWS + c] -= term
                size += abs(term)
        floats[KNOWN_SIZE + c] = size
    return count


def group_is_asked(ints, lane, c):
    """Whether contact c or one of those that act on it is to be asked."""
    asked = False
    for d in range(CONTACTS):
        asked = asked or (GROUP[d] == GROUP[c] and ints[TO_DECIDE + d * LANES + lane] == 1)
    return asked


def solve_modes(floats, count):
    """Find the mode for those that have given way so far, and which of its sides the forces decide; how many fit."""
    if not DYNAMIC and pivot(floats, count):
        fits = ONE_FITS
    else:
        fits = try_all(floats, count)
    if fits != ONE_FITS:
        return fits
    faint = UNDECIDED_SHARE * floats[LARGEST_SIZE]
    for i in range(count):
        c = int(floats[OPEN + i])
        floats[TIED + c] = 0.0
        if floats[AT_REST + c] == 1.0:
            if floats[TRIED + c] != 0.0:
                if abs(floats[ACCELERATIONS + c]) <= faint:
                    floats[TIED + c] = 1.0
                    floats[TRIED + c] = 0.0
            else:
                least, most = held_between(floats, c)
                size = UNDECIDED_SHARE * (abs(least) + abs(most) + abs(floats[TAKEN + c]))
                if most - floats[TAKEN + c] <= size or floats[TAKEN + c] - least <= size:
                    floats[TIED + c] = 1.0
    return fits


def pivot(floats, count):
    """Find the mode of constant loads, from all at rest: the first contact that does not fit is changed; did it end?"""
    for i in range(count):
        floats[TRIED + int(floats[OPEN + i])] = 0.0
    for _ in range(MOST_PIVOTS * count):
        unknown = find_forces(floats, count, SHARED)
        misfit = first_misfit(floats, count)
        if misfit < 0:
            if SHARED and unknown > 1:
                find_forces(floats, count, False)
            return True
        if floats[TRIED + misfit] != 0.0:
            floats[TRIED + misfit] = 0.0
        else:
            most = held_between(floats, misfit)[1]
            floats[TRIED + misfit] = 1.0 if floats[TAKEN + misfit] > most else -1.0
    return False


def first_misfit(floats, count):
    """The least number of a contact at rest that does not fit the mode that is tried; -1: all do."""
    faint = FITTING * floats[LARGEST_SIZE]
    for i in range(count):
        c = int(floats[OPEN + i])
        if floats[AT_REST + c] == 1.0:
            if floats[TRIED + c] != 0.0:
                if floats[TRIED + c] * floats[ACCELERATIONS + c] < -faint:
                    return c
            else:
                least, most = held_between(floats, c)
                size = FITTING * (abs(least) + abs(most) + abs(floats[TAKEN + c]))
                if floats[TAKEN + c] > most + size or floats[TAKEN + c] < least - size:
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
        found = 0
        for number in range(modes):
            rest = number
            for i in range(count):
                c = int(floats[OPEN + i])
                if floats[AT_REST + c] == 1.0:
                    floats[TRIED + c] = float(rest % 3)
                    if rest % 3 == 2:
                        floats[TRIED + c] = -1.0
                    rest = rest // 3
            find_forces(floats, count, False)
            if first_misfit(floats, count) >= 0 or (lifting == 0 and not presses(floats, count)):
                continue
            if found == 0:
                found = 1
                for i in range(count):
                    c = int(floats[OPEN + i])
                    floats[FOUND_SIDE + c] = floats[TRIED + c]
                    floats[FOUND_ACCELERATION + c] = floats[ACCELERATIONS + c]
            elif differs(floats, count):
                return SEVERAL_FIT
        if found == 1:
            for i in range(count):
                c = int(floats[OPEN + i])
                floats[TRIED + c] = floats[FOUND_SIDE + c]
            find_forces(floats, count, False)
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
        largest = max(largest, abs(floats[ACCELERATIONS + c] - floats[FOUND_ACCELERATION + c]))
    return largest > UNDECIDED_SHARE * floats[LARGEST_SIZE]


def held_between(floats, c):
    """(least, most) that a contact at rest may take, under the load of the mode that is tried."""
    levels = HELD_LEVELS + LEVELS_EACH * c
    least, most = floats[levels + LEAST_HELD], floats[levels + MOST_HELD]
    if floats[GAVE + c] == 1.0:
        least, most = floats[levels + LEAST_KINETIC], floats[levels + MOST_KINETIC]
    pushed = floats[levels + PUSHED_AT_REST]
    return least * floats[NORMALS + c] - pushed, most * floats[NORMALS + c] - pushed


def find_forces(floats, count, soft):
    """Write the forces, accelerations and loads of the mode that is tried; how many forces were unknown.

    The force of a contact that slides is known where loads are constant; one linear problem gives all others.

    soft: with a little more on the diagonal of A, so that contacts at imposed distances differ; else those that rest
    together have equal shares of what they can hold
    """
    unknown = 0
    for i in range(count):
        c = int(floats[OPEN + i])
        if DYNAMIC or rests(floats, c):
            floats[UNKNOWN + unknown] = floats[OPEN + i]
            unknown += 1
        else:
            level, pushed = sliding_force(floats, c)
            floats[TAKEN + c] = level * floats[LOAD_ROWS + c] - pushed
    for i in range(unknown):
        write_row(floats, i, unknown, count, soft)
    eliminate(floats, unknown)
    largest = 0.0
    for i in range(count):
        c = int(floats[OPEN + i])
        acceleration = floats[FREE_ROWS + c]
        normal = floats[LOAD_ROWS + c]
        size = floats[KNOWN_SIZE + c]
        for k in range(count):
            j = int(floats[OPEN + k])
            term = floats[SLOWING + c * CONTACTS + j] * floats[TAKEN + j]
            acceleration -= term
            size += abs(term)
            if DYNAMIC:
                normal -= floats[RAISED_ROWS + c * CONTACTS + j] * floats[TAKEN + j]
        floats[ACCELERATIONS + c] = acceleration
        floats[NORMALS + c] = normal
        largest = max(largest, size)
    floats[LARGEST_SIZE] = largest
    return unknown


def rests(floats, c):
    """Whether a contact rests in the mode that is tried."""
    return floats[AT_REST + c] == 1.0 and floats[TRIED + c] == 0.0


def sliding_force(floats, c):
    """(force over load, what pushes it besides) of a contact that slides in the mode that is tried."""
    levels = HELD_LEVELS + LEVELS_EACH * c
    if floats[AT_REST + c] != 1.0:
        return floats[levels + SLIDING], floats[levels + PUSHED]
    first = LEAST_KINETIC if floats[GAVE + c] == 1.0 else LEAST_HELD
    return floats[levels + first + (1 if floats[TRIED + c] > 0.0 else 0)], floats[levels + PUSHED_AT_REST]


def write_row(floats, i, unknown, count, soft):
    """Write row i of the linear problem for so many unknown forces."""
    row, c = MATRIX_ROWS + i * (CONTACTS + 1), int(floats[UNKNOWN + i])
    if not rests(floats, c):
        level, pushed = sliding_force(floats, c)
        for k in range(unknown):
            floats[row + k] = level * floats[RAISED_ROWS + c * CONTACTS + int(floats[UNKNOWN + k])]
        floats[row + i] += 1.0
        floats[row + CONTACTS] = level * floats[LOAD_ROWS + c] - pushed
        return
    head = i
    if SHARED and not soft:
        for k in range(i - 1, -1, -1):
            other = int(floats[UNKNOWN + k])
            if rests(floats, other) and ROW_LIKE[other] == ROW_LIKE[c]:
                head = k
    if head != i:
        first = int(floats[UNKNOWN + head])
        own, other_width = half_width(floats, c), half_width(floats, first)
        for k in range(unknown):
            floats[row + k] = 0.0
        floats[row + i] = other_width
        floats[row + head] = -own
        floats[row + CONTACTS] = other_width * middle_taken(floats, c) - own * middle_taken(floats, first)
        return
    known = floats[FREE_ROWS + c]
    if unknown < count:
        for k in range(count):
            j = int(floats[OPEN + k])
            if not rests(floats, j):
                known -= floats[SLOWING + c * CONTACTS + j] * floats[TAKEN + j]
    for k in range(unknown):
        floats[row + k] = floats[SLOWING + c * CONTACTS + int(floats[UNKNOWN + k])]
    if soft and unknown > 1:
        largest, widest = 0.0, 0.0
        for k in range(count):
            j = int(floats[OPEN + k])
            largest = max(largest, abs(floats[SLOWING + j * CONTACTS + j]))
            widest = max(widest, half_width(floats, j))
        floats[row + i] += SOFTNESS * largest * (widest / (half_width(floats, c) + SOFTNESS * widest))
    floats[row + CONTACTS] = known


def half_width(floats, c):
    """Of the forces that a contact can hold, with a little more so that one which holds nothing has a share."""
    levels = HELD_LEVELS + LEVELS_EACH * c
    return 0.5 * (floats[levels + MOST_HELD] - floats[levels + LEAST_HELD]) + 1e-150


def middle_taken(floats, c):
    """Middle of what a contact takes at rest."""
    levels = HELD_LEVELS + LEVELS_EACH * c
    return 0.5 * (floats[levels + MOST_HELD] + floats[levels + LEAST_HELD]) - floats[levels + PUSHED_AT_REST]


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
            value -= floats[MATRIX_ROWS + i * width + k] * floats[TAKEN + int(floats[UNKNOWN + k])]
        floats[TAKEN + int(floats[UNKNOWN + i])] = value / floats[MATRIX_ROWS + i * width + i]
