"""A friction law under an imposed motion: the force that answers a measured or prescribed velocity."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.laboratory.driven_equations import driven_equations
from vibrocap.laboratory.driven_input import imposed_motion, parameter_sets, start_states
from vibrocap.motion.trajectory import Status
from vibrocap.numerics.api import DrivenEquations, codes, driven_runs
from vibrocap.numerics.expressions.graph import evaluate
from vibrocap.physics.friction.law import Law

STATUSES = {
    codes.DONE: Status.FINISHED,
    codes.STEP_UNDERFLOW: Status.STEP_UNDERFLOW,
    codes.NOT_FINITE: Status.NOT_FINITE,
    codes.TOO_MANY_EVENTS: Status.TOO_MANY_EVENTS,
    codes.TOO_MANY_STEPS: Status.TOO_MANY_STEPS,
}


@dataclasses.dataclass(frozen=True, eq=False)
class Driven:
    """Response of a law to an imposed motion, sample by sample.

    force: [n], in the unit of load times coefficient; internal: [n, k] states of the law (k = 0 where it has none)
    status: `finished`, or why it could not be completed; force and states are NaN from there on
    """

    force: np.ndarray
    internal: np.ndarray
    status: Status


@dataclasses.dataclass(frozen=True, eq=False)
class DrivenSet:
    """Responses of a law with many parameter sets to one imposed motion.

    force: [m, n]; a row is NaN throughout where its run could not be completed; status: [m], how each run ended
    """

    force: np.ndarray
    status: tuple[Status, ...]

    @property
    def completed(self) -> np.ndarray:
        """[m] whether each run went to its end."""
        return np.array([status.ok for status in self.status])


def driven_force(
    law: Law,
    time: Any,
    velocity: Any,
    *,
    load: Any = 1.0,
    internal: Any = None,
    tolerance: float = 1e-8,
) -> Driven:
    """Friction force of a law whose contact is moved at a given velocity, which is linear between the samples.

    The internal states follow z' = f(v(t), z, N(t)) by an L-stable method under error control within every interval;
    an interval in which the velocity changes sign is cut there, and a switch of the law's pieces is located.

    time: [n], strictly increasing, even or not [1, or s]      velocity: [n] [1, or m/s]
    load: normal load N, a number or [n], linear between the samples; 1 for a law whose coefficients are forces in N
    internal: [k] states at the first sample, 0 by default
    tolerance: error per step over the natural size of a state

    At rest the force of a set-valued law is whatever balances the contact, which an imposed motion does not tell:
    given is the force of the side of the last motion at vanishing speed, and 0 before the first motion. The friction
    of the other laws at v = 0 is on the side of the last motion, or of the first where there was none yet.
    Raises ValueError for what is not such an input. A run that cannot be completed says so in `status`.
    """
    given = imposed_motion(law, time, velocity, load, tolerance)
    start = start_states(law, internal, 1)
    equations = driven_equations(law, ())
    parameters = np.array([_values(law, equations)])
    if not law.internal:
        force = _steady(equations, parameters, given)[0]
        ok = bool(np.isfinite(force).all())
        return Driven(force, np.empty((len(force), 0)), Status.FINISHED if ok else Status.NOT_FINITE)
    runs = driven_runs(equations, parameters, start, given, tolerance, threads=1, keep_internal=True)
    assert runs.internal is not None
    return Driven(runs.force[0], runs.internal[0], STATUSES[int(runs.status[0])])


def driven_forces(
    law: Law,
    values: Any,
    names: Sequence[str],
    time: Any,
    velocity: Any,
    *,
    load: Any = 1.0,
    internal: Any = None,
    tolerance: float = 1e-8,
    threads: int | None = None,
) -> DrivenSet:
    """`driven_force` for many parameter sets at once, as a fit asks for them; one kernel serves them all.

    values: [m, p] parameter sets; column j replaces the law's parameter names[j]. They are not checked against the
    bounds of the law: outside, a run may fail, which its status tells.      internal: [k] or [m, k]
    threads: how many share the work (by default all cores); the numbers do not depend on it.

    A parameter that chooses the formula when it is whole (`shape_parameters`) takes the general formula when it is one
    of `names`.
    """
    if threads is not None and (isinstance(threads, bool) or not isinstance(threads, int) or threads < 1):
        raise ValueError(f"threads should be a whole number >= 1, got {threads!r}")
    given = imposed_motion(law, time, velocity, load, tolerance)
    names = tuple(names)
    table = parameter_sets(law, values, names)
    start = start_states(law, internal, len(table))
    equations = driven_equations(law, names)
    parameters = np.tile(_values(law, equations), (len(table), 1))
    for j, name in enumerate(names):
        parameters[:, equations.parameter_names.index(name)] = table[:, j]
    if not law.internal:
        force = _steady(equations, parameters, given)
        status = tuple(Status.FINISHED if np.isfinite(row).all() else Status.NOT_FINITE for row in force)
    else:
        runs = driven_runs(equations, parameters, start, given, tolerance, threads)
        force, status = runs.force, tuple(STATUSES[int(code)] for code in runs.status)
    force[[not ended.ok for ended in status]] = np.nan
    return DrivenSet(force, status)


def _values(law: Law, equations: DrivenEquations) -> list[float]:
    return [float(getattr(law, name)) for name in equations.parameter_names]


def _steady(equations: DrivenEquations, parameters: np.ndarray, given: np.ndarray) -> np.ndarray:
    """Force [m, n] of a law without internal states."""
    _, velocity, load = given
    moving = velocity != 0.0
    last = np.maximum.accumulate(np.where(moving, np.arange(len(velocity)), -1))  # sample of the last motion
    side = np.sign(velocity[np.maximum(last, np.argmax(moving))]) if moving.any() else np.ones(len(velocity))
    with np.errstate(all="ignore"):
        (force,) = evaluate([equations.force], 0.0, [velocity, load, 0.0, 0.0], side, parameters.T[:, :, None])
    force = np.array(np.broadcast_to(force, (len(parameters), len(velocity))), dtype=float)
    if equations.set_valued:
        force[:, last < 0] = 0.0
    return force
