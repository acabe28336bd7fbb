"""Kinds of events: their names, and what happens at each.

A motion, a C library and an FMU name them alike, the command line says what they mean, and the kernel has numbers for
them (`numerics/kernel/codes.py`), in the order of `KINDS`; a machine of one's own may add names of its own.
"""

STICK, SLIP_FORWARD, SLIP_BACK, REVERSAL = "stick", "slip_forward", "slip_back", "reversal"
IMPACT, STOP_OPENED = "impact", "stop_opened"
LIFT_OFF, PARADOX, STOP_REACHED, AMBIGUOUS = "lift_off", "paradox", "stop_reached", "ambiguous_contacts"
RUNAWAY, SINGULAR_COMMAND, SINGULAR_PATH = "runaway", "singular_command", "singular_path"
SINGULAR_MASS_MATRIX = "singular_mass_matrix"

CONTACT = {
    STICK: "the contact comes to rest and sticks",
    SLIP_FORWARD: "the contact leaves stick forward",
    SLIP_BACK: "the contact leaves stick backward",
    REVERSAL: "the contact reverses without sticking",
}
TOUCHING = {
    "graze": "the contact touches its limit and stays",
    "switch": "the contact goes over to another piece of its law",
}
STOPS = {IMPACT: "a mass strikes a stop", STOP_OPENED: "a mass leaves a stop"}
ENDS = {  # at bounds of the equations, beyond which they do not hold
    LIFT_OFF: "the contact loses its load, which ends the run",
    STOP_REACHED: "the machine reaches a stop, which ends the run",
    PARADOX: "the contact has no load that follows from the forces",
    AMBIGUOUS: "which contacts rest is no longer certain",
    RUNAWAY: "the measurement of an unstable control loop runs away, which ends the run",
    SINGULAR_PATH: "the velocity of a contact no longer determines its coordinates, which ends the run",
    SINGULAR_MASS_MATRIX: "one motion of the machine moves no mass, which ends the run",
    SINGULAR_COMMAND: "no command gives the motion that the controller orders, which ends the run",
}
ADDED = {  # of an actuator and of a controller, counted where there is one
    "saturated": "the actuator reaches its limit",
    "unsaturated": "the actuator leaves its limit",
    "clipped": "the command reaches its limit",
    "unclipped": "the command comes back from its limit",
    "sample": "the controller samples, or its command acts",
    "command_saturated": "the command of the controller reaches its limit",
    "command_unsaturated": "the command of the controller leaves its limit",
}

# Where equations with a load that follows the motion cease to hold: the load vanishes, or no longer follows from the
# balance of forces, as friction and load raise one another without end (Painleve 1895).
SINGULAR = (SINGULAR_COMMAND, SINGULAR_PATH, SINGULAR_MASS_MATRIX)
BOUNDS = (PARADOX, LIFT_OFF, LIFT_OFF, STOP_REACHED, AMBIGUOUS, RUNAWAY, *SINGULAR)
LOCATED = (False, True, False, True, False, True, True, True, True)  # a located event, or looked at where a step starts

KINDS = (*CONTACT, *TOUCHING, *BOUNDS)
MEANINGS = CONTACT | TOUCHING | STOPS | ENDS
