"""First coefficients of rows of the series, besides those of the states, and places among what is integrated."""

VELOCITY = 0  # of the contact
HOLD = LIMIT = 0  # the force that would hold the contact, and the largest holding force (both to ORDER - 1)
GUARD = 0  # a work row of the event search
VELOCITY_OF = (0,)  # of each contact
HOLD_OF = LIMIT_OF = (0,)  # of each contact that can stick
IMPOSED = 0  # velocities of further contacts that are no states (to ORDER)
SHIFT = 0  # what all velocities are ahead of the state that they share, see `shifts`
SHIFTS = 0  # how many these are
REACTION = 0  # the true load of the contact (to ORDER - 2), where it is watched
FRICTION = 0  # place of R among the functions of the instant that are gathered
