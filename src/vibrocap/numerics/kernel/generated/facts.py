"""What is known of the equations of one system: constants, so that what they rule out is not compiled."""

SET_VALUED = True  # whether the contact can stick
KINKED = False  # whether the law has a kink at rest
MAYBE_STIFF = False  # whether a contact has a law with a force for every velocity
SEVERAL = False  # whether there are several contacts
LIMIT_CONSTANT = True  # whether the largest holding force never changes along a motion
SHARP = True  # whether the law has functions that could hide within a step, see `resolution.py`
MIRRORED = True  # whether these are the same for either direction of sliding
VELOCITY_JUMPS = False  # whether the contact velocity jumps where the drive has a corner
FOLLOWS_LOAD = False  # whether the load of the contact follows the motion
SPARSE = False  # whether the law hides near rest: three terms in four of a series may vanish, or it has a logarithm
ROUGH = False  # whether a law that sticks has a power of the speed that has no Taylor series at rest
GAPS = False  # whether most terms of a series from rest vanish: the law has a power of the speed from the third on
SHARP_INTERNAL = False  # whether any of them depends on an internal state
WATCHED = False  # whether the true load of the contact is looked at, which friction takes as constant
CYCLIC = 2  # the state on which nothing depends
TURN_COUNT = 0  # coordinates that turn, on which everything depends with a period
TURN_STATES = (-1,)  # which states they are
TURN_RADII = (1.0,)  # their periods over 2 pi
CONTACT_STATE = 3  # the state that moves one to one with the contact velocity
MIRROR = (-1,)  # sign of each state under the half-period symmetry
STICKS = (1,)  # of each contact: 1 where it can stick
KINKS = (0,)  # of each contact: 1 where it has a force for every velocity, with a kink at rest
STATE_OF = (3,)  # of each contact: the state that moves one to one with its velocity
SHARED = False  # whether some share one state, as their distances are imposed
DYNAMIC = False  # whether the loads of several contacts follow the motion
ROW_LIKE = (0,)  # of each of several contacts: the first one whose row of A is the same
