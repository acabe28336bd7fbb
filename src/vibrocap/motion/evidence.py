"""What a certificate rests on, gathered from a motion: its steps, its contact, its balances and a second run."""

import math
from typing import Any

import numpy as np

from vibrocap.motion.certificate import Certificate
from vibrocap.motion.equations import equations, parameter_values
from vibrocap.motion.trajectory import Trajectory
from vibrocap.numerics.api import Recorded, memory
from vibrocap.numerics.expressions.graph import evaluate

POINTS = 9  # per piece at which a certificate looks
FINE = 65  # points per piece among which the slowest is looked for
PIECES_AT_A_TIME = 1000
# What a step leaves of the equations, over the tolerance: at most 500 in motions of all laws at tolerances from 1e-4 to
# 1e-14, from 1e3 to 1e5 where a law was stepped over. Below LEAST_DEFECT rounding decides.
DEFECT_BOUND, LEAST_DEFECT = 1e3, 1e-13
STICK_SLACK = 1e-9  # of the limit; a hold is left where its force is at the limit to rounding


def certificate(motion: Trajectory, recorded: Recorded, loose: Recorded, ratio_of_tolerances: float) -> Certificate:
    """Evidence for a motion, from points within every piece and from a second run whose tolerance is looser."""
    if not len(motion.piece_start):
        return Certificate(None, 0.0, True, 0.0, 0.0, 0.0, None, 0, 0, 0.0)
    parameters = parameter_values(motion.system)
    scales = np.asarray(evaluate(equations(motion.system).scales, 0.0, [], 1.0, parameters), float)
    defect = _defect(motion, scales)
    share = np.linspace(0.0, 1.0, POINTS)
    index = np.repeat(np.arange(len(motion.piece_start)), POINTS)
    s = np.tile(share, len(motion.piece_start)) * motion.piece_length[index]
    side = motion.piece_side[index]
    names = ("contact_velocity", "friction", "energy", "contact_energy", "momentum")
    velocity, friction, energy, contact_energy, momentum = motion.piece_observables(names, index, s)
    marks = motion.piece_marks  # integrals at the start of every piece and at the end
    stored = _at_marks(energy + contact_energy)
    balance = stored - stored[0] - marks[:-1].sum(axis=0)
    if motion.system.friction.switched:  # energy that was stored in the contact is lost where a piece begins unloaded
        before, after = (energy + contact_energy)[POINTS - 1 :: POINTS][:-1], stored[1:-1]
        balance[1:] -= np.cumsum(np.append(after - before, 0.0))
    impulse = _at_marks(momentum) - momentum[0] + marks[-1] - _outer_impulse(motion)
    stuck = side == 0
    ratio = None
    if motion.system.friction.kind == "set-valued":
        load = motion.system.machine.load()
        limit = float(motion.system.friction.holding_limit(load))
        largest = float(np.max(np.abs(friction[stuck] - motion.system.friction.holding_middle(load)), initial=0.0))
        ratio = largest / limit if limit > 0.0 else (0.0 if largest == 0.0 else math.inf)
    least = float(np.min((side * velocity)[~stuck], initial=0.0))
    slack = 64 * np.finfo(float).eps * max(1.0, float(np.max(np.abs(velocity), initial=0.0)))
    failures = []
    bound = DEFECT_BOUND * max(motion.tolerance, LEAST_DEFECT)
    if not defect <= bound:
        failures.append(f"the equations are left by {defect:.1e} within a step, where {bound:.1e} is the bound")
    if ratio is not None and not ratio <= 1.0 + STICK_SLACK:
        failures.append(f"the stuck contact carries {ratio:.9g} times what it can hold")
    if motion.system.friction.kind != "smooth" and not least >= -slack:
        failures.append(f"the velocity passes rest by {-least:.1e} without an event")
    return Certificate(
        stick_force_ratio=ratio,
        event_velocity=recorded.contact_residual,
        sign_kept=least >= -slack,
        least_velocity=least,
        energy_residual=float(np.max(np.abs(balance), initial=0.0)),
        momentum_residual=float(np.max(np.abs(impulse), initial=0.0)),
        estimated_error=_estimated_error(recorded, loose, scales, ratio_of_tolerances),
        taylor_steps=recorded.taylor_steps,
        implicit_steps=recorded.implicit_steps,
        defect=defect,
        failures=tuple(failures),
    )


def _defect(motion: Trajectory, scales: np.ndarray) -> float:
    """Largest h |y' - f(t, y)| over the natural size of a state, of all Taylor steps.

    Nine points of every step, and five more about the slowest of a finer grid: friction changes most near rest.
    """
    recording, parameters = equations(motion.system), parameter_values(motion.system)
    worst = 0.0
    taylor = np.flatnonzero(~motion.piece_implicit)
    fine = np.linspace(0.0, 1.0, FINE)
    for first in range(0, len(taylor), PIECES_AT_A_TIME):
        pieces = taylor[first : first + PIECES_AT_A_TIME]
        h = motion.piece_length[pieces]
        grid = (fine * h[:, None]).ravel()
        speed = np.abs(motion.piece_observables(("contact_velocity",), np.repeat(pieces, FINE), grid)[0])
        slowest = fine[np.argmin(speed.reshape(-1, FINE), axis=1)]
        near = slowest[:, None] + np.linspace(-1.0, 1.0, 5) / (FINE - 1.0)
        share = np.hstack(
            [np.broadcast_to(np.linspace(0.0, 1.0, POINTS), (len(pieces), POINTS)), np.clip(near, 0.0, 1.0)]
        )
        index, s = np.repeat(pieces, share.shape[1]), (share * h[:, None]).ravel()
        local = motion.piece_start[index] + s
        local = local - motion.period * np.floor(local / motion.period)
        rates = evaluate(recording.rates, local, motion.piece_states(index, s), motion.piece_side[index], parameters)
        slopes = motion.piece_slopes(index, s)
        for i, rate in enumerate(rates):
            worst = max(worst, float(np.max(np.abs(rate - slopes[i]) * motion.piece_length[index])) / scales[i])
    return worst


def _outer_impulse(motion: Trajectory) -> Any:
    """Integral of the force from outside, at the start of every piece and at the end; 0.0 where there is none."""
    if "outer_force" not in motion.observable_names:
        return 0.0
    whole = motion.piece_integrals(np.arange(len(motion.piece_start)), motion.piece_length, ("outer_force",))
    return np.append(0.0, np.cumsum(whole[0]))


def _estimated_error(
    recorded: Recorded, loose: Recorded, scales: np.ndarray, ratio_of_tolerances: float
) -> float | None:
    """Error of a run from a looser one, at the period marks that both reached, and at the end if both did."""
    count = min(len(recorded.sections), len(loose.sections))
    differences = list(recorded.sections[1:count] - loose.sections[1:count])
    if recorded.status == loose.status == memory.DONE:
        differences.append(recorded.final - loose.final)
    if not differences:
        return None
    return float(np.max(np.abs(differences) / scales)) / (ratio_of_tolerances - 1.0)


def _at_marks(values: np.ndarray) -> np.ndarray:
    """Of values at POINTS points per piece: those at the start of every piece, and at the end."""
    return np.append(values[::POINTS], values[-1])
