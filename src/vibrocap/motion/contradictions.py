"""Why a balance of a motion does not close: its equations contradict one another, or it is no motion of them."""

from collections.abc import Sequence

import numpy as np

from vibrocap.motion.trajectory import Trajectory
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression, derivative, evaluated
from vibrocap.physics.flow import CONTACT_CHANNELS
from vibrocap.physics.names import name_and_number

INCONSISTENT = 1e-9  # of the powers: more than rounding leaves of a balance that holds


def at_starts(motion: Trajectory) -> tuple:
    """(states, drive) at the starts of all pieces."""
    start = np.arange(len(motion.piece_start))
    return motion.series.numbers[:, : len(motion.state_names)].T, motion.drive_at(start, 0.0 * motion.piece_length)


def unbalanced(field: str, value: float, bound: float, contradiction: str, tolerance: float) -> str:
    """A balance that does not close, and what that probably means."""
    what = field.removesuffix("_residual")
    words = f"the balance of {what} is off by {value:.2g}, where {bound:.2g} is the bound: "
    if contradiction:
        return words + contradiction
    return words + (
        f"the equations are in balance, the motion is not, so that its works and impulse are not to be trusted; the "
        f"tolerance {tolerance:.1e} is too loose for a law as stiff as this"
    )


def energy_contradiction(motion: Trajectory, recording: Equations) -> str:
    """What of a system's energies and powers contradicts its rates, in words; empty where nothing does."""
    known, machine, contact = recording.observables, [], []
    for name, power in zip(recording.channels, recording.powers, strict=True):
        (contact if name_and_number(name)[0] in CONTACT_CHANNELS else machine).append(power)
    taken = [contact.friction * contact.velocity for contact in recording.contacts]
    problem = _contradiction(motion, recording, known["energy"], [*machine, *(-power for power in taken)])
    if problem:
        return f"`energy` and `powers` of the machine contradict its `rates`: {problem}"
    problem = _contradiction(motion, recording, known["contact_energy"], [*contact, *taken])
    if problem:
        return f"`losses` and `stored_energy` of the law contradict its `force`: {problem}"
    return ""


def momentum_contradiction(motion: Trajectory, recording: Equations) -> str:
    """What of a machine's momentum contradicts its rates, in words; empty where nothing does."""
    known = recording.observables
    outer = [known["outer_force"]] if "outer_force" in known else []
    taken = [-contact.friction for contact in recording.contacts]
    problem = _contradiction(motion, recording, known["momentum"], [*outer, *taken])
    return f"`momentum` of the machine contradicts its `rates`: {problem}" if problem else ""


def _contradiction(motion: Trajectory, recording: Equations, stored: Expression, inflows: Sequence[Expression]) -> str:
    """Where the rate of what is stored is not the sum of what flows in, at the starts of the pieces; empty: nowhere."""
    terms = [derivative(stored, i) * rate for i, rate in enumerate(recording.rates)]
    terms += [derivative(stored, -1), *(-inflow for inflow in inflows)]
    states, (local, parameters) = at_starts(motion)
    sides = tuple(motion.piece_sides.T)
    values = evaluated(terms, local, states, sides, parameters, local.shape)
    gap, size = np.abs(np.sum(values, axis=0)), np.sum(np.abs(values), axis=0)
    worst = int(np.argmax(gap - INCONSISTENT * size))
    if not gap[worst] > INCONSISTENT * size[worst]:
        return ""
    change = float(np.sum(values[: -len(inflows)], axis=0)[worst])
    inflow = -float(np.sum(values[-len(inflows) :], axis=0)[worst])
    return f"at time {motion.piece_start[worst]:.6g} it changes at the rate {change:.6g}, while {inflow:.6g} flows in"
