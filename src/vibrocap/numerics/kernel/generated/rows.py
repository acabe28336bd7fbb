"""First coefficients of rows of the series, besides those of the states, and places among what is integrated."""

GUARD = 0  # a work row of the event search
VELOCITY_OF = (0,)  # of each contact
HOLD_OF = LIMIT_OF = (0,)  # of each: the force that would hold it, and the largest one that can (both to ORDER - 1)
SHIFT = 0  # what all velocities are ahead of the state that they share, see `shifts`
SHIFTS = 0  # how many these are
REACTION = 0  # the first of the true loads that are watched (to ORDER - 2)
FRICTION = 0  # place of R among the functions of the instant that are gathered
