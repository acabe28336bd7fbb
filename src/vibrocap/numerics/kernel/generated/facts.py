"""What is known of the equations of one system: constants, so that what they rule out is not compiled."""

MAYBE_STIFF = False  # whether a contact has a law with a force for every velocity
SEVERAL = False  # whether there are several contacts
LIMIT_CONSTANT = True  # whether the largest holding force never changes along a motion
SHARP = True  # whether the law has functions that could hide within a step, see `resolution.py`
VELOCITY_JUMPS = False  # whether the contact velocity jumps where the drive has a corner
FOLLOWS_LOAD = False  # whether the load of the contact follows the motion
LACUNARY = (
    False  # whether four terms hold a step from stick: a law has a whole power of the speed, or is one of several
)
ROUGH = (0,)  # of each contact: 1 where it can stick and its law has a power of the speed that is not whole
GAPS = False  # whether a law has a whole power of the speed from the third on, see `powers.py`
SHARP_INTERNAL = False  # whether any of them depends on an internal state, or on several contacts
SHARP_CONTACT = 0  # the contact on whose velocity they depend otherwise
WATCHED = 0  # true loads that are looked at, which friction takes as constant
CYCLIC = 2  # the state on which nothing depends
TURN_COUNT = 0  # coordinates that turn, on which everything depends with a period
TURN_STATES = (-1,)  # which states they are
TURN_RADII = (1.0,)  # their periods over 2 pi
RETURNING = False  # whether returns tell that a motion has settled
PLACE = 0  # the coordinate that is largest there, or has turned, where a motion returns that comes to rest nowhere
PLACE_TURN = 0.0  # its period, if it turns
MIRROR = (-1,)  # sign of each state under the half-period symmetry
STICKS = (1,)  # of each contact: 1 where it can stick
KINKS = (0,)  # of each contact: 1 where it has a force for every velocity, with a kink at rest
STATE_OF = (3,)  # of each contact: the state that moves one to one with its velocity
SHARED = False  # whether some share one state, as their distances are imposed
DYNAMIC = False  # whether the loads of several contacts follow the motion
GROUP = (0,)  # of each of several contacts: the first one of those that act on one another
ROW_LIKE = (0,)  # of each of several contacts: the first one whose row of A is the same
SLOWED = False  # whether bristles of a contact may be on a slow manifold, see `step/slow_manifold.py`
MANIFOLDS = 1  # number of slow manifolds
SLOW_CONTACT = (0,)  # of each: number of its contact
PAIR = False  # whether they are those of two states of one contact of a motion alone, which may be slaved together
SLOW_STATE: tuple[int, ...] = (-1,)  # of each: the state that is slaved; -1: there is none
